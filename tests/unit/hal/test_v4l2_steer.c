/* SPDX-License-Identifier: Apache-2.0 */
/* test_v4l2_steer.c: frames of a free-running stream moved in time, so that a middle meets its instant. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/attr.h"
#include "v4l2_fixture.h"

#define PERIOD (20 * MS)

/* How far the middles of sets at twelve phases of the stream are from what was asked for, at worst. */
static int64_t worst_error_ns(struct bench *bench)
{
    int64_t worst = 0;

    for (int64_t k = 0; k < 12; k++) {
        int64_t wanted = ttf_clock_now_ns(bench->clock) + ttf_camera_caps(bench->camera)->lead_ns +
                         k * 7 * MS / 3;
        struct ttf_frame *frame = NULL;
        int64_t error;

        assert_int_equal(bench_submit(bench, 5, 1, wanted), 0);
        assert_int_equal(bench_next(bench, &frame), 0);
        if (!frame)
            abort();
        assert_int_equal(frame->flags, 0);
        error = llabs(frame->start_ns + (frame->end_ns - frame->start_ns) / 2 - wanted);
        worst = error > worst ? error : worst;
        ttf_camera_release(bench->camera, frame);
        assert_int_equal(bench->fake.period_ns, PERIOD); /* it is as it was again */
    }
    return worst;
}

static void begin(struct bench *bench)
{
    bench->config.steer = true;
    bench_start(bench);
    (void)bench_warm(bench, 5);
}

static void a_stream_that_nobody_wants_moved_is_left_alone(void **state)
{
    struct bench *bench = *state;

    bench->fake.steers = true;
    bench_start(bench);
    (void)bench_warm(bench, 5);
    assert_true(worst_error_ns(bench) > PERIOD / 4);
    assert_int_equal(bench->fake.rates, 0);
}

static void a_stream_that_cannot_be_moved_is_off_by_up_to_half_a_frame(void **state)
{
    struct bench *bench = *state;

    begin(bench);
    assert_true(worst_error_ns(bench) > PERIOD / 4);
    assert_int_equal(bench->fake.rates, 0);
}

static void another_rate_for_a_few_frames_brings_the_middle_to_its_instant(void **state)
{
    struct bench *bench = *state;

    bench->fake.steers = true;
    begin(bench);
    assert_true(worst_error_ns(bench) <= PERIOD / 16);
}

static void a_driver_that_knows_few_rates_is_moved_as_near_as_they_lead(void **state)
{
    struct bench *bench = *state;

    bench->fake.steers = true;
    bench->fake.period_step_ns = 5 * MS;
    begin(bench);
    assert_true(worst_error_ns(bench) <= 5 * MS / 2 + MS / 10);
}

static void lines_of_blanking_do_the_same(void **state)
{
    struct bench *bench = *state;
    const struct fake_control sensor[] = {
        {V4L2_CID_PIXEL_RATE, V4L2_CTRL_TYPE_INTEGER64, "Pixel Rate", 1, 100000000, 1, 10000000,
         10000000, false},
        {V4L2_CID_HBLANK, V4L2_CTRL_TYPE_INTEGER, "Horizontal Blanking", 36, 36, 1, 36, 36, false},
        {V4L2_CID_VBLANK, V4L2_CTRL_TYPE_INTEGER, "Vertical Blanking", 4, 8000, 1, 100, 100, false},
    };

    memcpy(&bench->fake.controls[FAKE_CONTROLS - 3], sensor, sizeof sensor);
    bench->fake.line_ns = (64 + 36) * 100; /* of 64 pixels a row and 10 MHz */
    begin(bench);
    assert_true(worst_error_ns(bench) <= PERIOD / 16);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_VBLANK)->value, 100);
}

static void a_driver_that_refuses_while_it_streams_is_asked_once(void **state)
{
    struct bench *bench = *state;

    bench->fake.steers = true;
    begin(bench);
    bench->fake.failing = VIDIOC_S_PARM;
    bench->fake.failure = -EBUSY;
    bench->fake.failures = 1;
    assert_true(worst_error_ns(bench) > PERIOD / 4);
    assert_int_equal(bench->fake.failures, 0);
    assert_int_equal(bench->fake.rates, 0);
}

static void a_driver_that_takes_one_rate_and_refuses_the_next_is_not_left_with_it(void **state)
{
    struct bench *bench = *state;

    bench->fake.steers = true;
    bench->fake.period_step_ns = 5 * MS; /* so that the first does not do */
    begin(bench);
    bench->fake.failing = VIDIOC_S_PARM;
    bench->fake.failure = -EBUSY;
    bench->fake.failures = 1;
    bench->fake.served = 1;
    assert_true(worst_error_ns(bench) > PERIOD / 4); /* looks at the rate after each set, too */
    assert_int_equal(bench->fake.failures, 0);
    assert_int_equal(bench->fake.rates, 2);
}

static void a_set_that_is_dropped_while_frames_are_moved_leaves_the_rate_as_it_was(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame *frame = NULL;
    int64_t wanted;

    bench->fake.steers = true;
    begin(bench);
    for (unsigned k = 0; k < 40 && bench->fake.period_ns == PERIOD; k++) {
        wanted = ttf_clock_now_ns(bench->clock) + 400 * MS + k * 3 * MS;
        assert_int_equal(bench_submit(bench, 5, 1, wanted), 0);
        assert_int_equal(
            ttf_camera_next(bench->camera, ttf_clock_now_ns(bench->clock) + 25 * MS, &frame, NULL),
            -ETIMEDOUT);
        if (bench->fake.period_ns == PERIOD)
            ttf_camera_cancel(bench->camera);
    }
    assert_true(bench->fake.period_ns != PERIOD);
    ttf_camera_cancel(bench->camera);
    assert_int_equal(bench->fake.period_ns, PERIOD);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_BENCH(a_stream_that_nobody_wants_moved_is_left_alone),
        ON_BENCH(a_stream_that_cannot_be_moved_is_off_by_up_to_half_a_frame),
        ON_BENCH(another_rate_for_a_few_frames_brings_the_middle_to_its_instant),
        ON_BENCH(a_driver_that_knows_few_rates_is_moved_as_near_as_they_lead),
        ON_BENCH(lines_of_blanking_do_the_same),
        ON_BENCH(a_driver_that_refuses_while_it_streams_is_asked_once),
        ON_BENCH(a_driver_that_takes_one_rate_and_refuses_the_next_is_not_left_with_it),
        ON_BENCH(a_set_that_is_dropped_while_frames_are_moved_leaves_the_rate_as_it_was),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
