/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>

#include "ttf/synth/metrics.h"

/* Was `block` taken from where `neighbour` was, moved as in the output? */
static bool continues(const struct ttf_quilt_block *block, const struct ttf_quilt_block *neighbour)
{
    return block->input == neighbour->input && block->turn == neighbour->turn &&
           block->src_x - neighbour->src_x == block->out_x - neighbour->out_x &&
           block->src_y - neighbour->src_y == block->out_y - neighbour->out_y;
}

/* Blocks lie in raster order: the first row has as many as a row has. */
static double verbatim_share(const struct ttf_quilt_map *map)
{
    unsigned columns = 1, verbatim = 0;

    while (columns < map->n_blocks && map->blocks[columns].out_y == 0)
        columns++;
    for (unsigned i = 1; i < map->n_blocks; i++) {
        const struct ttf_quilt_block *block = &map->blocks[i];

        verbatim += (block->out_x > 0 && continues(block, &map->blocks[i - 1])) ||
                    (block->out_y > 0 && continues(block, &map->blocks[i - columns]));
    }
    return map->n_blocks > 1 ? (double)verbatim / (map->n_blocks - 1) : 0.0;
}

int ttf_repetition_of_map(const struct ttf_quilt_map *map, struct ttf_repetition_figures *ret)
{
    size_t source_pixels = map->source_pixels;
    size_t pixels = (size_t)map->width * map->height, used = 0;
    uint32_t *uses = calloc(source_pixels, sizeof(*uses));
    uint32_t most = 0;

    if (!uses)
        return -ENOMEM;
    for (size_t i = 0; i < pixels; i++) {
        uint32_t n = ++uses[map->source[i]];

        used += n == 1;
        most = n > most ? n : most;
    }
    free(uses);
    *ret = (struct ttf_repetition_figures){.verbatim_share = verbatim_share(map),
                                           .source_coverage = (double)used / (double)source_pixels,
                                           .mean_uses = (double)pixels / (double)used,
                                           .max_uses = most};
    return 0;
}
