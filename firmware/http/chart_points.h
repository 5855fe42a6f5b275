/* SPDX-License-Identifier: Apache-2.0 */
/*
 * chart_points.h: columns of a dataset's records, downsampled as they come: at most CHART_POINTS points, each of so many
 * slots, with the least and the greatest value of each column, so that a spike of one slot is never hidden. When there
 * is no room for another point, two become one and each holds twice as many slots. Pure; one thread at a time.
 */
#ifndef HTTP_CHART_POINTS_H
#define HTTP_CHART_POINTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "chart_lamps.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/record.h"

#define CHART_POINTS 1024 /* at most; at least half of it once there were more slots than that */
#define CHART_SERIES 48   /* columns; more are left out */

enum chart_what {
    CHART_REFERENCE = 0, /* reference_level of a stream's image */
    CHART_MEAN,          /* mean_level */
    CHART_ERROR,         /* middle - due, s */
    CHART_SENSOR,        /* value of a sensor, in its kind's unit */
    CHART_LAMP           /* hours so far that a lamp burned */
};

struct chart_value {
    double min, max, sum;
    uint32_t n; /* 0: no slot of this point has one */
};

struct chart_series {
    enum chart_what what;
    char name[32]; /* of the stream, sensor or lamp */
    char kind[24]; /* of the sensor */
    int bracket;   /* of the image; -1: none */
    double total;  /* of a lamp: hours */
    struct chart_value *value;
};

struct chart_point {
    int64_t index, due_ns; /* of its first slot; due on the segment's boot clock */
    int64_t pictured;      /* its first slot that has a picture; -1: none has */
    int segment;
    uint32_t results[TTF_RESULT_COUNT]; /* slots by result; all 0: a hole */
};

struct chart_points {
    int64_t slots, base, width; /* taken; index of the first; slots per point */
    unsigned n, n_series;
    struct chart_point *point;
    struct chart_series series[CHART_SERIES];
};

/* Zeroed is empty. lamps: of the dataset, told of the record's segment and plan before it. 0, -ENOMEM. */
TTF_MUST_USE int chart_points_add(struct chart_points *points, struct chart_lamps *lamps,
                                  const struct ttf_slot_record *record);
void chart_points_free(struct chart_points *points); /* empty again */

#endif
