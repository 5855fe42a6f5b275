/* SPDX-License-Identifier: Apache-2.0 */
/* quilt_files.c: see quilt_files.h. */
#include "quilt_files.h"

#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/synth/map_file.h"

#define TIME_ONE 65536u /* a frame, in a map's times */
#define MAP_MAX  ((size_t)1 << 31)

/* ---- maps ---- */

/* How far off its own time any block ever is, in whole frames: what a jitter of so many says. */
static uint32_t jitter_of(const struct ttf_quilt_map *map)
{
    uint64_t most = 0;

    for (unsigned i = 0; map->times && i < map->n_blocks; i++) {
        for (uint32_t t = 0; t < map->n_times; t++) {
            int64_t off = (int64_t)map->times[(size_t)i * map->n_times + t] - (int64_t)t * TIME_ONE;
            uint64_t size = (uint64_t)(off < 0 ? -off : off);

            most = size > most ? size : most;
        }
    }
    most = (most + TIME_ONE - 1) / TIME_ONE;
    if (most < 1 && map->times)
        most = 1;
    return most < 1u << 20 ? (uint32_t)most : 1u << 20;
}

static uint32_t at_least(uint32_t a, uint32_t b)
{
    return a > b ? a : b;
}

static uint32_t at_most(uint32_t a, uint32_t b)
{
    return a < b ? a : b;
}

/*
 * The block that was asked for. Of a map that does not say, what suits a configuration's rules: its
 * first block may be cut off by a small output, and twice the overlap is what it was at least.
 */
static void describe_block(const struct ttf_quilt_map *map, const struct ttf_sequence *input,
                           struct ttf_quilt_config *config)
{
    const struct ttf_quilt_block *first = &map->blocks[0];
    uint32_t width = map->block_width ? map->block_width : first->width;
    uint32_t height = map->block_height ? map->block_height : first->height;

    config->block_width = at_most(at_least(at_least(width, 2 * map->overlap_x), 4), input->width);
    config->block_height =
        at_most(at_least(at_least(height, 2 * map->overlap_y), 4), input->height);
}

void quilt_map_describe(const struct ttf_quilt_map *map, const struct ttf_sequence *input,
                        struct ttf_quilt_config *config)
{
    if (!map->blocks)
        return;
    config->width = map->width;
    config->height = map->height;
    describe_block(map, input, config);
    config->overlap_x = at_most(map->overlap_x, config->block_width / 2);
    config->overlap_y = at_most(map->overlap_y, config->block_height / 2);
    config->feather_px = at_most(map->feather_px, at_most(config->overlap_x, config->overlap_y));
    config->tileable =
        map->tileable && map->width >= config->block_width && map->height >= config->block_height;
    config->jitter_frames = jitter_of(map);
    config->jitter_round = config->jitter_round || map->rounded;
    config->rate = map->rate.m ? &map->rate : NULL;
    config->replay = map;
}

int quilt_map_load(struct cli *cli, struct ttf_quilt_map *ret)
{
    char *text = NULL;
    size_t bytes = 0;
    int r;

    if (!cli->opt.map)
        return 0;
    r = ttf_io_slurp(cli->io, cli->opt.map, MAP_MAX, &text, &bytes, &cli->err);
    if (r == 0)
        r = ttf_quilt_map_parse(text, bytes, 0, ret, &cli->err);
    free(text);
    if (r < 0) {
        ttf_err_prefix(&cli->err, "--map %s", cli->opt.map);
        return r;
    }
    if (cli->opt.check && (ret->times || ret->rate.m)) {
        ttf_err_set(&cli->err, -EINVAL, "--check", "the map gives %s of their own",
                    ret->times ? "blocks times" : "pixels a pace");
        return ttf_err_hint(&cli->err, "such an output is no plain copy of its input"), -EINVAL;
    }
    return 0;
}

int quilt_map_save(struct cli *cli, const struct ttf_quilt_map *map)
{
    struct ttf_json json;
    const char *text;
    size_t bytes;
    int r;

    if (!cli->opt.save_map)
        return 0;
    ttf_json_init(&json, true);
    ttf_quilt_map_json(map, &json);
    r = ttf_json_finish(&json, &text, &bytes);
    if (r == 0)
        r = ttf_io_write_file(cli->io, cli->opt.save_map, text, bytes, &cli->err);
    else
        ttf_err_set(&cli->err, r, "--save-map", "cannot be made");
    ttf_json_free(&json);
    return r;
}
