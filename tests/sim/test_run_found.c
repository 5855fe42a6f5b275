/* SPDX-License-Identifier: Apache-2.0 */
/* What captures at random (chaos.c) have found, each as a capture of its own. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim_run.h"
#include "ttf/dataset/reader.h"

/* Runs it again from the first power-on, into another folder: the same instants. */
static void again(struct sim_run *run)
{
    snprintf(run->path, sizeof(run->path), "%s/again", run->folder);
}

static void a_frame_gone_wrong_while_arming_does_not_set_the_exposure_of_the_run(void **state)
{
    (void)state;
    for (int64_t at = 0; at < 8; at++) {
        struct ttf_slot_record record;
        struct sim_run run;

        sim_run_init(&run);
        /* A frame of those that the exposure is locked by. */
        sim_run_fault(&run, TTF_FAULT_WRONG_SETTINGS, TTF_NS_PER_S + at * 40 * TTF_NS_PER_MS);
        assert_int_equal(sim_run_boot(&run), 0);
        sim_run_expect(&run, "cccccc");
        sim_run_record(&run, 5, &record);
        assert_int_equal(record.images[0].shots[0].granted.exposure_ns, 20 * TTF_NS_PER_MS);
        assert_string_equal(record.images[0].flags, "");
        ttf_slot_record_free(&record);
        sim_run_finish(&run);
    }
}

static void
a_camera_that_exposes_ever_longer_while_arming_is_not_locked_at_its_longest(void **state)
{
    struct sim_run run;
    struct ttf_fault *wrong;

    (void)state;
    sim_run_init(&run);
    wrong = sim_run_fault(&run, TTF_FAULT_WRONG_SETTINGS, 0);
    wrong->duration_ns = TTF_NS_PER_H;
    wrong->amount = 20000;
    assert_int_equal(sim_run_boot(&run), -EIO);
    sim_run_finish(&run);
}

static void a_door_open_for_a_part_of_an_exposure_is_flagged(void **state)
{
    struct ttf_slot_record record;
    struct sim_run run;
    struct ttf_fault *door;
    int64_t due;

    (void)state;
    sim_run_init(&run);
    run.plan.lamps = TTF_LAMPS_NONE;
    run.plan.shots[0].n_levels = 0;
    run.plan.shots[0].exposure.exposure_ns = TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    due = sim_run_due_ns(&run, 2);
    again(&run);
    /* Opened and closed again before the frame is read out. */
    door = sim_run_fault(&run, TTF_FAULT_DOOR_OPEN, due - 100 * TTF_NS_PER_MS);
    door->duration_ns = 200 * TTF_NS_PER_MS;
    /* Open when slot 4's frame comes, not when its exposure was begun. */
    door = sim_run_fault(&run, TTF_FAULT_DOOR_OPEN, due + 2 * TTF_NS_PER_MIN);
    door->duration_ns = 10 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    for (int64_t k = 0; k < 6; k++) {
        sim_run_record(&run, k, &record);
        assert_int_equal(strstr(record.images[0].flags, "door-open") != NULL, k == 2 || k == 4);
        ttf_slot_record_free(&record);
    }
    assert_int_equal(sim_run_events(&run, "door", "opened"), 2);
    assert_int_equal(sim_run_events(&run, "door", "closed"), 2);
    sim_run_finish(&run);
}

static void a_clock_that_was_set_is_no_outage_at_the_next_power_cut(void **state)
{
    static const int64_t steps_s[] = {3600, -3600};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct sim_run run;

        sim_run_init(&run);
        run.plan.count = 12;
        sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 2 * TTF_NS_PER_MIN)->amount = steps_s[i];
        sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount =
            130;
        assert_int_equal(sim_run_through_cuts(&run), 0);
        sim_run_expect(&run, "ccccwwcccccc");
        sim_run_expect_whole(&run, true);
        sim_run_finish(&run);
    }
}

static void a_last_record_that_must_wait_is_waited_for(void **state)
{
    struct sim_run run;
    int64_t due;

    (void)state;
    sim_run_init(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    due = sim_run_due_ns(&run, 5);
    again(&run);
    sim_run_fault(&run, TTF_FAULT_IO_ERROR, due)->duration_ns = 20 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.sealed);
    sim_run_expect(&run, "cccccf");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void a_last_record_that_cannot_be_written_is_no_success(void **state)
{
    struct sim_run run;
    int64_t due;

    (void)state;
    sim_run_init(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    due = sim_run_due_ns(&run, 5);
    again(&run);
    sim_run_fault(&run, TTF_FAULT_IO_ERROR, due)->duration_ns = TTF_NS_PER_DAY;
    assert_int_equal(sim_run_boot(&run), -EIO);
    assert_false(run.result.sealed);
    sim_run_expect(&run, "ccccc");
    run.config.n_faults = 0;
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_MIN;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccw");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void fail_after_the_last(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind == TTF_PROGRESS_SLOT && progress->index == run->plan.count - 1)
        run->failing = 12;
}

static void a_seal_that_fails_is_tried_again(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.on_progress = fail_after_the_last;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(run.failing, 0);
    assert_true(run.result.sealed);
    assert_int_equal(run.result.slots, 6);
    assert_int_equal(strlen(run.result.digest), 64);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void a_local_day_is_gone_on_with_after_two_cuts_without_a_clock(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.config.rtc = false;
    run.plan.count = 12;
    run.plan.lamps = TTF_LAMPS_PHOTOPERIOD;
    run.plan.photoperiod_local = true;
    run.plan.period_ns = TTF_NS_PER_DAY;
    run.plan.day_ns = 12 * TTF_NS_PER_H;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S);
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 9 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S);
    assert_int_equal(sim_run_through_cuts(&run), 0);
    sim_run_expect(&run, "cccccccccccc");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void frames_gone_wrong_alike_while_arming_are_outvoted_by_one_as_asked(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 40; seed++) {
        struct ttf_slot_record record;
        struct ttf_fault *wrong;
        struct sim_run run;

        sim_run_init(&run);
        run.config.seed = seed;
        run.plan.count = 1;
        /* One frame in five, each time by the same: among those that the exposure is locked by. */
        wrong = sim_run_fault(&run, TTF_FAULT_WRONG_SETTINGS, 1);
        wrong->rate_per_million = 200000;
        wrong->duration_ns = 5 * TTF_NS_PER_S;
        wrong->amount = -23;
        assert_int_equal(sim_run_boot(&run), 0);
        sim_run_record(&run, 0, &record);
        assert_int_equal(record.images[0].shots[0].granted.exposure_ns, 20 * TTF_NS_PER_MS);
        assert_string_equal(record.images[0].flags, "");
        ttf_slot_record_free(&record);
        sim_run_finish(&run);
    }
}

static void stop_at_the_first(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind == TTF_PROGRESS_SLOT && progress->index == 0)
        run->stop = 1;
}

static void a_clock_set_while_the_last_slots_are_written_is_no_outage_either(void **state)
{
    static const int64_t steps_s[] = {520, -520};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct ttf_slot_record record;
        struct sim_run run;
        int64_t due;

        sim_run_init(&run);
        /* Stopped once slot 0 is told: slot 1 has been exposed, and is written for a minute yet. */
        run.config.cost_commit_ns = 70 * TTF_NS_PER_S;
        run.on_progress = stop_at_the_first;
        sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, 120 * TTF_NS_PER_S)->amount = steps_s[i];
        assert_int_equal(sim_run_boot(&run), 0);
        sim_run_expect(&run, "cc");
        assert_int_equal(sim_run_events(&run, "clock-step", NULL), 1);
        due = sim_run_due_ns(&run, 5);
        run.config.cost_commit_ns = 50 * TTF_NS_PER_MS;
        run.config.power_on_ns = run.ended_ns + TTF_NS_PER_MIN;
        run.on_progress = NULL;
        run.stop = 0;
        assert_int_equal(sim_run_boot(&run), 0);
        sim_run_expect(&run, "ccwwcc");
        sim_run_record(&run, 5, &record);
        assert_true(record.due_ns + run.config.power_on_ns == due);
        ttf_slot_record_free(&record);
        sim_run_expect_whole(&run, true);
        sim_run_finish(&run);
    }
}

static void a_run_that_failed_is_brought_to_its_end_without_the_watchdog(void **state)
{
    struct sim_run run;
    int64_t due;

    (void)state;
    sim_run_init(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    due = sim_run_due_ns(&run, 2);
    again(&run);
    /* Slots are still being written, for a minute each, when nothing can be written any more. */
    run.config.cost_commit_ns = 70 * TTF_NS_PER_S;
    run.plan.count = 12;
    sim_run_fault(&run, TTF_FAULT_IO_ERROR, due)->duration_ns = TTF_NS_PER_DAY;
    assert_int_equal(sim_run_boot(&run), -EIO);
    assert_int_equal(run.bites, 0);
    sim_run_finish(&run);
}

static void a_disk_that_stays_full_is_called_full_for_each_slot(void **state)
{
    struct sim_run run;
    int64_t due;

    (void)state;
    sim_run_init(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    due = sim_run_due_ns(&run, 2);
    again(&run);
    sim_run_fault(&run, TTF_FAULT_DISK_FULL, due)->duration_ns = 70 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccffcc");
    sim_run_expect_reason(&run, 2, "disk full");
    sim_run_expect_reason(&run, 3, "disk full");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* Where the first event of a kind stands in events.jsonl. */
static const char *event_in(const char *all, const char *kind)
{
    char want[40];

    snprintf(want, sizeof(want), "\"kind\":\"%s\"", kind);
    return strstr(all, want);
}

/* The clock is set while nothing can be written; the door is opened when that is over, and before the next slot. */
static void what_a_storage_that_was_away_missed_is_written_in_order(void **state)
{
    struct ttf_segment before, after;
    struct ttf_reader *reader;
    struct sim_run run;
    char path[160];
    char *all = NULL;
    size_t bytes;
    int64_t due;

    (void)state;
    sim_run_init(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    due = sim_run_due_ns(&run, 2);
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run.path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_segment(reader, 0, &before), 0);
    ttf_reader_close(reader);
    again(&run);
    sim_run_fault(&run, TTF_FAULT_IO_ERROR, due + 10 * TTF_NS_PER_S)->duration_ns =
        15 * TTF_NS_PER_S;
    sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, due + 15 * TTF_NS_PER_S)->amount = 3600;
    sim_run_fault(&run, TTF_FAULT_DOOR_OPEN, due + 35 * TTF_NS_PER_S)->duration_ns =
        5 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    snprintf(path, sizeof(path), "%s/events.jsonl", run.path);
    assert_int_equal(ttf_io_slurp(ttf_io_posix(), path, 1 << 24, &all, &bytes, NULL), 0);
    assert_non_null(event_in(all, "clock-step"));
    assert_non_null(event_in(all, "door"));
    assert_true(event_in(all, "clock-step") < event_in(all, "door"));
    free(all);
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run.path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_segment(reader, 0, &after), 0);
    ttf_reader_close(reader);
    assert_true(after.origin_utc_ns - before.origin_utc_ns > 3599 * TTF_NS_PER_S);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_gone_wrong_while_arming_does_not_set_the_exposure_of_the_run),
        cmocka_unit_test(
            a_camera_that_exposes_ever_longer_while_arming_is_not_locked_at_its_longest),
        cmocka_unit_test(a_door_open_for_a_part_of_an_exposure_is_flagged),
        cmocka_unit_test(a_clock_that_was_set_is_no_outage_at_the_next_power_cut),
        cmocka_unit_test(a_last_record_that_must_wait_is_waited_for),
        cmocka_unit_test(a_last_record_that_cannot_be_written_is_no_success),
        cmocka_unit_test(a_seal_that_fails_is_tried_again),
        cmocka_unit_test(a_local_day_is_gone_on_with_after_two_cuts_without_a_clock),
        cmocka_unit_test(frames_gone_wrong_alike_while_arming_are_outvoted_by_one_as_asked),
        cmocka_unit_test(a_clock_set_while_the_last_slots_are_written_is_no_outage_either),
        cmocka_unit_test(a_run_that_failed_is_brought_to_its_end_without_the_watchdog),
        cmocka_unit_test(a_disk_that_stays_full_is_called_full_for_each_slot),
        cmocka_unit_test(what_a_storage_that_was_away_missed_is_written_in_order),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
