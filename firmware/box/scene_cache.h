/* SPDX-License-Identifier: Apache-2.0 */
/* scene_cache.h: the last frames that a scene made of pictures was asked for, as floats. */
#ifndef FIRMWARE_SCENE_CACHE_H
#define FIRMWARE_SCENE_CACHE_H

#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/pixbuf.h"

#define SCENE_CACHE_FRAMES 2 /* the camera's size and that of whoever asks for the truth */

struct scene_cache {
    struct {
        int64_t frame; /* -1: nothing */
        uint64_t used;
        struct ttf_pixbuf rgb; /* f32, 3 samples */
    } kept[SCENE_CACHE_FRAMES];
    uint64_t uses;
};

/* Gives frame `frame` as a fresh f32 pixbuf of its own size, linear 0..1, 3 samples. */
typedef int scene_load_fn(void *ctx, int64_t frame, struct ttf_pixbuf *ret, struct ttf_err *err);

void scene_cache_init(struct scene_cache *cache);
void scene_cache_finish(struct scene_cache *cache);

/* Frame `frame` at w x h into rgb, loaded and resampled (in linear light) if it is not kept. */
int scene_cache_render(struct scene_cache *cache, int64_t frame, uint32_t w, uint32_t h,
                       scene_load_fn *load, void *ctx, float *rgb, struct ttf_err *err);

#endif
