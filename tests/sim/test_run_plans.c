/* SPDX-License-Identifier: Apache-2.0 */
/* Plans beyond the plain one: several shots, brackets, averages, photoperiods, regions. */
#include "cmocka_includes.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "sim_run.h"

static void light(struct ttf_plan_shot *shot, const char *lamp, unsigned permille)
{
    snprintf(shot->levels[shot->n_levels].lamp, sizeof(shot->levels[0].lamp), "%s", lamp);
    shot->levels[shot->n_levels++].permille = permille;
}

/* Two lamp states and a bracket: five images a slot in three streams. */
static void three_shots(struct ttf_plan *plan)
{
    struct ttf_plan_shot plain = plan->shots[0];

    plan->n_shots = 3;
    plan->settle_ns = 3 * TTF_NS_PER_S;
    plan->shots[0].average = 4;
    plan->shots[1] = plain;
    strcpy(plan->shots[1].stream, "raking");
    strcpy(plan->shots[1].channel, "raking-right");
    plan->shots[1].n_levels = 0;
    light(&plan->shots[1], "right", 500);
    plan->shots[2] = plain;
    strcpy(plan->shots[2].stream, "hdr");
    strcpy(plan->shots[2].channel, "both");
    plan->shots[2].n_levels = 0;
    light(&plan->shots[2], "left", 1000);
    light(&plan->shots[2], "right", 1000);
    plan->shots[2].n_brackets = 3;
    plan->shots[2].brackets[0] = 0.5;
    plan->shots[2].brackets[1] = 1;
    plan->shots[2].brackets[2] = 4;
}

static void expect_three_shots(const struct ttf_slot_record *record)
{
    static const char *const streams[] = {"main", "raking", "hdr", "hdr", "hdr"};
    static const int64_t exposures_ms[] = {20, 20, 10, 20, 80};
    static const int left[] = {1000, 0, 1000, 1000, 1000};

    assert_int_equal(record->n_images, 5);
    for (unsigned i = 0; i < 5; i++) {
        const struct ttf_image *image = &record->images[i];

        assert_string_equal(image->stream, streams[i]);
        assert_int_equal(image->bracket, i < 2 ? -1 : (int)i - 2);
        assert_int_equal(image->n_files, 2);
        assert_int_equal(image->n_averaged, i == 0 ? 4 : 1);
        assert_int_equal(image->n_shots, i == 0 ? 4 : 1);
        assert_int_equal(image->shots[0].granted.exposure_ns, exposures_ms[i] * TTF_NS_PER_MS);
        assert_int_equal(image->shots[0].lamps[0].commanded_permille, left[i]);
        assert_true(i == 0 || image->shots[0].start_ns > record->images[i - 1].shots[0].end_ns);
    }
    /* The first exposure's middle is what met the slot. */
    assert_in_range(record->middle_ns - record->due_ns + TTF_NS_PER_MS, 0, 2 * TTF_NS_PER_MS);
}

static void three_shots_a_slot_work(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;
    struct ttf_reader *reader;

    (void)state;
    sim_run_init(&run);
    three_shots(&run.plan);
    run.plan.reference = (struct ttf_region){8, 8, 8, 8};
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    for (int64_t k = 0; k < 6; k++) {
        sim_run_record(&run, k, &record);
        expect_three_shots(&record);
        assert_false(isnan(record.images[0].reference_level));
        ttf_slot_record_free(&record);
    }
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run.path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_manifest(reader)->n_streams, 3);
    assert_int_equal(ttf_reader_manifest(reader)->n_channels, 3);
    assert_string_equal(ttf_manifest_primary(ttf_reader_manifest(reader))->id, "main");
    ttf_reader_close(reader);
    sim_run_finish(&run);
}

static void a_shot_that_fails_leaves_the_slot_partial(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    sim_run_init(&run);
    three_shots(&run.plan);
    /* From after slot 2's first shot to its end. */
    sim_run_fault(&run, TTF_FAULT_FRAME_CORRUPT, 0);
    assert_int_equal(sim_run_boot(&run), 0);
    run.config.faults[0].at_ns = sim_run_due_ns(&run, 2) + TTF_NS_PER_S;
    run.config.faults[0].duration_ns = 4 * TTF_NS_PER_S;
    snprintf(run.path, sizeof(run.path), "%s/again", run.folder);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccpccc");
    sim_run_record(&run, 2, &record);
    assert_string_equal(record.images[0].lacking, "");
    assert_string_equal(record.images[1].lacking, "corrupt");
    assert_string_equal(record.images[2].lacking, "");
    assert_string_equal(record.reason, "corrupt");
    ttf_slot_record_free(&record);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void an_average_with_a_bad_frame_takes_one_more(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    sim_run_init(&run);
    run.plan.shots[0].average = 8;
    sim_run_fault(&run, TTF_FAULT_FRAME_CORRUPT, 95 * TTF_NS_PER_S);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_record(&run, 2, &record);
    assert_int_equal(record.images[0].n_averaged, 8);
    assert_int_equal(record.images[0].n_shots, 9);
    assert_string_equal(record.images[0].shots[0].refused, "corrupt");
    ttf_slot_record_free(&record);
    sim_run_finish(&run);
}

static void by_day_the_growth_lamp_burns(void **state)
{
    struct sim_run run;
    double day = 0;
    double night = 0;

    (void)state;
    sim_run_init(&run);
    run.config.day_swing_degc = 0;
    run.config.width = run.config.height = 16;
    run.plan.interval_ns = TTF_NS_PER_H;
    run.plan.count = 48;
    run.plan.lamps = TTF_LAMPS_PHOTOPERIOD;
    run.plan.day_ns = 12 * TTF_NS_PER_H;
    run.plan.period_ns = 24 * TTF_NS_PER_H;
    strcpy(run.plan.day_levels[0].lamp, "right");
    run.plan.day_levels[0].permille = 800;
    run.plan.n_day_levels = 1;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(run.result.captured, 48);
    for (int64_t k = 0; k < 48; k++) {
        struct ttf_slot_record record;

        sim_run_record(&run, k, &record);
        /* During a shot it is as the shot says, by day too. */
        assert_int_equal(record.images[0].shots[0].lamps[1].commanded_permille, 0);
        if (k % 24 >= 3 && k % 24 < 12)
            day += (double)record.sensors[0].value / 18e3;
        if (k % 24 >= 15)
            night += (double)record.sensors[0].value / 18e3;
        ttf_slot_record_free(&record);
    }
    assert_true(day - night > 3); /* it warms the box by 4.8 degrees */
    assert_true(fabs(night - 22) < 1);
    sim_run_finish(&run);
}

static void a_local_day_begins_by_the_clock_on_the_wall(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;
    double levels[24];

    (void)state;
    sim_run_init(&run);
    run.config.day_swing_degc = 0;
    run.config.width = run.config.height = 16;
    run.plan.interval_ns = TTF_NS_PER_H;
    run.plan.count = 24;
    run.plan.lamps = TTF_LAMPS_PHOTOPERIOD;
    run.plan.photoperiod_local = true;
    run.plan.day_start_s = 8 * 3600;
    strcpy(run.plan.zone, "Europe/Berlin");
    run.plan.zone_offset_s = 3600; /* the box begins at 00:00 UTC, 01:00 there */
    run.plan.day_ns = 6 * TTF_NS_PER_H;
    run.plan.period_ns = 24 * TTF_NS_PER_H;
    strcpy(run.plan.day_levels[0].lamp, "right");
    run.plan.day_levels[0].permille = 1000;
    run.plan.n_day_levels = 1;
    /* A resume in between must not move the day. */
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 5 * TTF_NS_PER_H + 100 * TTF_NS_PER_S)->amount = 60;
    assert_int_equal(sim_run_through_cuts(&run), 0);
    sim_run_expect(&run, "cccccccccccccccccccccccc");
    for (int64_t k = 0; k < 24; k++) {
        sim_run_record(&run, k, &record);
        levels[k] = (double)record.sensors[0].value / 1e3;
        ttf_slot_record_free(&record);
    }
    /* Day from 08:00 to 14:00 there: slots 7 to 13. */
    assert_true(levels[6] < 23.5);
    assert_true(levels[8] > 25);
    assert_true(levels[13] > 25);
    assert_true(levels[16] < 23.5);
    sim_run_finish(&run);
}

static void continuous_lamps_stay_on_between_slots(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    sim_run_init(&run);
    run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    run.plan.interval_ns = 10 * TTF_NS_PER_MIN;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_record(&run, 5, &record);
    assert_true(record.images[0].shots[0].lamps[0].measured_permille > 980); /* fully warm */
    ttf_slot_record_free(&record);
    sim_run_finish(&run);
}

static void only_what_is_asked_for_is_kept(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    sim_run_init(&run);
    run.plan.keep = TTF_KEEP_RAW;
    run.plan.count = 2;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_record(&run, 1, &record);
    assert_int_equal(record.images[0].n_files, 1);
    assert_string_equal(record.images[0].files[0].role, "raw");
    ttf_slot_record_free(&record);
    snprintf(run.path, sizeof(run.path), "%s/again", run.folder);
    run.plan.keep = TTF_KEEP_DEVELOPED;
    run.plan.region = (struct ttf_region){4, 6, 20, 10};
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_record(&run, 1, &record);
    assert_int_equal(record.images[0].n_files, 1);
    assert_string_equal(record.images[0].files[0].role, "developed");
    ttf_slot_record_free(&record);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void three_slots_a_second_keep_up(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    run.plan.settle_ns = TTF_NS_PER_MS;
    run.plan.interval_ns = 300 * TTF_NS_PER_MS;
    run.plan.count = 100;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(run.result.captured, 100);
    assert_true(run.result.error_p99_ns < TTF_NS_PER_MS);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(three_shots_a_slot_work),
        cmocka_unit_test(a_shot_that_fails_leaves_the_slot_partial),
        cmocka_unit_test(an_average_with_a_bad_frame_takes_one_more),
        cmocka_unit_test(by_day_the_growth_lamp_burns),
        cmocka_unit_test(a_local_day_begins_by_the_clock_on_the_wall),
        cmocka_unit_test(continuous_lamps_stay_on_between_slots),
        cmocka_unit_test(only_what_is_asked_for_is_kept),
        cmocka_unit_test(three_slots_a_second_keep_up),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
