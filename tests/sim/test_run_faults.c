/* SPDX-License-Identifier: Apache-2.0 */
/* Every fault by name: a whole capture each, and what becomes of it (hal/sim/README.md). */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "sim_run.h"

/* The first opportunity from here on is slot k's first frame, or its first lamp command. */
static int64_t before_slot(int64_t k)
{
    return k * TTF_NS_PER_MIN - 25 * TTF_NS_PER_S;
}

/* Runs the plain plan with one fault that strikes once at slot 2. */
static void one_fault(struct sim_run *run, enum ttf_fault_kind kind, int64_t amount)
{
    sim_run_init(run);
    sim_run_fault(run, kind, before_slot(2))->amount = amount;
    assert_int_equal(sim_run_boot(run), 0);
    assert_true(run->result.sealed);
    assert_int_equal(run->bites, 0);
    sim_run_expect_whole(run, true);
}

/* Slot 2 was taken at the second try, the first having been refused so. */
static void expect_retaken(const struct sim_run *run, const char *refused)
{
    struct ttf_slot_record record;

    sim_run_expect(run, "cccccc");
    sim_run_record(run, 2, &record);
    assert_int_equal(record.images[0].n_shots, 2);
    assert_string_equal(record.images[0].shots[0].refused, refused);
    assert_string_equal(record.images[0].shots[1].refused, "");
    assert_int_equal(record.images[0].n_averaged, 1);
    ttf_slot_record_free(&record);
    sim_run_expect_flag(run, 2, "late");
    assert_int_equal(sim_run_events(run, "retry", refused), 1);
}

static void a_frame_a_little_late_is_waited_for(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    one_fault(&run, TTF_FAULT_FRAME_LATE, 0);
    sim_run_expect(&run, "cccccc");
    sim_run_record(&run, 2, &record);
    assert_int_equal(record.images[0].n_shots, 1);
    assert_string_equal(record.images[0].flags, "");
    ttf_slot_record_free(&record);
    sim_run_finish(&run);
}

static void a_frame_that_is_too_late_is_taken_again(void **state)
{
    struct sim_run run;

    (void)state;
    one_fault(&run, TTF_FAULT_FRAME_LATE, 5000);
    expect_retaken(&run, "missing");
    sim_run_finish(&run);
}

static void a_short_frame_is_taken_again(void **state)
{
    struct sim_run run;

    (void)state;
    one_fault(&run, TTF_FAULT_FRAME_SHORT, 0);
    expect_retaken(&run, "short");
    sim_run_finish(&run);
}

static void a_corrupt_frame_is_taken_again(void **state)
{
    struct sim_run run;

    (void)state;
    one_fault(&run, TTF_FAULT_FRAME_CORRUPT, 0);
    expect_retaken(&run, "corrupt");
    sim_run_finish(&run);
}

static void a_missing_frame_is_taken_again(void **state)
{
    struct sim_run run;

    (void)state;
    one_fault(&run, TTF_FAULT_FRAME_MISSING, 0);
    expect_retaken(&run, "missing");
    sim_run_finish(&run);
}

static void frames_that_stay_corrupt_cost_their_slot_only(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    sim_run_fault(&run, TTF_FAULT_FRAME_CORRUPT, before_slot(2))->duration_ns = TTF_NS_PER_MIN;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccfccc");
    sim_run_expect_reason(&run, 2, "corrupt");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void a_hanging_camera_is_brought_back(void **state)
{
    static const char *const steps[] = {"requeue", "restart", "reopen"};

    (void)state;
    for (int amount = 0; amount < 3; amount++) {
        struct sim_run run;

        one_fault(&run, TTF_FAULT_CAMERA_HANG, amount);
        sim_run_expect(&run, "cccccc");
        sim_run_expect_flag(&run, 2, "late");
        assert_int_equal(sim_run_events(&run, "camera", steps[amount]), 1);
        assert_int_equal(sim_run_events(&run, "camera", "delivers again"), 1);
        sim_run_finish(&run);
    }
}

static void a_camera_that_nothing_helps_costs_slots_until_it_is_back(void **state)
{
    struct sim_run run;
    struct ttf_fault *hang;

    (void)state;
    sim_run_init(&run);
    hang = sim_run_fault(&run, TTF_FAULT_CAMERA_HANG, before_slot(2));
    hang->amount = 3;
    hang->duration_ns = 2 * TTF_NS_PER_MIN;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccffcc");
    sim_run_expect_reason(&run, 2, "camera does not deliver");
    assert_int_equal(sim_run_events(&run, "camera", "given up"), 2);
    assert_int_equal(sim_run_events(&run, "camera", "delivers again"), 1);
    assert_int_equal(run.bites, 0);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* A reopening takes 1.5 s. Tried again between slots although it was brought back, it would never come to a slot's turn. */
static void a_camera_that_takes_longer_than_a_slot_to_come_back_comes_back(void **state)
{
    struct sim_run run;
    struct ttf_fault *hang;
    char results[64];

    (void)state;
    sim_run_init(&run);
    run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    run.plan.settle_ns = TTF_NS_PER_MS;
    run.plan.interval_ns = TTF_NS_PER_S;
    run.plan.count = 30;
    hang = sim_run_fault(&run, TTF_FAULT_CAMERA_HANG, 20 * TTF_NS_PER_S);
    hang->amount = 3;
    hang->duration_ns = 4 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_results(&run, results, sizeof(results));
    assert_string_equal(results, "cccccccccccccccccfmfmmcccccccc");
    assert_int_equal(sim_run_events(&run, "camera", "delivers again"), 1);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void no_camera_at_arming_is_an_error(void **state)
{
    struct sim_run run;
    struct ttf_fault *hang;

    (void)state;
    sim_run_init(&run);
    hang = sim_run_fault(&run, TTF_FAULT_CAMERA_HANG, 0);
    hang->amount = 3;
    hang->duration_ns = TTF_NS_PER_DAY;
    assert_int_equal(sim_run_boot(&run), -ENODEV);
    sim_run_finish(&run);
}

static void wrong_settings_are_taken_again(void **state)
{
    struct sim_run run;

    (void)state;
    one_fault(&run, TTF_FAULT_WRONG_SETTINGS, 0);
    expect_retaken(&run, "wrong settings");
    sim_run_finish(&run);
}

static void settings_that_stay_wrong_are_kept_and_flagged(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    sim_run_init(&run);
    sim_run_fault(&run, TTF_FAULT_WRONG_SETTINGS, before_slot(2))->duration_ns = TTF_NS_PER_MIN;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_flag(&run, 2, "wrong-settings");
    sim_run_record(&run, 2, &record);
    assert_int_equal(record.images[0].shots[1].granted.exposure_ns, 25 * TTF_NS_PER_MS);
    ttf_slot_record_free(&record);
    sim_run_record(&run, 3, &record);
    assert_string_equal(record.images[0].flags, "");
    ttf_slot_record_free(&record);
    sim_run_finish(&run);
}

static void a_dead_lamp_is_flagged_and_told_once(void **state)
{
    struct sim_run run;

    (void)state;
    one_fault(&run, TTF_FAULT_LAMP_DEAD, 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_flag(&run, 2, "lamp-level");
    sim_run_expect_flag(&run, 5, "lamp-level");
    assert_int_equal(sim_run_events(&run, "lamp-level", "left"), 1);
    sim_run_finish(&run);
}

static void a_fading_lamp_is_flagged_when_half_is_gone(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    sim_run_init(&run);
    run.plan.interval_ns = 10 * TTF_NS_PER_MIN;
    sim_run_fault(&run, TTF_FAULT_LAMP_FADING, 0)->amount = 700;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_record(&run, 0, &record);
    assert_string_equal(record.images[0].flags, "");
    ttf_slot_record_free(&record);
    sim_run_expect_flag(&run, 5, "lamp-level");
    sim_run_finish(&run);
}

static void a_lamp_stuck_off_is_flagged(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    sim_run_fault(&run, TTF_FAULT_LAMP_STUCK, before_slot(2))->duration_ns = TTF_NS_PER_MIN;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_flag(&run, 2, "lamp-level");
    assert_int_equal(sim_run_events(&run, "lamp-level", "again"), 1);
    sim_run_finish(&run);
}

static void a_silent_sensor_is_told_when_it_goes_and_comes(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;
    struct ttf_fault *gone;

    (void)state;
    sim_run_init(&run);
    gone = sim_run_fault(&run, TTF_FAULT_SENSOR_GONE, before_slot(2));
    gone->duration_ns = 2 * TTF_NS_PER_MIN;
    strcpy(gone->target, "box-humidity");
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    for (int k = 1; k < 5; k++) {
        sim_run_record(&run, k, &record);
        assert_int_equal(record.sensors[1].ok, k == 1 || k == 4);
        ttf_slot_record_free(&record);
    }
    assert_int_equal(sim_run_events(&run, "sensor", "does not answer"), 1);
    assert_int_equal(sim_run_events(&run, "sensor", "answers again"), 1);
    sim_run_finish(&run);
}

static void a_missing_temperature_turns_lamps_off_not_the_run(void **state)
{
    struct sim_run run;
    struct ttf_fault *gone;

    (void)state;
    sim_run_init(&run);
    gone = sim_run_fault(&run, TTF_FAULT_SENSOR_GONE, before_slot(2));
    gone->duration_ns = TTF_NS_PER_MIN;
    strcpy(gone->target, "box-temp");
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_flag(&run, 2, "lamp-tripped");
    assert_true(sim_run_events(&run, "lamp-trip", NULL) >= 1);
    sim_run_finish(&run);
}

static void a_full_disk_costs_the_slots_it_lasts(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    sim_run_fault(&run, TTF_FAULT_DISK_FULL, before_slot(2))->duration_ns = TTF_NS_PER_MIN;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccfccc");
    sim_run_expect_reason(&run, 2, "disk full");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void a_disk_that_stays_full_ends_the_run_with_all_slots_safe(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.plan.count = 10;
    sim_run_fault(&run, TTF_FAULT_DISK_FULL, before_slot(2))->duration_ns = TTF_NS_PER_DAY;
    assert_int_equal(sim_run_boot(&run), -ENOSPC);
    sim_run_expect(&run, "cc");
    sim_run_expect_whole(&run, false);
    /* Somebody makes room and runs it again. */
    run.config.n_faults = 0;
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_MIN;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccwwwwcccc");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* A light that remembers what it showed, in the box's panel's place. */
static struct {
    struct ttf_panel base; /* first */
    struct ttf_panel *of;
    enum ttf_led shown;
} light;

static int light_led(struct ttf_panel *panel, enum ttf_led led)
{
    (void)panel;
    light.shown = led;
    return 0;
}

static int light_door(struct ttf_panel *panel)
{
    (void)panel;
    return ttf_panel_door(light.of);
}

static int light_poll(struct ttf_panel *panel, struct ttf_panel_event *ret)
{
    (void)panel;
    return ttf_panel_poll(light.of, ret);
}

static const struct ttf_panel_ops LIGHT = {
    .name = "light", .led = light_led, .door = light_door, .poll = light_poll};

static void put_light(struct sim_run *run)
{
    light.base.ops = &LIGHT;
    light.of = run->box->panel;
    run->box->panel = &light.base;
}

static void take_light(struct sim_run *run)
{
    run->box->panel = light.of;
}

static enum ttf_led led_of_slot[6];

/* Less room than the reserve while slots 2 and 3 are committed. */
static void fill_and_empty(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind != TTF_PROGRESS_SLOT)
        return;
    run->free_bytes = progress->index == 1 || progress->index == 2 ? 1 << 20 : 1 << 30;
    led_of_slot[progress->index] = light.shown;
}

static void before_its_reserve_is_touched_capture_stops_and_goes_on_when_there_is_room(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.plan.reserve_bytes = 8 << 20;
    run.free_bytes = 1 << 30;
    run.on_progress = fill_and_empty;
    run.on_box = put_light;
    run.at_end = take_light;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccmmcc");
    /* Whoever is needed is told, until there is room. */
    assert_int_equal(run.alarms, 1);
    assert_non_null(strstr(run.alarm_text, "disk full"));
    assert_int_equal(run.alarms_over, 1);
    assert_int_equal(led_of_slot[3], TTF_LED_STOPPED);
    assert_int_equal(led_of_slot[5], TTF_LED_CAPTURING);
    sim_run_expect_reason(&run, 2, "disk full");
    assert_int_equal(sim_run_events(&run, "disk", "less room"), 1);
    assert_int_equal(sim_run_events(&run, "disk", "room again"), 1);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void one_operation_without_room_is_survived(void **state)
{
    struct sim_run run;

    (void)state;
    one_fault(&run, TTF_FAULT_DISK_FULL, 0);
    sim_run_expect(&run, "cccccc");
    sim_run_finish(&run);
}

static void a_hiccup_of_seconds_does_not_end_a_fast_run(void **state)
{
    struct sim_run run;
    char results[256];

    (void)state;
    sim_run_init(&run);
    run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    run.plan.settle_ns = TTF_NS_PER_MS;
    run.plan.interval_ns = 500 * TTF_NS_PER_MS;
    run.plan.count = 100;
    sim_run_fault(&run, TTF_FAULT_IO_ERROR, 20 * TTF_NS_PER_S)->duration_ns = 8 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_results(&run, results, sizeof(results));
    assert_int_equal(strlen(results), 100);
    assert_in_range(run.result.failed, 12, 20);
    assert_int_equal(run.result.captured + run.result.failed + run.result.missed, 100);
    /* What happened meanwhile was not forgotten. */
    assert_true(sim_run_events(&run, "disk", NULL) > 0);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void one_failed_file_operation_is_survived(void **state)
{
    struct sim_run run;

    (void)state;
    one_fault(&run, TTF_FAULT_IO_ERROR, 0);
    sim_run_expect(&run, "cccccc");
    sim_run_finish(&run);
}

static void files_that_cannot_be_written_cost_their_slot(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    sim_run_fault(&run, TTF_FAULT_IO_ERROR, before_slot(2))->duration_ns = TTF_NS_PER_MIN;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccfccc");
    sim_run_expect_reason(&run, 2, "storage error");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void now_and_then_a_file_operation_fails(void **state)
{
    struct sim_run run;
    char results[128];

    (void)state;
    sim_run_init(&run);
    run.plan.count = 60;
    sim_run_fault(&run, TTF_FAULT_IO_ERROR, 0)->rate_per_million = 10000;
    if (sim_run_boot(&run) == 0) {
        sim_run_results(&run, results, sizeof(results));
        assert_int_equal(strlen(results), 60);
    }
    assert_true(run.code == 0 || run.code == -EIO);
    sim_run_expect_whole(&run, run.result.sealed);
    sim_run_finish(&run);
}

static void a_clock_step_moves_labels_not_slots(void **state)
{
    struct sim_run run;
    struct ttf_slot_record before;
    struct ttf_slot_record after;

    (void)state;
    one_fault(&run, TTF_FAULT_CLOCK_STEP, -7200);
    sim_run_expect(&run, "cccccc");
    assert_int_equal(sim_run_events(&run, "clock-step", "-7200"), 1);
    sim_run_record(&run, 1, &before);
    sim_run_record(&run, 4, &after);
    assert_int_equal(after.due_ns - before.due_ns, 3 * TTF_NS_PER_MIN);
    assert_in_range(after.middle_ns - before.middle_ns, 3 * TTF_NS_PER_MIN - TTF_NS_PER_MS,
                    3 * TTF_NS_PER_MIN + TTF_NS_PER_MS);
    assert_int_equal(before.segment, after.segment);
    ttf_slot_record_free(&before);
    ttf_slot_record_free(&after);
    sim_run_finish(&run);
}

static void an_open_door_flags_and_the_lamp_comes_back(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    sim_run_fault(&run, TTF_FAULT_DOOR_OPEN, before_slot(2))->duration_ns = TTF_NS_PER_MIN;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_flag(&run, 2, "door-open");
    sim_run_expect_flag(&run, 2, "lamp-tripped");
    assert_int_equal(sim_run_events(&run, "door", "opened"), 1);
    assert_int_equal(sim_run_events(&run, "door", "closed"), 1);
    {
        struct ttf_slot_record record;

        sim_run_record(&run, 3, &record);
        assert_string_equal(record.images[0].flags, "");
        assert_true(record.images[0].shots[0].lamps[0].measured_permille > 500);
        ttf_slot_record_free(&record);
    }
    sim_run_finish(&run);
}

static void a_lamp_that_a_door_put_out_between_slots_is_lit_again(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    sim_run_init(&run);
    run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    run.plan.settle_ns = 45 * TTF_NS_PER_S;
    sim_run_fault(&run, TTF_FAULT_DOOR_OPEN, 140 * TTF_NS_PER_S)->duration_ns = 5 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    assert_int_equal(sim_run_events(&run, "lamp-trip", "door"), 1);
    /* Soon enough for slot 2, but it says that the lamp has not settled. */
    sim_run_expect_flag(&run, 2, "lamp-unsettled");
    for (int64_t k = 2; k < 6; k++) {
        sim_run_record(&run, k, &record);
        assert_true(k == 2 || record.images[0].flags[0] == '\0');
        assert_true(record.images[0].shots[0].lamps[0].measured_permille > 800);
        ttf_slot_record_free(&record);
    }
    sim_run_finish(&run);
}

/* Two before it begins, a third while it goes on. */
static void errors_come(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind == TTF_PROGRESS_SLOT && progress->index == 2)
        run->fs_errors = 3;
}

static void errors_that_the_file_system_found_are_told_and_the_run_goes_on(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.fs_errors = 2;
    run.on_progress = errors_come;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(run.result.captured, 6);
    assert_int_equal(run.alarms, 2);
    assert_non_null(strstr(run.alarm_text, "file system has found errors"));
    assert_int_equal(run.alarms_over, 0);
    assert_int_equal(sim_run_events(&run, "storage", "has found errors"), 2);
    assert_int_equal(sim_run_events(&run, "storage", "2 since it was last checked"), 1);
    assert_int_equal(sim_run_events(&run, "storage", "3 since it was last checked"), 1);
    sim_run_finish(&run);
}

static void checked_storage_ends_the_alarm_of_the_run_before(void **state)
{
    struct sim_run run;

    (void)state;
    sim_run_init(&run);
    run.fs_errors = 2;
    run.plan.count = 2;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(run.alarms, 1);
    run.fs_errors = 0;
    snprintf(run.path, sizeof(run.path), "%s/another", run.folder);
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(run.alarms, 1);
    assert_int_equal(run.alarms_over, 1);
    assert_int_equal(sim_run_events(&run, "storage", NULL), 0);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_a_little_late_is_waited_for),
        cmocka_unit_test(a_frame_that_is_too_late_is_taken_again),
        cmocka_unit_test(a_short_frame_is_taken_again),
        cmocka_unit_test(a_corrupt_frame_is_taken_again),
        cmocka_unit_test(a_missing_frame_is_taken_again),
        cmocka_unit_test(frames_that_stay_corrupt_cost_their_slot_only),
        cmocka_unit_test(a_hanging_camera_is_brought_back),
        cmocka_unit_test(a_camera_that_nothing_helps_costs_slots_until_it_is_back),
        cmocka_unit_test(a_camera_that_takes_longer_than_a_slot_to_come_back_comes_back),
        cmocka_unit_test(no_camera_at_arming_is_an_error),
        cmocka_unit_test(wrong_settings_are_taken_again),
        cmocka_unit_test(settings_that_stay_wrong_are_kept_and_flagged),
        cmocka_unit_test(a_dead_lamp_is_flagged_and_told_once),
        cmocka_unit_test(a_fading_lamp_is_flagged_when_half_is_gone),
        cmocka_unit_test(a_lamp_stuck_off_is_flagged),
        cmocka_unit_test(a_silent_sensor_is_told_when_it_goes_and_comes),
        cmocka_unit_test(a_missing_temperature_turns_lamps_off_not_the_run),
        cmocka_unit_test(a_full_disk_costs_the_slots_it_lasts),
        cmocka_unit_test(a_disk_that_stays_full_ends_the_run_with_all_slots_safe),
        cmocka_unit_test(
            before_its_reserve_is_touched_capture_stops_and_goes_on_when_there_is_room),
        cmocka_unit_test(one_operation_without_room_is_survived),
        cmocka_unit_test(a_hiccup_of_seconds_does_not_end_a_fast_run),
        cmocka_unit_test(one_failed_file_operation_is_survived),
        cmocka_unit_test(files_that_cannot_be_written_cost_their_slot),
        cmocka_unit_test(now_and_then_a_file_operation_fails),
        cmocka_unit_test(a_clock_step_moves_labels_not_slots),
        cmocka_unit_test(an_open_door_flags_and_the_lamp_comes_back),
        cmocka_unit_test(a_lamp_that_a_door_put_out_between_slots_is_lit_again),
        cmocka_unit_test(errors_that_the_file_system_found_are_told_and_the_run_goes_on),
        cmocka_unit_test(checked_storage_ends_the_alarm_of_the_run_before),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
