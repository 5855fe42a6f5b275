/* SPDX-License-Identifier: Apache-2.0 */
/* notes.js: what people add to a dataset. */
import { h, fill, renew, say } from "./dom.js";
import { getLines, post } from "./api.js";
import { when } from "./words.js";

export function notes(parent, box, name) {
  let ended = false, slot;
  const list = h("ul", { class: "notes" }), said = h("p", { class: "bad", role: "alert" }), may_not = h("p", { class: "quiet" });
  const text = h("textarea", { rows: 3, maxlength: 1000, required: true }), author = h("input", { maxlength: 63, size: 14, autocomplete: "name" });
  const of_slot = h("option", { value: "slot", disabled: true }, "a slot"), about = h("select", { onchange: may_exclude }, h("option", { value: "" }, "the whole dataset"), of_slot);
  const exclude = h("input", { type: "checkbox", disabled: true }), button = h("button", {}, "Add the note");

  async function refresh() {
    const lines = (await getLines(name, "notes")).reverse();
    if (ended)
      return;
    renew(list, lines, () => (lines.length ? lines.map((n) => h("li", {}, h("small", {}, [n.utc_ns && when(n.utc_ns), n.author,
      n.slots && `slots ${n.slots.map(([a, b]) => (a === b ? a : `${a}–${b}`)).join(", ")}`, n.tags?.join(", ")].filter(Boolean).join(" · ")), h("div", { class: "said" }, n.text || ""))) : [h("li", {}, "None yet.")]));
  }

  function may_exclude() {
    exclude.disabled = about.value !== "slot";
    exclude.checked &&= !exclude.disabled;
  }

  async function add(e) {
    e.preventDefault();
    say(said, "");
    const body = { text: text.value.trim() };
    if (author.value.trim())
      body.author = author.value.trim();
    if (about.value === "slot")
      body.slots = [[slot, slot]];
    if (exclude.checked)
      body.tags = ["exclude"];
    button.disabled = true; /* it is added once, however often that is pressed */
    try {
      await post(`datasets/${name}/notes`, body);
      text.value = "";
      exclude.checked = false;
      await refresh();
    } catch (error) {
      say(said, error.text || error.message);
    }
    allow();
  }

  function allow() {
    button.disabled = !box.session.change;
    say(may_not, box.session.change ? "" : box.session.box ? "Notes need the token." : `Here notes are added by: ttfbox note ${name} "TEXT"`);
  }

  const form = h("form", { class: "stack", onsubmit: add }, h("label", { class: "field" }, "Note", text),
    h("div", { class: "fields" }, h("label", { class: "field" }, "About", about), h("label", { class: "field" }, "By", author)),
    h("label", {}, exclude, "leave this slot out of what is made of the dataset"), h("div", { class: "row" }, button), may_not, said);
  fill(parent, h("h2", {}, "Notes"), list, h("h3", {}, "A new one"), form);
  const look = () => refresh().catch((error) => say(said, error.text || error.message));
  const off = box.on({ session: allow, stale: look });
  allow();
  look();
  return {
    /* Which one a note is about is the writer's choice: one that begins to be shown meanwhile is another. */
    slot(shown, by_person) {
      if (about.value === "slot" && !by_person)
        return;
      slot = shown;
      of_slot.disabled = false;
      say(of_slot, `slot ${shown}, chosen above`);
    },
    end() {
      ended = true;
      off();
    },
  };
}
