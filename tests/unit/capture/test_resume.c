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

/* A new boot, 5 s old, when UTC is utc_ns. */
static struct ttf_resume_input boot(const struct ttf_writer_state *state, int64_t utc_ns,
                                    enum ttf_trust trust)
{
    struct ttf_resume_input in = {
        .state = state,
        .boot_id = "second-boot",
        .utc = {.boot_ns = 5 * TTF_NS_PER_S, .utc_ns = utc_ns, .trust = trust},
        .now_ns = 5 * TTF_NS_PER_S,
        .ready_ns = 8 * TTF_NS_PER_S,
        .interval_ns = TTF_NS_PER_MIN,
        .count = 1000,
    };

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
    assert_int_equal(r.lost_until, in.count);
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
    assert_int_equal(r.lost_until, in.count);
}

static void the_gap_is_known_once_utc_is(void **state)
{
    struct ttf_writer_state done = ten_slots_done();

    (void)state;
    assert_int_equal(ttf_resume_gap_ns(&done.last_segment, 10, UTC0 + (600 + 300) * TTF_NS_PER_S),
                     300 * TTF_NS_PER_S);
    snprintf(done.last_segment.trust, sizeof(done.last_segment.trust), "none");
    assert_int_equal(ttf_resume_gap_ns(&done.last_segment, 10, UTC0), TTF_NS_UNKNOWN);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_new_run_begins_as_soon_as_it_is_ready),
        cmocka_unit_test(a_pcs_word_alone_gives_up_no_run),
        cmocka_unit_test(a_start_time_lies_where_utc_says),
        cmocka_unit_test(a_start_time_needs_a_clock_somebody_vouches_for),
        cmocka_unit_test(a_trusted_clock_rejoins_the_grid_and_names_the_outage),
        cmocka_unit_test(the_same_boot_needs_no_utc),
        cmocka_unit_test(what_a_person_stopped_and_what_was_tried_in_vain_is_said_so),
        cmocka_unit_test(a_stop_holds_over_a_boot_and_is_no_lack_of_power),
        cmocka_unit_test(an_untrusted_clock_goes_on_at_once_with_the_gap_unknown),
        cmocka_unit_test(a_clock_behind_the_last_slot_is_not_believed),
        cmocka_unit_test(slots_given_up_ahead_of_time_do_not_make_the_clock_wrong),
        cmocka_unit_test(
            slots_that_pass_while_the_box_gets_ready_are_told_from_those_of_the_outage),
        cmocka_unit_test(an_outage_past_the_end_leaves_no_slot_unnamed),
        cmocka_unit_test(the_gap_is_known_once_utc_is),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
