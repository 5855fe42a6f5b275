/* SPDX-License-Identifier: Apache-2.0 */
/*
 * learner.h: frames read and factored, batch by batch: while one thread learns the directions of
 * a batch, the others read the next one. Its state can be kept and gone on with.
 */
#ifndef TTF_SYNTH_SEARCH_LEARNER_H
#define TTF_SYNTH_SEARCH_LEARNER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "search/factors.h"
#include "search/kept.h"
#include "search/second_differences.h"
#include "search/sources.h"
#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pool.h"
#include "ttf/synth/quilt.h"

struct ttf_learner {
    unsigned n_factors; /* 1, or 3 */
    struct ttf_factors factors[3];
    struct ttf_second_differences noise;
    uint32_t known; /* frames taken over */
};

/* What goes on besides, while frames are read. */
struct ttf_aside {
    struct ttf_kept *
        kept; /* gets the codes of its frames, where the first of all is read; NULL: none are kept */
    /*
     * The next small piece of it: called from any thread of the pool, one at a time, while the others are busy with frames, as often as there is
     * time for. 1: there is more; 0: that was all; errors end the learning. NULL: nothing.
     */
    int (*next)(void *ctx, struct ttf_err *err);
    void *ctx;
    int64_t (*now_ns)(void *ctx); /* that kept's memory is taken by (ttf_kept_touch); NULL: none */
    void *now_ctx;
};

/* Zeroed factors for so many pixels. -ENOMEM. */
TTF_MUST_USE int ttf_learner_create(size_t pixels, unsigned room, bool per_channel,
                                    struct ttf_learner *ret);
void ttf_learner_free(struct ttf_learner *learner); /* a zeroed one is fine */

/* Adds frames from..to-1 and finishes. table: 16-bit codes to what is compared. aside: NULL for nothing. */
TTF_MUST_USE int ttf_learner_add(struct ttf_learner *learner, const struct ttf_sources *sources,
                                 uint32_t from, uint32_t to, const uint8_t *table,
                                 const struct ttf_aside *aside, const volatile int *cancel,
                                 struct ttf_pool *pool, struct ttf_err *err);

/* All of it as bytes, to be freed. -ENOMEM. */
TTF_MUST_USE int ttf_learner_pack(const struct ttf_learner *learner, enum ttf_metric metric,
                                  struct ttf_quilt_factors *ret);

/*
 * Back again. -EINVAL with words if the bytes are none of ours, are of another size, metric or kind,
 * of more frames than the sources have, or if the last frame they know is not the sources'.
 */
TTF_MUST_USE int ttf_learner_unpack(const struct ttf_quilt_factors *bytes,
                                    const struct ttf_sources *sources, unsigned room,
                                    bool per_channel, enum ttf_metric metric, const uint8_t *table,
                                    struct ttf_learner *ret, struct ttf_err *err);

/* Of bytes that were refused: are they sound, of this kind and of no more frames, so that the input is another? */
bool ttf_learner_is_of_other(const struct ttf_quilt_factors *bytes,
                             const struct ttf_sources *sources, unsigned room, bool per_channel,
                             enum ttf_metric metric);

#endif
