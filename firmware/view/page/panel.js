/* SPDX-License-Identifier: Apache-2.0 */
/* panel.js: one texture on the page: its picture, how one looks around in it, the life of a pixel. */
"use strict";
(() => {
  const { Surface, pick, planeScale, sphereRadius } = ttfSurface;

  function make(parent, name, properties, ...children) {
    const e = Object.assign(document.createElement(name), properties);
    e.append(...children);
    parent.append(e);
    return e;
  }

  class Panel {
    constructor(parent, about, number, onplace) {
      Object.assign(this, { about, number, onplace, points: new Map(), wanted: false });
      this.text = about.text || ttfPlot.timeText; /* of what frames are apart by: time, where that is known */
      this.view = { shape: "plane", frame: 0, gain: 1, mark: null };
      this.reset();
      this.build(parent);
      this.surface = Surface.create(this.canvas, about.width, about.height, about.slots.length);
      if (!this.surface) {
        this.canvas.replaceWith(this.canvas = this.canvas.cloneNode());
        this.surface = new ttfFlat.Flat(this.canvas, about.width, about.height, about.slots.length);
      }
      this.listen();
    }

    build(parent) {
      const { about } = this, id = `panel${this.number}`;
      this.section = make(parent, "section", { className: "panel" });
      this.section.setAttribute("aria-labelledby", id);
      const head = make(this.section, "div", { className: "head" });
      make(head, "h2", { id, textContent: about.role });
      make(head, "p", { textContent: about.title });
      this.canvas = make(this.section, "canvas", { className: "stage", tabIndex: 0 });
      this.canvas.setAttribute("aria-label", `${this.about.role}: no frame yet`);
      this.canvas.setAttribute("role", "img");
      this.row = make(this.section, "div", { className: "row pick" });
      this.x = this.number_input("Pixel x", about.width);
      this.y = this.number_input("y", about.height);
      this.said = make(this.row, "output", {});
      make(this.row, "button", { type: "button", textContent: "Show all" }).addEventListener("click", () => {
        this.reset();
        this.redraw();
      });
      this.figure = make(this.section, "figure", { className: "plot", hidden: true });
    }

    number_input(text, size) {
      const input = document.createElement("input");
      Object.assign(input, { type: "number", min: 0, max: size - 1, step: 1 });
      make(this.row, "label", {}, text, input);
      input.addEventListener("change", () => {
        const x = Number(this.x.value), y = Number(this.y.value);
        if (this.x.value !== "" && this.y.value !== "")
          this.place(x, y);
      });
      return input;
    }

    reset() {
      Object.assign(this.view, { zoom: 1, x: this.about.width / 2, y: this.about.height / 2, yaw: 0, pitch: 0 });
    }

    /* Its place is empty from now on. */
    end() {
      this.watched.disconnect();
      this.surface.end();
      this.section.remove();
    }

    /* The value that a display code stands for. */
    value(code) {
      return this.about.black + ttfFlat.decode(code / 255) * (this.about.white - this.about.black);
    }

    /* What light is multiplied with so that value 1 (of a measurement: its greatest) is white. */
    gain(stops) {
      return (this.about.black === 0 ? this.about.white : 1) * 2 ** stops;
    }

    redraw() {
      if (this.wanted)
        return;
      this.wanted = true;
      requestAnimationFrame(() => {
        this.wanted = false;
        const ratio = globalThis.devicePixelRatio || 1, box = this.canvas.getBoundingClientRect();
        const width = Math.max(1, Math.round(box.width * ratio)), height = Math.max(1, Math.round(box.height * ratio));
        if (this.canvas.width !== width || this.canvas.height !== height)
          Object.assign(this.canvas, { width, height });
        this.surface.draw(this.view);
      });
    }

    show(frame, stops, shape) {
      this.view.frame = frame;
      this.view.gain = this.gain(stops);
      this.view.shape = this.surface.shapes.includes(shape) ? shape : "plane";
      this.canvas.setAttribute("aria-label", `${this.about.role}: slot ${this.about.slots[frame]}, ` +
        `${this.text(this.about.times_s[frame])}, on a ${this.view.shape}. Arrow keys move the chosen pixel.`);
      if (this.plotted)
        this.plotted.now(this.about.times_s[frame]);
      this.say();
      this.redraw();
    }

    /* All frames are there: what was chosen before is looked up now. Until then a life would show what is missing as black. */
    loaded() {
      this.surface.loaded();
      this.whole = true;
      if (this.view.mark)
        this.place(this.view.mark.x, this.view.mark.y);
    }

    say() {
      const { view, codes } = this;
      if (!view.mark || !codes)
        return;
      const p = [0, 1, 2].map((c) => this.value(codes[view.frame * 4 + c]).toFixed(3));
      this.said.textContent = `p = ${p.join(", ")}`;
    }

    async place(x, y) {
      const { about, view } = this;
      x = Math.max(0, Math.min(about.width - 1, Math.round(x)));
      y = Math.max(0, Math.min(about.height - 1, Math.round(y)));
      view.mark = { x, y };
      this.x.value = x;
      this.y.value = y;
      this.redraw();
      if (!this.whole)
        return;
      const codes = await this.surface.life(x, y);
      if (view.mark.x !== x || view.mark.y !== y)
        return;
      this.codes = codes;
      this.plot(x, y);
      this.say();
      this.onplace(this.number, x, y);
    }

    plot(x, y) {
      const names = this.about.camera_colours ? ["camera 1", "camera 2", "camera 3"] : ["red", "green", "blue"];
      const series = ["red", "green", "blue"].map((style, c) => ({
        name: names[c], style, values: this.about.slots.map((_, i) => this.value(this.codes[i * 4 + c])),
      }));
      const { times_s, text: about_text } = this.about, open = this.figure.querySelector("details")?.open;
      this.figure.hidden = false;
      this.figure.replaceChildren();
      this.plotted = ttfPlot.lines(this.figure, { times_s, series, text: about_text, now_s: times_s[this.view.frame],
        unit: this.about.quantity || "value", label: `The life of pixel ${x}, ${y}: each channel over time; the table below has its values` });
      make(this.figure, "figcaption", { textContent: `Pixel ${x}, ${y} over ${this.text(times_s.at(-1) - times_s[0])}` });
      const details = make(this.figure, "details", { open: !!open }, Object.assign(document.createElement("summary"), { textContent: "As a table" }));
      const scroll = make(details, "div", { className: "scroll", tabIndex: 0 });
      scroll.setAttribute("role", "region");
      scroll.setAttribute("aria-label", `Values of pixel ${x}, ${y}`);
      ttfPlot.table(scroll, { times_s, series, text: about_text });
    }

    /* A pointer's place in pixels of the canvas. */
    at(event) {
      const box = this.canvas.getBoundingClientRect();
      return { x: (event.clientX - box.left) * this.canvas.width / box.width, y: (event.clientY - box.top) * this.canvas.height / box.height };
    }

    /* The point under (x, y) stays where it is. */
    zoom(factor, x = this.canvas.width / 2, y = this.canvas.height / 2) {
      const { view, about, canvas } = this, before = planeScale(view, about.width, about.height, canvas);
      view.zoom = Math.max(0.5, Math.min(200, view.zoom * factor));
      const after = planeScale(view, about.width, about.height, canvas);
      view.x += (x - canvas.width / 2) * (1 / before - 1 / after);
      view.y += (y - canvas.height / 2) * (1 / before - 1 / after);
      this.redraw();
    }

    move(dx, dy) {
      const { view, about, canvas } = this;
      if (view.shape === "sphere") {
        const r = sphereRadius(view, canvas);
        view.yaw -= dx / r;
        view.pitch = Math.max(-1.5, Math.min(1.5, view.pitch - dy / r));
      } else {
        const scale = planeScale(view, about.width, about.height, canvas);
        view.x -= dx / scale;
        view.y -= dy / scale;
      }
      this.redraw();
    }

    listen() {
      const { canvas, points } = this;
      let travelled = 0;
      canvas.addEventListener("pointerdown", (e) => {
        canvas.setPointerCapture(e.pointerId);
        if (points.size === 0)
          travelled = 0;
        points.set(e.pointerId, this.at(e));
      });
      canvas.addEventListener("pointermove", (e) => {
        const old = points.get(e.pointerId), now = this.at(e);
        if (!old)
          return;
        const other = [...points].find(([id]) => id !== e.pointerId)?.[1];
        points.set(e.pointerId, now);
        if (other) {
          const d = (p) => Math.hypot(p.x - other.x, p.y - other.y) || 1;
          this.zoom(d(now) / d(old), (now.x + other.x) / 2, (now.y + other.y) / 2);
          travelled += 100;
        } else {
          travelled += Math.hypot(now.x - old.x, now.y - old.y);
          if (travelled > 4)
            this.move(now.x - old.x, now.y - old.y);
        }
      });
      const up = (e) => {
        const was = points.delete(e.pointerId);
        if (was && travelled <= 4 && e.type === "pointerup") {
          const p = this.at(e), found = pick(this.view, this.about.width, this.about.height, canvas, p.x, p.y);
          if (found)
            this.place(found.x, found.y);
        }
      };
      canvas.addEventListener("pointerup", up);
      canvas.addEventListener("pointercancel", up);
      canvas.addEventListener("wheel", (e) => {
        e.preventDefault();
        const p = this.at(e);
        this.zoom(Math.exp(-e.deltaY * (e.deltaMode ? 0.05 : 0.0015)), p.x, p.y);
      }, { passive: false });
      canvas.addEventListener("keydown", (e) => this.key(e));
      canvas.addEventListener("webglcontextlost", () => { /* as phones do with pages that were left for a while */
        this.said.textContent = "The graphics card has let go of the frames: load them again.";
      });
      this.watched = new ResizeObserver(() => this.redraw());
      this.watched.observe(canvas);
    }

    key(e) {
      const arrows = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] };
      if (arrows[e.key] && !e.ctrlKey && !e.altKey && !e.metaKey) {
        const [dx, dy] = arrows[e.key], step = e.shiftKey ? 10 : 1;
        const from = this.view.mark || { x: this.about.width >> 1, y: this.about.height >> 1 };
        if (this.view.shape === "sphere")
          this.move(-dx * 20 * step, -dy * 20 * step);
        else
          this.place(from.x + dx * step, from.y + dy * step);
      } else if (e.key === "+" || e.key === "=") {
        this.zoom(1.25);
      } else if (e.key === "-") {
        this.zoom(0.8);
      } else if (e.key === "0") {
        this.reset();
        this.redraw();
      } else {
        return;
      }
      e.preventDefault();
    }
  }

  globalThis.ttfPanel = { Panel };
})();
