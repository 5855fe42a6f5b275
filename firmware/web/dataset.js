/* SPDX-License-Identifier: Apache-2.0 */
/* dataset.js: one dataset: its time to scrub through, charts, events, notes, how to take it home. */
import { h, fill, facts, renew, say } from "./dom.js";
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
  let ended = false, timer = 0, last = "", uuid, busy = false, wanted = false, news = false; /* something happened: with or without a slot */
  const head = h("div"), wrong = h("p", { class: "bad", role: "alert" }), time = h("section", { class: "card wide timeline" }), drawn = h("section", { class: "card wide" });
  const happenings = h("ul", { class: "notes" }, h("li", {}, "…"));
  const events = h("section", { class: "card" }, h("h2", {}, "Events"), h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Events, newest first" }, happenings)), people = h("section", { class: "card" }), home = h("section", { class: "card" }), deep = h("section", { class: "card wide" });
  const grown = h("section", { class: "card wide", hidden: true });
  fill(main, h("p", {}, h("a", { href: "#/data" }, "All datasets")), h("h1", {}, name), wrong,
    h("div", { class: "cards" }, time, grown, drawn, h("section", { class: "card" }, h("h2", {}, "What it holds"), head), home, people, events, deep));

  const written = notes(people, box, name), scrubber = timeline(time, name, written.slot), chart = charts(drawn);
  const looked = texture(deep, name);
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
      if (uuid && about.uuid !== uuid) { /* another one took its name: nothing that is seen here is of it */
        location.reload();
        return;
      }
      uuid = about.uuid;
      describe(about);
      const key = `${about.slots} ${about.sealed}`;
      if (key !== last) {
        const got = await columns(name, () => ended);
        if (ended)
          return;
        scrubber.show(got);
        chart.show(got);
        looked.show(got, about);
      }
      if (key !== last || news)
        await happened();
      last = key; /* what failed is asked for again */
      say(wrong, "");
    } catch (error) {
      if (!ended)
        say(wrong, error.text || error.message);
      news = true;
      wanted = error.status !== 404 && error.status !== 401;
    }
    busy = false;
    if (wanted && !ended)
      soon();
  }

  function describe(about) {
    const stream = about.streams?.find((s) => s.primary) || about.streams?.[0];
    renew(head, about, () => facts([
      about.title && ["Title", about.title],
      about.simulated && ["Made by", h("span", { class: "mark" }, "SIMULATED")],
      ["Slots", `${(about.slots || 0).toLocaleString()}: ${results(about.results)}`],
      stream && ["Pictures", `${stream.width} x ${stream.height} pixels, ${stream.quantity || "values"} in ${stream.colour_space || "camera"}`],
      ["State", about.sealed ? "sealed" : about.ended ? "ended, not sealed" : "growing, or to be gone on with"],
      about.digest && ["Digest", h("code", {}, about.digest)],
      ["uuid", h("code", {}, about.uuid || "?")],
    ]));
    renew(home, about.sealed, () => [h("h2", {}, "Take it home"),
      h("p", {}, h("a", { class: "button main", href: `/api/v1/datasets/${name}/tar`, download: `${name}.tar` }, "Download as a tar")),
      h("p", {}, "Or with the tool, which resumes, verifies every byte and follows a run:"),
      h("pre", { tabindex: 0, "aria-label": "Command" }, `ttfbox pull here --only ${name} --box ${location.origin}${about.sealed ? "" : " --follow"}`),
      h("p", { class: "quiet" }, "Over a network the box wants its token for that, too: in a file that only you can read, and ", h("code", {}, "--token-file FILE"), " behind the command."),
      !about.sealed && h("p", { class: "quiet" }, "It is not sealed: a download of now holds what is there now.")]);
  }

  async function happened() {
    news = false; /* what happens from here on is asked for by itself */
    const lines = (await getLines(name, "events", EVENTS_BYTES)).slice(-200).reverse();
    if (ended)
      return;
    renew(happenings, lines, () => (lines.length === 0 ? [h("li", {}, "Nothing out of the ordinary.")]
      : lines.map((e) => h("li", {}, h("small", {}, e.at_utc_ns ? when(e.at_utc_ns) : "time unknown", ` · ${e.kind}`), h("div", {}, e.text)))));
  }

  /* A page that nobody looks at for a week asks for nothing ("stale" comes when it is seen). */
  function soon() {
    timer ||= setTimeout(() => {
      timer = 0;
      if (!document.hidden)
        refresh();
    }, REFRESH_MS);
  }

  /* A stop, a door that opens: its line may be the last one, or come an hour before the next slot. */
  function soon_with_news() {
    news = true;
    soon();
  }

  const off = box.on({ slot: ({ detail }) => detail.dataset === name && soon(), event: ({ detail }) => detail.dataset === name && soon_with_news(), state: soon_with_news, stale: soon_with_news });
  refresh();
  return () => {
    ended = true;
    clearTimeout(timer);
    off();
    for (const end of [written.end, scrubber.end, looked.end, grown_view])
      end();
  };
}
