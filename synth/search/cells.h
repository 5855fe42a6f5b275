/* SPDX-License-Identifier: Apache-2.0 */
/*
 * cells.h: short stand-ins for cell x cell pixels, for a bound that excludes positions: the
 * strongest numbers of the pixels, projected on the few orthonormal directions that hold most
 * of what such cells differ by (principal axes of sampled cells). The squared distance of
 * projections never exceeds that of the pixels.
 */
#ifndef TTF_SYNTH_SEARCH_CELLS_H
#define TTF_SYNTH_SEARCH_CELLS_H

#include <stddef.h>
#include <stdint.h>

#include "search/matching.h"
#include "search/rank_kernels.h"
#include "ttf/base/attr.h"

#define TTF_CELL_SIDE_MAX 6

#define TTF_CELL_SIDE_FINE 2

/*
 * Of each pixel so many numbers, the strongest; of a small cell more. In a coarse cell's axes the weaker numbers have next to no part; in a
 * fine one's they have (simulated grass: 0.83 of E instead of 0.82, and a seventh fewer positions that pass), and it has few pixels.
 */
#define TTF_CELL_NUMBERS      8u
#define TTF_CELL_NUMBERS_FINE 16u

struct ttf_cells {
    uint32_t side;    /* pixels; the one that leaves least of the overlap over */
    uint32_t numbers; /* of each pixel */
    size_t dims;      /* side x side x numbers */
    float *basis;     /* dims x TTF_CELL_DIMS */
    double scale;     /* stored over projected */
};

/* Coarse cells are few and exclude what is far off; fine ones bound tightly. */
#define TTF_CELL_LEVELS 2

/* The side of a level's cells for an overlap of so many pixels. */
uint32_t ttf_cells_side(unsigned level, uint32_t overlap);

/* From the pixels of one input (width x height at `coefs`, stride numbers each). -ENOMEM. */
TTF_MUST_USE int ttf_cells_find(const int16_t *coefs, uint32_t width, uint32_t height,
                                size_t stride, uint32_t side, struct ttf_cells *ret);
void ttf_cells_free(struct ttf_cells *cells); /* zeroed ones are fine */

/*
 * Four cells at once: pixel(ctx, which, i) gives the numbers of pixel i (row by row) of cell `which`.
 * ret: 4 x TTF_CELL_DIMS, within TTF_CELL_MAX.
 */
void ttf_cells_project(const struct ttf_cells *cells,
                       const int16_t *(*pixel)(const void *ctx, unsigned which, uint32_t i),
                       const void *ctx, int16_t *ret);

#endif
