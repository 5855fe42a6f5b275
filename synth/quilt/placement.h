/* SPDX-License-Identifier: Apache-2.0 */
/*
 * placement.h: where blocks lie in the output: a grid in raster order. Its last blocks are clipped;
 * those of a tileable output are spread evenly instead, at least half a block apart, and the last
 * of a row and column reach around to the first.
 */
#ifndef TTF_SYNTH_QUILT_PLACEMENT_H
#define TTF_SYNTH_QUILT_PLACEMENT_H

#include <stdint.h>

#include "ttf/synth/quilt.h"

struct ttf_placement {
    uint32_t columns, rows; /* of blocks */
    uint32_t step_x, step_y;
    uint32_t overlap_x, overlap_y; /* of a tileable output the least */
};

/* The overlap of a side of `block` pixels: what was asked for, or max(2, round(block / 6)). */
uint32_t ttf_placement_overlap(uint32_t asked, uint32_t block);

/* config has been validated. */
void ttf_placement_make(const struct ttf_quilt_config *config, struct ttf_placement *ret);

/* Fills place, size and overlaps of block i. */
void ttf_placement_block(const struct ttf_placement *placement,
                         const struct ttf_quilt_config *config, unsigned i,
                         struct ttf_quilt_block *ret);

#endif
