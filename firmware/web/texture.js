/* SPDX-License-Identifier: Apache-2.0 */
/*
 * texture.js: the dataset as a time-varying texture: on a plane or a sphere, with time, exposure, and the
 * life of a pixel; where there is a preview of its synthesis, beside that. The scripts of `ttfbox view` (firmware/view/page), fed with small pictures.
 */
import { h, fill, say } from "./dom.js";
import { get } from "./api.js";
import { pictured, spread } from "./timeline.js";

const FRAMES = 96;

const slot_text = (v) => `${v} slots`;

export function texture(parent, name) {
  let columns = null, about = null, panels = [], ended = false, frames = [], known = true;
  const said = h("p", { role: "status" }), place = h("div", { class: "big" }), tools = h("div", { class: "stack", hidden: true });
  const load = h("button", { onclick: begin, disabled: true }, "Load the texture");
  const time = h("input", { type: "range", class: "scrub", min: 0, value: 0, step: 1, "aria-label": "Time", oninput: show });
  const exposure = h("input", { type: "range", min: -4, max: 4, step: 0.25, value: 0, "aria-label": "Exposure in stops", oninput: show });
  const shape = h("select", { onchange: show }, h("option", { value: "plane" }, "plane"), h("option", { value: "sphere" }, "sphere"));
  const when = h("output", {}), stops = h("output", {});
  tools.append(h("div", { class: "row" }, h("label", {}, "Time", time), when), h("div", { class: "row" }, h("label", {}, "Exposure", exposure), stops, h("label", {}, "On a", shape)));
  fill(parent, h("h2", {}, "As a texture"),
    h("p", { class: "quiet" }, `Up to ${FRAMES} slots as small pictures: time and exposure, on a plane or a sphere; a click on a pixel plots its life. Where there is a preview of the synthesis, it is shown beside.`),
    h("div", { class: "row" }, load, said), tools, place,
    h("details", {}, h("summary", {}, "In full, as one file to keep"),
      h("p", {}, "The box makes small pictures alone: whole frames, hundreds of them, would take the disk and the memory that a run needs. A PC makes the file (up to 30 MB, opened by any browser, without a network) from the dataset that was taken home; with ", h("code", {}, "--beside"), " and what was synthesized from it, both:"),
      h("pre", { tabindex: 0, "aria-label": "Commands" }, `ttfbox pull here --only ${name} --box ${location.origin}\nttfbox view here/${name} -o ${name}.html`)));

  async function picture(path) {
    for (let tries = 0; ; tries++) {
      const answer = await fetch(`/api/v1/datasets/${name}/${path}`, { credentials: "same-origin" });
      if (answer.status === 204 || answer.status === 404)
        return null;
      if (answer.ok)
        return answer.blob();
      if (answer.status !== 503 || tries > 20)
        throw new Error(`the box answered ${answer.status}`);
      await new Promise((go) => setTimeout(go, 1000));
    }
  }

  /* Of a synthesis of which there is a preview, its frames; else none. */
  async function synthesized() {
    try {
      return (await get(`datasets/${name}/preview`)).frames || [];
    } catch {
      return []; /* none is offered here */
    }
  }

  function time_of(slot) {
    const i = columns.index.findLastIndex((first) => first <= slot); /* the point that the slot is part of */
    return known && i >= 0 ? (columns.due_utc_ns[i] - columns.due_utc_ns[0]) / 1e9 : slot;
  }

  /* [{slot, time_s, blob, grown}]; grown: of a preview */
  async function fetch_all() {
    const grown = await synthesized(), moments = grown.length ? grown : spread(pictured(columns), FRAMES).map((slot) => ({ slot })), got = [];
    for (const { slot, path } of moments) {
      const blob = await picture(`thumbs/${slot}`), beside = blob && path ? await picture(`preview/${path}`) : null;
      if (ended)
        return [];
      if (blob && (beside || !path))
        got.push({ blob, grown: beside, slot, time_s: time_of(slot) });
      say(said, `${got.length} of ${moments.length}`);
    }
    if (!got.length)
      throw new Error("there is no picture yet");
    return got;
  }

  async function make_panel(role, title, blobs) {
    const size = await createImageBitmap(blobs[0]);
    const made = new globalThis.ttfPanel.Panel(place, { role, title, quantity: "value", camera_colours: false, text: known ? undefined : slot_text,
      width: size.width, height: size.height, black: 0, white: 1, slots: frames.map((f) => f.slot), times_s: frames.map((f) => f.time_s) }, panels.length, () => {});
    panels.push(made);
    for (const [k, blob] of blobs.entries()) {
      if (ended)
        return size;
      await made.surface.load(k, blob);
    }
    made.loaded();
    return size;
  }

  /* What the graphics card holds for them is given back: it lends to sixteen at a time. */
  function clear() {
    panels.forEach((panel) => panel.end());
    panels = [];
    place.replaceChildren();
  }

  async function begin() {
    load.disabled = true;
    try {
      known = columns.due_utc_ns.every((t) => t !== null);
      const got = await fetch_all();
      if (ended)
        return;
      frames = got;
      clear();
      const note = "8-bit sRGB, so values are near, not exact", both = got.every((f) => f.grown);
      const size = await make_panel(both ? "captured" : "small pictures", note, got.map((f) => f.blob));
      if (both && !ended)
        await make_panel("synthesized from it", note, got.map((f) => f.grown));
      time.max = got.length - 1;
      tools.hidden = false;
      shape.parentElement.hidden = !panels.every((p) => p.surface.shapes.includes("sphere"));
      say(said, `${got.length} slots of ${columns.slots}, ${size.width} x ${size.height} pixels of ${about?.streams?.[0]?.width ?? "?"} x ${about?.streams?.[0]?.height ?? "?"}`);
      load.textContent = "Load it again";
      show();
    } catch (error) {
      say(said, error.message);
    }
    load.disabled = false;
  }

  function show() {
    const k = Number(time.value), ev = Number(exposure.value);
    for (const panel of panels)
      panel.show(k, ev, shape.value);
    say(when, `${known ? `${globalThis.ttfPlot.timeText(frames[k].time_s)}, ` : ""}slot ${frames[k].slot}`);
    time.setAttribute("aria-valuetext", when.textContent);
    say(stops, `${ev > 0 ? "+" : ""}${ev} stops`);
  }

  return {
    show(got, of) {
      columns = got;
      about = of;
      load.disabled = got.index.length === 0;
    },
    end() {
      ended = true;
      clear();
    },
  };
}
