/* SPDX-License-Identifier: Apache-2.0 */
/* calibrate.js: step by step from a camera's own values to reflectance: asked of the box, or typed as commands. */
import { ask, h, fill, say } from "./dom.js";
import { keep as keepDraft, kept, putValues, valuesOf } from "./draft.js";
import { get, post, put, refusal, remove } from "./api.js";
import { cornersOption, picked, pickedText } from "./picker.js";
import { nameOf } from "./presets.js";
import { count, span, today } from "./words.js";

const LOOK_MS = 1000, BUSY = ["capturing", "arming", "paused", "stopping", "retrying"];
const PARTS = ["dark", "flat", "chart", "geometry", "flicker"];

/* What a part of a calibration says of itself. */
function partWords(name, part) {
  const further = { flat: () => `target ${+part.reflectance.toPrecision(3)}`, chart: () => `colours off by ${part.delta_e_mean.toFixed(1)} (${part.delta_e_before_mean.toFixed(1)} without), CIEDE2000`,
    geometry: () => `${part.mm_per_px.toPrecision(4)} mm a pixel`, flicker: () => `frames differ by ${(100 * part.frame_rms).toFixed(2)} %, bands by ${(100 * part.band_rms).toFixed(2)} %` }[name];
  return `${name}: ${part.frames} frames${part.exposure_ns ? ` of ${span(part.exposure_ns)}` : ""}${further ? `, ${further()}` : ""}`;
}

export function calibrate(main, box) {
  let ended = false, timer = 0, step = null, listed = null, look_said = "";
  const marks = picked(), text = pickedText(marks), seen = marks.seen;
  const said = h("p", { role: "status" }), wrong = h("p", { class: "bad", role: "alert" }), list = h("div"), busy_said = h("p", { class: "finding-warning" });
  const name = h("input", { required: true, pattern: "[A-Za-z0-9_\\-][A-Za-z0-9._\\-]{0,63}", maxlength: 64, size: 22, value: `${nameOf(box.status?.board || "box")}-${today()}` });
  const plan = h("select", { onchange: () => { if (plan.value) exposure.value = gain.value = ""; /* the plan's own hold */ hold(); } }, h("option", { value: "" }, "all lamps, fully lit"));
  const frames = h("input", { type: "number", min: 1, max: 1000, step: 1, value: 64 });
  const exposure = h("input", { type: "number", class: "roomy", min: 0.001, max: 1e6, step: "any", value: seen?.exposure_ms || "" });
  const gain = h("input", { type: "number", class: "roomy", min: 0.1, max: 1000, step: "any", value: seen?.gain || "" });
  const reflectance = h("input", { type: "number", min: 0.01, max: 1, step: "any", placeholder: "0.9", size: 6 });
  const pitch = h("input", { type: "number", min: 0.001, max: 1000, step: "any", value: 5, size: 6 });
  const form = h("form", { onsubmit: (e) => e.preventDefault() }, h("div", { class: "fields" },
    h("label", { class: "field" }, "Name of the calibration", name), h("label", { class: "field" }, "For the light of the plan", plan),
    h("label", { class: "field" }, "Exposure, ms", exposure), h("label", { class: "field" }, "Gain", gain), h("label", { class: "field" }, "Frames of a step", frames)));

  /*
   * What was typed stays. The exposure does, once it was typed or a step was taken with it: live view finds another one for each thing that it looks at,
   * a chart whose corners are marked, say, and all steps of a calibration are to be of one. Only what is set there by hand counts more, unless a plan says it.
   */
  const fields = { name, frames, reflectance, pitch }, light = { exposure, gain }, draft = kept("calibrate"), set = JSON.stringify([marks.exposure_ms, marks.gain]);
  const holds = draft && (draft.plan || draft.set === set || !(marks.exposure_ms > 0));
  let plan_kept = draft?.plan || "", typed = !!(holds && draft.typed), taken_with = !!(holds && draft.taken_with); /* plan_kept: until it is known which plans there are */
  const the_plan = () => plan.value || plan_kept;
  const remember = () => keepDraft("calibrate", { values: valuesOf({ ...fields, ...light }), plan: the_plan(), typed, taken_with, set });
  name.addEventListener("input", () => {
    if (taken_with) /* another calibration; else it is the same one, called otherwise */
      typed = taken_with = false;
  });
  for (const e of [exposure, gain, plan])
    e.addEventListener("input", () => (typed = !!(exposure.value || gain.value || plan.value)));
  putValues(fields, draft?.values);
  if (typed || taken_with)
    putValues(light, draft.values);

  /* What holds where nothing is said. */
  function hold() {
    exposure.placeholder = the_plan() ? "the plan's" : "20";
    gain.placeholder = the_plan() ? "the plan's" : "1";
  }

  /* ---- what is asked of the box ---- */

  const body = { flat: () => reflectance.value > 0 && { reflectance: Number(reflectance.value) }, geometry: () => ({ pitch_mm: Number(pitch.value) }),
    chart: () => ({ corners: marks.corners.map((p) => [p.x, p.y]) }) };
  async function take(part) {
    say(wrong, "");
    at_step(part, wrong);
    const beside = { flat: reflectance, geometry: pitch }[part];
    if (!form.reportValidity() || (beside && !beside.reportValidity()))
      return;
    try {
      taken_with = true;
      remember();
      show(await post(`calibrations/${encodeURIComponent(name.value)}`, { part, frames: Number(frames.value), ...(the_plan() && { plan: the_plan() }),
        ...(exposure.value > 0 && { exposure_ns: Math.round(exposure.value * 1e6) }), ...(gain.value > 0 && { gain_milli: Math.round(gain.value * 1000) }), ...body[part]?.() }));
    } catch (error) {
      say(wrong, error.text || error.message);
    }
  }

  async function use(which) {
    say(wrong, "");
    at_list.before(wrong);
    try {
      await put("calibration", { name: which });
      await look();
    } catch (error) {
      say(wrong, error.text || error.message);
    }
  }

  async function take_away(which) {
    const answer = await ask(`Delete the calibration ${which}?`, h("p", {}, "For good. Datasets that were developed with it keep their own copy."),
      [{ name: "yes", text: "Delete it", kind: "danger" }, { name: "", text: "Keep it" }]);
    if (answer !== "yes" || ended)
      return;
    say(wrong, "");
    at_list.before(wrong);
    try {
      await remove(`calibrations/${encodeURIComponent(which)}`);
    } catch (error) {
      say(wrong, error.text || error.message);
    }
    await look();
  }

  async function look() {
    clearTimeout(timer);
    try {
      const got = await get("calibrations");
      if (ended)
        return;
      if (wrong.textContent === look_said) /* what somebody else was told stays */
        say(wrong, "");
      show(got);
    } catch (error) {
      look_said = error.text || error.message;
      say(wrong, look_said);
      look_again();
    }
  }

  const working = () => step && ["waiting", "under-way"].includes(step.state);

  /* A step goes on whether or not one look at it succeeds. */
  function look_again() {
    clearTimeout(timer);
    if (!ended && working())
      timer = setTimeout(look, LOOK_MS);
  }

  /* ---- what it says ---- */

  function show({ used, configured, step: now, calibrations }) {
    step = now;
    if (now?.state === "refused" && now.calibration === name.value && !calibrations.some((c) => c.name === name.value)) {
      taken_with = false; /* nothing came of it */
      remember();
    }
    show_step(now);
    const all = JSON.stringify([calibrations, used, configured, box.session.change]);
    if (all !== listed) /* a button in somebody's fingers stays where it is */
      show_list(calibrations, used, configured);
    listed = all;
    enable();
    look_again();
  }

  /* Where the person is who pressed the step's button: on a phone the end of the list is far away. */
  function at_step(part, e) {
    if (e.parentElement !== steps[part])
      steps[part].append(e);
  }

  function show_step(now) {
    if (!now) { /* none since the box was started, or of a calibration that was taken away */
      say(said, "");
    } else {
      at_step(now.part, said);
      const { part, calibration, state } = now, most = now.at_most_ns ? `, ${span(now.at_most_ns)} at the most` : "";
      say(said, { waiting: `The ${part} is about to be taken.`, "under-way": `The ${part} is being taken, for ${span(now.for_ns)} by now${most}. Leave the box alone.`,
        done: `The ${part} of ${calibration} is there.`, refused: `The ${part} was refused: ${refusal(now)}` }[state]);
      said.className = { done: "good", refused: "bad" }[state] || "";
    }
  }

  function show_list(calibrations, used, configured) {
    fill(list, calibrations.length === 0 ? h("p", {}, "None yet.") : h("div", { class: "scroll", tabindex: 0, role: "region", "aria-label": "Calibrations on this box" }, h("table", {},
      h("thead", {}, h("tr", {}, ["Calibration", "Holds", ""].map((t) => h("th", { scope: "col" }, t || h("span", { class: "visually-hidden" }, "What to do"))))),
      h("tbody", {}, calibrations.map((c) => h("tr", {}, h("td", {}, c.name, c.simulated && h("div", { class: "quiet" }, "SIMULATED")),
        h("td", {}, PARTS.filter((p) => c[p]).map((p) => h("div", {}, partWords(p, c[p]))), c.dark && h("div", { class: "quiet" }, count(c.hot_pixels, "hot pixel"))),
        h("td", {}, c.name === used ? h("strong", {}, "in use") : h("div", { class: "row" }, h("button", { disabled: !box.session.change, onclick: () => use(c.name) }, "Use it"),
          h("button", { class: "danger", disabled: !box.session.change, "aria-label": `Delete ${c.name}`, onclick: () => take_away(c.name) }, "Delete")))))))),
      used && h("div", { class: "row end" }, h("button", { disabled: !box.session.change, onclick: () => use("") }, configured ? "Use the configured one" : "Use none")),
      configured && h("p", { class: "quiet" }, `The box's configuration names ${configured}${used ? "; what is chosen here holds instead" : ""}.`));
  }

  const buttons = Object.entries({ dark: "Take the dark", flat: "Take the flat", chart: "Take the chart", geometry: "Take the grid", flicker: "Measure the light" })
    .reduce((all, [part, words]) => ({ ...all, [part]: h("button", { type: "button", disabled: true, onclick: () => take(part) }, words) }), {});

  function enable() {
    const { state, run } = box.status || {}, starts = state === "waiting" && run?.next; /* for its plan's start: armed. One that waits for a plan or a clock is not. */
    const busy = starts || BUSY.includes(state);
    say(busy_said, busy ? `A run ${starts ? "waits for its start" : "is under way"}: the camera belongs to it. Calibrate before a run, or when it is stopped.` : box.session.change ? "" : "To calibrate, enter the token.");
    for (const [part, button] of Object.entries(buttons))
      button.disabled = busy || working() || !box.session.change || (part === "chart" && marks.corners.length !== 4);
  }

  /* ---- the commands ---- */

  const simulated = box.status?.simulated, board = box.status?.board || "BOARD", b = board === "sim" ? "" : ` --board ${board}`;
  const command = (line) => h("pre", { tabindex: 0, "aria-label": "Command" }, line);
  const by_hand = h("details", {}, h("summary", {}, "By hand, at the box's own terminal"),
    h("p", {}, "The same, for whoever is logged in on the box, with targets of other colours or a sample of its own. The box's program holds the camera and the lamps: end it first. A run under way ends within a slot, and is gone on with when the program is started again."),
    command("sudo systemctl stop ttfboxd"), command(`ttfbox calibrate dark${b} -p PLAN -o cal`), command(`ttfbox calibrate flat${b} -p PLAN${simulated ? " --scene white" : ""} --reflectance 0.9 -o cal`),
    command(`ttfbox calibrate chart${b} -p PLAN${simulated ? " --scene chart" : ""} -o cal${simulated ? "" : ` ${cornersOption(marks) || "--corners X,Y,X,Y,X,Y,X,Y"}`}`),
    command(`ttfbox calibrate geometry${b} -p PLAN${simulated ? " --scene dots" : ""} --pitch 5 -o cal`), command(`ttfbox calibrate flicker${b} -p PLAN -o cal`), command("ttfbox calibrate report cal"),
    h("p", {}, "Then ", h("code", {}, "calibration: PATH"), " in the configuration of the program, and:"), command("sudo systemctl start ttfboxd"));

  /* ---- the page ---- */

  const taken = (part, ...fields) => h("div", { class: "row" }, fields, buttons[part]);
  const steps = {
    dark: h("li", {}, h("strong", {}, "Dark."), " Close the box; all lamps go off by themselves.", taken("dark")),
    flat: h("li", {}, h("strong", {}, "Flat."), " Put an even white target in the sample's place, filling the picture; say how much light it reflects. Lamps are lit and settled first.", taken("flat", h("label", {}, "It reflects", reflectance))),
    chart: h("li", {}, h("strong", {}, "Chart, if colours matter."), " Put a ColorChecker Classic in the sample's place, under the same lamps; mark the corners of its patches in ", h("a", { href: "#/live" }, "live view"), ", from \"dark skin\" clockwise. Grey stays grey.",
      marks.corners.length === 4 ? null : h("span", { class: "quiet" }, " Its corners are not marked yet."), taken("chart")),
    geometry: h("li", {}, h("strong", {}, "Grid, if sizes matter."), " Put a printed grid of dark round dots in the sample's place, flat, filling the picture; say how many millimetres they are apart. Datasets then say how large a pixel is.", taken("geometry", h("label", {}, "Dots apart, mm", pitch))),
    flicker: h("li", {}, h("strong", {}, "Is the light steady?"), " Frame by frame, and in bands across one.", taken("flicker")),
  };
  const at_list = h("p", { class: "quiet" }, "What is in use develops the pictures of the next run that begins. A run that is gone on with keeps its own.");
  fill(main, h("h1", {}, "Calibration, step by step"), h("div", { class: "cards" },
    h("section", { class: "card wide", oninput: remember, onchange: remember },
      h("p", {}, "Without a calibration, values are the camera's own (radiance); with one, value 1 is a perfect diffuser wherever it lies (reflectance). It takes ten minutes, and it holds as long as camera, lens, lamps and exposure stay as they are. Each step refuses what cannot be right, and says why."),
      busy_said, form,
      h("ol", { class: "steps" },
        h("li", {}, h("strong", {}, "Frame, focus, expose."), " In ", h("a", { href: "#/live" }, "live view"), " turn the lens until the focus number is largest; put the white target in, light the lamps, and set the exposure so that nothing is clipped and the brightest lies near the right end of the histogram. It is taken over here, and into the plan."),
        Object.values(steps)),
      said, by_hand),
    h("section", { class: "card wide" }, h("h2", {}, "Calibrations on this box"), list, wrong, at_list),
    h("section", { class: "card" }, h("h2", {}, "What was picked in live view"),
      text ? h("pre", { class: "picked", tabindex: 0, "aria-label": "What was picked" }, text) : h("p", {}, "Nothing yet. Region, reference patch and the corners of a colour chart are marked in ", h("a", { href: "#/live" }, "live view"), "."),
      h("p", { class: "quiet" }, "Region and reference go into the plan, the corners into the chart."))));

  get("plans").then(({ plans }) => {
    plans.filter((p) => !p.error).forEach((p) => plan.append(h("option", { value: p.name, selected: p.name === plan_kept }, p.name)));
    plan_kept = "";
    hold();
  }).catch(() => { /* without one it works as well */ });
  hold();
  const off = box.on({ status: enable, session: look, stale: look });
  enable();
  look();
  return () => {
    ended = true;
    clearTimeout(timer);
    off();
  };
}
