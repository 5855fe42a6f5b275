/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "metrics/activity.h"
#include "ttf/base/checked.h"
#include "ttf/synth/metrics.h"

#define CELL 4 /* side of the box averages; also the rows of a tile */

/* Sums of one strip of CELL rows: added up in order of strips, though integers would not mind. */
struct strip {
    uint64_t difference, second, rgb[3];
};

struct ttf_activity {
    uint32_t width, height;
    uint32_t strips;
    uint32_t cells_x; /* whole cells in a row; what is left over at the edges does not count */
    uint32_t frames;
    struct ttf_encoding encoding;
    uint8_t *table;    /* of 16-bit codes; NULL: none came yet */
    uint8_t *own;      /* the running frame in display codes, where 16-bit ones came */
    uint8_t *previous; /* display codes of the last frame */
    /* sums over cells: of the last frame, the one before, and the running one: strips x cells_x x 3 */
    uint16_t *cells[3];
    uint32_t *pixel_sums; /* per pixel, over channels and time; NULL unless asked for */
    struct strip *sums;
    const uint16_t *wide; /* of the running add; or NULL */
    const uint8_t *frame;
};

struct ttf_activity *ttf_activity_create(uint32_t width, uint32_t height,
                                         const struct ttf_encoding *encoding)
{
    struct ttf_activity *a = calloc(1, sizeof(*a));
    size_t samples, cells;

    if (!a)
        return NULL;
    a->width = width;
    a->height = height;
    a->strips = (height + CELL - 1) / CELL;
    a->cells_x = width / CELL;
    cells = (size_t)a->strips * a->cells_x * 3 + 1;
    if (width == 0 || height == 0 || !ttf_mul_size((size_t)width * height, 3, &samples))
        goto fail;
    a->previous = malloc(samples);
    a->cells[0] = calloc(cells, sizeof(uint16_t));
    a->cells[1] = calloc(cells, sizeof(uint16_t));
    a->cells[2] = calloc(cells, sizeof(uint16_t));
    a->sums = calloc(a->strips, sizeof(*a->sums));
    if (!a->previous || !a->cells[0] || !a->cells[1] || !a->cells[2] || !a->sums)
        goto fail;
    a->encoding = *encoding;
    return a;

fail:
    ttf_activity_destroy(a);
    return NULL;
}

int ttf_activity_keep_pixels(struct ttf_activity *activity)
{
    activity->pixel_sums =
        calloc((size_t)activity->width * activity->height, sizeof(*activity->pixel_sums));
    return activity->pixel_sums ? 0 : -1;
}

const uint32_t *ttf_activity_pixels(const struct ttf_activity *activity)
{
    return activity->pixel_sums;
}

void ttf_activity_destroy(struct ttf_activity *activity)
{
    if (!activity)
        return;
    free(activity->table);
    free(activity->own);
    free(activity->previous);
    free(activity->cells[0]);
    free(activity->cells[1]);
    free(activity->cells[2]);
    free(activity->pixel_sums);
    free(activity->sums);
    free(activity);
}

static unsigned absolute(int x)
{
    return (unsigned)(x < 0 ? -x : x);
}

/* Sum of absolute differences; left to the compiler's vectorizer. */
static uint64_t difference_of(const uint8_t *a, const uint8_t *b, size_t n)
{
    uint64_t sum = 0;

    while (n > 0) {
        size_t part = n < 4096 ? n : 4096; /* 4096 x 255 fits 32 bits */
        uint32_t own = 0;

        for (size_t i = 0; i < part; i++)
            own += absolute(a[i] - b[i]);
        sum += own;
        a += part;
        b += part;
        n -= part;
    }
    return sum;
}

/* Sums of the three channels of a row; the inner loop is over whole groups of pixels. */
static void add_colours(const uint8_t *codes, size_t pixels, uint64_t rgb[3])
{
    uint32_t sums[48] = {0};
    size_t i = 0;

    for (; i + 48 <= 3 * pixels; i += 48) {
        for (int k = 0; k < 48; k++)
            sums[k] += codes[i + (size_t)k];
    }
    for (; i < 3 * pixels; i++)
        sums[i % 48] += codes[i];
    for (int k = 0; k < 48; k++)
        rgb[k % 3] += sums[k];
}

/* Compares one row to the same row of the frame before. */
static void add_row(struct ttf_activity *a, uint32_t y, struct strip *sums)
{
    size_t samples = (size_t)a->width * 3, at = (size_t)y * samples;
    const uint8_t *codes = a->frame + at, *previous = a->previous + at;
    uint32_t *pixels = a->pixel_sums ? a->pixel_sums + (size_t)y * a->width : NULL;

    add_colours(codes, a->width, sums->rgb);
    if (a->frames == 0)
        return;
    sums->difference += difference_of(codes, previous, samples);
    for (size_t x = 0; pixels && x < a->width; x++) {
        for (size_t c = 0; c < 3; c++)
            pixels[x] += absolute(codes[3 * x + c] - previous[3 * x + c]);
    }
}

/* Sums of one row of cells, added down four rows and then along them. */
static void cell_sums(const uint8_t *codes, size_t row, size_t cells, uint16_t *ret)
{
    for (size_t i = 0; i < cells * CELL; i++) {
        for (size_t c = 0; c < 3; c++) {
            const uint8_t *at = codes + 3 * i + c;
            uint16_t *to = &ret[i / CELL * 3 + c];
            int sum = at[0] + at[row] + at[2 * row] + at[3 * row];

            *to = (uint16_t)((i % CELL == 0 ? 0 : *to) + sum);
        }
    }
}

/* This frame's cells' sums, and their second difference in time. */
static void add_cells(struct ttf_activity *a, uint32_t strip, struct strip *sums)
{
    size_t n = (size_t)a->cells_x * 3, row = (size_t)a->width * 3;
    uint16_t *last = a->cells[0] + (size_t)strip * n;
    uint16_t *before = a->cells[1] + (size_t)strip * n;
    uint16_t *now = a->cells[2] + (size_t)strip * n;
    uint64_t second = 0;

    cell_sums(a->frame + (size_t)strip * CELL * row, row, a->cells_x, now);
    for (size_t i = 0; a->frames >= 2 && i < n; i++)
        second += absolute(now[i] - 2 * last[i] + before[i]);
    sums->second += second;
    memcpy(before, last, n * sizeof(*before));
    memcpy(last, now, n * sizeof(*last));
}

static void add_strip(void *ctx, unsigned strip, unsigned worker)
{
    struct ttf_activity *a = ctx;
    struct strip *sums = &a->sums[strip];
    uint32_t y0 = strip * CELL;
    uint32_t y1 = y0 + CELL < a->height ? y0 + CELL : a->height;
    size_t from = (size_t)y0 * a->width * 3, to = (size_t)y1 * a->width * 3;

    (void)worker;
    for (size_t i = from; a->wide && i < to; i++)
        a->own[i] = a->table[a->wide[i]];
    for (uint32_t y = y0; y < y1; y++)
        add_row(a, y, sums);
    if (y1 - y0 == CELL)
        add_cells(a, strip, sums);
    memcpy(a->previous + from, a->frame + from, to - from);
}

static void add(struct ttf_activity *activity, struct ttf_pool *pool)
{
    ttf_pool_run(pool, activity->strips, add_strip, activity);
    activity->frame = NULL;
    activity->wide = NULL;
    activity->frames++;
}

void ttf_activity_add8(struct ttf_activity *activity, struct ttf_pool *pool, const uint8_t *frame)
{
    activity->frame = frame;
    add(activity, pool);
}

int ttf_activity_add(struct ttf_activity *activity, struct ttf_pool *pool, const uint16_t *frame)
{
    if (!activity->table) {
        activity->table = malloc(65536);
        activity->own = malloc((size_t)activity->width * activity->height * 3);
        if (!activity->table || !activity->own) {
            free(activity->table);
            free(activity->own);
            activity->table = activity->own = NULL;
            return -ENOMEM;
        }
        ttf_display8_table(&activity->encoding, activity->table);
    }
    activity->wide = frame;
    activity->frame = activity->own;
    add(activity, pool);
    return 0;
}

void ttf_activity_figures(const struct ttf_activity *activity, struct ttf_activity_figures *ret)
{
    double samples = 3.0 * activity->width * activity->height;
    double cells = 3.0 * ((uint64_t)activity->cells_x * (uint64_t)(activity->height / CELL));
    struct strip all = {0};

    *ret = (struct ttf_activity_figures){.frames = activity->frames};
    for (uint32_t i = 0; i < activity->strips; i++) {
        all.difference += activity->sums[i].difference;
        all.second += activity->sums[i].second;
        for (int c = 0; c < 3; c++)
            all.rgb[c] += activity->sums[i].rgb[c];
    }
    if (activity->frames >= 2)
        ret->mean_difference = (double)all.difference / (samples * (activity->frames - 1));
    if (activity->frames >= 3 && cells > 0.0)
        ret->second_difference =
            (double)all.second / (CELL * CELL) / (cells * (activity->frames - 2));
    for (int c = 0; c < 3 && activity->frames > 0; c++)
        ret->mean_rgb[c] = (double)all.rgb[c] * 3.0 / (samples * activity->frames);
}
