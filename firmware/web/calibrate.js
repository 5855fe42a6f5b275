/* SPDX-License-Identifier: Apache-2.0 */
/* calibrate.js: step by step from a camera's own values to reflectance, with the commands as they are to be typed. */
import { h, fill } from "./dom.js";
import { cornersOption, picked, pickedText } from "./picker.js";

export function calibrate(main, box) {
  const { status } = box, board = status?.board || "BOARD", marks = picked(), text = pickedText(marks), simulated = status?.simulated;
  const command = (line) => h("pre", { tabindex: 0, "aria-label": "Command" }, line);
  const b = board === "sim" ? "" : ` --board ${board}`, white = simulated ? " --scene white" : "";
  const busy = status && ["waiting", "capturing", "arming", "paused", "retrying"].includes(status.state);

  fill(main, h("h1", {}, "Calibration, step by step"), h("div", { class: "cards" },
    h("section", { class: "card wide" },
      h("p", {}, "Without a calibration, values are the camera's own (radiance); with one, value 1 is a perfect diffuser wherever it lies (reflectance). It takes ten minutes, and it holds as long as camera, lens, lamps and exposure stay as they are. Each step refuses what cannot be right, and says why."),
      busy && h("p", { class: "finding-warning" }, "A run is under way: the camera belongs to it. Calibrate before a run, or after."),
      h("ol", { class: "steps" },
        h("li", {}, h("strong", {}, "Frame, focus, expose."), " In ", h("a", { href: "#/live" }, "live view"), " turn the lens until the focus number is largest; put the white target in, and set exposure and lamps so that nothing is clipped and the brightest lies near the right end of the histogram. Write them into the plan: the calibration takes them from there."),
        h("li", {}, h("strong", {}, "Dark."), " Close the box; all lamps go off by themselves.", command(`ttfbox calibrate dark${b} -p PLAN -o cal`)),
        h("li", {}, h("strong", {}, "Flat."), " Put an even white target in the sample's place, filling the picture; say how much light it reflects. Lamps are lit and settled first.", command(`ttfbox calibrate flat${b} -p PLAN${white} --reflectance 0.9 -o cal`)),
        h("li", {}, h("strong", {}, "Chart, if colours matter."), " Put a colour chart of 24 patches in the sample's place, under the same lamps; mark the corners of its patches in ", h("a", { href: "#/live" }, "live view"), ", from \"dark skin\" clockwise. Grey stays grey; the report says how far the colours are off before and after.",
          command(`ttfbox calibrate chart${b} -p PLAN${simulated ? " --scene chart" : ""} -o cal${simulated ? "" : ` ${cornersOption(marks) || "--corners X,Y,X,Y,X,Y,X,Y"}`}`)),
        h("li", {}, h("strong", {}, "Grid, if sizes matter."), " Put a printed grid of dark round dots in the sample's place, flat, filling the picture; say how many millimetres they are apart. Datasets then say how large a pixel is; the report says how square the camera looks and what the lens bends.", command(`ttfbox calibrate geometry${b} -p PLAN${simulated ? " --scene dots" : ""} --pitch 5 -o cal`)),
        h("li", {}, h("strong", {}, "Is the light steady?"), " Frame by frame, and in bands across one; it says what helps.", command(`ttfbox calibrate flicker${b} -p PLAN -o cal`)),
        h("li", {}, h("strong", {}, "Look at it."), " How even the light is, how much noise there is, what was refused.", command("ttfbox calibrate report cal")),
        h("li", {}, h("strong", {}, "Use it."), " In the daemon's configuration as ", h("code", {}, "calibration: PATH"), ", or by hand:", command(`ttfbox capture PLAN${b} -c cal -o DATASET`)))),
    h("section", { class: "card" }, h("h2", {}, "What was picked in live view"),
      text ? h("pre", { tabindex: 0, "aria-label": "What was picked" }, text) : h("p", {}, "Nothing yet. Region, reference patch and the corners of a colour chart are marked in ", h("a", { href: "#/live" }, "live view"), "."),
      h("p", { class: "quiet" }, "Region and reference go into the plan, the corners into the chart's command."))));
}
