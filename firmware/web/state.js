/* SPDX-License-Identifier: Apache-2.0 */
/* state.js: what the box does, in words. */

const WORDS = {
  none: ["Datasets only", ""],
  idle: ["Idle", ""],
  waiting: ["Waiting to start", "warn"],
  arming: ["Preparing", "warn"],
  capturing: ["Capturing", "good"],
  paused: ["Paused", "warn"],
  stopping: ["Stopping", "warn"],
  retrying: ["Failed, tries again", "bad"],
  stopped: ["Stopped", "bad"],
};

/* {text, said, kind}: as the page's head and the window's title have it; the same without what changes with each slot, to be read out; how it is coloured. */
export function stateWords(status, lost) {
  if (lost)
    return { text: "Connection lost", said: "Connection lost", kind: "bad" };
  if (!status)
    return { text: "…", said: "", kind: "" };
  const [text, kind] = WORDS[status.state] || [status.state, ""], { run } = status;
  if (status.state === "idle" && run?.sealed)
    return { text: "Done", said: "Done", kind: "" };
  if (run?.slots !== undefined && ["capturing", "paused", "stopped"].includes(status.state))
    return { text: `${text} ${run.done || 0}/${run.slots}`, said: text, kind };
  return { text, said: text, kind };
}

/* Results that a slot may have, good ones first. */
export const RESULTS = ["captured", "partial", "paused", "missed", "failed", "power"];

/* "98 captured, 2 missed" */
export function results(counts) {
  const parts = RESULTS.filter((name) => counts?.[name]).map((name) => `${counts[name].toLocaleString()} ${name}`);
  return parts.length ? parts.join(", ") : "none yet";
}
