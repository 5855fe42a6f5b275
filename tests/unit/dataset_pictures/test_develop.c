/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scratch.h"
#include "ttf/dataset/develop.h"

#define W     97
#define H     71
#define BLACK 256
#define WHITE 4095

static const struct ttf_exposure settings = {10000000, 1000, 1000, 1000, 0};
static const struct ttf_encoding encoding = {TTF_PEDESTAL, TTF_SCALE};

static struct ttf_frame_format bayer(uint32_t width, uint32_t height, enum ttf_cfa cfa)
{
    return (struct ttf_frame_format){.width = width,
                                     .height = height,
                                     .stride = (size_t)width * 2,
                                     .packing = TTF_PACKING_RAW16,
                                     .cfa = cfa,
                                     .bits = 12,
                                     .black_level = BLACK,
                                     .white_level = WHITE};
}

/* A sum of n equal frames of these codes. */
static void sum_of(struct ttf_raw_sum *sum, const struct ttf_frame_format *format,
                   const void *codes, size_t bytes, unsigned n)
{
    struct ttf_frame frame = {
        .format = *format, .data = codes, .bytes = bytes, .settings = settings};

    assert_int_equal(ttf_raw_sum_init(sum, format), 0);
    for (unsigned i = 0; i < n; i++)
        assert_int_equal(ttf_raw_sum_add(sum, &frame), 0);
}

static void develop_all(const struct ttf_develop_config *config, const struct ttf_raw_sum *raw,
                        unsigned threads, struct ttf_pixbuf *ret,
                        struct ttf_image_figures *ret_figures)
{
    struct ttf_pool *pool = threads ? ttf_pool_create(threads) : NULL;
    struct ttf_develop *develop = NULL;
    struct ttf_err err = {0};

    if (ttf_develop_create(config, &develop, &err) < 0)
        fail_msg("%s", err.what);
    assert_int_equal(ttf_pixbuf_alloc(ret, ttf_develop_width(develop), ttf_develop_height(develop),
                                      3, TTF_SAMPLE_U16),
                     0);
    if (ttf_develop_run(develop, raw, pool, ret, ret_figures, &err) < 0)
        fail_msg("%s", err.what);
    ttf_develop_destroy(develop);
    ttf_pool_destroy(pool);
}

/* ---- the reference: one pixel at a time, in double, from the paper's figure ---- */

struct reference {
    const double *value; /* W x H corrected mosaic */
    uint32_t w, h;
    enum ttf_cfa cfa;
};

static int colour_at(enum ttf_cfa cfa, int x, int y)
{
    static const int patterns[TTF_CFA_COUNT][4] = {
        {0}, {0, 1, 1, 2}, {1, 0, 2, 1}, {1, 2, 0, 1}, {2, 1, 1, 0}};

    return patterns[cfa][(y & 1) * 2 + (x & 1)];
}

static double mosaic_at(const struct reference *ref, int x, int y)
{
    int w = (int)ref->w, h = (int)ref->h;

    x = x < 0 ? -x : x >= w ? 2 * (w - 1) - x : x;
    y = y < 0 ? -y : y >= h ? 2 * (h - 1) - y : y;
    return ref->value[y * w + x];
}

static double filtered(const struct reference *ref, int x, int y, const double kernel[5][5])
{
    double sum = 0.0;

    for (int j = 0; j < 5; j++) {
        for (int i = 0; i < 5; i++)
            sum += kernel[j][i] * mosaic_at(ref, x + i - 2, y + j - 2);
    }
    return sum / 8.0;
}

static double reference_at(const struct reference *ref, int x, int y, int colour)
{
    static const double green_at_other[5][5] = {
        {0, 0, -1, 0, 0}, {0, 0, 2, 0, 0}, {-1, 2, 4, 2, -1}, {0, 0, 2, 0, 0}, {0, 0, -1, 0, 0}};
    static const double along_row[5][5] = {{0, 0, 0.5, 0, 0},
                                           {0, -1, 0, -1, 0},
                                           {-1, 4, 5, 4, -1},
                                           {0, -1, 0, -1, 0},
                                           {0, 0, 0.5, 0, 0}};
    static const double along_column[5][5] = {{0, 0, -1, 0, 0},
                                              {0, -1, 4, -1, 0},
                                              {0.5, 0, 5, 0, 0.5},
                                              {0, -1, 4, -1, 0},
                                              {0, 0, -1, 0, 0}};
    static const double diagonal[5][5] = {{0, 0, -1.5, 0, 0},
                                          {0, 2, 0, 2, 0},
                                          {-1.5, 0, 6, 0, -1.5},
                                          {0, 2, 0, 2, 0},
                                          {0, 0, -1.5, 0, 0}};
    int here = colour_at(ref->cfa, x, y);

    if (here == colour)
        return mosaic_at(ref, x, y);
    if (colour == 1)
        return filtered(ref, x, y, green_at_other);
    if (here != 1)
        return filtered(ref, x, y, diagonal);
    return filtered(ref, x, y, colour_at(ref->cfa, x + 1, y) == colour ? along_row : along_column);
}

static int code_of(double value)
{
    double code = floor(value * TTF_SCALE + TTF_PEDESTAL + 0.5);

    return code < 0 ? 0 : code > 65535 ? 65535 : (int)code;
}

static void assert_near(int a, int b, int tolerance, int x, int y, int c)
{
    if (abs(a - b) > tolerance)
        fail_msg("at %d, %d, %d: %d is not %d", x, y, c, a, b);
}

/* All minimum, all maximum, noise, and a region at every parity. */
static void every_mosaic_and_parity_agrees_with_the_reference(void **state)
{
    static uint16_t codes[W * H];
    static double corrected[W * H];
    uint32_t seed = 7;

    for (int fill = 0; fill < 3; fill++) {
        for (int cfa = TTF_CFA_RGGB; cfa <= TTF_CFA_BGGR; cfa++) {
            struct ttf_frame_format format = bayer(W, H, (enum ttf_cfa)cfa);
            struct reference ref = {corrected, W, H, (enum ttf_cfa)cfa};
            struct ttf_raw_sum raw;

            for (int i = 0; i < W * H; i++) {
                codes[i] = fill == 0 ? 0 : fill == 1 ? 4095 : scratch_random(&seed) % 4096;
                corrected[i] = ((double)codes[i] - BLACK) / (WHITE - BLACK);
            }
            sum_of(&raw, &format, codes, sizeof(codes), 3);
            for (uint32_t shift = 0; shift < 4; shift++) {
                struct ttf_develop_config config = {
                    .format = format,
                    .encoding = encoding,
                    .region = {shift, shift / 2, W - 2 * shift, H - 5 * (shift / 2)}};
                struct ttf_pixbuf out;

                develop_all(&config, &raw, 0, &out, NULL);
                for (uint32_t y = 0; y < out.height; y++) {
                    const uint16_t *row = ttf_pixbuf_row(&out, y);

                    for (uint32_t x = 0; x < out.width; x++) {
                        for (int c = 0; c < 3; c++)
                            assert_near(row[3 * x + c],
                                        code_of(reference_at(&ref, (int)(x + shift),
                                                             (int)(y + shift / 2), c)),
                                        1, (int)x, (int)y, c);
                    }
                }
                ttf_pixbuf_free(&out);
            }
            ttf_raw_sum_free(&raw);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_mosaic_and_parity_agrees_with_the_reference),
    };

    return cmocka_run_group_tests_name("develop", tests, NULL, NULL);
}
