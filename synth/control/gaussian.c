/* SPDX-License-Identifier: Apache-2.0 */
#include "control/gaussian.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

struct kernel {
    double *weights; /* of offsets 0..radius, of one side */
    uint32_t radius;
};

static int kernel_create(double sigma_px, struct kernel *ret)
{
    uint32_t radius = (uint32_t)ceil(4.0 * sigma_px);
    double *weights = malloc(((size_t)radius + 1) * sizeof(*weights));
    double sum = 0.0;

    if (!weights)
        return -ENOMEM;
    for (uint32_t i = 0; i <= radius; i++) {
        double u = (double)i / sigma_px;

        weights[i] = exp(-0.5 * u * u);
        sum += i == 0 ? weights[i] : 2.0 * weights[i];
    }
    for (uint32_t i = 0; i <= radius; i++)
        weights[i] /= sum;
    ret->weights = weights;
    ret->radius = radius;
    return 0;
}

/*
 * The n values in the middle of `line` (radius on either side) get what lies beyond their ends. Where
 * a reflection reaches beyond the other end, it reflects what was put there just before.
 */
static void extend(double *line, uint32_t n, uint32_t radius, enum ttf_gaussian_border border)
{
    double *first = line + radius, *last = first + (n - 1);

    for (uint32_t i = 1; i <= radius; i++) {
        if (border == TTF_BORDER_HOLD || n == 1) {
            *(first - i) = *first;
            *(last + i) = *last;
        } else {
            *(first - i) = 2.0 * *first - *(first + i);
            *(last + i) = 2.0 * *last - *(last - i);
        }
    }
}

static double weighted(const struct kernel *kernel, const double *at)
{
    double sum = kernel->weights[0] * at[0];

    for (uint32_t i = 1; i <= kernel->radius; i++)
        sum += kernel->weights[i] * (*(at - i) + at[i]);
    return sum;
}

/* One row or column: n values, `step` apart. */
static void smooth_line(const struct kernel *kernel, double *values, uint32_t n, size_t step,
                        enum ttf_gaussian_border border, double *line)
{
    for (uint32_t i = 0; i < n; i++)
        line[kernel->radius + i] = values[i * step];
    extend(line, n, kernel->radius, border);
    for (uint32_t i = 0; i < n; i++)
        values[i * step] = weighted(kernel, line + kernel->radius + i);
}

int ttf_control_gaussian(double *plane, uint32_t width, uint32_t height, double sigma_px,
                         enum ttf_gaussian_border border)
{
    struct kernel kernel = {0};
    double *line;
    int r;

    if (!(sigma_px >= 0.0 && sigma_px <= TTF_GAUSSIAN_SIGMA_MAX))
        return -EINVAL;
    if (sigma_px < 0.05) /* its neighbours' weights would be below 1e-80 */
        return 0;
    r = kernel_create(sigma_px, &kernel);
    if (r < 0)
        return r;
    line = malloc(((size_t)(width > height ? width : height) + 2 * (size_t)kernel.radius) *
                  sizeof(*line));
    if (!line) {
        free(kernel.weights);
        return -ENOMEM;
    }
    for (uint32_t y = 0; y < height; y++)
        smooth_line(&kernel, plane + (size_t)y * width, width, 1, border, line);
    for (uint32_t x = 0; x < width; x++)
        smooth_line(&kernel, plane + x, height, width, border, line);
    free(line);
    free(kernel.weights);
    return 0;
}
