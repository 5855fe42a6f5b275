/* SPDX-License-Identifier: Apache-2.0 */
/* plot.js: lines over time as SVG, and the same as a table. */
"use strict";
(() => {
  const NS = "http://www.w3.org/2000/svg";
  const LEFT = 52, RIGHT = 12, FIRST = 26, ROW = 18, BOTTOM = 34;

  function element(parent, name, attributes, text) {
    const e = document.createElementNS(NS, name);
    for (const [key, value] of Object.entries(attributes || {}))
      e.setAttribute(key, value);
    if (text !== undefined)
      e.textContent = text;
    parent.append(e);
    return e;
  }

  /* "2 d 03:15", "03:15:20" or "12.5 s" */
  function timeText(s) {
    const two = (v) => String(Math.floor(v)).padStart(2, "0");
    if (!Number.isFinite(s))
      return "?";
    if (Math.abs(s) < 60)
      return `${+s.toFixed(s < 10 ? 2 : 1)} s`;
    if (s < 86400)
      return `${two(s / 3600)}:${two(s / 60 % 60)}:${two(s % 60)}`;
    return `${Math.floor(s / 86400)} d ${two(s / 3600 % 24)}:${two(s / 60 % 60)}`;
  }

  /* Round steps between two ends, about `count` of them. */
  function ticks(lo, hi, count, steps) {
    const rough = (hi - lo) / count || 1;
    let step;
    if (steps)
      step = steps.find((s) => s >= rough) || Math.ceil(rough / 86400) * 86400;
    else {
      const power = 10 ** Math.floor(Math.log10(rough));
      step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * 0.999);
    }
    const found = [];
    for (let k = Math.ceil(lo / step - 1e-9); k * step <= hi + step * 1e-9; k++)
      found.push(k * step);
    return found;
  }

  const TIME_STEPS = [0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 10800,
    21600, 43200, 86400, 172800, 432000, 864000];

  /* As many digits as there is room for left of the lines: what is tiny, or huge, as 2e-6. */
  function tickText(v) {
    const text = String(+v.toPrecision(4));
    return text.length <= 7 ? text : v.toExponential(1).replace("e+", "e").replace(".0e", "e");
  }

  /* Where names stand above the lines, from the right: in as many rows as it takes. */
  function legend(series, W) {
    const places = [];
    let right = W - RIGHT, row = 0;
    for (const one of series.filter(({ name }) => name).reverse()) {
      const wide = one.name.length * 7 + 8;
      if (right - wide - 26 < LEFT && right < W - RIGHT) {
        right = W - RIGHT;
        row++;
      }
      places.push({ one, at: right - wide, row });
      right -= wide + 36;
    }
    return { places, rows: row + 1 };
  }

  /*
   * lines(figure, {times_s, series: [{name, style, values, bound}], label, now_s}): values may hold null. What is
   * no time has its own text. A line without a name is not in the legend; one that is a bound is thin.
   * Gives back {now(s)}, which moves the mark of the present time.
   */
  function lines(figure, { times_s, series, label, unit, now_s, text = timeText }) {
    const svg = document.createElementNS(NS, "svg");
    const W = Math.max(300, Math.min(1000, figure.clientWidth || 640)); /* so that texts have their own size */
    svg.setAttribute("role", "img");
    svg.setAttribute("aria-label", label);
    const { places, rows } = legend(series, W), TOP = FIRST + (rows - 1) * ROW;
    const H = 240 + (rows - 1) * ROW;
    svg.setAttribute("viewBox", `0 0 ${W} ${H}`);
    let lo = Infinity, hi = -Infinity;
    for (const one of series)
      for (const v of one.values)
        if (v !== null && Number.isFinite(v)) {
          lo = Math.min(lo, v);
          hi = Math.max(hi, v);
        }
    if (!(hi >= lo))
      [lo, hi] = [0, 1];
    if (hi - lo < Math.max(Math.abs(hi), Math.abs(lo)) * 0.02 || hi === lo) {
      const more = Math.abs(hi) * 0.05 || 0.01;
      [lo, hi] = [lo - more, hi + more];
    }
    const t0 = times_s[0], t1 = Math.max(times_s.at(-1), t0 + 1e-9);
    const x = (t) => LEFT + (t - t0) / (t1 - t0) * (W - LEFT - RIGHT);
    const y = (v) => H - BOTTOM - (v - lo) / (hi - lo) * (H - TOP - BOTTOM);
    for (const v of ticks(lo, hi, 4)) {
      element(svg, "line", { class: "grid", x1: LEFT, x2: W - RIGHT, y1: y(v), y2: y(v) });
      element(svg, "text", { x: LEFT - 6, y: y(v) + 4, "text-anchor": "end" }, tickText(v));
    }
    for (const t of ticks(t0, t1, W < 480 ? 2.5 : 5, text === timeText ? TIME_STEPS : null)) {
      element(svg, "line", { class: "grid", x1: x(t), x2: x(t), y1: TOP, y2: H - BOTTOM });
      element(svg, "text", { x: x(t), y: H - BOTTOM + 16, "text-anchor": x(t) > W - 60 ? "end" : x(t) < LEFT + 20 ? "start" : "middle" },
        text(t));
    }
    if (unit)
      element(svg, "text", { x: 4, y: 14 }, unit);
    for (const { one, at, row } of places) {
      element(svg, "text", { x: at, y: 14 + row * ROW }, one.name);
      element(svg, "line", { class: `line ${one.style}`, x1: at - 26, x2: at - 6, y1: 10 + row * ROW, y2: 10 + row * ROW });
    }
    for (const one of [...series].reverse()) {
      let d = "", pen = "M";
      one.values.forEach((v, i) => {
        if (v === null || !Number.isFinite(v)) {
          pen = "M";
          return;
        }
        d += `${pen}${x(times_s[i]).toFixed(1)} ${y(v).toFixed(1)}`;
        pen = "L";
      });
      if (!d.includes("L") && d)
        d += "h2";
      element(svg, "path", { class: `line ${one.style}${one.bound ? " bound" : ""}`, d });
    }
    const mark = element(svg, "line", { class: "now", y1: TOP, y2: H - BOTTOM });
    const now = (s) => {
      mark.setAttribute("visibility", s === undefined || s < t0 || s > t1 ? "hidden" : "visible");
      mark.setAttribute("x1", x(s || 0));
      mark.setAttribute("x2", x(s || 0));
    };
    now(now_s);
    figure.append(svg);
    return { now };
  }

  /* The same values for those who read them; at most `most` rows, evenly taken. */
  function table(parent, { times_s, series, most = 400, text = timeText }) {
    const t = document.createElement("table"), head = t.createTHead().insertRow(), body = t.createTBody();
    for (const name of [text === timeText ? "time" : "slot", ...series.map((one) => one.name)]) {
      const th = document.createElement("th");
      th.scope = "col";
      th.textContent = name;
      head.append(th);
    }
    const step = Math.max(1, Math.ceil(times_s.length / most));
    for (let i = 0; i < times_s.length; i += step) {
      const row = body.insertRow();
      row.insertCell().textContent = text(times_s[i]);
      for (const one of series)
        row.insertCell().textContent = one.values[i] === null ? "–" : String(+one.values[i].toPrecision(4));
    }
    parent.append(t);
  }

  globalThis.ttfPlot = { lines, table, timeText, tickText };
})();
