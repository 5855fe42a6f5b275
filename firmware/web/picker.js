/* SPDX-License-Identifier: Apache-2.0 */
/*
 * picker.js: a rectangle and four corners over a picture, in the camera's pixels: by pointer, by arrow
 * keys, by numbers. What was picked stays with this browser, for the plan and the calibration.
 */
import { h, fill } from "./dom.js";

const NS = "http://www.w3.org/2000/svg";
const CORNERS = ["top left", "top right", "bottom right", "bottom left"];
const KEPT = "picked";

/* {region: {x, y, width, height} or null, reference: the same, corners: [{x, y}, ...]}, of a camera of `width` x `height` */
export function picked() {
  try {
    return { region: null, reference: null, corners: [], ...JSON.parse(sessionStorage.getItem(KEPT) || "{}") };
  } catch {
    return { region: null, reference: null, corners: [] };
  }
}

export function keep(what) {
  try {
    sessionStorage.setItem(KEPT, JSON.stringify({ ...picked(), ...what }));
  } catch { /* it is kept no longer than the page */ }
}

function shape(parent, name, attributes) {
  const e = document.createElementNS(NS, name);
  for (const [key, value] of Object.entries(attributes))
    e.setAttribute(key, value);
  parent.append(e);
  return e;
}

export class Picker {
  /* `overlay`: the SVG over the picture; `form`: where numbers go; camera: {name, width, height}. */
  constructor(overlay, form, camera) {
    Object.assign(this, { overlay, form, mode: null, ...picked() });
    overlay.setAttribute("preserveAspectRatio", "none");
    overlay.addEventListener("pointerdown", (e) => this.down(e));
    overlay.addEventListener("pointermove", (e) => this.moved(e));
    for (const end of ["pointerup", "pointercancel"])
      overlay.addEventListener(end, () => (this.from = null));
    this.build();
    this.size(camera);
    new ResizeObserver(() => this.draw()).observe(overlay); /* marks are as large on a screen that was turned */
  }

  /* Of which camera the picture is. */
  size({ name, width, height }) {
    Object.assign(this, { of: name, width, height });
    this.overlay.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.draw();
  }

  at(e) {
    const box = this.overlay.getBoundingClientRect(), clamp = (v, most) => Math.max(0, Math.min(most, Math.round(v)));
    return { x: clamp((e.clientX - box.left) / box.width * this.width, this.width), y: clamp((e.clientY - box.top) / box.height * this.height, this.height) };
  }

  down(e) {
    if (!this.mode)
      return;
    e.preventDefault();
    this.overlay.setPointerCapture(e.pointerId);
    const p = this.at(e);
    if (this.mode === "corners") {
      if (this.corners.length >= 4)
        this.corners = [];
      this.corners.push(p);
      this.changed();
      if (this.corners.length === 4) { /* one click too many does not take them away */
        this.choose("corners");
        this.hint.textContent = "All four corners are marked.";
      }
    } else {
      this.from = p;
    }
  }

  moved(e) {
    if (!this.from || this.mode === "corners")
      return;
    const p = this.at(e), x = Math.min(p.x, this.from.x, this.width - 2), y = Math.min(p.y, this.from.y, this.height - 2);
    this[this.mode] = { x, y, width: Math.max(2, Math.abs(p.x - this.from.x)), height: Math.max(2, Math.abs(p.y - this.from.y)) };
    this.changed();
  }

  changed() {
    keep({ region: this.region, reference: this.reference, corners: this.corners });
    this.draw();
    this.numbers();
  }

  draw() {
    this.overlay.replaceChildren();
    for (const rect of [this.region, this.reference].filter(Boolean))
      for (const style of ["region under", "region"])
        shape(this.overlay, "rect", { ...rect, class: style });
    const r = Math.max(Math.max(this.width, this.height) / 90, 7 * this.width / (this.overlay.clientWidth || this.width)); /* on a phone, too, numbers can be read */
    this.corners.forEach((p, i) => {
      for (const style of ["corner under", "corner"])
        shape(this.overlay, "path", { class: style, d: `M${p.x - r} ${p.y}h${2 * r}M${p.x} ${p.y - r}v${2 * r}` });
      const right = i === 1 || i === 2, below = i >= 2; /* within the chart: outside of it the picture may end */
      const text = shape(this.overlay, "text", { x: p.x + (right ? -r : r), y: p.y + (below ? -0.6 * r : 2.4 * r), "text-anchor": right ? "end" : "start", fill: "#fff", stroke: "#000", "stroke-width": r / 2, "paint-order": "stroke", "font-size": 2.4 * r, "font-weight": 700 });
      text.textContent = i + 1;
    });
    const what = [this.region && "the region", this.reference && "the reference patch", this.corners.length && `${this.corners.length} corners`].filter(Boolean);
    this.overlay.setAttribute("aria-label", what.length ? `Over the picture: ${what.join(", ")}` : "Nothing is marked in the picture");
  }

  /* ---- by numbers ---- */

  build() {
    const mode = (name, text) => h("button", { type: "button", "aria-pressed": "false", "data-mode": name, onclick: () => this.choose(name) }, text);
    this.fields = {};
    const rect = (what, title) => h("fieldset", {}, h("legend", {}, title), h("div", { class: "fields" },
      ["x", "y", "width", "height"].map((key) => this.number(`${what}.${key}`, key, (value) => {
        this[what] = { x: 0, y: 0, width: this.width, height: this.height, ...this[what], [key]: value };
      })), h("button", { type: "button", onclick: () => { this[what] = null; this.changed(); } }, "Clear")));
    fill(this.form,
      h("div", { class: "row" }, mode("region", "Draw the region"), mode("reference", "Draw the reference patch"), mode("corners", "Mark the chart's corners")),
      this.hint = h("p", { class: "quiet", role: "status" }, "Draw in the picture, or type numbers, in the camera's pixels."),
      h("details", {}, h("summary", {}, "Numbers"),
        rect("region", "Region: what is kept of each frame"), rect("reference", "Reference: a grey patch within it whose level is watched"),
        h("fieldset", {}, h("legend", {}, "Corners of the colour chart"), h("div", { class: "fields" },
          CORNERS.map((name, i) => ["x", "y"].map((key) => this.number(`corners.${i}.${key}`, `${name} ${key}`, (value) => {
            while (this.corners.length <= i)
              this.corners.push({ x: 0, y: 0 });
            this.corners[i] = { ...this.corners[i], [key]: value };
          }))), h("button", { type: "button", onclick: () => { this.corners = []; this.changed(); } }, "Clear")))),
      this.text = h("pre", { class: "picked", tabindex: 0, "aria-label": "What was picked, as a plan has it" }));
    this.numbers();
  }

  number(path, name, set) {
    const input = h("input", { type: "number", min: 0, step: 1, onchange: () => {
      if (input.value !== "") {
        set(Math.round(Number(input.value)));
        this.changed();
      }
    } });
    this.fields[path] = input;
    return h("label", { class: "field" }, name, input);
  }

  choose(mode) {
    this.mode = this.mode === mode ? null : mode;
    this.overlay.toggleAttribute("data-drawing", !!this.mode); /* else a finger on the picture moves the page */
    if (this.mode)
      this.overlay.scrollIntoView({ block: "nearest" });
    for (const b of this.form.querySelectorAll("[data-mode]"))
      b.setAttribute("aria-pressed", String(b.dataset.mode === this.mode));
    this.hint.textContent = { region: "Drag from one corner of the region to the other.", reference: "Drag over a grey patch that does not change.",
      corners: `Click the corners of the chart's patches, clockwise from "dark skin". Where it lies upright that is ${CORNERS.join(", ")}.` }[this.mode] || "Draw in the picture, or type numbers, in the camera's pixels.";
  }

  numbers() {
    for (const [path, input] of Object.entries(this.fields)) {
      const value = path.split(".").reduce((v, key) => v?.[key], this);
      input.value = value === undefined || value === null ? "" : value;
    }
    this.text.textContent = pickedText(this) || "nothing is picked";
  }
}

/* A plan's patch counts from its region's corner, what is drawn from the frame's. */
export function withinRegion(patch, region) {
  return patch && region ? { ...patch, x: patch.x - region.x, y: patch.y - region.y } : patch;
}

/* The option that says where a chart lies; "" until all four corners are there. */
export function cornersOption({ corners }) {
  return corners.length === 4 ? `--corners ${corners.map((p) => `${p.x},${p.y}`).join(",")}` : "";
}

/* As a plan's lines; the corners, which are none, behind a #. */
export function pickedText({ region, reference, corners }) {
  const rect = (name, r) => r && `${name}: {x: ${r.x}px, y: ${r.y}px, width: ${r.width}px, height: ${r.height}px}`;
  return [rect("region", region), rect("reference", withinRegion(reference, region)),
    corners.length === 4 && `# corners of the chart: ${corners.map((p) => `${p.x},${p.y}`).join(" ")}`].filter(Boolean).join("\n");
}
