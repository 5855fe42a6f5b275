/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/avoid.h"

/* A block at most TTF_AVOID_BLOCKS away, over the border of a tileable output; false: none, or not before block i. */
static bool nearby(const struct ttf_plan *plan, unsigned i, int right, int down, unsigned *ret)
{
    int columns = (int)plan->placement.columns, rows = (int)plan->placement.rows;
    int column = (int)i % columns + right, row = (int)i / columns + down;

    if (plan->config->tileable) {
        column = (column + TTF_AVOID_BLOCKS * columns) % columns;
        row = (row + TTF_AVOID_BLOCKS * rows) % rows;
    }
    if (column < 0 || column >= columns || row < 0 || row >= rows)
        return false;
    *ret = (unsigned)(row * columns + column);
    return *ret < i;
}

/* Twice the middle of a block; of half pixels, so. */
struct middle {
    int64_t x, y;
};

/* From a turned picture of this size to the picture itself, or (`back`) the other way. */
static struct middle turned(struct middle m, const struct ttf_view *view, bool back)
{
    if (back && (view->turn & 4))
        m = (struct middle){m.y, m.x};
    if (view->turn & 1)
        m.x = 2 * (int64_t)view->width - m.x;
    if (view->turn & 2)
        m.y = 2 * (int64_t)view->height - m.y;
    if (!back && (view->turn & 4))
        m = (struct middle){m.y, m.x};
    return m;
}

static uint32_t at_least_0(int64_t value)
{
    return value > 0 ? (uint32_t)value : 0;
}

/* Corners in `view` whose blocks' middles lie within `avoid` of this one. */
static struct ttf_position_rect around(const struct ttf_plan *plan, unsigned view,
                                       struct middle place, const struct ttf_quilt_block *block,
                                       uint32_t avoid)
{
    struct middle m = turned(place, &plan->views.list[view], true);
    int64_t x = (m.x - block->width) >> 1, y = (m.y - block->height) >> 1;

    return (struct ttf_position_rect){.view = view,
                                      .x0 = at_least_0(x - avoid),
                                      .y0 = at_least_0(y - avoid),
                                      .x1 = at_least_0(x + avoid + 1),
                                      .y1 = at_least_0(y + avoid + 1)};
}

/* The place that `other` was taken from, in all views of its input. */
static unsigned add_place(const struct ttf_plan *plan, const struct ttf_quilt_block *block,
                          const struct ttf_quilt_block *other, uint32_t avoid,
                          struct ttf_position_rect *ret)
{
    const struct ttf_views *views = &plan->views;
    struct middle place = {2 * (int64_t)other->src_x + block->width,
                           2 * (int64_t)other->src_y + block->height};
    unsigned n = 0;

    for (unsigned v = 0; v < views->n; v++) {
        if (views->list[v].input == other->input && views->list[v].turn == other->turn)
            place = turned(place, &views->list[v], false);
    }
    for (unsigned v = 0; v < views->n; v++) {
        if (views->list[v].input == other->input)
            ret[n++] = around(plan, v, place, block, avoid);
    }
    return n;
}

static unsigned find_within(const struct ttf_plan *plan, unsigned i, uint32_t avoid,
                            struct ttf_position_rect *ret)
{
    unsigned n = 0, at;

    for (int down = -TTF_AVOID_BLOCKS; down <= TTF_AVOID_BLOCKS; down++) {
        for (int right = -TTF_AVOID_BLOCKS; right <= TTF_AVOID_BLOCKS; right++) {
            if (nearby(plan, i, right, down, &at))
                n += add_place(plan, &plan->map.blocks[i], &plan->map.blocks[at], avoid, ret + n);
        }
    }
    return n;
}

/* Where a rectangle that covers the position ends; x if none does. */
static uint32_t beyond(const struct ttf_position_rect *rects, unsigned n, unsigned view, uint32_t x,
                       uint32_t y)
{
    for (unsigned i = 0; i < n; i++) {
        if (rects[i].view == view && y >= rects[i].y0 && y < rects[i].y1 && x >= rects[i].x0 &&
            x < rects[i].x1)
            return rects[i].x1;
    }
    return x;
}

/* Is a row of positions covered from end to end? */
static bool row_is_covered(const struct ttf_position_rect *rects, unsigned n, unsigned view,
                           uint32_t y, uint32_t columns)
{
    uint32_t x = 0, next = beyond(rects, n, view, x, y);

    while (x < columns && next > x) {
        x = next;
        next = beyond(rects, n, view, x, y);
    }
    return x >= columns;
}

static bool any_is_left(const struct ttf_plan *plan, const struct ttf_quilt_block *block,
                        const struct ttf_position_rect *rects, unsigned n)
{
    for (unsigned v = 0; v < plan->views.n; v++) {
        const struct ttf_view *view = &plan->views.list[v];

        if (view->width < block->width || view->height < block->height)
            continue;
        for (uint32_t y = 0; y + block->height <= view->height; y++) {
            if (!row_is_covered(rects, n, v, y, view->width - block->width + 1))
                return true;
        }
    }
    return false;
}

unsigned ttf_avoid_find(const struct ttf_plan *plan, unsigned i, struct ttf_position_rect *ret)
{
    uint32_t avoid = plan->config->avoid_px, longest = 0;

    for (unsigned v = 0; v < plan->views.n; v++) {
        const struct ttf_view *view = &plan->views.list[v];

        longest = view->width > longest ? view->width : longest;
        longest = view->height > longest ? view->height : longest;
    }
    /* no two places of an input are farther apart */
    for (avoid = avoid < longest ? avoid : longest; avoid > 0; avoid /= 2) {
        unsigned n = find_within(plan, i, avoid, ret);

        if (any_is_left(plan, &plan->map.blocks[i], ret, n))
            return n;
    }
    return 0;
}
