/* SPDX-License-Identifier: Apache-2.0 */
/* aids.js: what a picture's pixels say of exposure and focus. Pure, but for pixelsOf: pixels in, figures or pixels out. */

const CLIPPED = 250, DARK = 5, SPOILED_TOP = 60; /* display codes; the last is 4 % of white */
const SPOILED_CLIPPED = 0.05;

/* Of RGBA pixels: 256 counts per channel, and the shares that are clipped and dark. */
export function histogram({ data }) {
  const counts = [0, 1, 2].map(() => new Uint32Array(256));
  let clipped = 0, dark = 0;
  for (let i = 0; i < data.length; i += 4) {
    const r = data[i], g = data[i + 1], b = data[i + 2];
    counts[0][r]++;
    counts[1][g]++;
    counts[2][b]++;
    if (Math.max(r, g, b) >= CLIPPED)
      clipped++;
    else if (Math.max(r, g, b) <= DARK)
      dark++;
  }
  const n = data.length / 4 || 1;
  return { counts, clipped: clipped / n, dark: dark / n };
}

/* The code above which there is next to nothing. */
function brightest({ counts }) {
  let seen = 0, top = 255;
  const all = counts[1].reduce((a, b) => a + b, 0);
  while (top > 0 && (seen += Math.max(counts[0][top], counts[1][top], counts[2][top])) < all / 1000)
    top--;
  return top;
}

const of_white = (code) => 100 * (code / 255) ** 2.2;

/* What nobody wants a week of: "" where there is nothing to be said. */
export function spoiled(figures) {
  const top = brightest(figures), { clipped } = figures;
  if (clipped > SPOILED_CLIPPED)
    return `clipped: ${Math.round(100 * clipped)} % of the picture is as bright as the camera can tell`;
  return top < SPOILED_TOP ? `nearly black: nothing in it is brighter than ${+of_white(top).toPrecision(1)} % of white` : "";
}

/* What the figures mean to somebody who sets the exposure. */
export function advice(figures) {
  const top = brightest(figures), { clipped, dark } = figures;
  if (clipped > 0.001)
    return `${(100 * clipped).toFixed(clipped > 0.01 ? 0 : 1)} % is clipped: expose less`;
  if (top < 130)
    return `nothing is brighter than ${Math.round(of_white(top))} % of white: expose more, or more light`;
  if (dark > 0.5)
    return "more than half is black: is the light on?";
  return "nothing is clipped";
}

/* Of a JPEG, all of them, or shrunk to so many in a row. */
export async function pixelsOf(blob, width) {
  const bitmap = await createImageBitmap(blob, width ? { resizeWidth: width } : {}), canvas = new OffscreenCanvas(bitmap.width, bitmap.height), context = canvas.getContext("2d", { willReadFrequently: true });
  context.drawImage(bitmap, 0, 0);
  bitmap.close();
  return context.getImageData(0, 0, canvas.width, canvas.height);
}

const luma = (d, i) => 0.2126 * d[i] + 0.7152 * d[i + 1] + 0.0722 * d[i + 2];

/*
 * How sharp a rectangle is: the mean squared Laplacian of luma, in display codes. It has no unit: compare
 * it with what it was a moment ago, of the same thing in the same light. The largest is the best focus.
 */
export function sharpness({ data, width, height }, x0 = 0, y0 = 0, w = width, h = height) {
  let sum = 0, n = 0;
  for (let y = Math.max(1, y0); y < Math.min(height - 1, y0 + h); y++)
    for (let x = Math.max(1, x0); x < Math.min(width - 1, x0 + w); x++) {
      const i = (y * width + x) * 4;
      const l = 4 * luma(data, i) - luma(data, i - 4) - luma(data, i + 4) - luma(data, i - 4 * width) - luma(data, i + 4 * width);
      sum += l * l;
      n++;
    }
  return n ? sum / n : 0;
}

/*
 * The pixels with marks in them, for looking at: clipped ones striped red, black ones striped blue; with
 * peaking, edges that are sharp in yellow.
 */
export function marked({ data, width, height }, { clipping, peaking }) {
  const out = new ImageData(new Uint8ClampedArray(data), width, height);
  const paint = (i, r, g, b) => {
    out.data[i] = r;
    out.data[i + 1] = g;
    out.data[i + 2] = b;
  };
  let limit = Infinity;
  if (peaking)
    limit = Math.max(14, 3.2 * Math.sqrt(sharpness({ data, width, height })));
  for (let y = 1; y < height - 1; y++)
    for (let x = 1; x < width - 1; x++) {
      const i = (y * width + x) * 4, top = Math.max(data[i], data[i + 1], data[i + 2]);
      if (clipping && top >= CLIPPED && (x + y) % 6 < 3)
        paint(i, 255, 0, 40);
      else if (clipping && top <= DARK && (x + y) % 6 < 3)
        paint(i, 40, 90, 255);
      else if (peaking) {
        const l = 4 * luma(data, i) - luma(data, i - 4) - luma(data, i + 4) - luma(data, i - 4 * width) - luma(data, i + 4 * width);
        if (Math.abs(l) > limit)
          paint(i, 255, 230, 0);
      }
    }
  return out;
}

/* The histogram as a picture: three channels over one another, in the root of their counts so that few pixels show. */
export function drawHistogram(canvas, { counts }, colours) {
  const w = canvas.width = 256, h = canvas.height = 100, context = canvas.getContext("2d");
  const most = Math.sqrt(Math.max(1, ...counts.map((c) => c.subarray(1, 255).reduce((a, b) => Math.max(a, b), 0))));
  context.clearRect(0, 0, w, h);
  counts.forEach((c, k) => {
    context.strokeStyle = colours[k];
    context.lineWidth = 1.6;
    context.beginPath();
    for (let x = 0; x < w; x++)
      context.lineTo(x, h - 1 - Math.min(1, Math.sqrt(c[x]) / most) * (h - 4));
    context.stroke();
  });
}
