/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rank_private.h: one query in work, shared by rank_search.c (the steps), rank_bounds.c (what cells exclude) and rank_compare.c (errors in full).
 */
#ifndef TTF_SYNTH_SEARCH_RANK_PRIVATE_H
#define TTF_SYNTH_SEARCH_RANK_PRIVATE_H

#include "search/rank_ground.h"
#include "search/rank_search.h"
#include "search/rank_template.h"

/* A bound that no limit lets pass. */
#define TTF_RANK_EXCLUDED UINT32_MAX

/* Positions that are compared side by side. */
#define TTF_RANK_ABREAST 4u

struct ttf_rank_workspace {
    struct ttf_rank_template template;
    struct ttf_rank_ground ground;
    bool on_ground; /* `ground` is of this query, and worth using */
    struct ttf_cell_target targets[TTF_CELLS_MAX];
    size_t room_positions, room_found, room_at;
    uint32_t *
        at; /* of each view, one after another: where vectors of known pixels lie, from a position's corner on */
    uint32_t
        fine_at[TTF_CELLS_MAX]; /* where the fine cells of one view lie, from a position's own on */
    uint32_t *bounds;           /* of all views' positions */
    struct ttf_rank_candidate *found;
    uint32_t n_found;
    struct ttf_rank_counts counts;
    /* of the running query */
    const struct ttf_rank_search *search;
    const struct ttf_rank_query *query;
    uint64_t best;
    double limit;
};

/* Positions in a row and column of a view; 0 x 0 where the block does not fit. */
void ttf_rank_grid(const struct ttf_view *view, const struct ttf_rank_query *query,
                   uint32_t *ret_columns, uint32_t *ret_rows);

/* ---- rank_bounds.c ---- */

/*
 * What the cells' sum may at most be where E is within the limit: each stored number is rounded by
 * at most a half, so that a difference may be off by one (and a little for what floats lose).
 * Beyond what sums are clipped to, nothing is excluded.
 */
uint32_t ttf_rank_cell_limit(const struct ttf_rank_workspace *w, unsigned level);

/* What the cells that a bound is of have of E at least. */
double ttf_rank_least_of_cells(const struct ttf_rank_workspace *w, unsigned level, uint32_t bound);

/* Of each view every so manyth row is sampled. */
#define TTF_RANK_SAMPLE 8u

/* Bounds of all views by coarse cells: of the sampled rows, or of the others. */
void ttf_rank_bound_coarse(struct ttf_rank_workspace *w, bool sampled);

/* Do the coarse cells let nearly all of the sampled rows' positions pass? */
bool ttf_rank_most_of_sample_pass(const struct ttf_rank_workspace *w);

/* The rows that are not sampled are let pass as they are, or left out. */
void ttf_rank_set_unsampled(struct ttf_rank_workspace *w, bool pass);

/* By fine cells, of the positions that the coarse ones let pass; the others are excluded. */
void ttf_rank_bound_fine(struct ttf_rank_workspace *w);

/* ---- rank_compare.c ---- */

/* Where the template's pixels lie in each view: before anything is compared, and anew after refining. -ENOMEM. */
TTF_MUST_USE int ttf_rank_place_vectors(struct ttf_rank_workspace *w);

/* Compares n positions, of any views, in full: they bring the limit down. */
void ttf_rank_look_at(struct ttf_rank_workspace *w, const struct ttf_rank_position *list,
                      unsigned n);

/* All positions that the bounds of `level` let pass, compared in full. The limit only tightens on the way. -ENOMEM. */
TTF_MUST_USE int ttf_rank_compare_survivors(struct ttf_rank_workspace *w, unsigned level);

#endif
