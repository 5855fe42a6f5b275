/* SPDX-License-Identifier: Apache-2.0 */
/* map_write.c: a map as JSON; see map_file.h. */
#include <stdio.h>

#include "quilt/map_format.h"
#include "quilt/map_rate.h"
#include "quilt/paste.h"
#include "ttf/synth/map_file.h"

/* On one line also where the rest is not. */
static void put_pair(struct ttf_json *json, const char *key, uint32_t a, uint32_t b)
{
    char text[32];

    if (key)
        ttf_json_key(json, key);
    (void)snprintf(text, sizeof(text), "[%u,%u]", a, b);
    ttf_json_raw(json, text);
}

static void put_cut(struct ttf_json *json, const char *key, const uint16_t *cut, uint32_t n)
{
    if (!cut)
        return;
    ttf_json_key(json, key);
    ttf_json_array(json);
    for (uint32_t i = 0; i < n; i++)
        ttf_json_int(json, cut[i]);
    ttf_json_array_end(json);
}

static void put_cuts(struct ttf_json *json, const struct ttf_quilt_map *map,
                     const struct ttf_quilt_block *block)
{
    struct ttf_block_cut_places places = ttf_block_cut_places(map, block);

    ttf_json_key(json, "cuts");
    ttf_json_object(json);
    put_cut(json, "left", places.left, block->height);
    put_cut(json, "top", places.top, block->width);
    put_cut(json, "right", places.right, block->height);
    put_cut(json, "bottom", places.bottom, block->width);
    ttf_json_object_end(json);
}

static void put_block(struct ttf_json *json, const struct ttf_quilt_map *map, unsigned i)
{
    const struct ttf_quilt_block *block = &map->blocks[i];

    ttf_json_object(json);
    put_pair(json, "at", block->out_x, block->out_y);
    put_pair(json, "size", block->width, block->height);
    ttf_json_key(json, "arms");
    ttf_json_array(json);
    ttf_json_int(json, block->left);
    ttf_json_int(json, block->top);
    ttf_json_int(json, block->right);
    ttf_json_int(json, block->bottom);
    ttf_json_array_end(json);
    ttf_json_kint(json, "input", block->input);
    ttf_json_kint(json, "turn", block->turn);
    put_pair(json, "from", block->src_x, block->src_y);
    put_cuts(json, map, block);
    ttf_json_kdouble(json, "error", block->error);
    ttf_json_kdouble(json, "best_error", block->best_error);
    ttf_json_kint(json, "overlap_pixels", block->overlap_pixels);
    ttf_json_kint(json, "candidates", block->candidates);
    if (map->times) {
        const uint32_t *times = map->times + (size_t)i * map->n_times;

        ttf_json_key(json, "times");
        ttf_json_array(json);
        for (uint32_t t = 0; t < map->n_times; t++)
            ttf_json_int(json, times[t]);
        ttf_json_array_end(json);
    }
    ttf_json_object_end(json);
}

/* A block is one line: thousands of numbers are no easier to read below one another. */
static void put_block_line(struct ttf_json *json, const struct ttf_quilt_map *map, unsigned i)
{
    struct ttf_json line;
    const char *text;
    size_t bytes;

    ttf_json_init(&line, false);
    put_block(&line, map, i);
    if (ttf_json_finish(&line, &text, &bytes) == 0)
        ttf_json_raw(json, text);
    else if (json->error == 0)
        json->error = line.error;
    ttf_json_free(&line);
}

void ttf_quilt_map_json(const struct ttf_quilt_map *map, struct ttf_json *json)
{
    ttf_json_object(json);
    ttf_json_kstring(json, "format", TTF_MAP_FORMAT);
    ttf_json_kint(json, "version", TTF_MAP_VERSION);
    put_pair(json, "size", map->width, map->height);
    ttf_json_key(json, "inputs");
    ttf_json_array(json);
    for (unsigned i = 0; i < map->n_inputs; i++)
        put_pair(json, NULL, map->inputs[i].width, map->inputs[i].height);
    ttf_json_array_end(json);
    if (map->block_width > 0)
        put_pair(json, "block", map->block_width, map->block_height);
    put_pair(json, "overlap", map->overlap_x, map->overlap_y);
    ttf_json_kbool(json, "tileable", map->tileable);
    ttf_json_kint(json, "feather_px", map->feather_px);
    if (map->frames > 0)
        ttf_json_kint(json, "frames", map->frames);
    ttf_json_kint(json, "times_of_frames", map->times ? map->n_times : 0);
    if (map->rounded)
        ttf_json_kbool(json, "rounded", true);
    ttf_json_key(json, "blocks");
    ttf_json_array(json);
    for (unsigned i = 0; i < map->n_blocks; i++)
        put_block_line(json, map, i);
    ttf_json_array_end(json);
    if (map->rate.m)
        ttf_map_rate_put(json, &map->rate);
    ttf_json_object_end(json);
}
