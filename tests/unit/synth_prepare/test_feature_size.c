/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "pictures.h"
#include "ttf/synth/prepare.h"

#define W     220u
#define H     200u
#define BLOBS 900u

/* Gaussian blobs of these sigmas, in pixels, light or dark, all over the place. */
struct blobs {
    double sigma_x, sigma_y;
    double slope;         /* of brightness, across the picture */
    double early_sigma_x; /* in the first frames; 0: as late */
    double display[H][W];
    double early[H][W];
};

static void fill(double field[H][W], double sigma_x, double sigma_y)
{
    for (uint32_t i = 0; i < BLOBS; i++) {
        double cx = W * chance(i, 1, 3), cy = H * chance(i, 2, 3);
        double sign = i % 2 ? 8.0 : -8.0;

        for (int y = (int)(cy - 3 * sigma_y); y <= (int)(cy + 3 * sigma_y); y++) {
            for (int x = (int)(cx - 3 * sigma_x); x <= (int)(cx + 3 * sigma_x); x++) {
                double u = (x - cx) / sigma_x, v = (y - cy) / sigma_y;

                if (x >= 0 && y >= 0 && x < (int)W && y < (int)H)
                    field[y][x] += sign * exp(-0.5 * (u * u + v * v));
            }
        }
    }
}

static double blobs(const void *ctx, double x, double y, uint32_t t, int c)
{
    const struct blobs *b = ctx;
    const double(*field)[W] = b->early_sigma_x > 0.0 && t < 18 ? b->early : b->display;
    double code = 128.0 + field[(int)y][(int)x] + b->slope * (x / W - 0.5 + y / H - 0.5);

    (void)c;
    return (double)ttf_srgb_decode((float)(code / 255.0));
}

static struct ttf_feature_size found(struct ttf_sequence *input)
{
    struct ttf_feature_size size;
    struct ttf_err err = {0};

    if (ttf_feature_size_find(input, &size, &err) < 0)
        fail_msg("%s", err.what);
    return size;
}

static struct ttf_feature_size of_blobs(double sigma_x, double sigma_y, double slope,
                                        double early_sigma_x)
{
    struct blobs *b = calloc(1, sizeof(*b));
    struct ttf_feature_size size;
    struct pictures input;

    assert_non_null(b);
    b->sigma_x = sigma_x;
    b->sigma_y = sigma_y;
    b->slope = slope;
    b->early_sigma_x = early_sigma_x;
    fill(b->display, sigma_x, sigma_y);
    if (early_sigma_x > 0.0)
        fill(b->early, early_sigma_x, early_sigma_x);
    input = pictures_make(W, H, early_sigma_x > 0.0 ? 20 : 1, &imported, blobs, b);
    size = found(input.sequence);
    pictures_free(&input);
    free(b);
    return size;
}

/* Of Gaussian blobs at random the autocorrelation is a Gaussian of sqrt(2) sigma: 1/e at 2 sigma. */
static void blobs_are_twice_their_sigma_long(void **state)
{
    struct ttf_feature_size size = of_blobs(3.0, 3.0, 0.0, 0.0);

    (void)state;
    assert_true(fabs(size.correlation_x_px - 6.0) < 0.6);
    assert_true(fabs(size.correlation_y_px - 6.0) < 0.6);
    assert_int_equal(size.block_width, 48);
    assert_int_equal(size.block_height, 48);
    assert_true(size.period_x_px == 0.0 && size.period_y_px == 0.0);
}

static void what_is_taller_than_wide_gets_taller_blocks(void **state)
{
    struct ttf_feature_size size = of_blobs(2.0, 4.0, 0.0, 0.0);

    (void)state;
    assert_true(fabs(size.correlation_x_px - 4.0) < 0.4);
    assert_true(fabs(size.correlation_y_px - 8.0) < 0.8);
    assert_int_equal(size.block_width, 32);
    assert_int_equal(size.block_height, 64);
}

static void uneven_light_is_no_feature(void **state)
{
    struct ttf_feature_size size = of_blobs(3.0, 3.0, 90.0, 0.0);

    (void)state;
    assert_true(fabs(size.correlation_x_px - 6.0) < 0.6);
    assert_true(fabs(size.correlation_y_px - 6.0) < 0.6);
}

static void late_times_count(void **state)
{
    struct ttf_feature_size size = of_blobs(2.0, 2.0, 0.0, 5.0);

    (void)state;
    assert_true(fabs(size.correlation_x_px - 4.0) < 0.4);
}

static double stripes(const void *ctx, double x, double y, uint32_t t, int c)
{
    double period = *(const double *)ctx;

    (void)t;
    (void)c;
    return 0.3 + 0.1 * sin(6.2831853 * x / period) + 0.02 * chance((uint32_t)x, (uint32_t)y, 1);
}

static void stripes_have_their_period(void **state)
{
    double period = 19.5;
    struct pictures input = pictures_make(150, 130, 2, &captured, stripes, &period);
    struct ttf_feature_size size = found(input.sequence);

    (void)state;
    assert_true(fabs(size.period_x_px - period) < 0.3);
    assert_true(size.correlation_x_px > 3.0 && size.correlation_x_px < 4.5);
    assert_true(size.period_y_px == 0.0);
    assert_true(size.correlation_y_px == 65.0); /* along them it never falls */
    assert_int_equal(size.block_width, 32);     /* 1.5 periods, in eights */
    assert_int_equal(size.block_height, 40);    /* a third, in eights */
    pictures_free(&input);
}

static double thin_lines(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    (void)x;
    (void)t;
    (void)c;
    return (uint32_t)y % 22 < 2 ? 0.2 : 0.5;
}

static void blocks_hold_more_than_a_period_of_thin_lines(void **state)
{
    struct pictures input = pictures_make(150, 130, 1, &captured, thin_lines, NULL);
    struct ttf_feature_size size = found(input.sequence);

    (void)state;
    assert_true(size.correlation_y_px < 2.0);
    assert_true(fabs(size.period_y_px - 22.0) < 0.3);
    assert_int_equal(size.block_height, 32); /* 33, in eights */
    pictures_free(&input);
}

static double constant(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    (void)y;
    (void)t;
    (void)c;
    return 0.3 + 0.0 * x;
}

static void blocks_of(uint32_t width, uint32_t height, uint32_t want_width, uint32_t want_height)
{
    struct pictures input = pictures_make(width, height, 1, &captured, constant, NULL);
    struct ttf_feature_size size = found(input.sequence);

    assert_true(size.correlation_x_px == 0.0 && size.period_y_px == 0.0);
    assert_int_equal(size.block_width, want_width);
    assert_int_equal(size.block_height, want_height);
    pictures_free(&input);
}

static void constant_pictures_get_the_least_block_that_fits(void **state)
{
    (void)state;
    blocks_of(200, 100, 24, 24);
    blocks_of(40, 24, 24, 24);
    blocks_of(23, 5, 23, 5);
    blocks_of(1, 2, 1, 2);
}

static void an_unreadable_frame_is_reported(void **state)
{
    struct ttf_sequence broken = unreadable_from(19, 20);
    struct ttf_feature_size size = {.block_width = 7};
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(ttf_feature_size_find(&broken, &size, &err), -EIO);
    assert_string_equal(err.where, "frame");
    assert_int_equal(size.block_width, 7);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(blobs_are_twice_their_sigma_long),
        cmocka_unit_test(what_is_taller_than_wide_gets_taller_blocks),
        cmocka_unit_test(uneven_light_is_no_feature),
        cmocka_unit_test(late_times_count),
        cmocka_unit_test(stripes_have_their_period),
        cmocka_unit_test(blocks_hold_more_than_a_period_of_thin_lines),
        cmocka_unit_test(constant_pictures_get_the_least_block_that_fits),
        cmocka_unit_test(an_unreadable_frame_is_reported),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
