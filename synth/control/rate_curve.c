/* SPDX-License-Identifier: Apache-2.0 */
/* Rates from the curvature of a curve swept along y (Enrique et al. 2005, eq. 10 to 12). */
#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "control/curvature.h"
#include "control/rates.h"
#include "ttf/synth/rate_map.h"

/*
 * The step of the differences, of the curve's whole range: errors of the formula (h^2 y''''/12)
 * and of rounding (4 eps y / h^2) are both about 1e-7 of what a curve that bends a few times has.
 */
#define STEP_SHARE 1e-4

/* How many last bits of y may be wrong: library functions are good to one or two. */
#define ROUNDING (16.0 * DBL_EPSILON)

/* eq. 10 */
static double sigmoid(void *ctx, double x)
{
    (void)ctx;
    return 1.0 / (1.0 + exp(-x));
}

double ttf_control_curve_curvature(double (*y)(void *ctx, double x), void *ctx, double x, double h)
{
    double before = y(ctx, x - h), here = y(ctx, x), after = y(ctx, x + h);
    double slope = (after - before) / (2.0 * h);
    double bend = before - 2.0 * here + after;
    double size = fabs(before) + 2.0 * fabs(here) + fabs(after);

    if (!isfinite(size))
        return (double)NAN;
    if (fabs(bend) <= ROUNDING * size)
        return 0.0;
    return fabs(bend) / (h * h) / pow(1.0 + slope * slope, 1.5);
}

/* One curvature per column, at its middle; the curve is asked only within its range. */
static int sample(const struct ttf_curve *curve, uint32_t width, double *ret, struct ttf_err *err)
{
    double range = curve->to - curve->from, column = range / (double)width;
    double h = STEP_SHARE * range < 0.5 * column ? STEP_SHARE * range : 0.5 * column;

    for (uint32_t i = 0; i < width; i++) {
        double x = curve->from + ((double)i + 0.5) * column;

        ret[i] = ttf_control_curve_curvature(curve->y ? curve->y : sigmoid, curve->ctx, x, h);
        if (!isfinite(ret[i]))
            return ttf_err_set(err, -EINVAL, "curve", "it has no finite curvature at x = %g", x);
    }
    return 0;
}

static int curve_check(const struct ttf_curve *curve, struct ttf_err *err)
{
    if (!isfinite(curve->from) || !isfinite(curve->to) || !(curve->from < curve->to) ||
        !isfinite(curve->to - curve->from))
        return ttf_err_set(err, -EINVAL, "curve", "from %g to %g is no range of x", curve->from,
                           curve->to);
    return 0;
}

int ttf_rate_map_of_curve(const struct ttf_curve *curve, uint32_t width, uint32_t height,
                          double offset, double gain, struct ttf_rate_map *ret, struct ttf_err *err)
{
    struct ttf_rate_scale scale = {offset, gain};
    struct ttf_rate_map map = {0};
    double *k = NULL;
    int r = curve_check(curve, err);

    if (r == 0)
        r = ttf_rate_scale_check(&scale, err);
    if (r == 0)
        r = ttf_rates_alloc(width, height, &map, err);
    if (r != 0)
        return r;
    k = calloc(width, sizeof(*k));
    if (!k) {
        ttf_rate_map_free(&map);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a curve of %u columns", width);
    }
    if (r == 0)
        r = sample(curve, width, k, err);
    if (r == 0)
        r = ttf_rates_of_curvature(k, width, 0.0, &scale, map.m, err);
    free(k);
    if (r != 0) {
        ttf_rate_map_free(&map);
        return r;
    }
    for (uint32_t y = 1; y < height; y++)
        memcpy(map.m + (size_t)y * width, map.m, width * sizeof(*map.m));
    *ret = map;
    return 0;
}
