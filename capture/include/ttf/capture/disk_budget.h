/* SPDX-License-Identifier: Apache-2.0 */
/*
 * disk_budget.h: whether a folder has the room and the speed that a plan needs.
 * Looked at before a capture is armed, and by `plan check`.
 */
#ifndef TTF_CAPTURE_DISK_BUDGET_H
#define TTF_CAPTURE_DISK_BUDGET_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/capture/plan.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/clock.h"

struct ttf_disk_figures {
    int64_t free_bytes;
    int64_t bytes_per_s;          /* written and synced; 0: not measured */
    int64_t slots_that_fit;       /* before the reserve is touched */
    int64_t shortest_interval_ns; /* that the speed sustains; 0: not measured */
};

/*
 * Looks at the folder that `path` lies in or will lie in (its nearest existing
 * folder). -ENOSPC: the plan's slots do not fit above its reserve; -EINVAL with
 * where "interval": written slower than slots come; both say the best that can be had and
 * fill *ret (may be NULL). Speed is measured with a file of one slot's size (64 MiB at
 * most) that is removed again; clock NULL or virtual: not measured, since no time passes.
 */
TTF_MUST_USE int ttf_disk_budget_check(struct ttf_io *io, const char *path, struct ttf_clock *clock,
                                       const struct ttf_plan *plan,
                                       const struct ttf_plan_figures *figures,
                                       struct ttf_disk_figures *ret, struct ttf_err *err);

/*
 * Whether there are so many bytes of room where `path` lies or will lie, for `what` (in the message). -ENOSPC, with the figures;
 * -EROFS; or why nobody knows.
 */
TTF_MUST_USE int ttf_disk_room_check(struct ttf_io *io, const char *path, const char *what,
                                     int64_t bytes, struct ttf_err *err);

/*
 * Whether the plan's second storage can be used: a folder that is there and can be written, and not the first one's own (-EINVAL). -ENOENT, -ENOTDIR, -EROFS
 * or what writing gave, with where "storage.second". path: where the dataset lies or will lie. *ret_same (may be NULL):
 * both are of one file system, so that what fills or breaks one does the other. A plan without one is fine.
 */
TTF_MUST_USE int ttf_second_storage_check(struct ttf_io *io, const char *path,
                                          const struct ttf_plan *plan, bool *ret_same,
                                          struct ttf_err *err);

/* The same without writing anything: what a look alone can say, at any time and beside any run. */
TTF_MUST_USE int ttf_second_storage_look(struct ttf_io *io, const char *path,
                                         const struct ttf_plan *plan, bool *ret_same,
                                         struct ttf_err *err);

#endif
