/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/synth/agreement.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/paste.h"
#include "search/block_search.h"
#include "search/hash.h"
#include "search/matching.h"
#include "search/rank_search.h"
#include "search/sources.h"
#include "search/views.h"
#include "ttf/synth/cancel.h"

struct agreement {
    const struct ttf_quilt_config *config;
    const struct ttf_quilt_map *map;
    struct ttf_pool *pool;
    struct ttf_quilt_map own; /* put together anew, block by block */
    struct ttf_sources sources;
    struct ttf_matching matching;
    struct ttf_views views;
    struct ttf_rank_search rank;
    struct ttf_rank_workspace *room;
    struct ttf_trajectories trajectories;
    struct ttf_search *full;
    uint32_t *known;
    uint64_t last_asked; /* the largest hash of a query that is compared */
    unsigned costs;
    struct ttf_agreement sums;
};

static void finish(struct agreement *a)
{
    ttf_quilt_map_free(&a->own);
    ttf_views_free(&a->views);
    ttf_matching_free(&a->matching);
    ttf_rank_workspace_destroy(a->room);
    ttf_search_destroy(a->full);
    ttf_trajectories_free(&a->trajectories);
    free(a->known);
}

static uint64_t hash_of(const struct agreement *a, unsigned block)
{
    return ttf_random64(a->config->seed, TTF_PURPOSE_QUERY, block);
}

static int by_number(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;

    return (x > y) - (x < y);
}

/* Of all blocks but the first, which is no query, the `most` first by hash; 0: all. */
static int choose_queries(struct agreement *a, unsigned most)
{
    unsigned n = a->map->n_blocks - 1;
    uint64_t *hashes;

    a->last_asked = UINT64_MAX;
    if (most == 0 || most >= n)
        return 0;
    hashes = malloc(n * sizeof(*hashes));
    if (!hashes)
        return -ENOMEM;
    for (unsigned i = 0; i < n; i++)
        hashes[i] = hash_of(a, i + 1);
    qsort(hashes, n, sizeof(*hashes), by_number);
    a->last_asked = hashes[most - 1];
    free(hashes);
    return 0;
}

/* Pixels of the largest block, at least 1. */
static size_t largest_block(const struct ttf_quilt_map *map)
{
    size_t most = 1;

    for (unsigned i = 0; i < map->n_blocks; i++) {
        size_t own = (size_t)map->blocks[i].width * map->blocks[i].height;

        most = own > most ? own : most;
    }
    return most;
}

static int start(struct agreement *a, struct ttf_sequence *input, unsigned most,
                 struct ttf_err *err)
{
    const struct ttf_quilt_map *map = a->map;
    struct ttf_quilt_config plain = *a->config;
    uint32_t narrow = map->overlap_x < map->overlap_y ? map->overlap_x : map->overlap_y;
    int r;

    plain.keep_factors = NULL;
    plain.known = (struct ttf_quilt_factors){0};
    r = ttf_sources_of(&plain, input, &a->sources, err);
    if (r == 0)
        r = ttf_trajectories_load(input, 0, input->n, plain.metric, a->pool, plain.cancel,
                                  &a->trajectories, err);
    if (r == 0)
        r = ttf_matching_build(&plain, &a->sources, 0, input->n, NULL, a->pool, &a->matching, err);
    if (r < 0)
        return r;
    a->known = malloc(largest_block(map) * sizeof(*a->known));
    if (!a->known || choose_queries(a, most) < 0 || ttf_quilt_map_copy(map, &a->own) < 0 ||
        ttf_views_create(&a->sources, &a->matching, 1u, narrow, a->pool, &a->views) < 0 ||
        ttf_rank_workspace_create(&a->room) < 0 ||
        ttf_search_create(&a->trajectories, narrow, plain.tolerance, a->matching.noise, NULL,
                          a->pool, &a->full) < 0)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to compare searches");
    a->rank =
        (struct ttf_rank_search){&a->matching, &a->views, ttf_rank_kernels_best(), plain.tolerance};
    return 0;
}

/* Full-time error of a position. */
static uint64_t full_error(const struct agreement *a, const struct ttf_quilt_block *b, uint32_t x0,
                           uint32_t y0)
{
    const struct ttf_trajectories *t = &a->trajectories;
    uint64_t sum = 0;

    for (uint32_t y = 0; y < b->height; y++) {
        for (uint32_t x = 0; x < b->width; x++) {
            uint32_t known = a->known[(size_t)y * b->width + x];
            size_t own = (size_t)(y0 + y) * t->width + x0 + x;

            if (known != TTF_UNKNOWN_ID)
                sum += ttf_kernels_best()->ssd_u8(ttf_trajectory(t, known), ttf_trajectory(t, own),
                                                  t->dims);
        }
    }
    return sum;
}

/* |both| / |either|: both lists are in the order of positions. */
static double overlap_of(const struct ttf_rank_result *rank, const struct ttf_candidates *full)
{
    uint32_t both = 0, i = 0, k = 0;

    while (i < rank->n && k < full->n) {
        uint32_t own = rank->list[i].position.y * full->columns + rank->list[i].position.x;

        both += own == full->positions[k];
        i += own <= full->positions[k];
        k += own > full->positions[k];
    }
    return (double)both / (double)(rank->n + full->n - both);
}

/* Does the full search's best position only go on where a neighbour was taken from? */
static bool goes_on(const struct ttf_candidates *full)
{
    return full->best == 0;
}

static int one_query(struct agreement *a, const struct ttf_quilt_block *b)
{
    const struct ttf_rank_query query = {
        .width = b->width, .height = b->height, .known = a->known, .rerank = true};
    const struct ttf_overlap overlap = {b->width, b->height, b->left, b->top, a->known, b->width};
    struct ttf_rank_result rank = {0};
    struct ttf_candidates full = {0};
    uint64_t chosen;
    double cost = 0.0;
    int r = ttf_rank_search_run(&a->rank, a->room, &query, &rank);

    if (r == 0)
        r = ttf_search_run(a->full, &overlap, &full);
    if (r < 0)
        return r;
    chosen = full_error(a, b, rank.list[rank.likeliest].position.x,
                        rank.list[rank.likeliest].position.y);
    a->sums.queries++;
    a->sums.best += chosen == full.best;
    a->sums.jaccard += overlap_of(&rank, &full);
    if (full.best > 0) {
        cost = (double)chosen / (double)full.best - 1.0;
        a->costs++;
        a->sums.extra_cost += cost;
    }
    if (!goes_on(&full)) {
        a->sums.jumps++;
        a->sums.jump_best += chosen == full.best;
        a->sums.jump_extra_cost += cost;
    }
    return 0;
}

/* Left and upper neighbour from anywhere: overlaps that no search has made alike. */
static void random_known(const struct agreement *a, const struct ttf_quilt_block *b, unsigned i)
{
    const struct ttf_trajectories *t = &a->trajectories;
    uint64_t random = ttf_random64(a->config->seed, TTF_PURPOSE_QUERY, 1000000u + i);
    uint32_t columns = t->width - b->width + 1, positions = columns * (t->height - b->height + 1);
    uint32_t left = ttf_pick(random, positions), top = ttf_pick(ttf_mix64(random), positions);

    for (uint32_t y = 0; y < b->height; y++) {
        for (uint32_t x = 0; x < b->width; x++) {
            uint32_t from = y < b->top ? top : left;

            if (x < b->left || y < b->top)
                a->known[(size_t)y * b->width + x] =
                    (from / columns + y) * t->width + from % columns + x;
        }
    }
}

static void gather_known(const struct agreement *a, const struct ttf_quilt_block *b)
{
    uint32_t *known = a->known;

    for (uint32_t y = 0; y < b->height; y++) {
        for (uint32_t x = 0; x < b->width; x++)
            *known++ = x < b->left || y < b->top ? a->own.source[ttf_block_pixel(&a->own, b, x, y)]
                                                 : TTF_UNKNOWN_ID;
    }
}

static int check(const struct ttf_quilt_config *config, const struct ttf_quilt_map *map,
                 const struct ttf_sequence *input, struct ttf_err *err)
{
    bool turned = false;

    if (config->rank == TTF_QUILT_RANK_FULL && !(config->rank_error > 0.0))
        return ttf_err_set(err, -EINVAL, "agreement",
                           "without a rank there is only the search over all frames");
    if (map->inputs[0].width != input->width || map->inputs[0].height != input->height)
        return ttf_err_set(err, -EINVAL, "agreement", "the map is of an input of %u x %u pixels",
                           map->inputs[0].width, map->inputs[0].height);
    for (unsigned i = 0; i < map->n_blocks; i++)
        turned = turned || map->blocks[i].turn != 0;
    if (map->n_inputs > 1 || turned || map->tileable) {
        ttf_err_set(err, -EINVAL, "agreement",
                    "the search over all frames takes one input, unturned, and no tileable output");
        return ttf_err_hint(err, "do without the comparison"), -EINVAL;
    }
    return 0;
}

static void average(struct ttf_agreement *sums, unsigned costs)
{
    if (sums->queries > 0) {
        sums->best /= sums->queries;
        sums->jaccard /= sums->queries;
    }
    if (costs > 0)
        sums->extra_cost /= costs;
    if (sums->jumps > 0) {
        sums->jump_best /= sums->jumps;
        sums->jump_extra_cost /= sums->jumps;
    }
}

static int compare_searches(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                            const struct ttf_quilt_map *map, unsigned most, bool anywhere,
                            struct ttf_pool *pool, struct ttf_agreement *ret, struct ttf_err *err)
{
    struct agreement a = {.config = config, .map = map, .pool = pool};
    int r = check(config, map, input, err);

    if (r < 0)
        return r;
    r = start(&a, input, most, err);
    for (unsigned i = 0; i < map->n_blocks && r == 0; i++) {
        if (ttf_cancelled(config->cancel))
            r = ttf_err_set(err, -ECANCELED, NULL, "cancelled");
        else if (i > 0 && hash_of(&a, i) <= a.last_asked &&
                 (map->blocks[i].left > 0 || map->blocks[i].top > 0)) {
            gather_known(&a, &map->blocks[i]);
            if (anywhere)
                random_known(&a, &map->blocks[i], i);
            r = one_query(&a, &map->blocks[i]);
            if (r < 0)
                ttf_err_set(err, r, NULL, "no memory to compare searches");
        }
        if (r == 0)
            r = ttf_paste_block(&a.own, i, NULL);
    }
    finish(&a);
    if (r < 0)
        return r;
    average(&a.sums, a.costs);
    *ret = a.sums;
    return 0;
}

int ttf_quilt_agreement(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                        const struct ttf_quilt_map *map, unsigned most, struct ttf_pool *pool,
                        struct ttf_agreement *ret, struct ttf_err *err)
{
    return compare_searches(config, input, map, most, false, pool, ret, err);
}

int ttf_quilt_agreement_anywhere(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                                 const struct ttf_quilt_map *map, unsigned most,
                                 struct ttf_pool *pool, struct ttf_agreement *ret,
                                 struct ttf_err *err)
{
    return compare_searches(config, input, map, most, true, pool, ret, err);
}
