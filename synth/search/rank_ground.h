/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rank_ground.h: an input with a plain ground (an object on white) has countless exact matches, all to
 * be compared in full. Where most of an overlap is of one and the same numbers g, sums of |p - g|^2
 * along rows answer for those pixels at once, exactly, and only the others are compared one by one.
 */
#ifndef TTF_SYNTH_SEARCH_RANK_GROUND_H
#define TTF_SYNTH_SEARCH_RANK_GROUND_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "search/rank_template.h"
#include "ttf/base/attr.h"

/* Zero-initialise; of one workspace. */
struct ttf_rank_ground {
    int16_t *g;      /* stride numbers; NULL: none yet */
    uint64_t **sums; /* of each view: height x (width + 1), of |p - g|^2 left of a pixel */
    unsigned n_views;
    /* the template's pixels again: runs of the ground, and of all others */
    size_t n_runs, n_others, room;
    struct ttf_rank_run *runs, *others;
    int16_t *coefs; /* of the others */
};

/*
 * Is most of the template of one g? Then makes the sums for it ready (nothing to do if it is the
 * last query's) and returns 1; else 0. -ENOMEM.
 */
TTF_MUST_USE int ttf_rank_ground_prepare(struct ttf_rank_ground *ground,
                                         const struct ttf_rank_search *search,
                                         const struct ttf_rank_template *template);
void ttf_rank_ground_free(struct ttf_rank_ground *ground);

/* E of a position, as the template's runs would give it; beyond the limit, any number beyond it. */
uint64_t ttf_rank_ground_error(const struct ttf_rank_ground *ground,
                               const struct ttf_rank_search *search,
                               const struct ttf_rank_position *at, uint64_t limit);

#endif
