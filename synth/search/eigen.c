/* SPDX-License-Identifier: Apache-2.0 */
#include "search/eigen.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

#define SWEEPS_MAX 30

/* Four sums side by side, so that the compiler may keep several additions in flight in a fixed order. */
static double dot(const double *a, const double *b, size_t n)
{
    double sum[4] = {0.0, 0.0, 0.0, 0.0};
    size_t i = 0;

    for (; i + 4 <= n; i += 4) {
        for (int k = 0; k < 4; k++)
            sum[k] += a[i + (size_t)k] * b[i + (size_t)k];
    }
    for (; i < n; i++)
        sum[0] += a[i] * b[i];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

static void subtract(double *a, const double *b, double factor, size_t n)
{
    for (size_t i = 0; i < n; i++)
        a[i] -= factor * b[i];
}

/* Takes the earlier rows out of row k, twice (once loses digits), and makes its length 1. */
static void orthonormalize_row(double *v, size_t dims, size_t k)
{
    double *row = v + k * dims;
    double before = sqrt(dot(row, row, dims)), after;

    for (size_t j = 0; j < 2 * k; j++) {
        const double *other = v + j % k * dims;

        subtract(row, other, dot(row, other, dims), dims);
    }
    after = sqrt(dot(row, row, dims));
    if (!(after > 1e-9 * before) || !(after > 0.0)) {
        memset(row, 0, dims * sizeof(*row));
        return;
    }
    for (size_t i = 0; i < dims; i++)
        row[i] /= after;
}

void ttf_eigen_iterate(const double *a, size_t dims, double *v, size_t n, unsigned rounds,
                       double *work)
{
    for (unsigned round = 0; round < rounds; round++) {
        memset(work, 0, n * dims * sizeof(*work));
        for (size_t k = 0; k < n; k++) {
            for (size_t i = 0; i < dims; i++)
                subtract(work + k * dims, a + i * dims, -v[k * dims + i], dims);
        }
        memcpy(v, work, n * dims * sizeof(*v));
        for (size_t k = 0; k < n; k++)
            orthonormalize_row(v, dims, k);
    }
}

/* Makes a[p][q] zero by a rotation of rows and columns p, q; the same on v's rows. */
static void rotate(double *a, size_t n, double *v, size_t p, size_t q)
{
    double apq = a[p * n + q];
    double theta = (a[q * n + q] - a[p * n + p]) / (2.0 * apq);
    double t = (theta >= 0.0 ? 1.0 : -1.0) / (fabs(theta) + sqrt(theta * theta + 1.0));
    double c = 1.0 / sqrt(t * t + 1.0), s = t * c;

    for (size_t i = 0; i < n; i++) {
        double x = a[i * n + p], y = a[i * n + q];

        a[i * n + p] = c * x - s * y;
        a[i * n + q] = s * x + c * y;
    }
    for (size_t i = 0; i < n; i++) {
        double x = a[p * n + i], y = a[q * n + i];

        a[p * n + i] = c * x - s * y;
        a[q * n + i] = s * x + c * y;
        x = v[p * n + i];
        y = v[q * n + i];
        v[p * n + i] = c * x - s * y;
        v[q * n + i] = s * x + c * y;
    }
}

static bool sweep(double *a, size_t n, double *v)
{
    double largest = 0.0;
    bool turned = false;

    for (size_t i = 0; i < n; i++)
        largest = fabs(a[i * n + i]) > largest ? fabs(a[i * n + i]) : largest;
    for (size_t p = 0; p < n; p++) {
        for (size_t q = p + 1; q < n; q++) {
            double off = fabs(a[p * n + q]);

            /* beside what the two stand for, and beside the whole, it is rounding */
            if (off <= 1e-14 * sqrt(fabs(a[p * n + p] * a[q * n + q])) || off <= 1e-18 * largest)
                continue;
            rotate(a, n, v, p, q);
            turned = true;
        }
    }
    return turned;
}

static void swap_rows(double *v, size_t n, size_t a, size_t b)
{
    for (size_t i = 0; i < n; i++) {
        double x = v[a * n + i];

        v[a * n + i] = v[b * n + i];
        v[b * n + i] = x;
    }
}

void ttf_eigen_all(double *a, size_t n, double *v, double *values)
{
    memset(v, 0, n * n * sizeof(*v));
    for (size_t i = 0; i < n; i++)
        v[i * n + i] = 1.0;
    for (int i = 0; i < SWEEPS_MAX && sweep(a, n, v); i++)
        ;
    for (size_t i = 0; i < n; i++)
        values[i] = a[i * n + i];
    for (size_t i = 0; i < n; i++) {
        size_t best = i;
        double value;

        for (size_t j = i + 1; j < n; j++)
            best = values[j] > values[best] ? j : best;
        if (best == i)
            continue;
        value = values[i];
        values[i] = values[best];
        values[best] = value;
        swap_rows(v, n, i, best);
    }
}
