/* SPDX-License-Identifier: Apache-2.0 */
#include "develop_strip.h"

#include <string.h>

/* Corrected rows of the frame around a strip, DEVELOP_MARGIN more on each side where the frame has them. */
struct buffer {
    float *data;
    size_t stride;       /* floats */
    int64_t x0, y0;      /* frame coordinates of data[0] */
    int64_t left, right; /* frame columns that are filled: [left, right) */
    int64_t top, bottom;
};

static size_t buffer_stride(const struct ttf_develop *develop)
{
    return ((size_t)develop->config.region.width + 2 * DEVELOP_MARGIN) * develop->samples;
}

size_t develop_scratch(const struct ttf_develop *develop)
{
    return buffer_stride(develop) * (STRIP_ROWS + 2 * DEVELOP_MARGIN) +
           3 * (size_t)develop->config.region.width;
}

static float *at(const struct buffer *buffer, int64_t x, int64_t y)
{
    return buffer->data + (size_t)(y - buffer->y0) * buffer->stride + (size_t)(x - buffer->x0);
}

static int64_t clip(int64_t value, int64_t low, int64_t high)
{
    if (value < low)
        return low;
    return value > high ? high : value;
}

/* Lays out a buffer for n rows from frame row y, and corrects what the frame has of it. */
static void fill(const struct develop_run *run, int64_t y, uint32_t n, struct buffer *buffer)
{
    const struct ttf_develop *develop = run->develop;
    const struct ttf_region *region = &develop->config.region;
    const struct ttf_calibration *calibration = develop->config.calibration;
    int64_t width = develop->config.format.width, height = develop->config.format.height;

    buffer->x0 = (int64_t)region->x - DEVELOP_MARGIN;
    buffer->y0 = y - DEVELOP_MARGIN;
    buffer->left = clip(buffer->x0, 0, width);
    buffer->right = clip((int64_t)region->x + region->width + DEVELOP_MARGIN, 0, width);
    buffer->top = clip(buffer->y0, 0, height);
    buffer->bottom = clip(y + n + DEVELOP_MARGIN, 0, height);
    for (int64_t row = buffer->top; row < buffer->bottom; row++) {
        size_t from = (size_t)(row * width + buffer->left);
        bool dark = calibration && calibration->has_dark,
             flat = calibration && calibration->has_flat;

        develop_correct(run->raw->sum + from, dark ? calibration->dark_offset_16 + from : NULL,
                        flat ? calibration->flat_gain + from : NULL,
                        (size_t)(buffer->right - buffer->left), run->mean, run->black, run->level,
                        at(buffer, buffer->left, row));
    }
}

/* ---- pixels not to be believed ---- */

/* Index of the first listed pixel at or after x, y. */
static unsigned hot_from(const struct ttf_calibration *calibration, int64_t x, int64_t y)
{
    unsigned low = 0, high = calibration->n_hot;

    while (low < high) {
        unsigned middle = low + (high - low) / 2;
        const struct ttf_hot_pixel *hot = &calibration->hot[middle];

        if (hot->y < y || (hot->y == y && hot->x < x))
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static bool is_hot(const struct ttf_calibration *calibration, int64_t x, int64_t y)
{
    unsigned i = hot_from(calibration, x, y);

    return i < calibration->n_hot && calibration->hot[i].x == x && calibration->hot[i].y == y;
}

static bool inside(const struct buffer *buffer, int64_t x, int64_t y)
{
    return x >= buffer->left && x < buffer->right && y >= buffer->top && y < buffer->bottom;
}

/* Median of the believed ones of the eight nearest pixels of the same colour; 0 if there is none. */
static float neighbours_median(const struct ttf_calibration *calibration,
                               const struct buffer *buffer, int64_t x, int64_t y, int step)
{
    float values[8];
    int n = 0;

    for (int dy = -step; dy <= step; dy += step) {
        for (int dx = -step; dx <= step; dx += step) {
            float value;
            int i;

            if (!inside(buffer, x + dx, y + dy) || is_hot(calibration, x + dx, y + dy))
                continue;
            value = *at(buffer, x + dx, y + dy);
            for (i = n++; i > 0 && values[i - 1] > value; i--)
                values[i] = values[i - 1];
            values[i] = value;
        }
    }
    if (n == 0)
        return 0.0f;
    return n % 2 ? values[n / 2] : 0.5f * (values[n / 2 - 1] + values[n / 2]);
}

/*
 * From pixels that are on no list alone: so the outcome depends neither on the
 * order nor on where a strip ends. The outermost rows and columns only lend their
 * values; what becomes of listed pixels there is not looked at.
 */
static void replace_hot(const struct develop_run *run, const struct buffer *buffer)
{
    const struct ttf_calibration *calibration = run->develop->config.calibration;
    int step = run->develop->config.format.cfa == TTF_CFA_NONE ? 1 : 2;

    if (!calibration || calibration->n_hot == 0)
        return;
    for (unsigned i = hot_from(calibration, 0, buffer->top); i < calibration->n_hot; i++) {
        const struct ttf_hot_pixel *hot = &calibration->hot[i];

        if (hot->y >= buffer->bottom)
            break;
        if (inside(buffer, hot->x, hot->y))
            *at(buffer, hot->x, hot->y) =
                neighbours_median(calibration, buffer, hot->x, hot->y, step);
    }
}

/* ---- beyond the frame's edge: mirrored about the outermost pixel, which keeps the mosaic's colours ---- */

static void mirror(const struct develop_run *run, const struct buffer *buffer, uint32_t rows)
{
    int64_t width = run->develop->config.format.width;
    int64_t height = run->develop->config.format.height;
    size_t n = buffer->stride;

    for (int64_t y = buffer->top; y < buffer->bottom; y++) {
        for (int64_t k = 1; k <= DEVELOP_REACH; k++) {
            if (buffer->x0 <= -k)
                *at(buffer, -k, y) = *at(buffer, k, y);
            if (buffer->right == width && width - 1 + k < buffer->x0 + (int64_t)buffer->stride)
                *at(buffer, width - 1 + k, y) = *at(buffer, width - 1 - k, y);
        }
    }
    for (int64_t k = 1; k <= DEVELOP_REACH; k++) {
        if (buffer->y0 <= -k)
            memcpy(at(buffer, buffer->x0, -k), at(buffer, buffer->x0, k), n * sizeof(float));
        if (buffer->bottom == height && height - 1 + k < buffer->y0 + rows + 2 * DEVELOP_MARGIN)
            memcpy(at(buffer, buffer->x0, height - 1 + k), at(buffer, buffer->x0, height - 1 - k),
                   n * sizeof(float));
    }
}

/* ---- rows ---- */

struct planes {
    float *r, *g, *b;
};

static void finish_row(const struct ttf_develop *develop, const struct planes *planes,
                       uint16_t *dst)
{
    size_t n = develop->config.region.width;

    if (develop->has_matrix)
        develop_matrix(develop->matrix, planes->r, planes->g, planes->b, n);
    develop_encode(planes->r, planes->g, planes->b, n, (float)develop->config.encoding.scale,
                   (float)develop->config.encoding.pedestal, dst);
}

static void mosaic_row(const struct ttf_develop *develop, const struct buffer *buffer, int64_t y,
                       const struct planes *planes, uint16_t *dst)
{
    enum ttf_cfa cfa = develop->config.format.cfa;
    int64_t x = develop->config.region.x;
    bool red_row = (y % 2 == 0) == (cfa == TTF_CFA_RGGB || cfa == TTF_CFA_GRBG);
    /* Whether a red row begins with red, and so a blue one with green. */
    bool red_first = cfa == TTF_CFA_RGGB || cfa == TTF_CFA_GBRG;
    bool own_first = (red_row ? red_first : !red_first) == (x % 2 == 0);
    struct develop_window window;

    for (int i = 0; i < 5; i++)
        window.row[i] = at(buffer, x, y + i - 2);
    if (red_row)
        develop_demosaic(&window, own_first, develop->config.region.width, planes->r, planes->g,
                         planes->b);
    else
        develop_demosaic(&window, own_first, develop->config.region.width, planes->b, planes->g,
                         planes->r);
    finish_row(develop, planes, dst);
}

static void plain_row(const struct ttf_develop *develop, const float *row,
                      const struct planes *planes, uint16_t *dst)
{
    size_t k = develop->samples, n = develop->config.region.width;

    for (size_t x = 0; x < n; x++) {
        planes->r[x] = row[x * k];
        planes->g[x] = row[x * k + (k > 1 ? 1 : 0)];
        planes->b[x] = row[x * k + (k > 1 ? 2 : 0)];
    }
    finish_row(develop, planes, dst);
}

static uint64_t count_saturated(const struct develop_run *run, int64_t y)
{
    const struct ttf_develop *develop = run->develop;
    size_t k = develop->samples, n = develop->config.region.width * k;
    const uint32_t *row =
        run->raw->sum + ((size_t)y * develop->config.format.width + develop->config.region.x) * k;
    uint32_t limit = (uint32_t)develop->white * run->raw->n;
    uint32_t count = 0;

    for (size_t i = 0; i < n; i++)
        count += row[i] >= limit ? 1 : 0;
    return count;
}

uint64_t develop_strip(const struct develop_run *run, uint32_t y0, uint32_t n, float *scratch,
                       uint16_t *dst, size_t stride)
{
    const struct ttf_develop *develop = run->develop;
    const struct ttf_region *region = &develop->config.region;
    struct buffer buffer = {.data = scratch, .stride = buffer_stride(develop)};
    float *after = scratch + buffer.stride * (STRIP_ROWS + 2 * DEVELOP_MARGIN);
    struct planes planes = {after, after + region->width, after + 2 * (size_t)region->width};
    bool mosaic = develop->config.format.cfa != TTF_CFA_NONE && develop->samples == 1;
    int64_t top = (int64_t)region->y + y0;
    uint64_t saturated = 0;

    if (develop->samples == 1) {
        fill(run, top, n, &buffer);
        replace_hot(run, &buffer);
        if (mosaic)
            mirror(run, &buffer, n);
    }
    for (uint32_t i = 0; i < n; i++) {
        uint16_t *to = (uint16_t *)((char *)dst + (size_t)i * stride);
        int64_t y = top + i;

        saturated += count_saturated(run, y);
        if (mosaic) {
            mosaic_row(develop, &buffer, y, &planes, to);
        } else if (develop->samples == 1) {
            plain_row(develop, at(&buffer, region->x, y), &planes, to);
        } else {
            size_t from = ((size_t)y * develop->config.format.width + region->x) * 3;

            develop_correct(run->raw->sum + from, NULL, NULL, (size_t)region->width * 3, run->mean,
                            run->black, run->level, buffer.data);
            plain_row(develop, buffer.data, &planes, to);
        }
    }
    return saturated;
}
