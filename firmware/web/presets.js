/* SPDX-License-Identifier: Apache-2.0 */
/* presets.js: the paper's five samples (Enrique et al. 2005, section 3; boards/sim/plans), and the plan's text from what is chosen. */

export const PRESETS = [
  { id: "grass", title: "Growing grass", interval: [10, "min"], duration: [7, "d"], mode: "photoperiod", settle: [30, "s"], day: [690, "min"], period: [24, "h"], keep: "raw",
    text: "By day the lamps are lit: grass needs their light. At night they are for the frames alone. Water from below before the start; do not move the pot." },
  { id: "banana", title: "Ripening bananas", interval: [10, "min"], duration: [7, "d"], mode: "capture-only", settle: [30, "s"],
    text: "Lamps only for the frames: heat ripens faster and dries the skin." },
  { id: "copper", title: "Oxidising copper", interval: [1, "min"], duration: [12, "h"], mode: "capture-only", settle: [20, "s"],
    text: "Put the patina solution on and start at once: the first green shows within minutes." },
  { id: "paint", title: "Cracking paint", interval: [5, "s"], duration: [2, "h"], mode: "continuous",
    text: "Crackle medium, then paint, then start at once. At 5 s there is no time to warm lamps." },
  { id: "snow", title: "Settling snow", interval: [5, "s"], duration: [20, "min"], mode: "none", mains: "none", channel: "sky",
    text: "Outdoors, under a clouded sky, the camera under a roof of its own. No lamp is lit." },
  { id: "own", title: "Something else", interval: [5, "min"], duration: [1, "d"], mode: "capture-only", settle: [20, "s"],
    text: "Choose everything yourself." },
];

export const UNITS = { ms: 1e6, s: 1e9, min: 6e10, h: 3.6e12, d: 8.64e13 };

export const nanoseconds = ([n, unit]) => Math.round(n * UNITS[unit]);

export function slots(choice) {
  return Math.ceil(nanoseconds(choice.duration) / nanoseconds(choice.interval));
}

const quoted = (text) => `"${text.replace(/[\\"]/g, "\\$&").replace(/[\u0000-\u001f\u007f-\u009f\u2028\u2029\ufeff\ufffe\uffff]/g, " ")}"`; /* what YAML takes for an end of the line, or for nothing */
const rect = (r) => `{x: ${r.x}px, y: ${r.y}px, width: ${r.width}px, height: ${r.height}px}`;
const quantity = ([n, unit]) => `${n}${unit}`;

/* What the form holds once a preset is chosen, before anybody has changed it; lamps: names. */
export function presetChoice(p, lamps) {
  return { title: p.id === "own" ? "Untitled" : p.title, interval: p.interval, duration: p.duration, start: null, mode: p.mode, settle: p.mode === "continuous" ? null : p.settle || [20, "s"],
    day: p.day || [11.5, "h"], period: p.period || [24, "h"], day_start: null, zone: null, channel: p.channel, camera: null, lamps: Object.fromEntries(lamps.map((name) => [name, 100])),
    exposure_ms: 20, gain: 1, mains: p.mains || "50Hz", keep: p.keep || "default", region: null, reference: null };
}

/* When a plan begins, of what a field of day and time holds; null: at once. What is no date goes as it was typed: the box says that it is none. */
export function startText(typed) {
  const at = new Date(typed);
  if (!typed)
    return null;
  return Number.isNaN(at.getTime()) ? typed : at.toISOString().replace(/\.\d+Z/, "Z");
}

/* A plan (firmware/config/README.md) of what the form holds. */
export function planText(c) {
  const lit = c.mode === "none" ? [] : Object.entries(c.lamps).filter(([, level]) => level > 0);
  const lines = [`title: ${quoted(c.title)}`, `interval: ${quantity(c.interval)}`, `count: ${slots(c)}`];
  if (c.start)
    lines.push(`start: ${c.start}`);
  const local = c.mode === "photoperiod" && c.day_start; /* "06:00": of whoever plans, wherever the box thinks it is */
  if (local && c.zone)
    lines.push(`zone: ${c.zone}`);
  lines.push("lamps:", `  mode: ${c.mode}`);
  if (c.mode !== "none" && c.settle)
    lines.push(`  settle: ${quantity(c.settle)}`);
  if (c.mode === "photoperiod") {
    lines.push(`  day: ${quantity(c.day)}`, `  period: ${quantity(c.period)}`);
    if (local)
      lines.push(`  day_start: "${c.day_start}"`);
    if (lit.length)
      lines.push(`  day_levels: {${lit.map(([name, level]) => `${name}: ${level}%`).join(", ")}}`);
  }
  lines.push("shots:", "  - stream: main");
  if (c.camera && c.camera !== "main")
    lines.push(`    camera: ${c.camera}`);
  lines.push(`    channel: ${c.channel || "white"}`);
  if (lit.length)
    lines.push(`    lamps: {${lit.map(([name, level]) => `${name}: ${level}%`).join(", ")}}`);
  lines.push(`    exposure: ${c.exposure_ms}ms`);
  if (c.gain !== 1)
    lines.push(`    gain: ${c.gain}`);
  lines.push(`mains: ${c.mains}`);
  if (c.region)
    lines.push(`region: ${rect(c.region)}`);
  if (c.reference)
    lines.push(`reference: ${rect(c.reference)}`);
  if (c.keep !== "default")
    lines.push(`keep: ${c.keep}`);
  return `${lines.join("\n")}\n`;
}

/* A name that plans and datasets may have. */
export function nameOf(title) {
  return title.toLowerCase().replace(/[^a-z0-9]+/g, "-").replace(/^-+|-+$/g, "").slice(0, 40) || "plan";
}
