/* SPDX-License-Identifier: Apache-2.0 */
/* Which frames a camera behind libcamera hands out, with which settings and when; what goes wrong meanwhile. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>

#include "libcamera_fixture.h"

static int64_t now(const struct rig *rig)
{
    return ttf_clock_now_ns(rig->clock);
}

static int64_t middle_of(const struct ttf_frame *frame)
{
    return (frame->start_ns + frame->end_ns) / 2;
}

/* ---- settings ---- */

static void what_was_read_back_is_granted_again_to_the_last_digit(void **state)
{
    struct ttf_exposure asked = of_us(12346, 1391), granted;
    struct rig *rig = *state;

    rig_start(rig);
    granted = rig_shoot(rig, &asked, 0).settings;
    assert_int_not_equal(granted.exposure_ns, asked.exposure_ns); /* cut down to lines */
    for (int i = 0; i < 5; i++) {
        struct ttf_frame again = rig_shoot(rig, &granted, 0);

        assert_memory_equal(&again.settings, &granted, sizeof(granted));
    }
}

/* A box that starts again knows the settings its dataset is locked to, and not what was asked for them. */
static void settings_of_an_earlier_run_are_granted_again(void **state)
{
    struct ttf_exposure asked = of_us(12346, 1391), granted;
    struct ttf_frame again;
    struct rig *rig = *state;

    rig_start(rig);
    granted = rig_shoot(rig, &asked, 0).settings;
    ttf_camera_destroy(rig->camera);
    rig->camera = NULL;
    rig_start(rig);
    again = rig_shoot(rig, &granted, 0);
    assert_memory_equal(&again.settings, &granted, sizeof(granted));
}

static void frames_under_way_with_the_settings_of_before_are_passed_over(void **state)
{
    struct ttf_exposure dark = of_us(3000, 1000), bright = of_us(15000, 1000);
    struct rig *rig = *state;

    for (unsigned delay = 0; delay <= 4; delay++) {
        rig->fake.delay = delay;
        rig_start(rig);
        for (int i = 0; i < 4; i++) {
            struct ttf_frame frame = rig_shoot(rig, i % 2 ? &bright : &dark, 0);
            int64_t wanted = i % 2 ? 15 * MS : 3 * MS;

            assert_true(llabs(frame.settings.exposure_ns - wanted) < 20000);
        }
        ttf_camera_destroy(rig->camera);
        rig->camera = NULL;
    }
}

static void a_bracket_has_each_of_its_settings(void **state)
{
    struct ttf_exposure bracket[3] = {of_us(3000, 1000), of_us(9000, 1000), of_us(27000, 1000)};
    struct rig *rig = *state;

    rig_start(rig);
    assert_int_equal(rig_submit(rig, bracket, 3, 0), 0);
    for (unsigned i = 0; i < 3; i++) {
        struct ttf_frame *frame = NULL;

        assert_int_equal(rig_next(rig, &frame), 0);
        if (!frame)
            abort();
        assert_int_equal(frame->set_index, i);
        assert_true(llabs(frame->settings.exposure_ns - bracket[i].exposure_ns) < 20000);
        ttf_camera_release(rig->camera, frame);
    }
}

static void an_exposure_that_is_clamped_without_a_word_is_told_as_it_was(void **state)
{
    struct ttf_exposure asked = of_us(90000, 1000);
    struct ttf_frame frame;
    struct rig *rig = *state;

    rig->fake.longest_exposure_ns = 50 * MS;
    rig_start(rig);
    frame = rig_shoot(rig, &asked, 0);
    assert_true(llabs(frame.settings.exposure_ns - 50 * MS) < 20000);
    asked = frame.settings;
    frame = rig_shoot(rig, &asked, 0);
    assert_memory_equal(&frame.settings, &asked, sizeof(asked));
}

static void a_request_whose_settings_were_lost_costs_no_more_than_its_frame(void **state)
{
    struct ttf_exposure asked = of_us(3000, 1000);
    struct rig *rig = *state;

    rig_start(rig);
    (void)rig_shoot(rig, &asked, 0);
    rig->fake.forgets = 0x5;
    rig->fake.fate_request = rig->fake.requests;
    asked = of_us(15000, 1000);
    assert_true(llabs(rig_shoot(rig, &asked, 0).settings.exposure_ns - 15 * MS) < 20000);
}

static void settings_that_begin_to_wander_end_the_set_in_words(void **state)
{
    struct ttf_exposure asked = of_us(5000, 1000), other = of_us(6000, 1000);
    struct ttf_frame *frame = NULL;
    struct rig *rig = *state;
    int r = 0;

    rig_start(rig);
    (void)rig_shoot(rig, &asked, 0);
    rig->fake.automatic = true;
    assert_int_equal(rig_submit(rig, &other, 1, 0), 0);
    r = rig_next(rig, &frame);
    assert_int_equal(r, -EIO);
    assert_says(rig, "do not come to rest");
}

static void a_frame_whose_settings_changed_by_themselves_says_so(void **state)
{
    struct ttf_exposure asked = of_us(5000, 1000);
    struct ttf_frame frame;
    struct rig *rig = *state;

    rig_start(rig);
    asked = rig_shoot(rig, &asked, 0).settings;
    rig->fake.longest_exposure_ns = 2 * MS;
    frame = rig_shoot(rig, &asked, 0);
    assert_true(frame.settings.exposure_ns < 3 * MS);
}

/* ---- time ---- */

static void middles_fall_where_they_were_asked_to(void **state)
{
    struct ttf_exposure asked = of_us(8000, 1000);
    struct rig *rig = *state;
    int64_t worst = 0;

    for (unsigned delay = 0; delay <= 3; delay++) {
        const struct ttf_camera_caps *caps;

        rig->fake.delay = delay;
        rig_start(rig);
        caps = ttf_camera_caps(rig->camera);
        asked = rig_shoot(rig, &asked, 0).settings;
        for (int i = 0; i < 20; i++) {
            int64_t middle = now(rig) + caps->lead_ns + i * 1237 * TTF_NS_PER_US;
            struct ttf_frame frame = rig_shoot(rig, &asked, middle);
            int64_t off = llabs(middle_of(&frame) - middle);

            worst = off > worst ? off : worst;
            assert_true(off <= caps->timing_bound_ns);
            ttf_clock_wait_until(rig->clock, now(rig) + (i % 3) * 700 * MS);
        }
        ttf_camera_destroy(rig->camera);
        rig->camera = NULL;
    }
    print_message("steered: %lld us off at most\n", (long long)(worst / 1000));
}

static void a_long_exposure_is_placed_too(void **state)
{
    struct ttf_exposure asked = of_us(180000, 1000);
    const struct ttf_camera_caps *caps;
    struct ttf_frame frame;
    struct rig *rig = *state;
    int64_t middle;

    rig_start(rig);
    caps = ttf_camera_caps(rig->camera);
    asked = rig_shoot(rig, &asked, 0).settings;
    middle = now(rig) + caps->lead_ns +
             (asked.exposure_ns - caps->frame_period_ns) * caps->long_frames + 77 * MS;
    frame = rig_shoot(rig, &asked, middle);
    assert_true(llabs(middle_of(&frame) - middle) <= caps->timing_bound_ns);
}

static void a_lost_frame_on_the_way_does_not_lead_steering_astray(void **state)
{
    struct ttf_exposure asked = of_us(8000, 1000);
    const struct ttf_camera_caps *caps;
    struct rig *rig = *state;

    rig_start(rig);
    caps = ttf_camera_caps(rig->camera);
    asked = rig_shoot(rig, &asked, 0).settings;
    rig->fake.fate_from = fake_libcamera_next(&rig->fake);
    rig->fake.dropped = 0x12;
    for (int i = 0; i < 3; i++) {
        int64_t middle = now(rig) + caps->lead_ns + 13 * MS;
        struct ttf_frame frame = rig_shoot(rig, &asked, middle);

        assert_true(llabs(middle_of(&frame) - middle) <= caps->timing_bound_ns);
    }
}

static void a_drivers_own_stamp_is_brought_to_the_boot_clock(void **state)
{
    struct ttf_exposure asked = of_us(8000, 1000);
    struct ttf_frame frame;
    struct rig *rig = *state;
    int64_t before;

    rig->fake.stamp_monotonic = true;
    rig->fake.monotonic_lag_ns = 5 * TTF_NS_PER_H;
    rig_start(rig);
    before = now(rig);
    frame = rig_shoot(rig, &asked, 0);
    assert_true(frame.start_ns >= before && frame.end_ns <= now(rig));
    assert_int_equal(frame.flags, 0);
}

static void without_any_stamp_the_arrival_counts_and_is_said(void **state)
{
    struct ttf_exposure asked = of_us(8000, 1000);
    struct rig *rig = *state;

    rig->fake.stamp_none = true;
    rig_start(rig);
    assert_int_equal(rig_shoot(rig, &asked, 0).flags, TTF_FRAME_NO_SENSOR_TIME);
}

/* Taken long after it came, so that its arrival hides nothing. */
static void assert_dated_as_it_was(struct rig *rig)
{
    struct ttf_exposure asked = of_us(15000, 1000);
    struct ttf_frame *frame = NULL;

    rig_start(rig);
    asked = rig_shoot(rig, &asked, 0).settings;
    assert_int_equal(rig_submit(rig, &asked, 1, 0), 0);
    ttf_clock_wait_until(rig->clock, now(rig) + 500 * MS);
    assert_int_equal(rig_next(rig, &frame), 0);
    if (!frame)
        abort();
    /* Exposures are told in whole microseconds. */
    assert_true(llabs(frame->start_ns - rig->fake.began_ns[frame->sequence % 64]) < TTF_NS_PER_US);
    assert_int_equal(frame->end_ns - frame->start_ns, frame->settings.exposure_ns + 20 * MS);
    ttf_camera_release(rig->camera, frame);
}

static void a_stamp_of_the_readout_is_dated_back_by_the_exposure(void **state)
{
    struct rig *rig = *state;

    rig->fake.stamp_readout = true;
    rig->config.stamp = TTF_LIBCAMERA_STAMP_READOUT;
    assert_dated_as_it_was(rig);
}

static void a_stamp_of_the_exposure_is_its_beginning(void **state)
{
    assert_dated_as_it_was(*state);
}

/* ---- what goes wrong ---- */

static void frames_in_error_short_or_mute_are_handed_out_with_their_marks(void **state)
{
    struct ttf_exposure asked[3] = {of_us(8000, 1000), of_us(8000, 1000), of_us(8000, 1000)};
    static const uint32_t marks[3] = {TTF_FRAME_ERROR, TTF_FRAME_SHORT, TTF_FRAME_ERROR};
    struct rig *rig = *state;

    rig_start(rig);
    asked[0] = asked[1] = asked[2] = rig_shoot(rig, &asked[0], 0).settings;
    assert_int_equal(rig_submit(rig, asked, 3, 0), 0);
    /* The one under way began before the set. */
    rig->fake.fate_from = fake_libcamera_next(&rig->fake);
    rig->fake.in_error = 1;
    rig->fake.cut = 2;
    rig->fake.mute = 4;
    for (unsigned i = 0; i < 3; i++) {
        struct ttf_frame *frame = NULL;

        assert_int_equal(rig_next(rig, &frame), 0);
        if (!frame)
            abort();
        assert_int_equal(frame->flags, marks[i]);
        ttf_camera_release(rig->camera, frame);
    }
}

static void a_digital_gain_that_comes_later_marks_the_frame_bad(void **state)
{
    struct ttf_exposure asked = of_us(8000, 1000);
    struct rig *rig = *state;

    rig->config.stream = TTF_LIBCAMERA_PROCESSED;
    rig_start(rig);
    asked.wb_r_milli = asked.wb_b_milli = 1500;
    asked = rig_shoot(rig, &asked, 0).settings;
    assert_int_equal(asked.wb_r_milli, 1500);
    rig->fake.digital_gain = 1.1;
    assert_int_equal(rig_shoot(rig, &asked, 0).flags, TTF_FRAME_ERROR);
}

static void a_frame_lost_within_a_set_is_skipped_and_the_next_is_flagged(void **state)
{
    struct ttf_exposure asked[4] = {of_us(8000, 1000), of_us(8000, 1000), of_us(8000, 1000),
                                    of_us(8000, 1000)};
    static const unsigned come[3] = {0, 2, 3};
    struct rig *rig = *state;

    rig_start(rig);
    asked[0] = asked[1] = asked[2] = asked[3] = rig_shoot(rig, &asked[0], 0).settings;
    assert_int_equal(rig_submit(rig, asked, 4, 0), 0);
    rig->fake.fate_from = fake_libcamera_next(&rig->fake);
    rig->fake.dropped = 2;
    for (unsigned i = 0; i < 3; i++) {
        struct ttf_frame *frame = NULL;

        assert_int_equal(rig_next(rig, &frame), 0);
        if (!frame)
            abort();
        assert_int_equal(frame->set_index, come[i]);
        assert_int_equal(frame->flags, i == 1 ? TTF_FRAME_SEQUENCE_GAP : 0);
        ttf_camera_release(rig->camera, frame);
    }
}

static void a_silent_camera_times_out_and_a_restart_helps(void **state)
{
    struct ttf_exposure asked = of_us(8000, 1000);
    struct ttf_frame *frame = NULL;
    struct rig *rig = *state;

    rig_start(rig);
    rig->fake.silent = true;
    assert_int_equal(rig_submit(rig, &asked, 1, 0), 0);
    assert_int_equal(rig_next(rig, &frame), -ETIMEDOUT);
    rig->fake.silent = false;
    assert_int_equal(ttf_camera_recover(rig->camera, TTF_CAMERA_REQUEUE, &rig->err), 0);
    (void)rig_shoot(rig, &asked, 0);
    assert_int_equal(ttf_camera_recover(rig->camera, TTF_CAMERA_RESTART, &rig->err), 0);
    (void)rig_shoot(rig, &asked, 0);
}

static void requests_that_come_back_unexposed_are_an_error_of_the_stream(void **state)
{
    struct ttf_exposure asked = of_us(8000, 1000);
    struct ttf_frame *frame = NULL;
    struct rig *rig = *state;

    rig_start(rig);
    rig->fake.cancels = true;
    assert_int_equal(rig_submit(rig, &asked, 1, 0), 0);
    assert_int_equal(rig_next(rig, &frame), -EIO);
    assert_says(rig, "gave a request up");
}

static void a_lost_camera_is_gone_until_it_is_back_and_then_the_same(void **state)
{
    struct ttf_exposure asked = of_us(8000, 1390), granted;
    struct ttf_frame *frame = NULL, again;
    const char *id;
    struct rig *rig = *state;

    rig_start(rig);
    id = rig->fake.id;
    granted = rig_shoot(rig, &asked, 0).settings;
    rig->fake.id = NULL;
    assert_int_equal(rig_submit(rig, &granted, 1, 0), 0);
    assert_int_equal(rig_next(rig, &frame), -ENODEV);
    assert_int_equal(ttf_camera_recover(rig->camera, TTF_CAMERA_REOPEN, &rig->err), -ENODEV);
    assert_int_equal(rig_submit(rig, &granted, 1, 0), -ENODEV);
    assert_int_equal(ttf_camera_recover(rig->camera, TTF_CAMERA_RESTART, &rig->err), -ENODEV);
    rig->fake.id = id;
    assert_int_equal(ttf_camera_recover(rig->camera, TTF_CAMERA_REOPEN, &rig->err), 0);
    again = rig_shoot(rig, &granted, 0);
    assert_memory_equal(&again.settings, &granted, sizeof(granted));
    assert_int_equal(again.flags, 0);
}

static void a_camera_that_comes_back_different_is_refused(void **state)
{
    struct ttf_exposure asked = of_us(8000, 1000);
    struct rig *rig = *state;

    rig_start(rig);
    (void)rig_shoot(rig, &asked, 0);
    rig->fake.width = 32;
    assert_int_equal(ttf_camera_recover(rig->camera, TTF_CAMERA_REOPEN, &rig->err), -EIO);
    assert_says(rig, "came back with another format");
    rig->fake.width = 64;
    fake_libcamera_take_away(&rig->fake, LC_GAIN);
    assert_int_equal(ttf_camera_recover(rig->camera, TTF_CAMERA_REOPEN, &rig->err), -EIO);
}

static void another_camera_in_its_place_is_not_taken_for_it(void **state)
{
    struct rig *rig = *state;

    rig_start(rig);
    rig->fake.id = "/base/soc/i2c0mux/i2c@1/imx000@10";
    assert_int_equal(ttf_camera_recover(rig->camera, TTF_CAMERA_REOPEN, &rig->err), -ENODEV);
}

static void a_request_that_cannot_be_given_back_is_said_by_next(void **state)
{
    struct ttf_exposure asked[2] = {of_us(8000, 1000), of_us(8000, 1000)};
    struct ttf_frame *frame = NULL;
    struct rig *rig = *state;

    rig_start(rig);
    assert_int_equal(rig_submit(rig, asked, 2, 0), 0);
    assert_int_equal(rig_next(rig, &frame), 0);
    rig->fake.queue_failure = -EIO;
    ttf_camera_release(rig->camera, frame);
    assert_int_equal(rig_next(rig, &frame), -EIO);
}

static void a_box_that_idles_for_a_day_goes_on(void **state)
{
    struct ttf_exposure asked = of_us(8000, 1000);
    const struct ttf_camera_caps *caps;
    struct ttf_frame frame;
    struct rig *rig = *state;
    int64_t middle;

    rig_start(rig);
    caps = ttf_camera_caps(rig->camera);
    asked = rig_shoot(rig, &asked, 0).settings;
    ttf_clock_wait_until(rig->clock, now(rig) + 24 * TTF_NS_PER_H);
    middle = now(rig) + caps->lead_ns + 7 * MS;
    frame = rig_shoot(rig, &asked, middle);
    assert_true(llabs(middle_of(&frame) - middle) <= caps->timing_bound_ns);
    assert_int_equal(frame.flags, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_RIG(what_was_read_back_is_granted_again_to_the_last_digit),
        ON_RIG(settings_of_an_earlier_run_are_granted_again),
        ON_RIG(frames_under_way_with_the_settings_of_before_are_passed_over),
        ON_RIG(a_bracket_has_each_of_its_settings),
        ON_RIG(an_exposure_that_is_clamped_without_a_word_is_told_as_it_was),
        ON_RIG(a_request_whose_settings_were_lost_costs_no_more_than_its_frame),
        ON_RIG(settings_that_begin_to_wander_end_the_set_in_words),
        ON_RIG(a_frame_whose_settings_changed_by_themselves_says_so),
        ON_RIG(middles_fall_where_they_were_asked_to),
        ON_RIG(a_long_exposure_is_placed_too),
        ON_RIG(a_lost_frame_on_the_way_does_not_lead_steering_astray),
        ON_RIG(a_drivers_own_stamp_is_brought_to_the_boot_clock),
        ON_RIG(without_any_stamp_the_arrival_counts_and_is_said),
        ON_RIG(a_stamp_of_the_readout_is_dated_back_by_the_exposure),
        ON_RIG(a_stamp_of_the_exposure_is_its_beginning),
        ON_RIG(frames_in_error_short_or_mute_are_handed_out_with_their_marks),
        ON_RIG(a_digital_gain_that_comes_later_marks_the_frame_bad),
        ON_RIG(a_frame_lost_within_a_set_is_skipped_and_the_next_is_flagged),
        ON_RIG(a_silent_camera_times_out_and_a_restart_helps),
        ON_RIG(requests_that_come_back_unexposed_are_an_error_of_the_stream),
        ON_RIG(a_lost_camera_is_gone_until_it_is_back_and_then_the_same),
        ON_RIG(a_camera_that_comes_back_different_is_refused),
        ON_RIG(another_camera_in_its_place_is_not_taken_for_it),
        ON_RIG(a_request_that_cannot_be_given_back_is_said_by_next),
        ON_RIG(a_box_that_idles_for_a_day_goes_on),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
