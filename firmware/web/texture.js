/* SPDX-License-Identifier: Apache-2.0 */
/*
 * texture.js: the dataset as a time-varying texture: on a plane or a sphere, with time, exposure, and the
 * life of a pixel. The scripts of `ttfbox view` (firmware/view/page), fed with small pictures of slots.
 */
import { h, fill, say } from "./dom.js";
import { pictured } from "./timeline.js";

const FRAMES = 96;

const slot_text = (v) => `${v} slots`;

export function texture(parent, name) {
  let columns = null, about = null, panel = null, ended = false, frames = [], known = true;
  const said = h("p", { role: "status" }), place = h("div"), tools = h("div", { class: "stack", hidden: true });
  const load = h("button", { onclick: begin, disabled: true }, "Load the texture");
  const time = h("input", { type: "range", class: "scrub", min: 0, value: 0, step: 1, "aria-label": "Time", oninput: show });
  const exposure = h("input", { type: "range", min: -4, max: 4, step: 0.25, value: 0, "aria-label": "Exposure in stops", oninput: show });
  const shape = h("select", { onchange: show }, h("option", { value: "plane" }, "plane"), h("option", { value: "sphere" }, "sphere"));
  const when = h("output", {}), stops = h("output", {});
  tools.append(h("div", { class: "row" }, h("label", {}, "Time", time), when), h("div", { class: "row" }, h("label", {}, "Exposure", exposure), stops, h("label", {}, "On a", shape)));
  fill(parent, h("h2", {}, "As a texture"),
    h("p", { class: "quiet" }, `Up to ${FRAMES} slots as small pictures: time and exposure, on a plane or a sphere; a click on a pixel plots its life. In full, as a file to keep: `, h("code", {}, `ttfbox view ${name} -o ${name}.html`)),
    h("div", { class: "row" }, load, said), tools, place);

  async function picture(index) {
    for (let tries = 0; ; tries++) {
      const answer = await fetch(`/api/v1/datasets/${name}/thumbs/${index}`, { credentials: "same-origin" });
      if (answer.ok)
        return answer.blob();
      if (answer.status === 404)
        return null;
      if (answer.status !== 503 || tries > 20)
        throw new Error(`the box answered ${answer.status}`);
      await new Promise((go) => setTimeout(go, 1000));
    }
  }

  async function begin() {
    load.disabled = true;
    try {
      known = columns.due_utc_ns.every((t) => t !== null);
      const has = pictured(columns), seen = columns.index.map((_, i) => i).filter((i) => has[i]);
      const n = Math.min(FRAMES, seen.length), t0 = columns.due_utc_ns[0];
      const chosen = Array.from({ length: n }, (_, k) => seen[n > 1 ? Math.round(k * (seen.length - 1) / (n - 1)) : 0]);
      const got = [];
      for (const i of chosen) {
        const blob = await picture(columns.index[i]);
        if (ended)
          return;
        if (blob)
          got.push({ blob, slot: columns.index[i], time_s: known ? (columns.due_utc_ns[i] - t0) / 1e9 : columns.index[i] });
        say(said, `${got.length} of ${n}`);
      }
      if (!got.length)
        throw new Error("there is no picture yet");
      const size = await createImageBitmap(got[0].blob);
      frames = got;
      place.replaceChildren();
      panel = new globalThis.ttfPanel.Panel(place, { role: "small pictures", title: "8-bit sRGB, so values are near, not exact", quantity: "value", camera_colours: false, text: known ? undefined : slot_text,
        width: size.width, height: size.height, black: 0, white: 1, slots: got.map((f) => f.slot), times_s: got.map((f) => f.time_s) }, 0, () => {});
      for (const [k, f] of got.entries())
        await panel.surface.load(k, f.blob);
      panel.loaded();
      time.max = got.length - 1;
      tools.hidden = false;
      shape.parentElement.hidden = !panel.surface.shapes.includes("sphere");
      say(said, `${got.length} slots of ${columns.index.length}, ${size.width} x ${size.height} pixels of ${about?.streams?.[0]?.width ?? "?"} x ${about?.streams?.[0]?.height ?? "?"}`);
      load.textContent = "Load it again";
      show();
    } catch (error) {
      say(said, error.message);
    }
    load.disabled = false;
  }

  function show() {
    const k = Number(time.value), ev = Number(exposure.value);
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
    },
  };
}
