// SPDX-License-Identifier: Apache-2.0
// guide.mjs DAEMON TTFBOX [SHOTS]: a person calibrates a simulated box by the page alone: dark, flat, chart, grid; what they typed stays; boards.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync, writeFileSync } from "node:fs";
import { Browser, until } from "./browser.mjs";
import { Daemon } from "./daemon.mjs";

const [program, ttfbox, shots] = process.argv.slice(2);
const SIZE = [384, 288], MARGIN = 0.1, NAME = "by-the-guide", AWAY = /ERR_CONNECTION|ERR_INCOMPLETE|ERR_EMPTY_RESPONSE|Failed to load resource|ERR_NETWORK/;
const scene = (name) => `sim.scene.name: ${name}, sim.optics.margin: ${100 * MARGIN}%, sim.optics.perspective: 0`;

const daemon = await Daemon.make(program);
const browser = await Browser.start({ may: (u) => u.startsWith(`${daemon.url}/`) });
const { page } = browser;
const state = () => page.locator("#state").textContent();
const go = async (part) => {
  await page.getByRole("link", { name: part, exact: true }).click();
  await page.locator(`html[data-part="${part}"]`).waitFor();
};

/* Something else is put into the box. */
async function put_in(name) {
  browser.expected = AWAY;
  assert.equal(await daemon.kill("SIGTERM"), 0, "the daemon ends cleanly");
  daemon.configure(scene(name), SIZE);
  await daemon.start();
  await page.reload();
  await until("it is there again", async () => (await state()) === "Idle", 30000);
  browser.expected = null;
}

/* A step is taken; what the box says of it. */
async function take(button, words) {
  await until(button, () => page.getByRole("button", { name: button }).isEnabled());
  await page.getByRole("button", { name: button }).click();
  await page.getByText(words).waitFor();
  return page.getByText(words).textContent();
}

const field = (label) => page.getByLabel(label, { exact: true });

function in_the_pages_words(text) {
  assert.doesNotMatch(text, /--[a-z]|-[a-z]:|_ns|_milli|Bearer/, "nobody at the page types options, or knows the interface's names");
}

async function the_token_is_given() {
  await page.goto(`${daemon.url}/`);
  await page.getByRole("textbox", { name: "Token" }).fill(daemon.token);
  await page.getByRole("button", { name: "Use it" }).click();
  await until("idle", async () => (await state()) === "Idle");
}

async function what_is_refused_is_said_in_the_pages_words() {
  await put_in("grass");
  await go("Calibrate");
  await field("Name of the calibration").fill(NAME);
  await field("Frames of a step").fill("8");
  for (const label of ["Exposure, ms", "Gain"])
    assert.equal(await field(label).getAttribute("placeholder"), label === "Gain" ? "1" : "20", "what holds where nothing is said");
  in_the_pages_words(await take("Take the flat", /The flat was refused: .*looks at no even target/));
  const place = await page.getByText(/The flat was refused: /).evaluate((e) => e.closest("li")?.textContent);
  assert.match(place, /^Flat\./, "it is said where the button is");
  let asked = 0;
  browser.expected = AWAY;
  const refuse = (status, answer) => page.route("**/calibrations/*", (route) => { asked++; return route.fulfill({ status, json: answer }); });
  for (const [status, answer, words] of [[400, { error: "a whole number of 1 to 1000 is meant", where: "gain_milli" }, "gain: a whole number of 1 to 1000 is meant"],
    [401, { error: "this needs the box's token", hint: "send it as Authorization: Bearer TOKEN" }, "this needs the box's token (enter it by the button at the top)"]]) {
    await refuse(status, answer);
    await page.getByRole("button", { name: "Take the dark" }).click();
    await page.getByRole("alert").getByText(words, { exact: true }).waitFor();
    await page.unroute("**/calibrations/*");
  }
  await refuse(400, {});
  asked = 0;
  for (const [label, wrong, button] of [["Exposure, ms", "90000000", "Take the dark"], ["It reflects", "7", "Take the flat"], ["Dots apart, mm", "0", "Take the grid"]]) {
    const right = await field(label).inputValue();
    await field(label).fill(wrong);
    await page.getByRole("button", { name: button }).click();
    assert.ok(await field(label).evaluate((e) => !e.validity.valid && e === document.activeElement), `${label} ${wrong}: the field says so itself`);
    await field(label).fill(right);
  }
  assert.equal(asked, 0);
  await page.unroute("**/calibrations/*");
  browser.expected = null;
  await browser.everywhere("guide-refused", shots);
}

/* Which plans there are, as the box says it from now on; nothing: it says nothing. */
async function plans_are(plans) {
  await page.unroute("**/api/v1/plans");
  await page.route("**/api/v1/plans", (route) => plans && route.fulfill({ json: { plans } }));
  await go("Now");
  await go("Calibrate");
}

async function a_plan_that_was_chosen_holds_before_the_others_are_known() {
  const chosen = page.getByLabel(/^For the light of the plan/), asked = [];
  await plans_are([{ name: "leaf" }]);
  await chosen.selectOption("leaf");
  await plans_are(null);
  assert.equal(await field("Gain").getAttribute("placeholder"), "the plan's");
  browser.expected = AWAY;
  await page.route("**/calibrations/*", (route) => { asked.push(route.request().postDataJSON()); return route.fulfill({ status: 400, json: { error: "not now" } }); });
  await page.getByRole("button", { name: "Take the dark" }).click();
  await page.getByRole("alert").getByText("not now").waitFor();
  assert.equal(asked[0].plan, "leaf", "not all lamps, fully lit");
  await page.unroute("**/calibrations/*");
  browser.expected = null;
  await plans_are([{ name: "leaf" }]);
  await until("it is chosen still", async () => (await chosen.inputValue()) === "leaf");
  await chosen.selectOption("");
  await page.unroute("**/api/v1/plans");
}

async function what_was_typed_into_the_guide_stays() {
  await field("Dots apart, mm").fill("4.5");
  await go("Live view");
  await page.getByText("From the camera, now.").waitFor();
  await go("Calibrate");
  assert.equal(await field("Name of the calibration").inputValue(), NAME, "who goes to live view and comes back types nothing twice");
  await page.reload();
  await until("the page", async () => (await state()) === "Idle");
  assert.deepEqual(await Promise.all(["Name of the calibration", "Frames of a step", "Dots apart, mm"].map((label) => field(label).inputValue())), [NAME, "8", "4.5"], "nor who loads the page anew");
  assert.ok(Number(await field("Exposure, ms").inputValue()) > 0, "what live view found is taken over");
  await field("Exposure, ms").fill("10"); /* of the lit box */
  await field("Gain").fill("1");
  await field("Name of the calibration").fill("called-otherwise");
  await field("Name of the calibration").fill(NAME);
  await go("Live view");
  await page.getByText("From the camera, now.").waitFor();
  await go("Calibrate");
  assert.equal(await field("Exposure, ms").inputValue(), "10", "whatever was typed first");
}

async function dark_and_flat_are_taken() {
  await put_in("white");
  await take("Take the dark", `The dark of ${NAME} is there.`);
  await take("Take the flat", `The flat of ${NAME} is there.`);
}

/* Where a person sees the chart's corners, in the order in which they are asked for. */
async function mark(corners) {
  await go("Live view");
  await page.getByText("From the camera, now.").waitFor();
  for (const side of ["left", "right"])
    await page.getByRole("slider", { name: `Lamp ${side}`, exact: true }).press("End");
  await page.getByText(/^Taken with .* lamps left 100 %, right 100 %/).waitFor();
  await page.getByRole("button", { name: "Mark the chart's corners" }).click();
  const svg = page.locator(".viewer svg");
  await svg.scrollIntoViewIfNeeded();
  const box = await svg.boundingBox();
  for (const [u, v] of corners)
    await page.mouse.click(box.x + box.width * u, box.y + box.height * v);
}

async function a_chart_is_marked_and_taken() {
  const a = MARGIN, b = 1 - MARGIN, corners = [[a, a], [b, a], [b, b], [a, b]];
  await put_in("chart");
  await go("Calibrate");
  assert.ok(await page.getByRole("button", { name: "Take the chart" }).isDisabled());
  await page.getByText("Its corners are not marked yet.").waitFor();
  await mark([...corners.slice(2), ...corners.slice(0, 2)]); /* begun at the wrong corner: upside down */
  await go("Calibrate");
  const said = await take("Take the chart", /The chart was refused: /);
  in_the_pages_words(said);
  assert.match(said, /dark skin|grey scale/, "what to look at");
  await mark(corners);
  await page.getByText("All four corners are marked.").waitFor();
  await page.locator(".viewer svg").click(); /* one click too many */
  assert.equal(await page.locator("pre.picked").textContent(), `# corners of the chart: ${corners.map(([u, v]) => `${Math.round(u * SIZE[0])},${Math.round(v * SIZE[1])}`).join(" ")}`);
  const digits = await page.locator(".viewer text").first().evaluate((e) => e.getBoundingClientRect().height);
  assert.ok(digits > 12, `numbers ${digits} pixels high can be read`);
  await browser.everywhere("guide-corners", shots);
  await go("Calibrate");
  assert.equal(await field("Exposure, ms").inputValue(), "10", "all steps are of one exposure, whatever live view found for the chart");
  await take("Take the chart", `The chart of ${NAME} is there.`);
}

async function a_grid_is_taken() {
  await put_in("dots");
  await go("Calibrate");
  await field("Dots apart, mm").fill("5");
  await take("Take the grid", `The geometry of ${NAME} is there.`);
  const { calibrations: [made] } = await daemon.ask("calibrations"), want = 16 * 5 / (SIZE[0] * (1 - 2 * MARGIN));
  assert.ok(Math.abs(made.geometry.mm_per_px / want - 1) < 0.02, `${made.geometry.mm_per_px} mm a pixel, where ${want} is so`);
  const row = page.getByRole("row", { name: new RegExp(`^${NAME}`) });
  for (const what of [/dark: 8 frames/, /flat: 8 frames/, /chart: 8 frames.*colours off by/, /geometry: 8 frames.*mm a pixel/])
    assert.match(await row.textContent(), what);
  await row.getByRole("button", { name: "Use it" }).click();
  await row.getByText("in use").waitFor();
  await browser.everywhere("guide-done", shots);
  execFileSync(ttfbox, ["calibrate", "report", `data/.ttfbox/calibrations/${NAME}`], { stdio: "pipe" });
}

async function what_was_typed_into_a_plan_stays() {
  await go("Plan");
  await page.getByText("This box can do it").waitFor();
  await page.getByLabel("Something else").check();
  const typed = { "A picture every": "7", For: "3", "Title": "Typed once", "Name of plan and dataset": "typed-once", "Exposure, ms": "30", "Lamp left, %": "40" };
  for (const [label, value] of Object.entries(typed))
    await field(label).fill(value);
  await field("For, unit").selectOption("h");
  await page.getByLabel("Lamps burn").selectOption("continuous");
  const stays = async (why) => {
    await page.getByText("This box can do it").waitFor();
    for (const [label, value] of Object.entries(typed))
      assert.equal(await field(label).inputValue(), value, `${why}: ${label}`);
    assert.equal(await page.getByLabel("Lamps burn").inputValue(), "continuous");
    assert.ok(await page.getByLabel("Something else").isChecked());
    assert.match(await page.getByLabel("The plan's text").inputValue(), /title: "Typed once"\ninterval: 7min\ncount: 26\n[^]*left: 40%/);
  };
  await page.getByRole("link", { name: "live view", exact: true }).first().click(); /* to draw a region, say */
  await page.getByText("From the camera, now.").waitFor();
  await page.getByText("Numbers", { exact: true }).click();
  for (const [label, value] of Object.entries({ x: "10", y: "10", width: "64", height: "48" })) {
    await page.getByRole("group", { name: /^Region/ }).getByLabel(label, { exact: true }).fill(value);
    await page.keyboard.press("Tab");
  }
  await go("Plan");
  await stays("after live view");
  assert.ok(await field("only the region").isChecked(), "what was drawn meanwhile is in it");
  await field("only the region").uncheck();
  await page.reload();
  await stays("after a reload");
  assert.ok(!await field("only the region").isChecked(), "and what was not wanted is not");
  await page.getByText("The plan, as the box reads it").click();
  const text = page.getByLabel("The plan's text"), by_hand = `${await text.inputValue()}# by hand\n`;
  await text.fill(by_hand);
  await go("Datasets");
  await go("Plan");
  await until("what was written by hand", async () => (await text.inputValue()) === by_hand);
  await browser.everywhere("plan-by-hand", shots);
  await page.getByRole("button", { name: "Begin anew" }).click();
  assert.equal(await field("Title").inputValue(), "Untitled");
  assert.doesNotMatch(await text.inputValue(), /by hand/);
}

async function boards_are_seen_checked_and_sent() {
  await go("Boards");
  const own = page.getByRole("row", { name: /^sim-small/ });
  assert.match(await own.textContent(), /this box/);
  await own.getByRole("button", { name: "Look at sim-small" }).click();
  await page.getByText("A board can be described so.").waitFor();
  assert.match(await page.locator("dl.facts").textContent(), /sim-small.*main.*left, lit for .*box-temp/);
  const text = page.getByLabel("Or as text"), send = page.getByRole("button", { name: "Send it, to be kept" });
  const mine = readFileSync(`${process.env.SOURCE}/boards/sim-small/board.yaml`, "utf8").replace("board: sim-small", "board: my-bench");
  writeFileSync("bench.yaml", mine.replace("kind: pwm", "kind: pmw"));
  await page.getByLabel("From a file").setInputFiles("bench.yaml");
  await page.getByText("No board can be described so.").waitFor();
  await page.getByText(/^board:\d+:\d+: .*pmw/).waitFor();
  assert.ok(await send.isDisabled());
  await page.getByText("From the file bench.yaml.", { exact: true }).waitFor();
  await browser.everywhere("boards-wrong", shots);
  let answer;
  await page.route("**/boards/check", async (route) => {
    const response = await route.fetch();
    await new Promise((go_on) => (answer = go_on));
    await route.fulfill({ response });
  }, { times: 1 });
  await text.fill(mine);
  await until("the box has an answer", () => answer);
  await send.evaluate((e) => new MutationObserver(() => (globalThis.was_enabled ||= !e.disabled)).observe(e, { attributes: true }));
  await text.fill("board: {}\n");
  answer();
  await page.getByText(/^board:1:\d+: /).waitFor();
  assert.ok(!await page.evaluate(() => globalThis.was_enabled), "what was said of another text lets nothing be sent");
  await text.fill(mine);
  await page.getByText("From the file bench.yaml, changed here.").waitFor();
  await page.getByText("A board can be described so.").waitFor();
  await go("Now");
  await go("Boards");
  assert.equal(await text.inputValue(), mine, "what was typed stays");
  await until("the button", () => send.isEnabled());
  await send.click();
  await page.getByText("my-bench is kept on the box.").waitFor();
  const row = page.getByRole("row", { name: /^my-bench/ });
  await row.getByText("sent to it").waitFor();
  await browser.everywhere("boards", shots);
  browser.expected = AWAY;
  await send.click();
  const said = page.getByRole("alert").filter({ hasText: "a board of this name was sent before" });
  await said.waitFor();
  browser.expected = null;
  await row.getByRole("button", { name: "Delete my-bench" }).click();
  await page.getByRole("button", { name: "Delete it" }).click();
  await row.waitFor({ state: "detached" });
  assert.deepEqual((await daemon.ask("boards")).boards.filter((b) => b.sent), []);
}

const the_daemon_ends_cleanly = async () => assert.equal(await daemon.kill("SIGTERM"), 0, "the daemon ends cleanly");
await browser.does([the_token_is_given, what_is_refused_is_said_in_the_pages_words, a_plan_that_was_chosen_holds_before_the_others_are_known, what_was_typed_into_the_guide_stays, dark_and_flat_are_taken, a_chart_is_marked_and_taken, a_grid_is_taken,
  what_was_typed_into_a_plan_stays, boards_are_seen_checked_and_sent],
  { shots, last: the_daemon_ends_cleanly, over: () => daemon.child.kill("SIGKILL") });
