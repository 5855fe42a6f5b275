/* SPDX-License-Identifier: Apache-2.0 */
/* preview.js: what the box synthesized so far, beside what was captured, moment by moment. Nothing where there is no preview. */
import { h, fill, renew, say } from "./dom.js";
import { get } from "./api.js";
import { player } from "./play.js";
import { spread } from "./timeline.js";
import { count, when } from "./words.js";

const STRIP = 10, PLAY_MS = 160;

/* Which of the frames is of this slot, or of the one next to it. */
export function nearest(frames, slot) {
  return frames.reduce((best, frame, i) => (Math.abs(frame.slot - slot) < Math.abs(frames[best].slot - slot) ? i : best), 0);
}

export function preview(parent, box, name) {
  let ended = false, frames = [];
  const captured = h("img", { alt: "" }), grown = h("img", { alt: "" }), caption = h("p", { class: "quiet" }), about = h("p", { class: "quiet" });
  const slider = h("input", { type: "range", class: "scrub", min: 0, max: 0, step: 1, value: 0, "aria-label": "Moment of the preview", oninput: show });
  const strip = h("div", { class: "strip", role: "group", "aria-label": "Moments over the whole time: captured above, synthesized below" });
  const video = h("a", { class: "button", href: `/api/v1/datasets/${name}/preview.avi`, download: `${name}-preview.avi` }, "Download the preview as a video");
  const play = player(onward, PLAY_MS, caption);
  const pictures = h("div", { class: "stack", hidden: true }, h("div", { class: "big" },
    h("figure", {}, h("div", { class: "picture" }, captured), h("figcaption", {}, "Captured")),
    h("figure", {}, h("div", { class: "picture" }, grown), h("figcaption", {}, "Synthesized from it"))),
  h("div", { class: "row" }, play.button, slider), caption, strip, h("p", {}, video));
  fill(parent, h("h2", {}, "Preview of a synthesis"), pictures, about);

  function show() {
    const frame = frames[Number(slider.value)];
    captured.src = `/api/v1/datasets/${name}/thumbs/${frame.slot}`;
    grown.src = `/api/v1/datasets/${name}/preview/${frame.path}`;
    captured.alt = `Captured, slot ${frame.slot}`;
    grown.alt = `Synthesized, as at slot ${frame.slot}`;
    slider.setAttribute("aria-valuetext", `slot ${frame.slot}`);
    say(caption, `Slot ${frame.slot}`);
    for (const b of strip.children)
      b.setAttribute("aria-current", String(b.dataset.at === slider.value));
  }

  /* The whole time at a glance: what was captured, and below each of it what was made of it. */
  function draw_strip() {
    renew(strip, frames, () => spread([...frames.keys()], STRIP).map((i) =>
      h("button", { type: "button", "data-at": i, "aria-label": `Slot ${frames[i].slot}`, onclick: () => { slider.value = i; show(); } },
        h("img", { src: `/api/v1/datasets/${name}/thumbs/${frames[i].slot}`, alt: "", loading: "lazy" }),
        h("img", { src: `/api/v1/datasets/${name}/preview/${frames[i].path}`, alt: "", loading: "lazy" }), h("small", { "aria-hidden": "true" }, frames[i].slot))));
  }

  function onward() {
    if (!captured.complete || !grown.complete || !frames.length)
      return;
    slider.value = (Number(slider.value) + 1) % frames.length;
    show();
  }

  async function refresh() {
    let state;
    try {
      state = await get(`datasets/${name}/preview`);
    } catch {
      return; /* no preview is offered here */
    }
    if (ended)
      return;
    const seen = frames[Number(slider.value)], newest = seen === frames.at(-1); /* at first: both none */
    frames = state.frames || [];
    parent.hidden = frames.length === 0 && state.state !== "failed";
    if (state.state === "failed")
      say(about, state.tried_images === 0 ? `There is none: ${state.why}.` : `The last try failed: ${state.why}. It is tried again when there are more pictures.`);
    else if (frames.length)
      say(about, `From ${count(state.images, "picture")}, ${state.width} x ${state.height} pixels, each standing for ${state.shrunk_by} x ${state.shrunk_by} of the captured ones; made ${when(state.made_utc_ns)}.`);
    pictures.hidden = !frames.length;
    if (!frames.length)
      return;
    slider.max = frames.length - 1;
    slider.value = newest ? frames.length - 1 : nearest(frames, seen.slot); /* who looks at one moment goes on looking at it */
    draw_strip();
    show();
  }

  const newer = ({ detail }) => detail.dataset === name && refresh();
  const off = box.on({ preview: newer, stale: refresh });
  refresh();
  return () => {
    ended = true;
    play.end();
    off();
  };
}
