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
const { span } = await import("./words.js");
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
  box.status = { state: "capturing", retry_in_ns: 60e9, run: { ends_in_ns: 100e9 } };
  box.received = performance.now() - 30000;
  box.happened("slot", { index: 3, total: 9, next: { index: 4, in_ns: 40e9 } });
  assert.ok(Math.abs(box.ends_in_ns() - 70e9) < 1e9, "it does not jump back");
  assert.ok(Math.abs(box.status.retry_in_ns - 30e9) < 1e9);
  assert.ok(Math.abs(box.next_in_ns() - 40e9) < 1e9);
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

for (const part of [an_error_is_no_news_of_the_box, an_order_ends_when_the_box_was_started_again, an_order_that_nobody_answers_ends,
  the_time_left_goes_on_when_a_slot_comes, of_two_pages_that_listen_one_gives_way_at_once, where_there_are_locks_its_holder_listens, times_and_axes_read_well]) {
  await part();
  console.log(part.name.replaceAll("_", " "));
}
process.exit(0); /* its timers never end */
