/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/map_rate.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DIGITS   TTF_MAP_RATE_DIGITS
#define RATE_MAX 1048576.0f /* rate_map.h */

/* Rows are lines of their own, which people do not read but may cut out; one that is as the one above is null. */
static void put_rate_row(struct ttf_json *json, const struct ttf_rate_map *rate, uint32_t y,
                         char *text)
{
    const float *row = rate->m + (size_t)y * rate->width;

    if (y > 0 && memcmp(row, row - rate->width, rate->width * sizeof(*row)) == 0) {
        ttf_json_null(json);
        return;
    }
    for (uint32_t x = 0; x < rate->width; x++) {
        uint32_t bits;

        memcpy(&bits, &row[x], sizeof(bits));
        (void)snprintf(text + (size_t)x * DIGITS, DIGITS + 1, "%08x", bits);
    }
    ttf_json_string(json, text);
}

void ttf_map_rate_put(struct ttf_json *json, const struct ttf_rate_map *rate)
{
    char *text = malloc((size_t)rate->width * DIGITS + 1);

    if (!text) {
        json->error = -ENOMEM;
        return;
    }
    ttf_json_key(json, "rate");
    ttf_json_array(json);
    for (uint32_t y = 0; y < rate->height; y++)
        put_rate_row(json, rate, y, text);
    ttf_json_array_end(json);
    free(text);
}

static int hex_digit(char c)
{
    if (c >= '0' && c <= '9')
        return c - '0';
    return c >= 'a' && c <= 'f' ? c - 'a' + 10 : -1;
}

/* The float of 8 digits; -1 if they are none or no rate. */
static float rate_of(const char *digits)
{
    uint32_t bits = 0;
    float rate;

    for (unsigned i = 0; i < DIGITS; i++) {
        int digit = hex_digit(digits[i]);

        if (digit < 0)
            return -1.0f;
        bits = bits << 4 | (uint32_t)digit;
    }
    memcpy(&rate, &bits, sizeof(rate));
    return rate >= 0.0f && rate <= RATE_MAX ? rate : -1.0f;
}

uint32_t ttf_map_rate_row(const char *text, uint32_t width, float *ret)
{
    for (uint32_t x = 0; x < width; x++) {
        ret[x] = rate_of(text + (size_t)x * DIGITS);
        if (ret[x] < 0.0f)
            return x;
    }
    return width;
}
