/* SPDX-License-Identifier: Apache-2.0 */
/*
 * agreement.h: does matching in k-space choose as matching over all frames would? The position that
 * k-space takes for the best is the one of the candidates within tolerance that is likely to be
 * (rank_search.h: what rank k misses of two pixels adds up).
 */
#ifndef TTF_SYNTH_AGREEMENT_H
#define TTF_SYNTH_AGREEMENT_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pool.h"
#include "ttf/synth/quilt.h"

struct ttf_agreement {
    unsigned queries;
    double best; /* share of queries whose best position is the full-time search's */
    double
        extra_cost; /* mean of E_full(chosen) / E_full(best) - 1, over queries with E_full(best) > 0 */
    double jaccard; /* mean overlap of the two sets within tolerance */
    /* of those queries whose best position does not just go on where a neighbour was taken from */
    unsigned jumps;
    double jump_best, jump_extra_cost;
};

/*
<<<<<<< HEAD
 * Of queries that a map's blocks really were: the overlap as it lay there when the block was placed.
 * `most` of them by hash (0: all). Loads all frames of the one input (3 n bytes
 * per pixel). -EINVAL of maps of several inputs, turned blocks or a tileable output;
 * -ENOMEM; the sequence's.
=======
 * The map's first `most` queries in a hashed order (0: all). Loads all frames of the one input (3 n bytes
 * per pixel). -EINVAL of maps of several inputs, turned blocks or a tileable output, of an
 * input of another size, or without a rank to judge; -ENOMEM; the sequence's.
>>>>>>> qtest
 */
TTF_MUST_USE int ttf_quilt_agreement(const struct ttf_quilt_config *config,
                                     struct ttf_sequence *input, const struct ttf_quilt_map *map,
                                     unsigned most, struct ttf_pool *pool,
                                     struct ttf_agreement *ret, struct ttf_err *err);

/*
 * The same, of queries that no search has made alike: the left and upper neighbour are of hashed places of the
 * input. Harder: there is hardly a position that fits.
 */
TTF_MUST_USE int ttf_quilt_agreement_anywhere(const struct ttf_quilt_config *config,
                                              struct ttf_sequence *input,
                                              const struct ttf_quilt_map *map, unsigned most,
                                              struct ttf_pool *pool, struct ttf_agreement *ret,
                                              struct ttf_err *err);

#endif
