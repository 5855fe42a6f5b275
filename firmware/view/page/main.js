/* SPDX-License-Identifier: Apache-2.0 */
/* main.js: the file's own data onto the page; time and exposure for all panels at once. */
"use strict";
(async () => {
  const $ = (id) => document.getElementById(id);
  const about = JSON.parse($("about").textContent);
  const first = about.panels[0];

  function blob(script, kind) {
    const text = atob(script.textContent), bytes = new Uint8Array(text.length);
    for (let i = 0; i < text.length; i++)
      bytes[i] = text.charCodeAt(i);
    script.remove(); /* the page holds it twice no longer than it must */
    return new Blob([bytes], { type: `image/${kind}` });
  }

  function facts() {
    for (const p of about.panels) {
      const line = document.createElement("p");
      const frames = p.slots.length === p.of_frames ? `all ${p.of_frames} frames` : `${p.slots.length} of ${p.of_frames} frames, evenly taken`;
      const size = p.width === p.of_width && p.height === p.of_height ? `${p.width} x ${p.height} pixels`
        : `${p.width} x ${p.height} pixels, averaged from ${p.of_width} x ${p.of_height}`;
      const codes = p.kind === "png" ? "exact in 8 bits" : "JPEG of quality 90, so values are near, not exact";
      line.textContent = `${p.role}: ${frames}; ${size}; 8-bit sRGB, ${codes}; the brightest code stands for ` +
        `${+p.white.toPrecision(3)}${p.quantity ? ` (${p.quantity})` : ""}, what is brighter is cut there` +
        `${p.camera_colours ? "; colours are the camera's own" : ""}.`;
      $("facts").append(line);
    }
    const made = document.createElement("p");
    made.textContent = `Made by ${about.software} view. This file asks for nothing from elsewhere.`;
    $("facts").append(made);
  }

  document.title = first.title || document.title;
  $("title").textContent = first.title || $("title").textContent;
  $("simulated").hidden = !about.panels.some((p) => p.simulated);
  facts();

  /* A pixel chosen in one panel stays the other's own choice: they are different places. */
  const panels = about.panels.map((p, i) => new ttfPanel.Panel($("panels"), p, i, () => {}));
  let done = 0;
  const total = panels.reduce((sum, p) => sum + p.about.slots.length, 0);
  for (const [i, panel] of panels.entries()) {
    const scripts = document.querySelectorAll(`script.p${i}`);
    for (let k = 0; k < scripts.length; k++) {
      await panel.surface.load(k, blob(scripts[k], panel.about.kind));
      if (++done % 16 === 0) {
        $("loading").textContent = `Reading the frames … ${Math.round(100 * done / total)} %`;
        await new Promise((go) => setTimeout(go));
      }
    }
    panel.loaded();
  }

  /* Each moment at which some panel has a frame. */
  const moments = [...new Set(panels.flatMap((p) => p.about.times_s))].sort((a, b) => a - b);
  const frameAt = (p, s) => {
    let k = p.about.times_s.findLastIndex((t) => t <= s + 1e-6);
    return Math.max(0, k);
  };

  function show() {
    const s = moments[Number($("time").value)], stops = Number($("exposure").value);
    const shape = document.querySelector('input[name="shape"]:checked').value;
    for (const p of panels)
      p.show(frameAt(p, s), stops, shape);
    const text = `${ttfPlot.timeText(s)}, slot ${first.slots[frameAt(panels[0], s)]}`;
    $("when").textContent = text;
    $("time").setAttribute("aria-valuetext", text);
    $("stops").textContent = `${stops > 0 ? "+" : ""}${stops} stops`;
    $("exposure").setAttribute("aria-valuetext", $("stops").textContent);
  }

  let playing = false, last = 0, rest = 0;
  function tick(now) {
    if (!playing)
      return;
    rest += Math.min(0.5, (now - last) / 1000) * Number($("speed").value);
    last = now;
    const steps = Math.floor(rest);
    rest -= steps;
    if (steps) {
      $("time").value = (Number($("time").value) + steps) % moments.length;
      show();
    }
    requestAnimationFrame(tick);
  }

  $("play").addEventListener("click", () => {
    playing = !playing;
    $("play").textContent = playing ? "Pause" : "Play";
    last = performance.now();
    rest = 0;
    if (playing)
      requestAnimationFrame(tick);
  });
  for (const name of ["time", "exposure"])
    $(name).addEventListener("input", show);
  const brightest = first.black === 0 ? Math.max(-6, Math.min(6, Math.floor(-4 * Math.log2(first.white)) / 4)) : 0;
  $("fit").addEventListener("click", () => {
    $("exposure").value = brightest;
    show();
  });
  if (brightest > 0.75) /* in the dark there is nothing to be seen at first */
    $("exposure").value = brightest;
  $("shapes").addEventListener("change", show);
  const spheres = panels.every((p) => p.surface.shapes.includes("sphere"));
  $("plain").hidden = spheres;
  $("shapes").hidden = !spheres;
  $("time").max = moments.length - 1;
  $("loading").hidden = true;
  $("controls").hidden = false;
  show();
  document.documentElement.dataset.ready = "yes";
})().catch((error) => {
  document.getElementById("loading").textContent = `This file cannot be shown: ${error.message}`;
});
