/* SPDX-License-Identifier: Apache-2.0 */
#include <stdlib.h>
#include <string.h>

#include "search/hash.h"
#include "ttf/synth/quilt.h"

void ttf_quilt_map_free(struct ttf_quilt_map *map)
{
    free(map->source);
    free(map->blocks);
    free(map->layers);
    memset(map, 0, sizeof(*map));
}

uint64_t ttf_quilt_map_digest(const struct ttf_quilt_map *map)
{
    size_t pixels = (size_t)map->width * map->height;
    uint64_t h = ttf_mix64(((uint64_t)map->width << 32) + map->height);

    h = ttf_mix64(h ^ (((uint64_t)map->source_width << 32) + map->source_height));
    for (size_t i = 0; i < pixels; i++)
        h = ttf_mix64(h + map->source[i]);
    for (size_t i = 0; i < map->n_layers; i++) {
        h = ttf_mix64(h + map->layers[i].pixel);
        h = ttf_mix64(h + map->layers[i].source);
        h = ttf_mix64(h + map->layers[i].weight);
    }
    return h;
}
