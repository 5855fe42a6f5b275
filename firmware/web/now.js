/* SPDX-License-Identifier: Apache-2.0 */
/* now.js: the first thing seen: state, countdown, the last picture; what the run has cost and will take. */
import { h, fill, facts, renew, say, ask } from "./dom.js";
import { getPicture, post } from "./api.js";
import { bytes, countdown, count, reading, span, when } from "./words.js";
import { histogram, pixelsOf, spoiled } from "./aids.js";
import { results, stateWords } from "./state.js";

export function now(main, box) {
  const clock = h("p", { class: "countdown", id: "countdown" }), under = h("p", {}), bar = h("progress", { "aria-label": "Slots done" });
  const run_of = h("p"), run_facts = h("div"), disk = h("div"), readings = h("div"), alarms = h("div", { role: "alert" }), said = h("p", { class: "bad", role: "alert" });
  const buttons = h("div", { class: "row end" }), happened = h("ul", { class: "notes" }), log = h("div", { role: "log", "aria-label": "What happened" }, happened);
  const img = h("img", { alt: "The last picture", hidden: true }), none = h("p", {}, "No picture yet"), caption = h("figcaption", {}, ""), exposure = h("p", { class: "finding-warning", role: "status", hidden: true });
  const happenings = h("section", { class: "card", hidden: true }, h("h2", {}, "While this page is open"), log);

  fill(main, h("h1", { class: "visually-hidden" }, "Now"), h("div", { class: "cards now" },
    h("section", { class: "card", "aria-label": "State" }, clock, under, bar, said, alarms, buttons),
    h("section", { class: "card picture-card" }, h("h2", {}, "Last picture"), h("figure", {}, h("div", { class: "picture" }, img, none), caption), exposure),
    h("section", { class: "card" }, h("h2", {}, "Run"), run_of, run_facts),
    h("section", { class: "card" }, h("h2", {}, "Box"), disk, readings), happenings));

  /* ---- the countdown, as often as it changes ---- */

  function tick() {
    const { status, lost } = box, next = box.next_in_ns();
    const word = lost ? "Connection lost" : next === undefined || ["stopped", "idle", "retrying", "stopping", "arming"].includes(status?.state)
      ? stateWords(status, lost).text : null;
    clock.classList.toggle("word", word !== null);
    say(clock, word ?? (next <= 0 ? "now" : countdown(next)));
    if (!status)
      return;
    const { run } = status, parts = [];
    if (lost)
      parts.push("What is shown is from before.");
    else if (status.why)
      parts.push(status.why);
    else if (word === null)
      parts.push(`until slot ${run.next.index}${run.slots ? ` of ${run.slots}` : ""}`, ...(box.settled_in_ns() > 0 ? ["the lamps warm up"] : []));
    if (!lost && status.retry_in_ns !== undefined)
      parts.push(`looked at again in ${countdown(status.retry_in_ns - (performance.now() - box.received) * 1e6)}`);
    say(under, parts.join("; "));
  }

  /* ---- everything else, when the status is new ---- */

  function refresh() {
    const { status } = box;
    if (!status)
      return;
    const { run } = status, ends = box.ends_in_ns();
    bar.hidden = run?.slots === undefined;
    if (run?.slots !== undefined) {
      bar.max = run.slots;
      bar.value = run.done || 0;
    }
    renew(run_of, run?.dataset ?? null, () => (run ? ["Dataset ", h("a", { href: `#/data/${run.dataset}` }, run.dataset)]
      : ["Nothing was run since this box was started. ", h("a", { href: "#/plan" }, "Make a plan"), "."]));
    fill(run_facts, run && facts([
      run.plan && ["Plan", run.plan],
      run.interval_ns && ["Interval", span(run.interval_ns)],
      ["Slots", run.slots === undefined ? "not yet known" : `${(run.done || 0).toLocaleString()} of ${run.slots.toLocaleString()}`],
      run.results && ["Results", results(run.results)],
      ends !== undefined && ends > 0 && ["Time left", `${span(ends)}, until ${when(Date.now() * 1e6 + ends)}`],
      run.last && ["Last slot", `${run.last.index}: ${run.last.result}${run.last.why ? `, ${run.last.why}` : ""}` +
        `${run.last.error_ns !== undefined ? `, ${signed(run.last.error_ns)} off its time` : ""}`],
      run.sealed && ["Sealed", "yes"],
    ]));
    fill(disk, facts([
      status.disk && ["Disk", `${bytes(status.disk.free_bytes)} free of ${bytes(status.disk.total_bytes)}`],
      status.disk && run?.slot_bytes && ["Room for", room_words(status.disk, run)],
      status.board && ["Board", status.board],
      status.time && ["Clock", clock_words(status.time)],
      ["Software", status.version],
    ]));
    const { lamps = [], sensors = [] } = status.readings || {};
    fill(readings, lamps.length + sensors.length ? [h("h3", {}, `At slot ${status.readings.index}`), facts([
      ...lamps.map((l) => [l.name, `${(l.measured_permille ?? l.commanded_permille) / 10} %`]),
      ...sensors.map((s) => [s.name, s.ok === false ? "gives nothing" : reading(s.kind, s.value)])])] : []);
    const list = (status.alarms || []).map((a) => `${a.utc_ns ? `${when(a.utc_ns)}: ` : ""}${a.text}`);
    renew(alarms, list, () => (list.length ? [h("h2", { class: "bad" }, "A person is needed"), h("ul", { class: "alarms" }, list.map((text) => h("li", {}, text)))] : []));
    draw_buttons(status);
    tick();
  }

  /* Beyond the plan's reserve: slots that would take of it are missed. */
  function room_words({ free_bytes }, { slot_bytes, reserve_bytes = 0, slots, done = 0 }) {
    const fit = Math.max(0, Math.floor((free_bytes - reserve_bytes) / slot_bytes));
    return count(fit, "more slot") + (slots && slots - done > fit ? ": not enough for this run" : "");
  }

  function signed(ns) {
    return `${ns < 0 ? "−" : "+"}${span(ns)}`;
  }

  /* The box's clock beside this machine's. */
  function clock_words(time) {
    const trust = { none: "set by nobody", rtc: "kept by its battery", ntp: "from the network", host: "from a host" }[time.trust] || time.trust;
    if (time.utc_ns === undefined)
      return trust;
    const off_s = time.utc_ns / 1e9 - Date.now() / 1000;
    return Math.abs(off_s) > 10 && !box.status.simulated ? `${trust}; ${span(off_s * 1e9)} ${off_s < 0 ? "behind" : "ahead of"} this device's` : trust;
  }

  /* ---- what may be asked of it ---- */

  async function order(path, body) {
    say(said, "");
    try {
      await box.order(path, body);
      await box.look();
    } catch (error) {
      say(said, error.text || error.message);
    }
  }

  async function stop() {
    const slots = box.status?.run?.slots;
    if (await ask("Stop this run?", h("p", {}, `It ends within a slot, loses no frame, and stays stopped until somebody goes on with it${slots ? ` (${slots} slots were planned)` : ""}.`),
      [{ name: "stop", text: "Stop it", kind: "danger" }, { name: "", text: "Let it run" }]) === "stop")
      await order("run/stop");
  }

  async function go_on() {
    say(said, "");
    try {
      await post("run", {});
      await box.look();
    } catch (error) {
      say(said, error.text || error.message);
    }
  }

  let drawn = "", held = false; /* somebody was at a button by keyboard: is to be at what comes in its place */
  function draw_buttons(status) {
    const { state, run } = status, may = box.session.change, key = `${state} ${may} ${!!run}`;
    if (key === drawn)
      return; /* a button in somebody's fingers stays where it is */
    drawn = key;
    held = buttons.contains(document.activeElement) || (held && document.activeElement === document.body);
    const running = ["capturing", "arming", "waiting"].includes(state);
    fill(buttons,
      running && h("button", { disabled: !may, onclick: () => order("run/pause", { reason: "asked for on the page" }) }, "Pause"),
      state === "paused" && h("button", { class: "main", disabled: !may, onclick: () => order("run/resume") }, "Resume"),
      (running || state === "paused" || state === "retrying") && h("button", { class: "danger", disabled: !may, onclick: stop }, "Stop"),
      state === "stopped" && run && h("button", { class: "main", disabled: !may, onclick: go_on }, "Go on"),
      (state === "idle" || state === "stopped") && h("a", { class: "button", href: "#/plan" }, "New plan"),
      !may && h("p", { class: "quiet" }, "To change something, enter the token."));
    const next = held && buttons.querySelector("button:enabled, a");
    if (next) {
      next.focus();
      held = false;
    }
  }

  /* ---- the picture ---- */

  let shown = null, asked = false, wanted = false, ended = false, known = null; /* the run whose last picture is shown, or that has none */
  async function picture(sure = false) {
    if (asked || document.hidden) { /* nobody sees it now; who comes back does ("stale") */
      wanted ||= asked && sure;
      return;
    }
    const counts = box.status?.run?.results;
    if (!sure && !counts?.captured && !counts?.partial)
      return; /* there is none to be asked for */
    asked = true;
    const of = box.status?.run?.dataset;
    known = null; /* until there is an answer: else it is asked for again with the next status */
    try {
      const got = await getPicture("latest");
      if (ended)
        return;
      known = of;
      if (shown)
        URL.revokeObjectURL(shown);
      shown = URL.createObjectURL(got.blob);
      img.src = shown;
      img.alt = `The last picture: slot ${got.index} of ${got.dataset}`;
      img.hidden = false;
      none.hidden = true;
      say(caption, `${got.dataset}, slot ${got.index}`);
      await look_at(got.blob);
    } catch (error) {
      if (error.status === 404) {
        known = of;
        img.hidden = true;
        none.hidden = false;
        warn("");
      } else if (error.status) {
        say(caption, error.text);
      }
    }
    asked = false;
    if (wanted) {
      wanted = false;
      setTimeout(picture, 500, true);
    }
  }

  /* What is there when the page comes to know of it (a token given, a first status), or can have it: no slot may come for hours, or ever. */
  function first_picture() {
    if (box.status?.run && box.status.run.dataset !== known)
      picture();
  }

  /* A run goes on whatever its frames are like: who looks at it is to see on the first that a week of these is no use. */
  async function look_at(blob) {
    warn(spoiled(histogram(await pixelsOf(blob, 256))));
  }

  let warned = "";
  function warn(what) {
    const kind = what.split(":")[0]; /* its figure changes with every picture's noise */
    if (kind === warned)
      return; /* said once, not at each slot */
    warned = kind;
    exposure.hidden = !what;
    fill(exposure, what && [`This picture is ${what}. `, h("a", { href: "#/live" }, "Live view"), " finds an exposure that suits, when the run is stopped; a new ", h("a", { href: "#/plan" }, "plan"), " takes it over."]);
  }

  function tell(text) {
    happenings.hidden = false;
    happened.prepend(h("li", {}, h("small", {}, new Date().toLocaleTimeString()), " ", text));
    while (happened.children.length > 30)
      happened.lastChild.remove();
  }

  const off = box.on({
    status: () => { refresh(); first_picture(); }, lost: tick, stale: () => picture(), session: () => { drawn = ""; refresh(); },
    slot: ({ detail }) => {
      if (detail.result === "captured" || detail.result === "partial")
        picture(true);
      else
        tell(`Slot ${detail.index}: ${detail.result}${detail.why ? `, ${detail.why}` : ""}`);
    },
    event: ({ detail }) => tell(detail.text),
    alarm: ({ detail }) => tell(`Alarm: ${detail.text}`),
  });
  const timer = setInterval(tick, 200);
  refresh();
  tick();
  first_picture();
  return () => {
    ended = true;
    clearInterval(timer);
    off();
    if (shown)
      URL.revokeObjectURL(shown);
  };
}
