/* SPDX-License-Identifier: Apache-2.0 */
/* A plain capture, from plan to sealed dataset. */
#include "cmocka_includes.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim_run.h"

static void a_plain_plan_becomes_a_sealed_dataset(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    sim_run_init(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.sealed);
    assert_int_equal(strlen(run.result.digest), 64);
    assert_int_equal(run.result.slots, 6);
    assert_int_equal(run.result.captured, 6);
    assert_int_equal(run.slots_told, 6);
    assert_int_equal(run.bites, 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    assert_true(run.result.error_max_ns < TTF_NS_PER_MS);

    sim_run_record(&run, 3, &record);
    assert_int_equal(record.n_images, 1);
    assert_string_equal(record.images[0].stream, "main");
    assert_int_equal(record.images[0].n_files, 2);
    assert_int_equal(record.images[0].n_averaged, 1);
    assert_int_equal(record.images[0].n_shots, 1);
    assert_int_equal(record.images[0].shots[0].granted.exposure_ns, 20 * TTF_NS_PER_MS);
    assert_string_equal(record.images[0].shots[0].lamps[0].name, "left");
    assert_int_equal(record.images[0].shots[0].lamps[0].commanded_permille, 1000);
    assert_true(record.images[0].shots[0].lamps[0].measured_permille > 500);
    assert_int_equal(record.images[0].shots[0].lamps[1].commanded_permille, 0);
    assert_true(record.images[0].mean_level > 0);
    assert_int_equal(record.n_sensors, 2);
    assert_true(record.sensors[0].ok);
    ttf_slot_record_free(&record);
    sim_run_finish(&run);
}

static void everything_the_simulator_makes_says_simulated(void **state)
{
    struct sim_run run;
    char path[160];
    char *text;
    size_t bytes;

    (void)state;
    sim_run_init(&run);
    run.plan.count = 1;
    assert_int_equal(sim_run_boot(&run), 0);
    snprintf(path, sizeof(path), "%s/dataset.json", run.path);
    assert_int_equal(ttf_io_slurp(ttf_io_posix(), path, 1 << 20, &text, &bytes, NULL), 0);
    assert_non_null(strstr(text, "SIMULATED"));
    assert_non_null(strstr(text, "\"simulated\": true"));
    free(text);
    sim_run_finish(&run);
}

static void stop_after_two(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind == TTF_PROGRESS_SLOT && progress->index == 1)
        __atomic_store_n(&run->stop, 1, __ATOMIC_RELAXED);
}

static void a_stopped_run_goes_on_where_it_was(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.on_progress = stop_after_two;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_false(run.result.sealed);
    assert_int_equal(run.result.slots, 2);
    assert_int_equal(sim_run_events(&run, "stop", NULL), 1);
    sim_run_expect_whole(&run, false);
    run.stop = 0;
    run.on_progress = NULL;
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.sealed);
    assert_true(run.result.resumed);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void a_finished_dataset_is_left_as_it_is(void **state)
{
    struct sim_run run;
    char digest[65];

    (void)state;
    sim_run_init(&run);
    run.plan.count = 2;
    assert_int_equal(sim_run_boot(&run), 0);
    snprintf(digest, sizeof(digest), "%s", run.result.digest);
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_H;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.sealed);
    assert_string_equal(run.result.digest, digest);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void another_plan_s_streams_do_not_fit(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.on_progress = stop_after_two;
    assert_int_equal(sim_run_boot(&run), 0);
    run.stop = 0;
    strcpy(run.plan.shots[0].stream, "other");
    run.config.power_on_ns = run.ended_ns;
    assert_int_equal(sim_run_boot(&run), -EINVAL);
    assert_non_null(strstr(run.err.what, "other"));
    sim_run_finish(&run);
}

static void a_rehearsal_reports_and_seals_nothing(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.rehearse = 3;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_false(run.result.sealed);
    assert_int_equal(run.result.captured, 3);
    assert_true(run.result.busy_ns > 10 * TTF_NS_PER_S); /* the settling is in it */
    assert_true(run.result.busy_ns < 12 * TTF_NS_PER_S);
    assert_true(run.result.sustained_interval_ns > 10 * TTF_NS_PER_S);
    assert_true(run.result.headroom_stops > 0.1 && run.result.headroom_stops < 6);
    assert_true(run.result.sharpness > 0);
    assert_true(fabs(run.result.settle_change) < 0.2);
    assert_true(run.result.slot_bytes > 48 * 32 * 8);
    sim_run_finish(&run);
}

static void a_rehearsal_does_not_touch_a_dataset(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.plan.count = 1;
    assert_int_equal(sim_run_boot(&run), 0);
    run.rehearse = 3;
    assert_int_equal(sim_run_boot(&run), -EEXIST);
    sim_run_expect(&run, "c");
    sim_run_finish(&run);
}

static void a_rehearsal_is_never_gone_on_with(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.rehearse = 3;
    assert_int_equal(sim_run_boot(&run), 0);
    run.rehearse = 0;
    run.config.power_on_ns = run.ended_ns;
    assert_int_equal(sim_run_boot(&run), -EINVAL);
    assert_non_null(strstr(run.err.what, "rehearsal"));
    sim_run_finish(&run);
}

static void a_longer_plan_goes_on_with_a_finished_dataset(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.plan.count = 2;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect_whole(&run, true);
    /* An hour later, with six more slots to take; those of the hour were nobody's. */
    run.plan.count = 2 + TTF_NS_PER_H / run.plan.interval_ns + 6;
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_H;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.sealed);
    sim_run_expect_whole(&run, true);
    sim_run_expect_reason(&run, 2, "the run had come to its end");
    assert_int_equal(run.result.power, 0);
    assert_in_range(run.result.captured, 2 + 5, 2 + 7);
    assert_int_equal(run.result.slots, run.plan.count);
    sim_run_finish(&run);
}

static void a_finished_dataset_of_another_plan_is_refused(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.plan.count = 2;
    assert_int_equal(sim_run_boot(&run), 0);
    run.plan.interval_ns *= 2;
    run.config.power_on_ns = run.ended_ns;
    assert_int_equal(sim_run_boot(&run), -EINVAL);
    assert_non_null(strstr(run.err.what, "another plan"));
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void a_capture_begins_when_it_is_told_to(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;
    struct ttf_reader *reader;

    (void)state;
    sim_run_init(&run);
    run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    run.plan.start_utc_ns = run.config.start_utc_ns + TTF_NS_PER_H;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_record(&run, 0, &record);
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run.path, &reader, NULL), 0);
    assert_in_range(ttf_reader_due_utc_ns(reader, &record) - run.plan.start_utc_ns + 1000, 0, 2000);
    ttf_reader_close(reader);
    /* The lamp was not burning for an hour before: it is still warming up. */
    assert_true(record.images[0].shots[0].lamps[0].measured_permille < 950);
    assert_true(record.images[0].shots[0].lamps[0].measured_permille > 500);
    ttf_slot_record_free(&record);
    sim_run_finish(&run);
}

static void a_capture_a_box_cannot_do_is_refused_before_it_begins(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    strcpy(run.plan.shots[0].levels[0].lamp, "sun");
    assert_int_equal(sim_run_boot(&run), -EINVAL);
    assert_string_equal(run.err.where, "shots[0].lamps.sun");
    sim_run_finish(&run);
}

static void a_full_disk_is_noticed_before_it_begins(void **state)
{
    struct sim_run run;
    struct ttf_io_stat st;

    (void)state;
    sim_run_init(&run);
    run.plan.reserve_bytes = INT64_C(1) << 60;
    assert_int_equal(sim_run_boot(&run), -ENOSPC);
    assert_true(ttf_io_posix()->ops->stat(ttf_io_posix(), run.path, &st) < 0);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plain_plan_becomes_a_sealed_dataset),
        cmocka_unit_test(everything_the_simulator_makes_says_simulated),
        cmocka_unit_test(a_stopped_run_goes_on_where_it_was),
        cmocka_unit_test(a_finished_dataset_is_left_as_it_is),
        cmocka_unit_test(another_plan_s_streams_do_not_fit),
        cmocka_unit_test(a_rehearsal_reports_and_seals_nothing),
        cmocka_unit_test(a_rehearsal_does_not_touch_a_dataset),
        cmocka_unit_test(a_rehearsal_is_never_gone_on_with),
        cmocka_unit_test(a_longer_plan_goes_on_with_a_finished_dataset),
        cmocka_unit_test(a_finished_dataset_of_another_plan_is_refused),
        cmocka_unit_test(a_capture_begins_when_it_is_told_to),
        cmocka_unit_test(a_capture_a_box_cannot_do_is_refused_before_it_begins),
        cmocka_unit_test(a_full_disk_is_noticed_before_it_begins),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
