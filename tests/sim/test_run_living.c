/* SPDX-License-Identifier: Apache-2.0 */
/* Runs that are changed while they live: longer, slower, paused, annotated, stopped; killed at every moment of it. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "sim_run.h"
#include "ttf/hal/clock.h"

static void with_control(struct sim_run *run)
{
    sim_run_init(run);
    run->control = ttf_control_create();
    assert_non_null(run->control);
}

static void finish(struct sim_run *run)
{
    ttf_control_destroy(run->control);
    sim_run_finish(run);
}

static int64_t ask(struct sim_run *run, const struct ttf_ask *ask)
{
    int64_t number = ttf_control_ask(run->control, ask);

    assert_true(number > 0);
    return number;
}

static void expect_done(struct sim_run *run, int64_t number)
{
    struct ttf_err err = {0};
    int r = ttf_control_answer(run->control, number, &err);

    if (r < 0)
        print_error("%s: %s\n", err.where, err.what);
    assert_int_equal(r, 0);
}

static void expect_refused(struct sim_run *run, int64_t number, const char *where, const char *what)
{
    struct ttf_err err = {0};

    assert_int_equal(ttf_control_answer(run->control, number, &err), -EINVAL);
    assert_string_equal(err.where, where);
    if (!strstr(err.what, what))
        print_error("'%s' does not say '%s'\n", err.what, what);
    assert_non_null(strstr(err.what, what));
}

static int64_t due_of(const struct sim_run *run, int64_t index)
{
    struct ttf_slot_record record;
    int64_t due;

    sim_run_record(run, index, &record);
    due = record.due_ns;
    ttf_slot_record_free(&record);
    return due;
}

static int segment_of(const struct sim_run *run, int64_t index, struct ttf_segment *ret)
{
    struct ttf_slot_record record;
    struct ttf_reader *reader;
    int n;

    sim_run_record(run, index, &record);
    n = record.segment;
    ttf_slot_record_free(&record);
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run->path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_segment(reader, n, ret), 0);
    ttf_reader_close(reader);
    return n;
}

/* The whole file, to be freed; NULL if there is none. */
static char *text_of(const struct sim_run *run, const char *name)
{
    char path[160];
    char *text = NULL;
    size_t bytes;

    snprintf(path, sizeof(path), "%s/%s", run->path, name);
    return ttf_io_slurp(ttf_io_posix(), path, 1 << 20, &text, &bytes, NULL) < 0 ? NULL : text;
}

static void expect_text(const struct sim_run *run, const char *name, const char *what)
{
    char *text = text_of(run, name);

    assert_non_null(text);
    if (!strstr(text, what))
        print_error("%s: '%s' lacks '%s'\n", name, text, what);
    assert_non_null(strstr(text, what));
    free(text);
}

static void more_slots_are_taken_when_asked(void **state)
{
    struct sim_run run;
    int64_t n;

    (void)state;
    with_control(&run);
    n = ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 3, .count = 9});
    assert_int_equal(sim_run_boot(&run), 0);
    expect_done(&run, n);
    run.plan.count = 9;
    sim_run_expect(&run, "ccccccccc");
    sim_run_expect_whole(&run, true);
    assert_int_equal(due_of(&run, 8) - due_of(&run, 0), 8 * TTF_NS_PER_MIN);
    assert_int_equal(sim_run_events(&run, "plan", "9 slots instead of 6"), 1);
    expect_text(&run, "plans/1.json", "\"count\": 9");
    finish(&run);
}

static void a_run_is_cut_short_when_asked_and_sealed(void **state)
{
    struct sim_run run;
    int64_t too_few;
    int64_t fewer;

    (void)state;
    with_control(&run);
    too_few = ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 3, .count = 2});
    fewer = ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 4, .count = 4});
    assert_int_equal(sim_run_boot(&run), 0);
    expect_refused(&run, too_few, "count", "3 slots have their records");
    expect_done(&run, fewer);
    run.plan.count = 4;
    sim_run_expect(&run, "cccc");
    sim_run_expect_whole(&run, true);
    finish(&run);
}

static void a_run_goes_on_until_an_instant(void **state)
{
    struct sim_run run;
    struct ttf_ask until = {.kind = TTF_ASK_UNTIL, .from_index = 2};
    int64_t n;

    (void)state;
    with_control(&run);
    /* Slot 0 is due some 13 s after power-on, so slot 9 is the last before 10 min. */
    until.until_utc_ns = run.config.start_utc_ns + 10 * TTF_NS_PER_MIN;
    n = ask(&run, &until);
    assert_int_equal(sim_run_boot(&run), 0);
    expect_done(&run, n);
    run.plan.count = 10;
    sim_run_expect(&run, "cccccccccc");
    sim_run_expect_whole(&run, true);
    finish(&run);
}

static void another_interval_begins_a_segment_and_renumbers_nothing(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;
    int64_t n;

    (void)state;
    with_control(&run);
    n = ask(&run, &(struct ttf_ask){
                      .kind = TTF_ASK_INTERVAL, .from_index = 3, .interval_ns = 20 * TTF_NS_PER_S});
    assert_int_equal(sim_run_boot(&run), 0);
    expect_done(&run, n);
    sim_run_expect(&run, "cccccc");
    assert_int_equal(due_of(&run, 2) - due_of(&run, 0), 2 * TTF_NS_PER_MIN);
    /* One new interval after the slot before it, and so on. */
    assert_int_equal(due_of(&run, 3) - due_of(&run, 2), 20 * TTF_NS_PER_S);
    assert_int_equal(due_of(&run, 5) - due_of(&run, 3), 40 * TTF_NS_PER_S);
    assert_int_equal(segment_of(&run, 2, &segment), 0);
    assert_int_equal(segment.plan, 0);
    assert_int_equal(segment_of(&run, 3, &segment), 1);
    assert_int_equal(segment.plan, 1);
    assert_int_equal(segment.first_index, 3);
    assert_int_equal(segment.interval_ns, 20 * TTF_NS_PER_S);
    assert_int_equal(segment.origin_utc_ns - segment.origin_ns, run.config.start_utc_ns);
    assert_true(run.result.error_max_ns < TTF_NS_PER_MS);
    sim_run_expect_whole(&run, true);
    finish(&run);
}

static void a_pause_is_recorded_slot_by_slot_with_its_reason(void **state)
{
    struct sim_run run;
    int64_t n;

    (void)state;
    with_control(&run);
    n = ask(&run, &(struct ttf_ask){.kind = TTF_ASK_PAUSE, .from_index = 2, .reason = "watering"});
    ask(&run, &(struct ttf_ask){.kind = TTF_ASK_CONTINUE, .from_index = 4});
    assert_int_equal(sim_run_boot(&run), 0);
    expect_done(&run, n);
    sim_run_expect(&run, "cczzcc");
    assert_int_equal(run.result.paused, 2);
    sim_run_expect_reason(&run, 2, "watering");
    sim_run_expect_reason(&run, 3, "watering");
    assert_int_equal(due_of(&run, 5) - due_of(&run, 0), 5 * TTF_NS_PER_MIN);
    assert_int_equal(sim_run_events(&run, "pause", "watering"), 1);
    assert_int_equal(sim_run_events(&run, "pause", "over"), 1);
    sim_run_expect_whole(&run, true);
    finish(&run);
}

/* Whoever forgets a pause over a power cut loses no more than its slots. */
static void a_pause_does_not_outlive_a_power_cut(void **state)
{
    struct sim_run run;

    (void)state;
    with_control(&run);
    run.plan.count = 8;
    ask(&run, &(struct ttf_ask){.kind = TTF_ASK_PAUSE, .from_index = 2});
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount = 70;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    sim_run_expect(&run, "cczzwccc");
    sim_run_expect_reason(&run, 2, "paused by a person");
    sim_run_expect_whole(&run, true);
    finish(&run);
}

static void a_stop_is_obeyed_and_the_run_gone_on_with(void **state)
{
    struct sim_run run;
    int64_t n;

    (void)state;
    with_control(&run);
    n = ask(&run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 3});
    assert_int_equal(sim_run_boot(&run), 0);
    expect_done(&run, n);
    assert_false(run.result.sealed);
    sim_run_expect(&run, "ccc");
    assert_int_equal(sim_run_events(&run, "stop", NULL), 1);
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    finish(&run);
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
    with_control(&run);
    with_days(&run);
    run.config.lamps[1].info.max_on_ns = 200 * TTF_NS_PER_S;
    longer = ask(&run, &day);
    day.day_ns = day.period_ns;
    too_long = ask(&run, &day);
    assert_int_equal(sim_run_boot(&run), 0);
    expect_done(&run, longer);
    expect_refused(&run, too_long, "lamps.day", "right");
    sim_run_expect(&run, "cccccc");
    expect_text(&run, "plans/1.json", "\"day_ns\": 180000000000");
    assert_int_equal(sim_run_events(&run, "plan", "another photoperiod"), 1);
    sim_run_expect_whole(&run, true);
    finish(&run);
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
        with_control(&run);
        with_days(&run);
        run.plan.count = 14;
        memset(burning, 0, sizeof(burning));
        run.on_progress = look_at_right;
        if (changed) { /* slots 4.. come every 30 s: 4 at 3.5 min, 5 at 4 min, ... */
            ask(&run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
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
        finish(&run);
    }
}

static long long phase_in(const struct sim_run *run, const char *name)
{
    static const char key[] = "\"phase_ns\":";
    char *text = text_of(run, name);
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

        with_control(&run);
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
        longer = ask(&run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 5, .count = 9});
        whole = ask(&run, &plan);
        assert_int_equal(sim_run_through_cuts(&run), 0);
        expect_done(&run, longer);
        expect_done(&run, whole);
        assert_true(phase_in(&run, "plans/0.json") != 0);
        assert_true(phase_in(&run, "plans/1.json") == phase_in(&run, "plans/0.json"));
        assert_true(phase_in(&run, "plans/2.json") == phase_in(&run, "plans/0.json"));
        sim_run_expect_undamaged(&run, true);
        finish(&run);
    }
}

static void what_cannot_change_is_refused_in_a_sentence(void **state)
{
    struct sim_run run;
    struct ttf_ask plan = {.kind = TTF_ASK_PLAN, .from_index = 1};
    int64_t stream, exposure, interval, photoperiod;

    (void)state;
    with_control(&run);
    plan.plan = run.plan;
    strcpy(plan.plan.shots[0].stream, "infrared");
    stream = ask(&run, &plan);
    plan.plan = run.plan;
    plan.plan.shots[0].exposure.exposure_ns *= 2;
    exposure = ask(&run, &plan);
    interval = ask(&run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL, .interval_ns = TTF_NS_PER_MS});
    photoperiod = ask(&run, &(struct ttf_ask){.kind = TTF_ASK_PHOTOPERIOD});
    assert_int_equal(sim_run_boot(&run), 0);
    expect_refused(&run, stream, "shots", "needs a new dataset of the group");
    expect_refused(&run, exposure, "shots", "while a run lives");
    expect_refused(&run, interval, "interval", "at least 100 ms");
    expect_refused(&run, photoperiod, "lamps.mode", "no photoperiod");
    sim_run_expect(&run, "cccccc");
    assert_null(text_of(&run, "plans/1.json"));
    sim_run_expect_whole(&run, true);
    finish(&run);
}

static void a_note_is_a_line_beside_the_seal(void **state)
{
    struct sim_run run;
    struct ttf_ask note = {.kind = TTF_ASK_NOTE, .from_index = 2};
    struct ttf_note later = {.utc_ns = TTF_NS_UNKNOWN, .text = "looks dry", .author = "Eva"};
    char *notes;
    int64_t n;

    (void)state;
    with_control(&run);
    note.note = (struct ttf_note){.utc_ns = TTF_NS_UNKNOWN,
                                  .text = "watered \"now\"",
                                  .author = "Jo",
                                  .n_slots = 1,
                                  .slots = {{2, 3}},
                                  .n_tags = 1,
                                  .tags = {"exclude"}};
    n = ask(&run, &note);
    assert_int_equal(sim_run_boot(&run), 0);
    expect_done(&run, n);
    assert_int_equal(ttf_note_append(ttf_io_posix(), run.path, &later, NULL), 0);
    sim_run_expect_whole(&run, true);
    notes = text_of(&run, "notes.jsonl");
    assert_non_null(notes);
    assert_non_null(strstr(notes, "\"author\":\"Jo\",\"slots\":[[2,3]],\"text\":\"watered "
                                  "\\\"now\\\"\",\"tags\":[\"exclude\"]}\n{\"author\":\"Eva\""));
    assert_int_equal(strncmp(notes, "{\"utc_ns\":17", 12), 0);
    free(notes);
    finish(&run);
}

/* ---- killed at every operation ---- */

static struct sim_run *child;
static unsigned operations, kill_at;

static int count_and_die(struct sim_run *run, const char *op, const char *path)
{
    (void)run;
    (void)op;
    (void)path;
    if (++operations == kill_at)
        _exit(77);
    return 0;
}

/* Where in the run's operations slot 1 was committed and the change told, which comes behind it. */
static unsigned begins, ends;

static void note_operations(struct sim_run *run, const struct ttf_progress *progress)
{
    (void)run;
    if (progress->kind == TTF_PROGRESS_SLOT && progress->index == 1)
        begins = operations;
    if (progress->kind == TTF_PROGRESS_EVENT && strstr(progress->text, "plan 1 is in force"))
        ends = operations + 2;
}

/* Killed at that operation: in a process of its own. False: it came to its end. */
static bool boot_and_die(struct sim_run *run, unsigned at)
{
    int status;
    pid_t pid = fork();

    assert_true(pid >= 0);
    if (pid == 0) {
        child = run;
        kill_at = at;
        operations = 0;
        run->fault = count_and_die;
        _exit(sim_run_boot(run) == 0 ? 0 : 1);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFEXITED(status));
    assert_true(WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 0);
    return WEXITSTATUS(status) == 77;
}

static void ask_for_change(struct sim_run *run)
{
    struct ttf_ask plan = {.kind = TTF_ASK_PLAN, .from_index = 2, .plan_yaml = "interval: 30s\n"};

    plan.plan = run->plan;
    plan.plan.interval_ns = 30 * TTF_NS_PER_S;
    plan.plan.count = 8;
    ask(run, &plan);
}

/* By the dataset alone: which plan it is left with. All of it, or nothing. */
static bool new_plan_in_force(const struct sim_run *run)
{
    struct ttf_segment last;
    struct ttf_reader *reader;

    assert_int_equal(ttf_reader_open(ttf_io_posix(), run->path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_segment(reader, ttf_reader_summary(reader)->n_segments - 1, &last),
                     0);
    ttf_reader_close(reader);
    assert_true(last.plan == 0 || last.plan == 1);
    assert_int_equal(last.interval_ns, last.plan == 1 ? 30 * TTF_NS_PER_S : TTF_NS_PER_MIN);
    return last.plan == 1;
}

/* Gone on with by the plan it was begun with, as whoever starts the box again does. */
static void expect_gone_on_with(struct sim_run *run, bool changed)
{
    char results[32];

    /* As the program does: a new boot, an outage after the last slot. */
    run->config.power_on_ns = 200 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(run), 0);
    sim_run_results(run, results, sizeof(results));
    assert_int_equal(strlen(results), changed ? 8 : 6);
    assert_int_equal(due_of(run, 5) - due_of(run, 4), changed ? 30 * TTF_NS_PER_S : TTF_NS_PER_MIN);
    assert_int_equal(run->result.total, changed ? 8 : 6);
    assert_int_equal(sim_run_events(run, "plan", "plan 1 has come since"), changed);
    run->plan.count = changed ? 8 : 6;
    sim_run_expect_whole(run, true);
}

static void killed_at_any_operation_of_a_change_the_old_or_the_new_plan_is_in_force(void **state)
{
    unsigned with_old = 0;
    unsigned with_new = 0;
    struct sim_run run;

    (void)state;
    with_control(&run);
    ask_for_change(&run);
    operations = kill_at = 0;
    run.fault = count_and_die;
    run.on_progress = note_operations;
    assert_int_equal(sim_run_boot(&run), 0);
    run.plan.count = 8;
    sim_run_expect_whole(&run, true);
    expect_text(&run, "plans/1.yaml", "interval: 30s\n");
    finish(&run);
    assert_true(begins > 0 && ends > begins);
    for (unsigned at = begins + 1; at <= ends; at++) {
        bool changed;

        with_control(&run);
        ask_for_change(&run);
        assert_true(boot_and_die(&run, at));
        changed = new_plan_in_force(&run);
        with_old += !changed;
        with_new += changed;
        ttf_control_destroy(run.control); /* the next boot knows nothing of it */
        run.control = NULL;
        expect_gone_on_with(&run, changed);
        finish(&run);
    }
    print_message("killed %u times: %u with the old plan, %u with the new one\n", ends - begins,
                  with_old, with_new);
    assert_true(with_old > 5 && with_new > 2);
}

/* ---- run again with this plan or that ---- */

static void stopped_after_a_change(struct sim_run *run)
{
    with_control(run);
    run->plan.count = 10;
    ask(run, &(struct ttf_ask){
                 .kind = TTF_ASK_INTERVAL, .from_index = 2, .interval_ns = 30 * TTF_NS_PER_S});
    ask(run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 4});
    assert_int_equal(sim_run_boot(run), 0);
    sim_run_expect(run, "cccc");
    run->config.power_on_ns = run->ended_ns + TTF_NS_PER_S;
}

static void the_first_plan_goes_on_with_what_it_has_become(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;

    (void)state;
    stopped_after_a_change(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    segment_of(&run, 9, &segment);
    assert_int_equal(segment.plan, 1);
    assert_int_equal(segment.interval_ns, 30 * TTF_NS_PER_S);
    assert_int_equal(sim_run_events(&run, "plan", "plan given is plan 0, but plan 1"), 1);
    sim_run_expect_whole(&run, true);
    /* Complete: nothing left to do by the first plan either. */
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.sealed);
    finish(&run);
}

static void a_plan_that_is_new_is_a_change(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;

    (void)state;
    stopped_after_a_change(&run);
    run.plan.interval_ns = 45 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    segment_of(&run, 9, &segment);
    assert_int_equal(segment.plan, 2);
    assert_int_equal(segment.interval_ns, 45 * TTF_NS_PER_S);
    sim_run_expect_whole(&run, true);
    finish(&run);
}

static void the_first_plan_is_gone_back_to_when_that_is_meant(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;

    (void)state;
    stopped_after_a_change(&run);
    run.plan_as_given = true;
    assert_int_equal(sim_run_boot(&run), 0);
    segment_of(&run, 9, &segment);
    assert_int_equal(segment.plan, 2);
    assert_int_equal(segment.interval_ns, TTF_NS_PER_MIN);
    sim_run_expect_whole(&run, true);
    finish(&run);
}

/* ---- asked on a storage that is away ---- */

static void away_for_a_while(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind == TTF_PROGRESS_SLOT && progress->index == 1)
        run->failing = 5; /* the change, and the next slot's files */
}

static void a_change_waits_for_its_storage_in_its_turn(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;
    int64_t n;

    (void)state;
    with_control(&run);
    run.plan.count = 8;
    run.on_progress = away_for_a_while;
    n = ask(&run, &(struct ttf_ask){
                      .kind = TTF_ASK_INTERVAL, .from_index = 2, .interval_ns = 30 * TTF_NS_PER_S});
    if (sim_run_boot(&run) < 0)
        print_error("%s: %s\n", run.err.where, run.err.what);
    assert_int_equal(run.code, 0);
    expect_done(&run, n);
    assert_int_equal(run.result.slots, 8);
    assert_int_equal(segment_of(&run, 2, &segment), 1);
    assert_int_equal(segment.interval_ns, 30 * TTF_NS_PER_S);
    sim_run_expect_whole(&run, true);
    finish(&run);
}

static void many_asks_are_answered_each(void **state)
{
    struct sim_run run;
    int64_t numbers[TTF_ASKS_MAX];
    struct ttf_ask never = {.kind = TTF_ASK_PAUSE, .from_index = 1000};

    (void)state;
    with_control(&run);
    for (int i = 0; i < TTF_ASKS_MAX - 1; i++)
        numbers[i] = ask(
            &run, &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 1, .count = 6 + i % 2});
    ask(&run, &never);
    assert_int_equal(ttf_control_ask(run.control, &never), -EAGAIN);
    assert_int_equal(sim_run_boot(&run), 0);
    for (int i = 0; i < TTF_ASKS_MAX - 1; i++)
        expect_done(&run, numbers[i]);
    assert_int_equal(ttf_control_waiting(run.control), 1);
    assert_int_equal(ttf_control_answer(run.control, 12345, NULL), -ENOENT);
    sim_run_expect_whole(&run, true);
    finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(more_slots_are_taken_when_asked),
        cmocka_unit_test(a_run_is_cut_short_when_asked_and_sealed),
        cmocka_unit_test(a_run_goes_on_until_an_instant),
        cmocka_unit_test(another_interval_begins_a_segment_and_renumbers_nothing),
        cmocka_unit_test(a_pause_is_recorded_slot_by_slot_with_its_reason),
        cmocka_unit_test(a_pause_does_not_outlive_a_power_cut),
        cmocka_unit_test(a_stop_is_obeyed_and_the_run_gone_on_with),
        cmocka_unit_test(another_photoperiod_is_a_plan_and_its_lamps_keep_their_limits),
        cmocka_unit_test(another_interval_does_not_move_the_day),
        cmocka_unit_test(another_length_does_not_move_a_local_day),
        cmocka_unit_test(what_cannot_change_is_refused_in_a_sentence),
        cmocka_unit_test(a_note_is_a_line_beside_the_seal),
        cmocka_unit_test(killed_at_any_operation_of_a_change_the_old_or_the_new_plan_is_in_force),
        cmocka_unit_test(the_first_plan_goes_on_with_what_it_has_become),
        cmocka_unit_test(a_plan_that_is_new_is_a_change),
        cmocka_unit_test(the_first_plan_is_gone_back_to_when_that_is_meant),
        cmocka_unit_test(a_change_waits_for_its_storage_in_its_turn),
        cmocka_unit_test(many_asks_are_answered_each),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
