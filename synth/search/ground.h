/* SPDX-License-Identifier: Apache-2.0 */
/*
 * ground.h: an input with a plain ground (an object on white) has countless exact
 * matches, all to be compared in full. Where most of an overlap is of one and the
 * same trajectory g, sums of |p - g|^2 over rectangles answer for those pixels at
 * once, exactly, and only the others are compared one by one.
 */
#ifndef TTF_SYNTH_SEARCH_GROUND_H
#define TTF_SYNTH_SEARCH_GROUND_H

#include <stdint.h>

#include "search/kernels.h"
#include "search/trajectories.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/pool.h"

/* Zero-initialise. */
struct ttf_ground {
    uint8_t *code;  /* g: one trajectory; NULL: none yet */
    uint64_t *sums; /* (height + 1) x (width + 1): of |p - g|^2 above and left of a corner */
    size_t stride;
};

/* Sums for this g; nothing to do if it is the last one's. -ENOMEM. */
TTF_MUST_USE int ttf_ground_prepare(struct ttf_ground *ground,
                                    const struct ttf_trajectories *trajectories,
                                    const uint8_t *code, const struct ttf_kernels *kernels,
                                    struct ttf_pool *pool);
void ttf_ground_free(struct ttf_ground *ground);

/* Sum over the rectangle of width x height pixels at (x, y). */
static inline uint64_t ttf_ground_sum(const struct ttf_ground *ground, size_t x, size_t y,
                                      size_t width, size_t height)
{
    const uint64_t *top = ground->sums + y * ground->stride + x;
    const uint64_t *bottom = top + height * ground->stride;

    return bottom[width] - bottom[0] - (top[width] - top[0]);
}

#endif
