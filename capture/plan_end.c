/* SPDX-License-Identifier: Apache-2.0 */
#include "plan_end.h"

#include "ttf/base/checked.h"
#include "ttf/base/time.h"

/* A clock that was set wrong by years asks for no more slots than a plan may. */
#define SLOTS_MAX INT64_C(1000000000)

bool ttf_plan_ends_in_time(const struct ttf_plan *plan)
{
    return plan->end == TTF_END_UNTIL || plan->end == TTF_END_LENGTH;
}

int64_t ttf_plan_end_ns(const struct ttf_plan *plan, const struct ttf_run_clock *clock)
{
    int64_t end;

    if (plan->end == TTF_END_LENGTH)
        return ttf_add_i64(ttf_near_difference_i64(clock->slot0_ns, clock->gaps_ns),
                           plan->length_ns, &end)
                   ? end
                   : TTF_NS_NEVER;
    if (plan->end == TTF_END_UNTIL && clock->utc_offset_ns != TTF_NS_UNKNOWN)
        return ttf_near_difference_i64(plan->until_utc_ns, clock->utc_offset_ns);
    return TTF_NS_UNKNOWN;
}

/* Whether so many is right, or wrong by less than what clocks are corrected by. */
static bool good_enough(int64_t count, const struct ttf_grid *grid, int64_t end_ns)
{
    int64_t slack = grid->interval_ns / 2 < TTF_NS_PER_S ? grid->interval_ns / 2 : TTF_NS_PER_S;

    return count >= grid->first_index && count <= SLOTS_MAX &&
           ttf_grid_due_ns(grid, count - 1) < end_ns + slack &&
           ttf_grid_due_ns(grid, count) >= end_ns - slack;
}

int64_t ttf_plan_slots(const struct ttf_plan *plan, const struct ttf_grid *grid,
                       const struct ttf_run_clock *clock)
{
    int64_t end_ns = ttf_plan_end_ns(plan, clock);
    int64_t n;

    if (end_ns == TTF_NS_UNKNOWN)
        return plan->count;
    if (end_ns < TTF_NS_NEVER - TTF_NS_PER_S && good_enough(plan->count, grid, end_ns))
        return plan->count;
    n = ttf_grid_index_at(grid, end_ns);
    return n < SLOTS_MAX ? n : SLOTS_MAX;
}

bool ttf_plan_end_passed(const struct ttf_plan *plan, const struct ttf_grid *grid, int64_t index,
                         const struct ttf_run_clock *clock)
{
    int64_t end_ns = ttf_plan_end_ns(plan, clock);

    return index > 0 && end_ns != TTF_NS_UNKNOWN && end_ns <= ttf_grid_due_ns(grid, index - 1);
}

bool ttf_run_clock_believed(const struct ttf_plan *plan, const struct ttf_grid *grid, int64_t index,
                            const struct ttf_run_clock *clock, bool host)
{
    if (!host)
        return true;
    return index > 0 ? !ttf_plan_end_passed(plan, grid, index, clock)
                     : ttf_plan_slots(plan, grid, clock) > 0;
}
