/* SPDX-License-Identifier: Apache-2.0 */
/*
 * box.js: what the box does, as it happens. Browsers hold six connections to a host, so of all pages
 * that are open here one listens and tells the others: the one that holds a lock of the browser's. Where there are no such
 * locks (a page of plain HTTP, but for this machine's own) they agree by saying "lead" every BEAT_MS.
 *
 * Events of a Box: "status" (box.status is new), "lost" (box.lost changed), "session" (who may what), "stale" (what is seen may be
 * old: it was away, events were missed, nobody looked; where there is no box to tell of anything, at each look), and each of the
 * box's own ("slot", "readings", "event", "alarm", "asked", "preview"), with their data as `detail`.
 */
import { get, post } from "./api.js";

const KINDS = ["state", "slot", "readings", "event", "alarm", "asked", "preview", "missed"];
const BEAT_MS = 2000, SILENT_MS = 5500, LOOK_MS = 5000, LOST_LOOK_MS = 2000, LOCK = "ttfbox-events";
const ANSWER_LOOK_MS = 2000, PATIENCE_MS = 120000, SILENT = "the box does not answer";

export class Box extends EventTarget {
  constructor() {
    super();
    this.status = null;
    this.received = 0; /* performance.now() of the status */
    this.lost = false;
    this.trouble = ""; /* why, where it is lost */
    this.session = { box: true, read: true, change: false };
    this.id = Math.random().toString(36).slice(2);
    this.leading = false;
    this.holds = this.waiting = false; /* the lock, or in line for it */
    this.heard = performance.now();
  }

  async start() {
    await this.ask_session();
    this.channel = "BroadcastChannel" in globalThis ? new BroadcastChannel("ttfbox") : null;
    if (this.channel)
      this.channel.onmessage = ({ data }) => this.told(data);
    if (this.channel && navigator.locks) {
      this.lead_by_lock();
    } else if (this.channel) {
      addEventListener("pagehide", () => this.leading && this.channel.postMessage({ what: "leave" }));
      setInterval(() => this.beat(), BEAT_MS);
      this.heard = performance.now() - SILENT_MS; /* the first page waits no longer than others need to answer */
      this.channel.postMessage({ what: "who" });
      setTimeout(() => this.beat(), 300 + Math.random() * 300);
    } else {
      this.holds = true; /* there is nobody to share with */
      this.lead();
    }
    document.addEventListener("visibilitychange", () => document.hidden || this.look().then(() => this.say_stale()));
    await this.look();
    this.again();
  }

  /* A token was given or taken back: everything again, of the other pages as well. */
  async renew() {
    await this.ask_session();
    this.channel?.postMessage({ what: "session" });
    if (this.holds) { /* it is this page that listens, or that could not */
      this.unlead();
      this.lead();
    } else if (!this.waiting) {
      this.unlead();
      this.heard = 0;
      this.beat();
    }
    await this.look();
  }

  async ask_session() {
    try {
      this.session = await get("session", 4000);
      this.listen(); /* another page may have given the token */
      this.dispatchEvent(new Event("session"));
      if (!this.session.read)
        this.set_lost(false);
    } catch (error) {
      if (!error.status && !this.session.read)
        this.set_lost(true, SILENT); /* else look() says so */
    }
  }

  again() {
    clearTimeout(this.timer);
    this.timer = setTimeout(async () => {
      if (!document.hidden || this.lost)
        await this.look();
      this.again();
    }, this.lost ? LOST_LOOK_MS : LOOK_MS);
  }

  async look() {
    if (!this.session.read) { /* it would be refused; whether that is still so can be asked */
      await this.ask_session();
      if (!this.session.read)
        return;
    }
    try {
      const status = await get("status", 4000);
      this.status = status;
      this.received = performance.now();
      this.set_lost(false);
      this.dispatchEvent(new Event("status"));
      if (status.state === "none")
        this.say_stale();
      if (status.time?.trust === "none")
        await this.offer_time();
    } catch (error) {
      if (error.status === 401) {
        this.set_lost(false);
        if (this.session.read) {
          this.session = { ...this.session, read: false, change: false };
          this.dispatchEvent(new Event("session"));
        }
      } else if (error.status && !this.session.box) {
        this.set_lost(false); /* there is none to be asked; what serves the datasets is there */
      } else { /* an error for an answer: what is seen grows old as if none came */
        this.set_lost(true, error.status ? `it cannot say how it is (${error.text})` : SILENT);
      }
    }
  }

  /* A box whose clock nobody vouches for takes this machine's, from whoever may change it; once, whatever it says to it. */
  async offer_time() {
    if (this.offered || !this.session.change)
      return;
    this.offered = true;
    try {
      await post("time", `{"utc_ns":${BigInt(Date.now()) * 1000000n}}`);
    } catch { /* it goes on without */ }
  }

  set_lost(lost, trouble = "") {
    if (this.lost === lost && this.trouble === trouble)
      return;
    const found = this.lost && !lost;
    this.lost = lost;
    this.trouble = trouble;
    this.offered = this.offered && !lost; /* it may have been started anew */
    if (!lost)
      this.ask_session(); /* it may have been another box, or the same with another token */
    this.dispatchEvent(new Event("lost"));
    if (found)
      this.say_stale();
    this.again();
  }

  say_stale() {
    this.dispatchEvent(new Event("stale"));
  }

  /* ---- one listens ---- */

  /* From when the lock is this page's until the page is closed; the browser then gives it to another. */
  lead_by_lock() {
    this.waiting = true;
    navigator.locks.request(LOCK, () => {
      this.waiting = false;
      this.holds = true;
      this.lead();
      return new Promise(() => {});
    }).catch(() => { /* the page is about to go */ });
  }

  beat() {
    if (this.leading)
      this.say_lead();
    else if (performance.now() - this.heard > SILENT_MS)
      this.lead();
  }

  told(data) {
    if (data.what === "lead") {
      this.heard = performance.now();
      /* Timers of a page that nobody sees come late: one that is seen listens, of equals one of them. */
      if (this.holds || !this.leading)
        return;
      if (data.hidden === document.hidden ? data.id < this.id : document.hidden)
        this.unlead();
      else
        this.say_lead(); /* at once: the other has not heard of this one, and would listen as well until the next beat */
    } else if (data.what === "who") {
      if (this.leading)
        this.say_lead();
    } else if (data.what === "leave") {
      this.heard = performance.now() - SILENT_MS + Math.random() * 1000;
    } else if (data.what === "session") {
      this.ask_session().then(() => this.look());
    } else if (data.what === "event") {
      this.happened(data.kind, data.detail);
    }
  }

  lead() {
    this.leading = true;
    this.say_lead();
    this.listen();
  }

  listen() {
    if (this.source || !this.leading || !this.session.box || !this.session.read)
      return;
    this.source = new EventSource("/api/v1/events");
    for (const kind of KINDS)
      this.source.addEventListener(kind, ({ data }) => {
        let detail = {};
        try {
          detail = JSON.parse(data);
        } catch { /* an empty one */ }
        this.channel?.postMessage({ what: "event", kind, detail });
        this.happened(kind, detail);
      });
    let opened = false;
    this.source.onopen = () => {
      if (opened)
        this.look(); /* it was away: what happened meanwhile is in the status */
      opened = true;
    };
    this.source.onerror = () => {
      this.look();
      if (this.source?.readyState === EventSource.CLOSED) { /* refused: the browser does not try again by itself */
        this.unlead();
        this.heard = performance.now();
        if (this.holds)
          setTimeout(() => this.leading || this.lead(), SILENT_MS);
      }
    };
  }

  say_lead() {
    this.channel?.postMessage({ what: "lead", id: this.id, hidden: document.hidden });
  }

  unlead() {
    this.source?.close();
    this.source = null;
    this.leading = false;
  }

  happened(kind, detail) {
    if (kind === "slot" && this.status?.run && this.status.run.dataset === detail.dataset) { /* else of a run that the status does not know yet */
      const { run } = this.status;
      this.pass();
      Object.assign(run, { last: detail, next: detail.next, done: Math.max(run.done || 0, detail.index + 1), slots: detail.total || run.slots });
      this.status.state = this.status.state === "arming" ? "capturing" : this.status.state;
    }
    if (kind === "readings" && this.status)
      this.status.readings = detail;
    if (kind === "state" || kind === "missed" || kind === "slot" || kind === "alarm")
      this.look_soon();
    if (kind === "slot" || kind === "readings")
      this.dispatchEvent(new Event("status"));
    if (kind === "missed")
      this.say_stale();
    this.dispatchEvent(new CustomEvent(kind, { detail }));
  }

  /* Times that are left, as of now. */
  pass() {
    const now = performance.now(), passed_ns = (now - this.received) * 1e6, { status } = this;
    for (const [of, key] of [[status, "retry_in_ns"], [status.run, "ends_in_ns"], [status.run, "settled_in_ns"]])
      if (of[key] !== undefined)
        of[key] -= passed_ns;
    this.received = now;
  }

  /* Slots may come several times a second; the status need not. */
  look_soon() {
    this.soon ??= setTimeout(() => {
      this.soon = null;
      this.look();
    }, 400);
  }

  /* ---- what is asked of it ---- */

  /*
   * Until the box says what came of it. Throws what it could not do; and where that is not to be had any more, as it was
   * started again meanwhile, or not in time (PATIENCE_MS), that it is not known.
   */
  async order(path, body) {
    const asked = await post(path, body);
    const { number } = asked;
    if (asked.answered || number === undefined)
      return asked;
    return new Promise((resolve, reject) => {
      const done = ({ detail }) => {
        if (detail.number !== number || detail.answered === false)
          return;
        stop();
        if (detail.error)
          reject(new Error(detail.error));
        else
          resolve(detail);
      };
      const give_up = (text) => {
        stop();
        reject(new Error(text));
      };
      const poll = setInterval(() => get(`run/asked/${number}`).then((d) => done({ detail: d }), (error) => {
        if (error.status === 404)
          give_up("the box was started again and does not know what came of it: look at its state");
      }), ANSWER_LOOK_MS);
      const late = setTimeout(give_up, PATIENCE_MS, "the box has not said what came of it; it may still be done: look at its state");
      const stop = () => {
        clearInterval(poll);
        clearTimeout(late);
        this.removeEventListener("asked", done);
      };
      this.addEventListener("asked", done);
    });
  }

  /* {kind: listener, ...}, until what this gives back is called. */
  on(listeners) {
    for (const [kind, listener] of Object.entries(listeners))
      this.addEventListener(kind, listener);
    return () => {
      for (const [kind, listener] of Object.entries(listeners))
        this.removeEventListener(kind, listener);
    };
  }

  /* Nanoseconds until the next slot, now; undefined where none is to come. */
  next_in_ns() {
    const next = this.status?.run?.next;
    return next?.in_ns === undefined ? undefined : next.in_ns - (performance.now() - this.received) * 1e6;
  }

  ends_in_ns() {
    return this.left_ns("ends_in_ns");
  }

  /* While the lamps warm up before slots begin: until they have. */
  settled_in_ns() {
    return this.left_ns("settled_in_ns");
  }

  left_ns(key) {
    const ns = this.status?.run?.[key];
    return ns === undefined ? undefined : ns - (performance.now() - this.received) * 1e6;
  }
}
