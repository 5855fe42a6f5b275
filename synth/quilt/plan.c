/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The raster loop: for each block the candidates within tolerance, a pick by hash
 * of (seed, block), the cuts, and the map.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/layers.h"
#include "quilt/placement.h"
#include "seam/boundary_cut.h"
#include "search/block_search.h"
#include "search/hash.h"
#include "ttf/synth/quilt.h"

struct plan {
    const struct ttf_quilt_config *config;
    struct ttf_pool *pool;
    struct ttf_placement placement;
    struct ttf_trajectories trajectories;
    struct ttf_search *search;
    struct ttf_quilt_map map;
    struct ttf_layers layers;
    /* one block's overlap: errors per pixel along each arm, and the cuts */
    uint64_t *left_error, *top_error; /* block height x overlap; block width x overlap */
    uint32_t *left_cut, *top_cut;     /* one per row; one per column */
    uint64_t seed;
};

static int64_t now_ns(const struct ttf_quilt_config *config)
{
    return config->now_ns ? config->now_ns(config->now_ctx) : 0;
}

static void plan_free(struct plan *plan)
{
    ttf_search_destroy(plan->search);
    ttf_trajectories_free(&plan->trajectories);
    ttf_quilt_map_free(&plan->map);
    ttf_layers_free(&plan->layers);
    free(plan->left_error);
    free(plan->top_error);
    free(plan->left_cut);
    free(plan->top_cut);
}

static int plan_alloc(struct plan *plan, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = plan->config;
    const struct ttf_placement *placement = &plan->placement;
    struct ttf_quilt_map *map = &plan->map;
    size_t pixels = (size_t)config->width * config->height;

    map->width = config->width;
    map->height = config->height;
    map->overlap_x = placement->overlap_x;
    map->overlap_y = placement->overlap_y;
    map->n_blocks = placement->columns * placement->rows;
    map->source = malloc(pixels * sizeof(*map->source));
    map->blocks = calloc(map->n_blocks, sizeof(*map->blocks));
    plan->left_error =
        malloc((size_t)config->block_height * placement->overlap_x * sizeof(*plan->left_error));
    plan->top_error =
        malloc((size_t)config->block_width * placement->overlap_y * sizeof(*plan->top_error));
    plan->left_cut = malloc(config->block_height * sizeof(*plan->left_cut));
    plan->top_cut = malloc(config->block_width * sizeof(*plan->top_cut));
    if (!map->source || !map->blocks || !plan->left_error || !plan->top_error || !plan->left_cut ||
        !plan->top_cut || ttf_layers_begin(&plan->layers, pixels) < 0)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a map of %u x %u pixels",
                           config->width, config->height);
    return 0;
}

static void overlap_of(const struct plan *plan, const struct ttf_quilt_block *block,
                       struct ttf_overlap *ret)
{
    const struct ttf_quilt_map *map = &plan->map;

    *ret = (struct ttf_overlap){.width = block->width,
                                .height = block->height,
                                .left = block->out_x > 0 ? plan->placement.overlap_x : 0,
                                .top = block->out_y > 0 ? plan->placement.overlap_y : 0,
                                .known =
                                    map->source + (size_t)block->out_y * map->width + block->out_x,
                                .stride = map->width};
}

/* Chooses where the block comes from. */
static int choose(struct plan *plan, unsigned i, const struct ttf_overlap *overlap)
{
    struct ttf_quilt_block *block = &plan->map.blocks[i];
    uint64_t random = ttf_random64(plan->seed, TTF_PURPOSE_BLOCK, i);
    struct ttf_candidates candidates;
    uint32_t columns = plan->map.source_width - block->width + 1;
    uint32_t position, pick;
    int r;

    if (overlap->left == 0 && overlap->top == 0) {
        block->candidates = columns * (plan->map.source_height - block->height + 1);
        position = ttf_pick(random, block->candidates);
    } else {
        r = ttf_search_run(plan->search, overlap, &candidates);
        if (r < 0)
            return r;
        pick = ttf_pick(random, candidates.n);
        position = candidates.positions[pick];
        block->candidates = candidates.n;
        block->error = (double)candidates.errors[pick];
        block->best_error = (double)candidates.best;
        block->overlap_pixels = (uint32_t)ttf_overlap_pixels(overlap);
    }
    block->src_x = position % columns;
    block->src_y = position / columns;
    return 0;
}

static uint32_t block_source(const struct plan *plan, const struct ttf_quilt_block *block,
                             uint32_t x, uint32_t y)
{
    return (block->src_y + y) * plan->map.source_width + block->src_x + x;
}

/* What the cut sees at one pixel: squared differences summed over channels and all frames. */
static uint64_t pixel_error(const struct plan *plan, const struct ttf_quilt_block *block,
                            const struct ttf_overlap *overlap, uint32_t x, uint32_t y)
{
    uint32_t known = overlap->known[y * overlap->stride + x];

    return ttf_kernels_best()->ssd_u8(
        ttf_trajectory(&plan->trajectories, known),
        ttf_trajectory(&plan->trajectories, block_source(plan, block, x, y)),
        plan->trajectories.dims);
}

static int find_cuts(struct plan *plan, const struct ttf_quilt_block *block,
                     const struct ttf_overlap *overlap)
{
    int r = 0;

    for (uint32_t y = 0; y < block->height; y++) {
        for (uint32_t x = 0; x < overlap->left; x++)
            plan->left_error[(size_t)y * overlap->left + x] =
                pixel_error(plan, block, overlap, x, y);
    }
    for (uint32_t x = 0; x < block->width; x++) {
        for (uint32_t y = 0; y < overlap->top; y++)
            plan->top_error[(size_t)x * overlap->top + y] = pixel_error(plan, block, overlap, x, y);
    }
    if (overlap->left > 0)
        r = ttf_boundary_cut(plan->left_error, block->height, overlap->left, plan->left_cut, NULL);
    if (r == 0 && overlap->top > 0)
        r = ttf_boundary_cut(plan->top_error, block->width, overlap->top, plan->top_cut, NULL);
    return r;
}

/* Weight of the new block at a pixel that is known already. */
static uint32_t blend_weight(const struct plan *plan, const struct ttf_overlap *overlap, uint32_t x,
                             uint32_t y)
{
    uint32_t feather = plan->config->feather_px;
    uint64_t weight = 65536;

    if (x < overlap->left)
        weight = ttf_layers_weight(x, plan->left_cut[y], overlap->left, feather);
    if (y < overlap->top)
        weight = weight * ttf_layers_weight(y, plan->top_cut[x], overlap->top, feather) / 65536;
    return (uint32_t)weight;
}

/* Writes the block into the map: in an L a pixel is new only on the new side of both cuts. */
static int paste(struct plan *plan, const struct ttf_quilt_block *block,
                 const struct ttf_overlap *overlap)
{
    int r = 0;

    for (uint32_t y = 0; y < block->height && r == 0; y++) {
        size_t row = (size_t)(block->out_y + y) * plan->map.width + block->out_x;

        for (uint32_t x = 0; x < block->width && r == 0; x++) {
            uint32_t source = block_source(plan, block, x, y);
            bool known = x < overlap->left || y < overlap->top;

            if (known && plan->config->feather_px > 1)
                r = ttf_layers_add(&plan->layers, (uint32_t)(row + x), plan->map.source[row + x],
                                   source, blend_weight(plan, overlap, x, y));
            if ((x >= overlap->left || x >= plan->left_cut[y]) &&
                (y >= overlap->top || y >= plan->top_cut[x]))
                plan->map.source[row + x] = source;
        }
    }
    return r;
}

static int place_block(struct plan *plan, unsigned i)
{
    struct ttf_quilt_block *block = &plan->map.blocks[i];
    struct ttf_quilt_search_figures *figures = &plan->map.figures;
    int64_t start_ns = now_ns(plan->config), chosen_ns;
    struct ttf_overlap overlap;
    int r;

    ttf_placement_block(&plan->placement, plan->config, i, block);
    overlap_of(plan, block, &overlap);
    r = choose(plan, i, &overlap);
    chosen_ns = now_ns(plan->config);
    if (r == 0)
        r = find_cuts(plan, block, &overlap);
    if (r == 0)
        r = paste(plan, block, &overlap);
    figures->search_ns += chosen_ns - start_ns;
    figures->cut_ns += now_ns(plan->config) - chosen_ns;
    return r;
}

static int place_all(struct plan *plan, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = plan->config;

    for (unsigned i = 0; i < plan->map.n_blocks; i++) {
        int r;

        if (config->cancel && *config->cancel)
            return ttf_err_set(err, -ECANCELED, NULL, "cancelled");
        r = place_block(plan, i);
        if (r < 0)
            return ttf_err_set(err, r, NULL, "no memory to place block %u of %u", i,
                               plan->map.n_blocks);
        if (config->progress)
            config->progress(config->progress_ctx, (i + 1.0) / plan->map.n_blocks);
    }
    return 0;
}

/* Loads the frames to match and makes the search ready. */
static int prepare(struct plan *plan, struct ttf_sequence *input, uint32_t first, uint32_t frames,
                   struct ttf_err *err)
{
    const struct ttf_quilt_config *config = plan->config;
    struct ttf_quilt_search_figures *figures = &plan->map.figures;
    const struct ttf_placement *placement = &plan->placement;
    uint32_t narrow =
        placement->overlap_x < placement->overlap_y ? placement->overlap_x : placement->overlap_y;
    int64_t start_ns = now_ns(config), loaded_ns;
    int r = ttf_trajectories_load(input, first, frames, config->metric, plan->pool, config->cancel,
                                  &plan->trajectories, err);

    if (r < 0)
        return r;
    loaded_ns = now_ns(config);
    figures->noise_variance = ttf_trajectories_noise(&plan->trajectories);
    figures->matching_bytes = ttf_quilt_matching_bytes(input->width, input->height, frames);
    r = ttf_search_create(&plan->trajectories, narrow, config->tolerance, figures->noise_variance,
                          NULL, plan->pool, &plan->search);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory to match %u frames of %u x %u", frames,
                           input->width, input->height);
    figures->load_ns = loaded_ns - start_ns;
    figures->prepare_ns = now_ns(config) - loaded_ns;
    return 0;
}

static int plan_range(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                      uint32_t first, uint32_t frames, uint64_t seed, struct ttf_pool *pool,
                      struct ttf_quilt_map *ret, struct ttf_err *err)
{
    struct plan plan = {.config = config, .pool = pool, .seed = seed};
    struct ttf_search_counts counts;
    int r = ttf_quilt_validate(config, input, err);

    if (r < 0)
        return r;
    ttf_placement_make(config, &plan.placement);
    plan.map.source_width = input->width;
    plan.map.source_height = input->height;
    r = plan_alloc(&plan, err);
    if (r == 0)
        r = prepare(&plan, input, first, frames, err);
    if (r == 0)
        r = place_all(&plan, err);
    if (r == 0) {
        ttf_search_counts(plan.search, &counts);
        plan.map.figures.positions = counts.positions;
        plan.map.figures.survived_cells = counts.survived_cells;
        plan.map.figures.survived_rank = counts.survived_rank;
        plan.map.figures.exact = counts.exact;
        plan.map.layers = plan.layers.list;
        plan.map.n_layers = plan.layers.n;
        plan.layers.list = NULL;
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
    return plan_range(&alone, input, t, 1, ttf_random64(config->seed, TTF_PURPOSE_FRAME, t), pool,
                      ret, err);
}
