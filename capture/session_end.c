/* SPDX-License-Identifier: Apache-2.0 */
/* How many slots a living run comes to, as its clock becomes better known, and why it has ended. Loop thread. */
#include "session_private.h"

static void tell(struct ttf_session *s, int64_t before, int64_t index)
{
    if (s->plan.count != before)
        ttf_events_emit_end(&s->events, s->plan.count, "plan",
                            "%lld slots instead of %lld%s: the clock was corrected",
                            (long long)s->plan.count, (long long)before,
                            s->plan.count == index ? ", the plan's end has come" : "");
}

/* A clock that contradicts one of before moves no end, but may say that slots were given up by that one: too long loses nothing. */
static bool takes_slots_back(struct ttf_session *s, int64_t gaps_ns)
{
    if (gaps_ns >= s->run.gaps_ns)
        return false;
    s->run.gaps_ns = gaps_ns;
    return s->plan.end == TTF_END_LENGTH;
}

static void count_anew(struct ttf_session *s, int64_t index)
{
    const struct ttf_segment *segment = &s->pulse.segment;
    struct ttf_run_clock clock = s->run;
    enum ttf_trust trust = ttf_segment_trust(segment);
    int64_t before = s->plan.count;
    const int64_t now_ns = ttf_clock_now_ns(s->box->clock);
    const struct ttf_utc utc = {.boot_ns = now_ns,
                                .utc_ns = ttf_pulse_utc_at(&s->pulse, now_ns),
                                .uncertainty_ns = segment->uncertainty_ns,
                                .trust = trust};

    clock.trust = trust;
    clock.utc_offset_ns = segment->origin_utc_ns - segment->origin_ns;
    clock.gaps_ns = ttf_timeline_gaps_ns(&s->past, segment, &s->resume.outage,
                                         clock.slot0_ns + clock.utc_offset_ns);
    if (ttf_resume_clock_behind(&s->past, &utc)) {
        if (!takes_slots_back(s, clock.gaps_ns))
            ttf_events_emit(
                &s->events, "plan",
                "UTC lies before the last slot of before: the plan's end is not moved by it");
        if (s->plan.end != TTF_END_LENGTH)
            return;
        clock = s->run;
    }
    if (!ttf_run_clock_believed(&s->plan, &s->grid, index, &clock, trust == TTF_TRUST_HOST)) {
        ttf_events_emit(&s->events, "plan",
                        "a PC's clock says that the plan's end has passed: not believed alone");
        return;
    }
    s->run = clock;
    s->plan.count = ttf_plan_slots(&s->plan, &s->grid, &s->run);
    if (s->plan.count < index) /* they have their records, whatever the clock says now */
        s->plan.count = index;
    tell(s, before, index);
}

bool ttf_session_has_slot(struct ttf_session *s, int64_t index)
{
    /* Also of a plan of so many slots: one that ends in time may take its place. */
    if (s->pulse.corrected)
        count_anew(s, index);
    s->pulse.corrected = false;
    return index < s->plan.count;
}

/* A change of plan was the end of it: no slot came after it. */
static bool ended_at_once(const struct ttf_session *s)
{
    const struct ttf_writer_state *state = ttf_writer_state(s->committer.writer);

    return state->n_segments > 0 && state->last_segment.first_index >= s->plan.count;
}

const char *ttf_session_end_reason(const struct ttf_session *s)
{
    if (ttf_plan_ends_in_time(&s->plan))
        return "until";
    return ended_at_once(s) ? "stopped" : "count";
}
