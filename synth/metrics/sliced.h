/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sliced.h: the parts of sliced Wasserstein-1 distances: hashed directions, and the
 * 1-D distance of two histograms. A shift by one code along a direction is
 * TTF_SLICED_BINS_PER_CODE bins.
 *
 * Directions are integers, so that a projection is exact and its bin is the same
 * on every machine; their rounding turns them by less than a thousandth.
 */
#ifndef TTF_SYNTH_METRICS_SLICED_H
#define TTF_SYNTH_METRICS_SLICED_H

#include <stdint.h>

#include "search/hash.h"

/* Length of a direction; and how a projection, made positive, becomes a bin. */
#define TTF_SLICED_UNIT          16384
#define TTF_SLICED_SHIFT         12
#define TTF_SLICED_BINS_PER_CODE (TTF_SLICED_UNIT >> TTF_SLICED_SHIFT)
#define TTF_SLICED_DIMENSIONS    147

/* Direction `which` of a space of n <= TTF_SLICED_DIMENSIONS dimensions. */
void ttf_sliced_direction(enum ttf_purpose purpose, unsigned which, unsigned n, int16_t *ret);

/* What to add to projections of codes 0..255 so that the least possible is 0. */
int32_t ttf_sliced_offset(const int16_t *direction, unsigned n);

/* Bins that projections of codes 0..255 can fall into. */
unsigned ttf_sliced_bins(const int16_t *direction, unsigned n);

/* Wasserstein-1 distance of two histograms that count n_a and n_b (not 0), in codes. */
double ttf_sliced_distance(const uint32_t *a, uint64_t n_a, const uint32_t *b, uint64_t n_b,
                           unsigned bins);

#endif
