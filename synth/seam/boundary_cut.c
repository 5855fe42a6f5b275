/* SPDX-License-Identifier: Apache-2.0 */
#include "seam/boundary_cut.h"

#include <errno.h>
#include <stdlib.h>

/* The cheapest of the up to three neighbours of j in a row; the lowest index of equal ones. */
static uint32_t cheapest(const uint64_t *row, uint32_t j, uint32_t width)
{
    uint32_t from = j > 0 ? j - 1 : 0;
    uint32_t to = j + 1 < width ? j + 1 : j;
    uint32_t best = from;

    for (uint32_t i = from + 1; i <= to; i++) {
        if (row[i] < row[best])
            best = i;
    }
    return best;
}

int ttf_boundary_cut(const uint64_t *error, uint32_t steps, uint32_t width, uint32_t *cut,
                     uint64_t *ret_total)
{
    uint64_t *cost = malloc((size_t)steps * width * sizeof(*cost));
    const uint64_t *last;
    uint32_t best = 0;

    if (!cost)
        return -ENOMEM;
    for (uint32_t j = 0; j < width; j++)
        cost[j] = error[j];
    for (size_t i = 1; i < steps; i++) {
        const uint64_t *before = cost + (i - 1) * width;

        for (uint32_t j = 0; j < width; j++)
            cost[i * width + j] = error[i * width + j] + before[cheapest(before, j, width)];
    }
    last = cost + (size_t)(steps - 1) * width;
    for (uint32_t j = 1; j < width; j++) {
        if (last[j] < last[best])
            best = j;
    }
    if (ret_total)
        *ret_total = last[best];
    cut[steps - 1] = best;
    for (size_t i = steps - 1; i > 0; i--)
        cut[i - 1] = cheapest(cost + (i - 1) * width, cut[i], width);
    free(cost);
    return 0;
}
