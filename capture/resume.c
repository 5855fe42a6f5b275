/* SPDX-License-Identifier: Apache-2.0 */
#include "resume.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "ledger.h"
#include "ttf/base/checked.h"
#include "ttf/base/time.h"

static bool vouched(const struct ttf_segment *s)
{
    return ttf_segment_has_utc(s) && ttf_segment_trust(s) != TTF_TRUST_NONE;
}

static struct ttf_grid grid_of(const struct ttf_segment *s)
{
    return (struct ttf_grid){s->first_index, s->origin_ns, s->interval_ns};
}

/* The same in UTC. */
static struct ttf_grid utc_grid_of(const struct ttf_segment *s)
{
    return (struct ttf_grid){s->first_index, s->origin_utc_ns, s->interval_ns};
}

static int resolve_new(const struct ttf_resume_input *in, struct ttf_resume *r, struct ttf_err *err)
{
    r->grid.first_index = 0;
    r->grid.interval_ns = in->plan->interval_ns;
    r->grid.origin_ns = in->ready_ns;
    r->gap_ns = 0;
    if (in->start_utc_ns == 0)
        return 0;
    if (in->utc.trust == TTF_TRUST_NONE) {
        ttf_err_set(err, -EINVAL, "start",
                    "nobody vouches for this box's clock, so a start time "
                    "means nothing");
        ttf_err_hint(err, "leave start out, or let the clock be set first (NTP, a PC over USB)");
        return -EINVAL;
    }
    r->grid.origin_ns = in->utc.boot_ns + (in->start_utc_ns - in->utc.utc_ns);
    r->lost_result = TTF_RESULT_MISSED;
    r->lost_reason = TTF_REASON_BEFORE_START;
    r->on_grid = true;
    return 0;
}

static struct ttf_run_clock clock_of(const struct ttf_resume_input *in, const struct ttf_grid *grid,
                                     int64_t gaps_ns, int64_t utc_offset_ns)
{
    return (struct ttf_run_clock){ttf_near_difference_i64(grid->origin_ns, in->elapsed_ns), gaps_ns,
                                  utc_offset_ns, TTF_TRUST_NONE};
}

/* The present, or a better clock that a run before this one in this boot knew: the boot clock has kept it. */
static struct ttf_utc best_of(const struct ttf_run_past *past, const struct ttf_utc *now)
{
    if (past->boot_trust <= now->trust)
        return *now;
    return (struct ttf_utc){.boot_ns = now->boot_ns,
                            .utc_ns = ttf_near_sum_i64(now->boot_ns, past->boot_offset_ns),
                            .uncertainty_ns = past->boot_uncertainty_ns,
                            .trust = past->boot_trust,
                            .steps = now->steps};
}

/* What lies between the boots that the run has no time of, by a clock that says so of slot 0 (TTF_NS_UNKNOWN: nobody). */
static int64_t gaps_by(const struct ttf_resume_input *in, const struct ttf_grid *grid,
                       const struct ttf_outage *outage, enum ttf_trust trust, int64_t slot0_utc_ns)
{
    struct ttf_segment now = {.interval_ns = grid->interval_ns};

    snprintf(now.trust, sizeof(now.trust), "%s", ttf_trust_name(trust));
    return ttf_timeline_gaps_ns(&in->past, &now, outage, slot0_utc_ns);
}

/* By what is believed of UTC in this boot. It tells outages of unknown length, too, and slots given up for none. */
static struct ttf_run_clock clock_of_boot(const struct ttf_resume_input *in,
                                          const struct ttf_grid *grid,
                                          const struct ttf_outage *outage)
{
    struct ttf_run_clock clock = clock_of(in, grid, 0, TTF_NS_UNKNOWN);
    const struct ttf_utc utc = ttf_resume_utc(&in->past, &in->utc);
    int64_t slot0_utc_ns = TTF_NS_UNKNOWN;

    clock.trust = utc.trust;
    if (clock.trust != TTF_TRUST_NONE) {
        clock.utc_offset_ns = utc.utc_ns - utc.boot_ns;
        slot0_utc_ns = ttf_near_sum_i64(clock.slot0_ns, clock.utc_offset_ns);
    }
    clock.gaps_ns = gaps_by(in, grid, outage, utc.trust, slot0_utc_ns);
    return clock;
}

/* With the run gone on with on this grid, by the UTC that slot 0 is said to have been due at: nothing of the present. */
static struct ttf_run_clock clock_of_past(const struct ttf_resume_input *in,
                                          const struct ttf_grid *grid, int64_t gaps_ns,
                                          int64_t slot0_utc_ns)
{
    struct ttf_run_clock clock = clock_of(in, grid, gaps_ns, TTF_NS_UNKNOWN);

    if (slot0_utc_ns != TTF_NS_UNKNOWN)
        clock.utc_offset_ns = ttf_near_difference_i64(slot0_utc_ns, clock.slot0_ns);
    return clock;
}

/* By how much two right clocks may differ: what they say themselves, what a system clock drifts by, and some seconds. */
static int64_t tolerance_ns(const struct ttf_run_past *past, const struct ttf_utc *utc)
{
    int64_t ns = TTF_BEHIND_NS + past->last_run_ns / TTF_BEHIND_DRIFT;

    if (past->last_uncertainty_ns > 0)
        ns = ttf_near_sum_i64(ns, past->last_uncertainty_ns);
    if (utc->uncertainty_ns > 0)
        ns = ttf_near_sum_i64(ns, utc->uncertainty_ns);
    return utc->trust == past->last_trust && ns < TTF_BEHIND_SAME_NS ? TTF_BEHIND_SAME_NS : ns;
}

/*
 * Of two of the box's own either may have been wrong, so one is heard again once it has come past that slot. A PC's against
 * them is what is wrong, and no less so for waiting: it would have had this boot begin before that slot. (Of a run that
 * has moved that slot may be of this boot.)
 */
static int64_t judged_at_ns(const struct ttf_run_past *past, const struct ttf_utc *utc)
{
    if (utc->trust == TTF_TRUST_HOST && past->last_trust > TTF_TRUST_HOST && !past->last_moved)
        return ttf_near_difference_i64(utc->utc_ns, utc->boot_ns);
    return utc->utc_ns;
}

bool ttf_resume_clock_behind(const struct ttf_run_past *past, const struct ttf_utc *utc)
{
    return utc->trust != TTF_TRUST_NONE && utc->trust <= past->last_trust &&
           judged_at_ns(past, utc) <
               ttf_near_difference_i64(past->last_utc_ns - past->last_ahead_ns,
                                       tolerance_ns(past, utc));
}

struct ttf_utc ttf_resume_utc(const struct ttf_run_past *past, const struct ttf_utc *now)
{
    struct ttf_utc utc = *now;

    if (ttf_resume_clock_behind(past, now)) {
        utc.trust = TTF_TRUST_NONE;
        utc.uncertainty_ns = TTF_NS_UNKNOWN;
    }
    return best_of(past, &utc);
}

/*
 * The same without a clock that is believed. One of the box's own that is not, as it contradicts another of the same
 * trust, takes time back from slots that were given up by that one: which of the two was wrong nobody knows, and a
 * run that goes on too long loses nothing.
 */
static int64_t gaps_by_past(const struct ttf_resume_input *in, const struct ttf_resume *r)
{
    const struct ttf_utc *utc = &in->utc;
    const int64_t gaps_ns = gaps_by(in, &r->grid, &r->outage, TTF_TRUST_NONE, TTF_NS_UNKNOWN);
    const int64_t slot0_ns = ttf_near_difference_i64(r->grid.origin_ns, in->elapsed_ns);
    int64_t other_ns;

    if (utc->trust != in->past.last_trust || !ttf_resume_clock_behind(&in->past, utc))
        return gaps_ns;
    other_ns = gaps_by(in, &r->grid, &r->outage, utc->trust,
                       ttf_near_sum_i64(slot0_ns, utc->utc_ns - utc->boot_ns));
    return other_ns < gaps_ns ? other_ns : gaps_ns;
}

/* What was known before: what a PC alone said counts where nobody else said anything, and as long as the end has not passed by it. */
static void resolve_end_by_past(const struct ttf_resume_input *in, struct ttf_resume *r)
{
    const struct ttf_run_past *past = &in->past;
    const int64_t gaps_ns = gaps_by_past(in, r);

    if (past->sure_slot0_utc_ns == TTF_NS_UNKNOWN) {
        r->clock = clock_of_past(in, &r->grid, gaps_ns, past->slot0_utc_ns);
        if (ttf_run_clock_believed(in->plan, &r->grid, r->grid.first_index, &r->clock, true))
            return;
    }
    r->clock = clock_of_past(in, &r->grid, gaps_ns, past->sure_slot0_utc_ns);
}

/*
 * By what the run ends: the UTC that labels it; else what was known before, as if there had been no outage, or only such as are known.
 * What a PC alone says counts as long as it does not say that the end has passed.
 */
static void resolve_end(const struct ttf_resume_input *in, struct ttf_resume *r)
{
    const int64_t index = r->grid.first_index;
    bool believed;

    r->clock = clock_of_boot(in, &r->grid, &r->outage);
    believed = !r->pc_gives_up && r->clock.trust != TTF_TRUST_NONE &&
               ttf_run_clock_believed(in->plan, &r->grid, index, &r->clock,
                                      r->continued && r->clock.trust == TTF_TRUST_HOST);
    if (!believed)
        resolve_end_by_past(in, r);
    r->end_passed = ttf_plan_end_passed(in->plan, &r->grid, index, &r->clock);
    r->count = ttf_plan_slots(in->plan, &r->grid, &r->clock);
    /* It had ended: a clock that says otherwise now adds nothing. */
    if (in->state->sealed && in->same_plan && ttf_plan_ends_in_time(in->plan))
        r->count = index;
}

/*
 * A PC's word alone would give up every slot that is left: more likely the PC's clock is ahead than that the box was
 * without power until after its end. Nothing is given up for that. Nor for what one said before the outage, by which
 * a clock that was behind looks like a long one: but for an instant that a better one tells now.
 */
static bool gives_up_all(const struct ttf_resume_input *in, const struct ttf_grid *grid)
{
    struct ttf_run_clock clock = clock_of_boot(in, grid, &(struct ttf_outage){0});
    const bool host_before = ttf_segment_trust(&in->state->last_segment) == TTF_TRUST_HOST;

    return (in->utc.trust == TTF_TRUST_HOST || (host_before && in->plan->end != TTF_END_UNTIL)) &&
           ttf_grid_index_at(grid, in->ready_ns) >= ttf_plan_slots(in->plan, grid, &clock);
}

/* No slot has come yet, and the first one is to come at an instant: however long that takes, and whatever is lost of it. */
static bool waits_for_start(const struct ttf_resume_input *in)
{
    return in->state->next_index == 0 && in->start_utc_ns != 0;
}

/*
 * Whether the next slot is further off than one that is to come, however clocks of one trust differ: by a clock that was
 * ahead those before it were given up, or slot 0 was begun. Pictures of hours or years would be lost by waiting for it.
 */
static bool waits_in_vain(const struct ttf_resume_input *in, const struct ttf_utc *utc,
                          int64_t due_ns)
{
    const int64_t wait_ns = ttf_near_difference_i64(due_ns, in->ready_ns);
    const int64_t late_ns = ttf_near_difference_i64(wait_ns, in->state->last_segment.interval_ns);

    return late_ns > TTF_BEHIND_SAME_NS && late_ns > tolerance_ns(&in->past, utc);
}

/*
 * When the last slot was due that was taken. Those that a resume gave up while its lamps settled were recorded before
 * they were due: a clock that has not come to them yet is not wrong for that. Nor is it for where the last segment's
 * grid would have had slots of before that segment, if none of it was taken: that one may have begun off the grid.
 */
static int64_t last_taken_utc_ns(const struct ttf_resume_input *in)
{
    const struct ttf_segment *last = &in->state->last_segment;
    const struct ttf_grid utc = utc_grid_of(last);
    const int64_t index = in->state->next_index - 1 - in->state->lost_at_end;

    if (index >= last->first_index)
        return ttf_grid_due_ns(&utc, index);
    return in->past.last_trust == TTF_TRUST_NONE ? TTF_NS_UNKNOWN : in->past.last_utc_ns;
}

/*
 * The grid of a boot before, found again through UTC that is vouched for then and now. A clock that is believed though
 * it stands before the last slot makes the next one come that much later: by less than an interval, and by no more
 * than right clocks differ, or the grid is not worth it.
 */
static bool finds_grid(const struct ttf_resume_input *in, const struct ttf_utc *utc,
                       struct ttf_resume *r)
{
    const struct ttf_segment *last = &in->state->last_segment;
    const int64_t next = in->state->next_index;
    const struct ttf_grid before_utc = utc_grid_of(last);
    const int64_t now_utc = utc->utc_ns + (in->now_ns - utc->boot_ns);
    const int64_t last_utc = last_taken_utc_ns(in);
    const int64_t early_ns = ttf_near_difference_i64(last_utc, now_utc + in->past.last_ahead_ns);

    r->grid.origin_ns = ttf_near_sum_i64(
        utc->boot_ns, ttf_near_difference_i64(ttf_grid_due_ns(&before_utc, next), utc->utc_ns));
    if (last_utc != TTF_NS_UNKNOWN)
        r->outage_ns = ttf_near_difference_i64(now_utc, last_utc);
    if (waits_for_start(in))
        return true;
    r->pc_gives_up = gives_up_all(in, &r->grid);
    r->waits_in_vain = !r->pc_gives_up && waits_in_vain(in, utc, r->grid.origin_ns);
    if (r->pc_gives_up || r->waits_in_vain)
        return false;
    return next == 0 || last_utc == TTF_NS_UNKNOWN ||
           (early_ns < last->interval_ns && early_ns <= tolerance_ns(&in->past, utc));
}

/* What is left of the slots that were due before this boot. */
static int64_t given_up_ns(const struct ttf_resume_input *in, const struct ttf_grid *grid)
{
    return ttf_timeline_given_up_ns(grid->origin_ns, grid->interval_ns,
                                    ttf_grid_index_at(grid, in->now_ns) - grid->first_index);
}

static void resolve_continued(const struct ttf_resume_input *in, struct ttf_resume *r)
{
    const struct ttf_segment *last = &in->state->last_segment;
    const struct ttf_utc utc = ttf_resume_utc(&in->past, &in->utc);
    int64_t next = in->state->next_index;
    struct ttf_grid before = grid_of(last);

    r->continued = true;
    r->grid.first_index = next;
    r->grid.interval_ns = in->plan->interval_ns;
    if (strcmp(last->boot_id, in->boot_id) == 0) {
        r->grid.origin_ns = ttf_grid_due_ns(&before, next);
        r->lost_result = TTF_RESULT_MISSED;
        r->lost_reason = in->state->sealed ? TTF_REASON_HAD_ENDED : TTF_REASON_NOT_RUNNING;
        r->on_grid = true;
        r->gap_ns = 0;
        r->outage_ns = in->now_ns - ttf_grid_due_ns(&before, next - 1);
        /* The run before this one in this boot came to an end before they had their records. */
        if (in->past.behind_outage)
            r->outage.given_up_ns = given_up_ns(in, &r->grid);
        return;
    }
    if (utc.trust != TTF_TRUST_NONE && vouched(last) && finds_grid(in, &utc, r)) {
        /* A run that had ended was not cut short: the box may have been put away, or not. */
        r->lost_result = in->state->sealed ? TTF_RESULT_MISSED : TTF_RESULT_POWER;
        r->lost_reason = in->state->sealed ? TTF_REASON_HAD_ENDED : TTF_REASON_NO_POWER;
        r->on_grid = true;
        r->gap_ns = 0;
        r->outage.given_up_ns = given_up_ns(in, &r->grid);
        return;
    }
    r->clock_implausible = in->utc.trust != TTF_TRUST_NONE && vouched(last);
    r->outage_ns = TTF_NS_UNKNOWN;
    r->grid.origin_ns = in->ready_ns;
    r->gap_ns = TTF_NS_UNKNOWN;
    r->outage.gap_unknown = true;
}

int ttf_resume_resolve(const struct ttf_resume_input *in, struct ttf_resume *ret,
                       struct ttf_err *err)
{
    struct ttf_resume r = {.outage_ns = TTF_NS_UNKNOWN, .lost_result = TTF_RESULT_MISSED};

    if (in->state->n_segments > 0) {
        resolve_continued(in, &r);
    } else {
        int e = resolve_new(in, &r, err);

        if (e < 0)
            return e;
    }
    resolve_end(in, &r);
    r.lost_until = ttf_grid_index_at(&r.grid, in->ready_ns);
    if (r.lost_until > r.count)
        r.lost_until = r.count;
    if (r.lost_until < r.grid.first_index)
        r.lost_until = r.grid.first_index;
    r.unready_from = r.continued ? ttf_grid_index_at(&r.grid, in->now_ns) : r.lost_until;
    if (r.unready_from > r.lost_until)
        r.unready_from = r.lost_until;
    if (r.unready_from < r.grid.first_index)
        r.unready_from = r.grid.first_index;
    if (r.continued && !in->state->sealed)
        r.absence = in->absence;
    *ret = r;
    return 0;
}

const char *ttf_resume_lost(const struct ttf_resume *r, int64_t index, enum ttf_result *ret_result)
{
    int64_t due_ns = ttf_grid_due_ns(&r->grid, index);
    const struct ttf_absence *a = &r->absence;

    *ret_result = TTF_RESULT_MISSED;
    if (index >= r->unready_from)
        return TTF_REASON_NOT_READY;
    for (unsigned i = 0; i < a->n_stops; i++)
        if (due_ns >= a->stops[i].from_ns && due_ns < a->stops[i].until_ns)
            return TTF_REASON_STOPPED;
    if (a->trying_since_ns > 0 && due_ns >= a->trying_since_ns)
        return TTF_REASON_TRYING;
    /* Gone on with by a program that was there: its cameras and the dataset were being made ready. */
    if (a->n_stops > 0 && due_ns >= a->stops[a->n_stops - 1].until_ns)
        return TTF_REASON_NOT_READY;
    *ret_result = r->lost_result;
    return r->lost_reason;
}

int64_t ttf_resume_gap_ns(const struct ttf_segment *before, int64_t first_index,
                          int64_t origin_utc_ns)
{
    struct ttf_grid grid = utc_grid_of(before);
    int64_t gap;

    if (!vouched(before) || origin_utc_ns == TTF_NS_UNKNOWN)
        return TTF_NS_UNKNOWN;
    gap = ttf_near_difference_i64(origin_utc_ns, ttf_grid_due_ns(&grid, first_index));
    if (gap < -before->interval_ns)
        return TTF_NS_UNKNOWN;
    return gap > 0 ? gap : 0;
}
