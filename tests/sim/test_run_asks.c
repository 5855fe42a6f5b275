/* SPDX-License-Identifier: Apache-2.0 */
/* What people ask of a living run and what they hear: who asks too much, too late, or of a box without a clock. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "living.h"

static void expect_answer(struct sim_run *run, int64_t number, int code, const char *what)
{
    struct ttf_err err = {0};
    int r = ttf_control_answer(run->control, number, &err);

    if (r != code || !strstr(err.what, what))
        print_error("%d, '%s', not %d, '%s'\n", r, err.what, code, what);
    assert_int_equal(r, code);
    assert_non_null(strstr(err.what, what));
}

static void whoever_asks_too_much_hears_so(void **state)
{
    struct ttf_ask plan = {.kind = TTF_ASK_PLAN, .from_index = 100, .plan_yaml = "count: 7\n"};
    struct ttf_control *control = ttf_control_create();

    (void)state;
    assert_non_null(control);
    assert_int_equal(ttf_control_ask(control, &(struct ttf_ask){.kind = TTF_ASK_KIND_COUNT}),
                     -EINVAL);
    ttf_plan_defaults(&plan.plan);
    for (unsigned i = 0; i < TTF_ASKS_MAX; i++)
        assert_int_equal(ttf_control_ask(control, &plan), i + 1);
    assert_int_equal(ttf_control_ask(control, &plan), -EAGAIN);
    assert_int_equal(ttf_control_waiting(control), TTF_ASKS_MAX);
    assert_int_equal(ttf_control_answer(control, 5, NULL), -EAGAIN);
    /* Numbers that nobody was given. */
    assert_int_equal(ttf_control_answer(control, 0, NULL), -ENOENT);
    assert_int_equal(ttf_control_answer(control, -3, NULL), -ENOENT);
    assert_int_equal(ttf_control_answer(control, 1000, NULL), -ENOENT);
    ttf_control_destroy(control);
    ttf_control_destroy(NULL);
}

/* After a power cut, of a box that keeps no time: instants and local times mean nothing. */
static void without_a_clock_no_instant_is_promised(void **state)
{
    struct sim_run run;
    int64_t until, local, later;

    (void)state;
    living_init(&run);
    run.config.rtc = false;
    run.plan.count = 8;
    run.plan.lamps = TTF_LAMPS_PHOTOPERIOD;
    run.plan.period_ns = 24 * TTF_NS_PER_H;
    run.plan.day_ns = 16 * TTF_NS_PER_H;
    run.plan.n_day_levels = 1;
    strcpy(run.plan.day_levels[0].lamp, "right");
    run.plan.day_levels[0].permille = 100;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 2 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S);
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    run.config.power_on_ns = run.back_ns;
    until =
        living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_UNTIL, .until_utc_ns = INT64_MAX / 2});
    local = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_PHOTOPERIOD,
                                               .day_ns = 12 * TTF_NS_PER_H,
                                               .period_ns = 24 * TTF_NS_PER_H,
                                               .local = true,
                                               .day_start_s = 6 * 3600});
    later = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_PHOTOPERIOD,
                                               .from_index = 6,
                                               .day_ns = 12 * TTF_NS_PER_H,
                                               .period_ns = 24 * TTF_NS_PER_H,
                                               .phase_ns = TTF_NS_PER_H});
    assert_int_equal(sim_run_boot(&run), 0);
    expect_answer(&run, until, -EINVAL, "nobody vouches");
    expect_answer(&run, local, -EINVAL, "nobody vouches");
    expect_answer(&run, later, 0, ""); /* counted from slot 0: that needs no clock */
    assert_int_equal(sim_run_events(&run, "plan", "another photoperiod"), 1);
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

static void what_is_asked_of_slots_that_are_taken_is_refused(void **state)
{
    struct sim_run run;
    int64_t fewer, before, after;

    (void)state;
    living_init(&run);
    fewer = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 4, .count = 3});
    before = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_UNTIL,
                                                .from_index = 4,
                                                .until_utc_ns = run.config.start_utc_ns});
    after = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
                                               .from_index = 100,
                                               .interval_ns = TTF_NS_PER_MIN});
    assert_int_equal(sim_run_boot(&run), 0);
    expect_answer(&run, fewer, -EINVAL, "have their records already");
    expect_answer(&run, before, -EINVAL, "have their records already");
    assert_int_equal(ttf_control_answer(run.control, after, NULL), -EAGAIN); /* for the next run */
    sim_run_expect(&run, "cccccc");
    living_finish(&run);
}

static void a_pause_is_taken_back_once_and_a_second_word_of_it_is_none(void **state)
{
    struct sim_run run;

    (void)state;
    living_init(&run);
    living_ask(
        &run, &(struct ttf_ask){.kind = TTF_ASK_CONTINUE, .from_index = 1}); /* it was not paused */
    living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_PAUSE, .from_index = 2});
    living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_CONTINUE, .from_index = 4});
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cczzcc");
    sim_run_expect_reason(&run, 2, "paused by a person");
    assert_int_equal(sim_run_events(&run, "pause", NULL), 2);
    living_finish(&run);
}

static void a_note_of_another_time_keeps_it_and_an_empty_one_is_refused(void **state)
{
    struct ttf_ask good = {.kind = TTF_ASK_NOTE, .from_index = 1};
    struct ttf_ask empty = {.kind = TTF_ASK_NOTE, .from_index = 1};
    struct sim_run run;
    char path[128];
    char *text = NULL;
    size_t bytes;
    int64_t n;

    (void)state;
    living_init(&run);
    good.note = (struct ttf_note){.utc_ns = 12345, .text = "yesterday"};
    empty.note = (struct ttf_note){.utc_ns = TTF_NS_UNKNOWN};
    living_ask(&run, &good);
    n = living_ask(&run, &empty);
    assert_int_equal(sim_run_boot(&run), 0);
    expect_answer(&run, n, -EINVAL, "needs a text or a tag");
    snprintf(path, sizeof(path), "%s/notes.jsonl", run.path);
    assert_int_equal(ttf_io_slurp(ttf_io_posix(), path, 1 << 16, &text, &bytes, NULL), 0);
    assert_non_null(strstr(text, "\"utc_ns\":12345"));
    free(text);
    living_finish(&run);
}

/* The disk takes no line of it any more. */
static int only_reads(struct sim_run *run, const char *op, const char *path)
{
    (void)op;
    (void)path;
    return run->committed >= 2 ? EROFS : 0;
}

static void what_the_run_s_end_came_before_is_told_so(void **state)
{
    struct sim_run run;
    int64_t change;

    (void)state;
    living_init(&run);
    run.fault = only_reads;
    change =
        living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 2, .count = 9});
    assert_int_equal(sim_run_boot(&run), -EROFS);
    expect_answer(&run, change, -ECANCELED, "the run ended before this was done");
    sim_run_expect(&run, "cc");
    living_finish(&run);
}

/* The storage gives an error in the middle of a change: it is opened anew, and what is there is not written again. */
static unsigned failures;
static const char *fails_op;
static const char *fails_in;
static unsigned passes; /* before it fails */

static int fails_once(struct sim_run *run, const char *op, const char *path)
{
    if (run->committed < 2 || failures > 0 || strcmp(op, fails_op) != 0 || !strstr(path, fails_in))
        return 0;
    if (passes > 0) {
        passes--;
        return 0;
    }
    failures++;
    return ENOSPC;
}

static void a_change_that_fails_once_is_made_once(void **state)
{
    /* The plan's file, its line, that line's sync; its newline, the segment's line. */
    static const char *const ops[][2] = {{"open", "plans/1.json"},
                                         {"append", "/records.jsonl"},
                                         {"sync", "/records.jsonl"},
                                         {"append", "/records.jsonl"},
                                         {"append", "/records.jsonl"}};

    (void)state;
    for (unsigned i = 0; i < 5; i++) {
        struct ttf_reader *reader = NULL;
        struct sim_run run;
        int64_t change;

        living_init(&run);
        failures = 0;
        passes = i > 2 ? i - 2 : 0;
        fails_op = ops[i][0];
        fails_in = ops[i][1];
        run.fault = fails_once;
        change =
            living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 2, .count = 7});
        assert_int_equal(sim_run_boot(&run), 0);
        assert_int_equal(failures, 1);
        expect_answer(&run, change, 0, "");
        sim_run_expect(&run, "ccccccc");
        assert_int_equal(ttf_reader_open(ttf_io_posix(), run.path, &reader, NULL), 0);
        assert_int_equal(ttf_reader_summary(reader)->n_plans, 2);
        assert_int_equal(ttf_reader_summary(reader)->n_segments, 2);
        ttf_reader_close(reader);
        living_finish(&run);
    }
}

static void many_asks_are_answered_each(void **state)
{
    struct sim_run run;
    int64_t numbers[TTF_ASKS_MAX];
    struct ttf_ask never = {.kind = TTF_ASK_PAUSE, .from_index = 1000};

    (void)state;
    living_init(&run);
    for (int i = 0; i < TTF_ASKS_MAX - 1; i++)
        numbers[i] = living_ask(
            &run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 1, .count = 6 + i % 2});
    living_ask(&run, &never);
    assert_int_equal(ttf_control_ask(run.control, &never), -EAGAIN);
    assert_int_equal(sim_run_boot(&run), 0);
    for (int i = 0; i < TTF_ASKS_MAX - 1; i++)
        living_expect_done(&run, numbers[i]);
    assert_int_equal(ttf_control_waiting(run.control), 1);
    assert_int_equal(ttf_control_answer(run.control, 12345, NULL), -ENOENT);
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(many_asks_are_answered_each),
        cmocka_unit_test(whoever_asks_too_much_hears_so),
        cmocka_unit_test(without_a_clock_no_instant_is_promised),
        cmocka_unit_test(what_is_asked_of_slots_that_are_taken_is_refused),
        cmocka_unit_test(a_pause_is_taken_back_once_and_a_second_word_of_it_is_none),
        cmocka_unit_test(a_note_of_another_time_keeps_it_and_an_empty_one_is_refused),
        cmocka_unit_test(what_the_run_s_end_came_before_is_told_so),
        cmocka_unit_test(a_change_that_fails_once_is_made_once),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
