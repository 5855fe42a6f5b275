/* SPDX-License-Identifier: Apache-2.0 */
/* charts.js: levels, slot error, sensors, lamp hours over the slots: as lines, and as tables. */
import { h, fill, say } from "./dom.js";
import { count, sensorKind } from "./words.js";

const TITLES = { reference_level: "Reference level", mean_level: "Mean level", slot_error_s: "Slot error", lamp_hours: "Lamp hours" };
const STYLES = ["plain", "red", "green", "blue", "violet"];

/* Hours as people read them: a run of seconds has none. */
function lampUnit(series) {
  const most = Math.max(0, ...series.filter((one) => one.what === "lamp_hours").flatMap((one) => one.max));
  return most >= 2 ? ["h", 1] : most >= 2 / 60 ? ["min", 60] : ["s", 3600];
}

/* How a series is charted: {title, unit, factor: from its own unit}. */
function kindOf({ what, kind }, lamp) {
  if (what === "sensor") {
    const [title, unit, per] = sensorKind(kind);
    return { title, unit, factor: 1 / per };
  }
  const [unit, factor] = { slot_error_s: ["ms", 1000], lamp_hours: lamp }[what] || ["value", 1];
  return { title: TITLES[what] || what, unit, factor };
}

/* One chart for each thing: [{title, unit, lines: [{one, factor}]}] */
function groups(series) {
  const found = new Map(), lamp = lampUnit(series);
  for (const one of series) {
    const { title, unit, factor } = kindOf(one, lamp);
    if (!found.has(title))
      found.set(title, { title, unit, lines: [] });
    found.get(title).lines.push({ one, factor });
  }
  return [...found.values()];
}

const called = ({ what, name, stream, bracket }) => name || [stream, bracket !== undefined && `bracket ${bracket}`].filter(Boolean).join(" ") || (what === "slot_error_s" ? "error" : what);

/* The place of one chart, which stays while its lines are drawn anew: its table may be open, and somebody reading in it. */
function place(title) {
  const drawn = h("div"), scroll = h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": `${title} as a table` });
  const details = h("details", { ontoggle: () => table() }, h("summary", {}, "As a table"), scroll), figure = h("figure", { class: "plot" }, h("figcaption", {}, title), drawn, details);
  let rows = null, plotted = null, wide = 0;
  function plot() {
    wide = drawn.clientWidth;
    fill(drawn);
    globalThis.ttfPlot.lines(drawn, plotted);
  }
  /* A phone that is turned: letters keep their size, and do not grow and shrink with the lines. */
  new ResizeObserver(() => requestAnimationFrame(() => plotted && drawn.clientWidth > 0 && Math.abs(drawn.clientWidth - wide) > 8 && plot())).observe(drawn);
  function table() {
    if (!details.open || !rows)
      return;
    const { scrollTop: top, scrollLeft: left } = scroll;
    fill(scroll);
    globalThis.ttfPlot.table(scroll, rows);
    scroll.scrollTo(left, top);
  }
  return { figure, draw(of) {
    plotted = of;
    plot();
    rows = { times_s: of.times_s, series: of.all, most: 300, text: of.text };
    table();
  } };
}

/* Of a point that stands for many slots the least and the greatest value, too: thin, and without a name of their own. */
function linesOf({ lines }, bounds) {
  return lines.flatMap(({ one, factor }, k) => {
    const scale = (column) => column.map((v) => (v === null ? null : v * factor)), style = STYLES[k % STYLES.length], name = called(one);
    const mean = { name, style, values: scale(one.mean) };
    return bounds ? [mean, { name: `${name}, least`, style, bound: true, values: scale(one.min) }, { name: `${name}, greatest`, style, bound: true, values: scale(one.max) }] : [mean];
  });
}

export function charts(parent) {
  const about = h("p", { class: "quiet" }, "No slots yet."), grid = h("div", { class: "chart-grid" }), places = new Map();
  fill(parent, h("h2", {}, "Charts"), about, grid);
  return {
    show({ index, due_utc_ns, series, slots, slots_per_point, results }) {
      if (!index.length)
        return;
      const known = due_utc_ns.every((t) => t !== null), times_s = known ? due_utc_ns.map((t) => (t - due_utc_ns[0]) / 1e9) : index, text = known ? undefined : String;
      const lost = slots - ["captured", "partial"].reduce((sum, name) => sum + (results[name] || []).reduce((a, b) => a + b, 0), 0);
      say(about, `Over ${known ? "time" : "slots"}${slots_per_point > 1 ? `; each point stands for ${slots_per_point} slots, and both their least and greatest value are drawn` : ""}. ` +
        `${lost ? `${count(lost, "slot")} ${lost === 1 ? "has" : "have"} no picture.` : "Every slot has its picture."}`);
      const charted = groups(series);
      for (const { title } of charted)
        if (!places.has(title))
          places.set(title, place(title));
      for (const [title, { figure }] of places)
        if (!charted.some((one) => one.title === title)) {
          figure.remove();
          places.delete(title);
        }
      for (const { figure } of places.values())
        if (!figure.isConnected)
          grid.append(figure); /* all of them: a plot is as wide as its place */
      for (const one of charted) {
        const all = linesOf(one, slots_per_point > 1);
        places.get(one.title).draw({ times_s, text, unit: one.unit, all, series: all.map((line) => (line.bound ? { ...line, name: "" } : line)), label: `${one.title}: ${summary(all, one.unit)}` });
      }
    },
  };
}

/* For those who do not see the lines. */
function summary(all, unit) {
  return all.slice(0, 6).map(({ name, values }) => {
    const some = values.filter((v) => v !== null);
    return some.length ? `${name} from ${+Math.min(...some).toPrecision(3)} to ${+Math.max(...some).toPrecision(3)} ${unit}, last ${+some.at(-1).toPrecision(3)}` : `${name} without values`;
  }).join("; ");
}
