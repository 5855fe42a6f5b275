/* SPDX-License-Identifier: Apache-2.0 */
/* play.js: a button that goes from picture to picture by itself until it is pressed again. */
import { h } from "./dom.js";

/* `step`: to the next one; `caption`: what says which it is, and cannot be listened to as fast as that. {button, end} */
export function player(step, ms, caption) {
  let timer = 0;
  const button = h("button", { type: "button", onclick: toggle }, "Play");
  caption.setAttribute("aria-live", "polite");

  function toggle() {
    clearInterval(timer);
    timer = timer ? 0 : setInterval(step, ms);
    button.textContent = timer ? "Pause" : "Play";
    caption.setAttribute("aria-live", timer ? "off" : "polite");
  }

  return { button, end: () => clearInterval(timer) };
}
