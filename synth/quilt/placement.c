/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/placement.h"

uint32_t ttf_placement_overlap(uint32_t asked, uint32_t block)
{
    uint32_t sixth = (2 * block + 6) / 12;

    if (asked > 0)
        return asked;
    return sixth > 2 ? sixth : 2;
}

/* Blocks of `block` that overlap by block - step, until `size` is covered. */
static uint32_t count(uint32_t size, uint32_t block, uint32_t step)
{
    return size <= block ? 1 : 1 + (size - block + step - 1) / step;
}

void ttf_placement_make(const struct ttf_quilt_config *config, struct ttf_placement *ret)
{
    ret->overlap_x = ttf_placement_overlap(config->overlap_x, config->block_width);
    ret->overlap_y = ttf_placement_overlap(config->overlap_y, config->block_height);
    ret->step_x = config->block_width - ret->overlap_x;
    ret->step_y = config->block_height - ret->overlap_y;
    ret->columns = count(config->width, config->block_width, ret->step_x);
    ret->rows = count(config->height, config->block_height, ret->step_y);
}

/* A block that is not the first of its row ends beyond the one before, so it is wider than the overlap. */
static uint32_t clipped(uint32_t at, uint32_t block, uint32_t size)
{
    return size - at < block ? size - at : block;
}

void ttf_placement_block(const struct ttf_placement *placement,
                         const struct ttf_quilt_config *config, unsigned i,
                         struct ttf_quilt_block *ret)
{
    ret->out_x = (i % placement->columns) * placement->step_x;
    ret->out_y = (i / placement->columns) * placement->step_y;
    ret->width = clipped(ret->out_x, config->block_width, config->width);
    ret->height = clipped(ret->out_y, config->block_height, config->height);
}
