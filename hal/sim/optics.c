/* SPDX-License-Identifier: Apache-2.0 */
#include "optics.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

static double even_pixels(double share, uint32_t side)
{
    return 2.0 * floor(share * side * 0.5 + 0.5);
}

static void init_blur(struct optics *o, double sigma)
{
    double sum = 0.0, w[OPTICS_BLUR_RADIUS_MAX + 1];

    memset(o->blur, 0, sizeof(o->blur));
    o->blur[0] = 1.0f;
    o->blur_radius = 0;
    if (!(sigma > 0.05))
        return;
    o->blur_radius = (int)ceil(3.0 * sigma);
    if (o->blur_radius > OPTICS_BLUR_RADIUS_MAX)
        o->blur_radius = OPTICS_BLUR_RADIUS_MAX;
    for (int k = 0; k <= o->blur_radius; k++) {
        /* The Gaussian averaged over the pixel, not its value at the middle: right for small sigma too. */
        const double a = M_SQRT1_2 / sigma;

        w[k] = 0.5 * (erf((k + 0.5) * a) - erf((k - 0.5) * a));
        sum += k ? 2.0 * w[k] : w[k];
    }
    for (int k = 0; k <= o->blur_radius; k++)
        o->blur[k] = (float)(w[k] / sum);
}

/* No side of the sample's picture has more pixels than that; 0: as many as the frame sees. */
static void fit_source(struct optics *o, uint32_t side_px)
{
    const uint32_t side = o->src_width > o->src_height ? o->src_width : o->src_height;

    if (side_px == 0 || side <= side_px)
        return;
    o->src_width = (uint32_t)fmax(1.0, floor((double)o->src_width * side_px / side + 0.5));
    o->src_height = (uint32_t)fmax(1.0, floor((double)o->src_height * side_px / side + 0.5));
}

void optics_init(struct optics *o, const struct ttf_sim_config *config)
{
    double mx, my, p;

    memset(o, 0, sizeof(*o));
    o->width = config->width;
    o->height = config->height;
    o->vignetting = config->vignetting;
    o->margin = (float)config->margin_reflectance;
    /* Whole pairs of pixels, so that without a keystone one pixel of the sample is one of the frame. */
    mx = even_pixels(config->margin, o->width);
    my = even_pixels(config->margin, o->height);
    o->x0 = mx;
    o->x1 = o->width - mx;
    o->y0 = my;
    o->y1 = o->height - my;
    p = o->keystone = config->perspective;
    o->src_width = (uint32_t)fmax(1.0, floor((o->x1 - o->x0) * (1.0 - p) + 1e-9));
    o->src_height = (uint32_t)fmax(1.0, floor((o->y1 - o->y0) * (1.0 - p) + 1e-9));
    fit_source(o, config->detail_px);
    init_blur(o, config->blur_px);
}

/*
 * The keystone as a homography with the denominator 1 - p v: the width at v is
 * W (1-p) / (1 - p v) and y(v) = H (1-p) v / (1 - p v), so that v = 0 and 1 are
 * the sample's top and bottom edges and straight lines stay straight.
 */
void optics_row(const struct optics *o, double y, struct optics_row *ret)
{
    const double p = o->keystone;
    const double w = o->x1 - o->x0, h = o->y1 - o->y0;
    const double dy = y - o->y0;
    const double v = dy / (h * (1.0 - p) + p * dy);
    const double row_width = w * (1.0 - p) / (1.0 - p * v);
    const double left = 0.5 * (o->x0 + o->x1) - 0.5 * row_width;

    ret->v = v;
    ret->du = 1.0 / row_width;
    ret->u0 = -left / row_width;
}

void optics_corners(const struct optics *o, double ret_xy[4][2])
{
    const double inset = 0.5 * o->keystone * (o->x1 - o->x0);

    ret_xy[0][0] = o->x0 + inset;
    ret_xy[1][0] = o->x1 - inset;
    ret_xy[2][0] = o->x1;
    ret_xy[3][0] = o->x0;
    ret_xy[0][1] = ret_xy[1][1] = o->y0;
    ret_xy[2][1] = ret_xy[3][1] = o->y1;
}

float optics_vignette(const struct optics *o, double x, double y)
{
    const double cx = 0.5 * o->width, cy = 0.5 * o->height;
    const double r2 = ((x - cx) * (x - cx) + (y - cy) * (y - cy)) / (cx * cx + cy * cy);

    /* The cos^4 law: with tan^2 of the corner's angle t, cos^4 = 1 / (1 + t r2)^2. */
    const double t = 1.0 / sqrt(1.0 - o->vignetting) - 1.0;
    const double c = 1.0 / (1.0 + t * r2);

    return (float)(c * c);
}

float optics_lamp_fall_off(const struct optics *o, const struct ttf_sim_lamp *lamp, double u,
                           double v)
{
    const double aspect = (o->y1 - o->y0) / (o->x1 - o->x0);
    const double h2 = lamp->height * lamp->height;
    const double dx = u - lamp->x, dy = (v - lamp->y) * aspect;
    const double mx = 0.5 - lamp->x, my = (0.5 - lamp->y) * aspect;
    const double here = h2 + dx * dx + dy * dy, middle = h2 + mx * mx + my * my;
    const double q = middle / here;

    /* height / r^3: the cosine of incidence is height / r. */
    return (float)(q * sqrt(q));
}

static float clamp01(float x)
{
    return x < 0.0f ? 0.0f : x > 1.0f ? 1.0f : x;
}

void optics_resample_row(const struct optics *o, const float *src, uint32_t y, float *scratch,
                         float *ret_r, float *ret_g, float *ret_b)
{
    const int sw = (int)o->src_width, sh = (int)o->src_height;
    struct optics_row row;
    double vp;
    float cover_v, left, right, t;
    int j0, j1;

    optics_row(o, y + 0.5, &row);
    /* Rounded to 2^-16 pixel, so that a mapping of pixel to pixel is exact in spite of the divisions. */
    vp = floor(row.v * sh * 65536.0 + 0.5) / 65536.0;
    /* How much of the pixel the sample covers: its edges cross pixels where the keystone slants them. */
    left = (float)(-row.u0 / row.du);
    right = (float)((1.0 - row.u0) / row.du);
    cover_v = clamp01((float)(y + 1.0 - o->y0)) * clamp01((float)(o->y1 - (double)y));
    vp = fmin(fmax(vp - 0.5, 0.0), sh - 1.0);
    j0 = (int)vp;
    j1 = j0 + 1 < sh ? j0 + 1 : j0;
    t = (float)(vp - j0);
    {
        const float *a = src + (size_t)j0 * sw * 3, *b = src + (size_t)j1 * sw * 3;

        for (int i = 0; i < sw * 3; i++)
            scratch[i] = a[i] + t * (b[i] - a[i]);
    }
    for (uint32_t x = 0; x < o->width; x++) {
        const float up = (float)((row.u0 + (x + 0.5) * row.du) * sw);
        const float cover = cover_v * clamp01((float)x + 1.0f - left) * clamp01(right - (float)x);
        const float at = fminf(fmaxf(up - 0.5f, 0.0f), (float)(sw - 1));
        const int i0 = (int)at, i1 = i0 + 1 < sw ? i0 + 1 : i0;
        const float f = at - (float)i0, rest = (1.0f - cover) * o->margin;
        const float *a = scratch + 3 * i0, *b = scratch + 3 * i1;

        ret_r[x] = rest + cover * (a[0] + f * (b[0] - a[0]));
        ret_g[x] = rest + cover * (a[1] + f * (b[1] - a[1]));
        ret_b[x] = rest + cover * (a[2] + f * (b[2] - a[2]));
    }
}

void optics_blur_rows(const struct optics *o, const float *const *taps, uint32_t n, float *dst)
{
    const int r = o->blur_radius;
    const float w0 = o->blur[0];

    for (uint32_t x = 0; x < n; x++)
        dst[x] = w0 * taps[r][x];
    for (int k = 1; k <= r; k++) {
        const float w = o->blur[k];
        const float *a = taps[r - k], *b = taps[r + k];

        for (uint32_t x = 0; x < n; x++)
            dst[x] += w * (a[x] + b[x]);
    }
}

void optics_blur_along(const struct optics *o, const float *src, uint32_t n, float *dst)
{
    const float w0 = o->blur[0];

    for (uint32_t x = 0; x < n; x++)
        dst[x] = w0 * src[x];
    for (int k = 1; k <= o->blur_radius; k++) {
        const float w = o->blur[k];
        const float *a = src - k, *b = src + k;

        for (uint32_t x = 0; x < n; x++)
            dst[x] += w * (a[x] + b[x]);
    }
}
