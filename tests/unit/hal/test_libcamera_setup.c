/* SPDX-License-Identifier: Apache-2.0 */
/* What a camera behind libcamera is found, granted and refused for; what is switched off in it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <string.h>

#include "libcamera_fixture.h"
#include "pixels.h"

#define CODE(a, b, c, d) \
    ((uint32_t)(a) | (uint32_t)(b) << 8 | (uint32_t)(c) << 16 | (uint32_t)(d) << 24)
#define PISP_COMPRESSED (UINT64_C(0x0c) << 56 | 1)

static double carried(const struct rig *rig, enum lc_control control)
{
    assert_true(rig->fake.last.set >> control & 1);
    return rig->fake.last.value[control][0];
}

static void no_camera_is_said_with_what_libcamera_complained_of(void **state)
{
    struct rig *rig = *state;

    rig->fake.id = NULL;
    assert_int_equal(rig_configure(rig), -ENODEV);
    assert_says(rig, "finds no camera: no sensor answers");
}

static void another_camera_than_the_one_meant_is_named(void **state)
{
    struct rig *rig = *state;

    memcpy(rig->config.name, "imx477", 7);
    assert_int_equal(rig_configure(rig), -ENODEV);
    assert_says(rig, "no camera 'imx477'");
    assert_says(rig, "'imx000' (/base/soc/i2c0mux/i2c@1/imx000@1a)");
    memcpy(rig->config.name, "imx0", 5);
    assert_int_equal(rig_configure(rig), 0);
}

static void a_camera_in_other_hands_is_busy(void **state)
{
    struct rig *rig = *state;

    rig->fake.hold_failure = -EBUSY;
    assert_int_equal(rig_configure(rig), -EBUSY);
    assert_says(rig, "another program has the camera");
}

static void raw_of_most_bits_a_word_a_sample_is_preferred(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(rig_configure(rig), 0);
    assert_int_equal(rig->format.packing, TTF_PACKING_RAW16);
    assert_int_equal(rig->format.cfa, TTF_CFA_RGGB);
    assert_int_equal(rig->format.bits, 12);
    assert_int_equal(rig->format.white_level, 4095);
    assert_int_equal(rig->fake.asked.colour, LC_COLOUR_RAW);
}

static void a_format_can_be_named_packed_too(void **state)
{
    struct rig *rig = *state;

    memcpy(rig->config.pixel_format, "RG10P", 6);
    assert_int_equal(rig_configure(rig), 0);
    assert_int_equal(rig->format.packing, TTF_PACKING_RAW10P);
}

static void a_processed_stream_is_rgb_of_full_range(void **state)
{
    struct rig *rig = *state;

    rig->config.stream = TTF_LIBCAMERA_PROCESSED;
    assert_int_equal(rig_configure(rig), 0);
    assert_int_equal(rig->format.packing, TTF_PACKING_RGB8);
    assert_int_equal(rig->fake.asked.colour, LC_COLOUR_RGB_FULL);
    assert_true(ttf_camera_caps(rig->camera)->has_white_balance);
}

static void a_camera_without_raw_gives_processed_unless_raw_is_demanded(void **state)
{
    struct rig *rig = *state;

    rig->fake.raw[0] = (struct lc_offer){CODE('B', 'G', '2', '4'), 0, 64, 48};
    rig->fake.raw[1].fourcc = 0;
    assert_int_equal(rig_configure(rig), 0);
    assert_int_equal(rig->format.packing, TTF_PACKING_RGB8);
    ttf_camera_destroy(rig->camera);
    rig->camera = NULL;
    rig->config.stream = TTF_LIBCAMERA_RAW;
    assert_int_equal(rig_configure(rig), -EINVAL);
    assert_says(rig, "gives no raw");
    assert_says(rig, "BG24");
}

static void compressed_raw_in_place_of_raw_is_refused(void **state)
{
    struct rig *rig = *state;

    rig->fake.granted_fourcc = CODE('R', 'G', 'B', '6');
    rig->fake.granted_modifier = PISP_COMPRESSED;
    assert_int_equal(rig_configure(rig), -EINVAL);
    assert_says(rig, "instead of RG12");
    assert_says(rig, "which is compressed");
}

static void only_compressed_formats_are_refused_with_the_reason(void **state)
{
    struct rig *rig = *state;

    rig->config.stream = TTF_LIBCAMERA_PROCESSED;
    rig->fake.processed[0].fourcc = CODE('M', 'J', 'P', 'G');
    rig->fake.processed[1].fourcc = 0;
    assert_int_equal(rig_configure(rig), -EINVAL);
    assert_says(rig, "MJPG");
    assert_says(rig, "cannot be calibrated");
}

static void colours_that_developing_does_not_know_are_refused(void **state)
{
    struct rig *rig = *state;

    rig->config.stream = TTF_LIBCAMERA_PROCESSED;
    rig->fake.colour = LC_COLOUR_OTHER;
    assert_int_equal(rig_configure(rig), -ENOTSUP);
    assert_says(rig, "coded as some other");
}

static void too_few_buffers_are_refused(void **state)
{
    struct rig *rig = *state;

    rig->fake.buffers_max = 2;
    assert_int_equal(rig_configure(rig), -ENOMEM);
    assert_says(rig, "gives 2 buffers, and 3 are needed");
}

static void levels_beyond_the_samples_bits_are_refused(void **state)
{
    struct rig *rig = *state;

    rig->config.white_level = 4096;
    assert_int_equal(rig_configure(rig), -EINVAL);
    assert_says(rig, "do not fit samples of 12 bits");
}

static void everything_automatic_is_off_in_each_request(void **state)
{
    static const enum lc_control off[] = {LC_AUTO_EXPOSURE, LC_AUTO_BALANCE, LC_AUTO_FOCUS,
                                          LC_NOISE_REDUCTION, LC_SHARPNESS};
    struct ttf_exposure asked = of_us(5000, 2000);
    struct ttf_libcamera_info info;
    struct rig *rig = *state;

    rig_start(rig);
    (void)rig_shoot(rig, &asked, 0);
    for (unsigned i = 0; i < TTF_COUNT_OF(off); i++)
        assert_true(carried(rig, off[i]) == 0);
    assert_true(carried(rig, LC_CONTRAST) == 1);
    ttf_libcamera_camera_info(rig->camera, &info);
    assert_int_equal(info.automatics_off, 4);
    assert_string_equal(info.pixel_format, "RG12");
    assert_true(info.raw);
}

static void raw_pixels_have_no_white_balance_but_the_gains_are_fixed_at_one(void **state)
{
    struct ttf_exposure asked = of_us(5000, 2000);
    struct rig *rig = *state;

    asked.wb_r_milli = 2500;
    rig_start(rig);
    assert_false(ttf_camera_caps(rig->camera)->has_white_balance);
    assert_int_equal(rig_shoot(rig, &asked, 0).settings.wb_r_milli, 0);
    assert_true(carried(rig, LC_COLOUR_GAINS) == 1);
}

static void an_exposure_that_wanders_is_refused_as_automatic(void **state)
{
    struct rig *rig = *state;

    rig->fake.automatic = true;
    assert_int_equal(rig_configure(rig), -ENOTSUP);
    assert_says(rig, "its exposure stays automatic");
}

static void an_automatic_that_cannot_be_switched_off_is_refused_by_its_name(void **state)
{
    static const struct {
        enum lc_control control;
        const char *words;
    } automatics[] = {{LC_AUTO_EXPOSURE, "automatic exposure cannot be switched off"},
                      {LC_AUTO_BALANCE, "automatic white balance cannot be switched off"},
                      {LC_AUTO_FOCUS, "automatic focus cannot be switched off"},
                      {LC_NOISE_REDUCTION, "noise reduction cannot be switched off"}};
    struct rig *rig = *state;

    for (unsigned i = 0; i < TTF_COUNT_OF(automatics); i++) {
        rig->fake.limits.min[automatics[i].control] = 1;
        assert_int_equal(rig_configure(rig), -ENOTSUP);
        assert_says(rig, automatics[i].words);
        rig->fake.limits.min[automatics[i].control] = 0;
    }
    assert_int_equal(rig_configure(rig), 0);
}

static void an_exposure_that_cannot_be_asked_for_is_refused_if_it_is_automatic(void **state)
{
    struct rig *rig = *state;

    fake_libcamera_take_away(&rig->fake, LC_EXPOSURE);
    assert_int_equal(rig_configure(rig), -ENOTSUP);
    assert_says(rig, "exposes by itself");
}

static void an_exposure_that_is_not_told_is_refused(void **state)
{
    struct rig *rig = *state;

    rig->fake.untold = 1u << LC_EXPOSURE;
    assert_int_equal(rig_configure(rig), -ENOTSUP);
    assert_says(rig, "does not tell what it made of it");
    assert_says(rig, "v4l2");
}

static void a_gain_that_is_not_told_is_none_and_stays_at_its_least(void **state)
{
    struct ttf_exposure asked = of_us(5000, 4000);
    struct rig *rig = *state;

    rig->fake.untold = 1u << LC_GAIN;
    rig_start(rig);
    assert_int_equal(ttf_camera_caps(rig->camera)->gain_max_milli, 0);
    assert_int_equal(rig_shoot(rig, &asked, 0).settings.gain_milli, 0);
    assert_true(carried(rig, LC_GAIN) == 1);
}

static void a_lens_that_is_not_told_is_recorded_as_it_was_asked(void **state)
{
    struct ttf_exposure asked = of_us(5000, 1000);
    struct rig *rig = *state;

    rig->fake.untold = 1u << LC_LENS;
    asked.lens_mdpt = 3250;
    rig_start(rig);
    assert_true(ttf_camera_caps(rig->camera)->has_lens);
    assert_int_equal(rig_shoot(rig, &asked, 0).settings.lens_mdpt, 3250);
    assert_true(carried(rig, LC_LENS) == 3.25 && carried(rig, LC_AUTO_FOCUS) == 0);
}

static void
a_digital_gain_of_processed_pixels_is_refused_and_of_raw_ones_does_not_matter(void **state)
{
    struct rig *rig = *state;

    rig->fake.digital_gain = 1.04;
    assert_int_equal(rig_configure(rig), 0);
    ttf_camera_destroy(rig->camera);
    rig->camera = NULL;
    rig->config.stream = TTF_LIBCAMERA_PROCESSED;
    assert_int_equal(rig_configure(rig), -ENOTSUP);
    assert_says(rig, "digital gain of 1.040");
}

static void a_period_that_nobody_tells_is_measured(void **state)
{
    struct rig *rig = *state;

    fake_libcamera_take_away(&rig->fake, LC_FRAME_DURATION);
    rig->fake.least_ns = 37 * MS;
    assert_int_equal(rig_configure(rig), 0);
    assert_int_equal(ttf_camera_caps(rig->camera)->frame_period_ns, 37 * MS);
    assert_false(ttf_camera_caps(rig->camera)->steerable);
}

static void steerable_is_what_follows_and_not_what_is_listed(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(rig_configure(rig), 0);
    assert_true(ttf_camera_caps(rig->camera)->steerable);
    assert_int_equal(ttf_camera_caps(rig->camera)->frame_period_ns, 20 * MS);
    ttf_camera_destroy(rig->camera);
    rig->camera = NULL;
    rig->fake.deaf_durations = true;
    assert_int_equal(rig_configure(rig), 0);
    assert_false(ttf_camera_caps(rig->camera)->steerable);
}

static void a_camera_without_frames_is_refused_within_ten_seconds(void **state)
{
    struct rig *rig = *state;
    int64_t before = ttf_clock_now_ns(rig->clock);

    rig->fake.silent = true;
    assert_int_equal(rig_configure(rig), -EIO);
    assert_says(rig, "gives no frames");
    assert_true(ttf_clock_now_ns(rig->clock) - before <= 10 * TTF_NS_PER_S);
}

static void a_camera_of_one_frame_a_second_has_the_time_for_its_trial(void **state)
{
    struct rig *rig = *state;

    rig->config.frame_period_ns = TTF_NS_PER_S;
    if (rig_configure(rig) < 0)
        fail_msg("%s", rig->err.what);
    assert_int_equal(ttf_camera_caps(rig->camera)->frame_period_ns, TTF_NS_PER_S);
    assert_true(ttf_camera_caps(rig->camera)->steerable);
}

static void a_libcamera_that_does_not_start_or_configure_is_said(void **state)
{
    struct rig *rig = *state;

    rig->fake.begin_failure = -EIO;
    assert_int_equal(rig_configure(rig), -EIO);
    assert_says(rig, "libcamera does not start");
    rig->fake.begin_failure = 0;
    rig->fake.configure_failure = -EINVAL;
    assert_int_equal(rig_configure(rig), -EINVAL);
    rig->fake.configure_failure = 0;
    rig->fake.start_failure = -ENOMEM;
    assert_int_equal(rig_configure(rig), -ENOMEM);
    assert_says(rig, "the stream does not start");
}

static void a_wrong_configuration_is_refused_before_anything_is_touched(void **state)
{
    struct rig *rig = *state;

    rig->config.buffers = 9;
    assert_int_equal(rig_configure(rig), -EINVAL);
    rig->config.buffers = 0;
    rig->config.delay_frames = 9;
    assert_int_equal(rig_configure(rig), -EINVAL);
    rig->config.delay_frames = 0;
    rig->config.frame_period_ns = -1;
    assert_int_equal(rig_configure(rig), -EINVAL);
    assert_int_equal(rig->fake.begun, 0);
}

static void a_module_that_is_not_there_is_said_with_what_to_do(void **state)
{
    struct rig *rig = *state;
    const struct ttf_libcamera_config config = {.module = "/nonexistent/ttfbox-libcamera.so"};

    assert_int_equal(ttf_libcamera_camera_create(&config, rig->clock, &rig->camera, &rig->err),
                     -ENOTSUP);
    assert_says(rig, "the module for libcamera cannot be loaded");
    assert_says(rig, "reinstall");
}

#ifdef TTF_TEST_MODULE
static void the_module_is_found_where_it_is_built_and_speaks_to_libcamera(void **state)
{
    struct rig *rig = *state;
    const struct ttf_libcamera_config nobody = {.name = "no such camera"};

    assert_int_equal(ttf_libcamera_camera_create(&nobody, rig->clock, &rig->camera, &rig->err),
                     -ENODEV);
    assert_says(rig, "finds no camera");
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_RIG(no_camera_is_said_with_what_libcamera_complained_of),
        ON_RIG(another_camera_than_the_one_meant_is_named),
        ON_RIG(a_camera_in_other_hands_is_busy),
        ON_RIG(raw_of_most_bits_a_word_a_sample_is_preferred),
        ON_RIG(a_format_can_be_named_packed_too),
        ON_RIG(a_processed_stream_is_rgb_of_full_range),
        ON_RIG(a_camera_without_raw_gives_processed_unless_raw_is_demanded),
        ON_RIG(compressed_raw_in_place_of_raw_is_refused),
        ON_RIG(only_compressed_formats_are_refused_with_the_reason),
        ON_RIG(colours_that_developing_does_not_know_are_refused),
        ON_RIG(too_few_buffers_are_refused),
        ON_RIG(levels_beyond_the_samples_bits_are_refused),
        ON_RIG(everything_automatic_is_off_in_each_request),
        ON_RIG(raw_pixels_have_no_white_balance_but_the_gains_are_fixed_at_one),
        ON_RIG(an_exposure_that_wanders_is_refused_as_automatic),
        ON_RIG(an_automatic_that_cannot_be_switched_off_is_refused_by_its_name),
        ON_RIG(an_exposure_that_cannot_be_asked_for_is_refused_if_it_is_automatic),
        ON_RIG(an_exposure_that_is_not_told_is_refused),
        ON_RIG(a_gain_that_is_not_told_is_none_and_stays_at_its_least),
        ON_RIG(a_lens_that_is_not_told_is_recorded_as_it_was_asked),
        ON_RIG(a_digital_gain_of_processed_pixels_is_refused_and_of_raw_ones_does_not_matter),
        ON_RIG(a_period_that_nobody_tells_is_measured),
        ON_RIG(steerable_is_what_follows_and_not_what_is_listed),
        ON_RIG(a_camera_without_frames_is_refused_within_ten_seconds),
        ON_RIG(a_camera_of_one_frame_a_second_has_the_time_for_its_trial),
        ON_RIG(a_libcamera_that_does_not_start_or_configure_is_said),
        ON_RIG(a_wrong_configuration_is_refused_before_anything_is_touched),
        ON_RIG(a_module_that_is_not_there_is_said_with_what_to_do),
#ifdef TTF_TEST_MODULE
        ON_RIG(the_module_is_found_where_it_is_built_and_speaks_to_libcamera),
#endif
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
