/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include <string.h>

#include "frame_check.h"
#include "image_flags.h"

static const struct ttf_exposure locked = {20000000, 1000, 1000, 1000, 0};
static const uint16_t pixels[4];

static struct ttf_frame good_frame(void)
{
    struct ttf_frame f = {
        .format = {.width = 2,
                   .height = 2,
                   .stride = 4,
                   .packing = TTF_PACKING_RAW16,
                   .cfa = TTF_CFA_RGGB,
                   .bits = 12,
                   .black_level = 64,
                   .white_level = 4095},
        .data = pixels,
        .bytes = sizeof(pixels),
        .settings = locked,
    };

    return f;
}

static void a_frame_as_ordered_is_taken(void **state)
{
    struct ttf_frame f = good_frame();

    (void)state;
    assert_null(ttf_frame_refused(&f, &f.format, &locked));
}

static void any_field_of_the_settings_counts(void **state)
{
    struct ttf_frame want = good_frame();
    struct ttf_frame f = want;

    (void)state;
    f.settings.exposure_ns += 1;
    assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "wrong settings");
    f = want;
    f.settings.gain_milli += 1;
    assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "wrong settings");
    f = want;
    f.settings.lens_mdpt += 1;
    assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "wrong settings");
}

static void bad_data_are_worse_than_bad_settings(void **state)
{
    struct ttf_frame want = good_frame();
    struct ttf_frame f = want;

    (void)state;
    f.settings.exposure_ns = 1;
    f.bytes--;
    assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "short");
    f.flags = TTF_FRAME_ERROR;
    assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "corrupt");
    f = want;
    f.format.width = 4;
    assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "wrong format");
}

static void any_field_of_the_format_counts(void **state)
{
    struct ttf_frame want = good_frame();

    (void)state;
    for (int field = 0; field < 6; field++) {
        struct ttf_frame f = want;

        f.format.height += field == 0;
        f.format.packing = field == 1 ? TTF_PACKING_RAW16 + 1 : f.format.packing;
        f.format.cfa = field == 2 ? TTF_CFA_NONE : f.format.cfa;
        f.format.bits += field == 3;
        f.format.black_level += field == 4;
        f.format.white_level -= field == 5;
        assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "wrong format");
    }
}

static void a_frame_whose_bytes_are_not_all_there_is_short_whoever_says_so(void **state)
{
    struct ttf_frame want = good_frame();
    struct ttf_frame f = want;

    (void)state;
    f.flags = TTF_FRAME_SHORT;
    assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "short");
    f = want;
    f.data = NULL;
    assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "short");
    f = want;
    f.settings.wb_b_milli++;
    assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "wrong settings");
    f.settings = want.settings;
    f.settings.wb_r_milli++;
    assert_string_equal(ttf_frame_refused(&f, &want.format, &locked), "wrong settings");
}

static void flags_are_words_said_once(void **state)
{
    struct ttf_image image = {0};

    (void)state;
    ttf_image_flag(&image, "late");
    ttf_image_flag(&image, "lamp-tripped");
    ttf_image_flag(&image, "late");
    assert_string_equal(image.flags, "late,lamp-tripped");
    ttf_image_flag(&image, "lamp");
    assert_string_equal(image.flags, "late,lamp-tripped,lamp");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_frame_as_ordered_is_taken),
        cmocka_unit_test(any_field_of_the_settings_counts),
        cmocka_unit_test(bad_data_are_worse_than_bad_settings),
        cmocka_unit_test(any_field_of_the_format_counts),
        cmocka_unit_test(a_frame_whose_bytes_are_not_all_there_is_short_whoever_says_so),
        cmocka_unit_test(flags_are_words_said_once),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
