/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "made.h"

struct ttf_pixbuf made_grey(uint32_t width, uint32_t height, made_fn *value)
{
    struct ttf_pixbuf buf = {0};

    assert_int_equal(ttf_pixbuf_alloc(&buf, width, height, 1, TTF_SAMPLE_F32), 0);
    for (uint32_t y = 0; y < height; y++) {
        float *row = ttf_pixbuf_row(&buf, y);

        for (uint32_t x = 0; x < width; x++)
            row[x] = (float)value((x + 0.5) / width, (y + 0.5) / width);
    }
    return buf;
}

struct ttf_pixbuf made_plain(uint32_t width, uint32_t height, double r, double g, double b)
{
    struct ttf_pixbuf buf = {0};

    assert_int_equal(ttf_pixbuf_alloc(&buf, width, height, 3, TTF_SAMPLE_F32), 0);
    for (uint32_t y = 0; y < height; y++) {
        float *row = ttf_pixbuf_row(&buf, y);

        for (uint32_t x = 0; x < width; x++) {
            row[3 * x] = (float)r;
            row[3 * x + 1] = (float)g;
            row[3 * x + 2] = (float)b;
        }
    }
    return buf;
}

float made_at(const struct ttf_rate_map *map, uint32_t x, uint32_t y)
{
    assert_true(x < map->width && y < map->height);
    return map->m[(size_t)y * map->width + x];
}

void made_refused(int got, int code, const char *where, const struct ttf_err *err,
                  const struct ttf_rate_map *untouched)
{
    assert_int_equal(got, code);
    assert_int_equal(err->code, code);
    assert_string_equal(err->where, where);
    assert_true(err->what[0] != '\0');
    assert_null(untouched->m);
    assert_int_equal(untouched->width, 0);
}
