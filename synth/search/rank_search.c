/* SPDX-License-Identifier: Apache-2.0 */
#include "search/rank_search.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "search/rank_ground.h"
#include "search/rank_template.h"

/* How many of the most promising positions are compared in full to get a first limit. */
#define SEEDS 16

#define EXCLUDED UINT32_MAX

/* Positions whose fine cells are looked at together. */
#define GROUP 16u

/* Fine cells pay for themselves where coarse ones let more than this share of positions pass. */
#define FINE_SHARE 64u

/* A plain ground is looked for where more than this share pass. */
#define GROUND_SHARE 16u

struct ttf_rank_workspace {
    struct ttf_rank_template template;
    struct ttf_rank_ground ground;
    bool on_ground; /* `ground` is of this query, and worth using */
    struct ttf_cell_target targets[TTF_CELLS_MAX];
    size_t room_positions, room_found, room_runs;
    struct ttf_run_place *runs; /* of each view, one after another */
    uint32_t *bounds;           /* of all views' positions */
    struct ttf_rank_candidate *found;
    uint32_t n_found;
    struct ttf_rank_counts counts;
    /* of the running query */
    const struct ttf_rank_search *search;
    const struct ttf_rank_query *query;
    uint64_t best;
    double limit;
};

int ttf_rank_workspace_create(struct ttf_rank_workspace **ret)
{
    *ret = calloc(1, sizeof(**ret));
    return *ret ? 0 : -ENOMEM;
}

void ttf_rank_workspace_destroy(struct ttf_rank_workspace *workspace)
{
    if (!workspace)
        return;
    ttf_rank_template_free(&workspace->template);
    ttf_rank_ground_free(&workspace->ground);
    free(workspace->bounds);
    free(workspace->found);
    free(workspace->runs);
    free(workspace);
}

struct ttf_rank_counts ttf_rank_workspace_counts(const struct ttf_rank_workspace *workspace)
{
    return workspace->counts;
}

double ttf_rank_limit(const struct ttf_rank_search *search, uint64_t overlap_pixels, uint64_t best)
{
    const struct ttf_matching *m = search->matching;
    double floor = 2.0 * m->noise * (double)overlap_pixels * m->k * m->scale * m->scale;
    double e = (double)best > floor ? (double)best : floor;

    return (1.0 + search->tolerance) * e;
}

/* Positions in a row and column of a view; 0 x 0 where the block does not fit. */
static void grid_of(const struct ttf_view *view, const struct ttf_rank_query *query,
                    uint32_t *ret_columns, uint32_t *ret_rows)
{
    bool fits = query->width <= view->width && query->height <= view->height;

    *ret_columns = fits ? view->width - query->width + 1 : 0;
    *ret_rows = fits ? view->height - query->height + 1 : 0;
}

static int make_room(struct ttf_rank_workspace *w, size_t positions)
{
    if (positions <= w->room_positions)
        return 0;
    free(w->bounds);
    w->room_positions = 0;
    w->bounds = malloc(positions * sizeof(*w->bounds));
    if (!w->bounds)
        return -ENOMEM;
    w->room_positions = positions;
    return 0;
}

/* E of one position in full; beyond the limit, any number beyond it. */
static uint64_t error_at(const struct ttf_rank_workspace *w, const struct ttf_rank_position *at)
{
    const struct ttf_view *view = &w->search->views->list[at->view];
    size_t corner = (size_t)at->y * view->width + at->x;
    uint64_t limit = w->limit < (double)UINT64_MAX ? (uint64_t)w->limit : UINT64_MAX;

    if (w->on_ground)
        return ttf_rank_ground_error(&w->ground, w->search, at, limit);
    return w->search->kernels->ssd_runs(view->coefs + corner * w->search->matching->stride,
                                        w->runs + (size_t)at->view * w->template.n_runs,
                                        w->template.n_runs, w->template.coefs, limit);
}

/* Where the template's runs lie in each view, from a position's corner on. */
static int place_runs(struct ttf_rank_workspace *w)
{
    const struct ttf_views *views = w->search->views;
    size_t n = w->template.n_runs, stride = w->search->matching->stride;

    if (n * views->n > w->room_runs) {
        free(w->runs);
        w->room_runs = 0;
        w->runs = malloc(n * views->n * sizeof(*w->runs));
        if (!w->runs)
            return -ENOMEM;
        w->room_runs = n * views->n;
    }
    for (unsigned v = 0; v < views->n; v++) {
        for (size_t i = 0; i < n; i++) {
            const struct ttf_rank_run *run = &w->template.runs[i];

            w->runs[v * n + i] = (struct ttf_run_place){
                ((size_t)run->dy * views->list[v].width + run->dx) * stride, run->length * stride};
        }
    }
    return 0;
}

static void look_at(struct ttf_rank_workspace *w, const struct ttf_rank_position *at)
{
    uint64_t error = error_at(w, at);

    w->counts.exact++;
    if (error < w->best) {
        w->best = error;
        w->limit = ttf_rank_limit(w->search, w->template.n_pixels, error);
    }
}

static bool is_excluded(const struct ttf_rank_query *query, const struct ttf_rank_position *at)
{
    for (unsigned i = 0; i < query->n_excluded; i++) {
        const struct ttf_position_rect *rect = &query->excluded[i];

        if (rect->view == at->view && at->x >= rect->x0 && at->x < rect->x1 && at->y >= rect->y0 &&
            at->y < rect->y1)
            return true;
    }
    return false;
}

static void look_at_hints(struct ttf_rank_workspace *w)
{
    for (unsigned i = 0; i < w->query->n_hints; i++) {
        const struct ttf_rank_position *at = &w->query->hints[i];
        uint32_t columns, rows;

        grid_of(&w->search->views->list[at->view], w->query, &columns, &rows);
        if (at->x < columns && at->y < rows && !is_excluded(w->query, at))
            look_at(w, at);
    }
}

/*
 * What the cells' sum may at most be where E is within the limit: each stored number is rounded by
 * at most a half, so that a difference may be off by one (and a little for what floats lose).
 * Beyond what sums are clipped to, nothing is excluded.
 */
static uint32_t cell_limit(const struct ttf_rank_workspace *w, unsigned level)
{
    double length = sqrt(w->limit) * w->search->views->levels[level].scale * (1.0 + 1e-5) +
                    1.01 * sqrt((double)w->template.n_cells[level] * TTF_CELL_DIMS);
    double limit = length * length + 1.0;

    return limit < (double)TTF_BOUND_MAX ? (uint32_t)limit : EXCLUDED - 1;
}

static void exclude(const struct ttf_rank_workspace *w, unsigned view, uint32_t columns,
                    uint32_t rows, uint32_t *bounds)
{
    for (unsigned i = 0; i < w->query->n_excluded; i++) {
        const struct ttf_position_rect *rect = &w->query->excluded[i];
        uint32_t x1 = rect->x1 < columns ? rect->x1 : columns;

        if (rect->view != view || rect->x0 >= x1)
            continue;
        for (uint32_t y = rect->y0; y < rect->y1 && y < rows; y++) {
            for (uint32_t x = rect->x0; x < x1; x++)
                bounds[(size_t)y * columns + x] = EXCLUDED;
        }
    }
}

static void aim_at_view(struct ttf_rank_workspace *w, const struct ttf_view *view, unsigned level)
{
    const struct ttf_rank_template *template = &w->template;

    for (size_t i = 0; i < template->n_cells[level]; i++) {
        w->targets[i] = template->cells[level][i].target;
        w->targets[i].offset =
            template->cells[level][i].dy * view->width + template->cells[level][i].dx;
    }
}

static void bound_view(struct ttf_rank_workspace *w, unsigned index, uint32_t limit,
                       uint32_t *bounds)
{
    const struct ttf_view *view = &w->search->views->list[index];
    uint32_t columns, rows;

    grid_of(view, w->query, &columns, &rows);
    aim_at_view(w, view, 0);
    for (uint32_t y = 0; y < rows; y++)
        w->search->kernels->bound_cells(view->cells[0] + (size_t)y * view->width * TTF_CELL_DIMS,
                                        w->targets, w->template.n_cells[0], columns, limit,
                                        bounds + (size_t)y * columns);
    exclude(w, index, columns, rows, bounds);
}

/* One group of neighbouring positions; those that are out already stay so. */
static void refine_group(const struct ttf_rank_workspace *w, const int16_t *cells, uint32_t n,
                         uint32_t coarse_limit, uint32_t limit, uint32_t *bounds)
{
    uint32_t fine[GROUP];
    bool any = false;

    for (uint32_t i = 0; i < n; i++)
        any = any || bounds[i] <= coarse_limit;
    if (any)
        w->search->kernels->bound_cells(cells, w->targets, w->template.n_cells[1], n, limit, fine);
    for (uint32_t i = 0; i < n; i++)
        bounds[i] = any && bounds[i] <= coarse_limit ? fine[i] : EXCLUDED;
}

/* Bounds by fine cells in place of those by coarse ones. */
static void refine_view(struct ttf_rank_workspace *w, unsigned index, uint32_t coarse_limit,
                        uint32_t limit, uint32_t *bounds)
{
    const struct ttf_view *view = &w->search->views->list[index];
    uint32_t columns, rows;

    grid_of(view, w->query, &columns, &rows);
    aim_at_view(w, view, 1);
    for (uint32_t y = 0; y < rows; y++) {
        const int16_t *row = view->cells[1] + (size_t)y * view->width * TTF_CELL_DIMS;

        for (uint32_t x = 0; x < columns; x += GROUP)
            refine_group(w, row + (size_t)x * TTF_CELL_DIMS,
                         columns - x < GROUP ? columns - x : GROUP, coarse_limit, limit,
                         bounds + (size_t)y * columns + x);
    }
}

/* Indices of the smallest bounds within the limit, in no promised order; returns how many. */
static unsigned most_promising(const uint32_t *bounds, size_t n, uint32_t limit, size_t ret[SEEDS])
{
    uint32_t value[SEEDS];
    unsigned used = 0;

    for (size_t i = 0; i < n; i++) {
        unsigned at;

        if (bounds[i] > limit)
            continue;
        at = used < SEEDS ? used++ : SEEDS - 1;
        for (; at > 0 && bounds[i] < value[at - 1]; at--) {
            value[at] = value[at - 1];
            ret[at] = ret[at - 1];
        }
        value[at] = bounds[i];
        ret[at] = i;
        if (used == SEEDS)
            limit = value[SEEDS - 1] > 0 ? value[SEEDS - 1] - 1 : 0;
    }
    return used;
}

static struct ttf_rank_position position_of(const struct ttf_rank_workspace *w, size_t index)
{
    for (unsigned i = 0; i < w->search->views->n; i++) {
        uint32_t columns, rows;

        grid_of(&w->search->views->list[i], w->query, &columns, &rows);
        if (index < (size_t)columns * rows)
            return (struct ttf_rank_position){i, (uint32_t)(index % columns),
                                              (uint32_t)(index / columns)};
        index -= (size_t)columns * rows;
    }
    return (struct ttf_rank_position){0, 0, 0};
}

static int add_found(struct ttf_rank_workspace *w, const struct ttf_rank_position *at,
                     uint64_t error)
{
    if (w->n_found == w->room_found) {
        size_t room = w->room_found ? 2 * w->room_found : 1024;
        struct ttf_rank_candidate *found = realloc(w->found, room * sizeof(*found));

        if (!found)
            return -ENOMEM;
        w->found = found;
        w->room_found = room;
    }
    w->found[w->n_found++] = (struct ttf_rank_candidate){*at, error};
    return 0;
}

/* What the cells that a bound is of have of E at least. */
static double least_of_cells(const struct ttf_rank_workspace *w, unsigned level, uint32_t bound)
{
    double length =
        (sqrt((double)bound) - 1.01 * sqrt((double)w->template.n_cells[level] * TTF_CELL_DIMS)) /
        (w->search->views->levels[level].scale * (1.0 + 1e-5));

    return length > 0.0 ? length * length : 0.0;
}

/* Do the pixels that no fine cell holds exclude a position, together with what the cells have at least? */
static bool rest_excludes(const struct ttf_rank_workspace *w, const struct ttf_rank_position *at,
                          uint32_t bound)
{
    const struct ttf_view *view = &w->search->views->list[at->view];
    size_t corner = (size_t)at->y * view->width + at->x;
    double left = w->limit - least_of_cells(w, 1, bound);
    uint64_t rest;

    if (w->template.n_rest == 0 || !(left < w->limit))
        return false;
    if (left < 0.0)
        return true;
    rest = w->search->kernels->ssd_runs(view->coefs + corner * w->search->matching->stride,
                                        w->runs + (size_t)at->view * w->template.n_runs,
                                        w->template.n_rest, w->template.coefs,
                                        left < (double)UINT64_MAX ? (uint64_t)left : UINT64_MAX);
    return (double)rest > left;
}

/* Sums over a plain ground cost a pass over the views: worth it for many survivors. */
static int look_for_ground(struct ttf_rank_workspace *w, size_t positions, size_t within)
{
    int r = within > positions / GROUND_SHARE
                ? ttf_rank_ground_prepare(&w->ground, w->search, &w->template)
                : 0;

    w->on_ground = r > 0;
    return r < 0 ? r : 0;
}

/* All positions that the bounds of `level` let pass, compared in full. The limit only tightens on the way. */
static int compare_survivors(struct ttf_rank_workspace *w, unsigned level)
{
    const uint32_t *bounds = w->bounds;
    uint32_t limit = cell_limit(w, level);

    w->n_found = 0;
    for (unsigned i = 0; i < w->search->views->n; i++) {
        uint32_t columns, rows;

        grid_of(&w->search->views->list[i], w->query, &columns, &rows);
        for (size_t at = 0; at < (size_t)columns * rows; at++) {
            struct ttf_rank_position position;
            uint64_t error;

            if (bounds[at] > limit)
                continue;
            position =
                (struct ttf_rank_position){i, (uint32_t)(at % columns), (uint32_t)(at / columns)};
            if (level == 1 && rest_excludes(w, &position, bounds[at]))
                continue;
            w->counts.exact++;
            error = error_at(w, &position);
            if ((double)error > w->limit)
                continue;
            if (add_found(w, &position, error) < 0)
                return -ENOMEM;
            if (error < w->best) {
                w->best = error;
                w->limit = ttf_rank_limit(w->search, w->template.n_pixels, error);
                limit = cell_limit(w, level);
            }
        }
        bounds += (size_t)columns * rows;
    }
    return 0;
}

/*
 * What the full-time error is likely to be, but for what all positions share: where pixels differ,
 * what rank k misses of them has nothing to do with each other, so it adds up. In quantised units.
 */
static double likely_error(const struct ttf_rank_workspace *w, const struct ttf_rank_candidate *c)
{
    const struct ttf_matching *m = w->search->matching;
    const struct ttf_view *view = &w->search->views->list[c->position.view];
    const struct ttf_rank_query *query = w->query;
    double missed = 0.0;

    for (uint32_t y = 0; y < query->height; y++) {
        for (uint32_t x = 0; x < query->width; x++) {
            uint32_t known = query->known[(size_t)y * query->width + x];
            uint32_t own = ttf_view_id(view, c->position.x + x, c->position.y + y);

            if (known != TTF_UNKNOWN_ID && known != own)
                missed += (double)m->missed[known] + (double)m->missed[own];
        }
    }
    return (double)c->error + missed * m->scale * m->scale;
}

static void collect(struct ttf_rank_workspace *w, struct ttf_rank_result *ret)
{
    uint32_t kept = 0, likeliest = 0;
    double least = 0.0;

    for (uint32_t i = 0; i < w->n_found; i++) {
        if ((double)w->found[i].error > w->limit)
            continue;
        w->found[kept++] = w->found[i];
    }
    for (uint32_t i = 0; w->query->rerank && i < kept; i++) {
        double likely = likely_error(w, &w->found[i]);

        if (i == 0 || likely < least) {
            least = likely;
            likeliest = i;
        }
    }
    *ret = (struct ttf_rank_result){.n = kept,
                                    .list = w->found,
                                    .best = w->best,
                                    .likeliest = likeliest,
                                    .overlap_pixels = w->template.n_pixels};
}

/* Compares the most promising positions, so that the limit is near its last value. */
static void look_at_seeds(struct ttf_rank_workspace *w, size_t positions, unsigned level)
{
    size_t seeds[SEEDS];
    unsigned n = most_promising(w->bounds, positions, cell_limit(w, level), seeds);

    for (unsigned i = 0; i < n; i++) {
        struct ttf_rank_position at = position_of(w, seeds[i]);

        look_at(w, &at);
    }
}

static size_t count_within(const uint32_t *bounds, size_t n, uint32_t limit)
{
    size_t within = 0;

    for (size_t i = 0; i < n; i++)
        within += bounds[i] <= limit;
    return within;
}

/* Bounds of all views: by coarse cells (level 0), or by fine ones where those let a position pass. */
static void bound_all(struct ttf_rank_workspace *w, unsigned level)
{
    uint32_t coarse_limit = cell_limit(w, 0), limit = cell_limit(w, level);
    uint32_t *bounds = w->bounds;

    for (unsigned i = 0; i < w->search->views->n; i++) {
        uint32_t columns, rows;

        grid_of(&w->search->views->list[i], w->query, &columns, &rows);
        if (level == 0)
            bound_view(w, i, limit, bounds);
        else
            refine_view(w, i, coarse_limit, limit, bounds);
        bounds += (size_t)columns * rows;
    }
}

static int run(struct ttf_rank_workspace *w, size_t positions)
{
    size_t within;

    w->best = UINT64_MAX;
    w->limit = (double)UINT64_MAX;
    w->on_ground = false;
    look_at_hints(w);
    bound_all(w, 0);
    look_at_seeds(w, positions, 0);
    within = count_within(w->bounds, positions, cell_limit(w, 0));
    w->counts.positions += positions;
    w->counts.survived_cells += within;
    if (look_for_ground(w, positions, within) < 0)
        return -ENOMEM;
    if (within <= positions / FINE_SHARE || w->on_ground)
        return compare_survivors(w, 0);
    ttf_rank_template_refine(&w->template, w->search, w->query);
    if (place_runs(w) < 0)
        return -ENOMEM;
    bound_all(w, 1);
    look_at_seeds(w, positions, 1);
    return compare_survivors(w, 1);
}

int ttf_rank_search_run(const struct ttf_rank_search *search, struct ttf_rank_workspace *workspace,
                        const struct ttf_rank_query *query, struct ttf_rank_result *ret)
{
    struct ttf_rank_query freed = *query;
    size_t positions = 0;
    int r;

    for (unsigned i = 0; i < search->views->n; i++) {
        uint32_t columns, rows;

        grid_of(&search->views->list[i], query, &columns, &rows);
        positions += (size_t)columns * rows;
    }
    workspace->search = search;
    workspace->query = query;
    r = make_room(workspace, positions);
    if (r == 0)
        r = ttf_rank_template_gather(&workspace->template, search, query);
    if (r == 0)
        r = place_runs(workspace);
    if (r < 0)
        return r;
    if (positions == 0 || workspace->template.n_pixels == 0)
        return -EINVAL;
    r = run(workspace, positions);
    if (r == 0 && workspace->best == UINT64_MAX) {
        freed.n_excluded = 0;
        workspace->query = &freed;
        r = run(workspace, positions);
    }
    if (r == 0)
        collect(workspace, ret);
    workspace->query = NULL;
    return r;
}
