// SPDX-License-Identifier: Apache-2.0
// view.mjs FILE [SHOTS]: the file that `ttfbox view --beside` made, opened from disk as a person does.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";
import { Browser } from "./browser.mjs";

const [file, shots] = process.argv.slice(2), url = pathToFileURL(file).href, text = readFileSync(file, "utf8");
const about = JSON.parse(text.match(/id="about">([^<]*)</)[1]), first = about.panels[0];
const pictures = [...text.matchAll(/class="p0">([^<]*)</g)].map((m) => m[1]);
const X = 17, Y = 31;

// What the pictures say, by another way than the page's: drawn to a canvas.
async function life_of(browser) {
  const page = await browser.context.newPage();
  const codes = await page.evaluate(async ({ pictures, kind, x, y }) => {
    const found = [];
    for (const data of pictures) {
      const img = new Image();
      img.src = `data:image/${kind};base64,${data}`;
      await img.decode();
      const c = document.createElement("canvas").getContext("2d");
      c.drawImage(img, -x, -y);
      found.push([...c.getImageData(0, 0, 1, 1).data.slice(0, 3)]);
    }
    return found;
  }, { pictures, kind: first.kind, x: X, y: Y });
  await page.close();
  const light = (c) => (c <= 0.04045 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4);
  return codes.map((rgb) => rgb.map((c) => light(c / 255) * first.white));
}

async function the_file_shows_both_and_the_life_of_a_pixel(webgl) {
  const browser = await Browser.start({ may: (u) => u.startsWith(url), webgl });
  try {
    const { page } = browser;
    await page.goto(url);
    await page.waitForFunction(() => document.documentElement.dataset.ready === "yes");
    assert.equal(await page.locator("canvas").count(), about.panels.length);
    assert.equal(await page.locator("#plain").isVisible(), !webgl, "it says so where there is no WebGL2");
    assert.equal(await page.getByText("SIMULATED", { exact: true }).isVisible(), about.panels.some((p) => p.simulated));

    /* By keyboard and numbers alone. */
    await page.getByLabel("Pixel x").first().fill(String(X));
    await page.getByLabel("y", { exact: true }).first().fill(String(Y));
    await page.keyboard.press("Enter");
    await page.locator(".panel").first().getByText("As a table").click();
    const cells = await page.locator(".panel").first().locator("tbody tr").evaluateAll((rows) => rows.map((r) => [...r.cells].slice(1).map((c) => Number(c.textContent))));
    const wanted = await life_of(browser);
    assert.equal(cells.length, wanted.length, "every frame has its value");
    cells.forEach((row, t) => row.forEach((v, c) => assert.ok(Math.abs(v - wanted[t][c]) <= 0.0006 * first.white + 0.001 * v, `frame ${t}, channel ${c}: ${v} instead of ${wanted[t][c]}`)));

    /* A click chooses what is under it: the middle of the picture. */
    const canvas = page.locator("canvas").first(), box = await canvas.boundingBox();
    await page.getByRole("button", { name: "Show all" }).first().click();
    await canvas.click({ position: { x: box.width / 2, y: box.height / 2 } });
    await page.waitForFunction((half) => Math.abs(Number(document.querySelector('input[type="number"]').value) - half) <= 1, first.width / 2);
    await page.keyboard.press("Shift+ArrowRight");
    await page.waitForFunction((want) => Math.abs(Number(document.querySelector('input[type="number"]').value) - want) <= 1, first.width / 2 + 10);

    /* Time moves on, light grows. */
    const seen = () => canvas.screenshot().then((b) => b.toString("base64"));
    const before = await seen();
    await page.locator("#time").focus();
    await page.keyboard.press("End");
    assert.match(await page.locator("#time").getAttribute("aria-valuetext"), new RegExp(`slot ${first.slots.at(-1)}$`));
    await page.waitForTimeout(300);
    const later = await seen();
    assert.notEqual(later, before, "another moment looks otherwise");
    await page.locator("#exposure").focus();
    await page.keyboard.press("Home");
    await page.waitForTimeout(300);
    assert.notEqual(await seen(), later, "less light looks otherwise");
    await page.getByRole("button", { name: "Brightest is white" }).click();
    if (webgl) {
      const plane = await seen();
      await page.getByLabel("sphere").check();
      await page.waitForTimeout(300);
      assert.notEqual(await seen(), plane, "a sphere is no plane");
      await canvas.click({ position: { x: box.width / 2, y: box.height / 2 } });
    }
    await page.setViewportSize({ width: 320, height: 215 }); /* a desk's page at 400 % */
    await page.locator("canvas").first().scrollIntoViewIfNeeded();
    assert.equal(await page.locator("#controls").evaluate((e) => getComputedStyle(e).position), "static", "controls do not cover a low window");
    await browser.everywhere(webgl ? "view" : "view-plain", shots);
    browser.fine("the file");
    if (webgl) { /* as a phone's card does with a page that was left for a while */
      browser.expected = /CONTEXT_LOST/;
      await canvas.evaluate((e) => e.getContext("webgl2").getExtension("WEBGL_lose_context").loseContext());
      await page.getByText("The graphics card has let go of the frames: load them again.").waitFor();
    }
  } finally {
    await browser.stop();
  }
}

await the_file_shows_both_and_the_life_of_a_pixel(true);
await the_file_shows_both_and_the_life_of_a_pixel(false);
console.log("view: the file shows what the dataset holds, with WebGL2 and without");
