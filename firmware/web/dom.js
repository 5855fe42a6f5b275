/* SPDX-License-Identifier: Apache-2.0 */
/* dom.js: elements in one line. Texts go in as texts, never as markup. */

/*
 * h("button", {class: "main", onclick: f, "aria-pressed": "true"}, "Start"): properties that begin with "on"
 * are listeners, true and false set and leave out, the rest are attributes. Children: nodes, texts, lists, nothing.
 */
export function h(name, properties, ...children) {
  const e = document.createElement(name);
  for (const [key, value] of Object.entries(properties || {})) {
    if (key.startsWith("on"))
      e.addEventListener(key.slice(2), value);
    else if (value === true)
      e.setAttribute(key, "");
    else if (value !== false && value !== null && value !== undefined)
      e.setAttribute(key, value);
  }
  e.append(...children.flat(3).filter((c) => c !== null && c !== undefined && c !== false));
  return e;
}

/* What an element holds from now on. */
export function fill(e, ...children) {
  e.replaceChildren(...children.flat(3).filter((c) => c !== null && c !== undefined && c !== false));
  return e;
}

/*
 * The same, made anew only where `of`, what it is about, is another than the last time: a link or a button that somebody is at
 * stays, and screen readers hear nothing twice.
 */
const SHOWN = new WeakMap();
export function renew(e, of, make) {
  const key = JSON.stringify(of);
  if (SHOWN.get(e) === key)
    return;
  SHOWN.set(e, key);
  fill(e, make());
}

export function facts(pairs) {
  return h("dl", { class: "facts" }, pairs.filter(Boolean).map(([term, value]) => [h("dt", {}, term), h("dd", {}, value)]));
}

/* Only what is new is written, so that screen readers hear no more than that. */
export function say(e, text) {
  if (e.textContent !== text)
    e.textContent = text;
}

/*
 * A question in the page's dialog. Gives the name of the button that was pressed, null if it was closed.
 * `content` may hold fields.
 */
export function ask(title, content, buttons) {
  const dialog = document.getElementById("ask");
  return new Promise((resolve) => {
    fill(dialog, h("form", { method: "dialog" },
      h("h2", { id: "ask-title" }, title), content,
      h("div", { class: "row end" }, buttons.map(({ name, text, kind }) => h("button", { value: name, class: kind || false }, text)))));
    dialog.onclose = () => resolve(dialog.returnValue || null);
    dialog.returnValue = "";
    dialog.showModal();
  });
}
