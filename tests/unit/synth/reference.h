/* SPDX-License-Identifier: Apache-2.0 */
/*
 * reference.h: the same decisions made the plainest way, one difference at a
 * time, sharing no code with the search, the cut or the map it checks.
 */
#ifndef TTF_TESTS_SYNTH_REFERENCE_H
#define TTF_TESTS_SYNTH_REFERENCE_H

#include <stdint.h>

#include "search/block_search.h"
#include "search/trajectories.h"

/* Eq. 3 of one position. */
uint64_t reference_error(const struct ttf_trajectories *trajectories,
                         const struct ttf_overlap *overlap, uint32_t x, uint32_t y);

/*
 * All candidates in raster order into positions and errors (room for all); returns
 * how many. The rule: E <= (1 + tolerance) max(E_min, 2 noise samples).
 */
uint32_t reference_candidates(const struct ttf_trajectories *trajectories,
                              const struct ttf_overlap *overlap, double tolerance, double noise,
                              uint32_t *positions, uint64_t *errors, uint64_t *ret_best);

/* The map of a whole plan, to be freed. seed as in the configuration. */
uint32_t *reference_plan(const struct ttf_trajectories *trajectories,
                         const struct ttf_quilt_config *config, double noise);

#endif
