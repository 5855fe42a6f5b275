/* SPDX-License-Identifier: Apache-2.0 */
/* rank_template.h: a query's known pixels, gathered so that inner loops run over whole rows. */
#ifndef TTF_SYNTH_SEARCH_RANK_TEMPLATE_H
#define TTF_SYNTH_SEARCH_RANK_TEMPLATE_H

#include "search/rank_search.h"

struct ttf_rank_run {
    uint32_t dx, dy; /* in the block */
    size_t length;   /* pixels, one row */
    size_t first;    /* of the gathered pixels */
};

struct ttf_rank_cell {
    uint32_t dx, dy;
    struct ttf_cell_target target; /* offset: to be set for each view */
};

/* Zero-initialise; grows as needed. */
struct ttf_rank_template {
    size_t n_pixels, n_runs, n_cells[TTF_CELL_LEVELS];
    struct ttf_rank_run *runs;
    size_t n_rest; /* pixels, the first, that no fine cell holds; 0 before refining */
    struct ttf_rank_cell *cells[TTF_CELL_LEVELS];
    int16_t *fine;      /* n_cells[1] x TTF_CELL_DIMS */
    int16_t *coefs;     /* n_pixels x stride */
    uint8_t *taken;     /* of the block's pixels: in a cell already */
    size_t room_pixels; /* of blocks */
};

/* Pixels and coarse cells. -ENOMEM. */
TTF_MUST_USE int ttf_rank_template_gather(struct ttf_rank_template *template,
                                          const struct ttf_rank_search *search,
                                          const struct ttf_rank_query *query);

/* The fine cells, for a query that needs them; and the runs anew, those first that no fine cell holds. */
void ttf_rank_template_refine(struct ttf_rank_template *template,
                              const struct ttf_rank_search *search,
                              const struct ttf_rank_query *query);
void ttf_rank_template_free(struct ttf_rank_template *template);

#endif
