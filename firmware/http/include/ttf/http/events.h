/* SPDX-License-Identifier: Apache-2.0 */
/*
 * events.h: what happens, for whoever listens: a ring of the last events, and listeners that each remember only how far
 * they have read. One that does not read falls behind and is cut off; nobody waits for it.
 *
 * Not for a thread that a slot waits for: publishing takes a lock that listeners take too.
 */
#ifndef TTF_HTTP_EVENTS_H
#define TTF_HTTP_EVENTS_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

#define TTF_HTTP_EVENTS_KEPT   1024
#define TTF_HTTP_EVENT_MAX     8192 /* bytes of one's JSON; a longer one is left out */
#define TTF_HTTP_LISTENERS_MAX 128
#define TTF_HTTP_EVENT_ID_SIZE 40

struct ttf_http_events;

/* -EIO: no randomness; -ENOMEM. */
TTF_MUST_USE int ttf_http_events_create(struct ttf_http_events **ret, struct ttf_err *err);
void ttf_http_events_destroy(
    struct ttf_http_events *events); /* NULL allowed; no server uses it any more */

/* kind: a word; json: one value on one line. Any thread. What finds no memory is left out: listeners hear `missed`. */
void ttf_http_events_publish(struct ttf_http_events *events, const char *kind, const char *json);

/* Each listener who has heard nothing since the last tick is told that this server lives. Every 10 s or so. */
void ttf_http_events_tick(struct ttf_http_events *events);

/* The id of the last event; of a start without any, the one before the first. Returns ret. */
const char *ttf_http_events_last(struct ttf_http_events *events, char ret[TTF_HTTP_EVENT_ID_SIZE]);

#endif
