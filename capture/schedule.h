/* SPDX-License-Identifier: Apache-2.0 */
/*
 * schedule.h: the absolute grid of slots. due(k) = origin + (k - first) * interval,
 * computed anew for each k: no error accumulates. Pure.
 */
#ifndef TTF_CAPTURE_PRIVATE_SCHEDULE_H
#define TTF_CAPTURE_PRIVATE_SCHEDULE_H

#include <stdint.h>

/* Instants on the boot clock; they may be negative (before this boot). */
struct ttf_grid {
    int64_t first_index;
    int64_t origin_ns;   /* first_index is due then */
    int64_t interval_ns; /* > 0 */
};

/* When slot `index` is due; an instant beyond int64 is TTF_NS_NEVER. */
int64_t ttf_grid_due_ns(const struct ttf_grid *grid, int64_t index);

/* The smallest index that is due at or after t_ns; at least first_index. */
int64_t ttf_grid_index_at(const struct ttf_grid *grid, int64_t t_ns);

#endif
