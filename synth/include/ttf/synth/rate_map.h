/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rate_map.h: how fast each pixel of the output ages: M(x,y) of eq. 8 (Enrique
 * et al. 2005, section 6). Output frame t takes source frame t * M(x,y).
 *
 * Maps are made from plain pictures in memory; reading files is the caller's.
 */
#ifndef TTF_SYNTH_RATE_MAP_H
#define TTF_SYNTH_RATE_MAP_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/pixbuf.h"

/* Height x width values, >= 0, finite, at most 2^20 (else -ERANGE); rows from the top. Sides of 1 to 32768 pixels. */
struct ttf_rate_map {
    uint32_t width, height;
    float *m;
};

void ttf_rate_map_free(struct ttf_rate_map *map); /* a zeroed one is fine */

/* Smallest and largest M. */
void ttf_rate_map_range(const struct ttf_rate_map *map, float *ret_least, float *ret_most);

/*
 * Frames of the output under eq. 8 ("the length is determined by the fastest pixel"):
 * ceil((n - 1) / max M) + 1; max M = 0: n (copies of frame 0). M being a float, a quotient within
 * 2^-22 of it above an integer is that integer: 0.7f means 0.7. At most 2^20: -ERANGE
 * (a map whose fastest pixel hardly moves). n = 0: -EINVAL.
 */
TTF_MUST_USE int ttf_rate_map_frames(const struct ttf_rate_map *map, uint32_t n, uint32_t *ret,
                                     struct ttf_err *err);

/*
 * M from a picture (figure 9c): its grey, offset + gain * value with value 0..1 as stored
 * (no transfer curve; colour by Rec. 709 weights; alpha left out), clipped at 0. Any format of pixbuf
 * but F16. Resampled to width x height (0: that side as it is). Not finite: -EINVAL.
 */
TTF_MUST_USE int ttf_rate_map_of_picture(const struct ttf_pixbuf *picture, uint32_t width,
                                         uint32_t height, double offset, double gain,
                                         struct ttf_rate_map *ret, struct ttf_err *err);

/*
 * A light and what it falls on (eq. 9). Lengths in units of the output's width, from its top
 * left corner: x to the right, y down, z up from the plane towards the viewer.
 */
struct ttf_light {
    double x, y, z;      /* position: (0.5, 0.3, 0.4) is over the plane; z > 0; x, y anywhere */
    double offset, gain; /* M = offset + gain * (cos q / r^2)^2 */
    const struct ttf_pixbuf *normals; /* tangent-space picture, 0..1 <-> -1..1, y up; or NULL */
    const struct ttf_pixbuf *heights; /* grey 0..1 times height_scale; or NULL. Not both. */
    double height_scale;              /* in units of the output's width */
};

/*
 * M = (cos q / r^2)^2, cos q = max(0, N.L), r the distance to the light in units of that of the
 * nearest pixel's middle, so that M <= 1 before offset and gain. Neither normals nor heights: a flat plane.
 * Heights turn the surface and raise it; normals only turn it. Both: -EINVAL.
 * Nothing casts a shadow on anything else.
 */
TTF_MUST_USE int ttf_rate_map_of_light(const struct ttf_light *light, uint32_t width,
                                       uint32_t height, struct ttf_rate_map *ret,
                                       struct ttf_err *err);

/*
 * M from curvature of a curve swept along y (eq. 10 to 12): k = |y''| / (1 + y'^2)^(3/2) over
 * x, sampled at each column's middle; M = offset + gain * clip(k / p99, 0, 1). p99: the curvature that 99%
 * of the columns do not exceed; where that is 0, the largest; a straight curve has M = offset.
 */
struct ttf_curve {
    /* y(x): NULL is the paper's 1 / (1 + e^-x). Derivatives are by central differences. */
    double (*y)(void *ctx, double x);
    void *ctx;
    double from,
        to; /* the x of the left and right edge, never asked beyond; the paper's curve: -8 and 8 */
};
TTF_MUST_USE int ttf_rate_map_of_curve(const struct ttf_curve *curve, uint32_t width,
                                       uint32_t height, double offset, double gain,
                                       struct ttf_rate_map *ret, struct ttf_err *err);

/*
 * A curve given as n >= 3 points (xs ascending): natural cubic spline, straight beyond its ends;
 * for ttf_curve.y with ctx = the spline.
 */
struct ttf_spline;
TTF_MUST_USE int ttf_spline_create(const double *xs, const double *ys, unsigned n,
                                   struct ttf_spline **ret, struct ttf_err *err);
double ttf_spline_at(void *spline, double x);
void ttf_spline_destroy(struct ttf_spline *spline);

/*
 * M from the mean curvature of a height map (grey 0..1 times height_scale, in units of the width):
 * brought to width x height, smoothed by sigma_px of the output (0 to 256; slopes go on beyond the borders),
 * then |H| as k above. Heights of 8 bits are terraces: they need a sigma of 2 pixels and more.
 */
TTF_MUST_USE int ttf_rate_map_of_heights(const struct ttf_pixbuf *heights, double height_scale,
                                         double sigma_px, uint32_t width, uint32_t height,
                                         double offset, double gain, struct ttf_rate_map *ret,
                                         struct ttf_err *err);

#endif
