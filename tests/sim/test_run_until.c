/* SPDX-License-Identifier: Apache-2.0 */
/* Runs that end at an instant or after a time: they do, whatever happens to the box; and what their end says. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "until_run.h"

#define S   TTF_NS_PER_S
#define MIN TTF_NS_PER_MIN

/* Of a box that keeps no time, dark from 3:40 on for so long; NTP gives the time `back` after it has power again. */
static void dark(struct sim_run *run, int64_t amount_s, int64_t back)
{
    run->config.rtc = false;
    run->config.utc_back_ns = back;
    sim_run_fault(run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = amount_s;
}

static void undisturbed_it_ends_as_it_was_reckoned_and_says_why(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 4);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect_text(&run, "plans/0.json", "\"end\": \"until\"");
    until_expect_end(&run, "cccc", "until");
    living_finish(&run);
    until_init(&run, TTF_END_LENGTH, 4);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect_text(&run, "plans/0.json", "\"end\": \"length\"");
    until_expect_end(&run, "cccc", "until");
    living_finish(&run);
    until_init(&run, TTF_END_COUNT, 4);
    assert_int_equal(sim_run_boot(&run), 0);
    until_expect_end(&run, "cccc", "count");
    living_finish(&run);
}

/* Once the clock is back the run ends where it was to end: no slot stands for the outage. */
static void after_an_outage_of_unknown_length_it_ends_at_its_instant(void **state)
{
    static const enum ttf_plan_end ends[] = {TTF_END_UNTIL, TTF_END_LENGTH};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct sim_run run;

        /* Slots 0 to 3; dark until 6:40; slots at 6:52, 7:52 (the clock is back at 8:10), 8:52, 9:52. */
        until_init(&run, ends[i], 10);
        dark(&run, 180, 90 * S);
        assert_int_equal(sim_run_through_cuts(&run), 0);
        assert_int_equal(
            sim_run_events(&run, "plan", i == 0 ? "8 slots instead of 10" : "7 slots instead"), 1);
        until_expect_end(&run, i == 0 ? "cccccccc" : "ccccccc",
                         "until"); /* of a length until 9:42 */
        living_finish(&run);
    }
}

static int64_t totals[64];
static unsigned n_totals, told_wrong, told_right;

static void note_total(struct sim_run *run, const struct ttf_progress *p)
{
    (void)run;
    if (n_totals == 0 || p->total != totals[n_totals - 1])
        totals[n_totals++ % 64] = p->total;
    if (p->kind != TTF_PROGRESS_EVENT || !strstr(p->text, " slots instead of "))
        return;
    if (p->total == strtoll(p->text, NULL, 10))
        told_right++;
    else
        told_wrong++;
}

/* After the first boot its records cannot be written from its first minute on, for one. */
static int records_wait(struct sim_run *run, const char *op, const char *path)
{
    int64_t now_ns = run->box ? ttf_clock_now_ns(run->box->clock) : 0;

    (void)op;
    return run->committed >= 4 && now_ns > 60 * S && now_ns < 110 * S &&
                   sim_run_path_ends(path, "/records.jsonl")
               ? EIO
               : 0;
}

/* The event that says so, as the next slot may be hours away; and none tells an older one than is known. */
static void who_watches_is_told_of_another_end_at_once(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 10);
    dark(&run, 180, 90 * S);
    n_totals = told_right = told_wrong = 0;
    run.on_progress = note_total;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    assert_int_equal(n_totals, 2);
    assert_int_equal(totals[0], 10);
    assert_int_equal(totals[1], 8);
    assert_int_equal(told_right, 1);
    assert_int_equal(told_wrong, 0);
    living_finish(&run);
}

/* The plan as it is stored says 8 slots, and its clock that was two minutes late made 6 of them. */
static void gone_on_with_its_first_event_tells_no_older_end(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 8);
    sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 2 * MIN + 40 * S)->amount = 120;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 30;
    n_totals = 0;
    run.on_progress = note_total;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    assert_true(sim_run_events(&run, "resume", "on the same grid") > 0);
    assert_int_equal(n_totals, 2);
    assert_int_equal(totals[0], 8);
    assert_int_equal(totals[1], 6);
    living_finish(&run);
}

static void another_end_is_not_taken_back_by_a_record_that_waited(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 10);
    dark(&run, 180, 90 * S);
    run.fault = records_wait;
    n_totals = 0;
    run.on_progress = note_total;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    assert_int_equal(n_totals, 2);
    assert_int_equal(totals[1], 8);
    assert_int_equal(run.result.slots, 8);
    assert_true(run.result.sealed);
    living_finish(&run);
}

static void an_outage_past_its_instant_ends_it_as_soon_as_that_is_known(void **state)
{
    static const enum ttf_plan_end ends[] = {TTF_END_UNTIL, TTF_END_LENGTH};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct sim_run run;

        until_init(&run, ends[i], 10);
        dark(&run, 86400, 90 * S);
        assert_int_equal(sim_run_through_cuts(&run), 0);
        assert_int_equal(sim_run_events(&run, "plan", "the plan's end has come"), 1);
        until_expect_end(&run, "cccccc", "until"); /* two at once, as nobody knew */
        living_finish(&run);
    }
}

/* With hours between slots it is not waited for the next one. */
static void it_ends_in_the_middle_of_a_long_wait(void **state)
{
    struct sim_run run;
    int64_t power_on;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 10);
    run.plan.interval_ns = 10 * TTF_NS_PER_H;
    run.plan.count = 5;
    run.plan.until_utc_ns = run.config.start_utc_ns + 45 * TTF_NS_PER_H;
    run.config.rtc = false;
    run.config.utc_back_ns = TTF_NS_PER_H;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 11 * TTF_NS_PER_H)->amount = 7 * 86400;
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    power_on = run.config.power_on_ns = run.back_ns;
    assert_int_equal(sim_run_boot(&run), 0);
    until_expect_end(&run, "ccc", "until");
    assert_in_range(run.ended_ns - power_on, TTF_NS_PER_H, TTF_NS_PER_H + 10 * S);
    living_finish(&run);
}

static void while_nobody_knows_it_comes_to_as_many_as_before(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 8);
    dark(&run, 86400, 0);
    assert_int_equal(sim_run_through_cuts(&run), 0);
    until_expect_end(&run, "cccccccc", "until");
    living_finish(&run);
}

/* The outage has its slots, and they are all that there were to be. */
static void an_outage_of_known_length_changes_nothing(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 8);
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * MIN + 40 * S)->amount = 86400;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    until_expect_end(&run, "ccccwwww", "until");
    living_finish(&run);
}

static void another_interval_ends_at_the_same_instant(void **state)
{
    static const enum ttf_plan_end ends[] = {TTF_END_UNTIL, TTF_END_LENGTH};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct sim_run run;
        int64_t n;

        until_init(&run, ends[i], 6); /* the end at 6:00 or 5:42 */
        n = living_ask(&run, &(struct ttf_ask){
                                 .kind = TTF_ASK_INTERVAL, .from_index = 3, .interval_ns = 25 * S});
        assert_int_equal(sim_run_boot(&run), 0);
        living_expect_done(&run, n);
        /* 0:12, 1:12, 2:12, then 2:37, 3:02, ..., 5:32 (and 5:57 before 6:00) */
        until_expect_end(&run, i == 0 ? "cccccccccccc" : "ccccccccccc", "until");
        sim_run_expect_text(&run, "plans/1.json", i == 0 ? "\"count\": 12" : "\"count\": 11");
        living_finish(&run);
    }
}

/* To end by a length of so many whole intervals; with an interval by which a slot is due at the end to the nanosecond. */
static void a_slot_due_at_its_end_is_none_of_it_however_many_there_were_to_be(void **state)
{
    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct ttf_ask ask = {.kind = TTF_ASK_INTERVAL, .from_index = 2, .interval_ns = 75 * S};
        struct sim_run run;
        int64_t n;

        until_init(&run, i == 0 ? TTF_END_COUNT : TTF_END_LENGTH, 4); /* a length of 3:30 */
        if (i == 0) {
            ask = (struct ttf_ask){.kind = TTF_ASK_PLAN, .from_index = 2, .plan = run.plan};
            ask.plan.end = TTF_END_LENGTH;
            ask.plan.length_ns = 3 * MIN;
        }
        n = living_ask(&run, &ask);
        assert_int_equal(sim_run_boot(&run), 0);
        living_expect_done(&run, n);
        until_expect_end(&run, "ccc", "until");
        living_finish(&run);
    }
}

static void asked_for_while_it_runs_it_holds_over_all_of_that(void **state)
{
    struct sim_run run;
    int64_t until, interval;

    (void)state;
    until_init(&run, TTF_END_COUNT, 4);
    until = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_UNTIL,
                                               .from_index = 1,
                                               .until_utc_ns = run.config.start_utc_ns + 10 * MIN});
    interval = living_ask(
        &run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL, .from_index = 3, .interval_ns = 30 * S});
    dark(&run, 180, 90 * S);
    assert_int_equal(sim_run_through_cuts(&run), 0);
    living_expect_done(&run, until);
    living_expect_done(&run, interval);
    sim_run_expect_text(&run, "plans/2.json", "\"until_utc_ns\"");
    /* 0:12, 1:12, 2:12, 2:42, 3:12; dark; each half minute from 6:52 on, seven before 10:00 */
    until_expect_end(&run, "cccccccccccc", "until");
    living_finish(&run);
}

/* So many slots, and an outage whose length is known only later; then it is to take so long, or to end then, after all. */
static void asked_for_after_an_outage_it_counts_the_outage(void **state)
{
    static const enum ttf_plan_end ends[] = {TTF_END_UNTIL, TTF_END_LENGTH};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct ttf_ask ask = {.kind = TTF_ASK_PLAN, .from_index = 7};
        struct sim_run run;
        int64_t n;

        /* Slots 0 to 3; dark until 6:40; slots at 6:52, 7:52 (the clock is back at 8:10), 8:52, 9:52. */
        until_init(&run, ends[i], 10);
        ask.plan = run.plan;
        run.plan.end = TTF_END_COUNT;
        run.plan.until_utc_ns = run.plan.length_ns = 0;
        n = living_ask(&run, &ask);
        dark(&run, 180, 90 * S);
        assert_int_equal(sim_run_through_cuts(&run), 0);
        living_expect_done(&run, n);
        sim_run_expect_text(&run, "plans/1.json", i == 0 ? "\"count\": 8" : "\"count\": 7");
        until_expect_end(&run, i == 0 ? "cccccccc" : "ccccccc",
                         "until"); /* of a length until 9:42 */
        living_finish(&run);
    }
}

static void a_clock_that_is_corrected_moves_it(void **state)
{
    static const struct {
        int64_t step_s;
        const char *letters;
    } cases[] = {{120, "cccc"}, {-120, "cccccccc"}, {7200, "ccc"}};

    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        struct sim_run run;

        until_init(&run, TTF_END_UNTIL, 6);
        sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 2 * MIN + 40 * S)->amount = cases[i].step_s;
        assert_int_equal(sim_run_boot(&run), 0);
        until_expect_end(&run, cases[i].letters, "until");
        living_finish(&run);
        /* Of a length there is nothing that UTC could say. */
        until_init(&run, TTF_END_LENGTH, 6);
        sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 2 * MIN + 40 * S)->amount = cases[i].step_s;
        assert_int_equal(sim_run_boot(&run), 0);
        until_expect_end(&run, "cccccc", "until");
        living_finish(&run);
    }
}

/* While the last slot is exposed: there are more to come, though it was the last. */
static void a_clock_corrected_in_the_last_slot_makes_it_another_than_the_last(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 4);
    run.plan.shots[0].exposure.exposure_ns = 5 * S;
    sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 3 * MIN + 14 * S)->amount = -120;
    assert_int_equal(sim_run_boot(&run), 0);
    until_expect_end(&run, "cccccc", "until");
    living_finish(&run);
}

static void once_ended_it_has_ended_whatever_the_clock_says_later(void **state)
{
    struct sim_run run;
    char digest[65];

    (void)state;
    until_init(&run, TTF_END_UNTIL, 4);
    assert_int_equal(sim_run_boot(&run), 0);
    memcpy(digest, run.result.digest, sizeof(digest));
    run.config.power_on_ns = run.ended_ns + MIN;
    sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 1)->amount = -120;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_string_equal(run.result.digest, digest);
    until_expect_end(&run, "cccc", "until");
    living_finish(&run);
}

static void a_run_that_a_person_ends_at_once_was_stopped(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 6);
    living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 3, .count = 3});
    assert_int_equal(sim_run_boot(&run), 0);
    until_expect_end(&run, "ccc", "stopped");
    living_finish(&run);
}

/* The same plan, given again in another boot. */
static void expect_nothing_to_do(struct sim_run *run)
{
    char digest[65];

    memcpy(digest, run->result.digest, sizeof(digest));
    run->config.power_on_ns = run->ended_ns + S;
    assert_int_equal(sim_run_boot(run), 0);
    assert_true(run->result.sealed);
    assert_string_equal(run->result.digest, digest);
}

/* Stopped, then given a plan that says: so many are enough. */
static void a_plan_that_ends_what_is_there_stops_it(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_COUNT, 6);
    living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 3});
    assert_int_equal(sim_run_boot(&run), 0);
    assert_false(run.result.sealed);
    run.plan.count = 3;
    run.config.power_on_ns = run.ended_ns + S;
    assert_int_equal(sim_run_boot(&run), 0);
    until_expect_end(&run, "ccc", "stopped");
    expect_nothing_to_do(&run);
    living_finish(&run);
}

static void a_new_plan_that_ends_before_what_is_there_is_refused(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 6);
    living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 4});
    assert_int_equal(sim_run_boot(&run), 0);
    run.plan.until_utc_ns -= 4 * MIN;
    run.config.power_on_ns = run.ended_ns + S;
    assert_int_equal(sim_run_boot(&run), -EINVAL);
    assert_string_equal(run.err.where, "until");
    assert_non_null(strstr(run.err.what, "slot 3"));
    run.plan.until_utc_ns += 2 * MIN; /* the last one was due before it, the next is not */
    assert_int_equal(sim_run_boot(&run), 0);
    until_expect_end(&run, "cccc", "until");
    expect_nothing_to_do(&run);
    living_finish(&run);
}

static void a_new_run_whose_end_has_passed_names_it(void **state)
{
    struct sim_run run;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 4);
    run.plan.until_utc_ns = run.config.start_utc_ns - MIN;
    assert_int_equal(sim_run_boot(&run), -EINVAL);
    assert_string_equal(run.err.where, "until");
    living_finish(&run);
    until_init(&run, TTF_END_COUNT, 4);
    run.plan.start_utc_ns = run.config.start_utc_ns - TTF_NS_PER_H;
    assert_int_equal(sim_run_boot(&run), -EINVAL);
    assert_string_equal(run.err.where, "start");
    living_finish(&run);
}

/* As plans were stored before: without what ends them. The plan of then, given again, is the same. */
static void a_dataset_that_does_not_tell_its_end_is_gone_on_with_by_its_count(void **state)
{
    struct sim_run run;
    char *text;

    (void)state;
    until_init(&run, TTF_END_UNTIL, 6);
    run.plan.end = TTF_END_UNTOLD;
    run.plan.until_utc_ns = 0;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 2 * MIN + 40 * S)->amount = 60;
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    text = sim_run_text(&run, "plans/0.json");
    assert_null(strstr(text, "\"end\""));
    free(text);
    run.plan.end = TTF_END_LENGTH;
    run.plan.length_ns = 6 * MIN;
    run.config.power_on_ns = run.back_ns;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_null(sim_run_text(&run, "plans/1.json"));
    until_expect_end(&run, "cccwcc", "count");
    living_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(undisturbed_it_ends_as_it_was_reckoned_and_says_why),
        cmocka_unit_test(after_an_outage_of_unknown_length_it_ends_at_its_instant),
        cmocka_unit_test(who_watches_is_told_of_another_end_at_once),
        cmocka_unit_test(gone_on_with_its_first_event_tells_no_older_end),
        cmocka_unit_test(another_end_is_not_taken_back_by_a_record_that_waited),
        cmocka_unit_test(an_outage_past_its_instant_ends_it_as_soon_as_that_is_known),
        cmocka_unit_test(it_ends_in_the_middle_of_a_long_wait),
        cmocka_unit_test(while_nobody_knows_it_comes_to_as_many_as_before),
        cmocka_unit_test(an_outage_of_known_length_changes_nothing),
        cmocka_unit_test(another_interval_ends_at_the_same_instant),
        cmocka_unit_test(a_slot_due_at_its_end_is_none_of_it_however_many_there_were_to_be),
        cmocka_unit_test(asked_for_while_it_runs_it_holds_over_all_of_that),
        cmocka_unit_test(asked_for_after_an_outage_it_counts_the_outage),
        cmocka_unit_test(a_clock_that_is_corrected_moves_it),
        cmocka_unit_test(a_clock_corrected_in_the_last_slot_makes_it_another_than_the_last),
        cmocka_unit_test(once_ended_it_has_ended_whatever_the_clock_says_later),
        cmocka_unit_test(a_run_that_a_person_ends_at_once_was_stopped),
        cmocka_unit_test(a_plan_that_ends_what_is_there_stops_it),
        cmocka_unit_test(a_new_plan_that_ends_before_what_is_there_is_refused),
        cmocka_unit_test(a_new_run_whose_end_has_passed_names_it),
        cmocka_unit_test(a_dataset_that_does_not_tell_its_end_is_gone_on_with_by_its_count),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
