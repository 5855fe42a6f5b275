/* SPDX-License-Identifier: Apache-2.0 */
/* datasets.js: all datasets of this box. */
import { h, fill, renew, say } from "./dom.js";
import { get } from "./api.js";
import { results } from "./state.js";

const SLOT_MS = 5000;

export function datasets(main, box) {
  let ended = false, timer = 0;
  const list = h("div", { class: "cards" }, h("p", { role: "status" }, "…")), wrong = h("p", { class: "bad", role: "alert" });
  fill(main, h("h1", {}, "Datasets"), wrong, list);

  async function refresh() {
    try {
      const { datasets: all } = await get("datasets");
      if (ended)
        return;
      say(wrong, "");
      renew(list, all, () => (all.length ? all.map((d) => h("section", { class: "card" },
        h("h2", {}, h("a", { href: `#/data/${d.name}` }, d.name), d.simulated && [" ", h("span", { class: "mark" }, "SIMULATED")]),
        d.title && h("p", {}, d.title),
        d.error ? h("p", { class: "bad" }, d.error) : [h("p", {}, `${(d.slots || 0).toLocaleString()} slots: ${results(d.results)}`),
          h("p", { class: "quiet" }, d.sealed ? "Sealed: nothing in it changes any more." : d.ended ? "Ended, not sealed." : "Growing, or to be gone on with.")]))
        : [h("p", {}, "There is none yet. A run makes one.")]));
    } catch (error) {
      if (!ended)
        say(wrong, error.text || error.message);
    }
  }

  /* Slots may come several times a second; the list need not. */
  function later() {
    timer ||= setTimeout(() => {
      timer = 0;
      if (!document.hidden)
        refresh();
    }, SLOT_MS);
  }

  const off = box.on({ state: refresh, stale: refresh, slot: later });
  refresh();
  return () => {
    ended = true;
    clearTimeout(timer);
    off();
  };
}
