/* SPDX-License-Identifier: Apache-2.0 */
/*
 * plan_end.h: how many slots a plan comes to that ends at an instant or after a time, by what is known of
 * the run's time. README.md, "Until". Pure.
 */
#ifndef TTF_CAPTURE_PRIVATE_PLAN_END_H
#define TTF_CAPTURE_PRIVATE_PLAN_END_H

#include <stdbool.h>

#include "schedule.h"
#include "ttf/capture/plan.h"
#include "ttf/hal/clock.h"

/* A run's time on this boot's clock, as far as it is known. */
struct ttf_run_clock {
    int64_t
        slot0_ns;    /* where slot 0 was, or would have been, due: what a photoperiod counts from */
    int64_t gaps_ns; /* outages that no slot stands for, as far as their lengths are known */
    int64_t utc_offset_ns; /* UTC - boot clock; TTF_NS_UNKNOWN */
    enum ttf_trust trust;  /* who says so in this boot; NONE: reckoned from the boots before */
};

/* It ends otherwise than by a number of slots. */
bool ttf_plan_ends_in_time(const struct ttf_plan *plan);

/* Where a plan ends on the boot clock; TTF_NS_UNKNOWN: by its count, or nobody knows. */
int64_t ttf_plan_end_ns(const struct ttf_plan *plan, const struct ttf_run_clock *clock);

/*
 * How many slots it comes to on this grid: those due before its end, or plan->count where that is not known. What
 * plan->count says stays as long as it is less than a second wrong: clocks are corrected by that every day. At least
 * grid->first_index of a plan whose end has passed.
 */
int64_t ttf_plan_slots(const struct ttf_plan *plan, const struct ttf_grid *grid,
                       const struct ttf_run_clock *clock);

/* Whether its end is known to have come before slot index - 1 was due: it has its record all the same. */
bool ttf_plan_end_passed(const struct ttf_plan *plan, const struct ttf_grid *grid, int64_t index,
                         const struct ttf_run_clock *clock);

/*
 * Whether a clock is believed in what it says of the run's end, slot `index` being the next. A PC's word alone (host)
 * that the end has passed, before slot 0 that it leaves none, is not: more likely that clock is ahead, as resume.c has it.
 */
bool ttf_run_clock_believed(const struct ttf_plan *plan, const struct ttf_grid *grid, int64_t index,
                            const struct ttf_run_clock *clock, bool host);

#endif
