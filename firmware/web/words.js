/* SPDX-License-Identifier: Apache-2.0 */
/* words.js: numbers as people read them. */

const S = 1e9;

/* "04:12", "1:04:12", "3 d 04:12" */
export function countdown(ns) {
  const s = Math.max(0, Math.ceil(ns / S - 1e-6)), two = (v) => String(Math.floor(v)).padStart(2, "0");
  if (s < 3600)
    return `${Math.floor(s / 60)}:${two(s % 60)}`;
  if (s < 86400)
    return `${Math.floor(s / 3600)}:${two(s / 60 % 60)}:${two(s % 60)}`;
  return `${Math.floor(s / 86400)} d ${two(s / 3600 % 24)}:${two(s / 60 % 60)}`;
}

/* "12 minutes", "3.5 hours", "6 days 23 hours" */
export function span(ns) {
  const s = Math.abs(ns) / S, some = (n, word) => `${n} ${word}${n === 1 ? "" : "s"}`;
  if (s < 1e-3)
    return `${+(s * 1e6).toPrecision(2)} µs`;
  if (s < 1)
    return `${+(s * 1000).toPrecision(3)} ms`;
  if (s < 60 || (s < 120 && s % 60 > 0.5))
    return some(+s.toPrecision(3), "second");
  if (s < 3600 || (s < 7200 && s % 3600 > 30))
    return some(+(s / 60).toPrecision(3), "minute");
  if (s < 86400 || (s < 171000 && s % 86400 > 1800))
    return some(+(s / 3600).toPrecision(3), "hour");
  const all = Math.round(s / 3600), days = Math.floor(all / 24), hours = all % 24; /* rounded first: no day has 24 hours more */
  return hours ? `${some(days, "day")} ${some(hours, "hour")}` : some(days, "day");
}

export function bytes(n) {
  if (n === undefined || n === null)
    return "?";
  for (const [unit, size] of [["TB", 1e12], ["GB", 1e9], ["MB", 1e6], ["kB", 1e3]])
    if (n >= size)
      return `${+(n / size).toPrecision(3)} ${unit}`;
  return `${n} B`;
}

/* An instant in this browser's zone. */
export function when(utc_ns) {
  if (utc_ns === undefined || utc_ns === null)
    return "unknown";
  return new Date(utc_ns / 1e6).toLocaleString([], { dateStyle: "medium", timeStyle: "medium" });
}

/* "2026-11-27": the day that it is where this browser is */
export function today(now = new Date()) {
  const two = (v) => String(v).padStart(2, "0");
  return `${now.getFullYear()}-${two(now.getMonth() + 1)}-${two(now.getDate())}`;
}

export function count(n, one, many) {
  return `${n.toLocaleString()} ${n === 1 ? one : many || `${one}s`}`;
}

/* "12.5 ms at gain 2, lamps left 50 %" */
export function exposureWords({ exposure_ms, gain, lamps }) {
  const lit = Object.entries(lamps || {}).filter(([, level]) => level > 0);
  return `${span(exposure_ms * 1e6)}${gain > 0 ? ` at gain ${+gain.toPrecision(3)}` : ""}, ${lit.length ? `lamps ${lit.map(([name, level]) => `${name} ${level} %`).join(", ")}` : "all lamps dark"}`;
}

/* Of a sensor's kind (hal/sensors.h): its name, the unit that people read it in, and how many of its own units that is. */
const SENSORS = { temp_mdegc: ["Temperature", "°C", 1000], humidity_mpct: ["Humidity", "%", 1000], light_permille: ["Light", "%", 10],
  pressure_pa: ["Pressure", "hPa", 100], undervoltage: ["Undervoltage", "", 1] };
export const sensorKind = (kind) => SENSORS[kind] || [kind, "", 1];

export function reading(kind, value) {
  const [, unit, per] = sensorKind(kind);
  return `${+(value / per).toFixed(2)} ${unit}`.trim();
}
