/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <string.h>

#include "made.h"
#include "ttf/synth/rate_map.h"

static uint32_t frames(float fastest, uint32_t n)
{
    float m[4] = {0.0f, fastest, fastest / 2, 0.0f};
    struct ttf_rate_map map = {2, 2, m};
    uint32_t got = 0;

    assert_int_equal(ttf_rate_map_frames(&map, n, &got, NULL), 0);
    return got;
}

static void the_fastest_pixel_sets_the_length(void **state)
{
    (void)state;
    assert_int_equal(frames(1.0f, 100), 100);
    assert_int_equal(frames(2.0f, 100), 51); /* 99 / 2, rounded up, and frame 0 */
    assert_int_equal(frames(2.0f, 101), 51);
    assert_int_equal(frames(0.5f, 100), 199);
    assert_int_equal(frames(0.0f, 100), 100); /* nothing moves: copies of frame 0 */
    assert_int_equal(frames(3.0f, 1), 1);
    assert_int_equal(frames(1000.0f, 100), 2);
}

static void a_rate_that_floats_cannot_hold_means_what_was_written(void **state)
{
    (void)state;
    assert_true((double)0.7f < 0.7); /* 70 / 0.7f is above 100 */
    assert_int_equal(frames(0.7f, 71), 101);
    assert_int_equal(frames(0.1f, 100), 991);
    assert_int_equal(frames(0.7f, 72), 103); /* 71 / 0.7 = 101.4 */
}

static void a_length_beyond_a_million_frames_is_refused(void **state)
{
    float m = 1e-5f;
    struct ttf_rate_map map = {1, 1, &m};
    struct ttf_err err = {0};
    uint32_t got = 77;

    (void)state;
    assert_int_equal(ttf_rate_map_frames(&map, 100, &got, &err), -ERANGE);
    assert_int_equal(err.code, -ERANGE);
    assert_true(err.hint[0] != '\0');
    assert_int_equal(got, 77);
    assert_int_equal(ttf_rate_map_frames(&map, 11, &got, NULL), 0);
    assert_int_equal(got, 1000001);
    assert_int_equal(ttf_rate_map_frames(&map, 0, &got, NULL), -EINVAL);
}

static void the_range_is_that_of_all_pixels(void **state)
{
    float m[6] = {0.5f, 0.25f, 0.75f, 3.0f, 0.5f, 0.125f}, least, most;
    struct ttf_rate_map map = {3, 2, m};

    (void)state;
    ttf_rate_map_range(&map, &least, &most);
    assert_true(least == 0.125f && most == 3.0f);
}

static double ramp(double x, double y)
{
    return 0.5 * x + y;
}

static void a_picture_is_rates_of_its_own_size(void **state)
{
    struct ttf_pixbuf grey = made_grey(8, 4, ramp);
    struct ttf_rate_map map;

    (void)state;
    assert_int_equal(ttf_rate_map_of_picture(&grey, 0, 0, 0.0, 1.0, &map, NULL), 0);
    assert_true(map.width == 8 && map.height == 4);
    for (uint32_t y = 0; y < 4; y++)
        for (uint32_t x = 0; x < 8; x++)
            assert_true(made_at(&map, x, y) == (float)ramp((x + 0.5) / 8, (y + 0.5) / 8));
    ttf_rate_map_free(&map);
    assert_null(map.m);
    ttf_pixbuf_free(&grey);
}

static void offset_and_gain_scale_it_and_nothing_ages_backwards(void **state)
{
    struct ttf_pixbuf grey = made_grey(8, 4, ramp);
    struct ttf_rate_map map;

    (void)state;
    assert_int_equal(ttf_rate_map_of_picture(&grey, 0, 0, 1.0, -4.0, &map, NULL), 0);
    for (uint32_t y = 0; y < 4; y++) {
        for (uint32_t x = 0; x < 8; x++) {
            double want = 1.0 - 4.0 * ramp((x + 0.5) / 8, (y + 0.5) / 8);

            assert_true(fabs((double)made_at(&map, x, y) - (want > 0.0 ? want : 0.0)) < 1e-6);
        }
    }
    ttf_rate_map_free(&map);
    ttf_pixbuf_free(&grey);
}

static void any_size_is_made_of_it(void **state)
{
    struct ttf_pixbuf grey = made_grey(8, 4, ramp);
    struct ttf_rate_map map;

    (void)state;
    assert_int_equal(ttf_rate_map_of_picture(&grey, 4, 2, 0.0, 1.0, &map, NULL), 0);
    for (uint32_t y = 0; y < 2; y++) /* a ramp's mean over 2 x 2 pixels is its middle */
        for (uint32_t x = 0; x < 4; x++)
            assert_true(fabs((double)made_at(&map, x, y) - ramp((x + 0.5) / 4, (y + 0.5) / 4)) <
                        1e-6);
    ttf_rate_map_free(&map);
    assert_int_equal(ttf_rate_map_of_picture(&grey, 0, 40, 0.0, 1.0, &map, NULL), 0);
    assert_true(map.width == 8 && map.height == 40);
    ttf_rate_map_free(&map);
    ttf_pixbuf_free(&grey);
}

static void colours_count_by_their_luminance_and_alpha_not_at_all(void **state)
{
    uint8_t rgba[8] = {255, 0, 0, 7, 51, 51, 51, 0};
    uint16_t two[4] = {13107, 65535, 65535, 0};
    struct ttf_pixbuf colour = {2, 1, 4, TTF_SAMPLE_U8, 8, rgba, false};
    struct ttf_pixbuf grey = {2, 1, 2, TTF_SAMPLE_U16, 8, two, false};
    struct ttf_rate_map map;

    (void)state;
    assert_int_equal(ttf_rate_map_of_picture(&colour, 0, 0, 0.0, 1.0, &map, NULL), 0);
    assert_true(fabs((double)made_at(&map, 0, 0) - 0.2126) < 1e-6);
    assert_true(fabs((double)made_at(&map, 1, 0) - 0.2) < 1e-6);
    ttf_rate_map_free(&map);
    assert_int_equal(ttf_rate_map_of_picture(&grey, 0, 0, 0.0, 1.0, &map, NULL), 0);
    assert_true(fabs((double)made_at(&map, 0, 0) - 0.2) < 1e-6);
    assert_true(made_at(&map, 1, 0) == 1.0f);
    ttf_rate_map_free(&map);
}

static void what_is_no_number_is_refused(void **state)
{
    struct ttf_pixbuf grey = made_grey(8, 4, ramp);
    struct ttf_rate_map map = {0};
    struct ttf_err err = {0};

    (void)state;
    made_refused(ttf_rate_map_of_picture(&grey, 0, 0, (double)NAN, 1.0, &map, &err), -EINVAL,
                 "offset", &err, &map);
    made_refused(ttf_rate_map_of_picture(&grey, 0, 0, 0.0, (double)INFINITY, &map, &err), -EINVAL,
                 "gain", &err, &map);
    made_refused(ttf_rate_map_of_picture(&grey, 0, 0, 0.0, 1e9, &map, &err), -ERANGE, "rate", &err,
                 &map);
    made_refused(ttf_rate_map_of_picture(&grey, 40000, 1, 0.0, 1.0, &map, &err), -EINVAL, "size",
                 &err, &map);
    ((float *)ttf_pixbuf_row(&grey, 2))[5] = NAN;
    made_refused(ttf_rate_map_of_picture(&grey, 4, 2, 0.0, 1.0, &map, &err), -EINVAL,
                 "rate picture", &err, &map);
    assert_non_null(strstr(err.what, "(5, 2)"));
    ((float *)ttf_pixbuf_row(&grey, 2))[5] = INFINITY;
    made_refused(ttf_rate_map_of_picture(&grey, 0, 0, 0.0, 1.0, &map, &err), -EINVAL,
                 "rate picture", &err, &map);
    grey.format = TTF_SAMPLE_F16;
    made_refused(ttf_rate_map_of_picture(&grey, 0, 0, 0.0, 1.0, &map, &err), -EINVAL,
                 "rate picture", &err, &map);
    ttf_pixbuf_free(&grey);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_fastest_pixel_sets_the_length),
        cmocka_unit_test(a_rate_that_floats_cannot_hold_means_what_was_written),
        cmocka_unit_test(a_length_beyond_a_million_frames_is_refused),
        cmocka_unit_test(the_range_is_that_of_all_pixels),
        cmocka_unit_test(a_picture_is_rates_of_its_own_size),
        cmocka_unit_test(offset_and_gain_scale_it_and_nothing_ages_backwards),
        cmocka_unit_test(any_size_is_made_of_it),
        cmocka_unit_test(colours_count_by_their_luminance_and_alpha_not_at_all),
        cmocka_unit_test(what_is_no_number_is_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
