/* SPDX-License-Identifier: Apache-2.0 */
/*
 * plan_change.h: a plan that changes while its run lives: what may change, the grid it gives, and its
 * way to the disk (stock.h, a work that carries a change instead of a slot).
 */
#ifndef TTF_CAPTURE_PRIVATE_PLAN_CHANGE_H
#define TTF_CAPTURE_PRIVATE_PLAN_CHANGE_H

#include "schedule.h"
#include "ttf/capture/control.h"
#include "ttf/dataset/record.h"

/* One on its way to the disk. */
struct ttf_plan_change {
    int64_t ask;                              /* to be answered; 0: none */
    char *json;                               /* owned */
    char *yaml;                               /* owned; NULL: not given */
    struct ttf_segment segment;               /* the session's numbers of it and of its plan */
    bool as_given;                            /* it is the plan that the session was given */
    int64_t count, slot_bytes, reserve_bytes; /* of the new plan */
};

/* A change with copies of the texts; NULL: no memory. */
struct ttf_plan_change *ttf_plan_change_new(const struct ttf_plan *plan, const char *yaml);
void ttf_plan_change_free(struct ttf_plan_change *change); /* NULL allowed */

/*
 * What the plan becomes by an ask of kind COUNT, UNTIL, INTERVAL, PHOTOPERIOD or PLAN (pure). -EINVAL with a
 * sentence where it asks for what cannot change while a run lives: another stream (a new dataset of the group),
 * another exposure (stop, and run with the new plan), fewer slots than there are records.
 * index: of the next slot. How many slots one comes to that ends in time is not said: that needs its grid.
 */
TTF_MUST_USE int ttf_plan_changed(const struct ttf_plan *plan, const struct ttf_ask *ask,
                                  int64_t index, struct ttf_plan *ret, struct ttf_err *err);

/*
 * The grid from slot `index` on with another interval: one new interval after the slot before, or,
 * where that is before ready_ns, the first multiple that is not. From slot 0 on nothing moves.
 */
struct ttf_grid ttf_grid_changed(const struct ttf_grid *grid, int64_t index, int64_t interval_ns,
                                 int64_t ready_ns);

#endif
