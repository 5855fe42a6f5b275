/* SPDX-License-Identifier: Apache-2.0 */
/*
 * patches.h: pictures as all their patches of TTF_PATCH_SIDE squared pixels, for
 * figures that compare patches. Numbers of one row of a patch lie side by side.
 */
#ifndef TTF_SYNTH_METRICS_PATCHES_H
#define TTF_SYNTH_METRICS_PATCHES_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/pool.h"

#define TTF_PATCH_SIDE    7u
#define TTF_PATCH_NUMBERS (3u * TTF_PATCH_SIDE * TTF_PATCH_SIDE)
/* A patch's row as loops see it, three whole vectors: its 21 numbers, and 3 that do not count. */
#define TTF_PATCH_ROW     24u

/* Samples are 16 bits wide so that differences and products need no widening. */
struct ttf_patches {
    uint32_t width, height; /* of the picture */
    uint32_t patches_x, patches_y;
    size_t stride;  /* numbers between rows of the picture */
    int16_t *codes; /* RGB codes; what is read behind the last patch's row is there */
};

/* width and height >= TTF_PATCH_SIDE. -ENOMEM. To free: ttf_patches_free. */
TTF_MUST_USE int ttf_patches_of_picture(const uint8_t *rgb, uint32_t width, uint32_t height,
                                        struct ttf_patches *ret);

/* Of half the size: means of 2 x 2 codes, rounded; an odd last row or column is left out. -ENOMEM. */
TTF_MUST_USE int ttf_patches_halve(const struct ttf_patches *from, struct ttf_patches *ret);

/* All zero allowed. */
void ttf_patches_free(struct ttf_patches *patches);

static inline const int16_t *ttf_patch_at(const struct ttf_patches *patches, uint32_t x, uint32_t y)
{
    return patches->codes + (size_t)y * patches->stride + (size_t)x * 3;
}

static inline uint64_t ttf_patches_count(const struct ttf_patches *patches)
{
    return (uint64_t)patches->patches_x * patches->patches_y;
}

/* Sliced Wasserstein-1 distance of two pictures' patches. -ENOMEM. */
TTF_MUST_USE int ttf_patches_sliced(const struct ttf_patches *a, const struct ttf_patches *b,
                                    struct ttf_pool *pool, double *ret);

/*
 * Of up to `samples` patches of `of` the distance to the nearest patch of `in`: the
 * mean of the root mean square difference per number. -ENOMEM.
 */
TTF_MUST_USE int ttf_patches_nearest(const struct ttf_patches *of, const struct ttf_patches *in,
                                     unsigned samples, struct ttf_pool *pool, double *ret);

#endif
