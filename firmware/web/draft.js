/* SPDX-License-Identifier: Apache-2.0 */
/* draft.js: what somebody typed into a form, until they are done with it: whoever goes to live view and comes back, or loads the page anew, types nothing twice. In this browser's tab alone. */

const key = (form) => `draft.${form}`;

/* What was kept of it, or null. */
export function kept(form) {
  try {
    return JSON.parse(sessionStorage.getItem(key(form)));
  } catch {
    return null;
  }
}

export function keep(form, what) {
  try {
    sessionStorage.setItem(key(form), JSON.stringify(what));
  } catch { /* it is kept no longer than the part is seen */ }
}

export function forget(form) {
  try {
    sessionStorage.removeItem(key(form));
  } catch { /* then nothing was kept */ }
}

/* The values of fields, by name; and back, where there is one of the name and a value for it. */
export const valuesOf = (fields) => Object.fromEntries(Object.entries(fields).map(([name, e]) => [name, e.type === "checkbox" ? e.checked : e.value]));

export function putValues(fields, values) {
  for (const [name, e] of Object.entries(fields))
    if (values?.[name] !== undefined)
      e[e.type === "checkbox" ? "checked" : "value"] = values[name];
}
