/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "prepare/levels.h"

/* More slopes than this are not looked at: pairs further apart say as much. */
#define PAIRED 201u

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

/* Theil and Sen's: the median of the slopes of all pairs of the first `window` values from `level`. */
static double robust_slope(const double *level, uint32_t window, double *scratch)
{
    uint32_t count = window < PAIRED ? window : PAIRED;
    size_t n = 0;

    for (uint32_t i = 0; i < count; i++) {
        for (uint32_t k = i + 1; k < count; k++) {
            if (!isnan(level[i]) && !isnan(level[k]))
                scratch[n++] = (level[k] - level[i]) / (k - i);
        }
    }
    return n > 0 ? median(scratch, n) : 0.0;
}

static double median_at(const double *level, struct span span, uint32_t t, double slope,
                        double *scratch)
{
    size_t n = 0;

    for (uint32_t k = span.first; k < span.first + span.count; k++) {
        if (!isnan(level[k]))
            scratch[n++] = level[k] - slope * ((double)k - t);
    }
    return median(scratch, n);
}

/*
 * The least-squares line's value at t. The values at both ends of the window count half:
 * so what alternates from frame to frame, which a median of an odd number passes on
 * in full, adds up to nothing.
 */
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
    uint32_t paired = count < PAIRED ? count : PAIRED;
    size_t pairs = (size_t)paired * (paired - 1) / 2;
    double *scratch = calloc(pairs > count ? pairs : count, sizeof(*scratch));
    double *medians = calloc(n, sizeof(*medians));
    int code = scratch && medians ? 0 : -ENOMEM;

    if (!code) {
        double start = robust_slope(level, count, scratch);
        double end = robust_slope(level + (n - paired), paired, scratch);

        for (uint32_t t = 0; t < n; t++) {
            double slope = t < count / 2 ? start : t + count / 2 >= n ? end : 0.0;

            medians[t] = median_at(level, span_at(t, n, count), t, slope, scratch);
        }
        for (uint32_t t = 0; t < n; t++)
            ret[t] = line_at(medians, span_at(t, n, count), t);
    }
    free(scratch);
    free(medians);
    return code;
}
