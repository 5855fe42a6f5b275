/* SPDX-License-Identifier: Apache-2.0 */
/*
 * paste.h: a block whose source and cuts are known, laid into the map: what a plan does with each
 * block, and what replaying a kept map does with all of them.
 */
#ifndef TTF_SYNTH_QUILT_PASTE_H
#define TTF_SYNTH_QUILT_PASTE_H

#include "quilt/layers.h"
#include "ttf/base/attr.h"
#include "ttf/synth/quilt.h"

/* Cuts that a block has room for in the map's list. */
static inline size_t ttf_block_cuts(const struct ttf_quilt_block *block)
{
    return (block->left > 0 ? block->height : 0u) + (block->right > 0 ? block->height : 0u) +
           (block->top > 0 ? block->width : 0u) + (block->bottom > 0 ? block->width : 0u);
}

/* Where each arm's cuts begin. */
struct ttf_block_cut_places {
    uint16_t *left, *right, *top, *bottom;
};
struct ttf_block_cut_places ttf_block_cut_places(const struct ttf_quilt_map *map,
                                                 const struct ttf_quilt_block *block);

/* Index of the output pixel under a block's (x, y). */
static inline size_t ttf_block_pixel(const struct ttf_quilt_map *map,
                                     const struct ttf_quilt_block *block, uint32_t x, uint32_t y)
{
    uint32_t ox = block->out_x + x, oy = block->out_y + y;

    ox = ox >= map->width ? ox - map->width : ox;
    oy = oy >= map->height ? oy - map->height : oy;
    return (size_t)oy * map->width + ox;
}

/*
 * Writes block i into source and owner: a pixel is new only on the new side of all cuts. layers: may be
 * NULL: no feathering. -ENOMEM.
 */
TTF_MUST_USE int ttf_paste_block(struct ttf_quilt_map *map, unsigned i, struct ttf_layers *layers);

/* All blocks in raster order, from nothing; with the map's feather. -ENOMEM. */
TTF_MUST_USE int ttf_paste_all(struct ttf_quilt_map *map);

#endif
