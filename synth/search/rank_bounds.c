/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdbool.h>

#include "search/rank_private.h"

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

static void bound_view(struct ttf_rank_workspace *w, unsigned index, uint32_t limit,
                       uint32_t *bounds)
{
    const struct ttf_view *view = &w->search->views->list[index];
    uint32_t columns, rows;

    ttf_rank_grid(view, w->query, &columns, &rows);
    aim_at_view(w, view);
    for (uint32_t y = 0; y < rows; y++)
        w->search->kernels->bound_cells(view->cells[0] + (size_t)y * view->width * TTF_CELL_DIMS,
                                        w->targets, w->template.n_cells[0], columns, limit,
                                        bounds + (size_t)y * columns);
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

        for (uint32_t x = 0; x < columns; x += 2) {
            bool here = bounds[x] <= coarse_limit;
            bool next = x + 1 < columns && bounds[x + 1] <= coarse_limit;

            if (!here)
                bounds[x] = TTF_RANK_EXCLUDED;
            if (!next && x + 1 < columns)
                bounds[x + 1] = TTF_RANK_EXCLUDED;
            if (here || next)
                wait_for_others(w, limit, row + (size_t)x * TTF_CELL_DIMS, bounds + x, here, next,
                                &waiting);
        }
        bounds += columns;
    }
    refine_waiting(w, limit, &waiting);
}

void ttf_rank_bound_all(struct ttf_rank_workspace *w, unsigned level)
{
    uint32_t coarse_limit = ttf_rank_cell_limit(w, 0), limit = ttf_rank_cell_limit(w, level);
    uint32_t *bounds = w->bounds;

    for (unsigned i = 0; i < w->search->views->n; i++) {
        uint32_t columns, rows;

        ttf_rank_grid(&w->search->views->list[i], w->query, &columns, &rows);
        if (level == 0)
            bound_view(w, i, limit, bounds);
        else
            refine_view(w, i, coarse_limit, limit, bounds);
        bounds += (size_t)columns * rows;
    }
}
