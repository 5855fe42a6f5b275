/* SPDX-License-Identifier: Apache-2.0 */
#include "jpeg_encoder.h"

#include <stdbool.h>

/*
 * One code for every category 0..16: two each of 2, 3 and 4 bits, then one each of
 * 5..15: an odd table, so that short and long codes occur.
 */
static const uint8_t counts[16] = {0, 2, 2, 2, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0};
static const uint8_t order[17] = {9, 3, 0, 12, 16, 1, 2, 4, 5, 6, 7, 8, 10, 11, 13, 14, 15};

struct writer {
    uint8_t *at;
    uint32_t bits;
    unsigned n;
};

static void put_byte(struct writer *w, unsigned byte)
{
    *w->at++ = (uint8_t)byte;
}

static void put_u16(struct writer *w, unsigned value)
{
    put_byte(w, value >> 8);
    put_byte(w, value & 255);
}

static void put_bits(struct writer *w, unsigned value, unsigned n)
{
    while (n-- > 0) {
        w->bits = w->bits << 1 | (value >> n & 1);
        if (++w->n == 8) {
            put_byte(w, w->bits & 255);
            if ((w->bits & 255) == 255)
                put_byte(w, 0);
            w->n = 0;
        }
    }
}

static void flush_bits(struct writer *w)
{
    while (w->n != 0)
        put_bits(w, 1, 1);
}

static void put_code(struct writer *w, unsigned category)
{
    unsigned code = 0, k = 0;

    for (unsigned length = 1; length <= 16; length++) {
        for (unsigned i = 0; i < counts[length - 1]; i++, k++, code++) {
            if (order[k] == category) {
                put_bits(w, code, length);
                return;
            }
        }
        code <<= 1;
    }
}

static void put_difference(struct writer *w, int d)
{
    unsigned category = 0, magnitude;

    d = (int)(int16_t)(uint16_t)d; /* modulo 2^16 */
    if (d == -32768) {
        put_code(w, 16);
        return;
    }
    for (magnitude = (unsigned)(d < 0 ? -d : d); magnitude > 0; magnitude >>= 1)
        category++;
    put_code(w, category);
    put_bits(w, (unsigned)(d < 0 ? d - 1 : d) & ((1u << category) - 1), category);
}

static void put_header(struct writer *w, const struct jpeg_encoding *e)
{
    put_u16(w, 0xffd8);
    put_u16(w, 0xffc4);
    put_u16(w, 2 + 17 + 17);
    put_byte(w, 0);
    for (int i = 0; i < 16; i++)
        put_byte(w, counts[i]);
    for (int i = 0; i < 17; i++)
        put_byte(w, order[i]);
    put_u16(w, 0xffc3);
    put_u16(w, 8 + 3 * e->components);
    put_byte(w, e->bits);
    put_u16(w, e->height);
    put_u16(w, e->width);
    put_byte(w, e->components);
    for (unsigned c = 0; c < e->components; c++) {
        put_byte(w, c + 1);
        put_byte(w, 0x11);
        put_byte(w, 0);
    }
    if (e->restart_rows) {
        put_u16(w, 0xffdd);
        put_u16(w, 4);
        put_u16(w, e->restart_rows * e->width);
    }
    put_u16(w, 0xffda);
    put_u16(w, 6 + 2 * e->components);
    put_byte(w, e->components);
    for (unsigned c = 0; c < e->components; c++) {
        put_byte(w, c + 1);
        put_byte(w, 0);
    }
    put_byte(w, e->predictor);
    put_u16(w, 0);
}

static int prediction(const struct jpeg_encoding *e, const uint16_t *at, size_t x, bool first)
{
    size_t k = e->components, stride = e->width * k;
    int a, b, c;

    if (first && x == 0)
        return 1 << (e->bits - 1);
    if (first)
        return at[-(ptrdiff_t)k];
    if (x == 0)
        return at[-(ptrdiff_t)stride];
    a = at[-(ptrdiff_t)k];
    b = at[-(ptrdiff_t)stride];
    c = at[-(ptrdiff_t)(stride + k)];
    switch (e->predictor) {
    case 1:
        return a;
    case 2:
        return b;
    case 3:
        return c;
    case 4:
        return a + b - c;
    case 5:
        return a + ((b - c) >> 1);
    case 6:
        return b + ((a - c) >> 1);
    default:
        return (a + b) >> 1;
    }
}

size_t jpeg_encode(const struct jpeg_encoding *e, const uint16_t *samples, uint8_t *ret)
{
    struct writer w = {.at = ret};
    size_t k = e->components;
    unsigned restarts = 0;

    put_header(&w, e);
    for (size_t y = 0; y < e->height; y++) {
        bool restart = e->restart_rows && y > 0 && y % e->restart_rows == 0;

        if (restart) {
            flush_bits(&w);
            put_u16(&w, 0xffd0 + restarts++ % 8);
        }
        for (size_t x = 0; x < e->width; x++) {
            for (size_t c = 0; c < k; c++) {
                const uint16_t *at = samples + (y * e->width + x) * k + c;

                put_difference(&w, *at - prediction(e, at, x, y == 0 || restart));
            }
        }
    }
    flush_bits(&w);
    put_u16(&w, 0xffd9);
    return (size_t)(w.at - ret);
}
