/* SPDX-License-Identifier: Apache-2.0 */
/*
 * features.h: short stand-ins for trajectories whose squared distances never
 * exceed the trajectories' own (rounding apart), so that they exclude candidates
 * without looking at all frames.
 *
 * Of a pixel: its coefficients in an orthonormal basis and, last, the length of
 * what the basis misses (by the triangle inequality the difference of lengths
 * is at most the length of the difference). Of a cell of c x c pixels: sums of
 * fewer such numbers over c (Cauchy: |sum|^2 / c^2 is at most the sum of squares).
 */
#ifndef TTF_SYNTH_SEARCH_FEATURES_H
#define TTF_SYNTH_SEARCH_FEATURES_H

#include "search/basis.h"
#include "search/kernels.h"
#include "search/trajectories.h"
#include "ttf/base/attr.h"

struct ttf_features {
    uint32_t width, height;
    uint32_t cell;                 /* side: 1, 2 or 4 pixels */
    float *cells[TTF_CELL_PLANES]; /* height x width each; cell whose corner is (x, y) */
    float *pixels;                 /* height x width x TTF_PIXEL_COEFS; NULL: not worth it */
    struct ttf_basis basis;
    double slack; /* upper bound of the rounding error of any one number */
};

/* -ENOMEM. */
TTF_MUST_USE int ttf_features_build(const struct ttf_trajectories *trajectories, uint32_t cell,
                                    struct ttf_pool *pool, struct ttf_features *ret);
void ttf_features_free(struct ttf_features *features);

/*
 * One pixel's own numbers, for targets: those that cells sum, and those of the
 * second bound (coefs may be NULL; all zero beyond the basis where there is no pixel level).
 */
void ttf_features_of_pixel(const struct ttf_features *features,
                           const struct ttf_trajectories *trajectories, size_t pixel,
                           float cell[TTF_CELL_PLANES], float *coefs);

/* Bytes per input pixel that features of n frames take. */
size_t ttf_features_bytes_per_pixel(uint32_t frames);

#endif
