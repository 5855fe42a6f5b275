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

/*
 * Of a tileable output: blocks until `size` is covered around, but at least half a block apart,
 * so that only the last one reaches over the border and knows both its neighbours.
 */
static uint32_t count_around(uint32_t size, uint32_t block, uint32_t step)
{
    uint32_t n = (size + step - 1) / step, most = 2 * size / block;

    return n < most ? n : most;
}

/* The least overlap of n blocks spread evenly. */
static uint32_t least_overlap(uint32_t size, uint32_t block, uint32_t n)
{
    return block - (size + n - 1) / n;
}

void ttf_placement_make(const struct ttf_quilt_config *config, struct ttf_placement *ret)
{
    ret->overlap_x = ttf_placement_overlap(config->overlap_x, config->block_width);
    ret->overlap_y = ttf_placement_overlap(config->overlap_y, config->block_height);
    ret->step_x = config->block_width - ret->overlap_x;
    ret->step_y = config->block_height - ret->overlap_y;
    if (config->tileable) {
        ret->columns = count_around(config->width, config->block_width, ret->step_x);
        ret->rows = count_around(config->height, config->block_height, ret->step_y);
        ret->overlap_x = least_overlap(config->width, config->block_width, ret->columns);
        ret->overlap_y = least_overlap(config->height, config->block_height, ret->rows);
        return;
    }
    ret->columns = count(config->width, config->block_width, ret->step_x);
    ret->rows = count(config->height, config->block_height, ret->step_y);
}

/* A block that is not the first of its row ends beyond the one before, so it is wider than the overlap. */
static uint32_t clipped(uint32_t at, uint32_t block, uint32_t size)
{
    return size - at < block ? size - at : block;
}

/* One axis of a tileable output: blocks at i * size / n, each reaching into the next. */
static void around(uint32_t i, uint32_t n, uint32_t size, uint32_t block, uint32_t *ret_at,
                   uint16_t *ret_before, uint16_t *ret_behind)
{
    uint32_t at = (uint32_t)((uint64_t)i * size / n);
    uint32_t before = i > 0 ? (uint32_t)((uint64_t)(i - 1) * size / n) : 0;

    *ret_at = at;
    *ret_before = (uint16_t)(i > 0 ? before + block - at : 0);
    *ret_behind = (uint16_t)(i + 1 == n ? at + block - size : 0);
}

void ttf_placement_block(const struct ttf_placement *placement,
                         const struct ttf_quilt_config *config, unsigned i,
                         struct ttf_quilt_block *ret)
{
    uint32_t column = i % placement->columns, row = i / placement->columns;

    if (config->tileable) {
        ret->width = config->block_width;
        ret->height = config->block_height;
        around(column, placement->columns, config->width, ret->width, &ret->out_x, &ret->left,
               &ret->right);
        around(row, placement->rows, config->height, ret->height, &ret->out_y, &ret->top,
               &ret->bottom);
        return;
    }
    ret->out_x = column * placement->step_x;
    ret->out_y = row * placement->step_y;
    ret->width = clipped(ret->out_x, config->block_width, config->width);
    ret->height = clipped(ret->out_y, config->block_height, config->height);
    ret->left = (uint16_t)(column > 0 ? placement->overlap_x : 0);
    ret->top = (uint16_t)(row > 0 ? placement->overlap_y : 0);
    ret->right = ret->bottom = 0;
}
