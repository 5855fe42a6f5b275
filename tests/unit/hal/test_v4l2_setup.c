/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A V4L2 camera before it streams: which device, what format, whose controls. Exposure cannot be tested on a real
 * driver here: the kernel's test driver (vivid, in ./dev rig) has no such control. So it is shown on a made-up one.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "v4l2_fixture.h"

/* ---- which device ---- */

static void a_camera_that_is_not_there_is_named_with_what_there_is(void **state)
{
    struct bench *bench = *state;

    strcpy(bench->config.name, "Other");
    assert_int_equal(bench_configure(bench), -ENODEV);
    assert_says(bench, "there is /dev/video0 'Fake camera' (test-1.2)");
    fake_unplug(&bench->fake);
    assert_int_equal(bench_configure(bench), -ENODEV);
    assert_says(bench, "no video device at all");
}

static void a_camera_is_found_by_name_bus_or_path(void **state)
{
    struct bench *bench = *state;

    strcpy(bench->config.name, "Fake");
    strcpy(bench->config.bus, "test-1");
    assert_int_equal(bench_configure(bench), 0);
    ttf_camera_destroy(bench->camera);
    bench->camera = NULL;
    strcpy(bench->config.device, "/dev/video0");
    assert_int_equal(bench_configure(bench), 0);
    ttf_camera_destroy(bench->camera);
    bench->camera = NULL;
    strcpy(bench->config.bus, "test-2");
    assert_int_equal(bench_configure(bench), -ENODEV);
}

static void a_node_that_does_not_capture_is_no_camera(void **state)
{
    struct bench *bench = *state;

    bench->fake.device_caps = V4L2_CAP_META_CAPTURE | V4L2_CAP_STREAMING;
    assert_int_equal(bench_configure(bench), -ENODEV);
    assert_says(bench, "does not capture into memory");
}

static void a_device_that_may_not_be_opened_says_so(void **state)
{
    struct bench *bench = *state;

    bench->fake.open_failure = -EACCES;
    assert_int_equal(bench_configure(bench), -EACCES);
    assert_says(bench, "Permission denied");
}

static void wrong_configurations_are_refused(void **state)
{
    struct bench *bench = *state;
    const struct ttf_v4l2_config wrong[] = {
        {.buffers = 1},
        {.buffers = 9},
        {.settle_frames = 31},
        {.frame_period_ns = -1},
        {.readout_ns = 61 * TTF_NS_PER_S},
        {.n_controls = TTF_V4L2_CONTROLS_MAX + 1},
        {.flicker = (enum ttf_v4l2_flicker)7},
        {.black_level = 1023},
        {.white_level = 1024},
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(wrong); i++) {
        bench->config = wrong[i];
        assert_int_equal(bench_configure(bench), -EINVAL);
        ttf_camera_destroy(bench->camera);
        bench->camera = NULL;
    }
}

/* ---- format ---- */

static void the_best_uncompressed_format_is_taken_at_its_largest(void **state)
{
    struct bench *bench = *state;
    static const struct fake_format FORMATS[] = {{V4L2_PIX_FMT_MJPEG, V4L2_FMT_FLAG_COMPRESSED},
                                                 {V4L2_PIX_FMT_YUYV, 0},
                                                 {V4L2_PIX_FMT_SGBRG10P, 0},
                                                 {V4L2_PIX_FMT_SGBRG12, 0},
                                                 {V4L2_PIX_FMT_GREY, 0}};

    memcpy(bench->fake.formats, FORMATS, sizeof(FORMATS));
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(bench->format.packing, TTF_PACKING_RAW16);
    assert_int_equal(bench->format.cfa, TTF_CFA_GBRG);
    assert_int_equal(bench->format.bits, 12);
    assert_int_equal(bench->format.white_level, 4095);
    assert_int_equal(bench->fake.asked_width, 64);
    assert_int_equal(bench->fake.asked_height, 48);
}

static void a_wished_format_and_size_are_asked_for(void **state)
{
    struct bench *bench = *state;
    static const struct fake_format FORMATS[] = {{V4L2_PIX_FMT_SRGGB10, 0}, {V4L2_PIX_FMT_Y16, 0}};

    memcpy(bench->fake.formats, FORMATS, sizeof(FORMATS));
    strcpy(bench->config.pixel_format, "Y16");
    bench->config.width = 32;
    bench->config.height = 24;
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(bench->format.packing, TTF_PACKING_GREY16);
    assert_int_equal(bench->fake.asked_width, 32);
    /* The driver has another size: that is the format, and the caller sees it. */
    assert_int_equal(bench->format.width, 64);
}

static void compressed_pixels_are_refused(void **state)
{
    struct bench *bench = *state;

    bench->fake.formats[0] = (struct fake_format){V4L2_PIX_FMT_MJPEG, V4L2_FMT_FLAG_COMPRESSED};
    bench->fake.formats[1] = (struct fake_format){V4L2_PIX_FMT_SRGGB10DPCM8, 0};
    assert_int_equal(bench_configure(bench), -EINVAL);
    assert_says(bench, "MJPG, bRA8; compressed ones are refused");
    strcpy(bench->config.pixel_format, "MJPG");
    ttf_camera_destroy(bench->camera);
    bench->camera = NULL;
    assert_int_equal(bench_configure(bench), -EINVAL);
    assert_says(bench, "MJPG is compressed");
    bench->config.pixel_format[0] = '\0';
    bench->fake.formats[0] = (struct fake_format){V4L2_PIX_FMT_SRGGB10, V4L2_FMT_FLAG_COMPRESSED};
    assert_int_equal(ttf_camera_configure(bench->camera, &(struct ttf_camera_mode){0}, NULL, NULL),
                     -EINVAL);
}

static void another_format_granted_than_asked_is_refused_and_named(void **state)
{
    struct bench *bench = *state;

    bench->fake.granted_fourcc = v4l2_fourcc('P', 'C', '1', 'R');
    assert_int_equal(bench_configure(bench), -EINVAL);
    assert_says(bench, "instead of RG10 the driver grants PC1R, which is compressed");
    bench->fake.granted_fourcc = V4L2_PIX_FMT_SRGGB8;
    assert_int_equal(bench_configure(bench), -EINVAL);
    assert_says(bench, "instead of RG10 the driver grants RGGB");
}

static void half_pictures_and_unknown_colours_are_refused(void **state)
{
    struct bench *bench = *state;

    bench->fake.field = V4L2_FIELD_INTERLACED;
    assert_int_equal(bench_configure(bench), -EINVAL);
    assert_says(bench, "interlaced");
    bench->fake.field = V4L2_FIELD_NONE;
    bench->fake.formats[0].fourcc = V4L2_PIX_FMT_YUYV;
    assert_int_equal(bench_configure(bench), 0);
    bench->fake.ycbcr_enc = V4L2_YCBCR_ENC_709;
    assert_int_equal(bench_configure(bench), -ENOTSUP);
    bench->fake.ycbcr_enc = V4L2_YCBCR_ENC_601;
    bench->fake.quantization = V4L2_QUANTIZATION_FULL_RANGE;
    assert_int_equal(bench_configure(bench), -ENOTSUP);
    bench->fake.formats[0].fourcc = V4L2_PIX_FMT_RGB24;
    assert_int_equal(bench_configure(bench), 0);
    bench->fake.quantization = V4L2_QUANTIZATION_LIM_RANGE;
    assert_int_equal(bench_configure(bench), -ENOTSUP);
}

static void a_range_that_another_program_left_behind_is_put_right(void **state)
{
    struct bench *bench = *state;

    bench->fake.keeps_range = true;
    bench->fake.quantization = V4L2_QUANTIZATION_LIM_RANGE;
    bench->fake.formats[0].fourcc = V4L2_PIX_FMT_RGB24;
    assert_int_equal(bench_configure(bench), 0);
    bench->fake.formats[0].fourcc = V4L2_PIX_FMT_NV12;
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(bench->fake.quantization, V4L2_QUANTIZATION_LIM_RANGE);
}

static void grey_bytes_are_linear_if_the_driver_says_so(void **state)
{
    struct bench *bench = *state;

    bench->fake.formats[0].fourcc = V4L2_PIX_FMT_GREY;
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(bench->format.packing, TTF_PACKING_GREY8);
    bench->fake.colorspace = V4L2_COLORSPACE_RAW;
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(bench->format.packing, TTF_PACKING_RAW8);
}

static void wider_rows_are_the_format(void **state)
{
    struct bench *bench = *state;

    bench->fake.row_padding = 32;
    bench_start(bench);
    assert_int_equal(bench->format.stride, 64 * 2 + 32);
    assert_int_equal(bench_shoot(bench, 10, 1000).bytes, bench->format.stride * 48);
}

static void a_rate_is_asked_for_and_what_is_granted_counts(void **state)
{
    struct bench *bench = *state;

    bench->config.frame_period_ns = 50 * MS;
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(ttf_camera_caps(bench->camera)->frame_period_ns, 50 * MS);
    bench->fake.no_rate = true;
    bench->config.frame_period_ns = 0;
    ttf_camera_destroy(bench->camera);
    bench->camera = NULL;
    assert_int_equal(bench_configure(bench), 0); /* a driver that tells none is taken to be slow */
    assert_true(ttf_camera_caps(bench->camera)->frame_period_ns >= 100 * MS);
}

/* ---- controls ---- */

static void all_that_is_automatic_is_switched_off(void **state)
{
    struct bench *bench = *state;
    struct ttf_v4l2_info info;

    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_EXPOSURE_AUTO)->value,
                     V4L2_EXPOSURE_MANUAL);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_AUTOGAIN)->value, 0);
    assert_int_equal(bench->fake.priority, V4L2_PRIORITY_RECORD);
    ttf_v4l2_camera_info(bench->camera, &info);
    assert_int_equal(info.automatics_off, 2);
    assert_int_equal(info.mapped, TTF_V4L2_EXPOSURE | TTF_V4L2_GAIN);
    assert_string_equal(info.pixel_format, "RG10");
}

static void a_compensation_without_off_is_set_to_its_least(void **state)
{
    struct bench *bench = *state;

    bench->fake.controls[10] = (struct fake_control){
        V4L2_CID_BACKLIGHT_COMPENSATION, V4L2_CTRL_TYPE_INTEGER, "Backlight", 1, 8, 1, 4, 4, false};
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(bench->fake.controls[10].value, 1);
}

static void a_camera_that_keeps_its_rate_exposes_no_longer_than_a_frame(void **state)
{
    struct bench *bench = *state;

    assert_int_equal(bench_configure(bench), 0);
    assert_true(ttf_camera_caps(bench->camera)->exposure_max_ns == 500 * MS);
    bench->fake.controls[10] = (struct fake_control){V4L2_CID_EXPOSURE_AUTO_PRIORITY,
                                                     V4L2_CTRL_TYPE_BOOLEAN,
                                                     "Exposure, Dynamic Framerate",
                                                     0,
                                                     1,
                                                     1,
                                                     1,
                                                     1,
                                                     false};
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(bench->fake.controls[10].value, 0);
    assert_true(ttf_camera_caps(bench->camera)->exposure_max_ns == bench->fake.period_ns);
}

static void an_automatic_that_stays_on_is_refused(void **state)
{
    struct bench *bench = *state;

    fake_control(&bench->fake, V4L2_CID_AUTOGAIN)->stuck = true;
    assert_int_equal(bench_configure(bench), -EIO);
    assert_says(bench, "Gain, Automatic");
    fake_control(&bench->fake, V4L2_CID_EXPOSURE_AUTO)->stuck = true;
    fake_control(&bench->fake, V4L2_CID_EXPOSURE_AUTO)->value = V4L2_EXPOSURE_AUTO;
    assert_int_equal(bench_configure(bench), -ENOTSUP);
    assert_says(bench, "cannot be locked");
}

static void what_has_no_unit_is_fixed_and_no_capability(void **state)
{
    struct bench *bench = *state;
    const struct ttf_camera_caps *caps;

    bench->config.gain_unity = 0;
    bench_start(bench);
    caps = ttf_camera_caps(bench->camera);
    assert_int_equal(caps->gain_max_milli, 0);
    assert_false(caps->has_white_balance || caps->has_lens);
    assert_int_equal(bench_shoot(bench, 10, 2000).settings.gain_milli, 0);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_GAIN)->value, 0);
}

static void a_camera_without_exposure_control_says_so(void **state)
{
    struct bench *bench = *state;
    struct ttf_frame frame;

    fake_control_remove(&bench->fake, V4L2_CID_EXPOSURE_AUTO);
    fake_control_remove(&bench->fake, V4L2_CID_EXPOSURE_ABSOLUTE);
    bench_start(bench);
    assert_true(ttf_camera_caps(bench->camera)->exposure_max_ns == 0);
    frame = bench_shoot(bench, 10, 1000);
    assert_true(frame.settings.exposure_ns == 0);
    assert_int_equal(frame.settings.gain_milli, 1000);
    /* What was read back can be asked for. */
    assert_true(bench_shoot(bench, 0, 1000).settings.exposure_ns == 0);
}

static void a_sensor_that_exposes_in_lines_is_told_in_lines(void **state)
{
    struct bench *bench = *state;
    const struct fake_control lines[] = {
        {V4L2_CID_EXPOSURE, V4L2_CTRL_TYPE_INTEGER, "Exposure", 4, 3000, 1, 100, 100, false},
        {V4L2_CID_PIXEL_RATE, V4L2_CTRL_TYPE_INTEGER64, "Pixel Rate", 0, 1LL << 40, 1, 0, 10000000,
         false},
        {V4L2_CID_HBLANK, V4L2_CTRL_TYPE_INTEGER, "Horizontal Blanking", 0, 1000, 1, 36, 36, false},
    };

    fake_control_remove(&bench->fake, V4L2_CID_EXPOSURE_ABSOLUTE);
    memcpy(&bench->fake.controls[10], lines, sizeof(lines));
    bench_start(bench);
    /* 64 + 36 pixels at 10 MHz: 10 us a line. */
    assert_true(ttf_camera_caps(bench->camera)->exposure_min_ns == 40000);
    assert_true(bench_shoot(bench, 5, 1000).settings.exposure_ns == 5 * MS);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_EXPOSURE)->value, 500);
    ttf_camera_destroy(bench->camera);
    bench->camera = NULL;
    fake_control_remove(&bench->fake, V4L2_CID_PIXEL_RATE);
    assert_int_equal(bench_configure(bench), 0); /* in units that nobody tells: no control */
    assert_true(ttf_camera_caps(bench->camera)->exposure_max_ns == 0);
}

static void balance_and_focus_with_units_are_capabilities(void **state)
{
    struct bench *bench = *state;
    const struct fake_control more[] = {
        {V4L2_CID_RED_BALANCE, V4L2_CTRL_TYPE_INTEGER, "Red Balance", 0, 1023, 1, 256, 256, false},
        {V4L2_CID_BLUE_BALANCE, V4L2_CTRL_TYPE_INTEGER, "Blue Balance", 0, 1023, 1, 256, 256,
         false},
        {V4L2_CID_FOCUS_ABSOLUTE, V4L2_CTRL_TYPE_INTEGER, "Focus, Absolute", 0, 250, 5, 0, 0,
         false},
    };
    struct ttf_exposure asked = {10 * MS, 1000, 1500, 2000, 4000};
    struct ttf_camera_set set = {.settings = &asked, .n = 1};
    struct ttf_frame *frame = NULL;

    memcpy(&bench->fake.controls[10], more, sizeof(more));
    bench->config.balance_unity = 256;
    bench->config.focus_per_dioptre = 25;
    bench_start(bench);
    assert_true(ttf_camera_caps(bench->camera)->has_lens);
    assert_true(ttf_camera_caps(bench->camera)->has_white_balance);
    assert_int_equal(ttf_camera_submit(bench->camera, &set, NULL), 0);
    assert_int_equal(bench_next(bench, &frame), 0);
    if (!frame)
        abort();
    assert_memory_equal(&frame->settings, &asked, sizeof(asked));
    ttf_camera_release(bench->camera, frame);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_RED_BALANCE)->value, 384);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_FOCUS_ABSOLUTE)->value, 100);
}

static void flicker_and_temperature_are_fixed(void **state)
{
    struct bench *bench = *state;
    const struct fake_control more[] = {
        {V4L2_CID_POWER_LINE_FREQUENCY, V4L2_CTRL_TYPE_MENU, "Power Line Frequency", 0, 2, 1, 1, 1,
         false},
        {V4L2_CID_WHITE_BALANCE_TEMPERATURE, V4L2_CTRL_TYPE_INTEGER, "White Balance Temperature",
         2800, 6500, 1, 4600, 3000, false},
    };

    bench->config.flicker = TTF_V4L2_FLICKER_50HZ;
    assert_int_equal(bench_configure(bench), -EINVAL); /* there is none to be set */
    memcpy(&bench->fake.controls[10], more, sizeof(more));
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(bench->fake.controls[10].value, V4L2_CID_POWER_LINE_FREQUENCY_50HZ);
    assert_int_equal(bench->fake.controls[11].value, 4600);
    ttf_camera_destroy(bench->camera);
    bench->camera = NULL;
    bench->config.flicker = TTF_V4L2_FLICKER_OFF;
    bench->config.white_balance_kelvin = 5000;
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(bench->fake.controls[10].value, V4L2_CID_POWER_LINE_FREQUENCY_DISABLED);
    assert_int_equal(bench->fake.controls[11].value, 5000);
}

static void anti_flicker_that_cannot_be_off_is_refused_with_what_to_write(void **state)
{
    struct bench *bench = *state;
    const struct fake_control mains = {V4L2_CID_POWER_LINE_FREQUENCY,
                                       V4L2_CTRL_TYPE_MENU,
                                       "Power Line Frequency",
                                       1,
                                       2,
                                       1,
                                       2,
                                       2,
                                       false};

    bench->fake.controls[10] = mains;
    assert_true(bench_configure(bench) < 0);
    assert_says(bench, "Power Line Frequency: the camera does not take 0 here");
    assert_says(bench, "flicker: 50Hz");
    bench->config.flicker = TTF_V4L2_FLICKER_50HZ;
    ttf_camera_destroy(bench->camera);
    bench->camera = NULL;
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(bench->fake.controls[10].value, V4L2_CID_POWER_LINE_FREQUENCY_50HZ);
}

static void a_board_fixes_controls_by_the_drivers_names(void **state)
{
    struct bench *bench = *state;

    bench->config.n_controls = 1;
    bench->config.controls[0] = (struct ttf_v4l2_control){"sharpness", 0};
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(fake_control(&bench->fake, V4L2_CID_SHARPNESS)->value, 0);
    ttf_camera_destroy(bench->camera);
    bench->camera = NULL;
    bench->config.controls[0].value = 99;
    assert_int_equal(bench_configure(bench), -EINVAL);
    assert_says(bench, "takes 7 here, not 99");
    ttf_camera_destroy(bench->camera);
    bench->camera = NULL;
    bench->config.controls[0] = (struct ttf_v4l2_control){"gain_automatic", 0};
    assert_int_equal(bench_configure(bench), 0);
    ttf_camera_destroy(bench->camera);
    bench->camera = NULL;
    bench->config.controls[0] = (struct ttf_v4l2_control){"sharp", 0};
    assert_int_equal(bench_configure(bench), -EINVAL);
    assert_says(bench, "no such control");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_BENCH(a_camera_that_is_not_there_is_named_with_what_there_is),
        ON_BENCH(a_camera_is_found_by_name_bus_or_path),
        ON_BENCH(a_node_that_does_not_capture_is_no_camera),
        ON_BENCH(a_device_that_may_not_be_opened_says_so),
        ON_BENCH(wrong_configurations_are_refused),
        ON_BENCH(the_best_uncompressed_format_is_taken_at_its_largest),
        ON_BENCH(a_wished_format_and_size_are_asked_for),
        ON_BENCH(compressed_pixels_are_refused),
        ON_BENCH(another_format_granted_than_asked_is_refused_and_named),
        ON_BENCH(half_pictures_and_unknown_colours_are_refused),
        ON_BENCH(a_range_that_another_program_left_behind_is_put_right),
        ON_BENCH(grey_bytes_are_linear_if_the_driver_says_so),
        ON_BENCH(wider_rows_are_the_format),
        ON_BENCH(a_rate_is_asked_for_and_what_is_granted_counts),
        ON_BENCH(all_that_is_automatic_is_switched_off),
        ON_BENCH(a_compensation_without_off_is_set_to_its_least),
        ON_BENCH(a_camera_that_keeps_its_rate_exposes_no_longer_than_a_frame),
        ON_BENCH(an_automatic_that_stays_on_is_refused),
        ON_BENCH(what_has_no_unit_is_fixed_and_no_capability),
        ON_BENCH(a_camera_without_exposure_control_says_so),
        ON_BENCH(a_sensor_that_exposes_in_lines_is_told_in_lines),
        ON_BENCH(balance_and_focus_with_units_are_capabilities),
        ON_BENCH(flicker_and_temperature_are_fixed),
        ON_BENCH(anti_flicker_that_cannot_be_off_is_refused_with_what_to_write),
        ON_BENCH(a_board_fixes_controls_by_the_drivers_names),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
