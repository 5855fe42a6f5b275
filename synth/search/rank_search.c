/* SPDX-License-Identifier: Apache-2.0 */
#include "search/rank_search.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "search/rank_private.h"

/* How many of the most promising positions are compared in full to get a first limit. */
#define SEEDS 16

/* Fine cells pay for themselves where coarse ones let more than this share of positions pass. */
#define FINE_SHARE 64u

/* A plain ground is looked for where more than this share pass. */
#define GROUND_SHARE 16u

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
    free(workspace->at);
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

void ttf_rank_grid(const struct ttf_view *view, const struct ttf_rank_query *query,
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

        ttf_rank_grid(&w->search->views->list[at->view], w->query, &columns, &rows);
        if (at->x < columns && at->y < rows && !is_excluded(w->query, at))
            ttf_rank_look_at(w, at, 1);
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

        ttf_rank_grid(&w->search->views->list[i], w->query, &columns, &rows);
        if (index < (size_t)columns * rows)
            return (struct ttf_rank_position){i, (uint32_t)(index % columns),
                                              (uint32_t)(index / columns)};
        index -= (size_t)columns * rows;
    }
    return (struct ttf_rank_position){0, 0, 0};
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
    struct ttf_rank_position list[SEEDS];
    unsigned n = most_promising(w->bounds, positions, ttf_rank_cell_limit(w, level), seeds);

    for (unsigned i = 0; i < n; i++)
        list[i] = position_of(w, seeds[i]);
    ttf_rank_look_at(w, list, n);
}

static size_t count_within(const uint32_t *bounds, size_t n, uint32_t limit)
{
    size_t within = 0;

    for (size_t i = 0; i < n; i++)
        within += bounds[i] <= limit;
    return within;
}

/* Of the sampled rows' positions: do coarse cells let so many pass, with a limit near its last value, that they are not worth the time for the others? */
static bool coarse_ones_are_in_vain(struct ttf_rank_workspace *w, size_t positions)
{
    if (!ttf_rank_most_of_sample_pass(w))
        return false;
    ttf_rank_set_unsampled(w, false);
    look_at_seeds(w, positions, 0);
    return ttf_rank_most_of_sample_pass(w);
}

/* Bounds by coarse cells, and a limit near its last value; returns how many positions are left. */
static size_t bound_coarsely(struct ttf_rank_workspace *w, size_t positions)
{
    ttf_rank_bound_coarse(w, true);
    if (coarse_ones_are_in_vain(w, positions)) {
        ttf_rank_set_unsampled(w, true);
    } else {
        ttf_rank_bound_coarse(w, false);
        look_at_seeds(w, positions, 0);
    }
    return count_within(w->bounds, positions, ttf_rank_cell_limit(w, 0));
}

static int run(struct ttf_rank_workspace *w, size_t positions)
{
    size_t within;

    w->best = UINT64_MAX;
    w->limit = (double)UINT64_MAX;
    w->on_ground = false;
    look_at_hints(w);
    within = bound_coarsely(w, positions);
    w->counts.positions += positions;
    w->counts.survived_cells += within;
    if (look_for_ground(w, positions, within) < 0)
        return -ENOMEM;
    if (within <= positions / FINE_SHARE || w->on_ground)
        return ttf_rank_compare_survivors(w, 0);
    ttf_rank_template_refine(&w->template, w->search, w->query);
    if (ttf_rank_place_vectors(w) < 0)
        return -ENOMEM;
    ttf_rank_bound_fine(w);
    look_at_seeds(w, positions, 1);
    return ttf_rank_compare_survivors(w, 1);
}

int ttf_rank_search_run(const struct ttf_rank_search *search, struct ttf_rank_workspace *workspace,
                        const struct ttf_rank_query *query, struct ttf_rank_result *ret)
{
    struct ttf_rank_query freed = *query;
    size_t positions = 0;
    int r;

    for (unsigned i = 0; i < search->views->n; i++) {
        uint32_t columns, rows;

        ttf_rank_grid(&search->views->list[i], query, &columns, &rows);
        positions += (size_t)columns * rows;
    }
    workspace->search = search;
    workspace->query = query;
    r = make_room(workspace, positions);
    if (r == 0)
        r = ttf_rank_template_gather(&workspace->template, search, query);
    if (r == 0)
        r = ttf_rank_place_vectors(workspace);
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
