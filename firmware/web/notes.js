/* SPDX-License-Identifier: Apache-2.0 */
/* notes.js: what people add to a dataset. */
import { h, fill, say } from "./dom.js";
import { getLines, post } from "./api.js";
import { when } from "./words.js";

export function notes(parent, box, name, slot_now) {
  let ended = false;
  const list = h("ul", { class: "notes" }), said = h("p", { class: "bad", role: "alert" });
  const text = h("textarea", { rows: 3, maxlength: 1000, required: true }), author = h("input", { maxlength: 63, size: 14, autocomplete: "name" });
  const about = h("select", {}, h("option", { value: "" }, "the whole dataset"), h("option", { value: "slot" }, "the slot chosen above"));
  const exclude = h("input", { type: "checkbox" }), button = h("button", {}, "Add the note");

  async function refresh() {
    const lines = (await getLines(name, "notes")).reverse();
    if (ended)
      return;
    fill(list, lines.length ? lines.map((n) => h("li", {}, h("small", {}, [n.utc_ns && when(n.utc_ns), n.author,
      n.slots && `slots ${n.slots.map(([a, b]) => (a === b ? a : `${a}–${b}`)).join(", ")}`, n.tags?.join(", ")].filter(Boolean).join(" · ")), h("div", {}, n.text || ""))) : h("li", {}, "None yet."));
  }

  const form = h("form", { class: "stack", onsubmit: async (e) => {
    e.preventDefault();
    say(said, "");
    const body = { text: text.value.trim() }, slot = slot_now();
    if (author.value.trim())
      body.author = author.value.trim();
    if (about.value === "slot" && slot !== undefined)
      body.slots = [[slot, slot]];
    if (exclude.checked)
      body.tags = ["exclude"];
    try {
      await post(`datasets/${name}/notes`, body);
      text.value = "";
      exclude.checked = false;
      await refresh();
    } catch (error) {
      say(said, error.text || error.message);
    }
  } }, h("label", { class: "field" }, "Note", text), h("div", { class: "fields" }, h("label", { class: "field" }, "About", about), h("label", { class: "field" }, "By", author)),
  h("label", {}, exclude, "leave this slot out of what is made of the dataset"), h("div", { class: "row" }, button), said);
  fill(parent, h("h2", {}, "Notes"), list, h("h3", {}, "A new one"), form);
  exclude.disabled = true;
  about.addEventListener("change", () => {
    exclude.disabled = about.value !== "slot";
    exclude.checked &&= !exclude.disabled;
  });
  const allow = () => {
    button.disabled = !box.session.change;
    if (!box.session.change)
      say(said, box.session.box ? "Notes need the token." : `Here notes are added by: ttfbox note ${name} "TEXT"`);
  };
  allow();
  refresh().catch((error) => say(said, error.text || error.message));
  return () => {
    ended = true;
  };
}
