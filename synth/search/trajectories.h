/* SPDX-License-Identifier: Apache-2.0 */
/*
 * trajectories.h: what the search over all frames compares: the input as one row of 3 n 8-bit codes
 * per pixel (channel fastest, then time), so that a pixel's whole history lies
 * together and sums of squared differences are exact integers.
 *
 * T of eq. 4 whole (one row of 3 n values per pixel); the search in k-space never holds
 * it (factors.h).
 */
#ifndef TTF_SYNTH_SEARCH_TRAJECTORIES_H
#define TTF_SYNTH_SEARCH_TRAJECTORIES_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pool.h"
#include "ttf/dataset/sequence.h"
#include "ttf/synth/quilt.h"

struct ttf_trajectories {
    uint32_t width, height, frames;
    size_t dims;    /* 3 x frames: bytes per pixel */
    uint8_t *codes; /* height x width x dims */
};

static inline const uint8_t *ttf_trajectory(const struct ttf_trajectories *t, size_t pixel)
{
    return t->codes + pixel * t->dims;
}

/* 16-bit codes to the 8-bit ones that the metric compares. */
void ttf_metric_table(enum ttf_metric metric, const struct ttf_encoding *encoding,
                      uint8_t table[65536]);

/*
 * Reads frames first .. first+frames-1. cancel: may be NULL. Free with
 * ttf_trajectories_free. -ENOMEM, -ECANCELED, the sequence's errors.
 */
TTF_MUST_USE int ttf_trajectories_load(struct ttf_sequence *input, uint32_t first, uint32_t frames,
                                       enum ttf_metric metric, struct ttf_pool *pool,
                                       const volatile int *cancel, struct ttf_trajectories *ret,
                                       struct ttf_err *err);
void ttf_trajectories_free(struct ttf_trajectories *trajectories);

/*
 * Variance of the noise of one sample, codes squared, at least 1/12 (rounding to
 * 8 bits): from second differences in time, whose variance is six times the
 * noise's where the texture itself changes slowly; differences beyond five
 * times their median are taken for real events and left out. Fewer than three
 * frames tell nothing: 1/12. A ratio of integers: the same on every machine.
 */
double ttf_trajectories_noise(const struct ttf_trajectories *trajectories);

#endif
