/* SPDX-License-Identifier: Apache-2.0 */
/* Runs that are changed while they live: longer, slower, paused, annotated, stopped. */
#include "cmocka_includes.h"

#include <stdlib.h>
#include <string.h>

#include "living.h"
#include "ttf/hal/clock.h"

static void more_slots_are_taken_when_asked(void **state)
{
    struct sim_run run;
    int64_t n;

    (void)state;
    living_init(&run);
    n = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 3, .count = 9});
    assert_int_equal(sim_run_boot(&run), 0);
    living_expect_done(&run, n);
    run.plan.count = 9;
    sim_run_expect(&run, "ccccccccc");
    sim_run_expect_whole(&run, true);
    assert_int_equal(sim_run_due_of(&run, 8) - sim_run_due_of(&run, 0), 8 * TTF_NS_PER_MIN);
    assert_int_equal(sim_run_events(&run, "plan", "9 slots instead of 6"), 1);
    sim_run_expect_text(&run, "plans/1.json", "\"count\": 9");
    living_finish(&run);
}

static void a_run_is_cut_short_when_asked_and_sealed(void **state)
{
    struct sim_run run;
    int64_t too_few;
    int64_t fewer;

    (void)state;
    living_init(&run);
    too_few =
        living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 3, .count = 2});
    fewer = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 4, .count = 4});
    assert_int_equal(sim_run_boot(&run), 0);
    living_expect_refused(&run, too_few, "count", "3 slots have their records");
    living_expect_done(&run, fewer);
    run.plan.count = 4;
    sim_run_expect(&run, "cccc");
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

static void a_run_goes_on_until_an_instant(void **state)
{
    struct sim_run run;
    struct ttf_ask until = {.kind = TTF_ASK_UNTIL, .from_index = 2};
    int64_t n;

    (void)state;
    living_init(&run);
    /* Slot 0 is due some 13 s after power-on, so slot 9 is the last before 10 min. */
    until.until_utc_ns = run.config.start_utc_ns + 10 * TTF_NS_PER_MIN;
    n = living_ask(&run, &until);
    assert_int_equal(sim_run_boot(&run), 0);
    living_expect_done(&run, n);
    run.plan.count = 10;
    sim_run_expect(&run, "cccccccccc");
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

static void another_interval_begins_a_segment_and_renumbers_nothing(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;
    int64_t n;

    (void)state;
    living_init(&run);
    n = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
                                           .from_index = 3,
                                           .interval_ns = 20 * TTF_NS_PER_S});
    assert_int_equal(sim_run_boot(&run), 0);
    living_expect_done(&run, n);
    sim_run_expect(&run, "cccccc");
    assert_int_equal(sim_run_due_of(&run, 2) - sim_run_due_of(&run, 0), 2 * TTF_NS_PER_MIN);
    /* One new interval after the slot before it, and so on. */
    assert_int_equal(sim_run_due_of(&run, 3) - sim_run_due_of(&run, 2), 20 * TTF_NS_PER_S);
    assert_int_equal(sim_run_due_of(&run, 5) - sim_run_due_of(&run, 3), 40 * TTF_NS_PER_S);
    assert_int_equal(sim_run_segment_of(&run, 2, &segment), 0);
    assert_int_equal(segment.plan, 0);
    assert_int_equal(sim_run_segment_of(&run, 3, &segment), 1);
    assert_int_equal(segment.plan, 1);
    assert_int_equal(segment.first_index, 3);
    assert_int_equal(segment.interval_ns, 20 * TTF_NS_PER_S);
    assert_int_equal(segment.origin_utc_ns - segment.origin_ns, run.config.start_utc_ns);
    assert_true(run.result.error_max_ns < TTF_NS_PER_MS);
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

/* With 11 s the next slot can only be met at the second multiple; that is no slot to count the other interval from. */
static void changed_twice_before_a_slot_the_next_comes_one_interval_after_the_last(void **state)
{
    static const int64_t intervals_s[] = {25, 60}; /* another, and the one of before */

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        const int64_t interval_ns = intervals_s[i] * TTF_NS_PER_S;
        struct sim_run run;
        int64_t first, then;

        living_init(&run);
        first = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
                                                   .from_index = 3,
                                                   .interval_ns = 11 * TTF_NS_PER_S});
        then = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
                                                  .from_index = 3,
                                                  .interval_ns = interval_ns});
        assert_int_equal(sim_run_boot(&run), 0);
        living_expect_done(&run, first);
        living_expect_done(&run, then);
        sim_run_expect(&run, "cccccc");
        assert_int_equal(sim_run_due_of(&run, 3) - sim_run_due_of(&run, 2), interval_ns);
        assert_int_equal(sim_run_due_of(&run, 5) - sim_run_due_of(&run, 3), 2 * interval_ns);
        sim_run_expect_whole(&run, true);
        living_finish(&run);
    }
}

/* Between the last slot, due at 2:13, and the one that was to come; the other interval puts none in between. */
static void an_end_behind_the_last_slot_is_taken_whatever_was_changed_before_the_next(void **state)
{
    struct sim_run run;
    int64_t interval, until;

    (void)state;
    living_init(&run);
    interval = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
                                                  .from_index = 3,
                                                  .interval_ns = 11 * TTF_NS_PER_S});
    until = living_ask(
        &run, &(struct ttf_ask){.kind = TTF_ASK_UNTIL,
                                .from_index = 3,
                                .until_utc_ns = run.config.start_utc_ns + 140 * TTF_NS_PER_S});
    assert_int_equal(sim_run_boot(&run), 0);
    living_expect_done(&run, interval);
    living_expect_done(&run, until);
    sim_run_expect(&run, "ccc");
    living_finish(&run);
}

static void a_pause_is_recorded_slot_by_slot_with_its_reason(void **state)
{
    struct sim_run run;
    int64_t n;

    (void)state;
    living_init(&run);
    n = living_ask(&run,
                   &(struct ttf_ask){.kind = TTF_ASK_PAUSE, .from_index = 2, .reason = "watering"});
    living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_CONTINUE, .from_index = 4});
    assert_int_equal(sim_run_boot(&run), 0);
    living_expect_done(&run, n);
    sim_run_expect(&run, "cczzcc");
    assert_int_equal(run.result.paused, 2);
    sim_run_expect_reason(&run, 2, "watering");
    sim_run_expect_reason(&run, 3, "watering");
    assert_int_equal(sim_run_due_of(&run, 5) - sim_run_due_of(&run, 0), 5 * TTF_NS_PER_MIN);
    assert_int_equal(sim_run_events(&run, "pause", "watering"), 1);
    assert_int_equal(sim_run_events(&run, "pause", "over"), 1);
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

/* Whoever forgets a pause over a power cut loses no more than its slots. */
static void a_pause_does_not_outlive_a_power_cut(void **state)
{
    struct sim_run run;

    (void)state;
    living_init(&run);
    run.plan.count = 8;
    living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_PAUSE, .from_index = 2});
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount = 70;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    sim_run_expect(&run, "cczzwccc");
    sim_run_expect_reason(&run, 2, "paused by a person");
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

static void a_stop_is_obeyed_and_the_run_gone_on_with(void **state)
{
    struct sim_run run;
    int64_t n;

    (void)state;
    living_init(&run);
    n = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 3});
    assert_int_equal(sim_run_boot(&run), 0);
    living_expect_done(&run, n);
    assert_false(run.result.sealed);
    sim_run_expect(&run, "ccc");
    assert_int_equal(sim_run_events(&run, "stop", NULL), 1);
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

/* A day of 2 min in each 4, from 1 min on; a shot needs the lamp anyway. */
static void with_days(struct sim_run *run)
{
    run->plan.lamps = TTF_LAMPS_PHOTOPERIOD;
    run->plan.day_ns = 2 * TTF_NS_PER_MIN;
    run->plan.period_ns = 4 * TTF_NS_PER_MIN;
    run->plan.phase_ns = TTF_NS_PER_MIN;
    run->plan.n_day_levels = 1;
    strcpy(run->plan.day_levels[0].lamp, "right");
    run->plan.day_levels[0].permille = 1000;
}

static void another_photoperiod_is_a_plan_and_its_lamps_keep_their_limits(void **state)
{
    struct sim_run run;
    struct ttf_ask day = {.kind = TTF_ASK_PHOTOPERIOD,
                          .from_index = 2,
                          .day_ns = 3 * TTF_NS_PER_MIN,
                          .period_ns = 4 * TTF_NS_PER_MIN};
    int64_t longer;
    int64_t too_long;

    (void)state;
    living_init(&run);
    with_days(&run);
    run.config.lamps[1].info.max_on_ns = 200 * TTF_NS_PER_S;
    longer = living_ask(&run, &day);
    day.day_ns = day.period_ns;
    too_long = living_ask(&run, &day);
    assert_int_equal(sim_run_boot(&run), 0);
    living_expect_done(&run, longer);
    living_expect_refused(&run, too_long, "lamps.day", "right");
    sim_run_expect(&run, "cccccc");
    sim_run_expect_text(&run, "plans/1.json", "\"day_ns\": 180000000000");
    assert_int_equal(sim_run_events(&run, "plan", "another photoperiod"), 1);
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

/* Whether lamp "right" burned when each slot was committed. */
static char burning[32];

static void look_at_right(struct sim_run *run, const struct ttf_progress *progress)
{
    struct ttf_lamp_state state;

    if (progress->kind != TTF_PROGRESS_SLOT || progress->result != TTF_RESULT_CAPTURED)
        return;
    assert_int_equal(ttf_lamps_state(run->box->lamps,
                                     (unsigned)ttf_lamps_find(run->box->lamps, "right"), &state),
                     0);
    burning[progress->index] = state.commanded_permille > 0 ? 'o' : '.';
}

/* Plants keep their day, whatever the interval, over a power cut too. */
static void another_interval_does_not_move_the_day(void **state)
{
    struct sim_run run;

    (void)state;
    for (int changed = 0; changed < 2; changed++) {
        living_init(&run);
        with_days(&run);
        run.plan.count = 14;
        memset(burning, 0, sizeof(burning));
        run.on_progress = look_at_right;
        if (changed) { /* slots 4.. come every 30 s: 4 at 3.5 min, 5 at 4 min, ... */
            living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
                                               .from_index = 4,
                                               .interval_ns = 30 * TTF_NS_PER_S});
            sim_run_fault(&run, TTF_FAULT_POWER_CUT, 5 * TTF_NS_PER_MIN + 30 * TTF_NS_PER_S)
                ->amount = 40;
        }
        assert_int_equal(sim_run_through_cuts(&run), 0);
        for (int64_t k = 0; k < 13; k++) { /* after the last one all goes dark */
            struct ttf_slot_record record;
            /* Minutes since slot 0; looked at a little after the exposure. */
            double at = k < 4 || !changed ? (double)k : 3 + 0.5 * (double)(k - 3);
            double in_day = at - 1 - 4 * (int)((at + 3) / 4 - 1);

            sim_run_record(&run, k, &record);
            if (record.result == TTF_RESULT_CAPTURED)
                assert_int_equal(burning[k], in_day >= 0 && in_day < 2 ? 'o' : '.');
            ttf_slot_record_free(&record);
        }
        sim_run_expect_whole(&run, true);
        living_finish(&run);
    }
}

static long long phase_in(const struct sim_run *run, const char *name)
{
    static const char key[] = "\"phase_ns\":";
    char *text = sim_run_text(run, name);
    const char *at = text ? strstr(text, key) : NULL;
    long long phase = at ? strtoll(at + strlen(key), NULL, 10) : 0;

    assert_non_null(at);
    free(text);
    return phase;
}

/* A day that begins at a local time is resolved once: neither a step of the clock nor another change moves it. */
static void another_length_does_not_move_a_local_day(void **state)
{
    struct sim_run run;
    int64_t longer, whole;

    (void)state;
    for (int trusted = 0; trusted < 2; trusted++) {
        struct ttf_ask plan = {.kind = TTF_ASK_PLAN, .from_index = 6};

        living_init(&run);
        with_days(&run);
        run.plan.day_ns = 6 * TTF_NS_PER_H;
        run.plan.period_ns = 24 * TTF_NS_PER_H;
        run.plan.phase_ns = 0;
        run.plan.photoperiod_local = true;
        run.plan.day_start_s = 8 * 3600;
        run.plan.count = 8;
        sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 2 * TTF_NS_PER_MIN)->amount = 3600;
        if (!trusted) { /* from the cut on nobody vouches for the time */
            run.config.rtc = false;
            sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 30 * TTF_NS_PER_S)
                ->amount = 20;
        }
        plan.plan = run.plan;
        plan.plan.count = 10;
        longer =
            living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 5, .count = 9});
        whole = living_ask(&run, &plan);
        assert_int_equal(sim_run_through_cuts(&run), 0);
        living_expect_done(&run, longer);
        living_expect_done(&run, whole);
        assert_true(phase_in(&run, "plans/0.json") != 0);
        assert_true(phase_in(&run, "plans/1.json") == phase_in(&run, "plans/0.json"));
        assert_true(phase_in(&run, "plans/2.json") == phase_in(&run, "plans/0.json"));
        sim_run_expect_undamaged(&run, true);
        living_finish(&run);
    }
}

static void what_cannot_change_is_refused_in_a_sentence(void **state)
{
    struct sim_run run;
    struct ttf_ask plan = {.kind = TTF_ASK_PLAN, .from_index = 1};
    int64_t stream, exposure, interval, photoperiod;

    (void)state;
    living_init(&run);
    plan.plan = run.plan;
    strcpy(plan.plan.shots[0].stream, "infrared");
    stream = living_ask(&run, &plan);
    plan.plan = run.plan;
    plan.plan.shots[0].exposure.exposure_ns *= 2;
    exposure = living_ask(&run, &plan);
    interval =
        living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL, .interval_ns = TTF_NS_PER_MS});
    photoperiod = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_PHOTOPERIOD});
    assert_int_equal(sim_run_boot(&run), 0);
    living_expect_refused(&run, stream, "shots", "needs a new dataset of the group");
    living_expect_refused(&run, exposure, "shots", "while a run lives");
    living_expect_refused(&run, interval, "interval", "at least 100 ms");
    living_expect_refused(&run, photoperiod, "lamps.mode", "no photoperiod");
    sim_run_expect(&run, "cccccc");
    assert_null(sim_run_text(&run, "plans/1.json"));
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

static void a_note_is_a_line_beside_the_seal(void **state)
{
    struct sim_run run;
    struct ttf_ask note = {.kind = TTF_ASK_NOTE, .from_index = 2};
    struct ttf_note later = {.utc_ns = TTF_NS_UNKNOWN, .text = "looks dry", .author = "Eva"};
    char *notes;
    int64_t n;

    (void)state;
    living_init(&run);
    note.note = (struct ttf_note){.utc_ns = TTF_NS_UNKNOWN,
                                  .text = "watered \"now\"",
                                  .author = "Jo",
                                  .n_slots = 1,
                                  .slots = {{2, 3}},
                                  .n_tags = 1,
                                  .tags = {"exclude"}};
    n = living_ask(&run, &note);
    assert_int_equal(sim_run_boot(&run), 0);
    living_expect_done(&run, n);
    assert_int_equal(ttf_note_append(ttf_io_posix(), run.path, &later, NULL), 0);
    sim_run_expect_whole(&run, true);
    notes = sim_run_text(&run, "notes.jsonl");
    assert_non_null(notes);
    assert_non_null(strstr(notes, "\"author\":\"Jo\",\"slots\":[[2,3]],\"text\":\"watered "
                                  "\\\"now\\\"\",\"tags\":[\"exclude\"]}\n{\"author\":\"Eva\""));
    assert_int_equal(strncmp(notes, "{\"utc_ns\":17", 12), 0);
    free(notes);
    living_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(more_slots_are_taken_when_asked),
        cmocka_unit_test(a_run_is_cut_short_when_asked_and_sealed),
        cmocka_unit_test(a_run_goes_on_until_an_instant),
        cmocka_unit_test(another_interval_begins_a_segment_and_renumbers_nothing),
        cmocka_unit_test(an_end_behind_the_last_slot_is_taken_whatever_was_changed_before_the_next),
        cmocka_unit_test(changed_twice_before_a_slot_the_next_comes_one_interval_after_the_last),
        cmocka_unit_test(a_pause_is_recorded_slot_by_slot_with_its_reason),
        cmocka_unit_test(a_pause_does_not_outlive_a_power_cut),
        cmocka_unit_test(a_stop_is_obeyed_and_the_run_gone_on_with),
        cmocka_unit_test(another_photoperiod_is_a_plan_and_its_lamps_keep_their_limits),
        cmocka_unit_test(another_interval_does_not_move_the_day),
        cmocka_unit_test(another_length_does_not_move_a_local_day),
        cmocka_unit_test(what_cannot_change_is_refused_in_a_sentence),
        cmocka_unit_test(a_note_is_a_line_beside_the_seal),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
