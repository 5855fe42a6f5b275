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

#include "pictures.h"

const struct ttf_encoding imported = {0.0, 65535.0};
const struct ttf_encoding captured = {TTF_PEDESTAL, TTF_SCALE};

struct pictures pictures_make(uint32_t width, uint32_t height, uint32_t n,
                              const struct ttf_encoding *encoding, value_fn *value, const void *ctx)
{
    struct pictures made = {0};
    uint16_t *at = malloc((size_t)n * height * width * 3 * sizeof(*at));

    assert_non_null(at);
    made.codes = at;
    for (uint32_t t = 0; t < n; t++) {
        for (uint32_t i = 0; i < width * height * 3; i++) {
            uint32_t x = i / 3 % width, y = i / 3 / width;
            double v = value(ctx, x, y, t, (int)(i % 3));
            long code = lround(v * encoding->scale + encoding->pedestal);

            *at++ = (uint16_t)(code < 0 ? 0 : code > 65535 ? 65535 : code);
        }
    }
    /* NOLINTNEXTLINE(clang-analyzer-unix.Malloc): pictures_free frees it; a failed assertion ends the test */
    assert_int_equal(
        ttf_sequence_of_memory(made.codes, width, height, n, encoding, &made.sequence, NULL), 0);
    return made;
}

void pictures_free(struct pictures *pictures)
{
    ttf_sequence_destroy(pictures->sequence);
    free(pictures->codes);
}

uint16_t *frame_of(struct ttf_sequence *sequence, uint32_t t)
{
    uint16_t *codes = malloc((size_t)sequence->width * sequence->height * 6);
    struct ttf_err err = {0};

    assert_non_null(codes);
    if (ttf_sequence_read_rows(sequence, t, 0, sequence->height, codes, &err) < 0)
        fail_msg("%s", err.what);
    return codes;
}

double mean_of(struct ttf_sequence *sequence, uint32_t t, uint32_t x0, uint32_t y0, uint32_t width,
               uint32_t height, int c)
{
    uint16_t *codes = frame_of(sequence, t);
    double sum = 0.0;

    for (uint32_t y = y0; y < y0 + height; y++) {
        for (uint32_t x = x0; x < x0 + width; x++)
            sum += codes[((size_t)y * sequence->width + x) * 3 + (size_t)c];
    }
    free(codes);
    return (sum / width / height - sequence->encoding.pedestal) / sequence->encoding.scale;
}

double mean_value(struct ttf_sequence *sequence, uint32_t t)
{
    return mean_of(sequence, t, 0, 0, sequence->width, sequence->height, 1);
}

double chance(uint32_t a, uint32_t b, uint32_t c)
{
    uint32_t x = a * 0x9e3779b1u ^ b * 0x85ebca77u ^ c * 0xc2b2ae3du;

    x ^= x >> 15;
    x *= 0x2c1b3c6du;
    x ^= x >> 12;
    x *= 0x297a2d39u;
    return (x ^ x >> 15) / 4294967296.0;
}

/* A cubic B-spline through random numbers: smooth to its second derivative wherever it is asked. */
double ground(double x, double y, unsigned key)
{
    const double cell = 3.0;
    double u = x / cell + 1000.0, v = y / cell + 1000.0, sum = 0.0, weights[2][4];
    uint32_t i = (uint32_t)u, j = (uint32_t)v;

    for (int axis = 0; axis < 2; axis++) {
        double f = axis ? v - j : u - i, g = 1.0 - f;

        weights[axis][0] = g * g * g / 6.0;
        weights[axis][1] = 2.0 / 3.0 - f * f * (1.0 - f / 2.0);
        weights[axis][2] = 2.0 / 3.0 - g * g * (1.0 - g / 2.0);
        weights[axis][3] = f * f * f / 6.0;
    }
    for (uint32_t k = 0; k < 16; k++)
        sum += weights[0][k % 4] * weights[1][k / 4] * chance(i + k % 4, j + k / 4, key);
    return 0.5 + 1.5 * (sum - 0.5);
}

void assert_same_frames(struct ttf_sequence *a, struct ttf_sequence *b)
{
    size_t bytes = (size_t)a->width * a->height * 6;

    assert_true(a->width == b->width && a->height == b->height && a->n == b->n);
    for (uint32_t t = 0; t < a->n; t++) {
        uint16_t *one = frame_of(a, t), *other = frame_of(b, t);

        assert_memory_equal(one, other, bytes);
        free(one);
        free(other);
    }
}

void assert_reads_by_rows(struct ttf_sequence *sequence)
{
    size_t row = (size_t)sequence->width * 3;
    uint16_t *rows = malloc(3 * row * sizeof(*rows));
    struct ttf_err err = {0};

    assert_non_null(rows);
    for (uint32_t t = 0; t < sequence->n; t++) {
        uint16_t *whole = frame_of(sequence, t);

        for (uint32_t y = 0; y + 3 <= sequence->height; y += 2) {
            assert_int_equal(ttf_sequence_read_rows(sequence, t, y, 3, rows, NULL), 0);
            assert_memory_equal(rows, whole + y * row, 3 * row * sizeof(*rows));
        }
        free(whole);
    }
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, sequence->height, 0, rows, NULL), 0);
    assert_int_equal(ttf_sequence_read_rows(sequence, 0, sequence->height, 1, rows, &err), -EINVAL);
    assert_int_equal(ttf_sequence_read_rows(sequence, sequence->n, 0, 1, rows, &err), -EINVAL);
    assert_true(err.what[0] != '\0');
    free(rows);
}

static int broken_read(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                       uint16_t *dst, struct ttf_err *err)
{
    for (uint32_t i = 0; i < rows * sequence->width * 3; i++)
        dst[i] = (uint16_t)(30000.0 * chance(i, y0, 4) + 10000.0);
    return *sequence->index <= (int64_t)t ? ttf_err_set(err, -EIO, "frame", "cannot be read") : 0;
}

struct ttf_sequence unreadable_from(uint32_t broken, uint32_t n)
{
    static const struct ttf_sequence_ops ops = {.read_rows = broken_read};
    static const int64_t from[64] = {0,  1,  2,  3,  4,  5,  6,  7,  8,  9,  10,
                                     11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21};

    return (struct ttf_sequence){.ops = &ops,
                                 .width = 40,
                                 .height = 36,
                                 .n = n,
                                 .encoding = imported,
                                 .index = from + broken,
                                 .time_ns = from};
}
