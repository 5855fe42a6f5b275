// SPDX-License-Identifier: Apache-2.0
// serve.mjs TTFBOX [SHOTS]: `ttfbox serve` over data/, made by serve.sh: nobody tells this page of anything, it has to look.
import assert from "node:assert/strict";
import { spawn } from "node:child_process";
import { appendFileSync, cpSync, mkdirSync, readFileSync, rmSync, writeFileSync } from "node:fs";
import { Browser, DESK, PHONE, until } from "./browser.mjs";
import { free_port } from "./daemon.mjs";

const [program, shots] = process.argv.slice(2);
const SLOTS = 10000, MISSED = SLOTS / 16 * 3, REFUSED = /Failed to load resource|ERR_CONNECTION/;
const port = await free_port(), url = `http://127.0.0.1:${port}`;
const lines = readFileSync("all/records.jsonl", "utf8").split("\n").filter(Boolean);
const before = lines.findIndex((line) => JSON.parse(line).type === "slot"), HAS = 12;

let server;
async function serve() {
  server = spawn(program, ["serve", "data", "--listen", `127.0.0.1:${port}`], { stdio: "ignore" });
  await until("it serves", async () => (await fetch(`${url}/api/v1/health`)).ok);
}

function dataset_with(slots, uuid) {
  rmSync("data/growing", { recursive: true, force: true });
  mkdirSync("data/growing");
  const about = JSON.parse(readFileSync("all/dataset.json", "utf8"));
  writeFileSync("data/growing/dataset.json", JSON.stringify({ ...about, uuid }));
  cpSync("all/frames", "data/growing/frames", { recursive: true });
  writeFileSync("data/growing/records.jsonl", lines.slice(0, before + slots).map((line) => `${line}\n`).join(""));
}

dataset_with(HAS, "11111111-1111-4111-8111-111111111111");
await serve();
const browser = await Browser.start({ may: (u) => u.startsWith(`${url}/`) });
const { page } = browser;
const caption = page.locator(".timeline figcaption"), img = page.locator(".timeline .picture img"), slider = page.getByLabel("Slot", { exact: true });
const loaded = (slot) => until(`the picture of slot ${slot}`, () => img.evaluate((e, end) => !e.hidden && e.complete && e.naturalWidth > 0 && e.src.endsWith(end), `/thumbs/${slot}`));
const open = async (name) => {
  await page.goto(`${url}/#/data/${name}`);
  await page.getByRole("heading", { level: 1, name }).waitFor();
};

async function what_people_wrote_is_text_and_has_its_place() {
  await page.goto(`${url}/`);
  await page.getByText("Grass <img src=x onerror=alert(1)>").first().waitFor();
  await until("it says what is seen", async () => (await page.title()) === "Datasets – ttfbox");
  await browser.everywhere("serve-datasets", shots);
  await open("grass");
  await until("it says what is seen", async () => (await page.title()) === "grass – ttfbox");
  const said = page.locator(".notes .said");
  assert.match(await said.innerText(), /^first line <b>not bold<\/b>\nsecond line, and x{400}$/, "its lines are lines");
  await page.getByText("Jo <script>alert(1)</script> · slots 1 · exclude").waitFor();
  await loaded(2);
  await page.locator(".plot svg").first().waitFor();
  await browser.everywhere("serve-dataset", shots);
  await open("a-name-that-is-as-long-as-names-of-datasets-may-be_0123456789.ab");
  await loaded(2);
  await browser.everywhere("serve-long-name", shots);
}

async function each_of_ten_thousand_slots_can_be_reached() {
  const begun = Date.now();
  await open("long");
  await until("the newest slot", async () => (await caption.textContent()).startsWith("Slot 9,999"), 60000);
  await loaded(9999);
  console.log(`  ten thousand slots are there after ${((Date.now() - begun) / 1000).toFixed(1)} s`);
  await page.getByText(`${MISSED.toLocaleString("en-US")} slots have no picture.`).waitFor();
  const strip = page.getByRole("group", { name: "Pictures spread over the whole time" });
  await strip.scrollIntoViewIfNeeded();
  await until("a point of which the first slot was missed has a picture all the same", () => strip.locator("img").evaluateAll((all) => all.length === 10 && all.every((e) => e.complete && e.naturalWidth > 0)));
  await slider.focus();
  await page.keyboard.press("Home");
  await page.getByText("No picture of this slot").waitFor();
  for (const slot of [1, 2, 3]) {
    await page.keyboard.press("ArrowRight");
    assert.match(await caption.textContent(), new RegExp(`^Slot ${slot}, about `), "each slot, not each sixteenth");
  }
  await loaded(3);
  await slider.fill("4567");
  await loaded(4567);
  assert.match(await caption.textContent(), /^Slot 4,567, about /);
  assert.match(await slider.getAttribute("aria-valuetext"), /^Slot 4,567, about /);
  await slider.fill("4560");
  assert.match(await caption.textContent(), /^Slot 4,560, [A-Z]/, "of a point's first slot the time is known");
  await page.getByRole("button", { name: "Play", exact: true }).first().click();
  assert.equal(await caption.getAttribute("aria-live"), "off", "seven captions a second are not read out");
  const played = new Set();
  await until("pictures of further points", async () => played.add((await caption.textContent()).match(/\d[\d,]*\d/)[0].replace(",", "")).size > 3);
  await page.getByRole("button", { name: "Pause", exact: true }).first().click();
  assert.equal(await caption.getAttribute("aria-live"), "polite");
  assert.ok([...played].every((slot) => slot === "4560" || slot % 16 === 3), `of each point its first picture: ${[...played]}`);
  for (const [title, wanted] of [["Mean level", ["main"]], ["Lamp hours", ["left", "right"]]]) {
    const names = await page.locator(".plot", { hasText: title }).locator("svg text[y='14'], svg text[y='32']").allTextContents();
    assert.deepEqual(names.slice(1).sort(), wanted, `${title}: the legend has each line's name, once`);
  }
  await browser.everywhere("serve-long", shots);
  await page.setViewportSize(PHONE);
  await until("letters of charts that were drawn on a desk can be read on a phone", () => page.locator(".plot svg text").evaluateAll((all) => all.length > 0 && all.every((e) => e.getBoundingClientRect().height >= 10)));
  await page.setViewportSize(DESK);
}

/* Nothing is taken from under somebody's fingers because a slot came. */
async function a_dataset_grows_under_ones_eyes() {
  let has = HAS;
  const add = (slots) => {
    appendFileSync("data/growing/records.jsonl", lines.slice(before + has, before + has + slots).map((line) => `${line}\n`).join(""));
    has += slots;
  };
  const grow = async (slots) => {
    add(slots);
    await page.getByText(`${has}: ${has} captured`).waitFor();
  };
  await page.goto(`${url}/#/data`);
  for (const name of ["grass", "growing"]) {
    const link = page.getByRole("link", { name, exact: true });
    await link.focus();
    add(1);
    await page.getByText(`${has} slots: ${has} captured`, { exact: true }).waitFor();
    assert.ok(await link.evaluate((e) => e === document.activeElement), `in the list the link of ${name} stays where it is`);
  }
  await open("growing");
  await until("the newest slot", async () => (await caption.textContent()).startsWith(`Slot ${has - 1},`));
  const chart = page.locator(".plot", { hasText: "Mean level" }), table = page.getByRole("region", { name: "Mean level as a table" });
  await chart.getByText("As a table").click();
  await until("its rows", async () => await table.locator("tbody tr").count() === has);
  for (const [what, place] of [["the download", page.getByRole("link", { name: "Download as a tar" })], ["the table", table], ["a picture of the strip", page.locator(".strip button").nth(4)]]) {
    await place.focus();
    await grow(1);
    await until("the newest slot", async () => (await caption.textContent()).startsWith(`Slot ${has - 1},`));
    assert.ok(await place.evaluate((e) => e === document.activeElement), `${what} stays where it is`);
  }
  await until("its rows", async () => await table.locator("tbody tr").count() === has);
  appendFileSync("data/growing/events.jsonl", `${JSON.stringify({ boot: 0, at_boot_ns: 1, kind: "door", text: "opened between two slots" })}\n`);
  await page.getByText("opened between two slots").waitFor();
  const about = page.getByLabel("About"), noted = () => about.evaluate((e) => e.selectedOptions[0].textContent);
  await about.selectOption("slot");
  const slot = has - 1;
  await grow(1);
  await until("the newest slot", async () => (await caption.textContent()).startsWith(`Slot ${slot + 1},`));
  assert.equal(await noted(), `slot ${slot}, chosen above`, "a note is of the slot that it was begun for");
  await slider.fill("5");
  assert.equal(await noted(), "slot 5, chosen above");
  const shown_slot = async () => Number((await caption.textContent()).match(/^Slot (\d+)/)[1]);
  await page.getByRole("button", { name: "Play", exact: true }).first().click();
  await until("pictures go by", async () => await shown_slot() !== 5);
  await page.getByRole("button", { name: "Pause", exact: true }).first().click();
  assert.equal(await noted(), "slot 5, chosen above", "what goes by while it plays is nobody's choice");
  await slider.fill("5");
  await grow(2);
  await page.waitForTimeout(300);
  assert.match(await caption.textContent(), /^Slot 5,/, "who looks at one slot goes on looking at it");
  assert.equal(await slider.getAttribute("max"), String(has - 1));

  /* A page that nobody looks at, for a week, asks for nothing. */
  let asked = 0;
  const count = (r) => /\/datasets\//.test(r.url()) && asked++;
  await page.waitForTimeout(3500); /* what was asked for already has come */
  page.on("request", count);
  const hide = (hidden) => page.evaluate((is) => {
    Object.defineProperty(document, "hidden", { get: () => is, configurable: true });
    document.dispatchEvent(new Event("visibilitychange"));
  }, hidden);
  await hide(true);
  await page.waitForTimeout(7000);
  assert.equal(asked, 0);
  await hide(false);
  await grow(1);
  page.off("request", count);
}

async function another_dataset_of_the_same_name_is_another() {
  dataset_with(HAS, "22222222-2222-4222-8222-222222222222");
  await page.getByText("22222222-2222-4222-8222-222222222222").waitFor();
  await page.getByText(`${HAS}: ${HAS} captured`).waitFor();
  await until("its newest slot", async () => (await caption.textContent()).startsWith(`Slot ${HAS - 1},`));
}

async function a_server_that_comes_back_is_found() {
  await page.getByRole("link", { name: "All datasets" }).click();
  await page.getByRole("link", { name: "growing" }).waitFor();
  browser.expected = REFUSED;
  server.kill("SIGKILL");
  await page.getByText("Connection lost: the box does not answer").waitFor();
  await page.reload().catch(() => {}); /* it is not there: what the browser shows then is no page of ours */
  await serve();
  /* the browser may still be at its own page of the error */
  await until("the page is there again", () => page.goto(`${url}/#/data`).then(() => true));
  await page.getByRole("link", { name: "growing" }).waitFor();
  server.kill("SIGKILL");
  await page.getByText("Connection lost: the box does not answer").waitFor();
  rmSync("data/growing", { recursive: true });
  await serve();
  await page.getByText("Connection lost").waitFor({ state: "hidden" });
  await page.getByRole("link", { name: "growing" }).waitFor({ state: "detached" });
  browser.expected = null;
}

await browser.does([what_people_wrote_is_text_and_has_its_place, each_of_ten_thousand_slots_can_be_reached, a_dataset_grows_under_ones_eyes,
  another_dataset_of_the_same_name_is_another, a_server_that_comes_back_is_found],
  { shots, over: () => server.kill("SIGKILL") });
