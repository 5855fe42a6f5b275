// SPDX-License-Identifier: Apache-2.0
// page.mjs DAEMON TTFBOX PREVIEW [SHOTS]: a person and the page of a simulated box, from the token to a verified dataset.
import assert from "node:assert/strict";
import { execFileSync } from "node:child_process";
import { readFileSync } from "node:fs";
import { Browser, DESK, PHONE, until } from "./browser.mjs";
import { Daemon } from "./daemon.mjs";

const [program, ttfbox, previewer, shots] = process.argv.slice(2);
const SLOTS = 40, NAME = "from-the-page";
const AWAY = /ERR_CONNECTION|ERR_INCOMPLETE|ERR_EMPTY_RESPONSE|Failed to load resource|ERR_NETWORK/;

const daemon = await Daemon.make(program);
const browser = await Browser.start({ may: (u) => u.startsWith(`${daemon.url}/`) });
const { page } = browser;
const state = () => page.locator("#state").textContent();
const go = async (part) => {
  await page.getByRole("link", { name: part, exact: true }).click();
  await page.locator(`html[data-part="${part}"]`).waitFor();
};
const run = async () => (await daemon.ask("status")).run;

async function nothing_is_shown_without_the_token() {
  await page.goto(`${daemon.url}/`);
  await page.getByText("This box asks for its token").waitFor();
  await browser.accessible("token");
  browser.expected = AWAY; /* the browser itself writes that it was refused */
  await page.getByRole("textbox", { name: "Token" }).fill("0123456789abcdef");
  await page.getByRole("button", { name: "Use it" }).click();
  await page.getByText("this is not the box's token").waitFor();
  browser.expected = null;
  await page.getByRole("textbox", { name: "Token" }).fill(daemon.token);
  await page.getByRole("button", { name: "Use it" }).click();
  await until("idle", async () => (await state()) === "Idle");
  await browser.everywhere("now-idle", shots);
}

async function a_region_is_drawn_in_live_view() {
  await go("Live view");
  await page.getByText("From the camera, now.").waitFor();
  assert.match(await page.getByText("Taken with").textContent(), /^Taken with [\d.]+ m?s(econds)? at gain 1, all lamps dark, by itself/);
  assert.match(await page.locator(".histogram").getAttribute("aria-label"), /clipped|expose|black/);
  assert.ok(Number(await page.locator(".meter").textContent()) > 0, "sharpness is a number");
  const touch = () => page.locator(".viewer svg").evaluate((e) => getComputedStyle(e).touchAction);
  assert.equal(await touch(), "auto", "a finger on the picture moves the page");
  assert.equal(await page.getByRole("slider", { name: "Lamp left", exact: true }).getAttribute("aria-valuetext"), "0 %");
  await page.getByRole("button", { name: "Draw the region" }).click();
  assert.equal(await touch(), "none", "and draws where that was asked for");
  await page.locator(".viewer svg").scrollIntoViewIfNeeded();
  const box = await page.locator(".viewer svg").boundingBox();
  await page.mouse.move(box.x + box.width * 0.25, box.y + box.height * 0.25);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width * 0.75, box.y + box.height * 0.75, { steps: 4 });
  await page.mouse.up();
  const about = await daemon.ask("box"), { width, height } = about.cameras[0];
  const drawn = (await page.locator("pre[aria-label^='What was picked']").textContent()).match(/region: \{x: (\d+)px, y: (\d+)px, width: (\d+)px, height: (\d+)px\}/).slice(1).map(Number);
  [width / 4, height / 4, width / 2, height / 2].forEach((want, i) => assert.ok(Math.abs(drawn[i] - want) <= 2, `the region ${drawn} of ${width} x ${height}`));
  await page.getByText("Numbers", { exact: true }).click();
  const patch = page.getByRole("group", { name: /^Reference/ });
  for (const [field, value] of Object.entries({ x: drawn[0] + 10, y: drawn[1] + 8, width: 20, height: 16 })) {
    await patch.getByLabel(field, { exact: true }).fill(String(value));
    await page.keyboard.press("Tab");
  }
  await page.getByText("reference: {x: 10px, y: 8px, width: 20px, height: 16px}").waitFor(); /* from the region's corner on, as a plan has it */
  await browser.everywhere("live", shots);
  const top = async (e) => (await e.boundingBox()).y, focus = page.getByRole("heading", { name: "Focus" }), region = page.getByRole("heading", { name: "Region and chart" });
  assert.ok(await top(region) > await top(page.locator(".viewer")) && await top(focus) < await top(page.locator(".viewer")) + 800, "on a desk they are beside the picture");
  await page.setViewportSize(PHONE);
  assert.ok(await top(focus) < await top(region), "on a phone the focus comes before what is drawn once");
  await page.getByRole("button", { name: "Draw the reference patch" }).click();
  const { y, height: high } = await page.locator(".viewer").boundingBox();
  assert.ok(y > -1 && y + high < PHONE.height + 1, "and the picture comes into view to draw in it");
  await page.setViewportSize(DESK);
}

async function a_button_stays_while_pictures_come() {
  let pictures = 0;
  const count = (r) => /\/live\?/.test(r.url()) && pictures++;
  page.on("response", count);
  const button = page.getByRole("button", { name: "Keep this exposure" }), exposure = page.getByLabel("Exposure, ms");
  await page.getByRole("button", { name: "Start live view" }).click();
  await button.focus();
  const before = pictures;
  await until("five more pictures", () => pictures > before + 5);
  assert.ok(await button.evaluate((e) => e === document.activeElement), "who has reached the button by keyboard is still there");
  await page.keyboard.press("Enter");
  assert.ok(Number(await exposure.inputValue()) > 0, "the exposure is kept");
  await button.waitFor({ state: "hidden" });
  await page.getByRole("button", { name: "Stop live view" }).click();
  page.off("response", count);
  await exposure.fill("");
  await page.keyboard.press("Tab");
  await page.getByText(/^Taken with .*, by itself/).waitFor();
}

/* Whatever is pressed, the camera is asked for one picture at a time; and not again and again where it gives none. */
async function live_view_asks_for_one_at_a_time() {
  const under_way = new Set();
  let most = 0, asked = 0;
  const begun = (r) => /\/live\?/.test(r.url()) && (asked++, most = Math.max(most, under_way.add(r).size)), ended = (r) => under_way.delete(r);
  page.on("request", begun);
  page.on("requestfinished", ended);
  page.on("requestfailed", ended);
  const play = page.getByRole("button", { name: /^(Start|Stop) live view$/ }), once = page.getByRole("button", { name: "One picture" });
  await play.click();
  for (let i = 0; i < 4; i++) {
    await once.click();
    await play.click();
    await play.click();
  }
  await page.waitForTimeout(1500);
  assert.equal(most, 1, "one at a time");
  browser.expected = AWAY;
  await page.route("**/live?*", (route) => route.fulfill({ status: 503, json: { error: "the camera does not answer" } }));
  await page.getByText("the camera does not answer").waitFor();
  asked = 0;
  await page.waitForTimeout(3000);
  assert.ok(asked <= 2, `${asked} times within 3 s`);
  await page.unroute("**/live?*");
  browser.expected = null;
  await page.getByText("From the camera, now.").waitFor();
  await play.click();
  await until("nothing is under way", () => under_way.size === 0);
  asked = 0;
  await page.waitForTimeout(1000);
  assert.equal(asked, 0, "stopped is stopped");
  for (const [kind, f] of [["request", begun], ["requestfinished", ended], ["requestfailed", ended]])
    page.off(kind, f);
}

/* A camera of more pixels than the picture has: the number is of the loupe's own pixels, and compared with those alone. */
async function focus_is_measured_in_the_cameras_own_pixels() {
  const flat = Buffer.from((await page.evaluate(() => {
    const canvas = Object.assign(document.createElement("canvas"), { width: 160, height: 160 });
    canvas.getContext("2d").fillRect(0, 0, 160, 160);
    return canvas.toDataURL("image/jpeg");
  })).split(",")[1], "base64");
  const about = await daemon.ask("box"), regions = [];
  await page.route("**/api/v1/box", (route) => route.fulfill({ json: { ...about, cameras: about.cameras.map((c) => ({ ...c, width: 4 * c.width, height: 4 * c.height })), lamps: about.lamps.map((lamp) => ({ ...lamp, steps: 7 })) } }));
  await page.route("**/live?*", async (route) => {
    const region = new URL(route.request().url()).searchParams.get("region");
    if (!region)
      return route.fallback();
    regions.push(region);
    return route.fulfill({ contentType: "image/jpeg", headers: { "X-Ttfbox-Live": "camera" }, body: flat });
  });
  await page.reload();
  const meter = page.locator(".meter");
  await until("the number", async () => await meter.textContent() === "0.0");
  const { width, height } = about.cameras[0];
  assert.deepEqual(regions, [`${2 * width - 80},${2 * height - 80},160,160`], "the middle, of four times as many pixels");
  await page.locator(".viewer svg").focus();
  await page.keyboard.press("ArrowRight");
  await until("another place is looked at", () => regions.at(-1) === `${2 * width - 80 + 32},${2 * height - 80},160,160`);
  await page.getByText("of the best so far, 0.0").waitFor();
  const lamp = page.getByRole("slider", { name: "Lamp left", exact: true });
  await lamp.press("ArrowRight");
  assert.equal(await lamp.getAttribute("aria-valuetext"), "14.3 %", "of a lamp of seven levels, one");
  await lamp.press("End");
  assert.equal(await lamp.getAttribute("aria-valuetext"), "100 %", "and all");
  await page.unroute("**/live?*");
  await page.unroute("**/api/v1/box");
  await page.reload();
  await page.getByText("From the camera, now.").waitFor();
}

async function a_charts_corners_go_into_the_calibration() {
  await page.getByRole("button", { name: "Mark the chart's corners" }).click();
  const svg = page.locator(".viewer svg"), picked = page.locator("pre[aria-label^='What was picked']");
  await svg.scrollIntoViewIfNeeded();
  const box = await svg.boundingBox();
  for (const [u, v] of [[0.2, 0.2], [0.8, 0.2], [0.8, 0.8], [0.2, 0.8]])
    await page.mouse.click(box.x + box.width * u, box.y + box.height * v);
  const corners = (await picked.textContent()).match(/^# corners of the chart: (\d+),(\d+) (\d+),(\d+) (\d+),(\d+) (\d+),(\d+)$/m).slice(1).map(Number);
  assert.ok(corners[0] < corners[2] && corners[1] < corners[5] && corners[0] === corners[6] && corners[1] === corners[3], `clockwise from the top left: ${corners}`);
  await go("Calibrate");
  await page.getByText("By hand, at the box").click();
  await page.getByText("ttfbox calibrate chart").waitFor();
  assert.match(await picked.textContent(), /^# corners of the chart: \d/m);
}

/* A box in daylight is not dark: refused. In its place one that is, with a white target in it. */
async function a_calibration_is_made_and_used() {
  const begin = async (what) => {
    browser.expected = AWAY;
    assert.equal(await daemon.kill("SIGTERM"), 0, "the daemon ends cleanly");
    daemon.configure(what);
    await daemon.start();
    await until("it is there again", async () => (await state()) === "Idle", 30000);
    browser.expected = null;
  };
  const fill = async () => {
    await page.getByLabel("Name of the calibration").fill("from-the-page");
    await page.getByLabel("Frames of a step").fill("8");
    await page.getByLabel("Exposure, ms").fill("20");
  };
  await fill();
  await page.getByRole("button", { name: "Take the dark" }).click();
  await page.getByText(/The dark was refused: .*the frames are not dark/).waitFor();
  await begin("sim.scene.name: white");
  await page.reload();
  await fill();
  await page.getByRole("button", { name: "Take the dark" }).click();
  await page.getByText("The dark of from-the-page is there.").waitFor();
  const row = page.getByRole("row", { name: /^from-the-page/ }), use = row.getByRole("button", { name: "Use it" });
  const dark = await daemon.ask("calibrations"), under_way = { ...dark, step: { ...dark.step, part: "flat", state: "under-way" } };
  let looks = 0;
  browser.expected = AWAY;
  await page.route("**/calibrations", (route) => ++looks > 4 ? route.fallback() :
    looks === 1 ? route.fulfill({ status: 503, json: { error: "too much is asked at once" } }) : route.fulfill({ json: under_way }));
  await page.getByRole("button", { name: "Take the flat" }).click();
  await page.getByText("too much is asked at once").waitFor();
  await use.focus();
  await until("it is looked at all the same", () => looks >= 4);
  assert.ok(await use.evaluate((e) => e === document.activeElement), "what is listed stays where it is while a step is under way");
  await page.getByText("The flat of from-the-page is there.").waitFor();
  assert.equal(await page.getByText("too much is asked at once").count(), 0, "that a look failed is old");
  browser.expected = null;
  await page.unroute("**/calibrations");
  assert.match(await row.textContent(), /dark: 8 frames of 20 ms.*flat: 8 frames of 20 ms, target 0\.\d+/);
  await use.click();
  await row.getByText("in use").waitFor();
  assert.equal((await daemon.ask("calibrations")).used, "from-the-page");
  await browser.everywhere("calibrate", shots);
  await page.getByRole("button", { name: "Use none" }).click();
  await use.waitFor();
  assert.equal((await daemon.ask("calibrations")).used, undefined);
  const drop = row.getByRole("button", { name: "Delete from-the-page" });
  await drop.click();
  await browser.everywhere("calibrate-delete", shots);
  await page.getByRole("button", { name: "Keep it" }).click();
  assert.equal((await daemon.ask("calibrations")).calibrations.length, 1, "kept");
  await drop.click();
  await page.getByRole("button", { name: "Delete it" }).click();
  await page.getByText("None yet.").waitFor();
  assert.deepEqual((await daemon.ask("calibrations")).calibrations, []);
  await begin("sim.ambient: 10");
}

async function a_run_is_started_from_the_wizard() {
  await go("Plan");
  await page.getByText("This box can do it").waitFor();
  await page.getByLabel("Something else").check();
  await page.getByLabel("A picture every", { exact: true }).fill("1");
  await page.getByLabel("A picture every, unit").selectOption("s");
  await page.getByLabel("For", { exact: true }).fill(String(SLOTS));
  await page.getByLabel("For, unit").selectOption("s");
  await page.getByLabel("Title").fill("A capture from the page");
  await page.getByLabel("Name of plan and dataset").fill(NAME);
  await page.getByLabel("Lamps burn").selectOption("none"); /* as they were in live view */
  await page.getByLabel("only the region").check();
  await page.getByLabel("watch the reference patch").check();
  const exposure = page.getByLabel("Exposure, ms"), seen = page.getByText("Live view's last picture: ");
  await exposure.fill("0.01");
  assert.match(await page.getByText(/This plan exposes [\d.e+]+ times less than the picture in live view/).textContent(), /too dark/);
  await exposure.fill("10000");
  assert.match(await page.getByText(/This plan exposes [\d.e+]+ times more than the picture in live view/).textContent(), /clipped/);
  await page.getByLabel("Lamps burn").selectOption("continuous");
  await page.getByText(/This plan exposes .* under other lamps: look there again/).waitFor();
  await page.getByRole("button", { name: "Take it over" }).click();
  await page.getByText("than the picture in live view").waitFor({ state: "detached" });
  const ms = Number(await exposure.inputValue()), said = (await seen.textContent()).match(/: ([\d.]+) (ms|seconds?) at gain/);
  assert.ok(Math.abs(ms / (said[1] * (said[2] === "ms" ? 1 : 1000)) - 1) < 0.01, `live view's exposure is in the plan: ${ms} ms, ${said[0]}`);
  await page.getByText("The plan, as the box reads it").click();
  const text = await page.getByLabel("The plan's text").inputValue();
  assert.match(text, new RegExp(`count: ${SLOTS}\\n`));
  assert.match(text, /region: \{x: /);
  const begin = page.getByLabel("Begin (empty: at once)");
  await page.getByText(/^39 seconds, until .* if begun now$/).waitFor();
  await begin.fill("2031-01-01T06:00");
  await page.getByText(/^39 seconds, from Jan 1, 2031, 6:00:00.AM until Jan 1, 2031, 6:00:39.AM$/).waitFor();
  await page.getByText("This box can do it.").evaluate((e) => (e.kept = true)); /* of this plan: what was typed before is checked */
  await begin.fill("2031-01-01T07:00");
  await page.getByText(/^39 seconds, from Jan 1, 2031, 7:00:00.AM until/).waitFor();
  assert.match(await page.getByLabel("The plan's text").inputValue(), /^start: 2030-12-31T18:00:00Z$/m, "of this device's zone, as one that needs none");
  assert.ok(await page.getByText("This box can do it.").evaluate((e) => e.kept), "a verdict that stays is not read out again");
  for (const far of ["202608-11-27T08:00", "12026-11-27T08:00"]) { /* what Chromium's field of a year lets one type */
    await begin.fill(far);
    await page.getByText("This box cannot do it as it stands.").waitFor();
    assert.ok(await begin.evaluate((e) => e.validity.rangeOverflow), "the field refuses it by itself");
    assert.ok(await page.getByRole("button", { name: "Save and start" }).isDisabled(), "no other plan is begun in its place");
    await begin.fill("");
    await page.getByText(/^39 seconds, until .* if begun now$/).waitFor();
  }
  await until("the box's verdict is of this plan", async () => /Pictures40/.test((await page.locator("dl.facts").first().textContent()).replace(/\s/g, "")));
  await browser.everywhere("plan", shots);
  await page.getByRole("button", { name: "Save and start" }).click();
  await until("it captures", async () => /^Capturing \d+\/40/.test(await state()), 60000);
}

async function that_lamps_warm_up_is_said() {
  const words = page.getByText(/^until slot \d+ of 40; the lamps warm up$/);
  await page.route("**/api/v1/status", async (route) => {
    const status = await (await route.fetch()).json();
    await route.fulfill({ json: { ...status, run: { ...status.run, settled_in_ns: 1e12 } } });
  });
  await words.waitFor();
  await page.unroute("**/api/v1/status");
  await page.getByText(/^until slot \d+ of 40$/).waitFor();
}

async function slots_arrive_and_the_countdown_runs() {
  await page.locator(".picture img").waitFor({ state: "visible" });
  const first = await page.locator("figcaption").textContent(), to_dataset = page.getByRole("link", { name: NAME });
  await to_dataset.focus();
  const head = await page.evaluate(() => {
    globalThis.heard = [];
    new MutationObserver(() => globalThis.heard.push(document.getElementById("heard").textContent)).observe(document.getElementById("heard"), { childList: true, characterData: true, subtree: true });
    return document.getElementById("state").textContent;
  });
  await until("another picture", async () => (await page.locator("figcaption").textContent()) !== first);
  await until("another slot", async () => (await state()) !== head);
  assert.deepEqual(await page.evaluate(() => [document.getElementById("heard").textContent, globalThis.heard]), ["Capturing", []], "that a slot is done is not read out each time");
  assert.ok(await to_dataset.evaluate((e) => e === document.activeElement), "who has reached a link by keyboard is still there");
  const known = (await page.locator(".now dl.facts").allTextContents()).join(" ");
  for (const what of [/Time left[\d.]+ seconds?, until /, /Disk[\d.]+ [kMGT]?B free of [\d.]+ [kMGT]?B/, /Room for[\d,]+ more slots?/, /Interval1 second/])
    assert.match(known, what);
  const { slot_bytes, reserve_bytes } = await run();
  assert.equal(reserve_bytes, 256 << 20, "what a plan leaves free unless it says otherwise");
  await page.route("**/api/v1/status", async (route) => {
    const status = await (await route.fetch()).json();
    await route.fulfill({ json: { ...status, disk: { ...status.disk, free_bytes: reserve_bytes + 3 * slot_bytes - 1 } } });
  });
  await page.getByText(/^2 more slots/).waitFor(); /* beyond the reserve: others would be missed */
  await page.unroute("**/api/v1/status");
  await go("Datasets");
  const counted = page.locator(".card", { hasText: NAME }).getByText(/^\d+ slots?: /), before = await counted.textContent();
  await page.getByRole("link", { name: NAME }).focus();
  await until("the list counts on", async () => (await counted.textContent()) !== before);
  await go("Now");
  assert.match(await page.title(), /^Capturing \d+\/40 – ttfbox$/);
  assert.equal(await page.getByText(/This picture is (nearly black|clipped)/).count(), 0, "frames exposed as live view was are neither black nor clipped");
  assert.match(await page.locator("#countdown").textContent(), /^(\d+:\d\d|now)$/);
}

// Of all pages one listens to the box; the others hear it from that one.
async function a_second_page_asks_for_no_second_stream() {
  let streams = 0;
  browser.context.on("request", (r) => r.url().endsWith("/events") && !r.url().includes("/datasets/") && streams++);
  const other = await browser.context.newPage();
  await other.goto(`${daemon.url}/`);
  await other.locator('html[data-ready="yes"]').waitFor();
  await until("the other page counts too", async () => /^(Capturing|Done)/.test(await other.locator("#state").textContent()));
  const before = await other.locator("#state").textContent();
  if (before.startsWith("Capturing"))
    await until("it hears of slots", async () => (await other.locator("#state").textContent()) !== before);
  assert.equal(streams, 0, "one stream is enough for a browser");
  await other.close();
}

async function a_killed_daemon_is_missed_and_found_again() {
  const { done } = await run();
  browser.expected = AWAY;
  await daemon.kill("SIGKILL");
  await until("connection lost", async () => (await state()) === "Connection lost", 15000);
  assert.ok(await page.getByText("the box does not answer").isVisible());
  assert.match(await page.title(), /^Connection lost/);
  await daemon.start();
  await until("it is there again", async () => /^(Capturing|Preparing|Done|Failed)/.test(await state()), 30000);
  await until("it goes on", async () => (await run()).done > done, 60000);
  browser.expected = null;
  await until("it is done", async () => (await state()) === "Done", 90000);
  const { results } = await run();
  assert.equal(Object.values(results).reduce((a, b) => a + b), SLOTS, "every slot has its record");
  await browser.everywhere("now-done", shots);
  await browser.context.clearCookies(); /* who comes now, and is asked for the token, sees what was captured: no slot will come any more */
  browser.expected = AWAY;
  let asked = 0; /* once in vain */
  await page.route("**/latest", (route) => asked++ ? route.fallback() : route.fulfill({ status: 503, json: { error: "too much is asked at once" } }));
  await page.reload();
  await page.getByRole("textbox", { name: "Token" }).fill(daemon.token);
  await page.getByRole("button", { name: "Use it" }).click();
  await page.getByRole("img", { name: /^The last picture: slot/ }).waitFor();
  const enough = asked;
  for (let looks = 0; looks < 2; looks++)
    await page.waitForResponse("**/api/v1/status");
  assert.ok(enough > 1 && asked === enough, "it is asked for until it is there, and no longer");
  await page.unroute("**/latest");
  browser.expected = null;
}

async function the_dataset_is_scrubbed_and_charted() {
  await go("Datasets");
  await page.getByRole("link", { name: NAME }).waitFor();
  await browser.everywhere("datasets", shots);
  browser.expected = AWAY;
  let failed = 0;
  await page.route("**/charts", (route) => failed++ ? route.fallback() : route.fulfill({ status: 503, json: { error: "too much is asked at once" } }));
  await page.getByRole("link", { name: NAME }).click();
  await page.getByText("too much is asked at once").waitFor();
  const caption = page.locator(".timeline figcaption"), img = page.locator(".timeline .picture img");
  await until("the newest slot is shown", async () => (await caption.textContent()).startsWith(`Slot ${SLOTS - 1}`)); /* of a dataset that changes no more, after charts that did not come */
  await page.getByRole("region", { name: "Events, newest first" }).getByText(/ · resume$/).first().waitFor(); /* what failed is asked for again, and that, too */
  browser.expected = null;
  await page.unroute("**/charts");
  await page.getByLabel("Slot", { exact: true }).last().focus();
  await page.keyboard.press("Home");
  assert.match(await caption.textContent(), /^Slot 0\b/);
  for (let slot = 0, seen = 0; seen < 2; slot++) { /* on a machine that is very busy one may be missed */
    assert.ok(slot < SLOTS, "two slots have pictures");
    const text = await caption.textContent();
    assert.match(text, new RegExp(`^Slot ${slot}\\b`));
    if (!text.includes("without a picture")) {
      await until(`the picture of ${text}`, () => img.evaluate((e, end) => e.complete && e.naturalWidth > 0 && e.src.endsWith(end), `/thumbs/${slot}`));
      seen++;
    }
    await page.keyboard.press("ArrowRight");
  }
  await page.keyboard.press("Home");
  for (const title of ["Mean level", "Reference level", "Slot error", "Temperature", "Humidity", "Lamp hours"])
    assert.ok(await page.locator(".plot", { hasText: title }).locator("svg path").first().getAttribute("d"), `a line of ${title}`);
  const lamps = await page.locator(".plot", { hasText: "Lamp hours" }).locator("svg").getAttribute("aria-label");
  const burned = Number(lamps.match(/left from [\d.]+ to [\d.]+ (?:s|min), last ([\d.]+)/)[1]) * (/ min,/.test(lamps) ? 60 : 1);
  const { captured = 0, partial = 0 } = (await run()).results, lit = captured + partial; /* of the others, the program did not run for most */
  assert.ok(burned > lit - 3 && burned < SLOTS + 5, `lamps that burned all the time did so for ${lit} s to ${SLOTS} s, not for the exposures alone: ${lamps}`);
  const reference = await page.locator(".plot", { hasText: "Reference level" }).locator("svg").getAttribute("aria-label");
  assert.match(reference, /main from 0\.\d+ to 0\.\d+ value/);
  for (const label of await page.locator(".plot svg text[text-anchor=end]").allTextContents())
    assert.ok(label.length <= 9, `an axis has room for ${label}`);
  const chart = page.locator(".plot", { hasText: "Slot error" });
  await chart.getByText("As a table").click();
  await until("the table has every slot", async () => await chart.locator("tbody tr").count() === SLOTS);
  await page.getByLabel("Note", { exact: true }).fill("The door was open a moment <b>here</b>");
  await page.getByLabel("By", { exact: true }).fill("web test");
  await page.getByLabel("About").selectOption("slot");
  await page.getByRole("button", { name: "Add the note" }).click();
  await page.getByText("The door was open a moment <b>here</b>").waitFor();
  assert.match(await page.locator(".notes").first().textContent(), /web test · slots 0/);
  await page.evaluate(() => {
    const get = HTMLCanvasElement.prototype.getContext;
    globalThis.contexts = [];
    HTMLCanvasElement.prototype.getContext = function (kind, ...args) {
      const context = get.call(this, kind, ...args);
      if (kind === "webgl2")
        globalThis.contexts.push(context);
      return context;
    };
  });
  await page.getByRole("button", { name: "Load the texture" }).click();
  await page.getByLabel("Pixel x").fill("3");
  await page.getByLabel("y", { exact: true }).fill("5");
  await page.keyboard.press("Enter");
  await page.getByText("Pixel 3, 5 over").waitFor();
  const life = await page.locator("figure", { hasText: "Pixel 3, 5 over" }).locator("tbody tr").evaluateAll((rows) => rows.map((row) => Number(row.cells[2].textContent)));
  assert.ok(life.length > 2 && life.every((green) => green > 0), `chosen while pictures come, none of them is shown as black: ${life}`);
  await browser.everywhere("dataset", shots);
}

/* As the box's own process makes it; the page hears of it by an event. */
async function the_preview_is_beside_what_was_captured() {
  const card = page.locator("section", { has: page.getByRole("heading", { name: "Preview of a synthesis" }) });
  assert.ok(!await card.isVisible(), "nothing is shown of a preview that is not there");
  const come_back = () => page.evaluate(() => document.dispatchEvent(new Event("visibilitychange")));
  await page.route("**/preview", (route) => route.fulfill({ json: { state: "failed", why: "there was no room", frames: [] } }));
  await come_back();
  await card.getByText("The last try failed: there was no room.").waitFor();
  assert.equal(await card.getByRole("button").count(), 0, "of a preview that failed there is nothing to play");
  await page.unroute("**/preview");
  await page.route("**/preview", (route) => route.fulfill({ json: { state: "failed", why: "only raw frames: develop the dataset first", tried_images: 0, frames: [] } }));
  await come_back();
  await card.getByText("There is none: only raw frames: develop the dataset first.", { exact: true }).waitFor();
  await page.unroute("**/preview");
  await come_back();
  await card.waitFor({ state: "hidden" });
  execFileSync(previewer, ["--folder", "data", "--ttfbox", ttfbox, "--room", "1MB", "--time", "5s", "--eager", "--once"], { stdio: "pipe" });
  await card.waitFor({ state: "visible" });
  const made = await daemon.ask(`datasets/${NAME}/preview`), { frames, width } = made, strip = card.getByRole("group", { name: /captured above, synthesized below/ });
  assert.equal(await strip.getByRole("button").count(), Math.min(10, frames.length));
  for (const [at, frame] of [[0, frames[0]], [-1, frames.at(-1)]]) {
    const moment = strip.getByRole("button").nth(at), [captured, grown] = await moment.locator("img").evaluateAll((all) => all.map((e) => e.getAttribute("src")));
    assert.ok(captured.endsWith(`/thumbs/${frame.slot}`) && grown.endsWith(`/preview/${frame.path}`), `slot ${frame.slot}: ${captured} above ${grown}`);
    await moment.click();
    await card.getByText(`Slot ${frame.slot}`, { exact: true }).waitFor();
    for (const [name, end] of [[/^Captured/, `/thumbs/${frame.slot}`], [/^Synthesized/, frame.path]])
      await until(`${name} of slot ${frame.slot}`, () => card.getByRole("img", { name }).evaluate((e, src) => e.complete && e.naturalWidth > 0 && e.src.endsWith(src), end));
  }
  await until("every picture of the strip", () => strip.locator("img").evaluateAll((all) => all.every((e) => e.complete && e.naturalWidth > 0)));
  await strip.getByRole("button").nth(1).click();
  const moment = await card.getByText(/^Slot \d+$/).textContent(), { slot } = frames.find((frame) => `Slot ${frame.slot}` === moment), at = frames.findIndex((frame) => frame.slot === slot);
  await page.route("**/preview", (route) => route.fulfill({ json: { ...made, frames: frames.slice(1) } }));
  await come_back();
  await until("another preview is there", async () => await card.getByRole("slider").getAttribute("max") === String(frames.length - 2));
  assert.equal(await card.getByText(/^Slot \d+$/).textContent(), moment, `who looks at one moment goes on looking at it: it was frame ${at}`);
  await page.unroute("**/preview");
  await come_back();
  await until("the preview is there again", async () => await card.getByRole("slider").getAttribute("max") === String(frames.length - 1));
  const [download] = await Promise.all([page.waitForEvent("download"), card.getByRole("link", { name: "Download the preview as a video" }).click()]);
  assert.equal(download.suggestedFilename(), `${NAME}-preview.avi`);
  await download.saveAs("preview.avi");
  assert.equal(readFileSync("preview.avi").subarray(8, 12).toString(), "AVI ");
  await page.getByRole("button", { name: "Load it again" }).click();
  const both = page.locator(".panel canvas.stage");
  await page.getByRole("heading", { name: "synthesized from it" }).waitFor();
  await page.getByText(new RegExp(`^${frames.length} slots of ${SLOTS},`)).waitFor();
  assert.equal(await both.count(), 2);
  assert.deepEqual(await page.evaluate(() => globalThis.contexts.map((gl) => gl.isContextLost())), [true, false, false], "what the graphics card held for the first is given back");
  await page.getByLabel("Time", { exact: true }).focus();
  await page.keyboard.press("End");
  for (const panel of await both.all())
    assert.match(await panel.getAttribute("aria-label"), new RegExp(`slot ${frames.at(-1).slot},`), `both show the same moment, ${width} pixels wide`);
  await browser.everywhere("dataset-preview", shots);
}

async function what_is_downloaded_verifies() {
  const [download] = await Promise.all([page.waitForEvent("download"), page.getByRole("link", { name: "Download as a tar" }).click()]);
  assert.equal(download.suggestedFilename(), `${NAME}.tar`);
  await download.saveAs("home.tar");
  execFileSync("tar", ["-xf", "home.tar"]);
  execFileSync(ttfbox, ["verify", NAME], { stdio: "pipe" });
  const note = execFileSync("tail", ["-n", "1", `${NAME}/notes.jsonl`], { encoding: "utf8" });
  assert.equal(JSON.parse(note).author, "web test");
}

async function a_stopped_box_says_stopped() {
  await go("Plan");
  await page.getByText("This box can do it").waitFor();
  const text = page.getByLabel("The plan's text");
  await page.getByRole("row", { name: NAME }).getByRole("button", { name: "Open" }).click();
  await text.waitFor({ state: "visible" });
  assert.match(await text.inputValue(), /title: "A capture from the page"/, "what is opened is seen");
  await page.getByLabel("Cracking paint").check();
  assert.match(await page.getByLabel("Name of plan and dataset").inputValue(), new RegExp(`^cracking-paint-${(await page.evaluate(() => new Date().toLocaleDateString("sv")))}$`), "the day is this device's");
  await page.getByLabel("Lamps burn").selectOption("none");
  await page.getByLabel("Name of plan and dataset").fill(NAME);
  const save = page.getByRole("button", { name: "Save only" });
  await until("the button", () => save.isEnabled());
  await save.click();
  await page.getByRole("heading", { name: `Replace the plan ${NAME}?` }).waitFor();
  await page.getByRole("button", { name: "Keep it" }).click();
  const kept = await (await fetch(`${daemon.url}/api/v1/plans/${NAME}`, { headers: { Authorization: `Bearer ${daemon.token}` } })).text();
  assert.match(kept, /A capture from the page/, "another plan is not replaced unasked");
  await page.getByLabel("Name of plan and dataset").fill("stopped");
  await page.getByLabel("Title").fill("A title that comes later");
  assert.equal(await page.getByLabel("Name of plan and dataset").inputValue(), "stopped", "a name that somebody gave stays");
  await save.click();
  await page.getByText("The plan stopped is on the box.").waitFor();
  await page.getByLabel("Exposure, ms").fill("0.1"); /* mains: what the wizard begins with snaps it to 10 ms */
  await page.getByLabel("Mains").selectOption("none");
  await until("the button", () => page.getByRole("button", { name: "Save and start" }).isEnabled());
  await page.waitForTimeout(600); /* the verdict of what was just typed */
  await page.getByRole("button", { name: "Save and start" }).click();
  await until("it captures", async () => /^Capturing/.test(await state()), 60000);
  const black = page.getByText("This picture is nearly black");
  await black.waitFor();
  await black.evaluate((e) => (e.firstChild.kept = true));
  const slot = await page.locator("figcaption").textContent();
  await until("another picture", async () => (await page.locator("figcaption").textContent()) !== slot);
  await page.waitForTimeout(300); /* it is looked at after it is named */
  assert.ok(await black.evaluate((e) => e.firstChild.kept), "what was said of one picture is not said again of the next");
  browser.expected = AWAY;
  await page.route("**/latest", (route) => route.fulfill({ status: 404, json: { error: "there is no picture" } }));
  await black.waitFor({ state: "hidden" }); /* nothing is said of a picture that is not there */
  await page.unroute("**/latest");
  await black.waitFor();
  browser.expected = null;
  await page.getByRole("button", { name: "Stop", exact: true }).focus();
  await page.keyboard.press("Enter");
  await browser.accessible("the question");
  await page.getByRole("button", { name: "Stop it" }).click();
  await until("stopped", async () => /^Stopped/.test(await state()), 30000);
  assert.match(await page.locator("#countdown").textContent(), /^Stopped/);
  const go_on = page.getByRole("button", { name: "Go on" });
  await go_on.waitFor();
  assert.ok(await go_on.evaluate((e) => e === document.activeElement), "who stopped it by keyboard is at what can be done next");
  await browser.everywhere("now-stopped", shots);
  await page.getByRole("button", { name: "Go on" }).click();
  await until("it goes on", async () => /^Capturing/.test(await state()), 60000);
}

async function nothing_is_calibrated_beside_a_run() {
  await go("Calibrate");
  await page.getByText("the camera belongs to it").waitFor();
  assert.ok(await page.getByRole("button", { name: "Take the dark" }).isDisabled(), "nothing is calibrated beside a run");
  await browser.everywhere("calibrate-busy", shots);
  for (const [status, text] of [[{ state: "waiting", run: { next: { index: 0, in_ns: 9e12 } } }, "A run waits for its start: the camera belongs to it"], [{ state: "waiting", why: "for the plan's file" }, ""]]) {
    await page.route("**/api/v1/status", (route) => route.fulfill({ json: { alarms: [], ...status } }));
    if (text)
      await page.getByText(text).waitFor();
    await until(`${JSON.stringify(status)}: may a step be taken?`, async () => await page.getByRole("button", { name: "Take the dark" }).isDisabled() === !!text);
    await page.unroute("**/api/v1/status");
  }
}

async function an_alarm_is_read_out_once() {
  await go("Now");
  await page.route("**/api/v1/status", (route) => route.fulfill({ json: { state: "idle", alarms: [{ text: "the lamp is too hot" }] } }));
  const alarm = page.getByRole("alert").getByText("the lamp is too hot");
  await alarm.waitFor();
  await alarm.evaluate((e) => (e.kept = true));
  for (let looks = 0; looks < 2; looks++)
    await page.waitForResponse("**/api/v1/status");
  assert.ok(await alarm.evaluate((e) => e.kept), "an alarm is read out once");
  await browser.accessible("an alarm");
  await page.unroute("**/api/v1/status");
}

const the_daemon_ends_cleanly = async () => assert.equal(await daemon.kill("SIGTERM"), 0, "the daemon ends cleanly");
await browser.does([nothing_is_shown_without_the_token, a_region_is_drawn_in_live_view, a_button_stays_while_pictures_come, live_view_asks_for_one_at_a_time, focus_is_measured_in_the_cameras_own_pixels, a_charts_corners_go_into_the_calibration, a_calibration_is_made_and_used, a_run_is_started_from_the_wizard, that_lamps_warm_up_is_said, slots_arrive_and_the_countdown_runs,
  a_second_page_asks_for_no_second_stream, a_killed_daemon_is_missed_and_found_again, the_dataset_is_scrubbed_and_charted, the_preview_is_beside_what_was_captured, what_is_downloaded_verifies, a_stopped_box_says_stopped,
  nothing_is_calibrated_beside_a_run, an_alarm_is_read_out_once],
  { shots, last: the_daemon_ends_cleanly, over: () => daemon.child.kill("SIGKILL") });
