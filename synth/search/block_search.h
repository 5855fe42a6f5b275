/* SPDX-License-Identifier: Apache-2.0 */
/*
 * block_search.h: all source positions whose overlap agrees with what is already
 * there: eq. 3 over all frames, exactly, for every position.
 *
 * Two rounds of lower bounds (features.h) exclude most positions; what is left
 * is compared in full, in integers, and only that decides. So the result is that
 * of a plain search over everything, on any machine and with any number of threads.
 */
#ifndef TTF_SYNTH_SEARCH_BLOCK_SEARCH_H
#define TTF_SYNTH_SEARCH_BLOCK_SEARCH_H

#include <stdint.h>

#include "search/kernels.h"
#include "search/trajectories.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/pool.h"

/* Pixels known already, of a block about to be placed: an L, or one of its arms. */
struct ttf_overlap {
    uint32_t width, height; /* of the block */
    uint32_t left;          /* known columns at the left, 0 .. width */
    uint32_t top;           /* known rows at the top, 0 .. height */
    const uint32_t *known;  /* source pixel of the block's (x, y): known[y * stride + x] */
    size_t stride;
};

struct ttf_candidates {
    uint32_t n;                /* within tolerance, at least 1 */
    const uint32_t *positions; /* ascending: y * columns + x of the block's corner in the source */
    const uint64_t *errors;    /* of each, eq. 3 */
    uint32_t columns;          /* positions in a row: source width - block width + 1 */
    uint64_t best;             /* the smallest error of all positions */
};

struct ttf_search_counts {
    uint64_t positions, survived_cells, survived_rank, exact;
};

struct ttf_search;

/*
 * trajectories must outlive it. min_overlap: the narrowest arm there will be,
 * pixels. noise: variance of one sample. kernels: NULL for the fastest. -ENOMEM.
 */
TTF_MUST_USE int ttf_search_create(const struct ttf_trajectories *trajectories,
                                   uint32_t min_overlap, double tolerance, double noise,
                                   const struct ttf_kernels *kernels, struct ttf_pool *pool,
                                   struct ttf_search **ret);
void ttf_search_destroy(struct ttf_search *search); /* NULL allowed */

/*
 * All positions with E <= (1 + tolerance) max(E_min, floor). left and top not
 * both 0. What *ret points at is valid until the next call. -ENOMEM.
 */
TTF_MUST_USE int ttf_search_run(struct ttf_search *search, const struct ttf_overlap *overlap,
                                struct ttf_candidates *ret);

/* Totals since creation. */
void ttf_search_counts(const struct ttf_search *search, struct ttf_search_counts *ret);

/* The rule itself: the largest error that is within tolerance, for so many overlap pixels. */
double ttf_search_limit(double tolerance, double noise, uint64_t overlap_pixels, uint32_t frames,
                        uint64_t best);

/* The overlap's pixels. */
static inline uint64_t ttf_overlap_pixels(const struct ttf_overlap *o)
{
    return (uint64_t)o->width * o->top + (uint64_t)o->left * (o->height - o->top);
}

#endif
