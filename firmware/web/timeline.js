/* SPDX-License-Identifier: Apache-2.0 */
/* timeline.js: a strip of small pictures and a slider over all slots. */
import { h, fill, say } from "./dom.js";
import { when } from "./words.js";

const STRIP = 10;

/* Of each point, whether it has a picture. */
export function pictured({ index, results }) {
  return index.map((_, i) => (results.captured?.[i] || 0) + (results.partial?.[i] || 0) > 0);
}

export function timeline(parent, name) {
  let index = [], due = [], has = [], ended = false, asked = 0, retry = 0;
  const img = h("img", { alt: "", hidden: true }), none = h("p", {}, "No picture yet"), caption = h("figcaption", { "aria-live": "polite" });
  const slider = h("input", { type: "range", class: "scrub", min: 0, max: 0, value: 0, step: 1, "aria-label": "Slot", oninput: () => pick(Number(slider.value)) });
  const strip = h("div", { class: "strip", role: "group", "aria-label": "Pictures spread over the whole time" });
  const play = h("button", { "aria-pressed": "false", onclick: toggle }, "Play"), full = h("a", {}, "");
  fill(parent, h("h2", {}, "Timeline"), strip, h("div", { class: "row" }, play, h("label", { class: "visually-hidden", for: "scrub" }, "Slot"), slider),
    h("figure", {}, h("div", { class: "picture" }, img, none), caption), full);
  slider.id = "scrub";
  img.addEventListener("error", () => { /* too many wait, or there is no picture of this slot */
    img.hidden = true;
    none.hidden = false;
    say(none, "No picture of this slot");
    if (retry++ < 3)
      setTimeout(() => !ended && index.length && src(Number(slider.value)), 1100);
  });
  img.addEventListener("load", () => {
    img.hidden = false;
    none.hidden = true;
    retry = 0;
  });

  const address = (i) => `/api/v1/datasets/${name}/thumbs/${index[i]}`;

  function src(i) {
    if (has[i]) {
      img.src = address(i);
    } else {
      img.hidden = true;
      none.hidden = false;
      say(none, "This slot has no picture");
    }
  }

  function pick(i) {
    const text = `Slot ${index[i].toLocaleString()}${has[i] ? "" : ", without a picture"}${due[i] ? `, ${when(due[i])}` : ""}`;
    slider.value = i;
    slider.setAttribute("aria-valuetext", text);
    say(caption, text);
    img.alt = text;
    retry = 0;
    /* One picture at a time: a slider that flies asks only for where it stops. */
    asked ||= requestAnimationFrame(() => {
      asked = 0;
      src(Number(slider.value));
    });
    for (const b of strip.children)
      b.setAttribute("aria-current", String(Number(b.dataset.at) === i));
  }

  let timer = 0;
  function toggle() {
    const on = play.getAttribute("aria-pressed") !== "true";
    play.setAttribute("aria-pressed", String(on));
    play.textContent = on ? "Pause" : "Play";
    clearInterval(timer);
    if (on)
      timer = setInterval(() => img.complete && pick((Number(slider.value) + 1) % index.length), 150);
  }

  return {
    slot: () => index[Number(slider.value)],
    show(columns) {
      const at_end = Number(slider.value) >= index.length - 1, grew = columns.index.length !== index.length;
      ({ index, due_utc_ns: due } = columns);
      has = pictured(columns);
      slider.max = Math.max(0, index.length - 1);
      slider.disabled = play.disabled = index.length < 2;
      if (!index.length || !grew)
        return;
      const seen = index.map((_, i) => i).filter((i) => has[i]), n = Math.min(STRIP, seen.length);
      fill(strip, Array.from({ length: n }, (_, k) => seen[n > 1 ? Math.round(k * (seen.length - 1) / (n - 1)) : 0]).map((i) =>
        h("button", { type: "button", "data-at": i, "aria-label": `Slot ${index[i]}`, onclick: () => pick(i) },
          h("img", { src: address(i), alt: "", loading: "lazy" }), h("small", { "aria-hidden": "true" }, index[i]))));
      pick(at_end ? index.length - 1 : Number(slider.value));
    },
    end() {
      ended = true;
      clearInterval(timer);
      cancelAnimationFrame(asked);
    },
  };
}
