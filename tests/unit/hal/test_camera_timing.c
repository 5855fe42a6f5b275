/* SPDX-License-Identifier: Apache-2.0 */
/* When the simulated sensor exposes: control delay, steering, free running. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>

#include "camera_timing.h"
#include "ttf/base/time.h"

#define S  TTF_NS_PER_S
#define MS TTF_NS_PER_MS

static const struct camera_timing steerable = {.period_ns = 30 * MS,
                                               .period_max_ns = S,
                                               .readout_ns = 20 * MS,
                                               .line_ns = 25000,
                                               .delay_frames = 2,
                                               .steerable = true};

static int64_t middle(const struct camera_timing *t, int64_t read, int64_t exposure)
{
    return read + camera_timing_middle_ns(t, exposure);
}

static void settings_take_their_control_delay(void **state)
{
    struct camera_timing t = steerable;

    (void)state;
    /* Readouts at ..., 90, 120, 150, ... ms; asked at 100 ms. */
    assert_true(camera_timing_first_ns(&t, 90 * MS, 100 * MS, 10 * MS, 0) == 180 * MS);
    t.delay_frames = 1;
    assert_true(camera_timing_first_ns(&t, 90 * MS, 100 * MS, 10 * MS, 0) == 150 * MS);
    /* A phase that lies ahead is the same phase. */
    assert_true(camera_timing_first_ns(&t, 90 * MS + 40 * t.period_ns, 100 * MS, 10 * MS, 0) ==
                150 * MS);
}

static void a_long_exposure_makes_its_frame_longer(void **state)
{
    int64_t read = camera_timing_first_ns(&steerable, 0, 95 * MS, 500 * MS, 0);

    (void)state;
    /* Begins with the frame at 150 ms (95 + one period's delay), not before. */
    assert_true(read - 500 * MS >= 150 * MS);
    assert_true(read - 500 * MS < 151 * MS);
}

static void a_steered_middle_is_met_within_half_a_line_whenever_it_is_asked_for(void **state)
{
    (void)state;
    for (int64_t k = 0; k < 2000; k++) {
        int64_t exposure = 1 * MS + k % 40 * 7 * MS, now = k * 13 * MS + 12345;
        int64_t wanted = now + 500 * MS + k * k * 1717;
        int64_t read = camera_timing_first_ns(&steerable, k * 999, now, exposure, wanted);

        assert_true(llabs(middle(&steerable, read, exposure) - wanted) <=
                    camera_timing_bound_ns(&steerable));
    }
    assert_true(camera_timing_bound_ns(&steerable) < MS / 10);
}

static void where_a_steered_frame_falls_depends_only_on_where_it_was_wanted(void **state)
{
    int64_t first = camera_timing_first_ns(&steerable, 0, 0, 10 * MS, 60 * S + 12345);

    (void)state;
    assert_true(first % steerable.line_ns == 0);
    for (int64_t k = 1; k < 1000; k++)
        assert_true(camera_timing_first_ns(&steerable, k * 31337, k * 50 * MS, 10 * MS,
                                           60 * S + 12345) == first);
}

static void without_steering_the_nearest_frame_is_taken(void **state)
{
    struct camera_timing t = steerable;
    int64_t worst = 0;

    (void)state;
    t.steerable = false;
    for (int64_t k = 0; k < 2000; k++) {
        int64_t wanted = 500 * MS + k * 137771;
        int64_t read = camera_timing_first_ns(&t, 7 * MS, 0, 10 * MS, wanted);
        int64_t error = llabs(middle(&t, read, 10 * MS) - wanted);

        assert_true((read - 7 * MS) % t.period_ns == 0);
        if (error > worst)
            worst = error;
    }
    assert_true(worst <= camera_timing_bound_ns(&t));
    assert_true(worst > t.period_ns / 2 - MS); /* the bound is no idle promise */
}

static void frames_that_stretch_too_little_leave_gaps_that_the_bound_knows(void **state)
{
    struct camera_timing t = steerable;

    (void)state;
    t.period_max_ns = 40 * MS; /* 41 to 59 ms cannot be made of frames of 30 to 40 */
    assert_true(camera_timing_bound_ns(&t) >= 10 * MS);
    for (int64_t k = 0; k < 3000; k++) {
        int64_t wanted = 100 * MS + k * 97777;
        int64_t read = camera_timing_first_ns(&t, 0, 0, 10 * MS, wanted);

        assert_true(llabs(middle(&t, read, 10 * MS) - wanted) <= camera_timing_bound_ns(&t));
    }
}

static void settings_are_quantised_to_the_drivers_steps_and_limits(void **state)
{
    (void)state;
    assert_true(camera_quantise(1000, 100, 5000, 300) == 1000);
    assert_true(camera_quantise(1149, 100, 5000, 300) == 1000);
    assert_true(camera_quantise(1150, 100, 5000, 300) == 1300);
    assert_true(camera_quantise(7, 100, 5000, 300) == 100);
    assert_true(camera_quantise(9999, 100, 5000, 300) == 4900);
    for (int64_t v = 0; v < 6000; v += 7) {
        int64_t q = camera_quantise(v, 100, 5000, 300);

        assert_true(camera_quantise(q, 100, 5000, 300) == q);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(settings_take_their_control_delay),
        cmocka_unit_test(a_long_exposure_makes_its_frame_longer),
        cmocka_unit_test(a_steered_middle_is_met_within_half_a_line_whenever_it_is_asked_for),
        cmocka_unit_test(where_a_steered_frame_falls_depends_only_on_where_it_was_wanted),
        cmocka_unit_test(without_steering_the_nearest_frame_is_taken),
        cmocka_unit_test(frames_that_stretch_too_little_leave_gaps_that_the_bound_knows),
        cmocka_unit_test(settings_are_quantised_to_the_drivers_steps_and_limits),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
