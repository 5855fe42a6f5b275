/* SPDX-License-Identifier: Apache-2.0 */
/* live.js: single pictures from the camera, one after another; exposure, focus, region. */
import { h, fill, say } from "./dom.js";
import { get, getPicture } from "./api.js";
import { advice, drawHistogram, histogram, marked, pixelsOf, sharpness, spoiled } from "./aids.js";
import { Picker, keep, picked } from "./picker.js";
import { exposureWords } from "./words.js";

const LOUPE = 160; /* pixels of the camera, shown as they are */
const PAUSE_MS = 150, AGAIN_MS = 2000; /* until the next picture; where that failed, or would be that of a slot */

/* A slider of a lamp's own levels: its last stop is full light, into however many they are parted. */
const stopsOf = ({ steps }) => Math.min(1000, Math.max(1, steps || 1000));

function settings_form(about, again) {
  const camera = h("select", { onchange: again }, (about.cameras || []).map((c) => h("option", { value: c.name }, `${c.name} (${c.width} x ${c.height})`)));
  const exposure = h("input", { type: "number", min: 0.001, step: "any", placeholder: "by itself", value: picked().exposure_ms || "", onchange: again });
  const gain = h("input", { type: "number", min: 0.1, step: "any", placeholder: "1", value: picked().gain || "", onchange: again });
  const lamps = (about.lamps || []).map((lamp) => {
    const input = h("input", { type: "range", min: 0, max: stopsOf(lamp), step: 1, value: 0, onchange: again, oninput: tell, "aria-label": `Lamp ${lamp.name}` }), level = h("output");
    const permille = () => Math.round(1000 * input.value / stopsOf(lamp));
    function tell() {
      level.textContent = `${permille() / 10} %`;
      input.setAttribute("aria-valuetext", level.textContent);
    }
    tell();
    return { lamp, permille, label: h("label", {}, `Lamp ${lamp.name}`, input, level) };
  });
  const form = h("div", { class: "stack" },
    (about.cameras || []).length > 1 && h("label", { class: "field" }, "Camera", camera),
    h("div", { class: "fields" }, h("label", { class: "field" }, "Exposure, ms", exposure), h("label", { class: "field" }, "Gain", gain)),
    lamps.map(({ label }) => label));
  const lit = () => lamps.filter(({ permille }) => permille() > 0);
  return { form, chosen: () => ({ exposure_ms: Number(exposure.value) || 0, gain: Number(gain.value) || 0 }),
    choose(seen) {
      exposure.value = seen.exposure_ms;
      gain.value = seen.gain || "";
    },
    lamps: () => Object.fromEntries(lit().map(({ lamp, permille }) => [lamp.name, permille() / 10])), camera: () => (about.cameras || []).find((c) => c.name === camera.value) || about.cameras?.[0],
    query() {
      const q = new URLSearchParams();
      if (camera.value)
        q.set("camera", camera.value);
      if (exposure.value > 0)
        q.set("exposure_ns", Math.round(exposure.value * 1e6));
      if (gain.value > 0)
        q.set("gain_milli", Math.round(gain.value * 1000));
      if (lit().length)
        q.set("lamps", lit().map(({ lamp, permille }) => `${lamp.name}:${permille()}`).join(","));
      return q;
    } };
}

export function live(main, box) {
  let ended = false, running = false, busy = false, wanted = false, from_camera = false, timer = 0, pixels = null, settings = null, picker = null, loupe_at = null, best = 0, measured = null, about = null, seen = null;
  const view = h("canvas", { role: "img", "aria-label": "Live view: no picture yet" });
  const overlay = document.createElementNS("http://www.w3.org/2000/svg", "svg");
  overlay.setAttribute("role", "img");
  const viewer = h("div", { class: "viewer" }, view), said = h("p", { role: "status" }, "…"), exposure_said = h("p", { role: "status" }), by_said = h("span"), by_keep = h("button", { onclick: keep_seen }, "Keep this exposure"), by = h("p", { hidden: true }, by_said, " ", by_keep);
  const bars = h("canvas", { class: "histogram", role: "img", "aria-label": "Histogram" });
  const meter = h("p", { class: "meter" }, "–"), meter_best = h("p", { class: "quiet" }, ""), loupe = h("canvas", { class: "loupe", role: "img", "aria-label": "Loupe" });
  const clipping = check("Mark what is clipped or black", true), peaking = check("Mark sharp edges", false);
  const play = h("button", { class: "main", disabled: true, onclick: toggle }, "Start live view"), once = h("button", { disabled: true, onclick: shoot }, "One picture");
  const side = h("div", { class: "stack" }), picks = h("div", { class: "stack" });

  function check(text, on) {
    const input = h("input", { type: "checkbox", checked: on, onchange: () => draw() });
    return { input, label: h("label", {}, input, text) };
  }

  viewer.append(overlay);
  fill(main, h("h1", {}, "Live view"), h("div", { class: "cards live" },
    h("section", { class: "card picture-card", "aria-label": "Picture" }, viewer, h("div", { class: "row end" }, play, once, clipping.label, peaking.label), said),
    h("div", { class: "aids" }, /* on a phone right below the picture: the other hand is at the lens */
      h("section", { class: "card" }, h("h2", {}, "Exposure"), bars, exposure_said, by, side),
      h("section", { class: "card" }, h("h2", {}, "Focus"), meter, meter_best,
        h("button", { onclick: () => { best = 0; focus(measured); } }, "Begin anew"),
        h("p", { class: "quiet" }, "The number is largest where focus is best; turn the ring until it grows no more. It is of the loupe's place: click the picture to move it, or with arrow keys."), loupe)),
    h("section", { class: "card" }, h("h2", {}, "Region and chart"), picks)));

  function set_running(on) {
    running = on;
    clearTimeout(timer);
    play.textContent = running ? "Stop live view" : "Start live view";
  }

  function toggle() {
    set_running(!running);
    if (running)
      shoot();
  }

  /* One at a time, whoever asks for another meanwhile; none where nobody looks ("stale" comes when somebody does). */
  async function shoot() {
    clearTimeout(timer);
    if (busy || ended || document.hidden || !settings) {
      wanted = busy;
      return;
    }
    busy = true;
    wanted = false;
    const worked = await take();
    busy = false;
    if (ended)
      return;
    if (wanted)
      shoot();
    else if (running)
      timer = setTimeout(shoot, worked && !box.status?.run?.next ? PAUSE_MS : AGAIN_MS);
  }

  async function take() {
    try {
      const query = settings.query(), got = await getPicture(`live?${query}`);
      if (ended)
        return true;
      pixels = await pixelsOf(got.blob);
      from_camera = got.live !== "latest";
      say(said, from_camera ? "From the camera, now." : `A run is under way: this is its last picture, slot ${got.index}. The camera is left alone.`);
      draw();
      show_exposure(got);
      if (closer())
        await look_closely(query);
      return true;
    } catch (error) {
      say(said, error.text || error.message);
      if (error.status === 401)
        set_running(false);
      return false;
    }
  }

  /* With what it was taken; the plan's wizard is told, too. The button stays the same: pictures come faster than a click is done. */
  function show_exposure({ live: from, exposure_ms, gain: g }) {
    seen = from === "camera" && exposure_ms > 0 ? { exposure_ms: +exposure_ms.toPrecision(4), gain: g, lamps: settings.lamps(), fine: !spoiled(histogram(pixels)) } : null;
    by.hidden = !seen;
    if (!seen)
      return;
    keep({ seen });
    const { exposure_ms: asked } = settings.chosen();
    say(by_said, `Taken with ${exposureWords(seen)}${asked > 0 ? "" : ", by itself"}.`);
    by_keep.hidden = asked > 0;
  }

  function keep_seen() {
    settings.choose(seen);
    keep(settings.chosen());
    if (!running)
      shoot();
  }

  function scale() {
    return (settings.camera()?.width || view.width) / view.width;
  }

  /* Whether the camera has more pixels at the loupe's place than the picture. */
  function closer() {
    const camera = settings.camera();
    return from_camera && scale() > 1.01 && camera.width >= LOUPE && camera.height >= LOUPE;
  }

  /* The loupe's place at the camera's own pixels. */
  async function look_closely(query) {
    const camera = settings.camera(), s = scale(), half = LOUPE / 2;
    const x = Math.max(0, Math.min(camera.width - LOUPE, Math.round(loupe_at.x * s - half))), y = Math.max(0, Math.min(camera.height - LOUPE, Math.round(loupe_at.y * s - half)));
    query.set("region", `${x},${y},${LOUPE},${LOUPE}`);
    const got = await getPicture(`live?${query}`);
    if (!ended)
      focus(await pixelsOf(got.blob));
  }

  function draw() {
    if (!pixels)
      return;
    view.width = pixels.width;
    view.height = pixels.height;
    loupe_at ??= { x: pixels.width / 2, y: pixels.height / 2 };
    view.getContext("2d").putImageData(clipping.input.checked || peaking.input.checked
      ? marked(pixels, { clipping: clipping.input.checked, peaking: peaking.input.checked }) : pixels, 0, 0);
    const figures = histogram(pixels), style = getComputedStyle(document.documentElement);
    drawHistogram(bars, figures, ["--red", "--green", "--blue"].map((name) => style.getPropertyValue(name)));
    say(exposure_said, advice(figures));
    bars.setAttribute("aria-label", `Histogram: ${advice(figures)}`);
    view.setAttribute("aria-label", `Live view, ${pixels.width} x ${pixels.height}: ${advice(figures)}`);
    if (!closer()) /* else the loupe's own pixels come: numbers of the one are not those of the other */
      focus(part());
  }

  /* The loupe's place in the picture. */
  function part() {
    const size = Math.min(LOUPE, pixels.width, pixels.height), cut = new OffscreenCanvas(size, size).getContext("2d");
    const x = Math.max(0, Math.min(pixels.width - size, Math.round(loupe_at.x - size / 2))), y = Math.max(0, Math.min(pixels.height - size, Math.round(loupe_at.y - size / 2)));
    cut.putImageData(pixels, -x, -y, x, y, size, size);
    return cut.getImageData(0, 0, size, size);
  }

  /* It is somewhere else: what was best there says nothing here. */
  function loupe_moved(to) {
    loupe_at = to;
    best = 0;
    if (!closer())
      focus(part());
    else if (!running)
      shoot();
  }

  /* Of the loupe's pixels. */
  function focus(close) {
    if (!close)
      return;
    const value = sharpness(close);
    measured = close;
    best = Math.max(best, value);
    say(meter, value.toFixed(1));
    say(meter_best, `${Math.round(100 * value / (best || 1))} % of the best so far, ${best.toFixed(1)}`);
    loupe.width = close.width;
    loupe.height = close.height;
    loupe.getContext("2d").putImageData(close, 0, 0);
    loupe.setAttribute("aria-label", `Loupe at ${Math.round(loupe_at.x * scale())}, ${Math.round(loupe_at.y * scale())}: sharpness ${value.toFixed(1)}`);
  }

  overlay.setAttribute("tabindex", "0");
  overlay.addEventListener("click", (e) => {
    if (picker?.mode || !pixels)
      return;
    const b = overlay.getBoundingClientRect();
    loupe_moved({ x: (e.clientX - b.left) / b.width * pixels.width, y: (e.clientY - b.top) / b.height * pixels.height });
  });
  overlay.addEventListener("keydown", (e) => {
    const by = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, -1], ArrowDown: [0, 1] }[e.key];
    if (!by || !pixels)
      return;
    e.preventDefault();
    const step = e.shiftKey ? 40 : 8;
    loupe_moved({ x: Math.max(0, Math.min(pixels.width, loupe_at.x + by[0] * step)), y: Math.max(0, Math.min(pixels.height, loupe_at.y + by[1] * step)) });
  });

  /* Another camera, another exposure or light: what was best before says nothing now. */
  function changed() {
    keep(settings.chosen()); /* the plan begins with it */
    best = 0;
    const camera = settings.camera();
    if (picker?.of !== camera.name) {
      picker?.size(camera);
      loupe_at = null;
    }
    if (!running)
      shoot();
  }

  async function ask_devices() {
    const got = await get("box");
    if (ended || about)
      return;
    about = got;
    settings = settings_form(about, changed);
    fill(side, settings.form);
    if (settings.camera())
      picker = new Picker(overlay, picks, settings.camera());
    begin();
  }

  function begin() {
    play.disabled = once.disabled = !about || !box.session.change;
    if (!box.session.change)
      say(said, "Live view needs the token.");
    else if (about)
      shoot();
  }

  /* A box that was away is there again. */
  function again() {
    if (!about)
      ask_devices().catch((error) => say(said, error.text || error.message));
    else if (running)
      shoot();
  }

  const off = box.on({ session: begin, stale: again });
  again();
  return () => {
    ended = true;
    clearTimeout(timer);
    off();
  };
}
