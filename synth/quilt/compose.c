/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/compose.h"

#include <string.h>

#define TILE_ROWS 32

struct compose {
    const struct ttf_quilt_map *map;
    const uint16_t *source;
    uint16_t *dst;
};

/* A map that was made by hand has no runs: pixel by pixel. */
static void copy_pixels(const struct ttf_quilt_map *map, const void *source, size_t code,
                        uint32_t y, void *dst)
{
    const uint32_t *row = map->source + (size_t)y * map->width;
    char *to = (char *)dst + (size_t)y * map->width * 3 * code;

    for (uint32_t x = 0; x < map->width; x++)
        memcpy(to + (size_t)x * 3 * code, (const char *)source + (size_t)row[x] * 3 * code,
               3 * code);
}

/* code: bytes of one. */
static void copy_rows(const struct ttf_quilt_map *map, const void *source, size_t code, uint32_t y0,
                      uint32_t y1, void *dst)
{
    char *to = (char *)dst + (size_t)y0 * map->width * 3 * code;

    for (uint32_t y = y0; !map->runs && y < y1; y++)
        copy_pixels(map, source, code, y, dst);
    for (uint32_t i = map->runs ? map->row_runs[y0] : 0; map->runs && i < map->row_runs[y1]; i++) {
        const struct ttf_quilt_run *run = &map->runs[i];
        size_t bytes = (size_t)run->length * 3 * code;

        memcpy(to, (const char *)source + (size_t)run->source * 3 * code, bytes);
        to += bytes;
    }
}

void ttf_compose_rows(const struct ttf_quilt_map *map, const uint16_t *source, uint32_t y0,
                      uint32_t y1, uint16_t *dst)
{
    copy_rows(map, source, sizeof(*dst), y0, y1, dst);
}

void ttf_compose_rows8(const struct ttf_quilt_map *map, const uint8_t *source, uint32_t y0,
                       uint32_t y1, uint8_t *dst)
{
    copy_rows(map, source, sizeof(*dst), y0, y1, dst);
}

static void copy_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct compose *compose = ctx;
    uint32_t y0 = tile * TILE_ROWS;
    uint32_t y1 = y0 + TILE_ROWS < compose->map->height ? y0 + TILE_ROWS : compose->map->height;

    (void)worker;
    ttf_compose_rows(compose->map, compose->source, y0, y1, compose->dst);
}

uint16_t ttf_blend(uint16_t below, uint16_t above, uint32_t weight)
{
    /* at most 65535 * 65536 + 32768: it fits */
    return (uint16_t)((below * (65536u - weight) + above * weight + 32768u) >> 16);
}

void ttf_compose_layers(const struct ttf_quilt_map *map, const uint16_t *source, uint16_t *dst)
{
    for (size_t i = 0; i < map->n_layers; i++) {
        const struct ttf_quilt_layer *layer = &map->layers[i];
        const uint16_t *above = source + (size_t)layer->source * 3;
        uint16_t *at = dst + (size_t)layer->pixel * 3;

        for (int c = 0; c < 3; c++)
            at[c] = ttf_blend(at[c], above[c], layer->weight);
    }
}

void ttf_compose_frame(const struct ttf_quilt_map *map, struct ttf_pool *pool,
                       const uint16_t *source, uint16_t *dst)
{
    struct compose compose = {map, source, dst};

    ttf_pool_run(pool, (map->height + TILE_ROWS - 1) / TILE_ROWS, copy_tile, &compose);
    ttf_compose_layers(map, source, dst);
}

void ttf_quilt_compose(const struct ttf_quilt_map *map, const uint16_t *source, uint16_t *dst)
{
    ttf_compose_frame(map, NULL, source, dst);
}
