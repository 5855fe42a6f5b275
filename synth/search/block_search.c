/* SPDX-License-Identifier: Apache-2.0 */
#include "search/block_search.h"

#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "search/features.h"
#include "search/ground.h"
#include "search/template.h"

/* How many of the most promising positions are compared in full to get a first limit. */
#define SEEDS 16

/* Survivors of one tile. */
#define TILE 64

#define EXCLUDED UINT64_MAX

struct ttf_search {
    const struct ttf_trajectories *trajectories;
    struct ttf_features features;
    const struct ttf_kernels *kernels;
    struct ttf_pool *pool;
    double tolerance, noise;
    struct ttf_template template;
    struct ttf_ground ground;
    /* one entry per position of the widest search so far */
    size_t room;
    float *bounds;       /* by position, then by survivor */
    uint32_t *survivors; /* positions, ascending */
    uint64_t *errors;    /* by survivor */
    /* of the running search */
    uint32_t columns, rows;
    struct ttf_overlap overlap;
    bool on_ground; /* `ground` is of this template, and worth using */
    uint32_t n;     /* survivors */
    double limit;
    struct ttf_search_counts counts;
};

double ttf_search_limit(double tolerance, double noise, uint64_t overlap_pixels, uint32_t frames,
                        uint64_t best)
{
    /* Two samples of the same thing differ by twice the noise variance (quilt/README.md). */
    double floor = 2.0 * noise * (double)overlap_pixels * 3.0 * frames;
    double e = (double)best > floor ? (double)best : floor;

    return (1.0 + tolerance) * e;
}

int ttf_search_create(const struct ttf_trajectories *trajectories, uint32_t min_overlap,
                      double tolerance, double noise, const struct ttf_kernels *kernels,
                      struct ttf_pool *pool, struct ttf_search **ret)
{
    struct ttf_search *search = calloc(1, sizeof(*search));
    uint32_t cell = min_overlap >= 4 ? 4 : min_overlap >= 2 ? 2 : 1;
    int r;

    if (!search)
        return -ENOMEM;
    search->trajectories = trajectories;
    search->kernels = kernels ? kernels : ttf_kernels_best();
    search->pool = pool;
    search->tolerance = tolerance;
    search->noise = noise;
    r = ttf_features_build(trajectories, cell, pool, &search->features);
    if (r < 0) {
        free(search);
        return r;
    }
    *ret = search;
    return 0;
}

void ttf_search_destroy(struct ttf_search *search)
{
    if (!search)
        return;
    ttf_features_free(&search->features);
    ttf_template_free(&search->template);
    ttf_ground_free(&search->ground);
    free(search->bounds);
    free(search->survivors);
    free(search->errors);
    free(search);
}

void ttf_search_counts(const struct ttf_search *search, struct ttf_search_counts *ret)
{
    *ret = search->counts;
}

static int make_room(struct ttf_search *search, size_t positions)
{
    if (positions <= search->room)
        return 0;
    free(search->bounds);
    free(search->survivors);
    free(search->errors);
    search->room = 0;
    search->bounds = malloc(positions * sizeof(*search->bounds));
    search->survivors = malloc(positions * sizeof(*search->survivors));
    search->errors = malloc(positions * sizeof(*search->errors));
    if (!search->bounds || !search->survivors || !search->errors)
        return -ENOMEM;
    search->room = positions;
    return 0;
}

/*
 * What a bound in floats may at most read where the true error is within
 * `limit`: each of `numbers` differences may be off by twice the features'
 * slack (so the whole, as a length, by 2 slack sqrt(numbers)), and adding `adds`
 * terms loses at most a unit in the last place each.
 */
static float bound_limit(const struct ttf_search *search, size_t numbers, size_t adds)
{
    double length = sqrt(search->limit) + 2.0 * search->features.slack * sqrt((double)numbers);
    double limit = length * length * (1.0 + ((double)adds + 64.0) * (double)FLT_EPSILON);

    return limit < (double)FLT_MAX ? (float)limit * (1.0f + FLT_EPSILON) : FLT_MAX;
}

/* First bound, one row of positions: sums over cells. */
static void bound_cells_row(void *ctx, unsigned y, unsigned worker)
{
    struct ttf_search *search = ctx;
    const struct ttf_template *template = &search->template;
    const struct ttf_features *features = &search->features;
    float *acc = search->bounds + (size_t)y * search->columns;

    (void)worker;
    memset(acc, 0, search->columns * sizeof(*acc));
    for (size_t i = 0; i < template->n_cells; i++) {
        const struct ttf_template_cell *cell = &template->cells[i];
        const float *planes[TTF_CELL_PLANES];
        size_t at = (size_t)(y + cell->dy) * features->width + cell->dx;

        for (unsigned d = 0; d < TTF_CELL_PLANES; d++)
            planes[d] = features->cells[d] + at;
        search->kernels->add_cells(acc, planes, cell->target, search->columns);
    }
}

/* Second bound, of the survivors of the first. */
static void bound_rank_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct ttf_search *search = ctx;
    const struct ttf_template *template = &search->template;
    uint32_t end = (tile + 1) * TILE < search->n ? (tile + 1) * TILE : search->n;

    (void)worker;
    for (uint32_t i = tile * TILE; i < end; i++) {
        uint32_t position = search->survivors[i];
        size_t corner = (size_t)(position / search->columns) * search->features.width +
                        position % search->columns;
        double sum = 0.0;

        for (size_t k = 0; k < template->n_runs; k++) {
            const struct ttf_template_run *run = &template->runs[k];
            size_t source = corner + (size_t)run->dy * search->features.width + run->dx;

            sum += (double)search->kernels->ssd_f32(
                search->features.pixels + source * TTF_PIXEL_COEFS,
                template->coefs + run->first * TTF_PIXEL_COEFS, run->length * TTF_PIXEL_COEFS);
        }
        search->bounds[i] = sum < (double)FLT_MAX ? (float)sum : FLT_MAX;
    }
}

/* The share of eq. 3 of the pixels that are of the ground: all rectangles less the others' places. */
static uint64_t ground_error(const struct ttf_search *search, size_t x, size_t y)
{
    const struct ttf_template *template = &search->template;
    const struct ttf_overlap *o = &search->overlap;
    uint64_t sum = ttf_ground_sum(&search->ground, x, y, o->width, o->top) +
                   ttf_ground_sum(&search->ground, x, y + o->top, o->left, o->height - o->top);

    for (size_t k = 0; k < template->n_others; k++) {
        const struct ttf_template_run *run = &template->others[k];

        sum -= ttf_ground_sum(&search->ground, x + run->dx, y + run->dy, run->length, 1);
    }
    return sum;
}

/* Eq. 3 in full, given up as soon as it passes the limit. */
static uint64_t exact_error(const struct ttf_search *search, uint32_t position)
{
    const struct ttf_template *template = &search->template;
    const struct ttf_trajectories *trajectories = search->trajectories;
    size_t corner =
        (size_t)(position / search->columns) * trajectories->width + position % search->columns;
    const struct ttf_template_run *runs = search->on_ground ? template->others : template->runs;
    size_t n_runs = search->on_ground ? template->n_others : template->n_runs;
    uint64_t sum = 0;

    if (search->on_ground)
        sum = ground_error(search, position % search->columns, position / search->columns);
    for (size_t k = 0; k < n_runs; k++) {
        const struct ttf_template_run *run = &runs[k];
        size_t source = corner + (size_t)run->dy * trajectories->width + run->dx;

        sum += search->kernels->ssd_u8(ttf_trajectory(trajectories, source),
                                       template->codes + run->first * trajectories->dims,
                                       run->length * trajectories->dims);
        if ((double)sum > search->limit)
            return EXCLUDED;
    }
    if ((double)sum > search->limit)
        return EXCLUDED;
    return sum;
}

static void exact_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct ttf_search *search = ctx;
    uint32_t end = (tile + 1) * TILE < search->n ? (tile + 1) * TILE : search->n;

    (void)worker;
    for (uint32_t i = tile * TILE; i < end; i++)
        search->errors[i] = exact_error(search, search->survivors[i]);
}

/* Positions (or survivors) with the smallest bounds, in no promised order; returns how many. */
static unsigned most_promising(const float *bounds, size_t n, uint32_t ret[SEEDS])
{
    float value[SEEDS];
    unsigned used = 0;

    for (size_t i = 0; i < n; i++) {
        unsigned at;

        if (used == SEEDS && !(bounds[i] < value[SEEDS - 1]))
            continue;
        at = used < SEEDS ? used++ : SEEDS - 1;
        for (; at > 0 && bounds[i] < value[at - 1]; at--) {
            value[at] = value[at - 1];
            ret[at] = ret[at - 1];
        }
        value[at] = bounds[i];
        ret[at] = (uint32_t)i;
    }
    return used;
}

/* Tightens the limit by the smallest full error among n positions. */
static void tighten(struct ttf_search *search, const uint32_t *positions, unsigned n,
                    uint64_t *best)
{
    for (unsigned i = 0; i < n; i++) {
        uint64_t error = exact_error(search, positions[i]);

        if (error < *best)
            *best = error;
    }
    search->counts.exact += n;
    if (*best != EXCLUDED)
        search->limit =
            ttf_search_limit(search->tolerance, search->noise, search->template.n_pixels,
                             search->trajectories->frames, *best);
}

/* Keeps the positions whose first bound does not exclude them. */
static void keep_positions(struct ttf_search *search, size_t positions, float limit)
{
    search->n = 0;
    for (size_t i = 0; i < positions; i++) {
        if (search->bounds[i] <= limit)
            search->survivors[search->n++] = (uint32_t)i;
    }
}

static void second_round(struct ttf_search *search, uint64_t *best)
{
    size_t numbers = search->template.n_pixels * TTF_PIXEL_COEFS;
    uint32_t seeds[SEEDS];
    uint32_t kept = 0;
    unsigned n;
    float limit;

    ttf_pool_run(search->pool, (search->n + TILE - 1) / TILE, bound_rank_tile, search);
    n = most_promising(search->bounds, search->n, seeds);
    for (unsigned i = 0; i < n; i++)
        seeds[i] = search->survivors[seeds[i]];
    tighten(search, seeds, n, best);
    limit = bound_limit(search, numbers, search->template.longest_run);
    for (uint32_t i = 0; i < search->n; i++) {
        if (search->bounds[i] <= limit)
            search->survivors[kept++] = search->survivors[i];
    }
    search->n = kept;
}

/* Sums over the ground cost a pass over the input: worth it for many survivors. Without memory for them, do without. */
static void look_for_ground(struct ttf_search *search)
{
    const struct ttf_template *template = &search->template;
    const struct ttf_trajectories *trajectories = search->trajectories;
    size_t pixels = (size_t)trajectories->width * trajectories->height;

    if (2 * template->n_ground < template->n_pixels || search->n < pixels / 16)
        return;
    search->on_ground = ttf_ground_prepare(&search->ground, trajectories,
                                           template->codes + template->ground * trajectories->dims,
                                           search->kernels, search->pool) == 0;
}

static void collect(struct ttf_search *search, struct ttf_candidates *ret)
{
    uint64_t best = EXCLUDED;
    uint32_t kept = 0;
    double limit;

    for (uint32_t i = 0; i < search->n; i++)
        best = search->errors[i] < best ? search->errors[i] : best;
    limit = ttf_search_limit(search->tolerance, search->noise, search->template.n_pixels,
                             search->trajectories->frames, best);
    for (uint32_t i = 0; i < search->n; i++) {
        if (search->errors[i] == EXCLUDED || (double)search->errors[i] > limit)
            continue;
        search->survivors[kept] = search->survivors[i];
        search->errors[kept++] = search->errors[i];
    }
    *ret = (struct ttf_candidates){.n = kept,
                                   .positions = search->survivors,
                                   .errors = search->errors,
                                   .columns = search->columns,
                                   .best = best};
}

int ttf_search_run(struct ttf_search *search, const struct ttf_overlap *overlap,
                   struct ttf_candidates *ret)
{
    uint32_t seeds[SEEDS];
    uint64_t best = EXCLUDED;
    size_t positions;
    unsigned n;
    int r;

    search->columns = search->features.width - overlap->width + 1;
    search->rows = search->features.height - overlap->height + 1;
    positions = (size_t)search->columns * search->rows;
    r = make_room(search, positions);
    if (r == 0)
        r = ttf_template_gather(&search->template, search->trajectories, &search->features,
                                overlap);
    if (r < 0)
        return r;
    search->overlap = *overlap;
    search->on_ground = false;
    search->limit = (double)EXCLUDED;
    ttf_pool_run(search->pool, search->rows, bound_cells_row, search);
    n = most_promising(search->bounds, positions, seeds);
    tighten(search, seeds, n, &best);
    keep_positions(search, positions,
                   bound_limit(search, search->template.n_cells * TTF_CELL_PLANES,
                               search->template.n_cells * TTF_CELL_PLANES));
    search->counts.positions += positions;
    search->counts.survived_cells += search->n;
    if (search->features.pixels)
        second_round(search, &best);
    search->counts.survived_rank += search->n;
    search->counts.exact += search->n;
    look_for_ground(search);
    ttf_pool_run(search->pool, (search->n + TILE - 1) / TILE, exact_tile, search);
    collect(search, ret);
    return 0;
}
