/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "metrics/patches.h"
#include "metrics/samples.h"
#include "metrics/sliced.h"
#include "ttf/synth/likeness.h"

#define W 45u
#define H 38u

static uint32_t random_below(uint64_t which, uint32_t n)
{
    return ttf_pick(ttf_random64(11, TTF_PURPOSE_BLOCK, which), n);
}

static uint8_t *allocate(uint32_t width, uint32_t height)
{
    uint8_t *rgb = malloc((size_t)width * height * 3);

    assert_non_null(rgb);
    return rgb;
}

/* Waves that cross, a little aslant, and a little noise. */
static uint8_t *make_texture(uint64_t seed, uint32_t width, uint32_t height)
{
    uint8_t *rgb = allocate(width, height);

    for (size_t i = 0; i < (size_t)width * height * 3; i++) {
        size_t column = i / 3 % width, row = i / 3 / width;
        double x = (double)column, y = (double)row;
        double wave = sin(0.7 * x + 0.1 * y + 2.0 * (double)seed) + sin(0.6 * y - 0.05 * x);

        rgb[i] = (uint8_t)(120.0 + 40.0 * wave + 5.0 * (double)(i % 3) +
                           random_below(seed * 1000003 + i, 12));
    }
    return rgb;
}

/* The same pixels left to right. */
static uint8_t *mirror(const uint8_t *rgb, uint32_t width, uint32_t height)
{
    uint8_t *ret = allocate(width, height);

    for (size_t i = 0; i < (size_t)width * height * 3; i++) {
        size_t y = i / 3 / width, x = width - 1 - i / 3 % width;

        ret[i] = rgb[(y * width + x) * 3 + i % 3];
    }
    return ret;
}

/* The same pixels without their places. */
static uint8_t *shuffle(const uint8_t *rgb, uint32_t width, uint32_t height)
{
    uint8_t *ret = allocate(width, height);

    memcpy(ret, rgb, (size_t)width * height * 3);
    for (uint32_t i = width * height; i-- > 1;) {
        uint32_t k = random_below(i, i + 1);

        for (size_t c = 0; c < 3; c++) {
            uint8_t keep = ret[i * 3 + c];

            ret[i * 3 + c] = ret[k * 3 + c];
            ret[k * 3 + c] = keep;
        }
    }
    return ret;
}

static double plain_square(const struct ttf_patches *a, uint32_t ax, uint32_t ay,
                           const struct ttf_patches *b, uint32_t bx, uint32_t by)
{
    double sum = 0.0;

    for (uint32_t i = 0; i < TTF_PATCH_NUMBERS; i++) {
        uint32_t x = i / 3 % 7, y = i / 21, c = i % 3;
        double d = (double)ttf_patch_at(a, ax + x, ay + y)[c] - ttf_patch_at(b, bx + x, by + y)[c];

        sum += d * d;
    }
    return sum;
}

static double plain_nearest(const struct ttf_patches *of, const struct ttf_patches *in,
                            unsigned samples)
{
    double sum = 0.0;

    for (unsigned i = 0; i < samples; i++) {
        uint32_t at =
            ttf_stratum(0, TTF_PURPOSE_PATCH, i, (uint64_t)of->patches_x * of->patches_y, samples);
        double best = INFINITY;

        for (uint32_t y = 0; y < in->patches_y; y++) {
            for (uint32_t x = 0; x < in->patches_x; x++)
                best =
                    fmin(best, plain_square(of, at % of->patches_x, at / of->patches_x, in, x, y));
        }
        sum += sqrt(best / TTF_PATCH_NUMBERS);
    }
    return sum / samples;
}

static void assert_nearest_is_plain(const uint8_t *a, uint32_t a_width, uint32_t a_height,
                                    const uint8_t *b, uint32_t b_width, uint32_t b_height,
                                    unsigned samples)
{
    struct ttf_patches of, in;
    double found;

    assert_int_equal(ttf_patches_of_picture(a, a_width, a_height, &of), 0);
    assert_int_equal(ttf_patches_of_picture(b, b_width, b_height, &in), 0);
    assert_int_equal(ttf_patches_nearest(&of, &in, samples, NULL, &found), 0);
    assert_true(found == plain_nearest(&of, &in, samples));
    ttf_patches_free(&of);
    ttf_patches_free(&in);
}

static void the_nearest_patch_is_that_of_brute_force(void **state)
{
    /* one row of patches wider than what is looked at together; a picture of one patch */
    const uint32_t sizes[][2] = {{W, H}, {300, 9}, {7, 7}, {8, 60}};

    for (size_t k = 0; k < sizeof(sizes) / sizeof(sizes[0]); k++) {
        uint32_t width = sizes[k][0], height = sizes[k][1];
        uint8_t *a = make_texture(1, W, H), *b = make_texture(2, width, height);
        uint8_t *noise = shuffle(b, width, height);

        assert_nearest_is_plain(a, W, H, b, width, height, 101);
        assert_nearest_is_plain(b, width, height, a, W, H, (width - 6) * (height - 6) / 4 + 1);
        assert_nearest_is_plain(a, W, H, noise, width, height, 20);
        free(a);
        free(b);
        free(noise);
    }
}

static void every_patch_of_a_picture_finds_itself(void **state)
{
    uint8_t *a = make_texture(1, 600, 12);
    struct ttf_patches p;
    double found;

    assert_int_equal(ttf_patches_of_picture(a, 600, 12, &p), 0);
    assert_int_equal(ttf_patches_nearest(&p, &p, 600 * 12, NULL, &found), 0);
    assert_true(found == 0.0);
    ttf_patches_free(&p);
    free(a);
}

static void black_and_white_are_255_apart(void **state)
{
    uint8_t *black = allocate(W, H), *white = allocate(W, H);
    struct ttf_patch_figures figures;

    memset(black, 0, (size_t)W * H * 3);
    memset(white, 255, (size_t)W * H * 3);
    assert_int_equal(ttf_patch_compare(black, W, H, white, W, H, 5, NULL, &figures), 0);
    assert_true(figures.to_input == 255.0 && figures.from_input == 255.0);
    for (int i = 0; i < 3; i++) /* sqrt(2 / pi) of 255 on the whole sphere */
        assert_true(fabs(figures.sliced[i] / 255.0 - 0.8) < 0.15);
    free(black);
    free(white);
}

static void identical_pictures_are_at_no_distance(void **state)
{
    uint8_t *a = make_texture(1, W, H);
    struct ttf_patch_figures f;

    assert_int_equal(ttf_patch_compare(a, W, H, a, W, H, 100, NULL, &f), 0);
    assert_true(f.sliced[0] == 0.0 && f.sliced[1] == 0.0 && f.sliced[2] == 0.0);
    assert_true(f.to_input == 0.0 && f.from_input == 0.0);
    free(a);
}

static void more_of_a_texture_is_nearer_than_its_mirror_image_and_that_than_its_pixels(void **state)
{
    uint8_t *a = make_texture(1, 90, 80), *more = make_texture(3, 130, 70);
    uint8_t *mirrored = mirror(a, 90, 80), *noise = shuffle(a, 90, 80);
    struct ttf_patch_figures f[3];

    assert_int_equal(ttf_patch_compare(a, 90, 80, more, 130, 70, 60, NULL, &f[0]), 0);
    assert_int_equal(ttf_patch_compare(a, 90, 80, mirrored, 90, 80, 60, NULL, &f[1]), 0);
    assert_int_equal(ttf_patch_compare(a, 90, 80, noise, 90, 80, 60, NULL, &f[2]), 0);
    for (int k = 0; k < 2; k++) {
        for (int i = 0; i < 2; i++)
            assert_true(f[k].sliced[i] < 0.8 * f[k + 1].sliced[i]);
        assert_true(f[k].to_input < 0.8 * f[k + 1].to_input);
        assert_true(f[k].from_input < 0.8 * f[k + 1].from_input);
    }
    free(a);
    free(more);
    free(mirrored);
    free(noise);
}

static void what_is_missing_and_what_is_foreign_are_told_apart(void **state)
{
    uint8_t *a = make_texture(1, W, H), *half = make_texture(1, W, H);
    struct ttf_patch_figures f;

    /* the lower half goes grey */
    memset(half + (size_t)W * 19 * 3, 230, (size_t)W * (H - 19) * 3);
    assert_int_equal(ttf_patch_compare(half, W, H, a, W, H, 10000, NULL, &f), 0);
    assert_true(f.from_input > 2.0 * f.to_input);
    assert_int_equal(ttf_patch_compare(a, W, H, half, W, H, 10000, NULL, &f), 0);
    assert_true(f.to_input > 2.0 * f.from_input);
    free(a);
    free(half);
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static double *sorted_projections(const struct ttf_patches *p, const int16_t *direction)
{
    double *ret = calloc((size_t)p->patches_x * p->patches_y, sizeof(*ret));

    assert_non_null(ret);
    for (uint32_t k = 0; k < p->patches_x * p->patches_y; k++) {
        for (uint32_t i = 0; i < TTF_PATCH_NUMBERS; i++) {
            uint32_t x = k % p->patches_x + i / 3 % 7, y = k / p->patches_x + i / 21;

            ret[k] += direction[i] / 16384.0 * ttf_patch_at(p, x, y)[i % 3];
        }
    }
    qsort(ret, (size_t)p->patches_x * p->patches_y, sizeof(*ret), by_size);
    return ret;
}

static void the_sliced_distance_is_that_of_sorted_projections(void **state)
{
    uint8_t *a = make_texture(1, W, H), *b = shuffle(a, W, H);
    struct ttf_patches p = {0}, q = {0};
    double found, plain = 0.0;

    assert_int_equal(ttf_patches_of_picture(a, W, H, &p), 0);
    assert_int_equal(ttf_patches_of_picture(b, W, H, &q), 0);
    assert_int_equal(ttf_patches_sliced(&p, &q, NULL, &found), 0);
    for (unsigned i = 0; i < 64; i++) {
        int16_t direction[TTF_PATCH_NUMBERS];

        ttf_sliced_direction(TTF_PURPOSE_PATCH_DIRECTION, i, TTF_PATCH_NUMBERS, direction);
        double *x = sorted_projections(&p, direction), *y = sorted_projections(&q, direction);

        for (size_t k = 0; k < (size_t)(W - 6) * (H - 6); k++)
            plain += fabs(x[k] - y[k]) / ((W - 6) * (H - 6) * 64.0);
        free(x);
        free(y);
    }
    assert_true(plain > 2.0);
    assert_true(fabs(found - plain) < 0.02);
    ttf_patches_free(&p);
    ttf_patches_free(&q);
    free(a);
    free(b);
}

static void half_size_is_the_mean_of_four(void **state)
{
    /* odd sizes: the last row and column are left out */
    uint8_t *a = make_texture(4, 29, 31);
    struct ttf_patches p, half;

    assert_int_equal(ttf_patches_of_picture(a, 29, 31, &p), 0);
    assert_int_equal(ttf_patches_halve(&p, &half), 0);
    assert_true(half.width == 14 && half.height == 15 && half.patches_x == 8);
    for (uint32_t i = 0; i < 14 * 15 * 3; i++) {
        uint32_t x = i / 3 % 14, y = i / 3 / 14, c = i % 3;
        uint32_t sum = 0;

        for (uint32_t k = 0; k < 4; k++)
            sum += a[((2 * y + k / 2) * 29 + 2 * x + k % 2) * 3 + c];
        assert_int_equal(ttf_patch_at(&half, x, y)[c], lrint(floor(sum / 4.0 + 0.5)));
    }
    ttf_patches_free(&p);
    ttf_patches_free(&half);
    free(a);
}

static void threads_do_not_change_a_bit(void **state)
{
    uint8_t *a = make_texture(1, W, H), *b = make_texture(2, 60, 50);
    struct ttf_patch_figures alone, shared;

    assert_int_equal(ttf_patch_compare(a, W, H, b, 60, 50, 77, NULL, &alone), 0);
    for (unsigned threads = 1; threads <= 3; threads++) {
        struct ttf_pool *pool = ttf_pool_create(threads);

        assert_non_null(pool);
        assert_int_equal(ttf_patch_compare(a, W, H, b, 60, 50, 77, pool, &shared), 0);
        assert_memory_equal(&alone, &shared, sizeof(alone));
        ttf_pool_destroy(pool);
    }
    free(a);
    free(b);
}

static void a_picture_too_small_is_refused(void **state)
{
    uint8_t *a = make_texture(1, W, H);
    struct ttf_patch_figures f = {.to_input = 42.0};

    assert_int_equal(ttf_patch_compare(a, 27, 28, a, W, H, 1, NULL, &f), -EINVAL);
    assert_int_equal(ttf_patch_compare(a, W, H, a, 28, 27, 1, NULL, &f), -EINVAL);
    assert_true(f.to_input == 42.0);
    assert_int_equal(ttf_patch_compare(a, 28, 28, a, W, H, 0, NULL, &f), 0);
    assert_true(f.to_input == 0.0 && f.from_input == 0.0 && f.sliced[2] > 0.0);
    free(a);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_nearest_patch_is_that_of_brute_force),
        cmocka_unit_test(every_patch_of_a_picture_finds_itself),
        cmocka_unit_test(black_and_white_are_255_apart),
        cmocka_unit_test(identical_pictures_are_at_no_distance),
        cmocka_unit_test(
            more_of_a_texture_is_nearer_than_its_mirror_image_and_that_than_its_pixels),
        cmocka_unit_test(what_is_missing_and_what_is_foreign_are_told_apart),
        cmocka_unit_test(the_sliced_distance_is_that_of_sorted_projections),
        cmocka_unit_test(half_size_is_the_mean_of_four),
        cmocka_unit_test(threads_do_not_change_a_bit),
        cmocka_unit_test(a_picture_too_small_is_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
