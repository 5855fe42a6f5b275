/* SPDX-License-Identifier: Apache-2.0 */
/* datasets.js: all datasets of this box. */
import { h, fill, renew, say } from "./dom.js";
import { get } from "./api.js";
import { results } from "./state.js";

const SLOT_MS = 5000;

export function datasets(main, box) {
  let ended = false, timer = 0;
  const cards = new Map(); /* by name: of one a slot comes, and the links of all others stay where they are */
  const none = h("p", {}, "There is none yet. A run makes one.");
  const list = h("div", { class: "cards" }, h("p", { role: "status" }, "…")), wrong = h("p", { class: "bad", role: "alert" });
  fill(main, h("h1", {}, "Datasets"), wrong, list);

  async function refresh() {
    try {
      const { datasets: all } = await get("datasets");
      if (ended)
        return;
      say(wrong, "");
      show(all);
    } catch (error) {
      if (!ended)
        say(wrong, error.text || error.message);
    }
  }

  function show(all) {
    for (const name of cards.keys())
      if (!all.some((d) => d.name === name))
        cards.delete(name);
    place(all.length ? all.map(card) : [none]);
  }

  /* What is there already is not moved: that would take the focus from it. */
  function place(wanted) {
    for (const e of [...list.children])
      if (!wanted.includes(e))
        e.remove();
    wanted.forEach((e, i) => list.children[i] !== e && list.insertBefore(e, list.children[i] ?? null));
  }

  function card(d) {
    if (!cards.has(d.name)) {
      const mark = h("span"), about = h("div", { class: "about" }), element = h("section", { class: "card" }, h("h2", {}, h("a", { href: `#/data/${d.name}` }, d.name), mark), about);
      cards.set(d.name, { element, mark, about });
    }
    const { element, mark, about } = cards.get(d.name);
    renew(mark, !!d.simulated, () => [d.simulated && [" ", h("span", { class: "mark" }, "SIMULATED")]]);
    renew(about, d, () => [d.title && h("p", {}, d.title),
      d.error ? h("p", { class: "bad" }, d.error) : [h("p", {}, `${(d.slots || 0).toLocaleString()} slots: ${results(d.results)}`),
        h("p", { class: "quiet" }, d.sealed ? "Sealed: nothing in it changes any more." : d.ended ? "Ended, not sealed." : "Growing, or to be gone on with.")]]);
    return element;
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
