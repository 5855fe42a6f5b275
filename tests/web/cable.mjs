// SPDX-License-Identifier: Apache-2.0
// cable.mjs URL TOKEN_FILE: the page over a box's cable shows the box's token, once, and uses it.
import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
import { Browser, until } from "./browser.mjs";

const [url, token_file] = process.argv.slice(2);
const browser = await Browser.start({ may: (u) => u.startsWith(`${url}/`) });
const { page } = browser;
try {
  await page.goto(`${url}/`);
  await until("idle", async () => (await page.locator("#state").textContent()) === "Idle"); /* read without a token */
  const other = await page.context().newPage(); /* reads as well, and hears of the token */
  await other.goto(`${url}/#/plan`);
  await other.getByText("To save or start one, enter the token.").waitFor();
  await other.getByText("With the token, the box says here what a plan takes.").waitFor(); /* nothing is asked that would be refused */
  await page.bringToFront();
  await page.route("**/api/v1/box", async (route) => { /* a box that takes its time */
    await new Promise((go) => setTimeout(go, 1500));
    await route.continue();
  });
  await page.getByRole("link", { name: "Plan", exact: true }).click();
  assert.equal(await page.getByLabel("Title").isEnabled(), false, "nothing can be typed that would be overwritten");
  await page.getByLabel("Title").fill("Typed before the token was there");
  await page.locator("#login").click();
  await page.getByText("nobody has seen its token yet").waitFor();
  await browser.accessible("the token waits");
  /* One that the box refuses: a token is shown once, and what fails afterwards does not take it away. */
  browser.expected = /Failed to load resource/;
  await page.route("**/session/token", (route) => route.fulfill({ json: { token: "made-up-0123456789" } }));
  await page.getByRole("button", { name: "Show the token" }).click();
  await page.getByText("This browser does not know it yet").waitFor();
  assert.equal(await page.locator("dialog code").textContent(), "made-up-0123456789");
  await page.getByRole("textbox", { name: "Token" }).waitFor();
  await browser.accessible("the token is shown, and was not taken over");
  await page.unroute("**/session/token");
  browser.expected = null;
  await page.getByRole("button", { name: "Close" }).click();
  await page.locator("#login").click();
  await page.getByRole("button", { name: "Show the token" }).click();
  await page.getByText("It is shown this once").waitFor();
  assert.equal(await page.locator("dialog code").textContent(), readFileSync(token_file, "utf8").trim());
  await browser.accessible("the token is shown");
  await page.getByRole("button", { name: "Close" }).click();
  await until("it is used", async () => (await page.locator("#login").textContent()) === "Token ✓");
  assert.equal(await page.getByLabel("Title").inputValue(), "Typed before the token was there", "what was typed stays");
  await until("it can be started", () => page.getByRole("button", { name: "Save and start" }).isEnabled());
  await until("the other page knows of it", async () => (await other.locator("#login").textContent()) === "Token ✓" && !await other.getByText("To save or start one, enter the token.").isVisible());
  await other.close();
  /* Another browser at the same cable: it is asked for. */
  await page.context().clearCookies();
  await page.reload();
  await until("idle", async () => (await page.locator("#state").textContent()) === "Idle");
  await page.locator("#login").click();
  await page.getByRole("textbox", { name: "Token" }).waitFor();
  assert.equal(await page.getByText("nobody has seen its token yet").count(), 0);
  browser.fine("the page at the cable");
} finally {
  await browser.stop();
}
