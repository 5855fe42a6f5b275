// SPDX-License-Identifier: Apache-2.0
// browser.mjs: a Chromium of this machine, watched: every error it writes and every request off the origin ends the test.
import assert from "node:assert/strict";
import { mkdtempSync, readFileSync, rmSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { chromium } from "playwright-core";

const FLAGS = ["--no-sandbox", "--disable-quic", "--no-first-run", "--disable-background-networking", "--disable-component-update",
  "--disable-sync", "--disable-extensions", "--disable-dev-shm-usage"];
const GL = ["--use-angle=swiftshader", "--enable-unsafe-swiftshader"], NO_GL = ["--disable-gpu", "--disable-3d-apis"];
const AXE = readFileSync(createRequire(import.meta.url).resolve("axe-core/axe.min.js"), "utf8");

export const DESK = { width: 1280, height: 860 }, PHONE = { width: 390, height: 844 };
const NARROW = { width: 320, height: 640 }; // WCAG 1.4.10: a desk's page at 400 %

// `may`: is this URL the page's own? `expected`: errors that belong to what is tried (a box that is away).
export class Browser {
  static async start({ may, webgl = true }) {
    const self = new Browser(), folder = mkdtempSync(join(tmpdir(), "ttf-chromium."));
    Object.assign(self, { may, folder, wrong: [], expected: null });
    self.context = await chromium.launchPersistentContext(folder, {
      executablePath: process.env.CHROMIUM || "/usr/bin/chromium", headless: true, viewport: DESK, acceptDownloads: true, timeout: 120000,
      timezoneId: "Pacific/Auckland", /* half of a day it is another one there than where UTC is kept */
      args: [...FLAGS, ...(webgl ? GL : NO_GL)] });
    self.context.setDefaultTimeout(60000);
    self.context.on("page", (page) => self.watch(page));
    self.page = self.context.pages()[0] || await self.context.newPage();
    self.watch(self.page);
    return self;
  }

  watch(page) {
    if (page.watched)
      return;
    page.watched = true;
    const note = (text) => {
      if (!this.expected?.test(text))
        this.wrong.push(text);
    };
    page.on("console", (m) => ["error", "warning"].includes(m.type()) && note(`console: ${m.text()} ${m.location().url}`));
    page.on("pageerror", (e) => note(`script: ${e.stack || e.message}`));
    page.on("request", (r) => !this.may(r.url()) && !/^(blob|data|about):/.test(r.url()) && this.wrong.push(`a request to ${r.url()}`));
  }

  fine(where) {
    assert.deepEqual(this.wrong, [], `${where}: nothing goes wrong, nothing is asked of others`);
  }

  // Names, contrast, structure: axe-core finds nothing. Animations would be measured half faded.
  async accessible(where) {
    await this.page.evaluate(AXE);
    const found = await this.page.evaluate(() => axe.run(document, { resultTypes: ["violations"],
      runOnly: ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa", "best-practice"] }));
    assert.deepEqual(found.violations.map((v) => `${v.id}: ${v.help}: ${v.nodes.slice(0, 3).map((n) => `${n.html.slice(0, 160)} ${n.any[0]?.message || ""}`).join(" | ")}`), [],
      `${where}: axe-core finds nothing`);
  }

  // Dark and light, on a desk and on a phone; a picture of each where pictures are wanted; no sideways scrolling.
  async everywhere(name, shots) {
    for (const [size_name, size] of [["desk", DESK], ["phone", PHONE]]) {
      await this.page.setViewportSize(size);
      for (const colorScheme of ["light", "dark"]) {
        await this.page.emulateMedia({ colorScheme, reducedMotion: "reduce" });
        await this.accessible(`${name}, ${size_name}, ${colorScheme}`);
        if (shots)
          await this.page.screenshot({ path: join(shots, `${name}-${size_name}-${colorScheme}.png`), fullPage: true });
      }
      await this.fits(`${name}, ${size_name}`);
    }
    for (const [size_name, size, letters] of [["narrow", NARROW, ""], ["large letters", PHONE, "200%"]]) {
      await this.page.setViewportSize(size);
      await this.page.evaluate((to) => (document.documentElement.style.fontSize = to), letters);
      if (shots)
        await this.page.screenshot({ path: join(shots, `${name}-${size_name.replace(" ", "-")}.png`), fullPage: true });
      await this.fits(`${name}, ${size_name}`);
    }
    await this.page.evaluate(() => (document.documentElement.style.fontSize = ""));
    await this.page.setViewportSize(DESK);
  }

  // Nothing sticks out to the side, and nothing is cut off in a place that cannot be scrolled.
  async fits(where) {
    const out = await this.page.evaluate(() => [...document.querySelectorAll("body *")].filter((e) => {
      const box = e.getBoundingClientRect();
      for (let p = e.parentElement; p; p = p.parentElement)
        if (["auto", "scroll", "hidden"].includes(getComputedStyle(p).overflowX))
          return false; /* scrolled there, or hidden on purpose */
      return box.width > 0 && box.height > 0 && (box.right > innerWidth + 0.5 || (box.left < -0.5 && !e.matches(".skip")));
    }).map((e) => `${e.tagName}.${e.className.baseVal ?? e.className}: ${e.textContent.slice(0, 60)}`));
    assert.deepEqual(out, [], `${where}: nothing sticks out to the side`);
    const wide = await this.page.evaluate(() => document.documentElement.scrollWidth - innerWidth);
    assert.ok(wide <= 0, `${where}: ${wide} pixels stick out to the side`);
  }

  // Part by part, each timed, and nothing may go wrong in one; then `last`, where something may. Where anything fails: a picture of it, and what
  // went wrong besides. In the end `over`, in any case.
  async does(parts, { shots, last = () => {}, over }) {
    try {
      for (const part of parts) {
        const begun = Date.now();
        await part();
        this.fine(part.name);
        console.log(`${part.name.replaceAll("_", " ")}: ${((Date.now() - begun) / 1000).toFixed(1)} s`);
      }
      await last();
    } catch (error) {
      if (shots)
        await this.page.screenshot({ path: join(shots, "failed.png"), fullPage: true }).catch(() => {});
      console.error(`wrong so far: ${JSON.stringify(this.wrong)}`);
      throw error;
    } finally {
      over();
      await this.stop();
    }
  }

  async stop() {
    await this.context?.close();
    rmSync(this.folder, { recursive: true, force: true, maxRetries: 5 });
  }
}

export async function until(what, test, patience_ms = 20000) {
  const end = Date.now() + patience_ms;
  let last;
  for (;;) {
    try {
      last = await test();
      if (last)
        return last;
    } catch (error) {
      last = error.message;
    }
    assert.ok(Date.now() < end, `${what}: not within ${patience_ms / 1000} s (${last})`);
    await new Promise((go) => setTimeout(go, 100));
  }
}
