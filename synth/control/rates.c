/* SPDX-License-Identifier: Apache-2.0 */
#include "control/rates.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "control/picture.h"

#define RATE_MAX 1048576.0

int ttf_rates_alloc(uint32_t width, uint32_t height, struct ttf_rate_map *ret, struct ttf_err *err)
{
    int r = ttf_control_size_check(width, height, err);
    float *m;

    if (r < 0)
        return r;
    m = calloc((size_t)width * height, sizeof(*m));
    if (!m)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a map of %u x %u", width, height);
    *ret = (struct ttf_rate_map){.width = width, .height = height, .m = m};
    return 0;
}

int ttf_rate_scale_check(const struct ttf_rate_scale *scale, struct ttf_err *err)
{
    if (!isfinite(scale->offset))
        return ttf_err_set(err, -EINVAL, "offset", "is not a finite number");
    if (!isfinite(scale->gain))
        return ttf_err_set(err, -EINVAL, "gain", "is not a finite number");
    return 0;
}

int ttf_rate_of_value(const struct ttf_rate_scale *scale, double value, float *ret,
                      struct ttf_err *err)
{
    double rate = scale->offset + scale->gain * value;

    if (!(rate <= RATE_MAX)) {
        ttf_err_set(err, -ERANGE, "rate", "a rate of %g is more than %g", rate, RATE_MAX);
        ttf_err_hint(err, "lower the gain: 1 is the pace of the input");
        return -ERANGE;
    }
    *ret = rate > 0.0 ? (float)rate : 0.0f;
    return 0;
}

static void swap(double *a, double *b)
{
    double t = *a;

    *a = *b;
    *b = t;
}

/* Hoare's selection: afterwards values[k] is where sorting would put it. */
static double select_kth(double *values, ptrdiff_t n, ptrdiff_t k)
{
    ptrdiff_t low = 0, high = n - 1;

    while (low < high) {
        double pivot = values[low + (high - low) / 2];
        ptrdiff_t i = low, j = high;

        while (i <= j) {
            while (i < high && values[i] < pivot)
                i++;
            while (j > low && values[j] > pivot)
                j--;
            if (i <= j)
                swap(&values[i++], &values[j--]);
        }
        if (k <= j)
            high = j;
        else if (k >= i)
            low = i;
        else
            break;
    }
    return values[k];
}

double ttf_control_quantile(double *values, size_t n, double share)
{
    double rank = ceil(share * (double)n);
    size_t k = rank < 1.0 ? 0 : (size_t)rank - 1;

    return select_kth(values, (ptrdiff_t)n, (ptrdiff_t)(k < n ? k : n - 1));
}

/* What counts as 1: p99; where less than 1% is curved at all, the largest; 0: nothing is. */
static int full_curvature(const double *k, size_t n, double noise, double *ret, struct ttf_err *err)
{
    double *sizes = malloc(n * sizeof(*sizes));
    double full;

    if (!sizes)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for %zu curvatures", n);
    for (size_t i = 0; i < n; i++)
        sizes[i] = fabs(k[i]);
    full = ttf_control_quantile(sizes, n, 0.99);
    if (full <= noise)
        full = ttf_control_quantile(sizes, n, 1.0);
    free(sizes);
    *ret = full > noise ? full : 0.0;
    return 0;
}

int ttf_rates_of_curvature(const double *k, size_t n, double noise,
                           const struct ttf_rate_scale *scale, float *ret, struct ttf_err *err)
{
    double full = 0.0;
    int r = full_curvature(k, n, noise, &full, err);

    for (size_t i = 0; i < n && r == 0; i++) {
        double share = full > 0.0 ? fabs(k[i]) / full : 0.0;

        r = ttf_rate_of_value(scale, share < 1.0 ? share : 1.0, &ret[i], err);
    }
    return r;
}
