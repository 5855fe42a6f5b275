/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Resampling, one axis after the other, in plain float. Shrinking averages over
 * the area that an output pixel covers; enlarging interpolates between centres.
 */
#include <errno.h>
#include <stdlib.h>

#include "ttf/base/checked.h"
#include "ttf/dataset/pixbuf.h"

/* Weights of one output position: taps first..first+n-1 of the source. */
struct span {
    uint32_t first, n;
    size_t weight; /* index of its first weight */
};

struct axis {
    struct span *spans;
    float *weights;
};

static void axis_free(struct axis *axis)
{
    free(axis->spans);
    free(axis->weights);
}

/* Output pixel i covers [i * src / dst, (i + 1) * src / dst) of the source, in exact fractions of 1/dst. */
static size_t shrink_span(struct span *span, float *weights, size_t used, uint64_t i, uint64_t src,
                          uint64_t dst)
{
    uint64_t from = i * src, to = from + src; /* in units of 1/dst source pixel */
    uint64_t last = (to - 1) / dst;

    span->first = (uint32_t)(from / dst);
    span->n = (uint32_t)(last - span->first + 1);
    span->weight = used;
    for (uint64_t p = span->first; p <= last; p++) {
        uint64_t a = p * dst > from ? p * dst : from;
        uint64_t b = (p + 1) * dst < to ? (p + 1) * dst : to;

        weights[used++] = (float)((double)(b - a) / (double)src);
    }
    return used;
}

/* Output centre (i + 1/2) * src / dst - 1/2, held at the edges. */
static size_t enlarge_span(struct span *span, float *weights, size_t used, uint32_t i, uint32_t src,
                           uint32_t dst)
{
    double centre = ((double)i + 0.5) * (double)src / (double)dst - 0.5;
    uint32_t first;

    if (centre < 0.0)
        centre = 0.0;
    if (centre > (double)(src - 1))
        centre = (double)(src - 1);
    first = (uint32_t)centre;
    span->first = first;
    span->n = first + 1 < src ? 2 : 1;
    span->weight = used;
    weights[used] = span->n == 2 ? (float)(1.0 - (centre - (double)first)) : 1.0f;
    if (span->n == 2)
        weights[used + 1] = (float)(centre - (double)first);
    return used + span->n;
}

static int axis_init(struct axis *axis, uint32_t src, uint32_t dst)
{
    size_t taps = src > dst ? (size_t)src + 2 * (size_t)dst : 2 * (size_t)dst;
    size_t used = 0;

    axis->spans = calloc(dst, sizeof(*axis->spans));
    axis->weights = calloc(taps, sizeof(*axis->weights));
    if (!axis->spans || !axis->weights)
        return -ENOMEM;
    for (uint32_t i = 0; i < dst; i++) {
        if (src > dst)
            used = shrink_span(&axis->spans[i], axis->weights, used, i, src, dst);
        else
            used = enlarge_span(&axis->spans[i], axis->weights, used, i, src, dst);
    }
    return 0;
}

static float sample_at(const void *row, enum ttf_sample format, size_t i)
{
    switch (format) {
    case TTF_SAMPLE_U8:
        return (float)((const uint8_t *)row)[i];
    case TTF_SAMPLE_U16:
        return (float)((const uint16_t *)row)[i];
    default:
        return ((const float *)row)[i];
    }
}

/* One source row brought to the output's width. */
static void resample_row(const struct ttf_pixbuf *src, uint32_t y, const struct axis *x_axis,
                         uint32_t width, float *ret)
{
    const void *row = ttf_pixbuf_row(src, y);
    uint32_t k = src->samples;

    for (uint32_t x = 0; x < width; x++) {
        const struct span *span = &x_axis->spans[x];
        const float *w = &x_axis->weights[span->weight];

        for (uint32_t c = 0; c < k; c++) {
            float sum = 0.0f;

            for (uint32_t t = 0; t < span->n; t++)
                sum += w[t] * sample_at(row, src->format, (size_t)(span->first + t) * k + c);
            ret[(size_t)x * k + c] = sum;
        }
    }
}

/* Rounded and clipped, a NaN to 0. */
static unsigned rounded(float value, float max)
{
    if (!(value > 0.0f))
        return 0;
    return value >= max ? (unsigned)max : (unsigned)(value + 0.5f);
}

static void store_row(const float *row, struct ttf_pixbuf *dst, uint32_t y)
{
    size_t n = (size_t)dst->width * dst->samples;
    void *to = ttf_pixbuf_row(dst, y);

    for (size_t i = 0; i < n; i++) {
        if (dst->format == TTF_SAMPLE_U8)
            ((uint8_t *)to)[i] = (uint8_t)rounded(row[i], 255.0f);
        else if (dst->format == TTF_SAMPLE_U16)
            ((uint16_t *)to)[i] = (uint16_t)rounded(row[i], 65535.0f);
        else
            ((float *)to)[i] = row[i];
    }
}

/* Source rows at the output's width, of which the last two are kept. */
struct row_cache {
    float *rows[2];
    uint32_t y[2];
};

static const float *cached_row(struct row_cache *cache, const struct ttf_pixbuf *src, uint32_t y,
                               const struct axis *x_axis, uint32_t width)
{
    unsigned i = y & 1u;

    if (cache->y[i] != y) {
        resample_row(src, y, x_axis, width, cache->rows[i]);
        cache->y[i] = y;
    }
    return cache->rows[i];
}

int ttf_pixbuf_resample(const struct ttf_pixbuf *src, struct ttf_pixbuf *dst)
{
    struct axis x_axis = {0}, y_axis = {0};
    struct row_cache cache = {{NULL, NULL}, {UINT32_MAX, UINT32_MAX}};
    size_t n = (size_t)dst->width * dst->samples;
    float *rows = NULL;
    int r;

    if (src->samples != dst->samples || src->format != dst->format ||
        (src->format != TTF_SAMPLE_U8 && src->format != TTF_SAMPLE_U16 &&
         src->format != TTF_SAMPLE_F32) ||
        src->width == 0 || src->height == 0 || dst->width == 0 || dst->height == 0)
        return -EINVAL;
    r = axis_init(&x_axis, src->width, dst->width);
    if (r == 0)
        r = axis_init(&y_axis, src->height, dst->height);
    rows = calloc(3 * n, sizeof(*rows));
    if (r < 0 || !rows || !y_axis.spans) {
        r = -ENOMEM;
        goto out;
    }
    cache.rows[0] = rows + n;
    cache.rows[1] = rows + 2 * n;
    for (uint32_t y = 0; y < dst->height; y++) {
        const struct span *span = &y_axis.spans[y];

        for (size_t i = 0; i < n; i++)
            rows[i] = 0.0f;
        for (uint32_t t = 0; t < span->n; t++) {
            const float *from = cached_row(&cache, src, span->first + t, &x_axis, dst->width);
            float w = y_axis.weights[span->weight + t];

            for (size_t i = 0; i < n; i++)
                rows[i] += w * from[i];
        }
        store_row(rows, dst, y);
    }
    r = 0;
out:
    free(rows);
    axis_free(&x_axis);
    axis_free(&y_axis);
    return r;
}
