/* SPDX-License-Identifier: Apache-2.0 */
#include "search/views.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "search/lanes.h"
#include "search/rank_kernels.h"

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
    const struct ttf_cells *cells; /* of the level that is being filled */
    int16_t *out;
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

struct four_cells {
    const struct ttf_view *view;
    size_t stride;
    uint32_t side, y, x[4];
};

static const int16_t *view_pixel(const void *ctx, unsigned which, uint32_t i)
{
    const struct four_cells *four = ctx;
    size_t x = four->x[which] + i % four->side, y = four->y + i / four->side;

    return four->view->coefs + (y * four->view->width + x) * four->stride;
}

/* Cells that reach over the edge are left 0: nobody asks for them. */
static void cells_row(void *ctx, unsigned y, unsigned worker)
{
    const struct fill *fill = ctx;
    const struct ttf_view *view = fill->view;
    struct four_cells four = {view, fill->matching->stride, fill->cells->side, y, {0}};
    int16_t *out = fill->out + (size_t)y * view->width * TTF_CELL_DIMS;
    uint32_t n = view->width - four.side + 1;
    int16_t values[4 * TTF_CELL_DIMS];

    (void)worker;
    for (uint32_t x = 0; x < n; x += 4) {
        for (uint32_t k = 0; k < 4; k++)
            four.x[k] = x + k < n ? x + k : n - 1;
        ttf_cells_project(fill->cells, view_pixel, &four, values);
        memcpy(out + (size_t)x * TTF_CELL_DIMS, values,
               (n - x < 4 ? n - x : 4) * TTF_CELL_DIMS * sizeof(*values));
    }
}

static int fill_view(struct ttf_view *view, const struct ttf_views *views,
                     const struct ttf_matching *matching, struct ttf_pool *pool)
{
    size_t pixels = (size_t)view->width * view->height;
    struct fill fill = {.view = view, .matching = matching};

    if (view->turn != 0) {
        view->own = ttf_lanes_alloc(pixels * matching->stride + TTF_COEF_LANES);
        if (!view->own)
            return -ENOMEM;
        ttf_pool_run(pool, view->height, copy_row, &fill);
        view->coefs = view->own;
    }
    for (unsigned level = 0; level < TTF_CELL_LEVELS; level++) {
        uint32_t side = views->levels[level].side;

        view->cells[level] =
            ttf_lanes_alloc((pixels + 1) * TTF_CELL_DIMS); /* the last one's neighbour */
        if (!view->cells[level])
            return -ENOMEM;
        fill.cells = &views->levels[level];
        fill.out = view->cells[level];
        if (view->height >= side && view->width >= side)
            ttf_pool_run(pool, view->height - side + 1, cells_row, &fill);
    }
    return 0;
}

struct find {
    const struct ttf_sequence *input;
    const struct ttf_matching *matching;
    uint32_t overlap;
    struct ttf_cells *levels;
    int codes[TTF_CELL_LEVELS];
};

static void find_level(void *ctx, unsigned level, unsigned worker)
{
    struct find *find = ctx;

    (void)worker;
    find->codes[level] = ttf_cells_find(find->matching->coefs, find->input->width,
                                        find->input->height, find->matching->stride,
                                        ttf_cells_side(level, find->overlap), &find->levels[level]);
}

static int find_levels(const struct ttf_sequence *input, const struct ttf_matching *matching,
                       uint32_t overlap, struct ttf_pool *pool, struct ttf_cells *levels)
{
    struct find find = {input, matching, overlap, levels, {0}};
    int r = 0;

    ttf_pool_run(pool, TTF_CELL_LEVELS, find_level, &find);
    for (unsigned level = 0; level < TTF_CELL_LEVELS; level++)
        r = r < 0 ? r : find.codes[level];
    return r;
}

/* Adds a view; without numbers to match by, only its place. */
static int add_view(struct ttf_views *views, const struct ttf_sources *sources,
                    const struct ttf_matching *matching, unsigned input, unsigned turn,
                    struct ttf_pool *pool)
{
    struct ttf_view *view = &views->list[views->n++];
    const struct ttf_sequence *sequence = sources->list[input];

    ttf_view_geometry(sequence->width, sequence->height, sources->first[input], turn, view);
    view->input = input;
    if (!matching->coefs)
        return 0;
    view->coefs = matching->coefs + (size_t)sources->first[input] * matching->stride;
    return fill_view(view, views, matching, pool);
}

int ttf_views_create(const struct ttf_sources *sources, const struct ttf_matching *matching,
                     unsigned turns, uint32_t overlap, struct ttf_pool *pool, struct ttf_views *ret)
{
    struct ttf_views views = {0};
    int r = 0;

    views.list = calloc((size_t)sources->n * TTF_TURN_COUNT, sizeof(*views.list));
    if (!views.list)
        return -ENOMEM;
    if (matching->coefs)
        r = find_levels(sources->list[0], matching, overlap, pool, views.levels);
    for (unsigned i = 0; i < sources->n && r == 0; i++) {
        for (unsigned turn = 0; turn < TTF_TURN_COUNT && r == 0; turn++) {
            if (turns & (1u << turn))
                r = add_view(&views, sources, matching, i, turn, pool);
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
        ttf_lanes_free(views->list[i].own);
        for (unsigned level = 0; level < TTF_CELL_LEVELS; level++)
            ttf_lanes_free(views->list[i].cells[level]);
    }
    free(views->list);
    for (unsigned level = 0; level < TTF_CELL_LEVELS; level++)
        ttf_cells_free(&views->levels[level]);
    memset(views, 0, sizeof(*views));
}
