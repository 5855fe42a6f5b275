/* SPDX-License-Identifier: Apache-2.0 */
/* The plan: the matching data, then all blocks (order.h). */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/avoid.h"
#include "quilt/map_of_sources.h"
#include "quilt/order.h"
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

static int prepare_rank(struct ttf_plan *plan, uint32_t first, uint32_t frames,
                        const struct ttf_aside *aside, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = plan->config;
    struct ttf_quilt_search_figures *figures = &plan->map.figures;
    uint32_t narrow = narrowest(plan);
    int64_t start_ns = now_ns(config), loaded_ns;
    int r = ttf_matching_build(config, &plan->sources, first, frames, aside, plan->pool,
                               &plan->matching, err);

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
                      struct ttf_ahead *ahead, struct ttf_quilt_map *ret, struct ttf_err *err)
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
                 : prepare_rank(&plan, first, frames, ahead ? ttf_ahead_aside(ahead) : NULL, err);
    plan.map.figures.matching_bytes = ttf_quilt_matching_bytes(config, plan.sources.pixels, frames);
    if (r == 0)
        r = full || config->tileable ? ttf_order_raster(&plan, err)
                                     : ttf_order_rows(&plan, ahead, err);
    if (r == 0 && (config->feather_px > 1 ? ttf_paste_all(&plan.map) : 0) < 0)
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory to blend seams");
    if (r == 0 && !plan.map.runs && ttf_quilt_map_index(&plan.map) < 0)
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory for a map of %u x %u pixels", config->width,
                        config->height);
    if (r == 0 && config->jitter_frames > 0 &&
        ttf_time_jitter_fill(seed, config->jitter_frames, config->jitter_every, frames, &plan.map) <
            0)
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory for the blocks' times");
    plan.map.block_width = config->block_width;
    plan.map.block_height = config->block_height;
    plan.map.frames = frames;
    plan.map.rounded = config->jitter_round && (config->jitter_frames > 0 || config->rate);
    if (r == 0) {
        sum_up(&plan);
        *ret = plan.map;
        memset(&plan.map, 0, sizeof(plan.map));
    }
    plan_free(&plan);
    return r;
}

int ttf_plan_ahead(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                   struct ttf_pool *pool, struct ttf_ahead *ahead, struct ttf_quilt_map *ret,
                   struct ttf_err *err)
{
    if (config->per_frame)
        return ttf_err_set(err, -EINVAL, "per_frame", "quilting each frame alone has no one map");
    return plan_range(config, input, 0, input->n, config->seed, pool, ahead, ret, err);
}

int ttf_quilt_plan(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                   struct ttf_pool *pool, struct ttf_quilt_map *ret, struct ttf_err *err)
{
    return ttf_plan_ahead(config, input, pool, NULL, ret, err);
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
                      NULL, ret, err);
}
