/* SPDX-License-Identifier: Apache-2.0 */
/*
 * alarms.h: what a person is needed for: the last eight that the program heard of and that are not over yet. Locked by whoever
 * has them.
 */
#ifndef DAEMON_ALARMS_H
#define DAEMON_ALARMS_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/capture/session.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/hal/clock.h"

#define ALARMS_KEPT 8

struct alarm {
    int64_t utc_ns; /* TTF_NS_UNKNOWN */
    int64_t run;    /* whose it is, its number */
    enum ttf_alarm_until until;
    char text[256];
};

/* Zeroed: none. */
struct alarms {
    unsigned n;
    struct alarm kept[ALARMS_KEPT]; /* the oldest first */
};

/* The oldest makes room; one of the same text that was there already. */
void alarms_add(struct alarms *alarms, struct ttf_clock *clock, int64_t run,
                enum ttf_alarm_until until, const char *text);

/* What is over is taken away; true: something was. */

bool alarms_over(struct alarms *alarms, const char *text); /* all of this text */
/* This run was armed: what ended one, and what another one said of its storage. */
bool alarms_armed(struct alarms *alarms, int64_t run);
/* This run is done: what ended it. */
bool alarms_done(struct alarms *alarms, int64_t run);

/* As an array. */
void alarms_put(const struct alarms *alarms, struct ttf_json *json);

#endif
