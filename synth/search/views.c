/* SPDX-License-Identifier: Apache-2.0 */
#include "search/views.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "search/rank_kernels.h"

/* Cell values are a quarter of the pixels' scale (TTF_CELL_MAX against TTF_COEF_MAX). */
#define CELL_SCALE 4

int16_t ttf_cell_value(int32_t sum, uint32_t pixels)
{
    int32_t unit = (int32_t)(CELL_SCALE * pixels);
    int32_t half = unit / 2;

    return (int16_t)(sum >= 0 ? (sum + half) / unit : -((-sum + half) / unit));
}

void ttf_view_geometry(uint32_t width, uint32_t height, uint32_t first, unsigned turn,
                       struct ttf_view *ret)
{
    bool swapped = turn & 4;
    uint32_t across = swapped ? height : width, down = swapped ? width : height;
    int64_t step_x = swapped ? (int64_t)width : 1, step_y = swapped ? 1 : (int64_t)width;
    int64_t origin = first;

    if (turn & 1) {
        origin += (across - 1) * step_x;
        step_x = -step_x;
    }
    if (turn & 2) {
        origin += (down - 1) * step_y;
        step_y = -step_y;
    }
    *ret = (struct ttf_view){.width = across,
                             .height = down,
                             .turn = turn,
                             .origin = origin,
                             .step_x = step_x,
                             .step_y = step_y};
}

struct fill {
    struct ttf_view *view;
    const struct ttf_matching *matching;
    uint32_t cell;
};

static void copy_row(void *ctx, unsigned y, unsigned worker)
{
    const struct fill *fill = ctx;
    const struct ttf_view *view = fill->view;
    size_t stride = fill->matching->stride;

    (void)worker;
    for (uint32_t x = 0; x < view->width; x++)
        memcpy(view->own + ((size_t)y * view->width + x) * stride,
               fill->matching->coefs + ttf_view_id(view, x, y) * stride,
               stride * sizeof(*view->own));
}

/* Sums down a column of cell pixels, then along the row. Cells that reach over the edge are left 0: nobody asks for them. */
static void cells_row(void *ctx, unsigned y, unsigned worker)
{
    const struct fill *fill = ctx;
    const struct ttf_view *view = fill->view;
    size_t stride = fill->matching->stride, cell = fill->cell;
    int16_t *out = view->cells + (size_t)y * view->width * TTF_CELL_DIMS;

    (void)worker;
    for (size_t x = 0; x + cell <= view->width; x++) {
        for (size_t d = 0; d < TTF_CELL_DIMS; d++) {
            int32_t sum = 0;

            for (size_t i = 0; i < cell * cell; i++)
                sum += view->coefs[((y + i / cell) * view->width + x + i % cell) * stride + d];
            out[x * TTF_CELL_DIMS + d] = ttf_cell_value(sum, (uint32_t)(cell * cell));
        }
    }
}

static int fill_view(struct fill *fill, struct ttf_pool *pool)
{
    struct ttf_view *view = fill->view;
    size_t pixels = (size_t)view->width * view->height;

    if (!fill->matching->coefs)
        return 0; /* only the geometry is asked for */
    if (view->turn != 0) {
        view->own = malloc(pixels * fill->matching->stride * sizeof(*view->own));
        if (!view->own)
            return -ENOMEM;
        ttf_pool_run(pool, view->height, copy_row, fill);
        view->coefs = view->own;
    }
    view->cells = calloc(pixels * TTF_CELL_DIMS, sizeof(*view->cells));
    if (!view->cells)
        return -ENOMEM;
    if (view->height >= fill->cell)
        ttf_pool_run(pool, view->height - fill->cell + 1, cells_row, fill);
    return 0;
}

int ttf_views_create(const struct ttf_sources *sources, const struct ttf_matching *matching,
                     unsigned turns, uint32_t cell, struct ttf_pool *pool, struct ttf_views *ret)
{
    struct ttf_views views = {.cell = cell};
    int r = 0;

    views.list = calloc((size_t)sources->n * TTF_TURN_COUNT, sizeof(*views.list));
    if (!views.list)
        return -ENOMEM;
    for (unsigned i = 0; i < sources->n; i++) {
        for (unsigned turn = 0; turn < TTF_TURN_COUNT && r == 0; turn++) {
            struct ttf_view *view = &views.list[views.n];
            struct fill fill = {view, matching, cell};

            if (!(turns & (1u << turn)))
                continue;
            views.n++;
            ttf_view_geometry(sources->list[i]->width, sources->list[i]->height, sources->first[i],
                              turn, view);
            view->input = i;
            view->coefs = matching->coefs + (size_t)sources->first[i] * matching->stride;
            r = fill_view(&fill, pool);
        }
    }
    if (r < 0) {
        ttf_views_free(&views);
        return r;
    }
    *ret = views;
    return 0;
}

void ttf_views_free(struct ttf_views *views)
{
    for (unsigned i = 0; views->list && i < views->n; i++) {
        free(views->list[i].own);
        free(views->list[i].cells);
    }
    free(views->list);
    memset(views, 0, sizeof(*views));
}
