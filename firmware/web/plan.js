/* SPDX-License-Identifier: Apache-2.0 */
/* plan.js: from a sample to a run: what, how often, under which light; checked by the box as one types. */
import { h, fill, renew, say, ask } from "./dom.js";
import { get, getText, post, postYaml, putPlan, remove } from "./api.js";
import { PRESETS, UNITS, nameOf, planText, presetChoice, startText } from "./presets.js";
import { picked, withinRegion } from "./picker.js";
import { forget, keep as keepDraft, kept, putValues, valuesOf } from "./draft.js";
import { figures, judgement, startOf } from "./verdict.js";
import { exposureWords, span, today } from "./words.js";

const ZONE = Intl.DateTimeFormat().resolvedOptions().timeZone;

function quantity(label, [n, unit], units, again) {
  const number = h("input", { type: "number", min: 0, step: "any", value: n, required: true, oninput: again, "aria-label": label });
  const choice = h("select", { onchange: again, "aria-label": `${label}, unit` }, units.map((u) => h("option", { selected: u === unit }, u)));
  return { element: h("div", { class: "field" }, h("span", { "aria-hidden": "true" }, label), h("div", { class: "pair" }, number, choice)), number, choice,
    get: () => [Number(number.value), choice.value],
    set([value, u]) {
      number.value = value;
      choice.value = u;
    } };
}

function select(label, options, again) {
  const e = h("select", { onchange: again }, options.map(([value, text]) => h("option", { value }, text)));
  return { element: h("label", { class: "field" }, label, e), e };
}

export function plan(main, box) {
  let ended = false, timer = 0, by_hand = false, named_by_hand = false, check_number = 0, about = null, ok = false, own = null; /* the plan that was opened or saved here */
  const judged = h("div", { role: "status" }), takes = h("div"), text = h("textarea", { rows: 18, spellcheck: "false", oninput: () => { by_hand = true; say(hand, "Changed by hand: the form above no longer changes it."); remember(); later(); } });
  const hand = h("p", { class: "quiet" }), said = h("p", { class: "bad", role: "alert" }), well = h("p", { class: "good", role: "status" }), list = h("div");

  /* ---- the form ---- */

  const changed = () => { write(); compare(); remember(); later(); };
  const preset = h("div", { class: "presets" }, PRESETS.map((p, i) => h("label", {},
    h("input", { type: "radio", name: "preset", value: p.id, checked: i === 0, onchange: () => choose(p) }), h("span", {}, p.title),
    h("small", {}, `every ${span(p.interval[0] * UNITS[p.interval[1]])} for ${span(p.duration[0] * UNITS[p.duration[1]])}. ${p.text}`))));
  const title = h("input", { required: true, maxlength: 120, size: 28, oninput: () => { name_it(); changed(); } });
  const name = h("input", { required: true, pattern: "[A-Za-z0-9_\\-][A-Za-z0-9._\\-]{0,63}", maxlength: 64, size: 22, oninput: () => { named_by_hand = true; changed(); } });
  const interval = quantity("A picture every", [10, "min"], ["ms", "s", "min", "h"], changed);
  const duration = quantity("For", [7, "d"], ["s", "min", "h", "d"], changed);
  const start = h("input", { type: "datetime-local", max: "9999-12-31T23:59", onchange: changed });
  const mode = select("Lamps burn", [["capture-only", "only for the pictures"], ["continuous", "all the time"], ["photoperiod", "as day and night"], ["none", "not at all"]], () => { shown(); changed(); });
  const settle = quantity("Settle before a picture", [20, "s"], ["s", "min"], changed);
  const day = quantity("Day of", [11.5, "h"], ["min", "h"], changed), period = quantity("in every", [24, "h"], ["min", "h", "d"], changed);
  const dawn = h("input", { type: "time", onchange: changed }), dawn_field = h("label", { class: "field" }, "Day begins at (empty: with the run)", dawn);
  const exposure = h("input", { type: "number", min: 0.001, step: "any", value: 20, oninput: changed }), gain = h("input", { type: "number", min: 0.1, step: "any", value: 1, oninput: changed });
  const mains = select("Mains", [["50Hz", "50 Hz"], ["60Hz", "60 Hz"], ["none", "none"]], changed);
  const keep = select("Keep", [["default", "as the box thinks best"], ["developed", "developed pictures"], ["raw", "raw frames"], ["both", "both"]], changed);
  const region = h("input", { type: "checkbox", onchange: changed }), reference = h("input", { type: "checkbox", onchange: changed });
  const lamps_box = h("div", { class: "fields" }), suits = h("div", { class: "stack" }), camera_box = h("div", { hidden: true });
  let lamps = [], camera = null;
  const fields = { title, name, start, mode: mode.e, dawn, exposure, gain, mains: mains.e, keep: keep.e, region, reference };
  for (const [called, { number, choice: unit }] of Object.entries({ interval, duration, settle, day, period }))
    Object.assign(fields, { [called]: number, [`${called}_unit`]: unit });
  const lamp_fields = () => Object.fromEntries(lamps.map(({ lamp, input }) => [lamp.name, input]));
  const chosen_preset = () => PRESETS.find((p) => p.id === preset.querySelector(":checked")?.value);

  /* What was typed, and what had been picked in live view by then: what is picked later counts more. */
  function remember() {
    if (about)
      keepDraft("plan", { preset: chosen_preset()?.id, values: valuesOf(fields), lamps: valuesOf(lamp_fields()), camera: camera?.value, text: by_hand ? text.value : null, hand: hand.textContent, named_by_hand, own, marks });
  }

  function restore(d) {
    putValues(fields, d.values);
    putValues(lamp_fields(), d.lamps);
    if (camera && d.camera)
      camera.value = d.camera;
    for (const radio of preset.querySelectorAll("input"))
      radio.checked = radio.value === d.preset;
    ({ named_by_hand, own } = d);
    take_picked(d.marks);
    by_hand = d.text !== null;
    if (by_hand)
      text.value = d.text;
    as_text.open = by_hand;
    say(hand, d.hand);
    shown();
    changed();
  }

  /* What was picked in live view, as far as it is not what it was; at first: all of it. */
  const marks = picked();
  function take_picked(before) {
    for (const [field, mark] of [[exposure, "exposure_ms"], [gain, "gain"]])
      if (marks[mark] > 0 && marks[mark] !== before?.[mark])
        field.value = marks[mark];
    for (const [field, mark] of [[region, "region"], [reference, "reference"]]) {
      field.disabled = !marks[mark];
      if (!marks[mark] || JSON.stringify(marks[mark]) !== JSON.stringify(before?.[mark] ?? null))
        field.checked = !!marks[mark];
    }
  }

  /* After the title and the day, until somebody gives it another name. */
  function name_it() {
    if (!named_by_hand)
      name.value = `${nameOf(title.value)}-${today()}`;
  }

  function choose(p) {
    by_hand = named_by_hand = false;
    own = null;
    say(hand, "");
    const c = presetChoice(p, []);
    title.value = c.title;
    name_it();
    interval.set(c.interval);
    duration.set(c.duration);
    mode.e.value = c.mode;
    if (c.settle)
      settle.set(c.settle);
    day.set(c.day);
    period.set(c.period);
    dawn.value = c.day_start || "";
    mains.e.value = c.mains;
    keep.e.value = c.keep;
    shown();
    changed();
  }

  function shown() {
    const lit = mode.e.value !== "none";
    lamps_box.hidden = !lit;
    settle.element.hidden = !lit || mode.e.value === "continuous";
    day.element.hidden = period.element.hidden = dawn_field.hidden = mode.e.value !== "photoperiod";
  }

  function choice() {
    return { title: title.value, interval: interval.get(), duration: duration.get(), start: startText(start.value),
      mode: mode.e.value, settle: settle.element.hidden ? null : settle.get(), day: day.get(), period: period.get(),
      day_start: dawn.value || null, zone: ZONE, channel: chosen_preset()?.channel,
      camera: camera?.value, lamps: Object.fromEntries(lamps.map(({ lamp, input }) => [lamp.name, Number(input.value)])),
      exposure_ms: Number(exposure.value), gain: Number(gain.value), mains: mains.e.value, keep: keep.e.value,
      region: region.checked ? marks.region : null, reference: reference.checked ? withinRegion(marks.reference, region.checked ? marks.region : null) : null };
  }

  function write() {
    if (!by_hand)
      text.value = planText(choice());
  }

  /* ---- the exposure, beside what live view found to suit ---- */

  const FAR = 2; /* times more or less light than a picture that was fine */
  function compare() {
    const { seen } = picked(), c = choice();
    if (!seen) {
      fill(suits, h("p", { class: "quiet" }, "Nobody has looked through the camera yet on this device: ", h("a", { href: "#/live" }, "live view"), " finds an exposure that suits."));
      return;
    }
    const lit = (levels, on) => JSON.stringify(Object.entries(levels).filter(([, level]) => on && level > 0).sort());
    const same_light = lit(seen.lamps || {}, true) === lit(c.lamps, c.mode !== "none");
    const times = (c.exposure_ms * c.gain) / (seen.exposure_ms * (seen.gain || 1)), far = times > FAR || times < 1 / FAR;
    fill(suits, h("div", { class: "row" }, h("p", { class: "quiet" }, `Live view's last picture: ${exposureWords(seen)}${seen.fine ? "" : "; it was clipped or nearly black"}.`),
      (c.exposure_ms !== seen.exposure_ms || c.gain !== (seen.gain || 1)) && h("button", { type: "button", onclick: take_over }, "Take it over")),
      far && seen.fine && h("p", { class: "finding-warning" }, `This plan exposes ${+(times > 1 ? times : 1 / times).toPrecision(2)} times ${times > 1 ? "more" : "less"} than the picture in live view${same_light
        ? `: expect frames that are ${times > 1 ? "clipped" : "too dark"}.` : ", which was under other lamps: look there again with the plan's."}`),
      !far && !same_light && h("p", { class: "quiet" }, "It was under other lamps than this plan's."));
  }

  function take_over() {
    const { seen } = picked();
    exposure.value = seen.exposure_ms;
    gain.value = seen.gain || 1;
    changed();
  }

  /* ---- what the box says of it ---- */

  function later() {
    clearTimeout(timer);
    timer = setTimeout(check, 350);
  }

  /* Where there are no figures. */
  function judge(p) {
    renew(judged, p.textContent, () => p);
    fill(takes);
  }

  async function check() {
    const number = ++check_number;
    if (!box.session.change) { /* it would be refused */
      ok = false;
      judge(h("p", {}, "With the token, the box says here what a plan takes."));
      allow();
      return;
    }
    try {
      const got = await postYaml("plans/check", text.value);
      if (ended || number !== check_number)
        return;
      ok = got.ok;
      renew(judged, [got.ok, got.findings], () => judgement(got)); /* read out when it is another one, and without its figures */
      fill(takes, got.figures && figures(got.figures, startOf(text.value)));
    } catch (error) {
      if (ended || number !== check_number)
        return;
      ok = false;
      judge(h("p", { class: "finding-error" }, error.text || error.message));
    }
    allow();
  }

  function allow() {
    for (const b of actions)
      b.disabled = !ok || !box.session.change;
    no_token.hidden = box.session.change;
  }

  const busy = () => ["waiting", "capturing", "arming", "paused", "stopping", "retrying"].includes(box.status?.state);

  /* A plan of this name that says something else is not lost by an oversight. */
  async function may_replace() {
    if (name.value === own || !listed.includes(name.value) || await getText(`/api/v1/plans/${name.value}`) === text.value)
      return true;
    return await ask(`Replace the plan ${name.value}?`, h("p", {}, "There is a plan of this name already, and it says something else."),
      [{ name: "replace", text: "Replace it", kind: "danger" }, { name: "", text: "Keep it" }]) === "replace";
  }

  async function save(then_start) {
    say(said, "");
    say(well, "");
    try {
      if (!form.reportValidity() || !await may_replace())
        return;
      await putPlan(name.value, text.value);
      own = name.value;
      remember();
      say(well, `The plan ${name.value} is on the box.`);
      if (then_start) {
        if (busy()) {
          say(said, "Another run is under way: stop it first. The plan is saved.");
        } else {
          await start_run({ plan: name.value, dataset: name.value }, () => forget("plan"));
          return;
        }
      }
      await plans();
    } catch (error) {
      say(said, error.text || error.message);
    }
  }

  /* What is shown next is the new run, not the one before. */
  async function start_run(what, begun) {
    const { dataset } = await post("run", what);
    begun?.();
    for (let looks = 0; looks < 20 && box.status?.run?.dataset !== dataset; looks++) {
      await new Promise((go_on) => setTimeout(go_on, 150));
      await box.look();
    }
    location.hash = "#/";
  }

  const actions = [h("button", { type: "button", class: "main", disabled: true, id: "save-start", onclick: () => save(true) }, "Save and start"),
    h("button", { type: "button", disabled: true, onclick: () => save(false) }, "Save only")];

  /* ---- plans that are there ---- */

  let listed = [];
  async function plans() {
    const { plans: there } = await get("plans");
    if (ended)
      return;
    listed = there.map((p) => p.name);
    renew(list, [there, box.session.change], () => [there.length === 0 ? h("p", {}, "None yet.") : h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Plans that are there" },
      h("table", {}, h("thead", {}, h("tr", {}, ["Plan", "Slots", "Every", ""].map((t) => h("th", { scope: "col" }, t || h("span", { class: "visually-hidden" }, "What to do"))))),
        h("tbody", {}, there.map((p) => h("tr", {}, h("td", {}, p.name, p.title && h("div", { class: "quiet" }, p.title), p.error && h("div", { class: "bad" }, p.error)),
          h("td", {}, p.slots?.toLocaleString() || ""), h("td", {}, p.interval_ns ? span(p.interval_ns) : ""),
          h("td", {}, h("div", { class: "row" }, h("button", { onclick: () => open(p.name) }, "Open"),
            h("button", { disabled: !box.session.change || !!p.error, onclick: () => begin(p) }, "Start"),
            !p.configured && h("button", { class: "danger", disabled: !box.session.change, onclick: () => drop(p) }, "Delete"))))))))]);
  }

  const look = () => plans().catch((error) => say(said, error.text || error.message));

  async function open(called) {
    say(said, "");
    try {
      text.value = await getText(`/api/v1/plans/${called}`);
    } catch (error) {
      say(said, error.text || error.message);
      return;
    }
    by_hand = true;
    own = name.value = called;
    say(hand, `This is ${called}, as it lies on the box. Begin anew, or choose another sample, to leave it so.`);
    remember();
    check();
    as_text.open = true;
    text.focus();
  }

  async function begin(p) {
    say(said, "");
    try {
      await start_run({ plan: p.name });
    } catch (error) {
      say(said, error.text || error.message);
    }
  }

  async function drop(p) {
    if (await ask(`Delete the plan ${p.name}?`, h("p", {}, "Datasets that were made by it stay as they are."), [{ name: "yes", text: "Delete it", kind: "danger" }, { name: "", text: "Keep it" }]) === "yes") {
      await remove(`plans/${p.name}`).catch((error) => say(said, error.text || error.message));
      await look();
    }
  }

  /* ---- the page ---- */

  let as_text;
  const no_token = h("p", { class: "quiet" }, "To save or start one, enter the token.");
  const step = (n, head, ...content) => h("fieldset", {}, h("legend", {}, `${n}. ${head}`), content);
  const form = h("form", { onsubmit: (e) => e.preventDefault() },
    step(1, "What is photographed?", h("div", { class: "stack" }, preset, h("div", { class: "row" }, h("button", { type: "button", onclick: () => choose(chosen_preset() || PRESETS[0]) }, "Begin anew"),
      h("span", { class: "quiet" }, "What you type stays in this tab until the run is begun.")))),
    step(2, "How often, how long?", h("div", { class: "fields" }, interval.element, duration.element,
      h("label", { class: "field" }, "Begin (empty: at once)", start), h("label", { class: "field" }, "Title", title), h("label", { class: "field" }, "Name of plan and dataset", name)),
      h("p", { class: "quiet" }, `Times of day are those of this device: ${ZONE}.`)),
    step(3, "Under which light?", h("div", { class: "stack" }, h("div", { class: "fields" }, mode.element, settle.element, day.element, period.element, dawn_field), lamps_box,
      h("div", { class: "fields" }, camera_box, h("label", { class: "field" }, "Exposure, ms", exposure), h("label", { class: "field" }, "Gain", gain), mains.element), suits)),
    step(4, "What is kept?", h("div", { class: "fields" }, keep.element, h("label", {}, region, "only the region"), h("label", {}, reference, "watch the reference patch")),
      h("p", { class: "quiet" }, "Region and patch are drawn in ", h("a", { href: "#/live" }, "live view"), ".")),
    as_text = h("details", {}, h("summary", {}, "The plan, as the box reads it"), h("label", { class: "field" }, h("span", { class: "visually-hidden" }, "The plan's text"), text), hand));

  fill(main, h("h1", {}, "Plan a run"), h("div", { class: "cards planning" },
    h("section", { class: "card form-card", "aria-label": "New plan" }, form),
    h("section", { class: "card" }, h("h2", {}, "What it takes"), judged, takes, h("div", { class: "row end" }, actions), said, well, no_token),
    h("section", { class: "card" }, h("h2", {}, "Plans on this box"), list)));

  /* Until the box has said what it has: what is set then would overwrite what somebody types before. */
  const ready = (is) => form.querySelectorAll("fieldset").forEach((step) => { step.disabled = !is; });

  ready(false);
  take_picked(null);
  async function ask_devices() {
    const got = await get("box");
    if (ended || about)
      return;
    about = got;
    lamps = (about.lamps || []).map((lamp) => ({ lamp, input: h("input", { type: "number", min: 0, max: 100, step: lamp.steps === 1 ? 100 : 1, value: 100, oninput: changed }) }));
    fill(lamps_box, lamps.map(({ lamp, input }) => h("label", { class: "field" }, `Lamp ${lamp.name}, %`, input)));
    if ((about.cameras || []).length > 1 || about.cameras?.[0]?.name !== "main") {
      camera = h("select", { onchange: changed }, (about.cameras || []).map((c) => h("option", {}, c.name)));
      camera_box.hidden = false;
      fill(camera_box, h("label", { class: "field" }, "Camera", camera));
    }
    const draft = kept("plan");
    if (draft)
      restore(draft);
    else
      choose(PRESETS[0]);
    ready(true);
  }

  /* At first, and when a box that was away is there again; what was typed meanwhile stays. */
  function begin_with_box() {
    say(said, "");
    if (about)
      check();
    else
      ask_devices().catch((error) => say(said, error.text || error.message));
    look();
  }

  const off = box.on({ session: () => { check(); look(); }, stale: begin_with_box });
  allow();
  begin_with_box();
  return () => {
    ended = true;
    clearTimeout(timer);
    off();
  };
}
