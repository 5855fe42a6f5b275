/* SPDX-License-Identifier: Apache-2.0 */
/*
 * chart_lamps.h: how long lamps burned, from one record to the next: by the run's lamp programme (the plan's `lamps`) and what the records
 * say of each exposure. Pure; one thread at a time.
 */
#ifndef HTTP_CHART_LAMPS_H
#define HTTP_CHART_LAMPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/record.h"

#define CHART_LAMPS 8

enum chart_lamp_mode {
    CHART_LAMPS_UNKNOWN = 0, /* no plan can be read: the exposures are all that is known */
    CHART_LAMPS_SHOTS,       /* lit for the shots alone */
    CHART_LAMPS_ALWAYS,      /* from the run's beginning to its end */
    CHART_LAMPS_DAYS
};

struct chart_lamps {
    /* of the plan */
    enum chart_lamp_mode mode;
    int64_t settle_ns, day_ns, period_ns, phase_ns;
    bool local;
    int day_start_s;
    unsigned n_background;
    char background[CHART_LAMPS][32]; /* lamps that burn between slots */
    /* of the segment */
    struct ttf_segment segment;
    bool has_segment;
    int64_t until_ns; /* what burned before it is counted; TTF_NS_UNKNOWN: nothing burned yet */
};

struct chart_lit {
    char name[32];
    int64_t ns;
};

/* The plan's JSON (plans/N.json); one that cannot be understood: the mode is UNKNOWN. */
void chart_lamps_plan(struct chart_lamps *lamps, const char *json, size_t bytes);

/* From here on; a line that corrects the same segment changes nothing but its times. */
void chart_lamps_segment(struct chart_lamps *lamps, const struct ttf_segment *segment);

/* What burned since the record before this one. Returns how many. */
unsigned chart_lamps_add(struct chart_lamps *lamps, const struct ttf_slot_record *record,
                         struct chart_lit ret[CHART_LAMPS]);

#endif
