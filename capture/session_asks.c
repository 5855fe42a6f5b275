/* SPDX-License-Identifier: Apache-2.0 */
/* What people ask of a run that lives (ttf/capture/control.h). Loop thread. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "asks.h"
#include "plan_change.h"
#include "session_private.h"

/* From hearing of another interval to the first lamp command on the new grid. */
#define READY_MARGIN_NS TTF_NS_PER_S

/* What a plan is to become. */
struct changed {
    struct ttf_plan plan;
    struct ttf_grid grid;
    struct ttf_run_clock run;
    struct ttf_plan_figures figures;
};

static bool same_end(const struct ttf_plan *a, const struct ttf_plan *b)
{
    return a->end == b->end && a->until_utc_ns == b->until_utc_ns && a->length_ns == b->length_ns;
}

/* Where the interval was changed, and no slot has come by that yet, the one before `index` is of the grid before. */
static const struct ttf_grid *grid_of_last(const struct ttf_session *s, int64_t index)
{
    return s->grid.first_index == index ? &s->grid_before : &s->grid;
}

/*
 * Slots of an end that nobody knows when it comes, of a shorter interval: as many as take the time that those left were to take. Not fewer: in doubt
 * a run goes on too long, and the clock that tells counts anew.
 */
static int64_t count_in_doubt(const struct ttf_session *s, const struct ttf_plan *to, int64_t index)
{
    int64_t left = s->plan.count - index, time_ns;

    if (left <= 0 || to->interval_ns >= s->plan.interval_ns ||
        __builtin_mul_overflow(left, s->plan.interval_ns, &time_ns))
        return s->plan.count;
    return index + (time_ns + to->interval_ns - 1) / to->interval_ns;
}

/* An instant that is new means what the clock says now, or a better one said before in this boot. */
static int count_until(const struct ttf_session *s, struct changed *to, int64_t index,
                       struct ttf_err *err)
{
    const bool is_new = !same_end(&to->plan, &s->plan);
    struct ttf_utc utc;

    ttf_clock_utc(s->box->clock, &utc);
    if (is_new && to->plan.end == TTF_END_UNTIL && utc.trust == TTF_TRUST_NONE)
        return ttf_err_set(err, -EINVAL, "until",
                           "nobody vouches for this box's clock, so an instant means nothing");
    if (is_new && to->plan.end == TTF_END_UNTIL && utc.trust >= to->run.trust) {
        if (ttf_resume_clock_behind(&s->past, &utc))
            return ttf_err_set(err, -EINVAL, "until",
                               "this box's clock stands before the last slot of before it had "
                               "power again, so an instant means nothing");
        to->run.utc_offset_ns = utc.utc_ns - utc.boot_ns;
        to->run.trust = utc.trust;
    }
    if (is_new && ttf_plan_end_passed(&to->plan, grid_of_last(s, index), index, &to->run))
        return ttf_err_set(err, -EINVAL, "until", "%lld slots have their records already",
                           (long long)index);
    /* What another end, or another grid, came to is no count that a corrected clock would leave as it is. */
    if (ttf_plan_end_ns(&to->plan, &to->run) == TTF_NS_UNKNOWN)
        to->plan.count = count_in_doubt(s, &to->plan, index);
    else if (is_new || to->plan.interval_ns != s->plan.interval_ns)
        to->plan.count = -1;
    to->plan.count = ttf_plan_slots(&to->plan, &to->grid, &to->run);
    return 0;
}

/* From slot `index` on: one new interval after the slot before it, as if no other change had come in between. */
static struct ttf_grid grid_with(const struct ttf_session *s, int64_t index, int64_t interval_ns)
{
    int64_t ready_ns = ttf_clock_now_ns(s->box->clock) + s->lead_ns + READY_MARGIN_NS;
    struct ttf_grid grid = s->grid;

    if (index > 0 && grid.first_index == index && grid.interval_ns != interval_ns)
        grid = (struct ttf_grid){index - 1, ttf_grid_due_ns(grid_of_last(s, index), index - 1), 0};
    return ttf_grid_changed(&grid, index, interval_ns, ready_ns);
}

static int changed_plan(const struct ttf_session *s, const struct ttf_ask *ask, int64_t index,
                        struct changed *ret, struct ttf_err *err)
{
    struct changed to = {.run = s->run};
    int r = ttf_plan_changed(&s->plan, ask, index, &to.plan, err);

    if (r < 0)
        return r;
    to.grid = grid_with(s, index, to.plan.interval_ns);
    if (ttf_plan_ends_in_time(&to.plan))
        r = count_until(s, &to, index, err);
    if (r == 0)
        r = ttf_plan_check(&to.plan, s->box, &to.figures, err);
    if (r == 0)
        *ret = to;
    return r;
}

/* The segment that the changed plan begins. Its UTC is that of the one before: the same boot, the same clock. */
static void next_segment(const struct ttf_session *s, const struct ttf_grid *grid,
                         struct ttf_segment *ret)
{
    *ret = s->pulse.segment;
    ret->segment = s->segment + 1;
    ret->first_index = grid->first_index;
    ret->origin_ns = grid->origin_ns;
    ret->interval_ns = grid->interval_ns;
    if (ret->origin_utc_ns != TTF_NS_UNKNOWN)
        ret->origin_utc_ns += grid->origin_ns - s->pulse.segment.origin_ns;
    ret->plan = s->next_plan;
    ret->gap_ns = 0;
    ret->run_ns = ret->run_utc_ns = 0; /* the first one says it */
    ret->corrects = false;
}

static void adopt(struct ttf_session *s, const struct changed *to,
                  const struct ttf_segment *segment)
{
    s->plan = to->plan;
    s->figures = to->figures;
    if (to->grid.first_index > s->grid.first_index)
        s->grid_before = s->grid;
    s->grid = to->grid;
    s->run = to->run;
    s->segment = segment->segment;
    s->next_plan++;
    ttf_pulse_next_segment(&s->pulse, segment);
}

static void tell_change(struct ttf_session *s, const struct ttf_plan *before, int64_t index)
{
    const struct ttf_plan *plan = &s->plan;
    char what[120];
    int n = 0;

    what[0] = '\0';
    if (plan->interval_ns != before->interval_ns)
        n += snprintf(what, sizeof(what), ", interval %g s instead of %g s",
                      (double)plan->interval_ns / 1e9, (double)before->interval_ns / 1e9);
    if (plan->count != before->count)
        n += snprintf(what + n, sizeof(what) - (size_t)n, ", %lld slots instead of %lld",
                      (long long)plan->count, (long long)before->count);
    if (plan->day_ns != before->day_ns || plan->period_ns != before->period_ns ||
        plan->phase_ns != before->phase_ns)
        snprintf(what + n, sizeof(what) - (size_t)n, ", another photoperiod");
    ttf_events_emit(&s->events, "plan", "plan %d is in force from slot %lld on%s",
                    s->pulse.segment.plan, (long long)index, what);
}

/* A day that begins at the same local time is where it was: it is resolved once, and no clock moves it. */
static bool same_local_day(const struct ttf_plan *a, const struct ttf_plan *b)
{
    return a->lamps == TTF_LAMPS_PHOTOPERIOD && b->lamps == TTF_LAMPS_PHOTOPERIOD &&
           a->photoperiod_local && b->photoperiod_local && a->day_start_s == b->day_start_s &&
           strcmp(a->zone, b->zone) == 0;
}

/* Everything is made before anything is changed: what fails leaves the old plan in force. */
static int change_plan(struct ttf_session *s, const struct ttf_ask *ask, int64_t number,
                       int64_t index, struct ttf_err *err)
{
    const struct ttf_plan before = s->plan;
    struct ttf_lamp_programme programme;
    struct ttf_plan_change *change;
    struct ttf_segment segment;
    struct changed to = {0};
    int r = changed_plan(s, ask, index, &to, err);

    if (r == 0 && same_local_day(&to.plan, &before))
        to.plan.phase_ns = before.phase_ns;
    else if (r == 0)
        r = ttf_session_resolve_phase(&to.plan, ttf_pulse_utc_at(&s->pulse, s->run.slot0_ns), err);
    if (r == 0)
        r = ttf_lamp_programme_init(&programme, &to.plan, s->box->lamps, s->run.slot0_ns, err);
    if (r < 0)
        return r;
    programme.begin_ns = s->programme.begin_ns;
    change = ttf_plan_change_new(&to.plan, ask->kind == TTF_ASK_PLAN ? ask->plan_yaml : NULL);
    if (!change)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    change->ask = number;
    change->slot_bytes = to.figures.slot_bytes;
    next_segment(s, &to.grid, &segment);
    change->segment = segment;
    r = ttf_session_hand_over_change(s, change);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory");
    s->programme = programme;
    adopt(s, &to, &segment);
    tell_change(s, &before, index);
    return 0;
}

static int take_note(struct ttf_session *s, struct ttf_note *note, int64_t number,
                     struct ttf_err *err)
{
    struct ttf_job *job;
    int r = ttf_note_check(note, err);

    if (r < 0)
        return r;
    job = ttf_job_new(&s->queue, TTF_JOB_NOTE);
    if (!job)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    if (note->utc_ns == TTF_NS_UNKNOWN)
        note->utc_ns = ttf_pulse_utc_at(&s->pulse, ttf_clock_now_ns(s->box->clock));
    job->note = note;
    job->ask = number;
    ttf_queue_push(&s->queue, job);
    return 0;
}

static void pause_run(struct ttf_session *s, const struct ttf_ask *ask, int64_t index)
{
    s->paused = true;
    snprintf(s->pause_reason, sizeof(s->pause_reason), "%s",
             ask->reason[0] ? ask->reason : TTF_REASON_PAUSED);
    ttf_events_emit(&s->events, "pause", "from slot %lld on: %s", (long long)index,
                    s->pause_reason);
}

static void continue_run(struct ttf_session *s, int64_t index)
{
    if (s->paused)
        ttf_events_emit(&s->events, "pause", "over: slot %lld is captured again", (long long)index);
    s->paused = false;
}

/* One ask. 0; -ECANCELED: to stop. What is on its way to the disk is answered when it is there. */
static int obey(struct ttf_session *s, struct ttf_ask *ask, int64_t number, int64_t index)
{
    struct ttf_err err = {0};
    bool answer = true;
    int r = 0;

    switch (ask->kind) {
    case TTF_ASK_STOP:
        ttf_asks_answer(s->config->control, number, 0, NULL);
        return -ECANCELED;
    case TTF_ASK_PAUSE:
        pause_run(s, ask, index);
        break;
    case TTF_ASK_CONTINUE:
        continue_run(s, index);
        break;
    case TTF_ASK_NOTE:
        r = take_note(s, &ask->note, number, &err);
        answer = r < 0;
        break;
    default:
        r = change_plan(s, ask, number, index, &err);
        answer = r < 0;
        break;
    }
    if (answer)
        ttf_asks_answer(s->config->control, number, r, &err);
    return 0;
}

int ttf_session_hear(struct ttf_session *s, int64_t index)
{
    struct ttf_ask *ask;
    int64_t number = 0;
    int r = 0;

    s->pulse.next_index = index;
    while (r == 0 && (ask = ttf_asks_take(s->config->control, index, &number)))
        r = obey(s, ask, number, index);
    return r;
}
