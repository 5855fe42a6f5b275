// SPDX-License-Identifier: Apache-2.0
// box.mjs: box.js on answers that are made up here, its timers a hundred times as fast.
import assert from "node:assert/strict";

const FASTER = 100, { setTimeout: real_timeout, setInterval: real_interval } = globalThis;
globalThis.setTimeout = (f, ms, ...args) => real_timeout(f, ms / FASTER, ...args);
globalThis.setInterval = (f, ms) => real_interval(f, ms / FASTER);
const wait = (ms) => new Promise((go) => real_timeout(go, ms));

const answers = new Map(), streams = new Set();
globalThis.fetch = async (path) => {
  const [status, body] = answers.get(path.replace("/api/v1/", "")) || [404, { error: "unknown" }];
  return new Response(JSON.stringify(body), { status });
};
globalThis.document = new EventTarget();
document.hidden = false;
globalThis.addEventListener = () => {};
globalThis.EventSource = class extends EventTarget {
  constructor() {
    super();
    streams.add(this);
  }
  close() {
    streams.delete(this);
  }
};
function with_locks(locks) {
  Object.defineProperty(globalThis, "navigator", { value: { locks }, configurable: true });
}

const { Box } = await import("./box.js");
const { span, today } = await import("./words.js");
const { stateWords } = await import("./state.js");
const { startOf } = await import("./verdict.js");
const { advice, histogram, marked, sharpness, spoiled } = await import("./aids.js");
const { planText, presetChoice, startText, PRESETS } = await import("./presets.js");
const { nearest } = await import("./preview.js");
const { lastSlot, pictured, slotOf, spread } = await import("./timeline.js");
await import("./plot.js");
answers.set("session", [200, { box: true, read: true, change: true }]);

async function an_error_is_no_news_of_the_box() {
  const box = new Box();
  answers.set("status", [200, { state: "capturing" }]);
  await box.look();
  assert.equal(box.lost, false);
  for (const status of [500, 503, 421]) {
    answers.set("status", [status, { error: "the disk is away" }]);
    await box.look();
    assert.equal(box.lost, true, `what was seen before ${status} is old`);
    assert.match(box.trouble, /the disk is away/);
    answers.set("status", [200, { state: "capturing" }]);
    await box.look();
    assert.equal(box.lost, false);
  }
  answers.set("status", [503, { error: "there is no box here" }]);
  const served = new Box();
  served.session = { box: false, read: true, change: false };
  await served.look();
  assert.equal(served.lost, false, "where datasets alone are served no box is missed");
  clearTimeout(box.timer);
}

async function an_order_ends_when_the_box_was_started_again() {
  const box = new Box();
  answers.set("run/pause", [202, { number: 7, answered: false }]);
  answers.set("run/asked/7", [404, { error: "nothing of this number was asked, or long ago" }]);
  await assert.rejects(box.order("run/pause", {}), /started again/);
}

async function an_order_that_nobody_answers_ends() {
  const box = new Box();
  answers.set("run/asked/7", [200, { number: 7, answered: false }]);
  await assert.rejects(box.order("run/pause", {}), /has not said/);
  answers.set("run/asked/7", [200, { number: 7, answered: true, done: true }]);
  assert.equal((await box.order("run/pause", {})).done, true);
}

async function the_time_left_goes_on_when_a_slot_comes() {
  const box = new Box();
  box.status = { state: "capturing", retry_in_ns: 60e9, run: { ends_in_ns: 100e9, settled_in_ns: 35e9 } };
  box.received = performance.now() - 30000;
  box.happened("slot", { index: 3, total: 9, next: { index: 4, in_ns: 40e9 } });
  assert.ok(Math.abs(box.ends_in_ns() - 70e9) < 1e9, "it does not jump back");
  assert.ok(Math.abs(box.status.retry_in_ns - 30e9) < 1e9);
  assert.ok(Math.abs(box.next_in_ns() - 40e9) < 1e9);
  assert.ok(Math.abs(box.settled_in_ns() - 5e9) < 1e9);
}

async function a_slot_of_another_run_is_not_counted_to_this_one() {
  const box = new Box();
  box.status = { state: "capturing", run: { dataset: "grass", done: 7, slots: 9 } };
  box.happened("slot", { dataset: "copper", index: 88, total: 100 });
  assert.deepEqual(box.status.run, { dataset: "grass", done: 7, slots: 9 });
}

// What is seen may be old then, and who shows it asks again.
async function what_may_be_old_is_said_to_be() {
  const box = new Box();
  let stale = 0;
  box.addEventListener("stale", () => stale++);
  answers.set("status", [200, { state: "capturing" }]);
  await box.look();
  assert.equal(stale, 0, "a look that shows what was seen already makes nothing old");
  box.happened("missed", {});
  assert.equal(stale, 1, "events that nobody heard");
  answers.delete("status");
  await box.look();
  assert.equal(box.lost, true);
  assert.equal(stale, 1);
  answers.set("status", [200, { state: "capturing" }]);
  await box.look();
  assert.equal(stale, 2, "it was away");
  answers.set("status", [200, { state: "none" }]);
  await box.look();
  assert.equal(stale, 3, "where there is no box to tell of anything, at each look");
  clearTimeout(box.timer);
}

async function a_token_given_on_one_page_is_known_on_the_others() {
  with_locks(undefined);
  const [page, other] = [new Box(), new Box()].map((box) => {
    box.channel = new BroadcastChannel("tokens");
    box.channel.onmessage = ({ data }) => box.told(data);
    return box;
  });
  answers.set("status", [200, { state: "idle" }]);
  answers.set("session", [200, { box: true, read: true, change: false }]);
  await other.ask_session();
  answers.set("session", [200, { box: true, read: true, change: true }]);
  await page.renew();
  await wait(50);
  assert.equal(other.session.change, true);
  for (const box of [page, other]) {
    box.unlead();
    clearTimeout(box.timer);
    box.channel.close();
  }
}

// Timers of hidden pages come late: both think that nobody listens.
async function of_two_pages_that_listen_one_gives_way_at_once() {
  with_locks(undefined);
  for (const [first, second] of [["a", "b"], ["b", "a"]]) {
    const pages = [first, second].map((id) => {
      const box = new Box();
      box.id = id;
      box.channel = new BroadcastChannel("test");
      box.channel.onmessage = ({ data }) => box.told(data);
      return box;
    });
    for (const box of pages) {
      box.heard = -1e6;
      box.beat();
      await wait(50);
    }
    assert.equal(streams.size, 1, "one stream is enough for a browser");
    for (const box of pages) {
      box.unlead();
      box.channel.close();
    }
  }
}

async function where_there_are_locks_its_holder_listens() {
  const line = [];
  with_locks({ request: (_, held) => new Promise(() => line.push(held) === 1 && held()) });
  answers.set("status", [200, { state: "idle" }]);
  const pages = [new Box(), new Box()];
  for (const box of pages)
    await box.start();
  await wait(100); /* five beats */
  for (const box of pages)
    await box.renew();
  assert.equal(streams.size, 1);
  line[1](); /* the first is gone */
  pages[0].unlead();
  assert.equal(streams.size, 1, "the next takes its place");
  assert.ok(pages[1].leading);
}

async function times_and_axes_read_well() {
  const D = 8.64e13, H = 3.6e12;
  assert.equal(span(7 * D - 6e11), "7 days"); /* a week of ten minutes: its last slot begins before it is over */
  assert.equal(span(6 * D + 23 * H), "6 days 23 hours");
  assert.equal(span(2 * D - 1e9), "2 days");
  for (const [value, text] of [[0.000002, "2e-6"], [-0.00012345, "-1.2e-4"], [0.25, "0.25"], [1250, "1250"], [12345678, "1.2e7"], [0, "0"]])
    assert.equal(globalThis.ttfPlot.tickText(value), text, "as wide as its place");
}

/* 40 slots, four to a point; of the second point's the first two were missed, of the third's all. */
async function a_slot_is_found_among_points() {
  const n = 10, columns = { index: Array.from({ length: n }, (_, i) => 100 + 4 * i), due_utc_ns: Array.from({ length: n }, (_, i) => 1e18 + 4e9 * i),
    results: { captured: Array(n).fill(4), missed: Array(n).fill(0) }, pictured: Array.from({ length: n }, (_, i) => 100 + 4 * i) };
  [columns.results.captured[1], columns.results.missed[1], columns.pictured[1]] = [2, 2, 106];
  [columns.results.captured[2], columns.results.missed[2], columns.pictured[2]] = [0, 4, null];
  [columns.results.captured[9], columns.results.missed[9]] = [3, 0]; /* its last one is not done yet */
  assert.equal(lastSlot(columns), 138);
  assert.equal(lastSlot({ index: [], results: {} }), -1);
  assert.deepEqual(slotOf(columns, 103), { due_utc_ns: 1e18 + 3e9, exact: false, picture: true });
  assert.deepEqual(slotOf(columns, 104), { due_utc_ns: 1e18 + 4e9, exact: true, picture: undefined });
  assert.equal(slotOf(columns, 111).picture, false);
  assert.deepEqual(slotOf(columns, 138), { due_utc_ns: 1e18 + 38e9, exact: false, picture: true });
  assert.equal(slotOf({ ...columns, due_utc_ns: Array(n).fill(null) }, 103).due_utc_ns, null);
  assert.deepEqual(pictured(columns).slice(0, 3), [100, 106, 112]);
  assert.deepEqual(spread(pictured(columns), 3), [100, 120, 136]);
  assert.deepEqual(spread([5], 10), [5]);
  assert.deepEqual(spread([], 10), []);
}

function a_previews_frame_is_found_by_its_slot() {
  const frames = [0, 4, 10, 12].map((slot) => ({ slot }));
  assert.deepEqual([0, 4, 7, 8, 11, 99].map((slot) => nearest(frames, slot)), [0, 1, 1, 2, 2, 3]);
}

async function states_and_days_read_well() {
  const capturing = stateWords({ state: "capturing", run: { done: 3, slots: 9 } }, false);
  assert.deepEqual([capturing.text, capturing.said], ["Capturing 3/9", "Capturing"], "what is read out does not change with each slot");
  assert.equal(stateWords({ state: "capturing" }, true).said, "Connection lost");
  process.env.TZ = "Pacific/Auckland";
  assert.equal(today(new Date("2026-11-27T20:00:00Z")), "2026-11-28", "the day that it is here");
  process.env.TZ = "Europe/Berlin";
  assert.equal(today(new Date("2026-03-28T23:30:00Z")), "2026-03-29");
  assert.equal(startOf("title: x\ninterval: 1min\n"), undefined);
  assert.equal(startOf("start: now\n"), undefined);
  assert.equal(startOf("start: 2026-03-29T06:00:00+02:00 # summer\n"), Date.UTC(2026, 2, 29, 4));
  assert.equal(startOf("start: 2026-03-29T06:00:00Z\n"), Date.UTC(2026, 2, 29, 6));
  assert.equal(startOf('start: "06:00"\n'), null, "of a zone that the box knows");
  assert.equal(startText(""), null);
  assert.equal(startText("2026-11-27T08:00"), "2026-11-27T07:00:00Z");
  assert.match(planText({ ...presetChoice(PRESETS[0], ["left"]), start: startText("202608-11-27T08:00") }), /^start: 202608-11-27T08:00$/m, "what is no date is not lost: the box is to refuse it");
  const text = planText({ ...presetChoice(PRESETS[0], ["left"]), title: 'a "b" \\ c\u0085d\u2028e\u0007f\nstart: now' });
  assert.match(text, /^title: "a \\"b\\" \\\\ c d e f start: now"\n/, "a title is one line, whatever was pasted into it");
}

/* A picture of the same grey, but for what `paint` gives another code. */
function picture(width, height, grey, paint = () => undefined) {
  const data = new Uint8ClampedArray(4 * width * height);
  for (let i = 0; i < width * height; i++)
    data.set([0, 1, 2].map(() => paint(i % width, Math.floor(i / width)) ?? grey).concat(255), 4 * i);
  return { data, width, height };
}

async function exposure_and_focus_are_judged_by_pixels() {
  globalThis.ImageData = class {
    constructor(data, width, height) {
      Object.assign(this, { data, width, height });
    }
  };
  const even = picture(40, 30, 180), bright = picture(40, 30, 180, (x) => (x < 4 ? 255 : undefined)), black = picture(40, 30, 3);
  const edge = picture(40, 30, 60, (x) => (x < 20 ? 160 : undefined)), soft = picture(40, 30, 60, (x) => (x < 15 ? 160 : x < 25 ? 160 - 10 * (x - 15) : undefined));
  assert.deepEqual([histogram(even).clipped, histogram(even).dark, histogram(even).counts[1][180]], [0, 0, 1200]);
  assert.equal(histogram(bright).clipped, 0.1);
  assert.equal(advice(histogram(even)), "nothing is clipped");
  assert.match(advice(histogram(bright)), /^10 % is clipped: expose less$/);
  assert.match(advice(histogram(black)), /expose more/);
  assert.deepEqual([even, bright, black].map((p) => spoiled(histogram(p)).split(":")[0]), ["", "clipped", "nearly black"]);
  assert.ok(sharpness(edge) > 4 * sharpness(soft) && sharpness(even) === 0, "a sharp edge counts more than a soft one");
  const at = ({ data, width }, x, y) => [...data.slice(4 * (y * width + x), 4 * (y * width + x) + 3)].join();
  const colours = (p) => new Set(Array.from({ length: 38 * 28 }, (_, i) => at(p, 1 + i % 38, 1 + Math.floor(i / 38))));
  const clip = { clipping: true, peaking: false }, peak = { clipping: false, peaking: true };
  assert.deepEqual(colours(marked(bright, clip)), new Set(["255,0,40", "255,255,255", "180,180,180"]), "what is clipped is striped");
  assert.deepEqual(colours(marked(black, clip)), new Set(["40,90,255", "3,3,3"]), "what is black, in another colour");
  assert.deepEqual(colours(marked(bright, { clipping: false, peaking: false })), new Set(["255,255,255", "180,180,180"]));
  const yellow = marked(edge, peak);
  assert.deepEqual([18, 19, 20, 21].map((x) => at(yellow, x, 15) === "255,230,0"), [false, true, true, false], "a sharp edge is marked where it is");
  assert.ok(!colours(marked(soft, peak)).has("255,230,0"), "a soft one is not");
  assert.ok(!colours(marked(bright, clip)).has("255,230,0"));
}

for (const part of [an_error_is_no_news_of_the_box, an_order_ends_when_the_box_was_started_again, an_order_that_nobody_answers_ends,
  the_time_left_goes_on_when_a_slot_comes, of_two_pages_that_listen_one_gives_way_at_once, where_there_are_locks_its_holder_listens, times_and_axes_read_well, a_slot_of_another_run_is_not_counted_to_this_one,
  what_may_be_old_is_said_to_be, a_token_given_on_one_page_is_known_on_the_others, a_slot_is_found_among_points, a_previews_frame_is_found_by_its_slot, states_and_days_read_well, exposure_and_focus_are_judged_by_pixels]) {
  await part();
  console.log(part.name.replaceAll("_", " "));
}
process.exit(0); /* its timers never end */
