/* SPDX-License-Identifier: Apache-2.0 */
/*
 * alarms.h: what a person was needed for since the program began, but for what is told to be over: the last eight. Locked by
 * whoever has them.
 */
#ifndef DAEMON_ALARMS_H
#define DAEMON_ALARMS_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/dataset/json_writer.h"
#include "ttf/hal/clock.h"

#define ALARMS_KEPT 8

struct alarm {
    int64_t utc_ns; /* TTF_NS_UNKNOWN */
    char text[256];
};

/* Zeroed: none. */
struct alarms {
    unsigned n;
    struct alarm kept[ALARMS_KEPT]; /* the oldest first */
};

/* The oldest makes room; one of the same text that was there already. */
void alarms_add(struct alarms *alarms, struct ttf_clock *clock, const char *text);
/* true: there was one of this text, and is none any more. */
bool alarms_over(struct alarms *alarms, const char *text);

/* As an array. */
void alarms_put(const struct alarms *alarms, struct ttf_json *json);

#endif
