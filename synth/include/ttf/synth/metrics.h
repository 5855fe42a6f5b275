/* SPDX-License-Identifier: Apache-2.0 */
/*
 * metrics.h: objective figures of a synthesized sequence against its input,
 * accumulated frame by frame. Display-encoded values, 0..255. All sums are of
 * integers: the same figures for any order of threads.
 */
#ifndef TTF_SYNTH_METRICS_H
#define TTF_SYNTH_METRICS_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/colour.h"
#include "ttf/dataset/pool.h"
#include "ttf/synth/quilt.h"

/* Temporal activity of one sequence. */
struct ttf_activity;

/* NULL: no memory, or a size of 0. Holds one 8-bit frame and little more. */
struct ttf_activity *ttf_activity_create(uint32_t width, uint32_t height,
                                         const struct ttf_encoding *encoding);
void ttf_activity_destroy(struct ttf_activity *activity);

/* The next frame, width x height x 3 codes. pool: may be NULL. -ENOMEM, of the first frame alone. */
TTF_MUST_USE int ttf_activity_add(struct ttf_activity *activity, struct ttf_pool *pool,
                                  const uint16_t *frame);

/* The same of display codes: several times as fast. */
void ttf_activity_add8(struct ttf_activity *activity, struct ttf_pool *pool, const uint8_t *frame);

struct ttf_activity_figures {
    uint32_t frames;
    double mean_difference;   /* mean absolute difference of successive frames */
    double second_difference; /* mean absolute second difference of 4 x 4 box averages: flicker */
    double mean_rgb[3];       /* over all frames */
};
/* Figures that need more frames than there were are 0. */
void ttf_activity_figures(const struct ttf_activity *activity, struct ttf_activity_figures *ret);

/*
 * Seams: pairs of neighbouring output pixels that were not neighbours in the
 * source. Their mean absolute step is set against the steps that the same pixels
 * make to the neighbour they lost, and against the input's mean step.
 */
struct ttf_seams;

/* The map must outlive it. NULL: no memory. */
struct ttf_seams *ttf_seams_create(const struct ttf_quilt_map *map,
                                   const struct ttf_encoding *encoding);
void ttf_seams_destroy(struct ttf_seams *seams);

/* One frame: the sources' (all inputs' pixels by id) and the output's (map size). */
void ttf_seams_add(struct ttf_seams *seams, const uint16_t *source, const uint16_t *output);

struct ttf_seams_figures {
    uint64_t pairs;         /* seam pairs in the map */
    uint32_t frames;        /* frames looked at */
    double pair_share;      /* of all neighbouring pairs of the output */
    double seam_gradient;   /* mean absolute step across seams, codes */
    double source_gradient; /* of the same pixels to the neighbours they had in the source */
    double input_gradient;  /* of all neighbouring pairs of the input */
    double
        excess; /* seam / source gradient - 1: 0 = seams no stronger than the texture; NAN: no seams or no gradient */
    double input_excess; /* seam / input gradient - 1 */
};
void ttf_seams_figures(const struct ttf_seams *seams, struct ttf_seams_figures *ret);

/* How much of the output says the same thing twice. */
struct ttf_repetition_figures {
    double
        verbatim_share; /* blocks that go on exactly where the left or upper one was taken from */
    double source_coverage; /* share of the source's pixels that occur in the output */
    double mean_uses;       /* output pixels per source pixel that occurs */
    uint32_t max_uses;
};
/* -ENOMEM. */
TTF_MUST_USE int ttf_repetition_of_map(const struct ttf_quilt_map *map,
                                       struct ttf_repetition_figures *ret);

#endif
