/* SPDX-License-Identifier: Apache-2.0 */
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
    uint8_t table[65536];
    uint8_t *previous; /* display codes of the last frame */
    /* sums over cells of the last two frames: strips x cells_x x 3 */
    uint16_t *cells[2];
    uint32_t *pixel_sums; /* per pixel, over channels and time; NULL unless asked for */
    struct strip *sums;
    const uint16_t *frame; /* of the running add */
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
    a->sums = calloc(a->strips, sizeof(*a->sums));
    if (!a->previous || !a->cells[0] || !a->cells[1] || !a->sums)
        goto fail;
    ttf_display8_table(encoding, a->table);
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
    free(activity->previous);
    free(activity->cells[0]);
    free(activity->cells[1]);
    free(activity->pixel_sums);
    free(activity->sums);
    free(activity);
}

static unsigned absolute(int x)
{
    return (unsigned)(x < 0 ? -x : x);
}

/* Encodes one row and compares it to the same row of the frame before. */
static void add_row(struct ttf_activity *a, uint32_t y, struct strip *sums)
{
    size_t at = (size_t)y * a->width * 3;
    const uint16_t *codes = a->frame + at;
    uint8_t *previous = a->previous + at;
    uint32_t *pixels = a->pixel_sums ? a->pixel_sums + (size_t)y * a->width : NULL;
    uint32_t first = a->frames == 0;

    for (size_t x = 0; x < a->width; x++, codes += 3, previous += 3) {
        unsigned difference = 0;

        for (int c = 0; c < 3; c++) {
            uint8_t now = a->table[codes[c]];

            difference += absolute(now - previous[c]);
            sums->rgb[c] += now;
            previous[c] = now;
        }
        difference = first ? 0 : difference;
        sums->difference += difference;
        if (pixels)
            pixels[x] += difference;
    }
}

/* previous[] holds this frame by now: its cells' sums, and their second difference in time. */
static void add_cells(struct ttf_activity *a, uint32_t strip, struct strip *sums)
{
    uint16_t *last = a->cells[0] + (size_t)strip * a->cells_x * 3;
    uint16_t *before = a->cells[1] + (size_t)strip * a->cells_x * 3;
    size_t row = (size_t)a->width * 3;
    const uint8_t *codes = a->previous + (size_t)strip * CELL * row;

    for (size_t i = 0; i < (size_t)a->cells_x * 3; i++) {
        const uint8_t *corner = codes + i / 3 * 3 * CELL + i % 3;
        int sum = 0;

        for (size_t y = 0; y < CELL; y++) {
            for (size_t x = 0; x < CELL; x++)
                sum += corner[y * row + 3 * x];
        }
        if (a->frames >= 2)
            sums->second += absolute(sum - 2 * last[i] + before[i]);
        before[i] = last[i];
        last[i] = (uint16_t)sum;
    }
}

static void add_strip(void *ctx, unsigned strip, unsigned worker)
{
    struct ttf_activity *a = ctx;
    struct strip *sums = &a->sums[strip];
    uint32_t y0 = strip * CELL;
    uint32_t y1 = y0 + CELL < a->height ? y0 + CELL : a->height;

    (void)worker;
    if (a->frames == 0)
        memset(a->previous + (size_t)y0 * a->width * 3, 0, (size_t)(y1 - y0) * a->width * 3);
    for (uint32_t y = y0; y < y1; y++)
        add_row(a, y, sums);
    if (y1 - y0 == CELL)
        add_cells(a, strip, sums);
}

void ttf_activity_add(struct ttf_activity *activity, struct ttf_pool *pool, const uint16_t *frame)
{
    activity->frame = frame;
    ttf_pool_run(pool, activity->strips, add_strip, activity);
    activity->frame = NULL;
    activity->frames++;
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
