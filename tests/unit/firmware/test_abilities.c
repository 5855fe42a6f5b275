/* SPDX-License-Identifier: Apache-2.0 */
/* test_abilities.c: what is said of what cameras can and cannot do. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <string.h>

#include "abilities.h"

static const struct ttf_camera_caps ALL = {.exposure_min_ns = 25000,
                                           .exposure_max_ns = 10000000000,
                                           .gain_min_milli = 1000,
                                           .gain_max_milli = 22260,
                                           .has_white_balance = true,
                                           .has_lens = true,
                                           .steerable = true,
                                           .timing_bound_ns = 2400000,
                                           .frame_period_ns = 100000000,
                                           .lead_frames = 3};
/* A webcam that keeps everything to itself. */
static const struct ttf_camera_caps NONE = {.timing_bound_ns = 70000000,
                                            .frame_period_ns = 66666667};
static const struct ttf_frame_format RAW = {
    .width = 4056, .height = 3040, .packing = TTF_PACKING_RAW12P, .cfa = TTF_CFA_BGGR, .bits = 12};

static void a_camera_with_all_controls_has_their_ranges(void **state)
{
    struct probe_abilities can;

    (void)state;
    probe_abilities(&ALL, &RAW, &can);
    assert_string_equal(can.pixels, "mosaic BGGR of 12 bits, packed");
    assert_string_equal(can.line[0], "exposure 0.025 ms to 10000 ms");
    assert_string_equal(can.line[1], "gain 1.00 to 22.26");
    assert_non_null(strstr(can.line[2], "at what a plan says"));
    assert_non_null(strstr(can.line[3], "held and recorded"));
    assert_string_equal(can.line[4],
                        "time: 10.00 frames a second, steerable: the middle of an exposure within "
                        "2.4 ms of its slot; settings take 3 frames");
}

static void a_control_that_is_not_there_is_no_range_of_nothing(void **state)
{
    struct ttf_frame_format yuyv = {
        .width = 640, .height = 480, .packing = TTF_PACKING_YUYV8, .bits = 8};
    struct probe_abilities can;

    (void)state;
    probe_abilities(&NONE, &yuyv, &can);
    assert_string_equal(can.pixels, "YUYV (half the colour) of 8 bits");
    assert_non_null(strstr(can.line[0], "exposure: no control"));
    assert_non_null(strstr(can.line[0], "not known"));
    assert_string_equal(can.line[1], "gain: no control");
    assert_non_null(strstr(can.line[2], "not a plan's"));
    assert_non_null(strstr(can.line[3], "not a plan's"));
    assert_non_null(strstr(can.line[4], "15.00 frames a second, free-running"));
    for (unsigned i = 0; i < PROBE_ABILITIES; i++) {
        assert_null(strstr(can.line[i], "0.0 to 0.0"));
        assert_true(strlen(can.line[i]) < sizeof can.line[i] - 1); /* none is cut short */
    }
}

static void a_lens_that_is_held_says_where(void **state)
{
    struct ttf_camera_caps held = NONE;
    struct probe_abilities can;

    (void)state;
    held.lens_held = true;
    held.lens_code = 120;
    probe_abilities(&held, &RAW, &can);
    assert_non_null(strstr(can.line[3], "at 120 in the driver's own count"));
}

static void each_kind_of_pixels_has_a_word(void **state)
{
    struct probe_abilities can;

    (void)state;
    for (int packing = TTF_PACKING_NONE + 1; packing < TTF_PACKING_COUNT; packing++)
        for (int cfa = TTF_CFA_NONE; cfa < TTF_CFA_COUNT; cfa++) {
            struct ttf_frame_format f = {
                .packing = (enum ttf_packing)packing, .cfa = (enum ttf_cfa)cfa, .bits = 8};

            probe_abilities(&ALL, &f, &can);
            assert_null(strstr(can.pixels, "unknown"));
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_camera_with_all_controls_has_their_ranges),
        cmocka_unit_test(a_control_that_is_not_there_is_no_range_of_nothing),
        cmocka_unit_test(a_lens_that_is_held_says_where),
        cmocka_unit_test(each_kind_of_pixels_has_a_word),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
