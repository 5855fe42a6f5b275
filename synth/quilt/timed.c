/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/timed.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/compose.h"
#include "quilt/time_jitter.h"

#define TILE_PIXELS 16384u
#define NOTHING     UINT32_MAX

struct ttf_timed {
    const struct ttf_quilt_config *config;
    const struct ttf_quilt_map *map;
    const struct ttf_sources *sources;
    unsigned capacity; /* source frames held, >= 3 */
    uint16_t *frames;
    uint32_t *held;   /* which frame lies in each place; NOTHING */
    uint32_t *blocks; /* of this output frame: the time of each block, where only they have one */
    uint32_t *times;  /* of this output frame: of each pixel, then of each layer */
    uint16_t *layers; /* of this output frame: each layer's colour */
    /* of the running pass: source frames first .. first + capacity - 2, and one more for interpolation */
    uint32_t t, first;
    uint16_t *dst;
};

int ttf_timed_create(const struct ttf_quilt_config *config, const struct ttf_quilt_map *map,
                     const struct ttf_sources *sources, size_t window_bytes, struct ttf_timed **ret)
{
    size_t frame = (size_t)sources->pixels * 3 * sizeof(uint16_t), fit = window_bytes / frame;
    size_t pixels = (size_t)map->width * map->height;
    struct ttf_timed *timed = calloc(1, sizeof(*timed));

    if (!timed)
        return -ENOMEM;
    timed->config = config;
    timed->map = map;
    timed->sources = sources;
    fit = fit > sources->frames + 1 ? sources->frames + 1 : fit;
    timed->capacity = fit < 3 ? 3 : (unsigned)fit;
    timed->frames = malloc(timed->capacity * frame);
    timed->held = malloc(timed->capacity * sizeof(*timed->held));
    timed->times = malloc((pixels + map->n_layers) * sizeof(*timed->times));
    timed->blocks = malloc((map->n_blocks + 1) * sizeof(*timed->blocks));
    timed->layers = malloc((map->n_layers * 3 + 1) * sizeof(*timed->layers));
    if (!timed->frames || !timed->held || !timed->times || !timed->layers || !timed->blocks) {
        ttf_timed_destroy(timed);
        return -ENOMEM;
    }
    for (unsigned i = 0; i < timed->capacity; i++)
        timed->held[i] = NOTHING;
    *ret = timed;
    return 0;
}

void ttf_timed_destroy(struct ttf_timed *timed)
{
    if (!timed)
        return;
    free(timed->frames);
    free(timed->held);
    free(timed->times);
    free(timed->blocks);
    free(timed->layers);
    free(timed);
}

size_t ttf_timed_bytes(const struct ttf_timed *timed)
{
    size_t pixels = (size_t)timed->map->width * timed->map->height;

    return (size_t)timed->capacity * timed->sources->pixels * 3 * sizeof(uint16_t) +
           (pixels + timed->map->n_layers + timed->map->n_blocks) * sizeof(uint32_t) +
           timed->map->n_layers * 6;
}

uint32_t ttf_timed_at(const struct ttf_timed *timed, uint32_t t, size_t pixel, uint32_t block)
{
    const struct ttf_quilt_map *map = timed->map;
    const uint32_t *times = map->times ? map->times + (size_t)block * map->n_times : NULL;
    uint64_t time = (uint64_t)t * TTF_TIME_ONE;
    uint32_t at;

    if (timed->config->rate) {
        double scaled = (double)time * (double)timed->config->rate->m[pixel];

        time = scaled < 1e15 ? (uint64_t)(scaled + 0.5) : (uint64_t)1e15;
    }
    at = ttf_time_at(times, timed->sources->frames, time);
    return timed->config->jitter_round ? (at + TTF_TIME_ONE / 2) / TTF_TIME_ONE * TTF_TIME_ONE : at;
}

static void times_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct ttf_timed *timed = ctx;
    const struct ttf_quilt_map *map = timed->map;
    size_t pixels = (size_t)map->width * map->height, all = pixels + map->n_layers;
    size_t to = ((size_t)tile + 1) * TILE_PIXELS < all ? ((size_t)tile + 1) * TILE_PIXELS : all;

    (void)worker;
    for (size_t i = (size_t)tile * TILE_PIXELS; i < to; i++) {
        const struct ttf_quilt_layer *layer = i < pixels ? NULL : &map->layers[i - pixels];
        uint32_t block = layer ? layer->block : map->owner[i];

        timed->times[i] = timed->config->rate
                              ? ttf_timed_at(timed, timed->t, layer ? layer->pixel : i, block)
                              : timed->blocks[block];
    }
}

static const uint16_t *frame_in(const struct ttf_timed *timed, uint32_t s)
{
    return timed->frames + (size_t)(s % timed->capacity) * timed->sources->pixels * 3;
}

/* Codes between two frames. */
static void blend_codes(const uint16_t *from, const uint16_t *to, uint32_t part, size_t n,
                        uint16_t *ret)
{
    for (size_t i = 0; i < n; i++)
        ret[i] = ttf_blend(from[i], to[i], part);
}

/* n pixels of one time that are neighbours in the source, too, or one layer. */
static void fill(const struct ttf_timed *timed, size_t from, size_t n, uint32_t source,
                 uint16_t *out)
{
    uint32_t s = timed->times[from] / TTF_TIME_ONE, part = timed->times[from] % TTF_TIME_ONE;
    const uint16_t *codes = frame_in(timed, s) + (size_t)source * 3;

    if (part == 0)
        memcpy(out, codes, n * 3 * sizeof(*out));
    else
        blend_codes(codes, frame_in(timed, s + 1) + (size_t)source * 3, part, n * 3, out);
}

/* Has this pass the frames of a pixel's or layer's time? */
static bool is_in_pass(const struct ttf_timed *timed, size_t i)
{
    uint32_t s = timed->times[i] / TTF_TIME_ONE;

    return s >= timed->first && s < timed->first + timed->capacity - 1;
}

static void pass_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct ttf_timed *timed = ctx;
    const struct ttf_quilt_map *map = timed->map;
    size_t pixels = (size_t)map->width * map->height, all = pixels + map->n_layers;
    size_t from = (size_t)tile * TILE_PIXELS, end;
    size_t to = from + TILE_PIXELS < all ? from + TILE_PIXELS : all;

    (void)worker;
    for (size_t i = from; i < to && i < pixels; i = end) {
        for (end = i + 1; end < to && end < pixels && timed->times[end] == timed->times[i] &&
                          map->source[end] == map->source[end - 1] + 1;)
            end++;
        if (is_in_pass(timed, i))
            fill(timed, i, end - i, map->source[i], timed->dst + 3 * i);
    }
    for (size_t i = from > pixels ? from : pixels; i < to; i++) {
        if (is_in_pass(timed, i))
            fill(timed, i, 1, map->layers[i - pixels].source, timed->layers + 3 * (i - pixels));
    }
}

static int load(struct ttf_timed *timed, uint32_t s, struct ttf_err *err)
{
    unsigned place = s % timed->capacity;
    int r;

    if (timed->held[place] == s)
        return 0;
    timed->held[place] = NOTHING;
    r = ttf_sources_read(timed->sources, s,
                         timed->frames + (size_t)place * timed->sources->pixels * 3, err);
    if (r == 0)
        timed->held[place] = s;
    return r;
}

/* Source frames from the earliest to the latest time. */
static void find_range(const struct ttf_timed *timed, uint32_t *ret_first, uint32_t *ret_last)
{
    size_t all = (size_t)timed->map->width * timed->map->height + timed->map->n_layers;
    const uint32_t *times = timed->config->rate ? timed->times : timed->blocks;
    uint32_t least = UINT32_MAX, most = 0;

    all = timed->config->rate ? all : timed->map->n_blocks;
    for (size_t i = 0; i < all; i++) {
        least = times[i] < least ? times[i] : least;
        most = times[i] > most ? times[i] : most;
    }
    *ret_first = least / TTF_TIME_ONE;
    *ret_last = (most + TTF_TIME_ONE - 1) / TTF_TIME_ONE;
}

int ttf_timed_frame(struct ttf_timed *timed, uint32_t t, struct ttf_pool *pool, uint16_t *dst,
                    struct ttf_err *err)
{
    const struct ttf_quilt_map *map = timed->map;
    size_t all = (size_t)map->width * map->height + map->n_layers;
    unsigned tiles = (unsigned)((all + TILE_PIXELS - 1) / TILE_PIXELS);
    uint32_t first, last;

    timed->t = t;
    timed->dst = dst;
    for (unsigned i = 0; i < map->n_blocks && !timed->config->rate; i++)
        timed->blocks[i] = ttf_timed_at(timed, t, 0, i);
    ttf_pool_run(pool, tiles, times_tile, timed);
    find_range(timed, &first, &last);
    for (; first <= last; first += timed->capacity - 1) {
        uint32_t end = first + timed->capacity - 1 < last ? first + timed->capacity - 1 : last;

        for (uint32_t s = first; s <= end; s++) {
            int r = load(timed, s, err);

            if (r < 0)
                return r;
        }
        timed->first = first;
        ttf_pool_run(pool, tiles, pass_tile, timed);
    }
    for (size_t i = 0; i < map->n_layers; i++) {
        uint16_t *at = dst + 3 * (size_t)map->layers[i].pixel;

        for (int c = 0; c < 3; c++)
            at[c] = ttf_blend(at[c], timed->layers[3 * i + (size_t)c], map->layers[i].weight);
    }
    return 0;
}
