// SPDX-License-Identifier: Apache-2.0
// presets.mjs TTFBOX SOURCE: the five samples, as the page's wizard and as plans that lie here: every board's lamps may burn as they say.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, readdirSync, writeFileSync } from "node:fs";
import { PRESETS, planText, presetChoice } from "./presets.js";

const [ttfbox, source] = process.argv.slice(2);
const PLANS = ["grass-week", "banana", "copper", "paint", "snow"];
const LIMITS = ["max_on", "max_duty", "warm_up"], MODEL = { left: true, right: true }; /* lamps of the simulated box, that stand for a board's */

/* A board's lamps: {left: {max_on: "12h", ...}, ...}; what it says in flow style, as those of real boards do, and in lines below the lamp's name. */
function lamps_of(board) {
  const text = readFileSync(`${source}/boards/${board}/board.yaml`, "utf8"), lamps = {};
  const section = text.match(/^lamps:\n((?: .*\n)+)/m)?.[1] || "";
  for (const [, name, rest] of section.matchAll(/^ {2}(\w+):((?:.*\n)(?: {4}.*\n)*)/gm))
    lamps[name] = Object.fromEntries(LIMITS.flatMap((key) => [...rest.matchAll(new RegExp(`\\b${key}: *([^,}\\s#]+)`, "g"))].map(([, value]) => [key, value])));
  return lamps;
}

const done = new Set();
function check(board, what, file) {
  const sets = Object.entries(lamps_of(board)).flatMap(([name, limits]) => {
    assert.ok(MODEL[name], `${board}: the lamp ${name} is none that a plan here names`);
    return Object.entries(limits).flatMap(([key, value]) => ["--set", `lamps.${name}.${key}=${value}`]);
  });
  if (done.has(`${file} ${sets}`)) /* another board with the same lamps */
    return;
  done.add(`${file} ${sets}`);
  try {
    execFileSync(ttfbox, ["plan", "check", file, ...sets], { stdio: "pipe" });
  } catch (error) {
    assert.fail(`${what} on ${board} (${sets.join(" ")}): ${error.stderr}`);
  }
}

const boards = readdirSync(`${source}/boards`, { withFileTypes: true }).filter((e) => e.isDirectory()).map((e) => e.name);
assert.ok(boards.length >= 7, `the boards that come with it: ${boards}`);
assert.deepEqual(lamps_of("rpi5").left, { max_on: "12h", max_duty: "60%", warm_up: "2min" }, "what this test reads of a board is what stands there");
for (const board of boards) {
  for (const preset of PRESETS) {
    writeFileSync(`${preset.id}.yaml`, planText(presetChoice(preset, ["left", "right"])));
    check(board, `the page's "${preset.title}"`, `${preset.id}.yaml`);
  }
  for (const plan of PLANS)
    check(board, plan, `${source}/boards/sim/plans/${plan}.yaml`);
}

/* A day that begins by the clock on the wall: of whoever plans, whatever the box's zone is. */
const grass = presetChoice(PRESETS[0], ["left", "right"]);
writeFileSync("local.yaml", planText({ ...grass, day_start: "06:30", zone: "Europe/Berlin" }));
assert.match(execFileSync(ttfbox, ["plan", "check", "local.yaml"], { encoding: "utf8" }), /^light +11 h 30 min of every 1 d, from 06:30 in Europe\/Berlin, UTC\+01:00$/m);
writeFileSync("local.yaml", planText(grass));
assert.match(execFileSync(ttfbox, ["plan", "check", "local.yaml"], { encoding: "utf8" }), /^light +11 h 30 min of every 1 d, from the first slot$/m);
console.log(`${PRESETS.length} presets and ${PLANS.length} plans on ${boards.length} boards`);
