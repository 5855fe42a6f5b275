/* SPDX-License-Identifier: Apache-2.0 */
#include "schedule.h"

#include "ttf/base/checked.h"
#include "ttf/base/time.h"

int64_t ttf_grid_due_ns(const struct ttf_grid *grid, int64_t index)
{
    int64_t offset;
    int64_t due;

    if (!ttf_mul_i64(index - grid->first_index, grid->interval_ns, &offset) ||
        !ttf_add_i64(grid->origin_ns, offset, &due))
        return TTF_NS_NEVER;
    return due;
}

int64_t ttf_grid_index_at(const struct ttf_grid *grid, int64_t t_ns)
{
    int64_t since;

    if (t_ns <= grid->origin_ns)
        return grid->first_index;
    since = ttf_near_difference_i64(t_ns, grid->origin_ns);
    return grid->first_index + since / grid->interval_ns + (since % grid->interval_ns != 0);
}
