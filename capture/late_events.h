/* SPDX-License-Identifier: Apache-2.0 */
/*
 * late_events.h: events that could not be written yet, in order. There is room for
 * so many of them; those beyond are lost, but not in silence: an event of kind
 * "lost" stands in their place and says how many. Pure.
 */
#ifndef TTF_CAPTURE_PRIVATE_LATE_EVENTS_H
#define TTF_CAPTURE_PRIVATE_LATE_EVENTS_H

#include "stock.h"

#define TTF_LATE_EVENTS 64

struct ttf_late_events {
    struct ttf_job wait[TTF_LATE_EVENTS + 1]; /* oldest first; the last place is for a "lost" one */
    unsigned n;
};

/* Keeps a copy, behind all that wait. */
void ttf_late_events_keep(struct ttf_late_events *late, const struct ttf_job *event);

/* Takes the oldest out. There is one. */
void ttf_late_events_drop_first(struct ttf_late_events *late);

/* The event that tells of those lost ones. */
void ttf_late_events_lost(struct ttf_job *ret, const struct ttf_lost *lost);

/* All that wait or are lost, as if the storage will take none of them. */
struct ttf_lost ttf_late_events_all(const struct ttf_late_events *late);

#endif
