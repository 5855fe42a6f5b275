/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/compose.h"

#include <string.h>

#define TILE_ROWS 32

struct compose {
    const struct ttf_quilt_map *map;
    const uint16_t *source;
    uint16_t *dst;
};

/* Copies codes as they are; pixels that were neighbours in the source go together. */
static void copy_row(const struct compose *compose, uint32_t y)
{
    const uint32_t *map = compose->map->source + (size_t)y * compose->map->width;
    uint16_t *dst = compose->dst + (size_t)y * compose->map->width * 3;
    uint32_t width = compose->map->width;

    for (uint32_t x = 0, end; x < width; x = end) {
        for (end = x + 1; end < width && map[end] == map[end - 1] + 1; end++)
            ;
        memcpy(dst + (size_t)x * 3, compose->source + (size_t)map[x] * 3,
               (size_t)(end - x) * 3 * sizeof(*dst));
    }
}

static void copy_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct compose *compose = ctx;
    uint32_t y0 = tile * TILE_ROWS;
    uint32_t y1 = y0 + TILE_ROWS < compose->map->height ? y0 + TILE_ROWS : compose->map->height;

    (void)worker;
    for (uint32_t y = y0; y < y1; y++)
        copy_row(compose, y);
}

/* Codes are linear in light, so blending them is blending light. Rounded to nearest. */
static uint16_t blend(uint16_t below, uint16_t above, uint32_t weight)
{
    uint64_t sum = (uint64_t)below * (65536 - weight) + (uint64_t)above * weight;

    return (uint16_t)((sum + 32768) >> 16);
}

void ttf_compose_frame(const struct ttf_quilt_map *map, struct ttf_pool *pool,
                       const uint16_t *source, uint16_t *dst)
{
    struct compose compose = {map, source, dst};

    ttf_pool_run(pool, (map->height + TILE_ROWS - 1) / TILE_ROWS, copy_tile, &compose);
    for (size_t i = 0; i < map->n_layers; i++) {
        const struct ttf_quilt_layer *layer = &map->layers[i];
        const uint16_t *above = source + (size_t)layer->source * 3;
        uint16_t *at = dst + (size_t)layer->pixel * 3;

        for (int c = 0; c < 3; c++)
            at[c] = blend(at[c], above[c], layer->weight);
    }
}

void ttf_quilt_compose(const struct ttf_quilt_map *map, const uint16_t *source, uint16_t *dst)
{
    ttf_compose_frame(map, NULL, source, dst);
}

int ttf_quilt_frame(const struct ttf_quilt_config *config, const struct ttf_quilt_map *map,
                    struct ttf_sequence *input, uint32_t t, uint16_t *scratch, uint16_t *dst,
                    struct ttf_err *err)
{
    int r = ttf_sequence_read_rows(input, t, 0, input->height, scratch, err);

    (void)config;
    if (r < 0)
        return r;
    ttf_compose_frame(map, NULL, scratch, dst);
    return 0;
}
