/* SPDX-License-Identifier: Apache-2.0 */
#include "control/mask.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

enum {
    OUT = 0,
    IN = 1,
    SEEN_IN, /* of a component that was measured */
    SEEN_OUT /* reached from the border */
};

/* Flooding visits a pixel once, so a stack of all pixels is enough. */
struct flood {
    struct ttf_mask *mask;
    size_t *stack;
    size_t n;
};

static int flood_init(struct flood *flood, struct ttf_mask *mask)
{
    *flood = (struct flood){.mask = mask};
    if (mask->width == 0 || mask->height == 0)
        return -EINVAL;
    flood->stack = malloc((size_t)mask->width * mask->height * sizeof(*flood->stack));
    return flood->stack ? 0 : -ENOMEM;
}

static void push_if(struct flood *flood, uint32_t x, uint32_t y, uint8_t from, uint8_t to)
{
    size_t i = (size_t)y * flood->mask->width + x;

    if (flood->mask->at[i] != from)
        return;
    flood->mask->at[i] = to;
    flood->stack[flood->n++] = i;
}

/* Turns all that touches the pixel from one value into another; returns how many those are. */
static size_t flood_from(struct flood *flood, uint32_t x, uint32_t y, uint8_t from, uint8_t to,
                         bool corners)
{
    uint32_t width = flood->mask->width, height = flood->mask->height;
    size_t count = 0;

    push_if(flood, x, y, from, to);
    for (; flood->n > 0; count++) {
        size_t i = flood->stack[--flood->n];
        uint32_t px = (uint32_t)(i % width), py = (uint32_t)(i / width);
        uint32_t x0 = px > 0 ? px - 1 : px, x1 = px + 1 < width ? px + 1 : px;
        uint32_t y0 = py > 0 ? py - 1 : py, y1 = py + 1 < height ? py + 1 : py;

        for (uint32_t qy = y0; qy <= y1; qy++) {
            for (uint32_t qx = x0; qx <= x1; qx++) {
                if (corners || qx == px || qy == py)
                    push_if(flood, qx, qy, from, to);
            }
        }
    }
    return count;
}

int ttf_mask_keep_largest(struct ttf_mask *mask, size_t *ret_pixels)
{
    size_t n = (size_t)mask->width * mask->height, largest = 0, first = 0;
    struct flood flood;
    int r = flood_init(&flood, mask);

    if (r < 0)
        return r;
    for (size_t i = 0; i < n; i++) {
        size_t count = flood_from(&flood, (uint32_t)(i % mask->width), (uint32_t)(i / mask->width),
                                  IN, SEEN_IN, true);

        if (count > largest) {
            largest = count;
            first = i;
        }
    }
    if (largest > 0)
        flood_from(&flood, (uint32_t)(first % mask->width), (uint32_t)(first / mask->width),
                   SEEN_IN, IN, true);
    for (size_t i = 0; i < n; i++)
        mask->at[i] = mask->at[i] == IN;
    free(flood.stack);
    *ret_pixels = largest;
    return 0;
}

int ttf_mask_fill_holes(struct ttf_mask *mask, size_t *ret_pixels)
{
    uint32_t right = mask->width - 1, bottom = mask->height - 1;
    size_t n = (size_t)mask->width * mask->height, pixels = 0;
    struct flood flood;
    int r = flood_init(&flood, mask);

    if (r < 0)
        return r;
    for (uint32_t x = 0; x <= right; x++) {
        flood_from(&flood, x, 0, OUT, SEEN_OUT, false);
        flood_from(&flood, x, bottom, OUT, SEEN_OUT, false);
    }
    for (uint32_t y = 0; y <= bottom; y++) {
        flood_from(&flood, 0, y, OUT, SEEN_OUT, false);
        flood_from(&flood, right, y, OUT, SEEN_OUT, false);
    }
    for (size_t i = 0; i < n; i++) {
        mask->at[i] = mask->at[i] != SEEN_OUT;
        pixels += mask->at[i];
    }
    free(flood.stack);
    *ret_pixels = pixels;
    return 0;
}

/* Along one line, n pixels `step` apart: becomes `value` within px of where it is so. */
static void spread_line(uint8_t *at, uint32_t n, size_t step, uint32_t px, uint8_t value,
                        uint8_t *line)
{
    for (uint32_t i = 0; i < n; i++)
        line[i] = at[i * step];
    for (uint32_t i = 0, until = 0; i < n; i++) {
        until = line[i] == value ? i + px + 1 : until;
        if (i < until)
            at[i * step] = value;
    }
    for (uint32_t i = n, since = n; i-- > 0;) {
        if (line[i] == value)
            since = i > px ? i - px : 0;
        if (i >= since)
            at[i * step] = value;
    }
}

int ttf_mask_grow(struct ttf_mask *mask, int px)
{
    uint32_t side = mask->width > mask->height ? mask->width : mask->height;
    uint8_t value = px > 0 ? IN : OUT;
    uint32_t distance = (uint32_t)abs(px);
    uint8_t *line;

    if (mask->width == 0 || mask->height == 0)
        return -EINVAL;
    line = malloc((size_t)side + 1);
    if (!line)
        return -ENOMEM;
    for (uint32_t y = 0; y < mask->height; y++)
        spread_line(mask->at + (size_t)y * mask->width, mask->width, 1, distance, value, line);
    for (uint32_t x = 0; x < mask->width; x++)
        spread_line(mask->at + x, mask->height, mask->width, distance, value, line);
    free(line);
    return 0;
}

int ttf_mask_close(struct ttf_mask *mask, unsigned px)
{
    struct ttf_mask padded = {mask->width + 2 * px, mask->height + 2 * px, NULL};
    size_t start;
    int r;

    padded.at = calloc((size_t)padded.width * padded.height, 1);
    if (!padded.at)
        return -ENOMEM;
    start = (size_t)px * padded.width + px;
    for (uint32_t y = 0; y < mask->height; y++)
        memcpy(padded.at + start + (size_t)y * padded.width, mask->at + (size_t)y * mask->width,
               mask->width);
    r = ttf_mask_grow(&padded, (int)px);
    if (r == 0)
        r = ttf_mask_grow(&padded, -(int)px);
    for (uint32_t y = 0; y < mask->height && r == 0; y++)
        memcpy(mask->at + (size_t)y * mask->width, padded.at + start + (size_t)y * padded.width,
               mask->width);
    free(padded.at);
    return r;
}
