/* SPDX-License-Identifier: Apache-2.0 */
/* dots.h: dark round dots on light ground, found in a picture, and told by row and column of the grid that they make. Pure. */
#ifndef TTF_DATASET_DOTS_H
#define TTF_DATASET_DOTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"

#define DOTS_MAX 10000

struct dot {
    double x, y; /* its middle, pixels; (0, 0) is the first pixel's outer corner */
    uint32_t area_px;
    bool on_grid;
    int32_t column, row; /* from the dot nearest to the picture's middle, where on_grid */
};

/*
 * Middles of the dots, by their darkness, to a fraction of a pixel. What touches the picture's edge, is not
 * round, or of quite another size than most is left out. light: height x width, any unit. *ret is to be freed. -ENOMEM; -E2BIG beyond
 * DOTS_MAX.
 */
TTF_MUST_USE int dots_find(const float *light, uint32_t width, uint32_t height, struct dot **ret,
                           size_t *ret_n);

/* Numbers the dots of the grid, from neighbour to neighbour; *ret: how many are on it, 0 where there is none. -ENOMEM. */
TTF_MUST_USE int dots_number(struct dot *dots, size_t n, uint32_t width, uint32_t height,
                             size_t *ret);

#endif
