/* SPDX-License-Identifier: Apache-2.0 */
/*
 * reference.h: the same decisions made the plainest way, one difference at a
 * time, sharing no code with the search, the cut or the map it checks.
 */
#ifndef TTF_TESTS_SYNTH_REFERENCE_H
#define TTF_TESTS_SYNTH_REFERENCE_H

#include <stdint.h>

#include "search/block_search.h"
#include "search/matching.h"
#include "search/trajectories.h"

/* What pixels are compared by: over all frames, or in k-space. */
struct reference {
    uint32_t width, height; /* of the source */
    uint64_t (*error)(const void *ctx, size_t p, size_t q);
    const void *ctx;
    double floor; /* of the tolerance rule, per overlap pixel */
};

/* What they are made of must outlive them. */
struct reference reference_of_trajectories(const struct ttf_trajectories *trajectories,
                                           double noise);
struct reference reference_of_matching(const struct ttf_matching *matching, uint32_t width);

/* Eq. 3 of one position. */
uint64_t reference_error(const struct reference *reference, const struct ttf_overlap *overlap,
                         uint32_t x, uint32_t y);

/*
 * All candidates in raster order into positions and errors (room for all); returns
 * how many. The rule: E <= (1 + tolerance) max(E_min, floor).
 */
uint32_t reference_candidates(const struct reference *reference, const struct ttf_overlap *overlap,
                              double tolerance, uint32_t *positions, uint64_t *errors,
                              uint64_t *ret_best);

/* The map of a whole plan, to be freed. seed as in the configuration. */
uint32_t *reference_plan(const struct reference *reference, const struct ttf_quilt_config *config);

#endif
