/* SPDX-License-Identifier: Apache-2.0 */
/* Raw streams of Raspberry Pis: what they list is not what they grant. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>

#include "libcamera_fixture.h"
#include "pixels.h"

static int configure(struct rig *rig, enum fake_pipeline pipeline, const char *format)
{
    fake_libcamera_be_pi(&rig->fake, pipeline);
    (void)snprintf(rig->config.pixel_format, sizeof(rig->config.pixel_format), "%s", format);
    return rig_configure(rig);
}

static void must(struct rig *rig, enum fake_pipeline pipeline, const char *format)
{
    if (configure(rig, pipeline, format) < 0)
        fail_msg("'%s': %s", format, rig->err.what);
}

static void looks_like(const struct rig *rig, enum ttf_packing packing, unsigned bits,
                       unsigned white, const char *name)
{
    struct ttf_libcamera_info info;

    assert_int_equal(rig->format.packing, packing);
    assert_int_equal(rig->format.cfa, TTF_CFA_BGGR); /* RGGB, turned by 180 degrees */
    assert_int_equal(rig->format.bits, bits);
    assert_int_equal(rig->format.white_level, white);
    ttf_libcamera_camera_info(rig->camera, &info);
    assert_string_equal(info.pixel_format, name);
}

static void a_turned_sensor_s_mosaic_is_the_one_that_was_granted(void **state)
{
    struct rig *rig = *state;

    must(rig, FAKE_VC4, "");
    looks_like(rig, TTF_PACKING_RAW12P, 12, 4095, "BG12P");
    assert_int_equal(rig->fake.configured, 1);
}

static void a_sensor_that_is_not_turned_keeps_its_mosaic(void **state)
{
    struct rig *rig = *state;

    fake_libcamera_be_pi(&rig->fake, FAKE_VC4);
    rig->fake.turned = false;
    assert_int_equal(rig_configure(rig), 0);
    assert_int_equal(rig->format.cfa, TTF_CFA_RGGB);
}

static void compressed_raw_is_not_taken_where_plain_words_are_to_be_had(void **state)
{
    struct rig *rig = *state;

    must(rig, FAKE_PISP, "");
    looks_like(rig, TTF_PACKING_RAW16, 16, 4095 << 4, "BYR2");
    assert_int_equal(rig->fake.asked.modifier, 0);
}

static void the_same_without_a_word_about_the_stream(void **state)
{
    struct rig *rig = *state;

    rig->config.stream = TTF_LIBCAMERA_ANY;
    must(rig, FAKE_PISP, "");
    looks_like(rig, TTF_PACKING_RAW16, 16, 65520, "BYR2");
}

/* Each order of the mosaic is the same format: which one comes is the sensor's affair. */
static void a_format_that_is_not_listed_can_be_named(void **state)
{
    static const struct {
        enum fake_pipeline pipeline;
        const char *asked;
        enum ttf_packing packing;
        unsigned bits, white;
        const char *granted;
    } named[] = {
        {FAKE_VC4, "RG12", TTF_PACKING_RAW16, 12, 4095, "BG12"},
        {FAKE_VC4, "BG12", TTF_PACKING_RAW16, 12, 4095, "BG12"},
        {FAKE_VC4, "RG12P", TTF_PACKING_RAW12P, 12, 4095, "BG12P"},
        {FAKE_VC4, "BG10P", TTF_PACKING_RAW10P, 10, 1023, "BG10P"},
        {FAKE_PISP, "RGB6", TTF_PACKING_RAW16, 16, 65520, "BYR2"},
        {FAKE_PISP, "BYR2", TTF_PACKING_RAW16, 16, 65520, "BYR2"},
    };
    struct rig *rig = *state;

    for (unsigned i = 0; i < TTF_COUNT_OF(named); i++) {
        must(rig, named[i].pipeline, named[i].asked);
        looks_like(rig, named[i].packing, named[i].bits, named[i].white, named[i].granted);
        ttf_camera_destroy(rig->camera);
        rig->camera = NULL;
    }
}

/* Levels are of the format that was named: another depth is another camera. */
static void a_named_format_is_taken_at_its_word(void **state)
{
    struct rig *rig = *state;

    assert_int_equal(configure(rig, FAKE_PISP, "RG12"), -EINVAL);
    assert_says(rig, "instead of RG12 libcamera grants BYR2");
    assert_says(rig, "format: BYR2");
    ttf_camera_destroy(rig->camera);
    rig->camera = NULL;
    assert_int_equal(configure(rig, FAKE_PISP, "RG12P"), -EINVAL);
    assert_says(rig, "which is compressed");
    assert_says(rig, "leave out 'format'");
}

static void saturation_of_a_small_mode_is_that_of_its_fewer_bits(void **state)
{
    struct rig *rig = *state;

    rig->config.width = rig->fake.width = 32;
    rig->config.height = rig->fake.height = 24;
    must(rig, FAKE_PISP, "");
    looks_like(rig, TTF_PACKING_RAW16, 16, 1023 << 6, "BYR2");
}

/* Which of the sensor's modes such frames are of is not told: the least that can saturate it. */
static void saturation_of_an_unknown_mode_is_the_lowest_there_may_be(void **state)
{
    struct rig *rig = *state;

    rig->config.width = rig->fake.width = 48;
    rig->config.height = rig->fake.height = 32;
    must(rig, FAKE_PISP, "");
    looks_like(rig, TTF_PACKING_RAW16, 16, 1023 << 6, "BYR2");
}

static void a_board_s_own_white_level_stands(void **state)
{
    struct rig *rig = *state;

    rig->config.black_level = 4096;
    rig->config.white_level = 60000;
    must(rig, FAKE_PISP, "");
    assert_int_equal(rig->format.white_level, 60000);
    assert_int_equal(rig->format.black_level, 4096);
}

static void a_camera_that_comes_back_turned_is_another(void **state)
{
    struct rig *rig = *state;

    must(rig, FAKE_VC4, "");
    assert_int_equal(ttf_camera_start(rig->camera, &rig->err), 0);
    rig->fake.turned = false;
    assert_int_equal(ttf_camera_recover(rig->camera, TTF_CAMERA_REOPEN, &rig->err), -EIO);
    assert_says(rig, "came back with another format");
    rig->fake.turned = true;
    assert_int_equal(ttf_camera_recover(rig->camera, TTF_CAMERA_REOPEN, &rig->err), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        ON_RIG(a_turned_sensor_s_mosaic_is_the_one_that_was_granted),
        ON_RIG(a_sensor_that_is_not_turned_keeps_its_mosaic),
        ON_RIG(compressed_raw_is_not_taken_where_plain_words_are_to_be_had),
        ON_RIG(the_same_without_a_word_about_the_stream),
        ON_RIG(a_format_that_is_not_listed_can_be_named),
        ON_RIG(a_named_format_is_taken_at_its_word),
        ON_RIG(saturation_of_a_small_mode_is_that_of_its_fewer_bits),
        ON_RIG(saturation_of_an_unknown_mode_is_the_lowest_there_may_be),
        ON_RIG(a_board_s_own_white_level_stands),
        ON_RIG(a_camera_that_comes_back_turned_is_another),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
