/* SPDX-License-Identifier: Apache-2.0 */
/* events.h: what happened, on its way to events.jsonl. Any thread. */
#ifndef TTF_CAPTURE_PRIVATE_EVENTS_H
#define TTF_CAPTURE_PRIVATE_EVENTS_H

#include "queue.h"

struct ttf_events {
    struct ttf_queue *queue;
    struct ttf_clock *clock;
};

/* kind: "retry", "camera", "lamp-trip", "lamp-level", "clock-step", "clock", "resume", "plan", "pause", "disk", "storage", "door", "sensor", "focus", "dew", "supply", "button", "box", "watchdog", "stop"; of the committer's own "lost". */
void ttf_events_emit(struct ttf_events *events, const char *kind, const char *fmt, ...)
    TTF_PRINTF(3, 4);

/* The same of one by which the run comes to so many slots from now on. */
void ttf_events_emit_end(struct ttf_events *events, int64_t total, const char *kind,
                         const char *fmt, ...) TTF_PRINTF(4, 5);

#endif
