/* SPDX-License-Identifier: Apache-2.0 */
/*
 * matching.h: what blocks are compared by: of each source pixel the k numbers of its row of
 * U_k S_k (section 5.2), shifted to a mean of 0 and quantised to integers, so that sums of
 * squared differences are exact and no choice depends on rounding.
 */
#ifndef TTF_SYNTH_SEARCH_MATCHING_H
#define TTF_SYNTH_SEARCH_MATCHING_H

#include <stddef.h>
#include <stdint.h>

#include "search/factors.h"
#include "search/learner.h"
#include "search/sources.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pool.h"
#include "ttf/synth/quilt.h"

struct ttf_matching {
    size_t pixels;
    unsigned k;      /* numbers of a pixel */
    unsigned stride; /* k, padded with zeros to a multiple of TTF_COEF_LANES */
    int16_t *coefs;  /* pixels x stride, strongest first, within TTF_COEF_MAX */
    float *missed;   /* of each pixel: squared length of what rank k misses, codes^2 */
    double scale;    /* quantised over codes: an error in codes^2 is the integers' over scale^2 */
    double noise;    /* variance of one sample, codes^2 */
    struct ttf_quilt_rank_figures figures;
};

/* Frames first .. first+frames-1 of the sources. aside: as the learner has it, NULL for nothing. -ENOMEM, -ECANCELED, the sequences' and its errors. */
TTF_MUST_USE int ttf_matching_build(const struct ttf_quilt_config *config,
                                    const struct ttf_sources *sources, uint32_t first,
                                    uint32_t frames, const struct ttf_aside *aside,
                                    struct ttf_pool *pool, struct ttf_matching *ret,
                                    struct ttf_err *err);

/*
 * From factors at hand (1, or 3 of a channel each; finished): k of each. noise as above.
 * What incremental work calls.
 */
TTF_MUST_USE int ttf_matching_of_factors(const struct ttf_factors *factors, unsigned n, unsigned k,
                                         double noise, struct ttf_pool *pool,
                                         struct ttf_matching *ret, struct ttf_err *err);
void ttf_matching_free(struct ttf_matching *matching); /* a zeroed one is fine */

/* Memory while it is built: about this many bytes. */
size_t ttf_matching_bytes(size_t pixels, unsigned rank, bool per_channel);

#endif
