/* SPDX-License-Identifier: Apache-2.0 */
/* Rates from the mean curvature of a height map: eq. 11 and 12 (Enrique et al. 2005) for surfaces. */
#include <errno.h>
#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "control/curvature.h"
#include "control/gaussian.h"
#include "control/picture.h"
#include "control/rates.h"
#include "ttf/synth/rate_map.h"

/* The place nearest to i, of n, that has neighbours on both sides. */
static uint32_t inner(uint32_t i, uint32_t n)
{
    if (i == 0)
        return 1;
    return i + 1 < n ? i : n - 2;
}

/*
 * H = ((1 + zy^2) zxx - 2 zx zy zxy + (1 + zx^2) zyy) / (2 (1 + zx^2 + zy^2)^(3/2)).
 * An axis of less than three pixels has no curvature: its differences are 0.
 */
static double mean_curvature_at(const double *z, uint32_t width, uint32_t height, double pixel,
                                uint32_t x, uint32_t y)
{
    uint32_t cx = width >= 3 ? inner(x, width) : 0, cy = height >= 3 ? inner(y, height) : 0;
    ptrdiff_t dx = width >= 3 ? 1 : 0, dy = height >= 3 ? (ptrdiff_t)width : 0;
    const double *at = z + (size_t)cy * width + cx;
    double zx = (at[dx] - at[-dx]) / (2.0 * pixel), zy = (at[dy] - at[-dy]) / (2.0 * pixel);
    double zxx = (at[dx] - 2.0 * at[0] + at[-dx]) / (pixel * pixel);
    double zyy = (at[dy] - 2.0 * at[0] + at[-dy]) / (pixel * pixel);
    double zxy = (at[dx + dy] - at[dx - dy] - at[dy - dx] + at[-dx - dy]) / (4.0 * pixel * pixel);
    double above = (1.0 + zy * zy) * zxx - 2.0 * zx * zy * zxy + (1.0 + zx * zx) * zyy;

    return above / (2.0 * pow(1.0 + zx * zx + zy * zy, 1.5));
}

void ttf_control_mean_curvature(const double *z, uint32_t width, uint32_t height, double pixel,
                                double *ret)
{
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++)
            ret[(size_t)y * width + x] = mean_curvature_at(z, width, height, pixel, x, y);
    }
}

static int smoothed_heights(const struct ttf_pixbuf *heights, double height_scale, double sigma_px,
                            uint32_t width, uint32_t height, double *ret, struct ttf_err *err)
{
    struct ttf_pixbuf grey = {0};
    int r = ttf_control_grey(heights, "heights", width, height, &grey, err);

    if (r < 0)
        return r;
    for (uint32_t y = 0; y < height; y++) {
        const float *row = ttf_pixbuf_row(&grey, y);

        for (uint32_t x = 0; x < width; x++)
            ret[(size_t)y * width + x] = height_scale * (double)row[x];
    }
    ttf_pixbuf_free(&grey);
    r = ttf_control_gaussian(ret, width, height, sigma_px, TTF_BORDER_ODD);
    if (r == -EINVAL)
        return ttf_err_set(err, r, "sigma", "%g pixels is not within 0 and %g", sigma_px,
                           TTF_GAUSSIAN_SIGMA_MAX);
    return r < 0 ? ttf_err_set(err, r, NULL, "no memory for smoothing") : 0;
}

/*
 * Samples have 24 bits at most, and their rounding bends a plane: second differences are
 * off by up to four times its half; of a Gaussian's result by the share 1 / sigma^2, since at a border,
 * which keeps its values, one sample's error stays and is bent away over sigma.
 */
static double rounding_curvature(const double *z, size_t n, double pixel, double sigma_px)
{
    double averaged = sigma_px > 1.0 ? sigma_px * sigma_px : 1.0;
    double largest = 0.0;

    for (size_t i = 0; i < n; i++)
        largest = fabs(z[i]) > largest ? fabs(z[i]) : largest;
    return 4.0 * (double)FLT_EPSILON * largest / (pixel * pixel) / averaged;
}

int ttf_rate_map_of_heights(const struct ttf_pixbuf *heights, double height_scale, double sigma_px,
                            uint32_t width, uint32_t height, double offset, double gain,
                            struct ttf_rate_map *ret, struct ttf_err *err)
{
    struct ttf_rate_scale scale = {offset, gain};
    struct ttf_rate_map map = {0};
    size_t n = (size_t)width * height;
    double *z = NULL, *k = NULL, pixel = 1.0 / (double)width;
    int r = ttf_rate_scale_check(&scale, err);

    if (r == 0 && !isfinite(height_scale))
        r = ttf_err_set(err, -EINVAL, "height_scale", "is not a finite number");
    if (r == 0)
        r = ttf_rates_alloc(width, height, &map, err);
    if (r < 0)
        return r;
    z = calloc(n, sizeof(*z));
    k = calloc(n, sizeof(*k));
    if (!z || !k) {
        r = -ENOMEM;
        ttf_err_set(err, r, "heights", "no memory for %u x %u", width, height);
    } else {
        r = smoothed_heights(heights, height_scale, sigma_px, width, height, z, err);
    }
    if (r == 0) {
        ttf_control_mean_curvature(z, width, height, pixel, k);
        r = ttf_rates_of_curvature(k, n, rounding_curvature(z, n, pixel, sigma_px), &scale, map.m,
                                   err);
    }
    free(z);
    free(k);
    if (r < 0) {
        ttf_rate_map_free(&map);
        return r;
    }
    *ret = map;
    return 0;
}
