/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>

#include "ledger.h"
#include "resume.h"

#define UTC0 (INT64_C(1700000000) * TTF_NS_PER_S)

/* Ten slots of a minute done, begun at boot clock 100 s = UTC0. */
static struct ttf_writer_state ten_slots_done(void)
{
    struct ttf_writer_state s = {.next_index = 10, .n_segments = 1};

    s.last_segment.first_index = 0;
    s.last_segment.origin_ns = 100 * TTF_NS_PER_S;
    s.last_segment.origin_utc_ns = UTC0;
    s.last_segment.interval_ns = TTF_NS_PER_MIN;
    snprintf(s.last_segment.boot_id, sizeof(s.last_segment.boot_id), "first-boot");
    snprintf(s.last_segment.trust, sizeof(s.last_segment.trust), "rtc");
    return s;
}

static const struct ttf_plan BY_COUNT = {.interval_ns = TTF_NS_PER_MIN, .count = 1000};

/* A new boot, 5 s old, when UTC is utc_ns; of a run as ten_slots_done. */
static struct ttf_resume_input boot(const struct ttf_writer_state *state, int64_t utc_ns,
                                    enum ttf_trust trust)
{
    struct ttf_resume_input in = {
        .state = state,
        .boot_id = "second-boot",
        .utc = {.boot_ns = 5 * TTF_NS_PER_S, .utc_ns = utc_ns, .trust = trust},
        .now_ns = 5 * TTF_NS_PER_S,
        .ready_ns = 8 * TTF_NS_PER_S,
        .plan = &BY_COUNT,
        .same_plan = true,
        .past = {.slot0_utc_ns = TTF_NS_UNKNOWN, .sure_slot0_utc_ns = TTF_NS_UNKNOWN},
    };

    if (state->n_segments > 0) {
        in.elapsed_ns = state->next_index * TTF_NS_PER_MIN;
        in.past.slot0_utc_ns = in.past.sure_slot0_utc_ns = UTC0;
    }

    return in;
}

static void a_new_run_begins_as_soon_as_it_is_ready(void **state)
{
    struct ttf_writer_state none = {0};
    struct ttf_resume_input in = boot(&none, UTC0, TTF_TRUST_NONE);
    struct ttf_resume r;

    (void)state;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.grid.first_index, 0);
    assert_int_equal(r.grid.origin_ns, in.ready_ns);
    assert_int_equal(r.lost_until, 0);
    assert_false(r.continued);
}

static void a_pcs_word_alone_gives_up_no_run(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in = boot(&done, UTC0 + 365 * TTF_NS_PER_DAY, TTF_TRUST_HOST);
    struct ttf_resume r;

    (void)state;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_true(r.clock_implausible);
    assert_int_equal(r.lost_until, r.grid.first_index); /* nothing is lost to a PC's calendar */
    assert_int_equal(r.gap_ns, TTF_NS_UNKNOWN);
    in.utc.trust = TTF_TRUST_NTP; /* a synchronised clock is believed */
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_false(r.clock_implausible);
    assert_int_equal(r.lost_until, BY_COUNT.count);
}

/* What one said before the outage is not worth more: by a clock that was behind the outage looks like a long one. */
static void what_a_pc_said_before_gives_up_no_run_either(void **state)
{
    static const enum ttf_trust now[] = {TTF_TRUST_HOST, TTF_TRUST_RTC, TTF_TRUST_NTP};
    static const int64_t day_ns = TTF_NS_PER_DAY;

    (void)state;
    for (unsigned i = 0; i < 6; i++) {
        struct ttf_writer_state done = ten_slots_done();
        struct ttf_resume_input in = boot(&done, UTC0 + 365 * day_ns, now[i % 3]);
        struct ttf_plan plan = BY_COUNT;
        struct ttf_resume r;

        in.plan = &plan;
        snprintf(done.last_segment.trust, sizeof(done.last_segment.trust), "host");
        in.past.sure_slot0_utc_ns = TTF_NS_UNKNOWN;
        if (i >= 3) /* nor where no slot was taken */
            in.elapsed_ns = done.next_index = 0;
        assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
        assert_true(r.pc_gives_up);
        assert_int_equal(r.lost_until, done.next_index);
        assert_int_equal(r.count, BY_COUNT.count);
        assert_int_equal(r.grid.origin_ns, in.ready_ns);
        in.utc.utc_ns = UTC0 + 12 * TTF_NS_PER_MIN; /* it is believed of an outage */
        assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
        assert_true(r.on_grid);
        in.utc.utc_ns = UTC0 + 365 * day_ns;
        plan.end = TTF_END_UNTIL; /* the present tells such an end, if it is not a PC's word */
        plan.until_utc_ns = UTC0 + 364 * day_ns;
        if (now[i % 3] == TTF_TRUST_HOST || done.next_index == 0)
            continue;
        assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
        assert_true(r.end_passed || r.lost_until == r.count);
    }
}

static void a_start_time_lies_where_utc_says(void **state)
{
    struct ttf_writer_state none = {0};
    struct ttf_resume_input in = boot(&none, UTC0, TTF_TRUST_NTP);
    struct ttf_resume r;

    (void)state;
    in.start_utc_ns = UTC0 + TTF_NS_PER_H;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.grid.origin_ns, 5 * TTF_NS_PER_S + TTF_NS_PER_H);
    in.start_utc_ns = UTC0 - 150 * TTF_NS_PER_S;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.lost_until, 3);
    assert_int_equal(r.lost_result, TTF_RESULT_MISSED);
}

static void a_start_time_needs_a_clock_somebody_vouches_for(void **state)
{
    struct ttf_writer_state none = {0};
    struct ttf_resume_input in = boot(&none, UTC0, TTF_TRUST_NONE);
    struct ttf_resume r;
    struct ttf_err err;

    (void)state;
    in.start_utc_ns = UTC0 + TTF_NS_PER_H;
    assert_int_equal(ttf_resume_resolve(&in, &r, &err), -EINVAL);
    assert_string_equal(err.where, "start");
}

static void a_trusted_clock_rejoins_the_grid_and_names_the_outage(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    /* Slot 10 was due at UTC0 + 600 s; it is 25 s after slot 12. */
    struct ttf_resume_input in = boot(&done, UTC0 + (12 * 60 + 25) * TTF_NS_PER_S, TTF_TRUST_RTC);
    struct ttf_resume r;

    (void)state;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_true(r.on_grid);
    assert_int_equal(r.grid.first_index, 10);
    assert_int_equal(r.lost_until, 13);
    assert_int_equal(r.lost_result, TTF_RESULT_POWER);
    assert_int_equal(r.gap_ns, 0);
    assert_int_equal(ttf_grid_due_ns(&r.grid, 13), (5 + 35) * TTF_NS_PER_S);
}

static void the_same_boot_needs_no_utc(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in = boot(&done, 0, TTF_TRUST_NONE);
    struct ttf_resume r;

    (void)state;
    in.boot_id = "first-boot";
    in.now_ns = (100 + 11 * 60 + 1) * TTF_NS_PER_S;
    in.ready_ns = in.now_ns + 2 * TTF_NS_PER_S;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.grid.origin_ns, (100 + 10 * 60) * TTF_NS_PER_S);
    assert_int_equal(r.lost_until, 12);
    assert_int_equal(r.lost_result, TTF_RESULT_MISSED);
    assert_string_equal(r.lost_reason, TTF_REASON_NOT_RUNNING);
}

static const char *lost(const struct ttf_resume *r, int64_t index, enum ttf_result result)
{
    enum ttf_result got;
    const char *reason = ttf_resume_lost(r, index, &got);

    assert_int_equal(got, result);
    return reason;
}

static void what_a_person_stopped_and_what_was_tried_in_vain_is_said_so(void **state)
{
    const int64_t slot10_ns = (100 + 10 * 60) * TTF_NS_PER_S;
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in = boot(&done, 0, TTF_TRUST_NONE);
    struct ttf_resume r;

    (void)state;
    in.boot_id = "first-boot";
    in.now_ns = slot10_ns + 5 * TTF_NS_PER_MIN + TTF_NS_PER_S;
    in.ready_ns = in.now_ns + TTF_NS_PER_MIN;
    /* Not running for slot 10; stopped by a person during 11 and 12, and once more during 14; else the guardian was away. */
    in.absence.n_stops = 2;
    in.absence.stops[0].from_ns = slot10_ns + 1;
    in.absence.stops[0].until_ns = slot10_ns + 3 * TTF_NS_PER_MIN;
    in.absence.stops[1].from_ns = slot10_ns + 4 * TTF_NS_PER_MIN;
    in.absence.stops[1].until_ns = slot10_ns + 5 * TTF_NS_PER_MIN;
    in.absence.trying_since_ns = in.absence.stops[0].until_ns;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.lost_until, 17);
    assert_string_equal(lost(&r, 10, TTF_RESULT_MISSED), TTF_REASON_NOT_RUNNING);
    assert_string_equal(lost(&r, 11, TTF_RESULT_MISSED), TTF_REASON_STOPPED);
    assert_string_equal(lost(&r, 12, TTF_RESULT_MISSED), TTF_REASON_STOPPED);
    assert_string_equal(lost(&r, 13, TTF_RESULT_MISSED), TTF_REASON_TRYING);
    assert_string_equal(lost(&r, 14, TTF_RESULT_MISSED), TTF_REASON_STOPPED);
    assert_string_equal(lost(&r, 15, TTF_RESULT_MISSED), TTF_REASON_TRYING);
    assert_string_equal(lost(&r, 16, TTF_RESULT_MISSED), TTF_REASON_NOT_READY);
    done.sealed = true; /* nobody could stop it any more */
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_string_equal(lost(&r, 11, TTF_RESULT_MISSED), TTF_REASON_HAD_ENDED);
}

static void a_stop_holds_over_a_boot_and_is_no_lack_of_power(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    /* Slot 12 passed before this boot, slot 13 is due 35 s from now: 20 s later a person goes on. */
    struct ttf_resume_input in = boot(&done, UTC0 + (12 * 60 + 25) * TTF_NS_PER_S, TTF_TRUST_RTC);
    struct ttf_resume r;

    (void)state;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_string_equal(lost(&r, 12, TTF_RESULT_POWER), TTF_REASON_NO_POWER);
    in.absence.n_stops = 1;
    in.absence.stops[0].from_ns = INT64_MIN;
    in.absence.stops[0].until_ns = in.now_ns;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_string_equal(lost(&r, 12, TTF_RESULT_MISSED), TTF_REASON_STOPPED);
}

static void what_is_due_while_a_box_gets_ready_behind_a_stop_did_not_lack_the_program(void **state)
{
    const int64_t slot10_ns = (100 + 10 * 60) * TTF_NS_PER_S;
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in = boot(&done, 0, TTF_TRUST_NONE);
    struct ttf_resume r;

    (void)state;
    in.boot_id = "first-boot";
    in.now_ns = slot10_ns + 3 * TTF_NS_PER_MIN + TTF_NS_PER_S; /* cameras are armed */
    in.ready_ns = in.now_ns + TTF_NS_PER_MIN;                  /* lamps have settled */
    in.absence.n_stops = 1;
    in.absence.stops[0].from_ns = slot10_ns + 1;
    in.absence.stops[0].until_ns = slot10_ns + 2 * TTF_NS_PER_MIN;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.lost_until, 15);
    assert_string_equal(lost(&r, 10, TTF_RESULT_MISSED), TTF_REASON_NOT_RUNNING);
    assert_string_equal(lost(&r, 11, TTF_RESULT_MISSED), TTF_REASON_STOPPED);
    assert_string_equal(lost(&r, 12, TTF_RESULT_MISSED), TTF_REASON_NOT_READY);
    assert_string_equal(lost(&r, 13, TTF_RESULT_MISSED), TTF_REASON_NOT_READY);
    assert_string_equal(lost(&r, 14, TTF_RESULT_MISSED), TTF_REASON_NOT_READY);
}

static void an_untrusted_clock_goes_on_at_once_with_the_gap_unknown(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in = boot(&done, UTC0 + TTF_NS_PER_DAY, TTF_TRUST_NONE);
    struct ttf_resume r;

    (void)state;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_false(r.on_grid);
    assert_int_equal(r.grid.first_index, 10);
    assert_int_equal(r.grid.origin_ns, in.ready_ns);
    assert_int_equal(r.lost_until, 10);
    assert_int_equal(r.gap_ns, TTF_NS_UNKNOWN);
}

static void a_clock_behind_the_last_slot_is_not_believed(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in = boot(&done, UTC0 - TTF_NS_PER_DAY, TTF_TRUST_RTC);
    struct ttf_resume r;

    (void)state;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_true(r.clock_implausible);
    assert_false(r.on_grid);
    assert_int_equal(r.lost_until, 10);
}

/* A resume gave up slots 4 to 9, five minutes ahead, and the power went again after two. */
static void slots_given_up_ahead_of_time_do_not_make_the_clock_wrong(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in = boot(&done, UTC0 + 6 * TTF_NS_PER_MIN, TTF_TRUST_RTC);
    struct ttf_resume r;

    (void)state;
    done.lost_at_end = 6;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_false(r.clock_implausible);
    assert_true(r.on_grid);
    assert_int_equal(r.lost_until, 10); /* nothing more is lost: slot 10 is to come */
    /* Before the last one that was taken it still is. */
    in.utc.utc_ns = UTC0 + 2 * TTF_NS_PER_MIN;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_true(r.clock_implausible);
}

/*
 * By a clock three hours ahead it gave up the slots until then, and the power went again before one was taken; or it
 * began by that clock and took none.
 */
static void no_slot_is_waited_for_that_a_clock_ahead_makes_the_next(void **state)
{
    static const enum ttf_trust now[] = {TTF_TRUST_HOST, TTF_TRUST_RTC, TTF_TRUST_NTP};

    (void)state;
    for (unsigned i = 0; i < 6; i++) {
        struct ttf_writer_state done = ten_slots_done();
        struct ttf_resume_input in = boot(&done, UTC0 + 6 * TTF_NS_PER_MIN, now[i % 3]);
        struct ttf_resume r;

        done.next_index = 184;
        done.lost_at_end = 180;
        if (i >= 3) {
            in.elapsed_ns = done.next_index = done.lost_at_end = 0;
            in.utc.utc_ns = UTC0 - 3 * TTF_NS_PER_H;
        }
        assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
        assert_false(r.on_grid);
        assert_int_equal(r.gap_ns, TTF_NS_UNKNOWN);
        assert_int_equal(r.grid.first_index, done.next_index);
        assert_int_equal(r.grid.origin_ns, in.ready_ns);
        assert_int_equal(r.lost_until, done.next_index);
        if (i < 3)
            continue;
        in.start_utc_ns = UTC0; /* a start is waited for */
        assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
        assert_true(r.on_grid);
        assert_int_equal(r.grid.origin_ns, in.now_ns + 3 * TTF_NS_PER_H);
    }
}

/* The power is back at 14:30 into the run; lamps settle until 17:00: slots 15 and 16 were not lost to the power. */
static void slots_that_pass_while_the_box_gets_ready_are_told_from_those_of_the_outage(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in =
        boot(&done, UTC0 + 14 * TTF_NS_PER_MIN + 30 * TTF_NS_PER_S, TTF_TRUST_RTC);
    struct ttf_resume r;

    (void)state;
    in.ready_ns = in.now_ns + 150 * TTF_NS_PER_S;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.grid.first_index, 10);
    assert_int_equal(r.unready_from, 15);
    assert_int_equal(r.lost_until, 17);
    assert_int_equal(r.lost_result, TTF_RESULT_POWER);
    /* None, if it is ready at once; all of them, if there was no outage to speak of. */
    in.ready_ns = in.now_ns;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.unready_from, r.lost_until);
    in.utc.utc_ns = UTC0 + 9 * TTF_NS_PER_MIN + 30 * TTF_NS_PER_S;
    in.ready_ns = in.now_ns + 150 * TTF_NS_PER_S;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.unready_from, 10);
    assert_int_equal(r.lost_until, 12);
}

static void an_outage_past_the_end_leaves_no_slot_unnamed(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in = boot(&done, UTC0 + 30 * TTF_NS_PER_DAY, TTF_TRUST_NTP);
    struct ttf_resume r;

    (void)state;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.lost_until, BY_COUNT.count);
}

/* Ten slots of the fifteen before UTC0 + 14:30. */
static const struct ttf_plan FIFTEEN = {.interval_ns = TTF_NS_PER_MIN,
                                        .count = 15,
                                        .end = TTF_END_UNTIL,
                                        .until_utc_ns = UTC0 + INT64_C(870) * TTF_NS_PER_S};

static void a_plan_that_ends_in_time_comes_to_what_the_clock_says(void **state)
{
    static const struct {
        enum ttf_trust trust, before;
        int64_t minutes, count;
    } cases[] = {
        {TTF_TRUST_NTP, TTF_TRUST_RTC, 12, 15},   /* on the same grid: the outage has slots */
        {TTF_TRUST_NONE, TTF_TRUST_RTC, 12, 15},  /* nobody knows: as if there had been none */
        {TTF_TRUST_NTP, TTF_TRUST_NONE, 12, 13},  /* at once, at 12:03 */
        {TTF_TRUST_NTP, TTF_TRUST_NONE, 20, 10},  /* over */
        {TTF_TRUST_HOST, TTF_TRUST_NONE, 12, 13}, /* a PC's clock that leaves slots counts, */
        {TTF_TRUST_HOST, TTF_TRUST_NONE, 20, 15}, /* and ends nothing: */
        {TTF_TRUST_HOST, TTF_TRUST_RTC, 14, 15},  /* one more at once, and none on the grid */
        {TTF_TRUST_RTC, TTF_TRUST_NTP, 5, 15},    /* behind the last slot: not believed, */
        {TTF_TRUST_NTP, TTF_TRUST_RTC, 5, 20},    /* unless it knows better: at once, at 5:03 */
    };

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct ttf_writer_state done = ten_slots_done();
        struct ttf_resume_input in =
            boot(&done, UTC0 + cases[i].minutes * TTF_NS_PER_MIN, cases[i].trust);
        struct ttf_resume r;

        in.plan = &FIFTEEN;
        snprintf(done.last_segment.trust, sizeof(done.last_segment.trust), "%s",
                 ttf_trust_name(cases[i].before));
        in.past.last_trust = cases[i].before;
        in.past.last_utc_ns = UTC0 + 9 * TTF_NS_PER_MIN;
        if (cases[i].before == TTF_TRUST_NONE)
            in.past.slot0_utc_ns = in.past.sure_slot0_utc_ns = TTF_NS_UNKNOWN;
        assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
        assert_int_equal(r.count, cases[i].count);
        assert_true(r.lost_until <= r.count);
        assert_int_equal(r.end_passed, cases[i].count == 10);
    }
}

/* What it said in an earlier boot is remembered, where nobody else said anything, and counts no more than it did then. */
static void what_a_pc_said_before_ends_nothing_either(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in = boot(&done, 0, TTF_TRUST_NONE);
    struct ttf_resume r;

    (void)state;
    in.plan = &FIFTEEN;
    in.past.sure_slot0_utc_ns = TTF_NS_UNKNOWN;
    in.past.slot0_utc_ns = UTC0 + TTF_NS_PER_DAY;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.count, 15);
    in.past.slot0_utc_ns = UTC0 + 3 * TTF_NS_PER_MIN; /* nor is that beyond belief */
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.count, 12);
    in.past.sure_slot0_utc_ns = UTC0; /* a better clock did */
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.count, 15);
    in.past.slot0_utc_ns = UTC0 - TTF_NS_PER_DAY; /* nor does one behind it add slots */
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.count, 15);
    in.past.sure_slot0_utc_ns = in.past.slot0_utc_ns =
        UTC0 + TTF_NS_PER_DAY; /* of a better clock */
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.count, 10);
}

/* NTP was there, the network went, the program began anew, and a PC offers its time. */
static void what_a_better_clock_said_in_this_boot_holds_against_a_pc(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in =
        boot(&done, UTC0 + 12 * TTF_NS_PER_MIN + 30 * TTF_NS_PER_S, TTF_TRUST_HOST);
    struct ttf_resume r;

    (void)state;
    in.plan = &FIFTEEN;
    in.boot_id = "first-boot";
    in.now_ns = in.utc.boot_ns = 700 * TTF_NS_PER_S; /* it is UTC0 + 10 min */
    in.ready_ns = in.now_ns;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.count, 12);
    assert_int_equal(r.clock.trust, TTF_TRUST_HOST);
    in.past.boot_trust = TTF_TRUST_NTP;
    in.past.boot_offset_ns = UTC0 - 100 * TTF_NS_PER_S;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.count, 15);
    assert_int_equal(r.clock.trust, TTF_TRUST_NTP);
    in.utc.trust = TTF_TRUST_NTP; /* its own again, and set */
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.count, 12);
}

/* The last slot that anybody knew of was at UTC0 + 9 min; the boot between knew nothing. */
static void a_clock_behind_the_last_slot_that_was_known_moves_no_end(void **state)
{
    static const struct {
        enum ttf_trust trust, last;
        int64_t minutes, count;
    } cases[] = {
        {TTF_TRUST_HOST, TTF_TRUST_NTP, 8, 15},  {TTF_TRUST_HOST, TTF_TRUST_NTP, 10, 15},
        {TTF_TRUST_HOST, TTF_TRUST_NTP, 12, 13}, {TTF_TRUST_NTP, TTF_TRUST_NTP, -7, 15},
        {TTF_TRUST_NTP, TTF_TRUST_NTP, -6, 31}, /* of the same trust: either may have been wrong */
        {TTF_TRUST_NTP, TTF_TRUST_HOST, 6, 19}, /* who knows better is believed */
        {TTF_TRUST_HOST, TTF_TRUST_NONE, 6, 19},
    };

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct ttf_writer_state done = ten_slots_done();
        struct ttf_resume_input in =
            boot(&done, UTC0 + cases[i].minutes * TTF_NS_PER_MIN, cases[i].trust);
        struct ttf_resume r;

        in.plan = &FIFTEEN;
        snprintf(done.last_segment.trust, sizeof(done.last_segment.trust), "none");
        in.past.last_trust = cases[i].last;
        in.past.last_utc_ns = UTC0 + 9 * TTF_NS_PER_MIN;
        assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
        assert_int_equal(r.count, cases[i].count);
    }
}

/*
 * One rule for what is believed of a clock, by whatever it stands before the last slot (UTC0 + 9 intervals). Believed, it
 * tells the end, and keeps the grid where the next slot comes less than an interval later by that.
 */
static void label_end_and_grid_go_by_the_same_clock(void **state)
{
    static const struct {
        enum ttf_trust trust, last;
        int64_t interval_s, earlier_s;
        bool on_grid;
        int64_t count; /* until UTC0 + 15 intervals and a half */
    } cases[] = {
        {TTF_TRUST_RTC, TTF_TRUST_RTC, 60, 0, true, 16},
        {TTF_TRUST_RTC, TTF_TRUST_RTC, 60, 45, true, 16},
        {TTF_TRUST_RTC, TTF_TRUST_RTC, 60, 60, false, 18}, /* at once */
        {TTF_TRUST_NTP, TTF_TRUST_NTP, 60, 600, false, 27},
        {TTF_TRUST_NTP, TTF_TRUST_NTP, 3600, 600, true, 16},
        {TTF_TRUST_NTP, TTF_TRUST_NTP, 3600, 901, false, 16}, /* not believed: by the past */
        {TTF_TRUST_RTC, TTF_TRUST_NTP, 3600, 10, true, 16},
        {TTF_TRUST_RTC, TTF_TRUST_NTP, 3600, 11, false, 16},
        {TTF_TRUST_NTP, TTF_TRUST_RTC, 60, 10, true, 16},
        {TTF_TRUST_NTP, TTF_TRUST_RTC, 60, 600, false, 27}, /* it knows better */
        {TTF_TRUST_NTP, TTF_TRUST_RTC, 3600, 3000, false, 18},
        {TTF_TRUST_HOST, TTF_TRUST_HOST, 60, 600, false, 27}};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        const int64_t interval_ns = cases[i].interval_s * TTF_NS_PER_S;
        const int64_t last_utc_ns = UTC0 + 9 * interval_ns;
        const struct ttf_plan plan = {.interval_ns = interval_ns,
                                      .count = 16,
                                      .end = TTF_END_UNTIL,
                                      .until_utc_ns = UTC0 + 15 * interval_ns + interval_ns / 2};
        struct ttf_writer_state done = ten_slots_done();
        struct ttf_resume_input in =
            boot(&done, last_utc_ns - cases[i].earlier_s * TTF_NS_PER_S, cases[i].trust);
        struct ttf_resume r;

        done.last_segment.interval_ns = interval_ns;
        snprintf(done.last_segment.trust, sizeof(done.last_segment.trust), "%s",
                 ttf_trust_name(cases[i].last));
        in.plan = &plan;
        in.elapsed_ns = 10 * interval_ns;
        in.past.last_trust = cases[i].last;
        in.past.last_utc_ns = last_utc_ns;
        assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
        assert_int_equal(r.on_grid, cases[i].on_grid);
        assert_int_equal(r.clock_implausible, !cases[i].on_grid);
        assert_int_equal(r.gap_ns, cases[i].on_grid ? 0 : TTF_NS_UNKNOWN);
        assert_int_equal(r.count, cases[i].count);
        assert_int_equal(r.lost_until, 10); /* no slot is lost to it */
    }
}

/* A week of free running, and what both say of themselves; of the same trust, a quarter of an hour. */
static void a_clock_is_behind_by_more_than_right_ones_differ(void **state)
{
    static const struct {
        enum ttf_trust trust;
        int64_t earlier_s;
        bool behind;
    } cases[] = {{TTF_TRUST_HOST, 73, false},  {TTF_TRUST_HOST, 74, true},
                 {TTF_TRUST_RTC, 900, false},  {TTF_TRUST_RTC, 901, true},
                 {TTF_TRUST_NTP, 1000, false}, {TTF_TRUST_NONE, 1000, false}};
    const struct ttf_run_past past = {.last_trust = TTF_TRUST_RTC,
                                      .last_utc_ns = UTC0,
                                      .last_uncertainty_ns = 2 * TTF_NS_PER_S,
                                      .last_run_ns = 7 * TTF_NS_PER_DAY};

    (void)state;
    for (unsigned i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        const struct ttf_utc utc = {.utc_ns = UTC0 - cases[i].earlier_s * TTF_NS_PER_S,
                                    .uncertainty_ns = TTF_NS_PER_S,
                                    .trust = cases[i].trust};

        assert_int_equal(ttf_resume_clock_behind(&past, &utc), cases[i].behind);
    }
}

/* What a foreign dataset may say: nobody is behind what may have been at any time. */
static void a_slot_of_no_certain_time_makes_no_clock_wrong(void **state)
{
    const struct ttf_run_past past = {
        .last_trust = TTF_TRUST_RTC, .last_utc_ns = UTC0, .last_uncertainty_ns = INT64_MAX};
    const struct ttf_utc utc = {
        .utc_ns = UTC0 / 2, .uncertainty_ns = TTF_NS_PER_S, .trust = TTF_TRUST_HOST};

    (void)state;
    assert_false(ttf_resume_clock_behind(&past, &utc));
}

static void a_run_that_had_ended_in_time_gains_nothing_by_another_clock(void **state)
{
    struct ttf_writer_state done = ten_slots_done();
    struct ttf_resume_input in = boot(&done, UTC0 + 12 * TTF_NS_PER_MIN, TTF_TRUST_NTP);
    struct ttf_resume r;

    (void)state;
    done.sealed = true;
    in.plan = &FIFTEEN;
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.count, 10);
    in.same_plan = false; /* a later instant was given */
    assert_int_equal(ttf_resume_resolve(&in, &r, NULL), 0);
    assert_int_equal(r.count, 15);
}

static void the_gap_is_known_once_utc_is(void **state)
{
    struct ttf_writer_state done = ten_slots_done();

    (void)state;
    assert_int_equal(ttf_resume_gap_ns(&done.last_segment, 10, UTC0 + (600 + 300) * TTF_NS_PER_S),
                     300 * TTF_NS_PER_S);
    /* Slot 9 was due at UTC0 + 540 s: gone on with at once, or by a clock that says that it was before that. */
    assert_int_equal(ttf_resume_gap_ns(&done.last_segment, 10, UTC0 + 550 * TTF_NS_PER_S), 0);
    assert_int_equal(ttf_resume_gap_ns(&done.last_segment, 10, UTC0 + 540 * TTF_NS_PER_S - 1),
                     TTF_NS_UNKNOWN);
    snprintf(done.last_segment.trust, sizeof(done.last_segment.trust), "none");
    assert_int_equal(ttf_resume_gap_ns(&done.last_segment, 10, UTC0), TTF_NS_UNKNOWN);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_new_run_begins_as_soon_as_it_is_ready),
        cmocka_unit_test(a_pcs_word_alone_gives_up_no_run),
        cmocka_unit_test(what_a_pc_said_before_gives_up_no_run_either),
        cmocka_unit_test(a_start_time_lies_where_utc_says),
        cmocka_unit_test(a_start_time_needs_a_clock_somebody_vouches_for),
        cmocka_unit_test(a_trusted_clock_rejoins_the_grid_and_names_the_outage),
        cmocka_unit_test(the_same_boot_needs_no_utc),
        cmocka_unit_test(what_a_person_stopped_and_what_was_tried_in_vain_is_said_so),
        cmocka_unit_test(a_stop_holds_over_a_boot_and_is_no_lack_of_power),
        cmocka_unit_test(what_is_due_while_a_box_gets_ready_behind_a_stop_did_not_lack_the_program),
        cmocka_unit_test(an_untrusted_clock_goes_on_at_once_with_the_gap_unknown),
        cmocka_unit_test(a_clock_behind_the_last_slot_is_not_believed),
        cmocka_unit_test(a_clock_is_behind_by_more_than_right_ones_differ),
        cmocka_unit_test(a_slot_of_no_certain_time_makes_no_clock_wrong),
        cmocka_unit_test(label_end_and_grid_go_by_the_same_clock),
        cmocka_unit_test(slots_given_up_ahead_of_time_do_not_make_the_clock_wrong),
        cmocka_unit_test(no_slot_is_waited_for_that_a_clock_ahead_makes_the_next),
        cmocka_unit_test(
            slots_that_pass_while_the_box_gets_ready_are_told_from_those_of_the_outage),
        cmocka_unit_test(an_outage_past_the_end_leaves_no_slot_unnamed),
        cmocka_unit_test(a_plan_that_ends_in_time_comes_to_what_the_clock_says),
        cmocka_unit_test(what_a_pc_said_before_ends_nothing_either),
        cmocka_unit_test(what_a_better_clock_said_in_this_boot_holds_against_a_pc),
        cmocka_unit_test(a_clock_behind_the_last_slot_that_was_known_moves_no_end),
        cmocka_unit_test(a_run_that_had_ended_in_time_gains_nothing_by_another_clock),
        cmocka_unit_test(the_gap_is_known_once_utc_is),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
