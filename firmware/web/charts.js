/* SPDX-License-Identifier: Apache-2.0 */
/* charts.js: levels, slot error, sensors, lamp hours over the slots: as lines, and as tables. */
import { h, fill } from "./dom.js";

const TITLES = { reference_level: "Reference level", mean_level: "Mean level", slot_error_s: "Slot error", sensor: "Sensors", lamp_hours: "Lamp hours" };
const UNITS = { temperature: ["°C", 1 / 1000], temp_mdegc: ["°C", 1 / 1000], humidity: ["%", 1 / 1000], humidity_mpct: ["%", 1 / 1000], light: ["%", 0.1], light_permille: ["%", 0.1] };
const KINDS = { temperature: "Temperature", temp_mdegc: "Temperature", humidity: "Humidity", humidity_mpct: "Humidity", light: "Light", light_permille: "Light" };
const STYLES = ["plain", "red", "green", "blue", "violet"];

/* Hours as people read them: a run of seconds has none. */
function lampUnit(series) {
  const most = Math.max(0, ...series.filter((one) => one.what === "lamp_hours").flatMap((one) => one.max));
  return most >= 2 ? ["h", 1] : most >= 2 / 60 ? ["min", 60] : ["s", 3600];
}

/* One chart for each thing that has one unit. */
function groups(series) {
  const found = new Map(), lamp = lampUnit(series);
  for (const one of series) {
    const [unit, factor] = one.what === "sensor" ? UNITS[one.kind] || [one.kind, 1] : one.what === "slot_error_s" ? ["ms", 1000] : one.what === "lamp_hours" ? lamp : ["value", 1];
    const key = one.what === "sensor" ? `sensor ${unit}` : one.what;
    if (!found.has(key))
      found.set(key, { title: one.what === "sensor" ? KINDS[one.kind] || one.kind : TITLES[one.what] || one.what, unit, lines: [] });
    found.get(key).lines.push({ one, factor });
  }
  return [...found.values()];
}

const called = ({ what, name, stream, bracket }) => name || [stream, bracket !== undefined && `bracket ${bracket}`].filter(Boolean).join(" ") || (what === "slot_error_s" ? "error" : what);

export function charts(parent) {
  fill(parent, h("h2", {}, "Charts"), h("p", {}, "No slots yet."));
  return {
    show({ index, due_utc_ns, series, slots_per_point, results }) {
      if (!index.length)
        return;
      const known = due_utc_ns.every((t) => t !== null), times_s = known ? due_utc_ns.map((t) => (t - due_utc_ns[0]) / 1e9) : index, text = known ? undefined : String;
      const lost = ["missed", "failed", "power"].reduce((sum, name) => sum + (results[name] || []).reduce((a, b) => a + b, 0), 0);
      const open = new Set([...parent.querySelectorAll("details[open]")].map((d) => d.dataset.chart));
      const grid = h("div", { class: "chart-grid" });
      fill(parent, h("h2", {}, "Charts"),
        h("p", { class: "quiet" }, `Over ${known ? "time" : "slots"}${slots_per_point > 1 ? `; each point stands for ${slots_per_point} slots, and both their least and greatest value are drawn` : ""}. ` +
          `${lost ? `${lost} slots have no picture.` : "Every slot has its picture."}`), grid);
      const charted = groups(series), figures = charted.map(({ title }) => h("figure", { class: "plot" }, h("figcaption", {}, title)));
      grid.append(...figures); /* all of them: a plot is as wide as its place */
      charted.forEach(({ title, unit, lines }, at) => {
        const figure = figures[at];
        const all = [];
        lines.forEach(({ one, factor }, k) => {
          const style = STYLES[k % STYLES.length], scale = (column) => column.map((v) => (v === null ? null : v * factor));
          all.push({ name: called(one), style, values: scale(one.mean) });
          if (slots_per_point > 1)
            for (const [end, column] of [["least", one.min], ["greatest", one.max]])
              all.push({ name: `${called(one)}, ${end}`, style, values: scale(column) });
        });
        globalThis.ttfPlot.lines(figure, { times_s, series: all.length > 3 ? all.map((s, i) => ({ ...s, name: i < 3 ? s.name : "" })).filter((s) => s.values.some((v) => v !== null)) : all, unit, text,
          label: `${title}: ${summary(all, unit)}` });
        const scroll = h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": `${title} as a table` });
        globalThis.ttfPlot.table(scroll, { times_s, series: all, most: 300, text });
        figure.append(h("details", { "data-chart": title, open: open.has(title) }, h("summary", {}, "As a table"), scroll));
      });
    },
  };
}

/* For those who do not see the lines. */
function summary(all, unit) {
  return all.slice(0, 4).map(({ name, values }) => {
    const some = values.filter((v) => v !== null);
    return some.length ? `${name} from ${+Math.min(...some).toPrecision(3)} to ${+Math.max(...some).toPrecision(3)} ${unit}, last ${+some.at(-1).toPrecision(3)}` : `${name} without values`;
  }).join("; ");
}
