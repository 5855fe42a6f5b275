/* SPDX-License-Identifier: Apache-2.0 */
/* Natural cubic spline: through all points, two times continuously differentiable, not bent at its ends. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "ttf/synth/rate_map.h"

#define POINTS_MAX 1000000u

struct ttf_spline {
    unsigned n;
    double *x, *y;
    double *bend; /* second derivative at each point */
};

static int points_check(const double *xs, const double *ys, unsigned n, struct ttf_err *err)
{
    if (n < 3 || n > POINTS_MAX)
        return ttf_err_set(err, -EINVAL, "curve", "%u points: 3 to %u are needed", n, POINTS_MAX);
    for (unsigned i = 0; i < n; i++) {
        if (!isfinite(xs[i]) || !isfinite(ys[i]))
            return ttf_err_set(err, -EINVAL, "curve", "point %u is not of finite numbers", i + 1);
        if (i > 0 && !(xs[i] > xs[i - 1])) {
            ttf_err_set(err, -EINVAL, "curve", "the x of point %u (%g) does not follow that of %u",
                        i + 1, xs[i], i);
            ttf_err_hint(err, "give the points by rising x, each x once");
            return -EINVAL;
        }
    }
    return 0;
}

/*
 * Continuity of the first derivative at each inner point gives a tridiagonal system for the second
 * ones: h0 b0 / 6 + (h0 + h1) b1 / 3 + h1 b2 / 6 = s1 - s0. It is diagonally dominant,
 * so elimination needs no pivots. `upper` is room for n values.
 */
static void solve_bends(struct ttf_spline *spline, double *upper)
{
    const double *x = spline->x, *y = spline->y;
    double *bend = spline->bend;

    bend[0] = upper[0] = 0.0;
    for (unsigned i = 1; i + 1 < spline->n; i++) {
        double h0 = x[i] - x[i - 1], h1 = x[i + 1] - x[i];
        double jump = (y[i + 1] - y[i]) / h1 - (y[i] - y[i - 1]) / h0;
        double pivot = (h0 + h1) / 3.0 - h0 / 6.0 * upper[i - 1];

        upper[i] = h1 / 6.0 / pivot;
        bend[i] = (jump - h0 / 6.0 * bend[i - 1]) / pivot;
    }
    bend[spline->n - 1] = 0.0;
    for (unsigned i = spline->n - 1; i-- > 1;)
        bend[i] -= upper[i] * bend[i + 1];
}

int ttf_spline_create(const double *xs, const double *ys, unsigned n, struct ttf_spline **ret,
                      struct ttf_err *err)
{
    struct ttf_spline *spline;
    double *upper;
    int r = points_check(xs, ys, n, err);

    if (r < 0)
        return r;
    spline = malloc(sizeof(*spline));
    if (spline)
        spline->x = calloc(3 * (size_t)n, sizeof(*spline->x));
    upper = calloc(n, sizeof(*upper));
    if (!spline || !spline->x || !upper) {
        ttf_spline_destroy(spline);
        free(upper);
        return ttf_err_set(err, -ENOMEM, "curve", "no memory for %u points", n);
    }
    spline->n = n;
    spline->y = spline->x + n;
    spline->bend = spline->y + n;
    for (unsigned i = 0; i < n; i++) {
        spline->x[i] = xs[i];
        spline->y[i] = ys[i];
    }
    solve_bends(spline, upper);
    free(upper);
    *ret = spline;
    return 0;
}

/* The piece that x lies in: its right end, 1..n-1. */
static unsigned piece_of(const struct ttf_spline *spline, double x)
{
    unsigned low = 1, high = spline->n - 1;

    while (low < high) {
        unsigned middle = low + (high - low) / 2;

        if (x <= spline->x[middle])
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

/* Outside its points the curve goes on straight, as its ends' slope has it. */
static double beyond(const struct ttf_spline *spline, unsigned end, unsigned inner, double x)
{
    double h = spline->x[inner] - spline->x[end]; /* negative at the right end */
    double slope = (spline->y[inner] - spline->y[end]) / h - h * spline->bend[inner] / 6.0;

    return spline->y[end] + slope * (x - spline->x[end]);
}

static double within(const struct ttf_spline *spline, double x)
{
    unsigned i = piece_of(spline, x);
    double h, a, b;

    h = spline->x[i] - spline->x[i - 1];
    a = (spline->x[i] - x) / h;
    b = (x - spline->x[i - 1]) / h;
    return a * spline->y[i - 1] + b * spline->y[i] +
           ((a * a * a - a) * spline->bend[i - 1] + (b * b * b - b) * spline->bend[i]) * h * h /
               6.0;
}

double ttf_spline_at(void *spline, double x)
{
    const struct ttf_spline *curve = spline;
    unsigned last = curve->n - 1;

    if (x < curve->x[0])
        return beyond(curve, 0, 1, x);
    if (x > curve->x[last])
        return beyond(curve, last, last - 1, x);
    return within(curve, x);
}

void ttf_spline_destroy(struct ttf_spline *spline)
{
    if (!spline)
        return;
    free(spline->x);
    free(spline);
}
