/* SPDX-License-Identifier: Apache-2.0 */
/* boards.js: boards that this box knows; a description looked at, checked as one types, and sent to be kept. None is put in force from here. */
import { ask, facts, fill, h, renew, say } from "./dom.js";
import { get, getText, postYaml, putBoard, remove } from "./api.js";
import { keep as keepDraft, kept } from "./draft.js";
import { findings } from "./verdict.js";
import { span } from "./words.js";

const CHANGED = ", changed here.";
const LARGEST = 256 * 1024; /* bytes of a description: what the box takes */

/* What a description says, in short. */
function says(b) {
  const names = (of) => (of.length ? of.join(", ") : "none");
  const lamp = (l) => `${l.name}${l.max_on_ns > 0 ? `, lit for ${span(l.max_on_ns)} at most` : ""}${l.max_duty_permille > 0 && l.max_duty_permille < 1000 ? `, ${l.max_duty_permille / 10} % of the time` : ""}`;
  return facts([["Board", b.name], b.title && ["Title", b.title], ["Cameras", names(b.cameras)], ["Lamps", b.lamps.length ? b.lamps.map((l) => h("div", {}, lamp(l))) : "none"], ["Sensors", names(b.sensors)],
    b.simulated && ["It is", "SIMULATED"]]);
}

export function boards(main, box) {
  let ended = false, timer = 0, number = 0, name = null, of = kept("boards")?.of || ""; /* name: of a description that will do */
  const said = h("p", { class: "bad", role: "alert" }), well = h("p", { class: "good", role: "status" }), list = h("div"), judged = h("div", { role: "status" }), takes = h("div"), whose = h("p", { class: "quiet" });
  const text = h("textarea", { rows: 18, spellcheck: "false", oninput: typed });
  const file = h("input", { type: "file", accept: ".yaml,.yml", onchange: from_file });
  const send = h("button", { type: "button", class: "main", disabled: true, onclick: () => put() }, "Send it, to be kept");
  text.value = kept("boards")?.text || "";

  async function attempt(what) {
    say(said, "");
    say(well, "");
    try {
      await what();
    } catch (error) {
      if (!ended)
        say(said, error.text || error.message);
    }
  }

  /* ---- a description ---- */

  function changed() {
    keepDraft("boards", { text: text.value, of });
    say(whose, of);
    name = null; /* until the box has said what it thinks of this one */
    number++; /* what it still says of the one before counts no more */
    send.disabled = true;
    clearTimeout(timer);
    timer = setTimeout(check, 350);
  }

  function typed() {
    if (of && !of.endsWith(CHANGED))
      of = of.replace(/\.$/, CHANGED);
    changed();
  }

  function from_file() {
    const [chosen] = file.files;
    attempt(async () => {
      if (!chosen)
        return;
      if (chosen.size > LARGEST)
        throw new Error(`${chosen.name}: a description has at most ${LARGEST / 1024} KiB`);
      text.value = await chosen.text();
      file.value = ""; /* the same file, changed, may be taken again */
      of = `From the file ${chosen.name}.`;
      changed();
    });
  }

  async function check() {
    const mine = ++number;
    let got = null, trouble = "";
    if (box.session.change && text.value.trim()) {
      try {
        got = await postYaml("boards/check", text.value);
      } catch (error) {
        trouble = error.text || error.message;
      }
    }
    if (ended || mine !== number)
      return;
    name = got?.ok ? got.board.name : null;
    send.disabled = !name;
    renew(judged, [got?.ok, got?.findings, trouble, box.session.change, !text.value.trim()], () => (got ? findings(got, "A board can be described so.", "No board can be described so.")
      : h("p", { class: trouble ? "finding-error" : "quiet" }, trouble || (box.session.change ? "What is typed, or taken from a file, is checked here: the text alone, no device is asked." : "With the token, the box says here whether a board can be described so."))));
    fill(takes, got?.board && says(got.board));
  }

  const put = () => attempt(async () => {
    const sent = name;
    await putBoard(sent, text.value);
    say(well, `${sent} is kept on the box. It is in force nowhere: which board the box is, its configuration says.`);
    await look();
  });

  /* ---- those that are known ---- */

  const show = (which) => attempt(async () => {
    const it = await getText(`boards/${encodeURIComponent(which)}`);
    if (ended)
      return;
    text.value = it;
    of = `This is ${which}, as the box has it.`;
    changed();
    text.focus();
  });

  const drop = (which) => attempt(async () => {
    if (await ask(`Delete the board ${which}?`, h("p", {}, "It was sent to this box, and is in force nowhere."), [{ name: "yes", text: "Delete it", kind: "danger" }, { name: "", text: "Keep it" }]) !== "yes")
      return;
    await remove(`boards/${encodeURIComponent(which)}`);
    await look();
  });

  async function look() {
    const { own, boards: all } = await get("boards");
    if (ended)
      return;
    renew(list, [own, all, box.session.change], () => h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Boards that this box knows" }, h("table", {},
      h("thead", {}, h("tr", {}, ["Board", "Its plans", ""].map((t) => h("th", { scope: "col" }, t || h("span", { class: "visually-hidden" }, "What to do"))))),
      h("tbody", {}, all.map((b) => h("tr", {}, h("td", {}, b.name, h("div", { class: "quiet" }, b.name === own ? "this box" : b.sent ? "sent to it" : "came with it")),
        h("td", {}, b.plans.map((p) => h("div", {}, h("a", { href: `/api/v1/boards/${b.name}/plans/${p}`, download: `${p}.yaml` }, p)))),
        h("td", {}, h("div", { class: "row" }, h("button", { type: "button", "aria-label": `Look at ${b.name}`, onclick: () => show(b.name) }, "Look"),
          b.sent && h("button", { type: "button", class: "danger", disabled: !box.session.change, "aria-label": `Delete ${b.name}`, onclick: () => drop(b.name) }, "Delete")))))))));
  }

  const again = () => {
    attempt(look);
    check();
  };

  fill(main, h("h1", {}, "Boards"), h("div", { class: "cards" },
    h("section", { class: "card" }, h("h2", {}, "Boards that this box knows"), list),
    h("section", { class: "card" }, h("h2", {}, "A board's description"),
      h("p", {}, "It says what a box is made of, which line is which lamp, and how long that may be lit."),
      h("div", { class: "stack" }, h("label", { class: "field" }, "From a file", file), h("label", { class: "field" }, "Or as text", text)), whose,
      judged, takes, h("div", { class: "row end" }, send), said, well,
      h("p", { class: "quiet" }, "What is sent is kept and listed, no more: it holds the limits of lamps, and nobody on a network is to change these. Which board the box is, its configuration says, on the box itself or on its card."))));
  say(whose, of);
  const off = box.on({ session: again, stale: again });
  again();
  return () => {
    ended = true;
    clearTimeout(timer);
    off();
  };
}
