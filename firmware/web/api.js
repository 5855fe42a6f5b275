/* SPDX-License-Identifier: Apache-2.0 */
/* api.js: the box's interface (openapi.yaml). Errors carry what the box said: what, where, what to do. */

/* Names that the interface has for what the page calls otherwise. */
const FIELDS = { exposure_ns: "exposure", gain_milli: "gain", pitch: "dots apart", pitch_mm: "dots apart", reflectance: "it reflects", frames: "frames of a step", corners: "the chart's corners" };

/* What the box refuses, in one line: of an answer, of a step, of a plan. */
export function refusal({ where, error, hint }) {
  return [where && `${FIELDS[where] || where}: `, error, hint && ` (${hint})`].filter(Boolean).join("");
}

export class ApiError extends Error {
  constructor(status, body) {
    super(body?.error || (status ? `the box answered ${status}` : "the box does not answer"));
    Object.assign(this, { status, where: body?.where, hint: status === 401 && body?.hint ? "enter it by the button at the top" : body?.hint }); /* programs are told of a header */
  }

  /* All of it in one line. */
  get text() {
    return refusal({ where: this.where, error: this.message, hint: this.hint });
  }
}

const V1 = "/api/v1";

async function ask(path, options = {}, patience_ms = 20000) {
  let answer;
  try {
    answer = await fetch(path.startsWith("/") ? path : `${V1}/${path}`, {
      cache: "no-store", credentials: "same-origin", redirect: "error", signal: AbortSignal.timeout(patience_ms), ...options });
  } catch (error) {
    throw new ApiError(0, error.name === "AbortError" ? { error: "stopped" } : null);
  }
  if (!answer.ok) {
    let body = null;
    try {
      body = await answer.json();
    } catch { /* not ours to read */ }
    throw new ApiError(answer.status, body);
  }
  return answer;
}

export const get = async (path, patience_ms) => (await ask(path, {}, patience_ms)).json();
export const getText = async (path, options) => (await ask(path, options)).text();

/* A picture, with what its headers say. */
export async function getPicture(path, patience_ms = 60000) {
  const answer = await ask(path, {}, patience_ms);
  return { blob: await answer.blob(), dataset: answer.headers.get("X-Ttfbox-Dataset"),
    index: answer.headers.get("X-Ttfbox-Index"), live: answer.headers.get("X-Ttfbox-Live"),
    exposure_ms: Number(answer.headers.get("X-Ttfbox-Exposure-Ns")) / 1e6, gain: Number(answer.headers.get("X-Ttfbox-Gain-Milli")) / 1000 };
}

async function send(method, path, body, type = "application/json") {
  const options = { method, headers: { "X-Ttfbox": "1" } };
  if (body !== undefined) {
    options.headers["Content-Type"] = type;
    options.body = typeof body === "string" ? body : JSON.stringify(body);
  }
  return (await ask(path, options, 60000)).json();
}

export const post = (path, body) => send("POST", path, body);
export const put = (path, body) => send("PUT", path, body);
export const postYaml = (path, text) => send("POST", path, text, "application/yaml");
export const putPlan = (name, text) => send("PUT", `plans/${encodeURIComponent(name)}`, text, "application/yaml");
export const putBoard = (name, text) => send("PUT", `boards/${encodeURIComponent(name)}`, text, "application/yaml");
export const remove = (path) => send("DELETE", path);

/* Lines of "events" or "notes", or those in the last so many bytes; what is no JSON, as after a crash or where that cuts, is passed over. */
export async function getLines(dataset, log, last_bytes) {
  const text = await getText(`datasets/${encodeURIComponent(dataset)}/${log}`, last_bytes ? { headers: { Range: `bytes=-${last_bytes}` } } : {});
  return text.split("\n").filter(Boolean).flatMap((line) => {
    try {
      return [JSON.parse(line)];
    } catch {
      return [];
    }
  });
}
