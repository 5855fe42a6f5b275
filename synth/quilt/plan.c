/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The plan: the matching data, then all blocks. Block (column c, row r) overlaps (c-1, r),
 * (c-1, r-1), (c, r-1) and (c+1, r-1), which all lie on earlier waves c + 2 r: so the blocks of one
 * wave can be placed side by side, and the result is that of raster order. Where repetition is
 * avoided a block looks as far as (c+3, r-1), and waves are c + 4 r. (A tileable
 * output's edges meet blocks of other waves: it is placed in raster order.)
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/avoid.h"
#include "quilt/map_of_sources.h"
#include "quilt/paste.h"
#include "quilt/plan_private.h"
#include "quilt/time_jitter.h"
#include "search/hash.h"

static int64_t now_ns(const struct ttf_quilt_config *config)
{
    return config->now_ns ? config->now_ns(config->now_ctx) : 0;
}

static void plan_free(struct ttf_plan *plan)
{
    ttf_search_destroy(plan->full);
    ttf_trajectories_free(&plan->trajectories);
    ttf_views_free(&plan->views);
    ttf_matching_free(&plan->matching);
    ttf_quilt_map_free(&plan->map);
    for (unsigned i = 0; plan->rooms && i < plan->n_rooms; i++) {
        ttf_rank_workspace_destroy(plan->rooms[i].search);
        free(plan->rooms[i].known);
        free(plan->rooms[i].error);
        free(plan->rooms[i].cut);
        free(plan->rooms[i].excluded);
    }
    free(plan->rooms);
}

static int room_alloc(const struct ttf_plan *plan, struct ttf_place_room *room)
{
    size_t width = plan->config->block_width, height = plan->config->block_height;
    size_t longest = width > height ? width : height;

    room->known = malloc(width * height * sizeof(*room->known));
    room->error = malloc(width * height * sizeof(*room->error));
    room->cut = malloc(longest * sizeof(*room->cut));
    room->excluded = malloc(TTF_AVOID_RECTS_MAX * sizeof(*room->excluded));
    if (!room->known || !room->error || !room->cut || !room->excluded)
        return -ENOMEM;
    return ttf_rank_workspace_create(&room->search);
}

/* All blocks' places, and room for their cuts. */
static int lay_out(struct ttf_plan *plan)
{
    struct ttf_quilt_map *map = &plan->map;

    map->blocks = calloc(map->n_blocks, sizeof(*map->blocks));
    if (!map->blocks)
        return -ENOMEM;
    for (unsigned i = 0; i < map->n_blocks; i++) {
        ttf_placement_block(&plan->placement, plan->config, i, &map->blocks[i]);
        map->blocks[i].cuts = (uint32_t)map->n_cuts;
        map->n_cuts += ttf_block_cuts(&map->blocks[i]);
    }
    map->cuts = calloc(map->n_cuts + 1, sizeof(*map->cuts));
    return map->cuts ? 0 : -ENOMEM;
}

static int plan_alloc(struct ttf_plan *plan, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = plan->config;
    struct ttf_quilt_map *map = &plan->map;
    size_t pixels = (size_t)config->width * config->height;
    int r = 0;

    ttf_quilt_map_of_sources(&plan->sources, map);
    map->width = config->width;
    map->height = config->height;
    map->overlap_x = plan->placement.overlap_x;
    map->overlap_y = plan->placement.overlap_y;
    map->tileable = config->tileable;
    map->feather_px = config->feather_px;
    map->n_blocks = plan->placement.columns * plan->placement.rows;
    map->source = malloc(pixels * sizeof(*map->source));
    map->owner = malloc(pixels * sizeof(*map->owner));
    plan->n_rooms = ttf_pool_threads(plan->pool);
    plan->rooms = calloc(plan->n_rooms, sizeof(*plan->rooms));
    if (!map->source || !map->owner || !plan->rooms || lay_out(plan) < 0)
        r = -ENOMEM;
    for (unsigned i = 0; r == 0 && i < plan->n_rooms; i++)
        r = room_alloc(plan, &plan->rooms[i]);
    return r < 0 ? ttf_err_set(err, r, NULL, "no memory for a map of %u x %u pixels", config->width,
                               config->height)
                 : 0;
}

/* ---- the raster loop, in waves ---- */

struct wave {
    struct ttf_plan *plan;
    uint32_t lag;       /* waves that a row is behind the one above */
    uint32_t first_row; /* block of tile i: row first_row + i, on the wave */
    uint32_t index;
    int results[64]; /* by tile % 64; negative stays */
};

static void wave_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct wave *wave = ctx;
    uint32_t row = wave->first_row + tile, columns = wave->plan->placement.columns;
    unsigned i = row * columns + (wave->index - wave->lag * row);
    int r = ttf_place_block(wave->plan, &wave->plan->rooms[worker], i);

    if (r < 0)
        __atomic_store_n(&wave->results[tile % 64], r, __ATOMIC_RELAXED);
}

static int run_wave(struct wave *wave)
{
    uint32_t columns = wave->plan->placement.columns, rows = wave->plan->placement.rows;
    uint32_t lag = wave->lag;
    uint32_t first = wave->index + 1 > columns ? (wave->index + lag - columns) / lag : 0;
    uint32_t last = wave->index / lag < rows - 1 ? wave->index / lag : rows - 1;

    wave->first_row = first;
    if (first <= last)
        ttf_pool_run(wave->plan->pool, last - first + 1, wave_tile, wave);
    for (int i = 0; i < 64; i++) {
        if (wave->results[i] < 0)
            return wave->results[i];
    }
    return 0;
}

static int place_in_waves(struct ttf_plan *plan, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = plan->config;
    uint32_t lag = config->avoid_px > 0 ? TTF_AVOID_BLOCKS + 1 : 2;
    uint32_t waves = plan->placement.columns + lag * (plan->placement.rows - 1);
    struct wave wave = {.plan = plan, .lag = lag};
    int r;

    for (uint32_t i = 0; i < waves; i++) {
        if (config->cancel && *config->cancel)
            return ttf_err_set(err, -ECANCELED, NULL, "cancelled");
        wave.index = i;
        r = run_wave(&wave);
        if (r < 0)
            return ttf_err_set(err, r, NULL, "no memory to place the blocks");
        if (config->progress)
            config->progress(config->progress_ctx, (i + 1.0) / waves);
    }
    return 0;
}

static int place_in_order(struct ttf_plan *plan, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = plan->config;

    for (unsigned i = 0; i < plan->map.n_blocks; i++) {
        int r;

        if (config->cancel && *config->cancel)
            return ttf_err_set(err, -ECANCELED, NULL, "cancelled");
        r = ttf_place_block(plan, &plan->rooms[0], i);
        if (r < 0)
            return ttf_err_set(err, r, NULL, "no memory to place block %u of %u", i,
                               plan->map.n_blocks);
        if (config->progress)
            config->progress(config->progress_ctx, (i + 1.0) / plan->map.n_blocks);
    }
    return 0;
}

/* ---- matching data ---- */

static uint32_t narrowest(const struct ttf_plan *plan)
{
    return plan->placement.overlap_x < plan->placement.overlap_y ? plan->placement.overlap_x
                                                                 : plan->placement.overlap_y;
}

static int prepare_full(struct ttf_plan *plan, uint32_t first, uint32_t frames, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = plan->config;
    struct ttf_quilt_search_figures *figures = &plan->map.figures;
    struct ttf_sequence *input = plan->sources.list[0];
    int64_t start_ns = now_ns(config), loaded_ns;
    int r = ttf_trajectories_load(input, first, frames, config->metric, plan->pool, config->cancel,
                                  &plan->trajectories, err);

    if (r < 0)
        return r;
    loaded_ns = now_ns(config);
    figures->noise_variance = ttf_trajectories_noise(&plan->trajectories);
    r = ttf_search_create(&plan->trajectories, narrowest(plan), config->tolerance,
                          figures->noise_variance, NULL, plan->pool, &plan->full);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory to match %u frames of %u x %u", frames,
                           input->width, input->height);
    figures->load_ns = loaded_ns - start_ns;
    figures->prepare_ns = now_ns(config) - loaded_ns;
    /* only for its geometry: a matching without numbers */
    r = ttf_views_create(&plan->sources, &plan->matching, 1u, 1, plan->pool, &plan->views);
    return r < 0 ? ttf_err_set(err, r, NULL, "no memory to match %u pixels", plan->sources.pixels)
                 : 0;
}

static int prepare_rank(struct ttf_plan *plan, uint32_t first, uint32_t frames, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = plan->config;
    struct ttf_quilt_search_figures *figures = &plan->map.figures;
    uint32_t narrow = narrowest(plan);
    int64_t start_ns = now_ns(config), loaded_ns;
    int r =
        ttf_matching_build(config, &plan->sources, first, frames, plan->pool, &plan->matching, err);

    if (r < 0)
        return r;
    loaded_ns = now_ns(config);
    r = ttf_views_create(&plan->sources, &plan->matching, ttf_quilt_turns(config), narrow,
                         plan->pool, &plan->views);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory to match %u pixels", plan->sources.pixels);
    plan->rank = (struct ttf_rank_search){&plan->matching, &plan->views, ttf_rank_kernels_best(),
                                          config->tolerance};
    plan->map.rank = plan->matching.figures;
    figures->noise_variance = plan->matching.noise;
    figures->load_ns = loaded_ns - start_ns;
    figures->prepare_ns = now_ns(config) - loaded_ns;
    return 0;
}

static void sum_up(struct ttf_plan *plan)
{
    struct ttf_quilt_search_figures *figures = &plan->map.figures;
    struct ttf_search_counts full;

    for (unsigned i = 0; i < plan->n_rooms; i++) {
        struct ttf_rank_counts counts = ttf_rank_workspace_counts(plan->rooms[i].search);

        figures->positions += counts.positions;
        figures->survived_cells += counts.survived_cells;
        figures->exact += counts.exact;
        figures->search_ns += plan->rooms[i].search_ns;
        figures->cut_ns += plan->rooms[i].cut_ns;
    }
    if (!plan->full)
        return;
    ttf_search_counts(plan->full, &full);
    figures->positions = full.positions;
    figures->survived_cells = full.survived_cells;
    figures->survived_rank = full.survived_rank;
    figures->exact = full.exact;
}

static int plan_range(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                      uint32_t first, uint32_t frames, uint64_t seed, struct ttf_pool *pool,
                      struct ttf_quilt_map *ret, struct ttf_err *err)
{
    struct ttf_plan plan = {.config = config, .pool = pool, .seed = seed};
    bool full = config->rank == TTF_QUILT_RANK_FULL && !(config->rank_error > 0.0);
    int r = ttf_quilt_validate(config, input, err);

    if (r == 0)
        r = ttf_sources_of(config, input, &plan.sources, err);
    if (r < 0)
        return r;
    ttf_placement_make(config, &plan.placement);
    r = plan_alloc(&plan, err);
    if (r == 0)
        r = full ? prepare_full(&plan, first, frames, err)
                 : prepare_rank(&plan, first, frames, err);
    plan.map.figures.matching_bytes = ttf_quilt_matching_bytes(config, plan.sources.pixels, frames);
    if (r == 0)
        r = full || config->tileable ? place_in_order(&plan, err) : place_in_waves(&plan, err);
    if (r == 0 && (config->feather_px > 1 ? ttf_paste_all(&plan.map) : 0) < 0)
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory to blend seams");
    if (r == 0 && ttf_quilt_map_index(&plan.map) < 0)
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory for a map of %u x %u pixels", config->width,
                        config->height);
    if (r == 0 && config->jitter_frames > 0 &&
        ttf_time_jitter_fill(seed, config->jitter_frames, config->jitter_every, frames, &plan.map) <
            0)
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory for the blocks' times");
    if (r == 0) {
        sum_up(&plan);
        *ret = plan.map;
        memset(&plan.map, 0, sizeof(plan.map));
    }
    plan_free(&plan);
    return r;
}

int ttf_quilt_plan(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                   struct ttf_pool *pool, struct ttf_quilt_map *ret, struct ttf_err *err)
{
    if (config->per_frame)
        return ttf_err_set(err, -EINVAL, "per_frame", "quilting each frame alone has no one map");
    return plan_range(config, input, 0, input->n, config->seed, pool, ret, err);
}

int ttf_quilt_frame_map(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                        uint32_t t, struct ttf_pool *pool, struct ttf_quilt_map *ret,
                        struct ttf_err *err)
{
    struct ttf_quilt_config alone = *config;

    if (t >= input->n)
        return ttf_err_set(err, -EINVAL, "frame", "%u is not one of %u frames", t, input->n);
    alone.per_frame = true;
    alone.jitter_frames = 0;
    return plan_range(&alone, input, t, 1, ttf_random64(config->seed, TTF_PURPOSE_FRAME, t), pool,
                      ret, err);
}
