/* SPDX-License-Identifier: Apache-2.0 */
/* scene_cache.c: see scene_cache.h. */
#include "scene_cache.h"

#include <errno.h>
#include <string.h>

void scene_cache_init(struct scene_cache *cache)
{
    memset(cache, 0, sizeof *cache);
    for (unsigned i = 0; i < SCENE_CACHE_FRAMES; i++)
        cache->kept[i].frame = -1;
}

void scene_cache_finish(struct scene_cache *cache)
{
    for (unsigned i = 0; i < SCENE_CACHE_FRAMES; i++)
        ttf_pixbuf_free(&cache->kept[i].rgb);
    scene_cache_init(cache);
}

/* Loads and brings to size into *ret, which is then owned by the caller. */
static int load_sized(int64_t frame, uint32_t w, uint32_t h, scene_load_fn *load, void *ctx,
                      struct ttf_pixbuf *ret, struct ttf_err *err)
{
    struct ttf_pixbuf own = {0}, sized = {0};
    int r = load(ctx, frame, &own, err);

    if (r < 0)
        return r;
    if (own.width == w && own.height == h) {
        *ret = own;
        return 0;
    }
    r = ttf_pixbuf_alloc(&sized, w, h, 3, TTF_SAMPLE_F32);
    if (r == 0)
        r = ttf_pixbuf_resample(&own, &sized);
    ttf_pixbuf_free(&own);
    if (r < 0) {
        ttf_pixbuf_free(&sized);
        return ttf_err_set(err, r, NULL, "a scene's frame cannot be brought to %u x %u", w, h);
    }
    *ret = sized;
    return 0;
}

int scene_cache_render(struct scene_cache *cache, int64_t frame, uint32_t w, uint32_t h,
                       scene_load_fn *load, void *ctx, float *rgb, struct ttf_err *err)
{
    unsigned at = SCENE_CACHE_FRAMES, oldest = 0;

    for (unsigned i = 0; i < SCENE_CACHE_FRAMES; i++) {
        if (cache->kept[i].frame == frame && cache->kept[i].rgb.width == w &&
            cache->kept[i].rgb.height == h)
            at = i;
        if (cache->kept[i].used < cache->kept[oldest].used)
            oldest = i;
    }
    if (at == SCENE_CACHE_FRAMES) {
        struct ttf_pixbuf loaded = {0};
        int r = load_sized(frame, w, h, load, ctx, &loaded, err);

        if (r < 0)
            return r;
        at = oldest;
        ttf_pixbuf_free(&cache->kept[at].rgb);
        cache->kept[at].rgb = loaded;
        cache->kept[at].frame = frame;
    }
    cache->kept[at].used = ++cache->uses;
    for (uint32_t y = 0; y < h; y++)
        memcpy(rgb + (size_t)y * w * 3, ttf_pixbuf_row(&cache->kept[at].rgb, y),
               (size_t)w * 3 * sizeof(float));
    return 0;
}
