/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rank_search.h: all positions whose overlap agrees with what is already there, in k-space
 * (section 5.2): sums of squared differences of quantised coefficients, exactly, over all
 * positions of all views.
 *
 * Lower bounds from coarse cells, then from fine ones (cells.h), exclude most positions; what is left
 * is compared in full, in integers, and given up as soon as it passes the limit. So the result
 * is that of a plain search.
 *
 * Threads: one search serves several queries at once, each with a workspace of its own.
 */
#ifndef TTF_SYNTH_SEARCH_RANK_SEARCH_H
#define TTF_SYNTH_SEARCH_RANK_SEARCH_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "search/matching.h"
#include "search/rank_kernels.h"
#include "search/views.h"
#include "ttf/base/attr.h"

/* Positions (corners of blocks) of one view: x0 <= x < x1, y0 <= y < y1. */
struct ttf_position_rect {
    unsigned view;
    uint32_t x0, y0, x1, y1;
};

struct ttf_rank_query {
    uint32_t width, height; /* of the block */
    const uint32_t *known;  /* height x width ids, TTF_UNKNOWN_ID where nothing lies yet */
    const struct ttf_position_rect *excluded;
    unsigned n_excluded;
    /* Positions worth a look first (they cost little and may save much). */
    const struct ttf_rank_position *hints;
    unsigned n_hints;
    bool rerank; /* find the likeliest */
};

struct ttf_rank_position {
    unsigned view;
    uint32_t x, y;
};

struct ttf_rank_candidate {
    struct ttf_rank_position position;
    uint64_t error; /* in quantised units */
};

struct ttf_rank_result {
    uint32_t n; /* within tolerance, at least 1; by view, row, column */
    const struct ttf_rank_candidate *list;
    uint64_t best;      /* the smallest error */
    uint32_t likeliest; /* which is likely to be the best over all frames too (with rerank) */
    uint64_t overlap_pixels;
};

struct ttf_rank_counts {
    uint64_t positions, survived_cells, exact;
};

struct ttf_rank_search {
    const struct ttf_matching *matching;
    const struct ttf_views *views;
    const struct ttf_rank_kernels *kernels;
    double tolerance;
};

struct ttf_rank_workspace; /* of one query at a time */
TTF_MUST_USE int ttf_rank_workspace_create(struct ttf_rank_workspace **ret); /* -ENOMEM */
void ttf_rank_workspace_destroy(struct ttf_rank_workspace *workspace);       /* NULL allowed */
struct ttf_rank_counts ttf_rank_workspace_counts(const struct ttf_rank_workspace *workspace);

/*
 * All positions with E <= (1 + tolerance) max(E_min, floor), over those not excluded. If all are
 * excluded, the exclusions are not heeded. What *ret points at is valid until the workspace's next
 * query. -ENOMEM; -EINVAL if nothing is known or the block fits no view.
 */
TTF_MUST_USE int ttf_rank_search_run(const struct ttf_rank_search *search,
                                     struct ttf_rank_workspace *workspace,
                                     const struct ttf_rank_query *query,
                                     struct ttf_rank_result *ret);

/* The rule: the largest error within tolerance, quantised units. Noise leaves 2 v in each number of each pixel. */
double ttf_rank_limit(const struct ttf_rank_search *search, uint64_t overlap_pixels, uint64_t best);

#endif
