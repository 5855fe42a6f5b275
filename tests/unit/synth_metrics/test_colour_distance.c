/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>

#include "metrics/colour_distance.h"
#include "metrics/sliced.h"
#include "ttf/synth/likeness.h"

#define N     1200u
#define LARGE 300007u /* more than are looked at, and a prime */

static const struct ttf_encoding encoding = {0.0, 65535.0};

static uint32_t random_below(uint64_t which, uint32_t n)
{
    return ttf_pick(ttf_random64(77, TTF_PURPOSE_BLOCK, which), n);
}

/* Pixels about a colour, with a spread for each channel and a common part. */
static uint16_t *make_picture(uint64_t seed, size_t pixels, int centre, int spread)
{
    uint16_t *codes = malloc(pixels * 3 * sizeof(*codes));

    assert_non_null(codes);
    for (size_t i = 0; i < pixels; i++) {
        int common = (int)random_below(seed + i * 4, (uint32_t)spread);

        for (size_t c = 0; c < 3; c++) {
            int own = (int)random_below(seed + i * 4 + 1 + c, (uint32_t)spread);

            codes[i * 3 + c] =
                ttf_srgb8_to_linear16((uint8_t)(centre + 10 * (int)c + (common + own) / 2));
        }
    }
    return codes;
}

static double distance_of(const uint16_t *input, size_t n_input, const uint16_t *output,
                          size_t n_output, struct ttf_pool *pool)
{
    struct ttf_colour_distance *distance = ttf_colour_distance_create(&encoding);
    double ret;

    assert_non_null(distance);
    ret = ttf_colour_distance_add(distance, pool, input, n_input, output, n_output);
    ttf_colour_distance_destroy(distance);
    return ret;
}

static int by_size(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static double *sorted_projections(const uint16_t *codes, size_t n, const int16_t direction[3])
{
    double *ret = malloc(n * sizeof(*ret));

    assert_non_null(ret);
    for (size_t i = 0; i < n; i++) {
        ret[i] = 0.0;
        for (size_t c = 0; c < 3; c++)
            ret[i] += ttf_linear16_to_srgb8(codes[i * 3 + c]) * (direction[c] / 16384.0);
    }
    qsort(ret, n, sizeof(*ret), by_size);
    return ret;
}

/* The definition: what is sorted is moved to its like, n_output being `times` n_input. */
static double plain_distance(const uint16_t *input, size_t n_input, const uint16_t *output,
                             size_t times)
{
    double sum = 0.0;

    for (unsigned i = 0; i < TTF_COLOUR_DIRECTIONS; i++) {
        int16_t direction[3];

        ttf_colour_direction(i, direction);
        double *a = sorted_projections(input, n_input, direction);
        double *b = sorted_projections(output, n_input * times, direction);

        for (size_t k = 0; k < n_input * times; k++)
            sum += fabs(a[k / times] - b[k]) / (double)(n_input * times);
        free(a);
        free(b);
    }
    return sum / TTF_COLOUR_DIRECTIONS;
}

static void directions_are_unit_vectors_all_around(void **state)
{
    double along[3] = {0.0};

    for (unsigned i = 0; i < TTF_COLOUR_DIRECTIONS; i++) {
        double square = 0.0;
        int16_t d[3];

        ttf_colour_direction(i, d);
        for (unsigned c = 0; c < 3; c++) {
            square += (double)d[c] * d[c];
            along[c] += fabs((double)d[c]) / TTF_SLICED_UNIT / TTF_COLOUR_DIRECTIONS;
        }
        assert_true(fabs(sqrt(square) / TTF_SLICED_UNIT - 1.0) < 1e-4);
    }
    /* over the whole sphere the mean is a half */
    for (unsigned c = 0; c < 3; c++)
        assert_true(fabs(along[c] - 0.5) < 0.12);
}

static void a_picture_is_at_no_distance_from_itself_or_its_pixels_in_another_order(void **state)
{
    uint16_t *a = make_picture(1, N, 60, 120);
    uint16_t *b = malloc(N * 3 * sizeof(*b));

    assert_non_null(b);
    /* 7 and N have no divisor in common */
    for (size_t i = 0; i < N * 3; i++)
        b[i] = a[(i / 3 * 7 + 5) % N * 3 + i % 3];
    assert_true(distance_of(a, N, a, N, NULL) == 0.0);
    assert_true(distance_of(a, N, b, N, NULL) == 0.0);

    /* nor from itself twice over: distributions do not know sizes */
    b = realloc(b, 2 * N * 3 * sizeof(*b));
    assert_non_null(b);
    for (size_t i = 0; i < 2 * N * 3; i++)
        b[i] = a[i % (N * 3)];
    assert_true(distance_of(a, N, b, 2 * N, NULL) == 0.0);
    free(a);
    free(b);
}

static void a_brighter_picture_is_as_far_as_it_is_brighter(void **state)
{
    const int steps[] = {1, 4, 30};
    double along = 0.0;

    for (unsigned i = 0; i < TTF_COLOUR_DIRECTIONS; i++) {
        int16_t d[3];

        ttf_colour_direction(i, d);
        along += fabs((double)(d[0] + d[1] + d[2])) / TTF_SLICED_UNIT / TTF_COLOUR_DIRECTIONS;
    }
    assert_true(along > 0.7 && along < 1.03); /* sqrt(3) / 2 over the whole sphere */
    for (size_t k = 0; k < 3; k++) {
        uint16_t *a = make_picture(5, N, 40, 100), *b = make_picture(5, N, 40 + steps[k], 100);
        double found = distance_of(a, N, b, N, NULL);

        assert_true(fabs(found - along * steps[k]) < 0.03);
        free(a);
        free(b);
    }
}

static void the_distance_is_that_of_sorted_projections(void **state)
{
    for (uint64_t seed = 0; seed < 4; seed++) {
        size_t times = 1 + seed % 2;
        uint16_t *a = make_picture(seed * 100000, N, 30, 90 + (int)seed * 20);
        uint16_t *b = make_picture(seed * 100000 + 50000, N * times, 50 + (int)seed * 7, 120);
        double found = distance_of(a, N, b, N * times, NULL);
        double plain = plain_distance(a, N, b, times);

        assert_true(plain > 3.0);
        assert_true(fabs(found - plain) < 0.05);
        /* and it is the same from both sides */
        assert_true(fabs(distance_of(b, N * times, a, N, NULL) - found) < 1e-9);
        free(a);
        free(b);
    }
}

static void a_large_picture_is_represented_by_a_sample(void **state)
{
    uint16_t *a = make_picture(1, 60000, 60, 120), *b = make_picture(900000, LARGE, 60, 120);
    uint16_t *c = make_picture(900000, LARGE, 70, 120);

    assert_true(distance_of(a, 60000, b, LARGE, NULL) < 0.4);
    assert_true(distance_of(a, 60000, c, LARGE, NULL) > 7.0);
    assert_true(distance_of(b, LARGE, b, LARGE, NULL) == 0.0);
    free(a);
    free(b);
    free(c);
}

static void threads_do_not_change_a_bit(void **state)
{
    uint16_t *a = make_picture(1, 5000, 60, 120), *b = make_picture(70000, 9001, 90, 120);
    double alone = distance_of(a, 5000, b, 9001, NULL);

    for (unsigned threads = 1; threads <= 3; threads++) {
        struct ttf_pool *pool = ttf_pool_create(threads);

        assert_non_null(pool);
        assert_true(distance_of(a, 5000, b, 9001, pool) == alone);
        ttf_pool_destroy(pool);
    }
    free(a);
    free(b);
}

static void the_worst_time_is_named(void **state)
{
    struct ttf_colour_distance *distance = ttf_colour_distance_create(&encoding);
    uint16_t *a = make_picture(1, N, 60, 100), *b = make_picture(1, N, 66, 100);
    uint16_t *c = make_picture(1, N, 80, 100);
    struct ttf_colour_figures figures;
    double sum;

    assert_non_null(distance);
    ttf_colour_distance_figures(distance, &figures);
    assert_true(figures.frames == 0 && figures.mean == 0.0 && figures.largest == 0.0);
    sum = ttf_colour_distance_add(distance, NULL, a, N, b, N);
    sum += ttf_colour_distance_add(distance, NULL, a, N, c, N);
    sum += ttf_colour_distance_add(distance, NULL, a, N, a, N);
    sum += ttf_colour_distance_add(distance, NULL, a, N, c, N);
    ttf_colour_distance_figures(distance, &figures);
    assert_int_equal(figures.frames, 4);
    assert_int_equal(figures.largest_at, 1);
    assert_true(figures.largest == ttf_colour_distance_add(distance, NULL, a, N, c, N));
    assert_true(fabs(figures.mean - sum / 4.0) < 1e-12);
    ttf_colour_distance_destroy(distance);
    free(a);
    free(b);
    free(c);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(directions_are_unit_vectors_all_around),
        cmocka_unit_test(a_picture_is_at_no_distance_from_itself_or_its_pixels_in_another_order),
        cmocka_unit_test(a_brighter_picture_is_as_far_as_it_is_brighter),
        cmocka_unit_test(the_distance_is_that_of_sorted_projections),
        cmocka_unit_test(a_large_picture_is_represented_by_a_sample),
        cmocka_unit_test(threads_do_not_change_a_bit),
        cmocka_unit_test(the_worst_time_is_named),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
