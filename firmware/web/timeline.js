/* SPDX-License-Identifier: Apache-2.0 */
/*
 * timeline.js: a strip of small pictures and a slider over all slots. What is known of them comes in points, of a long
 * dataset each of so many slots (charts): the slider has every slot all the same.
 */
import { h, fill, say } from "./dom.js";
import { player } from "./play.js";
import { when } from "./words.js";

const STRIP = 10, PLAY_MS = 150, AGAIN_MS = 1100;

/* Of each point that has a picture, the slot of its first one. */
export function pictured({ pictured: slots }) {
  return slots.filter((slot) => slot !== null);
}

/* At most `n` of them, evenly taken, first and last among them. */
export function spread(all, n) {
  const few = Math.min(n, all.length);
  return Array.from({ length: few }, (_, k) => all[few > 1 ? Math.round(k * (all.length - 1) / (few - 1)) : 0]);
}

/* What the columns say of one slot: {due_utc_ns, exact: of this very slot, picture: true, false, undefined: not known}. */
export function slotOf({ index, due_utc_ns: due, results }, slot) {
  const i = index.findLastIndex((first) => first <= slot), slots = Object.values(results).reduce((sum, column) => sum + column[i], 0);
  const have = (results.captured?.[i] || 0) + (results.partial?.[i] || 0), apart = due[i + 1] ? (due[i + 1] - due[i]) / (index[i + 1] - index[i]) : due[i - 1] ? (due[i] - due[i - 1]) / (index[i] - index[i - 1]) : 0;
  return { due_utc_ns: due[i] && due[i] + (slot - index[i]) * apart, exact: slot === index[i], picture: have === 0 ? false : have === slots ? true : undefined };
}

/* The last slot of all; -1: there is none. */
export function lastSlot({ index, results }) {
  return index.length ? index.at(-1) + Object.values(results).reduce((sum, column) => sum + column.at(-1), 0) - 1 : -1;
}

/* `moved(slot, by_person)`: another slot is shown. */
export function timeline(parent, name, moved) {
  let columns = null, newest = -1, ended = false, asked = 0, retry = 0, following = true; /* the newest slot, until somebody wants another */
  const img = h("img", { alt: "", hidden: true }), none = h("p", {}, "No picture yet"), caption = h("figcaption"), play = player(onward, PLAY_MS, caption);
  const slider = h("input", { type: "range", class: "scrub", min: 0, max: 0, value: 0, step: 1, "aria-label": "Slot", disabled: true, oninput: () => pick(Number(slider.value), true) });
  const strip = h("div", { class: "strip", role: "group", "aria-label": "Pictures spread over the whole time" });
  play.button.disabled = true;
  fill(parent, h("h2", {}, "Timeline"), strip, h("div", { class: "row" }, play.button, slider),
    h("figure", {}, h("div", { class: "picture" }, img, none), caption));
  img.addEventListener("error", () => { /* too many wait, or there is no picture of this slot */
    empty("No picture of this slot");
    if (retry++ < 3)
      setTimeout(() => !ended && source(Number(slider.value)), AGAIN_MS);
  });
  img.addEventListener("load", () => {
    img.hidden = false;
    none.hidden = true;
    retry = 0;
  });

  const address = (slot) => `/api/v1/datasets/${name}/thumbs/${slot}`;

  function empty(text) {
    img.hidden = true;
    none.hidden = false;
    say(none, text);
  }

  function source(slot) {
    if (slotOf(columns, slot).picture !== false)
      img.src = address(slot);
    else
      empty("This slot has no picture");
  }

  function pick(slot, by_person) {
    const about = slotOf(columns, slot);
    const text = `Slot ${slot.toLocaleString()}${about.picture === false ? ", without a picture" : ""}${about.due_utc_ns ? `, ${about.exact ? "" : "about "}${when(about.due_utc_ns)}` : ""}`;
    if (by_person)
      following = slot === Number(slider.max);
    slider.value = slot;
    slider.setAttribute("aria-valuetext", text);
    say(caption, text);
    img.alt = text;
    retry = 0;
    /* One picture at a time: a slider that flies asks only for where it stops. */
    asked ||= requestAnimationFrame(() => {
      asked = 0;
      source(Number(slider.value));
    });
    mark();
    moved(slot, by_person);
  }

  function mark() {
    for (const b of strip.children)
      b.setAttribute("aria-current", String(b.dataset.at === slider.value));
  }

  /* From point to point: of ten thousand slots some hundreds. */
  function onward() {
    if (!img.complete)
      return;
    const all = pictured(columns), at = Number(slider.value);
    if (!all.length)
      return;
    const next = all.find((slot) => slot > at) ?? all[0];
    following = next === Number(slider.max);
    pick(next, false); /* nobody chose it */
  }

  /* Buttons stay: somebody may be at one of them. */
  function draw_strip() {
    const slots = spread(pictured(columns), STRIP);
    while (strip.children.length > slots.length)
      strip.lastChild.remove();
    while (strip.children.length < slots.length) {
      const b = h("button", { type: "button", onclick: () => pick(Number(b.dataset.at), true) }, h("img", { alt: "", loading: "lazy" }), h("small", { "aria-hidden": "true" }));
      strip.append(b);
    }
    slots.forEach((slot, k) => {
      const b = strip.children[k];
      if (b.dataset.at === String(slot))
        return;
      b.dataset.at = slot;
      b.setAttribute("aria-label", `Slot ${slot}`);
      b.firstChild.src = address(slot);
      say(b.lastChild, String(slot));
    });
    mark();
  }

  return {
    show(got) {
      const last = lastSlot(got), grew = last !== newest;
      columns = got;
      newest = last;
      slider.disabled = play.button.disabled = got.index.length === 0 || last === got.index[0];
      if (last < 0)
        return;
      slider.min = got.index[0];
      slider.max = last;
      draw_strip();
      if (grew && following)
        pick(last, false);
    },
    end() {
      ended = true;
      play.end();
      cancelAnimationFrame(asked);
    },
  };
}
