/* SPDX-License-Identifier: Apache-2.0 */
/*
 * metrics.h: objective figures of a synthesized sequence against its input,
 * accumulated frame by frame. Display-encoded values, 0..255.
 */
#ifndef TTF_SYNTH_METRICS_H
#define TTF_SYNTH_METRICS_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/colour.h"

/* Temporal activity of one sequence. */
struct ttf_activity;

/* NULL: no memory. */
struct ttf_activity *ttf_activity_create(uint32_t width, uint32_t height,
                                         const struct ttf_encoding *encoding);
void ttf_activity_destroy(struct ttf_activity *activity);

/* The next frame, width x height x 3 codes. */
void ttf_activity_add(struct ttf_activity *activity, const uint16_t *frame);

struct ttf_activity_figures {
    uint32_t frames;
    double mean_difference; /* mean absolute difference of successive frames */
    double
        second_difference; /* mean absolute second difference of 4 x 4 box-averaged frames: flicker, less noise */
    double mean_rgb[3]; /* over all frames */
};
void ttf_activity_figures(const struct ttf_activity *activity, struct ttf_activity_figures *ret);

#endif
