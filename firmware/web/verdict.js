/* SPDX-License-Identifier: Apache-2.0 */
/* verdict.js: what the box says of a plan: figures, storage, what is wrong. */
import { h, facts } from "./dom.js";
import { refusal } from "./api.js";
import { bytes, count, span, when } from "./words.js";

/* When a plan's text has it begin, in milliseconds; undefined: at once; null: as only the box can tell. */
export function startOf(text) {
  const said = text.match(/^start:\s*"?([^"#\n]*)/m)?.[1].trim(), at = said && /(Z|[+-]\d\d:?\d\d)$/.test(said) ? Date.parse(said) : NaN;
  return said === undefined || said === "now" ? undefined : Number.isNaN(at) ? null : at;
}

function until(ns, ready_ns, start) {
  if (start === null)
    return "";
  return start === undefined ? `, until ${when(Date.now() * 1e6 + ready_ns + ns)} if begun now` : `, from ${when(start * 1e6)} until ${when(start * 1e6 + ns)}`;
}

/* What the box found, below `yes` or `no`. */
export function findings({ ok, findings: all = [] }, yes, no) {
  return [
    h("p", { class: ok ? "good" : "bad" }, h("strong", {}, ok ? yes : no)),
    all.length > 0 && h("ul", {}, all.map((one) => h("li", { class: `finding-${one.level}` }, refusal({ ...one, error: one.text })))),
  ];
}

/* Whether a plan can be done, and what is in the way. */
export const judgement = (got) => findings(got, "This box can do it.", "This box cannot do it as it stands.");

/* What it takes; `start`: startOf its text. */
export function figures(f, start) {
  const fits = f.slots_that_fit === undefined || f.slots_that_fit >= f.slots;
  return facts([
    ["Pictures", f.slots.toLocaleString()],
    ["Time", `${span(f.duration_ns)}${until(f.duration_ns, f.ready_ns, start)}`],
    ["Storage", `${bytes(f.bytes)}, ${bytes(f.slot_bytes)} a slot`],
    f.disk_free_bytes !== undefined && ["On this disk", h("span", { class: fits ? "" : "bad" },
      `${bytes(f.disk_free_bytes)} free${f.slots_that_fit !== undefined ? `, room for ${count(f.slots_that_fit, "slot")}` : ""}${fits ? "" : ": not enough"}`)],
    f.slot_busy_ns !== undefined && ["A slot takes", `${span(f.slot_busy_ns)} of its ${span(f.interval_ns)}`],
    f.memory_bytes !== undefined && ["Memory", bytes(f.memory_bytes)],
    ...(f.lamps || []).filter((l) => l.on_ns > 0).map((l) => [`Lamp ${l.name}`, `on for ${span(l.on_ns)}${l.duty_permille > 0 ? `, at most ${l.duty_permille / 10} % of any ${l.duty_window_ns ? span(l.duty_window_ns) : "such run"}` : ""}`]),
  ]);
}
