/* SPDX-License-Identifier: Apache-2.0 */
/* template.h: an overlap's known pixels, gathered so that the search's inner loops run over whole rows. */
#ifndef TTF_SYNTH_SEARCH_TEMPLATE_H
#define TTF_SYNTH_SEARCH_TEMPLATE_H

#include "search/block_search.h"
#include "search/features.h"

struct ttf_template_run {
    uint32_t dx, dy; /* in the block */
    size_t length;   /* pixels, one row */
    size_t first;    /* of the gathered pixels */
};

struct ttf_template_cell {
    uint32_t dx, dy;
    float target[TTF_CELL_PLANES];
};

/* Zero-initialise; grows as needed. */
struct ttf_template {
    size_t n_pixels, n_runs, n_cells, longest_run;
    struct ttf_template_run *runs;
    struct ttf_template_cell *cells;
    /* the trajectory that most pixels have: how many, where one is, and the runs of all others */
    size_t n_ground, ground, n_others;
    struct ttf_template_run *others;
    uint8_t *codes; /* n_pixels x dims */
    float *coefs;   /* n_pixels x TTF_PIXEL_COEFS, or NULL */
    size_t room_pixels, room_runs, room_cells;
};

/* -ENOMEM. */
TTF_MUST_USE int ttf_template_gather(struct ttf_template *template,
                                     const struct ttf_trajectories *trajectories,
                                     const struct ttf_features *features,
                                     const struct ttf_overlap *overlap);
void ttf_template_free(struct ttf_template *template);

#endif
