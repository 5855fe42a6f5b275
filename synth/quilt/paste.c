/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/paste.h"

#include <stdlib.h>
#include <string.h>

#include "search/views.h"

struct ttf_block_cut_places ttf_block_cut_places(const struct ttf_quilt_map *map,
                                                 const struct ttf_quilt_block *block)
{
    struct ttf_block_cut_places places = {0};
    uint16_t *at = map->cuts + block->cuts;

    if (block->left > 0) {
        places.left = at;
        at += block->height;
    }
    if (block->right > 0) {
        places.right = at;
        at += block->height;
    }
    if (block->top > 0) {
        places.top = at;
        at += block->width;
    }
    if (block->bottom > 0)
        places.bottom = at;
    return places;
}

struct paste {
    const struct ttf_quilt_block *block;
    struct ttf_block_cut_places cuts;
    uint32_t feather_px;
};

/* Is a pixel on the new side of all cuts? The pixel on a cut itself is new. */
static bool is_new(const struct paste *p, uint32_t x, uint32_t y)
{
    const struct ttf_quilt_block *b = p->block;

    return (x >= b->left || x >= p->cuts.left[y]) && (y >= b->top || y >= p->cuts.top[x]) &&
           (x + b->right < b->width || x + b->right - b->width <= p->cuts.right[y]) &&
           (y + b->bottom < b->height || y + b->bottom - b->height <= p->cuts.bottom[x]);
}

/* Weight of the new block at a pixel that is known already, 0..65536. */
static uint32_t blend_weight(const struct paste *p, uint32_t x, uint32_t y)
{
    const struct ttf_quilt_block *b = p->block;
    uint64_t weight = 65536;

    if (x < b->left)
        weight = ttf_layers_weight(x, p->cuts.left[y], b->left, p->feather_px);
    if (y < b->top)
        weight = weight * ttf_layers_weight(y, p->cuts.top[x], b->top, p->feather_px) / 65536;
    if (x + b->right >= b->width)
        weight = weight *
                 (65536 - ttf_layers_weight(x + b->right - b->width, p->cuts.right[y] + 1u,
                                            b->right, p->feather_px)) /
                 65536;
    if (y + b->bottom >= b->height)
        weight = weight *
                 (65536 - ttf_layers_weight(y + b->bottom - b->height, p->cuts.bottom[x] + 1u,
                                            b->bottom, p->feather_px)) /
                 65536;
    return (uint32_t)weight;
}

static bool is_known(const struct ttf_quilt_block *b, uint32_t x, uint32_t y)
{
    return x < b->left || y < b->top || x + b->right >= b->width || y + b->bottom >= b->height;
}

int ttf_paste_block(struct ttf_quilt_map *map, unsigned i, struct ttf_layers *layers)
{
    const struct ttf_quilt_block *block = &map->blocks[i];
    const struct ttf_quilt_input *input = &map->inputs[block->input];
    struct paste paste = {block, ttf_block_cut_places(map, block), map->feather_px};
    struct ttf_view view;
    int r = 0;

    ttf_view_geometry(input->width, input->height, input->first, block->turn, &view);
    for (uint32_t y = 0; y < block->height && r == 0; y++) {
        for (uint32_t x = 0; x < block->width && r == 0; x++) {
            uint32_t id = ttf_view_id(&view, block->src_x + x, block->src_y + y);
            size_t at = ttf_block_pixel(map, block, x, y);

            if (layers && is_known(block, x, y))
                r = ttf_layers_add(layers, (uint32_t)at, map->source[at], map->owner[at], id, i,
                                   blend_weight(&paste, x, y));
            if (is_new(&paste, x, y)) {
                map->source[at] = id;
                map->owner[at] = i;
            }
        }
    }
    return r;
}

int ttf_paste_all(struct ttf_quilt_map *map)
{
    size_t pixels = (size_t)map->width * map->height;
    struct ttf_layers layers = {0};
    bool feathered = map->feather_px > 1;
    int r = feathered ? ttf_layers_begin(&layers, pixels) : 0;

    for (size_t at = 0; at < pixels; at++)
        map->source[at] = TTF_UNKNOWN_ID;
    for (unsigned i = 0; i < map->n_blocks && r == 0; i++)
        r = ttf_paste_block(map, i, feathered ? &layers : NULL);
    if (r == 0) {
        free(map->layers);
        map->layers = layers.list;
        map->n_layers = layers.n;
        layers.list = NULL;
    }
    ttf_layers_free(&layers);
    return r;
}
