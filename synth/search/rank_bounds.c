/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "search/rank_private.h"

/* Coarse cells are not worth their time where less than one in so many positions is excluded by them: fine ones, of a whole row, cost so much more. */
#define SAMPLE_SHARE 8u

uint32_t ttf_rank_cell_limit(const struct ttf_rank_workspace *w, unsigned level)
{
    double length = sqrt(w->limit) * w->search->views->levels[level].scale * (1.0 + 1e-5) +
                    1.01 * sqrt((double)w->template.n_cells[level] * TTF_CELL_DIMS);
    double limit = length * length + 1.0;

    return limit < (double)TTF_BOUND_MAX ? (uint32_t)limit : TTF_RANK_EXCLUDED - 1;
}

double ttf_rank_least_of_cells(const struct ttf_rank_workspace *w, unsigned level, uint32_t bound)
{
    double length =
        (sqrt((double)bound) - 1.01 * sqrt((double)w->template.n_cells[level] * TTF_CELL_DIMS)) /
        (w->search->views->levels[level].scale * (1.0 + 1e-5));

    return length > 0.0 ? length * length : 0.0;
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
                bounds[(size_t)y * columns + x] = TTF_RANK_EXCLUDED;
        }
    }
}

static void aim_at_view(struct ttf_rank_workspace *w, const struct ttf_view *view)
{
    const struct ttf_rank_template *template = &w->template;

    for (size_t i = 0; i < template->n_cells[0]; i++) {
        w->targets[i] = template->cells[0][i].target;
        w->targets[i].offset = template->cells[0][i].dy * view->width + template->cells[0][i].dx;
    }
}

static void bound_view(struct ttf_rank_workspace *w, unsigned index, bool sampled, uint32_t limit,
                       uint32_t *bounds)
{
    const struct ttf_view *view = &w->search->views->list[index];
    uint32_t columns, rows;

    ttf_rank_grid(view, w->query, &columns, &rows);
    aim_at_view(w, view);
    for (uint32_t y = 0; y < rows; y++) {
        if ((y % TTF_RANK_SAMPLE == 0) == sampled)
            w->search->kernels->bound_cells(
                view->cells[0] + (size_t)y * view->width * TTF_CELL_DIMS, w->targets,
                w->template.n_cells[0], columns, limit, bounds + (size_t)y * columns);
    }
    exclude(w, index, columns, rows, bounds);
}

/* Pairs of neighbouring positions that wait for others to be bounded with: survivors come in clusters. */
struct waiting {
    const int16_t *cells[TTF_RANK_ABREAST];
    uint32_t *bounds[TTF_RANK_ABREAST];
    bool asked[TTF_RANK_ABREAST][2]; /* for the bound of this one and of its right neighbour */
    unsigned n;
};

static void refine_waiting(const struct ttf_rank_workspace *w, uint32_t limit,
                           struct waiting *waiting)
{
    uint64_t sums[2 * TTF_RANK_ABREAST];

    for (unsigned i = waiting->n; i > 0 && i < TTF_RANK_ABREAST; i++)
        waiting->cells[i] = waiting->cells[0];
    if (waiting->n > 0)
        w->search->kernels->ssd_at_pairs(waiting->cells, w->fine_at, w->template.fine,
                                         w->template.n_cells[1], limit, sums);
    for (unsigned i = 0; i < 2 * waiting->n; i++) {
        if (waiting->asked[i / 2][i % 2])
            waiting->bounds[i / 2][i % 2] =
                sums[i] < TTF_BOUND_MAX ? (uint32_t)sums[i] : TTF_BOUND_MAX;
    }
    waiting->n = 0;
}

static void wait_for_others(const struct ttf_rank_workspace *w, uint32_t limit,
                            const int16_t *cells, uint32_t *bounds, bool here, bool next,
                            struct waiting *waiting)
{
    waiting->cells[waiting->n] = cells;
    waiting->bounds[waiting->n] = bounds;
    waiting->asked[waiting->n][0] = here;
    waiting->asked[waiting->n][1] = next;
    if (++waiting->n == TTF_RANK_ABREAST)
        refine_waiting(w, limit, waiting);
}

/* Of a row's places so many are to be left, so that it is worth comparing with all. */
#define ROW_LEFT 10

/* Bounds of a row of places, if enough of them are left. */
static bool refine_row(const struct ttf_rank_workspace *w, const int16_t *cells,
                       uint32_t coarse_limit, uint32_t limit, uint32_t *bounds)
{
    uint64_t sums[TTF_ROW_PLACES];
    unsigned left = 0;

    for (unsigned i = 0; i < TTF_ROW_PLACES; i++)
        left += bounds[i] <= coarse_limit;
    if (left < ROW_LEFT)
        return false;
    w->search->kernels->ssd_at_row(cells, w->fine_at, w->template.fine, w->template.n_cells[1],
                                   limit, sums);
    for (unsigned i = 0; i < TTF_ROW_PLACES; i++) {
        uint32_t sum = sums[i] < TTF_BOUND_MAX ? (uint32_t)sums[i] : TTF_BOUND_MAX;

        bounds[i] = bounds[i] <= coarse_limit ? sum : TTF_RANK_EXCLUDED;
    }
    return true;
}

/* Pairs of places, those that are left. */
static void refine_pairs(const struct ttf_rank_workspace *w, const int16_t *cells, uint32_t n,
                         uint32_t coarse_limit, uint32_t limit, uint32_t *bounds,
                         struct waiting *waiting)
{
    for (uint32_t x = 0; x < n; x += 2) {
        bool here = bounds[x] <= coarse_limit;
        bool next = x + 1 < n && bounds[x + 1] <= coarse_limit;

        if (!here)
            bounds[x] = TTF_RANK_EXCLUDED;
        if (!next && x + 1 < n)
            bounds[x + 1] = TTF_RANK_EXCLUDED;
        if (here || next)
            wait_for_others(w, limit, cells + (size_t)x * TTF_CELL_DIMS, bounds + x, here, next,
                            waiting);
    }
}

/* Bounds by fine cells in place of those by coarse ones; those that are out already stay so. */
static void refine_view(struct ttf_rank_workspace *w, unsigned index, uint32_t coarse_limit,
                        uint32_t limit, uint32_t *bounds)
{
    const struct ttf_view *view = &w->search->views->list[index];
    uint32_t columns, rows;
    struct waiting waiting = {.n = 0};

    ttf_rank_grid(view, w->query, &columns, &rows);
    for (size_t i = 0; i < w->template.n_cells[1]; i++)
        w->fine_at[i] = w->template.cells[1][i].dy * view->width + w->template.cells[1][i].dx;
    for (uint32_t y = 0; y < rows; y++) {
        const int16_t *row = view->cells[1] + (size_t)y * view->width * TTF_CELL_DIMS;

        for (uint32_t x = 0, n; x < columns; x += n) {
            const int16_t *cells = row + (size_t)x * TTF_CELL_DIMS;

            n = columns - x < TTF_ROW_PLACES ? columns - x : TTF_ROW_PLACES;
            if (n < TTF_ROW_PLACES || !refine_row(w, cells, coarse_limit, limit, bounds + x))
                refine_pairs(w, cells, n, coarse_limit, limit, bounds + x, &waiting);
        }
        bounds += columns;
    }
    refine_waiting(w, limit, &waiting);
}

void ttf_rank_bound_coarse(struct ttf_rank_workspace *w, bool sampled)
{
    uint32_t limit = ttf_rank_cell_limit(w, 0), *bounds = w->bounds;

    for (unsigned i = 0; i < w->search->views->n; i++) {
        uint32_t columns, rows;

        ttf_rank_grid(&w->search->views->list[i], w->query, &columns, &rows);
        bound_view(w, i, sampled, limit, bounds);
        bounds += (size_t)columns * rows;
    }
}

bool ttf_rank_most_of_sample_pass(const struct ttf_rank_workspace *w)
{
    uint32_t limit = ttf_rank_cell_limit(w, 0), *bounds = w->bounds;
    size_t within = 0, all = 0;

    for (unsigned i = 0; i < w->search->views->n; i++) {
        uint32_t columns, rows;

        ttf_rank_grid(&w->search->views->list[i], w->query, &columns, &rows);
        for (uint32_t y = 0; y < rows; y += TTF_RANK_SAMPLE) {
            for (uint32_t x = 0; x < columns; x++) {
                uint32_t bound = bounds[(size_t)y * columns + x];

                within += bound <= limit;
                all +=
                    bound != TTF_RANK_EXCLUDED; /* those that the query leaves out do not count */
            }
        }
        bounds += (size_t)columns * rows;
    }
    return within > all / SAMPLE_SHARE * (SAMPLE_SHARE - 1);
}

void ttf_rank_set_unsampled(struct ttf_rank_workspace *w, bool pass)
{
    uint32_t *bounds = w->bounds;

    for (unsigned i = 0; i < w->search->views->n; i++) {
        uint32_t columns, rows;

        ttf_rank_grid(&w->search->views->list[i], w->query, &columns, &rows);
        for (uint32_t y = 0; y < rows; y++) {
            if (y % TTF_RANK_SAMPLE != 0)
                memset(bounds + (size_t)y * columns, pass ? 0 : 0xff, columns * sizeof(*bounds));
        }
        exclude(w, i, columns, rows, bounds);
        bounds += (size_t)columns * rows;
    }
}

void ttf_rank_bound_fine(struct ttf_rank_workspace *w)
{
    uint32_t coarse_limit = ttf_rank_cell_limit(w, 0), limit = ttf_rank_cell_limit(w, 1);
    uint32_t *bounds = w->bounds;

    for (unsigned i = 0; i < w->search->views->n; i++) {
        uint32_t columns, rows;

        ttf_rank_grid(&w->search->views->list[i], w->query, &columns, &rows);
        refine_view(w, i, coarse_limit, limit, bounds);
        bounds += (size_t)columns * rows;
    }
}
