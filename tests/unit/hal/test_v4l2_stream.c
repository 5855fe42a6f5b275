/* SPDX-License-Identifier: Apache-2.0 */
/* A V4L2 camera that streams, and all that its driver can do wrong. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "alloc/alloc_hook.h"
#include "v4l2_fixture.h"

static int64_t now_ns(struct bench *bench)
{
    return ttf_clock_now_ns(bench->clock);
}

/* ---- settings ---- */

static void settings_reach_the_very_frames_they_are_asked_for(void **state)
{
    struct bench *bench = *state;
    const struct ttf_exposure bracket[] = {of_ms(5, 1000), of_ms(5, 1000), of_ms(10, 2000),
                                           of_ms(2, 1500)};
    struct ttf_camera_set set = {.settings = bracket, .n = 4};

    bench_start(bench);
    assert_int_equal(ttf_camera_submit(bench->camera, &set, NULL), 0);
    for (unsigned i = 0; i < 4; i++) {
        struct ttf_frame *frame = NULL;
        int exposure = 0, gain = 0;

        assert_int_equal(bench_next(bench, &frame), 0);
        if (!frame)
            abort();
        assert_int_equal(frame->set_index, i);
        assert_memory_equal(&frame->settings, &bracket[i], sizeof(bracket[i]));
        fake_exposed_with(frame->data, &exposure, &gain);
        assert_int_equal(exposure * 100, bracket[i].exposure_ns / TTF_NS_PER_US);
        assert_int_equal(gain * 1000 / 64, bracket[i].gain_milli);
        ttf_camera_release(bench->camera, frame);
    }
}

static void settings_that_stay_cost_no_frames(void **state)
{
    struct bench *bench = *state;
    uint64_t before;

    bench_start(bench);
    before = bench_warm(bench, 5);
    assert_in_range(bench_shoot(bench, 5, 1000).sequence, before, before + 2);
}

static void what_another_hand_changed_shows_in_what_is_read_back(void **state)
{
    struct bench *bench = *state;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    fake_control(&bench->fake, V4L2_CID_EXPOSURE_ABSOLUTE)->value = 77;
    assert_true(bench_shoot(bench, 5, 1000).settings.exposure_ns == 77 * MS / 10);
}

/* Once or twice, to the same value: its processor begins anew with what it was made with. */
static void a_camera_that_loses_its_settings_is_set_up_anew(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame frame;
    int exposure = 0, gain = 0;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    for (unsigned i = 0; i < 2; i++) {
        fake_control(&bench->fake, V4L2_CID_EXPOSURE_ABSOLUTE)->value = 77;
        fake_control(&bench->fake, V4L2_CID_GAIN)->value = 3;
        fake_control(&bench->fake, V4L2_CID_AUTOGAIN)->value = 1;
        fake_control(&bench->fake, V4L2_CID_EXPOSURE_AUTO)->value = V4L2_EXPOSURE_APERTURE_PRIORITY;
        assert_true(bench_shoot(bench, 5, 1000).settings.exposure_ns == 77 * MS / 10);
        frame = bench_shoot(bench, 5, 1000);
        assert_true(frame.settings.exposure_ns == 5 * MS && frame.settings.gain_milli == 1000);
        fake_exposed_with(frame.data, &exposure, &gain);
        assert_int_equal(exposure, 50);
        assert_int_equal(gain, 64);
        assert_int_equal(fake_control(&bench->fake, V4L2_CID_AUTOGAIN)->value, 0);
        assert_int_equal(fake_control(&bench->fake, V4L2_CID_EXPOSURE_AUTO)->value,
                         V4L2_EXPOSURE_MANUAL);
    }
}

static void a_camera_that_cannot_be_set_up_anew_is_tried_again(void **state)
{
    struct bench *bench = *state;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    fake_control(&bench->fake, V4L2_CID_EXPOSURE_ABSOLUTE)->value = 77;
    (void)bench_shoot(bench, 5, 1000);
    bench->fake.failing = VIDIOC_S_EXT_CTRLS;
    bench->fake.failure = -EPIPE;
    bench->fake.failures = 3; /* both modes of exposure, and once more */
    assert_int_equal(bench_submit(bench, 5, 1, 0), -EIO);
    assert_int_equal(ttf_camera_recover(bench->camera, TTF_CAMERA_REQUEUE, NULL), 0);
    bench->fake.failures = 0;
    assert_true(bench_shoot(bench, 5, 1000).settings.exposure_ns == 5 * MS);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_EXPOSURE_ABSOLUTE)->value, 50);
}

static void a_camera_that_obeys_late_is_asked_until_it_does(void **state)
{
    struct bench *bench = *state;
    struct fake_control *exposure;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    exposure = fake_control(&bench->fake, V4L2_CID_EXPOSURE_ABSOLUTE);
    exposure->value = 77;
    exposure->stuck = true;
    for (unsigned i = 0; i < 4; i++)
        assert_true(bench_shoot(bench, 5, 1000).settings.exposure_ns == 77 * MS / 10);
    exposure->stuck = false;
    (void)bench_shoot(bench, 5, 1000);
    assert_true(bench_shoot(bench, 5, 1000).settings.exposure_ns == 5 * MS);
}

static void a_driver_that_never_grants_what_is_asked_costs_no_frames_for_ever(void **state)
{
    struct bench *bench = *state;
    uint64_t before;

    bench_start(bench);
    fake_control(&bench->fake, V4L2_CID_EXPOSURE_ABSOLUTE)->stuck = true;
    (void)bench_warm(bench, 5);
    (void)bench_warm(bench, 5); /* asked once more */
    before = bench_warm(bench, 5);
    assert_in_range(bench_shoot(bench, 5, 1000).sequence, before, before + 2);
}

static void a_refusal_is_told_in_the_camera_s_own_terms(void **state)
{
    struct bench *bench = *state;

    bench_start(bench);
    bench->fake.failing = VIDIOC_S_EXT_CTRLS;
    bench->fake.failures = 2;
    bench->fake.failure = -EILSEQ;
    assert_int_equal(bench_submit(bench, 5, 1, 0), -EIO);
    assert_says(bench, "not in the state that the camera is in");
    bench->fake.failure = -EREMOTE;
    assert_int_equal(bench_submit(bench, 5, 1, 0), -EIO);
    assert_says(bench, "power");
}

static void a_driver_that_does_not_take_or_tell_settings_is_found_out(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;

    bench_start(bench);
    bench->fake.failing = VIDIOC_S_EXT_CTRLS;
    bench->fake.failure = -EPIPE;
    bench->fake.failures = 1;
    assert_int_equal(bench_submit(bench, 5, 1, 0), -EIO);
    assert_says(bench, "does not take the settings");
    assert_int_equal(bench_submit(bench, 5, 1, 0), 0);
    bench->fake.failing = VIDIOC_G_EXT_CTRLS;
    bench->fake.failures = 1;
    assert_int_equal(bench_next(bench, &frame), 0);
    if (!frame)
        abort();
    assert_true(frame->flags & TTF_FRAME_ERROR);
    ttf_camera_release(bench->camera, frame);
}

/* ---- what is lost ---- */

static void a_lost_frame_of_a_set_never_comes_and_the_next_says_so(void **state)
{
    struct bench *bench = *state;
    static const unsigned COME[] = {0, 1, 4, 5};
    struct ttf_frame *frame = NULL;

    bench_start(bench);
    bench->fake.fate_from = bench_warm(bench, 5) + 3; /* one goes by between submit and set */
    bench->fake.dropped = 3;
    assert_int_equal(bench_submit(bench, 5, 6, 0), 0);
    for (unsigned i = 0; i < 4; i++) {
        assert_int_equal(bench_next(bench, &frame), 0);
        if (!frame)
            abort();
        assert_int_equal(frame->set_index, COME[i]);
        assert_int_equal(frame->flags & TTF_FRAME_SEQUENCE_GAP,
                         i == 2 ? TTF_FRAME_SEQUENCE_GAP : 0);
        ttf_camera_release(bench->camera, frame);
    }
    assert_int_equal(bench_next(bench, &frame), -ENODATA);
}

static void a_set_whose_rest_is_lost_is_over(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;

    bench_start(bench);
    bench->fake.fate_from = bench_warm(bench, 5) + 2;
    bench->fake.dropped = 7;
    assert_int_equal(bench_submit(bench, 5, 3, 0), 0);
    assert_int_equal(bench_next(bench, &frame), 0);
    ttf_camera_release(bench->camera, frame);
    assert_int_equal(bench_next(bench, &frame), -ENODATA);
    assert_says(bench, "rest of the set was lost");
    assert_int_equal(bench_submit(bench, 5, 1, 0), 0);
}

static void the_frame_wanted_is_lost_and_none_of_another_time_is_put_in_its_place(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;
    int64_t middle;

    bench_start(bench);
    bench->fake.fate_from = bench_warm(bench, 5) + 10;
    bench->fake.dropped = 3;
    middle = now_ns(bench) + 10 * bench->fake.period_ns;
    assert_int_equal(bench_submit(bench, 5, 1, middle), 0);
    assert_int_equal(bench_next(bench, &frame), -ENODATA);
    bench->fake.dropped = 0;
    middle = now_ns(bench) + 10 * bench->fake.period_ns;
    assert_int_equal(bench_submit(bench, 5, 1, middle), 0);
    assert_int_equal(bench_next(bench, &frame), 0);
    if (!frame)
        abort();
    assert_true(llabs((frame->start_ns + frame->end_ns) / 2 - middle) <= bench->fake.period_ns / 2);
    ttf_camera_release(bench->camera, frame);
}

static void bad_and_short_buffers_are_handed_out_with_their_flag(void **state)
{
    struct bench *bench = *state;
    static const uint32_t FLAGS[] = {0, TTF_FRAME_ERROR, TTF_FRAME_SHORT, 0};
    struct ttf_frame *frame = NULL;

    bench_start(bench);
    bench->fake.fate_from = bench_warm(bench, 5) + 1;
    bench->fake.in_error = 2;
    bench->fake.cut = 4;
    assert_int_equal(bench_submit(bench, 5, 4, 0), 0);
    for (unsigned i = 0; i < 4; i++) {
        assert_int_equal(bench_next(bench, &frame), 0);
        if (!frame)
            abort();
        assert_int_equal(frame->set_index, i);
        assert_int_equal(frame->flags, FLAGS[i]);
        assert_int_equal(frame->bytes < 64 * 48 * 2, FLAGS[i] == TTF_FRAME_SHORT);
        ttf_camera_release(bench->camera, frame);
    }
}

static void a_stream_that_falls_silent_times_out(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    bench->fake.silent = true;
    assert_int_equal(bench_submit(bench, 5, 1, 0), 0);
    assert_int_equal(bench_next(bench, &frame), -ETIMEDOUT);
}

/* ---- time ---- */

static void frames_are_dated_on_the_boot_clock_whatever_the_driver_stamps(void **state)
{
    struct bench *bench = *state;
    struct ttf_v4l2_info info;
    static const uint32_t STAMPS[] = {V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC,
                                      V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC |
                                          V4L2_BUF_FLAG_TSTAMP_SRC_SOE};

    bench->lag_ns = bench->fake.monotonic_lag_ns = 5 * TTF_NS_PER_H; /* slept a night */
    bench->config.readout_ns = bench->fake.readout_ns;
    bench_start(bench);
    for (unsigned i = 0; i < 2; i++) {
        struct ttf_frame frame;
        int64_t read;

        bench->fake.stamp_flags = STAMPS[i];
        (void)bench_warm(bench, 5);
        frame = bench_shoot(bench, 5, 1000);
        read = bench->fake.began_ns + ((int64_t)frame.sequence + 1) * bench->fake.period_ns;
        assert_true(llabs(frame.end_ns - read) < TTF_NS_PER_US);
        assert_true(llabs(frame.start_ns - (read - bench->fake.readout_ns - 5 * MS)) <
                    TTF_NS_PER_US);
        assert_int_equal(frame.flags, 0);
    }
    ttf_v4l2_camera_info(bench->camera, &info);
    assert_true(info.sensor_time);
    assert_true(info.time_uncertainty_ns == 250);
}

static void frames_of_before_a_suspend_are_passed_over(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;
    int64_t woke;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    assert_int_equal(bench_submit(bench, 5, 3, 0), 0);
    assert_int_equal(bench_next(bench, &frame), 0);
    ttf_camera_release(bench->camera, frame);
    /* What is in flight is stamped already when the machine goes to sleep. */
    ttf_clock_wait_until(bench->clock, now_ns(bench) + 3 * bench->fake.period_ns);
    (void)fake_next_sequence(&bench->fake);
    bench->lag_ns = bench->fake.monotonic_lag_ns = TTF_NS_PER_H;
    woke = now_ns(bench);
    assert_int_equal(bench_next(bench, &frame), 0);
    if (!frame)
        abort();
    assert_true(frame->start_ns >= woke);
    ttf_camera_release(bench->camera, frame);
}

static void what_has_arrived_is_not_dated_later(void **state)
{
    struct bench *bench = *state;

    /* Stamped at the beginning, and of the readout we know no better than a whole period. */
    bench->fake.stamp_flags |= V4L2_BUF_FLAG_TSTAMP_SRC_SOE;
    bench_start(bench);
    assert_true(bench_shoot(bench, 5, 1000).end_ns <= now_ns(bench));
}

static void without_a_stamp_the_arrival_counts_and_is_marked(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame frame;

    bench->fake.stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_UNKNOWN;
    bench_start(bench);
    frame = bench_shoot(bench, 5, 1000);
    assert_int_equal(frame.flags, TTF_FRAME_NO_SENSOR_TIME);
    assert_true(frame.end_ns == now_ns(bench));
}

/* ---- failing requests, and the ladder ---- */

static void another_program_that_has_the_camera_is_named_as_the_cause(void **state)
{
    struct bench *bench = *state;
    static const unsigned long AT_START[] = {VIDIOC_REQBUFS, VIDIOC_STREAMON};

    bench->fake.failing = VIDIOC_S_FMT;
    bench->fake.failure = -EBUSY;
    bench->fake.failures = 1;
    assert_int_equal(bench_configure(bench), -EBUSY);
    assert_says(bench, "another program uses the camera");
    assert_int_equal(bench_configure(bench), 0);
    for (unsigned i = 0; i < 2; i++) {
        bench->fake.failing = AT_START[i];
        bench->fake.failures = 1;
        assert_int_equal(ttf_camera_start(bench->camera, &bench->err), -EBUSY);
        assert_says(bench, "another program uses the camera");
    }
    assert_int_equal(ttf_camera_start(bench->camera, NULL), 0);
}

static void a_start_that_fails_anywhere_can_be_tried_again(void **state)
{
    struct bench *bench = *state;
    static const unsigned long STEPS[] = {VIDIOC_REQBUFS, VIDIOC_QUERYBUF, VIDIOC_QBUF,
                                          VIDIOC_STREAMON};

    assert_int_equal(bench_configure(bench), 0);
    for (unsigned i = 0; i < 4; i++) {
        bench->fake.failing = STEPS[i];
        bench->fake.failure = -EINVAL;
        bench->fake.failures = 1;
        assert_int_equal(ttf_camera_start(bench->camera, &bench->err), -EINVAL);
        assert_int_equal(bench->fake.mapped, bench->fake.unmapped);
    }
    assert_int_equal(ttf_camera_start(bench->camera, NULL), 0);
    (void)bench_shoot(bench, 5, 1000);
}

static void too_few_buffers_are_refused(void **state)
{
    struct bench *bench = *state;

    bench->fake.buffers_max = 2;
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(ttf_camera_start(bench->camera, &bench->err), -ENOMEM);
    assert_says(bench, "2 buffers, and 3 are needed");
}

/* What capture does: steps of the ladder until a frame comes. The step that did it. */
static int climb(struct bench *bench)
{
    for (int step = TTF_CAMERA_REQUEUE; step < TTF_CAMERA_RECOVERY_COUNT; step++) {
        struct ttf_frame *frame = NULL;

        if (ttf_camera_recover(bench->camera, (enum ttf_camera_recovery)step, &bench->err) < 0 ||
            bench_submit(bench, 5, 1, 0) < 0 || bench_next(bench, &frame) < 0)
            continue;
        ttf_camera_release(bench->camera, frame);
        return step;
    }
    return -1;
}

static void a_stream_that_fails_is_restarted(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    assert_int_equal(bench_submit(bench, 5, 1, 0), 0);
    bench->fake.dead = true;
    assert_int_equal(bench_next(bench, &frame), -EIO);
    assert_int_equal(climb(bench), TTF_CAMERA_RESTART);
    assert_int_equal(bench->fake.opened, 1);
}

static void a_buffer_that_is_not_taken_back_is_noticed_and_given_back_again(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;

    bench_start(bench);
    assert_int_equal(bench_submit(bench, 5, 2, 0), 0);
    assert_int_equal(bench_next(bench, &frame), 0);
    bench->fake.failing = VIDIOC_QBUF;
    bench->fake.failure = -EINVAL;
    bench->fake.failures = 1;
    ttf_camera_release(bench->camera, frame);
    assert_int_equal(bench_next(bench, &frame), -EIO);
    assert_int_equal(climb(bench), TTF_CAMERA_REQUEUE);
}

static void a_requeue_takes_back_what_the_caller_forgot(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;

    bench_start(bench);
    assert_int_equal(bench_submit(bench, 5, 3, 0), 0);
    assert_int_equal(bench_next(bench, &frame), 0);
    assert_int_equal(bench_next(bench, &frame), 0);
    assert_int_equal(bench_next(bench, &frame), -ETIMEDOUT);
    assert_int_equal(climb(bench), TTF_CAMERA_REQUEUE);
}

static void a_restart_asks_for_the_settings_again(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame frame;
    int exposure = 0, gain = 0;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    fake_control(&bench->fake, V4L2_CID_EXPOSURE_ABSOLUTE)->value =
        999; /* a hiccup of its processor */
    assert_int_equal(ttf_camera_recover(bench->camera, TTF_CAMERA_RESTART, NULL), 0);
    frame = bench_shoot(bench, 5, 1000);
    fake_exposed_with(frame.data, &exposure, &gain);
    assert_int_equal(exposure, 50);
    assert_true(frame.settings.exposure_ns == 5 * MS);
}

static void a_camera_that_comes_back_under_another_name_is_found_and_set_up_anew(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;
    struct ttf_v4l2_info info;
    int exposure = 0, gain = 0;

    strcpy(bench->config.device, "/dev/video0");
    bench_start(bench);
    (void)bench_warm(bench, 5);
    assert_int_equal(bench_submit(bench, 5, 1, 0), 0);
    fake_unplug(&bench->fake);
    assert_int_equal(bench_next(bench, &frame), -ENODEV);
    assert_int_equal(climb(bench), -1);
    assert_says(bench, "the camera 'Fake camera' (test-1.2) is gone");
    assert_int_equal(bench_submit(bench, 5, 1, 0), -ENODEV);
    fake_plug(&bench->fake, "/dev/video7");
    assert_int_equal(climb(bench), TTF_CAMERA_REOPEN);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_AUTOGAIN)->value, 0);
    ttf_v4l2_camera_info(bench->camera, &info);
    assert_string_equal(info.device, "/dev/video7");
    fake_exposed_with(bench_shoot(bench, 5, 1000).data, &exposure, &gain);
    assert_int_equal(exposure, 50);
}

/* A webcam of a board that knows no unit of its lens: a person turned it to 121, between two of its steps. */
static void a_lens_without_a_unit_is_where_it_was_after_a_replug(void **state)
{
    struct bench *bench = *state;
    const struct fake_control focus = {V4L2_CID_FOCUS_ABSOLUTE,
                                       V4L2_CTRL_TYPE_INTEGER,
                                       "Focus, Absolute",
                                       0,
                                       250,
                                       5,
                                       30,
                                       121,
                                       false};

    bench->fake.controls[10] = focus;
    bench_start(bench);
    assert_false(ttf_camera_caps(bench->camera)->has_lens);
    assert_true(ttf_camera_caps(bench->camera)->lens_held);
    assert_int_equal(ttf_camera_caps(bench->camera)->lens_code, 121);
    (void)bench_warm(bench, 5);
    fake_unplug(&bench->fake);
    fake_plug(&bench->fake, "/dev/video0");
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_FOCUS_ABSOLUTE)->value, 30);
    assert_int_equal(climb(bench), TTF_CAMERA_REOPEN);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_FOCUS_ABSOLUTE)->value, 120);
    (void)bench_shoot(bench, 5, 1000);
    /* A new configuration takes what a person has made of it since. */
    ttf_camera_stop(bench->camera);
    fake_control(&bench->fake, V4L2_CID_FOCUS_ABSOLUTE)->value = 45;
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(ttf_camera_caps(bench->camera)->lens_code, 45);
}

static void another_camera_at_its_place_is_not_taken_for_it(void **state)
{
    struct bench *bench = *state;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    fake_unplug(&bench->fake);
    bench->fake.bus = "test-1.3"; /* the same model in another socket, and it is another one */
    bench->fake.serial = "0002";
    fake_plug(&bench->fake, "/dev/video0");
    assert_int_equal(climb(bench), -1);
    assert_says(bench, "there is /dev/video0 'Fake camera' (test-1.3)");
    bench->fake.bus = "test-1.2"; /* even where the first one was */
    assert_int_equal(climb(bench), -1);
    bench->fake.serial = "";
    assert_int_equal(climb(bench), TTF_CAMERA_REOPEN);
}

static void a_camera_that_was_moved_to_another_socket_is_found_there(void **state)
{
    struct bench *bench = *state;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    fake_unplug(&bench->fake);
    bench->fake.bus = "test-3.4";
    fake_plug(&bench->fake, "/dev/video2");
    assert_int_equal(climb(bench), TTF_CAMERA_REOPEN);
    (void)bench_shoot(bench, 5, 1000);
}

static void a_camera_that_comes_back_different_is_refused(void **state)
{
    struct bench *bench = *state;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    bench->fake.formats[0].fourcc = V4L2_PIX_FMT_SRGGB8;
    assert_int_equal(ttf_camera_recover(bench->camera, TTF_CAMERA_REOPEN, &bench->err), -EIO);
    assert_says(bench, "came back with another format");
    assert_int_equal(ttf_camera_format(bench->camera)->packing, TTF_PACKING_RAW16);
    bench->fake.formats[0].fourcc = V4L2_PIX_FMT_SRGGB10;
    fake_control_remove(&bench->fake, V4L2_CID_GAIN);
    assert_int_equal(ttf_camera_recover(bench->camera, TTF_CAMERA_REOPEN, &bench->err), -EIO);
}

static void a_release_after_the_end_is_harmless(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;

    bench_start(bench);
    assert_int_equal(bench_submit(bench, 5, 1, 0), 0);
    assert_int_equal(bench_next(bench, &frame), 0);
    ttf_camera_stop(bench->camera);
    ttf_camera_release(bench->camera, frame);
    assert_int_equal(ttf_camera_start(bench->camera, NULL), 0);
    (void)bench_shoot(bench, 5, 1000);
}

static void frames_cost_no_allocation(void **state)
{
    struct bench *bench = *state;
    unsigned long calls = 0;

    bench_start(bench);
    (void)bench_warm(bench, 5);
    for (unsigned i = 0; i < 50; i++) {
        struct alloc_counts before = alloc_hook_counts(ALLOC_ALL), after;

        (void)bench_shoot(bench, i % 2 ? 5 : 10, 1000);
        after = alloc_hook_counts(ALLOC_ALL);
        calls += after.calls - before.calls;
    }
    assert_int_equal(calls, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_BENCH(settings_reach_the_very_frames_they_are_asked_for),
        ON_BENCH(settings_that_stay_cost_no_frames),
        ON_BENCH(what_another_hand_changed_shows_in_what_is_read_back),
        ON_BENCH(a_camera_that_loses_its_settings_is_set_up_anew),
        ON_BENCH(a_camera_that_cannot_be_set_up_anew_is_tried_again),
        ON_BENCH(a_camera_that_obeys_late_is_asked_until_it_does),
        ON_BENCH(a_driver_that_never_grants_what_is_asked_costs_no_frames_for_ever),
        ON_BENCH(a_refusal_is_told_in_the_camera_s_own_terms),
        ON_BENCH(a_driver_that_does_not_take_or_tell_settings_is_found_out),
        ON_BENCH(a_lost_frame_of_a_set_never_comes_and_the_next_says_so),
        ON_BENCH(a_set_whose_rest_is_lost_is_over),
        ON_BENCH(the_frame_wanted_is_lost_and_none_of_another_time_is_put_in_its_place),
        ON_BENCH(bad_and_short_buffers_are_handed_out_with_their_flag),
        ON_BENCH(a_stream_that_falls_silent_times_out),
        ON_BENCH(frames_are_dated_on_the_boot_clock_whatever_the_driver_stamps),
        ON_BENCH(frames_of_before_a_suspend_are_passed_over),
        ON_BENCH(what_has_arrived_is_not_dated_later),
        ON_BENCH(without_a_stamp_the_arrival_counts_and_is_marked),
        ON_BENCH(another_program_that_has_the_camera_is_named_as_the_cause),
        ON_BENCH(a_start_that_fails_anywhere_can_be_tried_again),
        ON_BENCH(too_few_buffers_are_refused),
        ON_BENCH(a_stream_that_fails_is_restarted),
        ON_BENCH(a_buffer_that_is_not_taken_back_is_noticed_and_given_back_again),
        ON_BENCH(a_requeue_takes_back_what_the_caller_forgot),
        ON_BENCH(a_restart_asks_for_the_settings_again),
        ON_BENCH(a_camera_that_comes_back_under_another_name_is_found_and_set_up_anew),
        ON_BENCH(a_lens_without_a_unit_is_where_it_was_after_a_replug),
        ON_BENCH(another_camera_at_its_place_is_not_taken_for_it),
        ON_BENCH(a_camera_that_was_moved_to_another_socket_is_found_there),
        ON_BENCH(a_camera_that_comes_back_different_is_refused),
        ON_BENCH(a_release_after_the_end_is_harmless),
        ON_BENCH(frames_cost_no_allocation),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
