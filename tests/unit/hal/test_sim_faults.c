/* SPDX-License-Identifier: Apache-2.0 */
/* What each fault does at the devices. The first boot: elapsed time is the boot clock. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim_fixture.h"

static struct ttf_box with(enum ttf_fault_kind kind, int64_t at_ns, int64_t duration_ns,
                           int64_t amount, const char *target)
{
    struct ttf_sim_config c = sim_small();

    sim_add_fault(&c, kind, at_ns, duration_ns, amount, target);
    return sim_box(&c);
}

static void names_and_kinds_go_together(void **state)
{
    (void)state;
    for (int i = 0; i < TTF_FAULT_KIND_COUNT; i++)
        assert_int_equal(ttf_fault_find(ttf_fault_name((enum ttf_fault_kind)i)), i);
    assert_int_equal(ttf_fault_find("frame-lost"), -ENOENT);
    assert_null(ttf_fault_name(TTF_FAULT_KIND_COUNT));
}

static void a_late_frame_comes_late_once_and_is_whole(void **state)
{
    struct ttf_box box = with(TTF_FAULT_FRAME_LATE, 20 * S, 0, 700, NULL);
    struct ttf_frame *frame;

    (void)state;
    assert_int_equal(sim_shoot(&box, 20 * MS, 30 * S, &frame), 0);
    assert_true(ttf_clock_now_ns(box.clock) >= frame->end_ns + 700 * MS);
    assert_true(llabs((frame->start_ns + frame->end_ns) / 2 - 30 * S) < MS);
    ttf_camera_release(box.cameras[0].camera, frame);
    assert_int_equal(sim_shoot(&box, 20 * MS, 40 * S, &frame), 0);
    assert_true(ttf_clock_now_ns(box.clock) < frame->end_ns + 10 * MS);
    ttf_camera_release(box.cameras[0].camera, frame);
    ttf_box_destroy(&box);
}

static void a_short_frame_says_so_and_has_fewer_bytes(void **state)
{
    struct ttf_box box = with(TTF_FAULT_FRAME_SHORT, 20 * S, 0, 250, NULL);
    struct ttf_frame *frame;

    (void)state;
    assert_int_equal(sim_shoot(&box, 20 * MS, 30 * S, &frame), 0);
    assert_true(frame->flags & TTF_FRAME_SHORT);
    assert_int_equal(frame->bytes, 64 * 48 * 2 / 4);
    ttf_camera_release(box.cameras[0].camera, frame);
    assert_int_equal(sim_shoot(&box, 20 * MS, 40 * S, &frame), 0);
    assert_int_equal(frame->flags, TTF_FRAME_SIMULATED);
    assert_int_equal(frame->bytes, 64 * 48 * 2);
    ttf_camera_release(box.cameras[0].camera, frame);
    ttf_box_destroy(&box);
}

static void a_corrupt_frame_is_marked_and_is_noise(void **state)
{
    struct ttf_box box = with(TTF_FAULT_FRAME_CORRUPT, 20 * S, 0, 0, NULL);
    struct ttf_frame *frame;

    (void)state;
    assert_int_equal(sim_shoot(&box, 20 * MS, 30 * S, &frame), 0);
    assert_true(frame->flags & TTF_FRAME_ERROR);
    assert_true(sim_mean(&box, frame) > 1000); /* the lamps are off */
    ttf_box_destroy(&box);
}

static void a_missing_frame_is_skipped_and_the_next_says_that_there_was_a_gap(void **state)
{
    struct ttf_box box = with(TTF_FAULT_FRAME_MISSING, 20 * S, 0, 0, NULL);
    struct ttf_exposure e[3] = {
        {20 * MS, 1000, 0, 0, 0}, {20 * MS, 1000, 0, 0, 0}, {20 * MS, 1000, 0, 0, 0}};
    struct ttf_camera_set set = {.settings = e, .n = 3, .middle_ns = 30 * S};
    struct ttf_camera *camera = box.cameras[0].camera;
    struct ttf_frame *frame;

    (void)state;
    assert_int_equal(ttf_camera_submit(camera, &set, NULL), 0);
    assert_int_equal(ttf_camera_next(camera, 40 * S, &frame, NULL), 0);
    assert_int_equal(frame->set_index, 1);
    assert_true(frame->flags & TTF_FRAME_SEQUENCE_GAP);
    ttf_camera_release(camera, frame);
    assert_int_equal(ttf_camera_next(camera, 40 * S, &frame, NULL), 0);
    assert_int_equal(frame->set_index, 2);
    assert_false(frame->flags & TTF_FRAME_SEQUENCE_GAP);
    ttf_camera_release(camera, frame);
    assert_int_equal(ttf_camera_submit(camera, &set, NULL), 0); /* the set is over */
    ttf_box_destroy(&box);
}

static void a_set_whose_rest_is_missing_is_over_soon(void **state)
{
    struct ttf_box box = with(TTF_FAULT_FRAME_MISSING, 20 * S, 0, 0, NULL);
    struct ttf_frame *frame;

    (void)state;
    assert_int_equal(sim_shoot(&box, 20 * MS, 30 * S, &frame), -ENODATA);
    assert_true(ttf_clock_now_ns(box.clock) < 30 * S + 200 * MS);
    assert_int_equal(sim_shoot(&box, 20 * MS, 31 * S, &frame), 0);
    ttf_camera_release(box.cameras[0].camera, frame);
    ttf_box_destroy(&box);
}

/* Tries the ladder from its mildest step; returns the step that helped. */
static int climb(struct ttf_box *box)
{
    int step = 0;

    while (step < TTF_CAMERA_RECOVERY_COUNT &&
           ttf_camera_recover(box->cameras[0].camera, (enum ttf_camera_recovery)step, NULL) < 0)
        step++;
    return step;
}

static void a_hang_delivers_nothing_until_the_step_that_cures_it(void **state)
{
    (void)state;
    for (int cure = 0; cure < 3; cure++) {
        struct ttf_box box = with(TTF_FAULT_CAMERA_HANG, 20 * S, 0, cure, NULL);
        struct ttf_frame *frame;

        assert_int_equal(sim_shoot(&box, 20 * MS, 10 * S, &frame), 0);
        ttf_camera_release(box.cameras[0].camera, frame);
        assert_int_equal(sim_shoot(&box, 20 * MS, 30 * S, &frame), -ETIMEDOUT);
        ttf_camera_cancel(box.cameras[0].camera);
        assert_int_equal(sim_shoot(&box, 20 * MS, 40 * S, &frame), -ETIMEDOUT);
        assert_int_equal(climb(&box), cure);
        assert_int_equal(sim_shoot(&box, 20 * MS, 60 * S, &frame), 0);
        ttf_camera_release(box.cameras[0].camera, frame);
        assert_int_equal(sim_shoot(&box, 20 * MS, 70 * S, &frame), 0);
        ttf_camera_release(box.cameras[0].camera, frame);
        ttf_box_destroy(&box);
    }
}

static void a_stubborn_hang_ends_only_with_its_time(void **state)
{
    struct ttf_box box = with(TTF_FAULT_CAMERA_HANG, 20 * S, 100 * S, 3, NULL);
    struct ttf_frame *frame;

    (void)state;
    assert_int_equal(sim_shoot(&box, 20 * MS, 30 * S, &frame), -ETIMEDOUT);
    assert_int_equal(climb(&box), TTF_CAMERA_RECOVERY_COUNT);
    assert_int_equal(sim_shoot(&box, 20 * MS, 130 * S, &frame), 0);
    ttf_camera_release(box.cameras[0].camera, frame);
    ttf_box_destroy(&box);
}

static void wrong_settings_are_in_effect_and_read_back(void **state)
{
    struct ttf_box box = with(TTF_FAULT_WRONG_SETTINGS, 20 * S, 0, 500, NULL);
    struct ttf_frame *frame;
    double right, wrong;

    (void)state;
    sim_light_up(&box, 1000 * S);
    right = sim_brightness(&box, 10 * S);
    assert_int_equal(sim_shoot(&box, 20 * MS, 30 * S, &frame), 0);
    assert_true(frame->settings.exposure_ns == 30 * MS);
    wrong = sim_mean(&box, frame);
    assert_true(fabs(wrong / right - 1.5) < 0.01);
    assert_int_equal(sim_shoot(&box, 20 * MS, 40 * S, &frame), 0);
    assert_true(frame->settings.exposure_ns == 20 * MS);
    ttf_camera_release(box.cameras[0].camera, frame);
    ttf_box_destroy(&box);
}

static void a_dead_lamp_gives_no_light_though_it_is_driven(void **state)
{
    struct ttf_box box = with(TTF_FAULT_LAMP_DEAD, 20 * S, 100 * S, 0, "right");
    double before, dead;

    (void)state;
    sim_light_up(&box, 1000 * S);
    before = sim_brightness(&box, 10 * S);
    dead = sim_brightness(&box, 60 * S);
    assert_true(fabs(dead / before - 0.5) < 0.02);
    assert_int_equal(sim_lamp(&box, 1).actual_permille, 1000);
    assert_int_equal(sim_lamp(&box, 1).measured_permille, 0);
    assert_int_equal(sim_lamp(&box, 0).measured_permille, 1000);
    assert_true(fabs(sim_brightness(&box, 200 * S) / before - 1) < 0.01);
    ttf_box_destroy(&box);
}

static void a_fading_lamp_loses_its_light_by_the_hour(void **state)
{
    struct ttf_box box = with(TTF_FAULT_LAMP_FADING, 100 * S, 0, 200, "left");

    (void)state;
    sim_light_up(&box, 10 * TTF_NS_PER_H);
    sim_wait(&box, 90 * S);
    assert_int_equal(sim_lamp(&box, 0).measured_permille, 1000);
    sim_wait(&box, 100 * S + TTF_NS_PER_H);
    assert_int_equal(sim_lamp(&box, 0).measured_permille, 800);
    assert_int_equal(sim_lamp(&box, 1).measured_permille, 1000);
    sim_wait(&box, 100 * S + 6 * TTF_NS_PER_H);
    assert_int_equal(sim_lamp(&box, 0).measured_permille, 0);
    ttf_box_destroy(&box);
}

static void a_stuck_lamp_stays_as_it_is_even_for_the_guardian(void **state)
{
    struct ttf_box box = with(TTF_FAULT_LAMP_STUCK, 20 * S, 100 * S, 0, "left");
    double lit;

    (void)state;
    sim_light_up(&box, 1000 * S);
    lit = sim_brightness(&box, 10 * S);
    sim_wait(&box, 30 * S);
    ttf_lamps_release(box.lamps);
    assert_int_equal(sim_lamp(&box, 0).actual_permille, 0);
    assert_int_equal(sim_lamp(&box, 0).measured_permille, 1000);
    assert_true(fabs(sim_brightness(&box, 40 * S) / lit - 0.5) < 0.02);
    assert_true(sim_brightness(&box, 140 * S) < 0.01 * lit);
    ttf_box_destroy(&box);
}

static bool answers(struct ttf_box *box, int i)
{
    struct ttf_reading r[TTF_SENSORS_MAX];

    assert_true(ttf_sensors_read(box->sensors, r, NULL) > i);
    return r[i].ok;
}

static void a_sensor_that_is_gone_does_not_answer_and_its_lamps_trip(void **state)
{
    struct ttf_box box = with(TTF_FAULT_SENSOR_GONE, 20 * S, 100 * S, 0, "box-temp");

    (void)state;
    sim_light_up(&box, 1000 * S);
    sim_wait(&box, 29 * S);
    assert_false(answers(&box, 0));
    assert_true(answers(&box, 1));
    assert_int_equal(sim_lamp(&box, 0).trip, TTF_TRIP_NONE);
    sim_wait(&box, 31 * S);
    assert_int_equal(sim_lamp(&box, 0).trip, TTF_TRIP_TEMP_MISSING);
    assert_int_equal(sim_lamp(&box, 0).measured_permille, 0);
    assert_int_equal(ttf_lamps_set(box.lamps, 0, 1000, NULL), -EPERM);
    sim_wait(&box, 122 * S);
    assert_true(answers(&box, 0));
    assert_int_equal(ttf_lamps_set(box.lamps, 0, 1000, NULL), 0);
    ttf_box_destroy(&box);
}

static void a_sensor_that_is_gone_for_an_instant_misses_one_reading(void **state)
{
    struct ttf_box box = with(TTF_FAULT_SENSOR_GONE, 20 * S, 0, 0, "box-humidity");

    (void)state;
    assert_true(answers(&box, 1));
    sim_wait(&box, 25 * S);
    assert_false(answers(&box, 1));
    assert_true(answers(&box, 1));
    ttf_box_destroy(&box);
}

static void storage_fails_in_its_time_or_once(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_box box;

    (void)state;
    sim_add_fault(&c, TTF_FAULT_DISK_FULL, 20 * S, 10 * S, 0, NULL);
    sim_add_fault(&c, TTF_FAULT_IO_ERROR, 50 * S, 0, 0, NULL);
    box = sim_box(&c);
    sim_wait(&box, 19 * S);
    assert_false(ttf_sim_storage_fault(&box, TTF_FAULT_DISK_FULL));
    sim_wait(&box, 20 * S);
    assert_true(ttf_sim_storage_fault(&box, TTF_FAULT_DISK_FULL));
    assert_true(ttf_sim_storage_fault(&box, TTF_FAULT_DISK_FULL));
    assert_false(ttf_sim_storage_fault(&box, TTF_FAULT_IO_ERROR));
    sim_wait(&box, 30 * S);
    assert_false(ttf_sim_storage_fault(&box, TTF_FAULT_DISK_FULL));
    sim_wait(&box, 60 * S);
    assert_true(ttf_sim_storage_fault(&box, TTF_FAULT_IO_ERROR));
    assert_false(ttf_sim_storage_fault(&box, TTF_FAULT_IO_ERROR));
    ttf_box_destroy(&box);
}

static void a_clock_step_moves_utc_and_not_the_boot_clock(void **state)
{
    struct ttf_box box = with(TTF_FAULT_CLOCK_STEP, 20 * S, 0, -120, NULL);
    struct ttf_utc a, b;

    (void)state;
    sim_wait(&box, 19 * S);
    ttf_clock_utc(box.clock, &a);
    sim_wait(&box, 21 * S);
    ttf_clock_utc(box.clock, &b);
    assert_true(b.boot_ns - a.boot_ns == 2 * S);
    assert_true(b.utc_ns - a.utc_ns == -118 * S);
    assert_int_equal(a.steps, 0);
    assert_int_equal(b.steps, 1);
    ttf_box_destroy(&box);
}

static void the_door_opens_lets_light_in_and_darkens_the_lamps(void **state)
{
    struct ttf_box box = with(TTF_FAULT_DOOR_OPEN, 20 * S, 15 * S, 0, NULL);
    struct ttf_panel_event event;
    double dark;

    (void)state;
    dark = sim_brightness(&box, 10 * S);
    sim_light_up(&box, 1000 * S);
    assert_int_equal(ttf_panel_door(box.panel), 0);
    assert_true(sim_brightness(&box, 30 * S) > dark + 50);
    assert_int_equal(ttf_panel_door(box.panel), 1);
    assert_int_equal(sim_lamp(&box, 0).trip, TTF_TRIP_DOOR);
    assert_int_equal(ttf_panel_poll(box.panel, &event), 1);
    assert_int_equal(event.kind, TTF_PANEL_DOOR_OPENED);
    assert_true(event.at_ns == 20 * S);
    assert_int_equal(ttf_panel_poll(box.panel, &event), 0);
    sim_wait(&box, 50 * S);
    assert_int_equal(ttf_panel_poll(box.panel, &event), 1);
    assert_int_equal(event.kind, TTF_PANEL_DOOR_CLOSED);
    assert_true(event.at_ns == 35 * S);
    assert_int_equal(ttf_lamps_set(box.lamps, 0, 1000, NULL), 0);
    ttf_box_destroy(&box);
}

static void faults_at_random_strike_about_as_often_as_said_and_the_same_each_time(void **state)
{
    struct ttf_sim_config c = sim_small();
    unsigned missing[2] = {0}, first[2] = {0};

    (void)state;
    c.n_faults = 1;
    c.faults[0] = (struct ttf_fault){.kind = TTF_FAULT_FRAME_MISSING, .rate_per_million = 100000};
    for (int run = 0; run < 2; run++) {
        struct ttf_box box = sim_box(&c);

        for (unsigned k = 1; k <= 1000; k++) {
            struct ttf_frame *frame;
            int r = sim_shoot(&box, 5 * MS, (int64_t)k * 10 * S, &frame);

            if (r == -ENODATA && missing[run]++ == 0)
                first[run] = k;
            if (r == 0)
                ttf_camera_release(box.cameras[0].camera, frame);
        }
        ttf_box_destroy(&box);
    }
    assert_in_range(missing[0], 70, 130);
    assert_int_equal(missing[0], missing[1]);
    assert_int_equal(first[0], first[1]);
}

static void the_largest_amounts_do_not_run_over(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_frame *frame;
    struct ttf_utc utc;
    struct ttf_box box;

    (void)state;
    c.start_utc_ns = INT64_C(4000000000) * S;
    for (int i = 0; i < 30; i++)
        sim_add_fault(&c, TTF_FAULT_CLOCK_STEP, S, 0, INT64_C(4000000000), NULL);
    sim_add_fault(&c, TTF_FAULT_WRONG_SETTINGS, S, TTF_NS_PER_DAY, 1000000, NULL);
    sim_add_fault(&c, TTF_FAULT_POWER_CUT, 36500 * TTF_NS_PER_DAY, 0, INT64_C(4000000000), NULL);
    box = sim_box(&c);
    ttf_clock_utc(box.clock, &utc);
    assert_true(utc.utc_ns > c.start_utc_ns);
    assert_int_equal(sim_shoot(&box, 10 * S, 20 * S, &frame), 0);
    assert_true(frame->settings.exposure_ns == 10 * S); /* the camera's longest */
    ttf_camera_release(box.cameras[0].camera, frame);
    assert_int_equal(sim_shoot(&box, INT64_MAX, TTF_NS_NEVER, &frame), -EINVAL);
    assert_int_equal(sim_shoot(&box, INT64_MAX, TTF_NS_UNKNOWN, &frame), -ETIMEDOUT);
    ttf_box_destroy(&box);
}

static void a_fault_about_something_that_is_not_there_is_refused(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_err err = {0};

    (void)state;
    sim_add_fault(&c, TTF_FAULT_LAMP_DEAD, 0, 0, 0, "top");
    assert_int_equal(ttf_sim_config_check(&c, &err), -EINVAL);
    assert_string_equal(err.where, "faults[0].target");
    assert_non_null(strstr(err.what, "lamp-dead"));
}

static void a_storage_has_faults_of_its_own(void **state)
{
    struct ttf_box box = with(TTF_FAULT_READ_ONLY, 0, 0, 0, "first");
    int64_t free_bytes;
    bool read_only;

    (void)state;
    assert_true(ttf_sim_storage_fault(&box, TTF_FAULT_READ_ONLY));
    assert_true(ttf_sim_storage_fault_at(&box, TTF_FAULT_READ_ONLY, 0));
    assert_false(ttf_sim_storage_fault_at(&box, TTF_FAULT_READ_ONLY, 1));
    ttf_sim_storage_state(&box, 0, &free_bytes, &read_only);
    assert_true(read_only && free_bytes == TTF_NS_UNKNOWN);
    ttf_sim_storage_state(&box, 1, &free_bytes, &read_only);
    assert_false(read_only);
    ttf_box_destroy(&box);
}

static void a_disk_that_fills_up_says_so_before_anything_fails(void **state)
{
    struct ttf_box box = with(TTF_FAULT_DISK_FULL, 0, TTF_NS_PER_H, 100, NULL);
    int64_t free_bytes;
    bool read_only;

    (void)state;
    ttf_sim_storage_state(&box, 0, &free_bytes, &read_only);
    assert_true(free_bytes == INT64_C(100) << 20 && !read_only);
    assert_false(ttf_sim_storage_fault(&box, TTF_FAULT_DISK_FULL));
    ttf_box_destroy(&box);
    box = with(TTF_FAULT_DISK_FULL, 0, TTF_NS_PER_H, 0, NULL);
    ttf_sim_storage_state(&box, 1, &free_bytes, &read_only);
    assert_true(free_bytes == 0);
    assert_true(ttf_sim_storage_fault_at(&box, TTF_FAULT_DISK_FULL, 1));
    ttf_box_destroy(&box);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_and_kinds_go_together),
        cmocka_unit_test(a_late_frame_comes_late_once_and_is_whole),
        cmocka_unit_test(a_short_frame_says_so_and_has_fewer_bytes),
        cmocka_unit_test(a_corrupt_frame_is_marked_and_is_noise),
        cmocka_unit_test(a_missing_frame_is_skipped_and_the_next_says_that_there_was_a_gap),
        cmocka_unit_test(a_set_whose_rest_is_missing_is_over_soon),
        cmocka_unit_test(a_hang_delivers_nothing_until_the_step_that_cures_it),
        cmocka_unit_test(a_stubborn_hang_ends_only_with_its_time),
        cmocka_unit_test(wrong_settings_are_in_effect_and_read_back),
        cmocka_unit_test(a_dead_lamp_gives_no_light_though_it_is_driven),
        cmocka_unit_test(a_fading_lamp_loses_its_light_by_the_hour),
        cmocka_unit_test(a_stuck_lamp_stays_as_it_is_even_for_the_guardian),
        cmocka_unit_test(a_sensor_that_is_gone_does_not_answer_and_its_lamps_trip),
        cmocka_unit_test(a_sensor_that_is_gone_for_an_instant_misses_one_reading),
        cmocka_unit_test(storage_fails_in_its_time_or_once),
        cmocka_unit_test(a_clock_step_moves_utc_and_not_the_boot_clock),
        cmocka_unit_test(the_door_opens_lets_light_in_and_darkens_the_lamps),
        cmocka_unit_test(faults_at_random_strike_about_as_often_as_said_and_the_same_each_time),
        cmocka_unit_test(the_largest_amounts_do_not_run_over),
        cmocka_unit_test(a_storage_has_faults_of_its_own),
        cmocka_unit_test(a_disk_that_fills_up_says_so_before_anything_fails),
        cmocka_unit_test(a_fault_about_something_that_is_not_there_is_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
