/* SPDX-License-Identifier: Apache-2.0 */
/*
 * views.h: the pictures that blocks are looked for in: each input as it is and, where asked, mirrored
 * and turned. A pixel (x, y) of a view is the source pixel of id origin + x * step_x + y * step_y.
 *
 * Beside coefficients a view holds what excludes most positions (rank_search.h): cells of two sizes
 * (cells.h).
 */
#ifndef TTF_SYNTH_SEARCH_VIEWS_H
#define TTF_SYNTH_SEARCH_VIEWS_H

#include <stdint.h>

#include "search/cells.h"
#include "search/matching.h"
#include "search/sources.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/pool.h"

struct ttf_view {
    uint32_t width, height;
    unsigned input, turn; /* TTF_TURN_COUNT: see quilt.h */
    int64_t origin, step_x, step_y;
    const int16_t *coefs; /* height x width x stride */
    int16_t *own;         /* the same, if they are not the matching's own */
    /* height x width x TTF_CELL_DIMS: of the cell whose corner is (x, y); coarse ones, then fine ones */
    int16_t *cells[TTF_CELL_LEVELS];
};

struct ttf_views {
    unsigned n;
    struct ttf_view *list;
    struct ttf_cells levels[TTF_CELL_LEVELS];
};

/* Where the pixels of a turned input of this size lie: fills all of *ret but its arrays. */
void ttf_view_geometry(uint32_t width, uint32_t height, uint32_t first, unsigned turn,
                       struct ttf_view *ret);

static inline uint32_t ttf_view_id(const struct ttf_view *view, uint32_t x, uint32_t y)
{
    return (uint32_t)(view->origin + x * view->step_x + y * view->step_y);
}

/*
 * turns: a set of bits 1 << turn. overlap: the narrowest there will be, pixels. The matching must outlive them;
 * of one without numbers only the geometry is filled in. -ENOMEM.
 */
TTF_MUST_USE int ttf_views_create(const struct ttf_sources *sources,
                                  const struct ttf_matching *matching, unsigned turns,
                                  uint32_t overlap, struct ttf_pool *pool, struct ttf_views *ret);
void ttf_views_free(struct ttf_views *views); /* zeroed ones are fine */

#endif
