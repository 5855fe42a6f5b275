/* SPDX-License-Identifier: Apache-2.0 */
/* app.js: which part of the page is seen, and what stands above all of them. */
import { Box } from "./box.js";
import { h, fill, say, ask } from "./dom.js";
import { post, remove } from "./api.js";
import { stateWords } from "./state.js";
import { now } from "./now.js";
import { live } from "./live.js";
import { plan } from "./plan.js";
import { datasets } from "./datasets.js";
import { dataset } from "./dataset.js";
import { calibrate } from "./calibrate.js";
import { boards } from "./boards.js";

const $ = (id) => document.getElementById(id);
const box = new Box();
let leave = null, part_seen = ""; /* ends the part that is seen; its name */

/* Each part fills `main` and gives back what ends it. */
const PARTS = [
  [/^#\/live$/, "Live view", live],
  [/^#\/plan$/, "Plan", plan],
  [/^#\/data$/, "Datasets", datasets],
  [/^#\/data\/([A-Za-z0-9._-]+)$/, "Dataset", dataset],
  [/^#\/calibrate$/, "Calibrate", calibrate],
  [/^#\/boards$/, "Boards", boards],
  [/^#?\/?$/, "Now", now],
];

function show() {
  const hash = location.hash || "#/";
  if (!box.session.box && /^#\/?(live|plan|calibrate|boards)?$/.test(hash)) {
    location.replace("#/data");
    return;
  }
  leave?.();
  leave = null;
  for (const a of document.querySelectorAll(".tabs a"))
    if (a.hash === hash || (a.hash === "#/data" && hash.startsWith("#/data/")))
      a.setAttribute("aria-current", "page");
    else
      a.removeAttribute("aria-current");
  part_seen = "";
  if (!box.session.read) {
    fill($("main"), login_card());
    title();
    return;
  }
  for (const [pattern, called, part] of PARTS) {
    const found = hash.match(pattern);
    if (!found)
      continue;
    fill($("main"));
    document.documentElement.dataset.part = called;
    part_seen = called === "Now" ? "" : found[1] || called;
    title();
    leave = part($("main"), box, ...found.slice(1)) || null;
    return;
  }
  title();
  fill($("main"), h("h1", {}, "Nothing is here"), h("p", {}, h("a", { href: "#/" }, "Back to the beginning")));
}

/* "Capturing 3/40 – Live view – ttfbox" */
function title() {
  const { session, status, lost } = box;
  document.title = [session.box && status && stateWords(status, lost).text, part_seen, "ttfbox"].filter(Boolean).join(" – ");
}

function login_card() {
  return h("section", { class: "card" }, h("h1", {}, "This box asks for its token"),
    h("p", {}, "It was made when the box was started first. With the box at this machine's USB, ", h("code", {}, "ttfbox usb token"), " shows it, once; on the box, ",
      h("code", {}, "ttfbox token"), " does; of ", h("code", {}, "ttfbox serve"), " it stands where that was started. One of your own: settings/token on the box's card."),
    login_form(() => {}));
}

/* At the cable, of a box that has shown its token to nobody yet: once. */
function first_form(shown) {
  const said = h("div", { role: "status" });
  const button = h("button", { type: "button", onclick: async () => {
    button.disabled = true;
    let token;
    try {
      ({ token } = await post("session/token"));
    } catch (error) {
      fill(said, h("p", { class: "bad" }, error.text || error.message));
      return;
    }
    fill(said, h("p", {}, "The box's token: ", h("code", {}, token)),
      h("p", {}, "It is shown this once. Keep it: other browsers and programs are asked for it."));
    try { /* whatever becomes of this, the token stays where it can be read */
      await post("session", { token });
      await box.renew();
      said.append(h("p", {}, "This browser knows it now."));
      shown();
    } catch (error) {
      said.append(h("p", { class: "bad" }, `This browser does not know it yet, enter it below: ${error.text || error.message}`));
    }
  } }, "Show the token");
  return h("div", { class: "stack" }, h("p", {}, "You are at the box's cable, and nobody has seen its token yet."), button, said);
}

function login_form(done) {
  const input = h("input", { type: "password", autocomplete: "current-password", required: true, size: 34 });
  const wrong = h("p", { class: "bad", role: "alert" });
  return h("form", { class: "stack", onsubmit: async (e) => {
    e.preventDefault();
    say(wrong, ""); /* the same once more is to be heard, too */
    try {
      await post("session", { token: input.value.trim() });
      await box.renew();
      done();
    } catch (error) {
      say(wrong, error.text || error.message);
      input.select();
    }
  } }, h("label", { class: "field" }, "Token", input), h("div", { class: "row" }, h("button", { class: "main" }, "Use it")), wrong);
}

async function login() {
  if (box.session.change) {
    if (await ask("Forget the token?", h("p", {}, "This browser can then no longer change anything on the box."),
      [{ name: "forget", text: "Forget it", kind: "main" }, { name: "", text: "Keep it" }]) === "forget") {
      await remove("session").catch(() => {});
      await box.renew();
    }
    return;
  }
  const dialog = $("ask");
  const form = login_form(() => dialog.close());
  fill(dialog, h("h2", { id: "ask-title" }, "The box's token"), box.session.token_waits && first_form(() => form.remove()), form,
    h("div", { class: "row end" }, h("button", { type: "button", onclick: () => dialog.close() }, "Close")));
  dialog.onclose = null;
  dialog.showModal();
}

function above() {
  const { status, lost, session } = box, words = stateWords(status, lost);
  say($("state"), session.box ? words.text : "Datasets on this machine");
  $("state").dataset.kind = session.box ? words.kind : "";
  say($("heard"), session.box ? words.said : "");
  title();
  say($("serial"), status?.serial || "");
  $("simulated").hidden = !status?.simulated;
  $("lost").hidden = !lost;
  if (lost)
    say($("lost"), `Connection lost: ${box.trouble}. What it was told to do goes on without this page; what is seen here may be old.`);
  for (const a of document.querySelectorAll("[data-box]"))
    a.hidden = !session.box;
  $("login").hidden = !session.read;
  say($("login"), session.change ? "Token ✓" : "Token");
  $("login").setAttribute("aria-label", session.change ? "Token: given. Forget it" : "Token: enter it");
}

function theme() {
  const root = document.documentElement, dark = matchMedia("(prefers-color-scheme: dark)").matches;
  const is_dark = root.dataset.theme ? root.dataset.theme === "dark" : dark;
  root.dataset.theme = is_dark ? "light" : "dark";
  try {
    localStorage.setItem("theme", root.dataset.theme);
  } catch { /* it is remembered no longer than the page */ }
}

try {
  const kept = localStorage.getItem("theme");
  if (kept === "dark" || kept === "light")
    document.documentElement.dataset.theme = kept;
} catch { /* as the system has it */ }
$("theme").addEventListener("click", theme);
$("login").addEventListener("click", login);
document.querySelector(".skip").addEventListener("click", (e) => { /* a part's address is not lost by it */
  e.preventDefault();
  $("main").focus();
});
box.on({ status: above, lost: above });
/* What a part shows to those who may change something, and not to others, it sees to by itself: what was typed into it stays. */
let could_read = null;
box.addEventListener("session", () => {
  above();
  const can = `${box.session.read} ${box.session.box}`;
  if (could_read !== null && could_read !== can)
    show();
  could_read = can;
});
addEventListener("hashchange", () => {
  show();
  $("main").focus({ preventScroll: true });
  scrollTo(0, 0);
});
await box.start();
above();
show();
document.documentElement.dataset.ready = "yes";
