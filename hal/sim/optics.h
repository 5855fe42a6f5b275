/* SPDX-License-Identifier: Apache-2.0 */
/*
 * optics.h: how the sample's plane gets onto the sensor. Private to the image model.
 *
 * Coordinates. The frame is the plane [0, width] x [0, height]: pixel (i, j) is
 * the square from (i, j) to (i+1, j+1) and its middle is (i + 0.5, j + 0.5). The
 * sample is [0, 1] x [0, 1]; a picture of it of w x h pixels divides it evenly in the same way.
 * Rows map to rows: the keystone is symmetric, so a row of the frame sees one row
 * of the sample and steps evenly along it.
 */
#ifndef TTF_HAL_SIM_OPTICS_H
#define TTF_HAL_SIM_OPTICS_H

#include <stdint.h>

#include "ttf/hal/sim.h"

#define OPTICS_BLUR_RADIUS_MAX 16

/* A plain struct; filled by optics_init, never changed afterwards. */
struct optics {
    uint32_t width, height; /* of the frame */
    uint32_t src_width;     /* size at which the sample is to be rendered: the coarsest the */
    uint32_t
        src_height; /* frame sees anywhere, so resampling only ever magnifies; or coarser yet */
    double x0, x1, y0, y1; /* the sample's rectangle in the frame before the keystone */
    double keystone;       /* share by which the top edge is shorter than the bottom one */
    double vignetting;     /* light lost in the frame's corner */
    float margin;          /* reflectance around the sample */
    int blur_radius;       /* taps on each side, 0: no blur */
    float blur[OPTICS_BLUR_RADIUS_MAX + 1]; /* weight at distance k */
};

void optics_init(struct optics *o, const struct ttf_sim_config *config);

/* A row of the frame in the sample: v of its middle, u = u0 + x * du for a frame coordinate x. */
struct optics_row {
    double v, u0, du;
};
void optics_row(const struct optics *o, double y, struct optics_row *ret);

/* The sample's corners in the frame: top left, top right, bottom right, bottom left. */
void optics_corners(const struct optics *o, double ret_xy[4][2]);

/* Share of light that reaches frame coordinate (x, y); 1 in the middle. */
float optics_vignette(const struct optics *o, double x, double y);

/*
 * Irradiance of a lamp at (u, v) of the sample, relative to the sample's middle: inverse square
 * and cosine. u and v may lie outside [0, 1].
 */
float optics_lamp_fall_off(const struct optics *o, const struct ttf_sim_lamp *lamp, double u,
                           double v);

/*
 * One row of the frame from the rendered sample (src_width x src_height x 3), before
 * blur: three rows of `width`. scratch: src_width x 3.
 */
void optics_resample_row(const struct optics *o, const float *src, uint32_t y, float *scratch,
                         float *ret_r, float *ret_g, float *ret_b);

/* Blurs across rows: taps[0..2*radius] are 2*radius+1 rows around the wanted one. dst: n. */
void optics_blur_rows(const struct optics *o, const float *const *taps, uint32_t n, float *dst);

/* Blurs along a row; src has blur_radius valid pixels before [0] and after [n-1]. */
void optics_blur_along(const struct optics *o, const float *src, uint32_t n, float *dst);

#endif
