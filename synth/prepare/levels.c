/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "prepare/levels.h"

/* Slopes are taken of so many frames at most: of more, they say no more of the one in the middle. */
#define SLOPE_FRAMES 51u

struct span {
    uint32_t first, count;
};

static struct span span_at(uint32_t t, uint32_t n, uint32_t window)
{
    uint32_t half = window / 2, first = t > half ? t - half : 0;

    return (struct span){first + window > n ? n - window : first, window};
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;

    return (x > y) - (x < y);
}

static double median(double *values, size_t n)
{
    if (n == 0)
        return (double)NAN;
    qsort(values, n, sizeof(*values), by_value);
    return n % 2 ? values[n / 2] : 0.5 * (values[n / 2 - 1] + values[n / 2]);
}

/* Theil and Sen's: the median of the slopes of all pairs. */
static double robust_slope(const double *level, struct span span, double *scratch)
{
    uint32_t end = span.first + span.count;
    size_t n = 0;

    for (uint32_t i = span.first; i < end; i++) {
        for (uint32_t k = i + 1; k < end; k++) {
            if (!isnan(level[i]) && !isnan(level[k]))
                scratch[n++] = (level[k] - level[i]) / (k - i);
        }
    }
    return n > 0 ? median(scratch, n) : 0.0;
}

/*
 * The values at both ends of a window count half, here and in the mean: so what alternates
 * from frame to frame is in balance, where an odd number of whole ones would take a side.
 */
static double median_at(const double *level, struct span span, uint32_t t, double slope,
                        double *scratch)
{
    size_t n = 0;

    for (uint32_t i = 0; i < span.count; i++) {
        double value = level[span.first + i] - slope * ((double)(span.first + i) - t);

        if (isnan(value))
            continue;
        scratch[n++] = value;
        if (i > 0 && i < span.count - 1)
            scratch[n++] = value;
    }
    return median(scratch, n);
}

/* The least-squares line's value at t. */
static double line_at(const double *value, struct span span, uint32_t t)
{
    double w = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, spread;

    for (uint32_t i = 0; i < span.count; i++) {
        double weight = i == 0 || i == span.count - 1 ? 0.5 : 1.0;
        double at = (double)(span.first + i) - t, v = value[span.first + i];

        if (isnan(v))
            continue;
        w += weight;
        x += weight * at;
        y += weight * v;
        xx += weight * at * at;
        xy += weight * at * v;
    }
    if (w == 0.0)
        return (double)NAN;
    spread = w * xx - x * x;
    return spread > 0.0 ? (xx * y - x * xy) / spread : y / w;
}

int ttf_levels_smooth(const double *level, uint32_t n, uint32_t window, double *ret)
{
    uint32_t fitting = n % 2 ? n : n - 1;
    uint32_t count = window < fitting ? window : fitting;
    uint32_t paired = count < SLOPE_FRAMES ? count : SLOPE_FRAMES;
    size_t pairs = (size_t)paired * (paired - 1) / 2, doubled = 2 * (size_t)count;
    double *scratch = calloc(pairs > doubled ? pairs : doubled, sizeof(*scratch));
    double *medians = calloc(n, sizeof(*medians));
    int code = scratch && medians ? 0 : -ENOMEM;

    for (uint32_t t = 0; t < n && !code; t++) {
        double slope = robust_slope(level, span_at(t, n, paired), scratch);

        medians[t] = median_at(level, span_at(t, n, count), t, slope, scratch);
    }
    for (uint32_t t = 0; t < n && !code; t++)
        ret[t] = line_at(medians, span_at(t, n, count), t);
    free(scratch);
    free(medians);
    return code;
}
