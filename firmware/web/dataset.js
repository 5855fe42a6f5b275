/* SPDX-License-Identifier: Apache-2.0 */
/* dataset.js: one dataset: its time to scrub through, charts, events, notes, how to take it home. */
import { h, fill, facts } from "./dom.js";
import { get, getLines } from "./api.js";
import { results } from "./state.js";
import { when } from "./words.js";
import { timeline } from "./timeline.js";
import { charts } from "./charts.js";
import { notes } from "./notes.js";
import { texture } from "./texture.js";
import { preview } from "./preview.js";

const REFRESH_MS = 3000, EVENTS_BYTES = 65536;

/* The columns over all slots; a long dataset comes by parts. */
async function columns(name, unwanted) {
  for (;;) {
    const got = await get(`datasets/${name}/charts`);
    if (got.complete || unwanted())
      return got;
    await new Promise((go) => setTimeout(go, 200));
  }
}

export function dataset(main, box, name) {
  let ended = false, timer = 0, last = "", busy = false, wanted = false;
  const head = h("div"), wrong = h("p", { class: "bad", role: "alert" }), time = h("section", { class: "card wide timeline" }), drawn = h("section", { class: "card wide" });
  const events = h("section", { class: "card" }), people = h("section", { class: "card" }), home = h("section", { class: "card" }), deep = h("section", { class: "card wide" });
  const grown = h("section", { class: "card wide", hidden: true });
  fill(main, h("p", {}, h("a", { href: "#/data" }, "All datasets")), h("h1", {}, name), wrong,
    h("div", { class: "cards" }, time, grown, drawn, h("section", { class: "card" }, h("h2", {}, "What it holds"), head), home, people, events, deep));

  const scrubber = timeline(time, name), chart = charts(drawn);
  const looked = texture(deep, name);
  const leave_notes = notes(people, box, name, () => scrubber.slot());
  const grown_view = preview(grown, box, name);

  /* One at a time: an older answer would be shown over a newer one. */
  async function refresh() {
    if (busy) {
      wanted = true;
      return;
    }
    busy = true;
    wanted = false;
    try {
      const about = await get(`datasets/${name}`);
      if (ended)
        return;
      describe(about);
      const key = `${about.slots} ${about.sealed}`;
      if (key !== last) {
        const got = await columns(name, () => ended);
        if (ended)
          return;
        scrubber.show(got);
        chart.show(got);
        looked.show(got, about);
        await happened();
        last = key; /* what failed is asked for again */
      }
      wrong.textContent = "";
    } catch (error) {
      if (!ended)
        wrong.textContent = error.text || error.message;
      wanted = error.status !== 404 && error.status !== 401;
    }
    busy = false;
    if (wanted && !ended)
      soon();
  }

  function describe(about) {
    const stream = about.streams?.find((s) => s.primary) || about.streams?.[0];
    fill(head, facts([
      about.title && ["Title", about.title],
      about.simulated && ["Made by", h("span", { class: "mark" }, "SIMULATED")],
      ["Slots", `${(about.slots || 0).toLocaleString()}: ${results(about.results)}`],
      stream && ["Pictures", `${stream.width} x ${stream.height} pixels, ${stream.quantity || "values"} in ${stream.colour_space || "camera"}`],
      ["State", about.sealed ? "sealed" : about.ended ? "ended, not sealed" : "growing, or to be gone on with"],
      about.digest && ["Digest", h("code", {}, about.digest)],
      ["uuid", h("code", {}, about.uuid || "?")],
    ]));
    fill(home, h("h2", {}, "Take it home"),
      h("p", {}, h("a", { class: "button main", href: `/api/v1/datasets/${name}/tar`, download: `${name}.tar` }, "Download as a tar")),
      h("p", {}, "Or with the tool, which resumes, verifies every byte and follows a run:"),
      h("pre", { tabindex: 0, "aria-label": "Command" }, `ttfbox pull here --only ${name} --box ${location.origin}${about.sealed ? "" : " --follow"}`),
      h("p", { class: "quiet" }, "Over a network the box wants its token for that, too: in a file that only you can read, and ", h("code", {}, "--token-file FILE"), " behind the command."),
      !about.sealed && h("p", { class: "quiet" }, "It is not sealed: a download of now holds what is there now."));
  }

  async function happened() {
    const lines = (await getLines(name, "events", EVENTS_BYTES)).slice(-200).reverse();
    if (ended)
      return;
    fill(events, h("h2", {}, "Events"), lines.length === 0 ? h("p", {}, "Nothing out of the ordinary.")
      : h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Events, newest first" }, h("ul", { class: "notes" },
        lines.map((e) => h("li", {}, h("small", {}, e.at_utc_ns ? when(e.at_utc_ns) : "time unknown", ` · ${e.kind}`), h("div", {}, e.text))))));
  }

  function soon() {
    timer ||= setTimeout(() => {
      timer = 0;
      refresh();
    }, REFRESH_MS);
  }

  const slot = ({ detail }) => detail.dataset === name && soon(), state = () => soon();
  box.addEventListener("slot", slot);
  box.addEventListener("state", state);
  refresh();
  return () => {
    ended = true;
    clearTimeout(timer);
    box.removeEventListener("slot", slot);
    box.removeEventListener("state", state);
    for (const end of [leave_notes, scrubber.end, looked.end, grown_view])
      end?.();
  };
}
