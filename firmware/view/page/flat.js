/* SPDX-License-Identifier: Apache-2.0 */
/* flat.js: what surface.js does, on a plane, by a plain canvas: frames are decoded when they are looked at. */
"use strict";
(() => {
  const KEPT = 24; /* decoded frames */

  const decode = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  const encode = (c) => (c <= 0.0031308 ? 12.92 * c : 1.055 * c ** (1 / 2.4) - 0.055);

  /* Display codes after the light they stand for was multiplied. */
  function exposed(gain) {
    const table = new Uint8ClampedArray(256);
    for (let i = 0; i < 256; i++)
      table[i] = Math.round(255 * encode(Math.min(1, decode(i / 255) * gain)));
    return table;
  }

  class Flat {
    constructor(canvas, width, height, n) {
      Object.assign(this, { canvas, width, height, n, shapes: ["plane"], blobs: [], kept: new Map(), turn: 0 });
      this.context = canvas.getContext("2d");
      this.work = new OffscreenCanvas(width, height);
      this.pixels = this.work.getContext("2d", { willReadFrequently: true });
    }

    async load(i, blob) {
      this.blobs[i] = blob;
    }

    loaded() {}

    end() {
      this.blobs = [];
      this.kept.clear();
    }

    async codes(i) {
      let found = this.kept.get(i);
      if (!found) {
        const bitmap = await createImageBitmap(this.blobs[i]);
        this.pixels.drawImage(bitmap, 0, 0);
        bitmap.close();
        found = this.pixels.getImageData(0, 0, this.width, this.height);
        this.kept.set(i, found);
        if (this.kept.size > KEPT)
          this.kept.delete(this.kept.keys().next().value);
      }
      return found;
    }

    async draw(view) {
      const turn = ++this.turn, { canvas, context } = this;
      if (!this.blobs[view.frame])
        return; /* still being read */
      const codes = await this.codes(view.frame);
      if (turn !== this.turn)
        return; /* something newer is to be seen */
      const shown = new ImageData(this.width, this.height), table = exposed(view.gain);
      for (let i = 0; i < codes.data.length; i++)
        shown.data[i] = i % 4 === 3 ? 255 : table[codes.data[i]];
      this.pixels.putImageData(shown, 0, 0);
      const scale = ttfSurface.planeScale(view, this.width, this.height, canvas);
      context.setTransform(1, 0, 0, 1, 0, 0);
      context.clearRect(0, 0, canvas.width, canvas.height);
      context.imageSmoothingEnabled = scale < 2;
      context.setTransform(scale, 0, 0, scale, canvas.width / 2 - view.x * scale, canvas.height / 2 - view.y * scale);
      context.drawImage(this.work, 0, 0);
      if (view.mark) {
        const half = Math.max(0.5, 5 / scale);
        for (const [style, grow] of [["#000", 2.5], ["#fff", 1]]) {
          context.strokeStyle = style;
          context.lineWidth = 1.5 / scale;
          const h = half + grow / scale;
          context.strokeRect(view.mark.x + 0.5 - h, view.mark.y + 0.5 - h, 2 * h, 2 * h);
        }
      }
    }

    async life(x, y) {
      const row = new Uint8Array(this.n * 4), one = new OffscreenCanvas(1, 1).getContext("2d", { willReadFrequently: true });
      for (let i = 0; i < this.n; i++) {
        const bitmap = await createImageBitmap(this.blobs[i]);
        one.drawImage(bitmap, -x, -y);
        bitmap.close();
        row.set(one.getImageData(0, 0, 1, 1).data, i * 4);
      }
      return row;
    }
  }

  globalThis.ttfFlat = { Flat, decode };
})();
