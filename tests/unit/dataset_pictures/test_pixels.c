/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <math.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>

#include "scratch.h"
#include "ttf/dataset/colour.h"
#include "ttf/dataset/pixbuf.h"
#include "ttf/dataset/pool.h"

/* ---- colour: the oracle is the standard's formula with libm ---- */

static double formula_decode(double encoded)
{
    return encoded <= 0.04045 ? encoded / 12.92 : pow((encoded + 0.055) / 1.055, 2.4);
}

static double formula_encode(double linear)
{
    return linear <= 0.0031308 ? linear * 12.92 : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static void every_8_bit_code_comes_back_from_linear_light(void **state)
{
    for (unsigned code = 0; code < 256; code++) {
        uint16_t linear = ttf_srgb8_to_linear16((uint8_t)code);

        assert_int_equal(linear, lround(formula_decode(code / 255.0) * 65535.0));
        assert_int_equal(ttf_linear16_to_srgb8(linear), code);
    }
}

static void every_linear_code_gets_the_nearest_display_code(void **state)
{
    for (unsigned linear = 0; linear < 65536; linear++) {
        double wanted = formula_encode(linear / 65535.0) * 255.0;
        double got = ttf_linear16_to_srgb8((uint16_t)linear);

        assert_true(fabs(got - wanted) <= 0.5 + 1e-4);
    }
}

static void the_curve_is_exact_to_a_millionth(void **state)
{
    for (unsigned i = 0; i <= 200000; i++) {
        double x = i / 200000.0;

        assert_true(fabs((double)ttf_srgb_encode((float)x) - formula_encode((float)x)) < 1e-6);
        assert_true(fabs((double)ttf_srgb_decode((float)x) - formula_decode((float)x)) < 1e-6);
    }
    assert_float_equal(ttf_srgb_encode(-1.0f), 0.0f, 0.0);
    assert_float_equal(ttf_srgb_encode(NAN), 0.0f, 0.0);
    assert_float_equal(ttf_srgb_encode(7.0f), 1.0f, 0.0);
}

static void display_codes_mean_the_same_under_both_encodings(void **state)
{
    static const struct ttf_encoding imported = {0, 65535}, captured = {TTF_PEDESTAL, TTF_SCALE};
    static uint8_t table[65536];

    ttf_display8_table(&imported, table);
    for (unsigned code = 0; code < 65536; code++)
        assert_int_equal(table[code], ttf_linear16_to_srgb8((uint16_t)code));
    ttf_display8_table(&captured, table);
    assert_int_equal(table[0], 0);
    assert_int_equal(table[TTF_PEDESTAL], 0);
    assert_int_equal(table[TTF_PEDESTAL + TTF_SCALE], 255);
    assert_int_equal(table[65535], 255);
    for (unsigned code = 0; code < 256; code++) {
        double value = ttf_srgb8_to_linear16((uint8_t)code) / 65535.0;
        long held = lround(value * TTF_SCALE + TTF_PEDESTAL);

        /* Half the codes of the imported ones: the darkest displays may move by one. */
        assert_true(abs((int)table[held] - (int)code) <= 1);
    }
}

/* ---- pixel buffers ---- */

static void impossible_sizes_are_refused(void **state)
{
    struct ttf_pixbuf buf = {0}, view;

    assert_int_equal(ttf_pixbuf_alloc(&buf, 0, 1, 1, TTF_SAMPLE_U8), -EINVAL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, 1, 1, 5, TTF_SAMPLE_U8), -EINVAL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, 1, 1, 1, TTF_SAMPLE_F16), -EINVAL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, UINT32_MAX, UINT32_MAX, 4, TTF_SAMPLE_F32), -EINVAL);
    assert_int_equal(ttf_pixbuf_alloc(&buf, 10, 8, 3, TTF_SAMPLE_U16), 0);
    assert_int_equal(ttf_pixbuf_view(&buf, 10, 0, 1, 1, &view), -EINVAL);
    assert_int_equal(ttf_pixbuf_view(&buf, 4, 4, UINT32_MAX, 1, &view), -EINVAL);
    assert_int_equal(ttf_pixbuf_view(&buf, 4, 5, 6, 3, &view), 0);
    ((uint16_t *)ttf_pixbuf_row(&view, 2))[17] = 77;
    assert_int_equal(((uint16_t *)ttf_pixbuf_row(&buf, 7))[29], 77);
    ttf_pixbuf_free(&view);
    ttf_pixbuf_free(&buf);
    ttf_pixbuf_free(NULL);
}

static void formats_go_there_and_back(void **state)
{
    struct ttf_pixbuf u8, u16, f32, back;

    assert_int_equal(ttf_pixbuf_alloc(&u8, 16, 16, 1, TTF_SAMPLE_U8), 0);
    assert_int_equal(ttf_pixbuf_alloc(&u16, 16, 16, 1, TTF_SAMPLE_U16), 0);
    assert_int_equal(ttf_pixbuf_alloc(&f32, 16, 16, 1, TTF_SAMPLE_F32), 0);
    assert_int_equal(ttf_pixbuf_alloc(&back, 16, 16, 1, TTF_SAMPLE_U8), 0);
    for (unsigned i = 0; i < 256; i++)
        ((uint8_t *)u8.data)[i] = (uint8_t)i;
    assert_int_equal(ttf_pixbuf_convert(&u8, &u16), 0);
    assert_int_equal(((uint16_t *)u16.data)[255], 65535);
    assert_int_equal(((uint16_t *)u16.data)[1], 257);
    assert_int_equal(ttf_pixbuf_convert(&u16, &f32), 0);
    assert_int_equal(ttf_pixbuf_convert(&f32, &back), 0);
    assert_memory_equal(u8.data, back.data, 256);
    ((float *)f32.data)[0] = NAN;
    ((float *)f32.data)[1] = -3.0f;
    ((float *)f32.data)[2] = 3.0f;
    assert_int_equal(ttf_pixbuf_convert(&f32, &u16), 0);
    assert_int_equal(((uint16_t *)u16.data)[0], 0);
    assert_int_equal(((uint16_t *)u16.data)[1], 0);
    assert_int_equal(((uint16_t *)u16.data)[2], 65535);
    ttf_pixbuf_free(&u8);
    ttf_pixbuf_free(&u16);
    ttf_pixbuf_free(&f32);
    ttf_pixbuf_free(&back);
}

/* Shrinking 12 -> 5: the mean of the covered stretch, by exact fractions. */
static void shrinking_averages_over_the_area(void **state)
{
    struct ttf_pixbuf src, dst;
    double mean_src = 0, mean_dst = 0;

    assert_int_equal(ttf_pixbuf_alloc(&src, 12, 10, 2, TTF_SAMPLE_F32), 0);
    assert_int_equal(ttf_pixbuf_alloc(&dst, 5, 3, 2, TTF_SAMPLE_F32), 0);
    for (uint32_t y = 0; y < 10; y++) {
        for (uint32_t x = 0; x < 12; x++) {
            ((float *)ttf_pixbuf_row(&src, y))[2 * x] = (float)(x * x);
            ((float *)ttf_pixbuf_row(&src, y))[2 * x + 1] = (float)(y * y * 3);
        }
    }
    assert_int_equal(ttf_pixbuf_resample(&src, &dst), 0);
    for (uint32_t i = 0; i < 5; i++) {
        double from = i * 12.0 / 5, to = from + 12.0 / 5, sum = 0;

        for (uint32_t x = 0; x < 12; x++) {
            double a = fmax(from, x), b = fmin(to, x + 1.0);

            if (b > a)
                sum += (b - a) * x * x;
        }
        assert_float_equal(((float *)ttf_pixbuf_row(&dst, 1))[2 * i], sum / 2.4, 1e-3);
    }
    for (uint32_t i = 0; i < 120; i++)
        mean_src += (double)((float *)src.data)[2 * i + 1] / 120;
    for (uint32_t i = 0; i < 15; i++)
        mean_dst += (double)((float *)dst.data)[2 * i + 1] / 15;
    assert_float_equal(mean_src, mean_dst, 1e-3);
    ttf_pixbuf_free(&src);
    ttf_pixbuf_free(&dst);
}

static void enlarging_interpolates_between_centres(void **state)
{
    struct ttf_pixbuf src, dst, same;

    assert_int_equal(ttf_pixbuf_alloc(&src, 4, 3, 1, TTF_SAMPLE_U16), 0);
    assert_int_equal(ttf_pixbuf_alloc(&dst, 40, 30, 1, TTF_SAMPLE_U16), 0);
    assert_int_equal(ttf_pixbuf_alloc(&same, 4, 3, 1, TTF_SAMPLE_U16), 0);
    for (uint32_t i = 0; i < 12; i++)
        ((uint16_t *)src.data)[i] = (uint16_t)(1000 * (i % 4) + 100 * (i / 4));
    assert_int_equal(ttf_pixbuf_resample(&src, &dst), 0);
    for (uint32_t y = 0; y < 30; y++) {
        for (uint32_t x = 0; x < 40; x++) {
            double u = fmin(fmax((x + 0.5) / 10 - 0.5, 0), 3);
            double v = fmin(fmax((y + 0.5) / 10 - 0.5, 0), 2);

            assert_true(fabs(((uint16_t *)ttf_pixbuf_row(&dst, y))[x] - (1000 * u + 100 * v)) < 1);
        }
    }
    assert_int_equal(ttf_pixbuf_resample(&src, &same), 0);
    assert_memory_equal(src.data, same.data, 24);
    ttf_pixbuf_free(&src);
    ttf_pixbuf_free(&dst);
    ttf_pixbuf_free(&same);
}

/* ---- the pool ---- */

#define TILES 1000

struct count {
    atomic_uint done[TILES];
    unsigned threads;
    atomic_uint strangers;
};

static void count_tile(void *ctx, unsigned tile, unsigned worker)
{
    struct count *count = ctx;

    atomic_fetch_add(&count->done[tile], 1);
    if (worker >= count->threads)
        atomic_fetch_add(&count->strangers, 1);
}

static void every_tile_is_done_once_for_any_number_of_threads(void **state)
{
    for (unsigned threads = 0; threads <= 5; threads++) {
        struct ttf_pool *pool = threads ? ttf_pool_create(threads) : NULL;
        struct count *count = calloc(1, sizeof(*count));

        assert_non_null(count);
        count->threads = ttf_pool_threads(pool);
        assert_int_equal(count->threads, threads ? threads : 1);
        for (unsigned run = 0; run < 50; run++)
            ttf_pool_run(pool, TILES - run, count_tile, count);
        ttf_pool_run(pool, 0, count_tile, count);
        for (unsigned i = 0; i < TILES; i++)
            assert_int_equal(count->done[i], i < TILES - 49 ? 50 : TILES - i);
        assert_int_equal(count->strangers, 0);
        free(count);
        ttf_pool_destroy(pool);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_8_bit_code_comes_back_from_linear_light),
        cmocka_unit_test(every_linear_code_gets_the_nearest_display_code),
        cmocka_unit_test(the_curve_is_exact_to_a_millionth),
        cmocka_unit_test(display_codes_mean_the_same_under_both_encodings),
        cmocka_unit_test(impossible_sizes_are_refused),
        cmocka_unit_test(formats_go_there_and_back),
        cmocka_unit_test(shrinking_averages_over_the_area),
        cmocka_unit_test(enlarging_interpolates_between_centres),
        cmocka_unit_test(every_tile_is_done_once_for_any_number_of_threads),
    };

    return cmocka_run_group_tests_name("pixels", tests, NULL, NULL);
}
