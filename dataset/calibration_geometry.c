/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The geometry: how large a pixel is on the sample, how square the camera looks at it, and what the lens bends.
 *
 * Dots of a flat grid lie where a homography takes their columns and rows, and a lens moves a point at r (1: the frame's corner)
 * by one number's radial law: straight = seen (1 + k r^2) (Brown 1966, first term). For each k the homography is linear least
 * squares; k is where the rest is least.
 */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "calibration_private.h"
#include "dots.h"

#define SIDE_LEAST  5    /* columns and rows of the grid */
#define SHARE_LEAST 0.4  /* of the frame's width and height that the grid spans */
#define ASTRAY      0.3  /* of all dots that may be on no grid */
#define REST_MOST   0.05 /* of the pitch: rms of what the model leaves */
#define BEND_MOST   0.3  /* |k| */
#define BEND_STEPS  40   /* of the golden section: 0.6 x 0.618^40 is nothing */
#define UNKNOWNS    8

struct fit {
    const struct ttf_calibration *calibration;
    const struct ttf_raw_sum *frames;
    double pitch_mm;
    struct dot *dots;
    size_t n, on_grid;
    double middle_x, middle_y, radius; /* of the frame, pixels */
    double k, h[9];                    /* columns and rows to straightened, of unit radius */
    struct ttf_err *err;
};

static int refuse(const struct fit *f, const char *hint, const char *what)
{
    ttf_err_set(f->err, -EINVAL, "grid", "%s", what);
    ttf_err_hint(f->err, "%s", hint);
    return -EINVAL;
}

/* Finished pictures will do as well, where nothing is known of the camera yet. */
static int check_frames(const struct fit *f)
{
    if (f->calibration->has_dark || f->calibration->has_flat)
        return calibration_check_sum(f->calibration, f->frames, "grid", f->err);
    return f->frames->n > 0 ? 0
                            : ttf_err_set(f->err, -EINVAL, NULL, "there are no frames of a grid");
}

/* ---- light, a number a cell: 2 x 2 pixels of a mosaic, else a pixel ---- */

static double pixel_light(const struct fit *f, size_t at, uint16_t black)
{
    const struct ttf_calibration *c = f->calibration;
    double light = 0;

    for (unsigned k = 0; k < f->frames->samples; k++)
        light += (double)f->frames->sum[at * f->frames->samples + k] / f->frames->n - black;
    return c->has_flat ? light * c->flat_gain[at] : light;
}

static float *light_of(const struct fit *f, uint32_t side, uint32_t *ret_width,
                       uint32_t *ret_height)
{
    uint32_t across = f->frames->format.width;
    uint32_t width = across / side, height = f->frames->format.height / side;
    float *light = malloc((size_t)width * height * sizeof(*light));
    uint16_t black, white;

    ttf_raw_sum_levels(&f->frames->format, &black, &white);
    for (uint32_t y = 0; light && y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            double sum = 0;

            for (uint32_t i = 0; i < side * side; i++)
                sum += pixel_light(f, (size_t)(y * side + i / side) * across + x * side + i % side,
                                   black);
            light[(size_t)y * width + x] = (float)sum;
        }
    }
    *ret_width = width;
    *ret_height = height;
    return light;
}

/* The dots, in the frame's pixels, numbered. */
static int find_dots(struct fit *f)
{
    uint32_t side = f->frames->format.cfa == TTF_CFA_NONE ? 1 : 2, width, height;
    float *light = light_of(f, side, &width, &height);
    int r = light ? dots_find(light, width, height, &f->dots, &f->n) : -ENOMEM;

    free(light);
    if (r == 0)
        r = dots_number(f->dots, f->n, width, height, &f->on_grid);
    if (r == -E2BIG)
        return refuse(f, "print the grid with a wider pitch", "there are too many dots");
    if (r < 0)
        return ttf_err_set(f->err, r, "grid", "no memory to look for dots");
    for (size_t i = 0; i < f->n; i++) {
        f->dots[i].x *= side;
        f->dots[i].y *= side;
    }
    return 0;
}

/* ---- is it a grid ---- */

static int check_grid(const struct fit *f)
{
    double x0 = INFINITY, x1 = -INFINITY, y0 = INFINITY, y1 = -INFINITY;
    int32_t columns[2] = {0, 0}, rows[2] = {0, 0};

    for (size_t i = 0; i < f->n; i++) {
        const struct dot *dot = &f->dots[i];

        if (!dot->on_grid)
            continue;
        x0 = fmin(x0, dot->x);
        x1 = fmax(x1, dot->x);
        y0 = fmin(y0, dot->y);
        y1 = fmax(y1, dot->y);
        columns[0] = dot->column < columns[0] ? dot->column : columns[0];
        columns[1] = dot->column > columns[1] ? dot->column : columns[1];
        rows[0] = dot->row < rows[0] ? dot->row : rows[0];
        rows[1] = dot->row > rows[1] ? dot->row : rows[1];
    }
    if (columns[1] - columns[0] + 1 < SIDE_LEAST || rows[1] - rows[0] + 1 < SIDE_LEAST) {
        ttf_err_set(f->err, -EINVAL, "grid",
                    "%zu dots are seen, %zu of them on a grid: 5 columns and 5 rows are needed",
                    f->n, f->on_grid);
        ttf_err_hint(f->err, "dark round dots on light ground, half as wide as they are apart, and "
                             "at least 4 pixels wide (8 of a colour camera), in focus");
        return -EINVAL;
    }
    if ((double)f->on_grid < (1 - ASTRAY) * (double)f->n)
        return refuse(f, "nothing but the grid may be in the picture", "many dots are on no grid");
    if (x1 - x0 < SHARE_LEAST * f->frames->format.width ||
        y1 - y0 < SHARE_LEAST * f->frames->format.height)
        return refuse(f, "let it fill the frame: scale and lens are measured where dots are",
                      "the grid covers less than two fifths of the frame");
    return 0;
}

/* ---- the fit ---- */

/* Where a straight lens would have shown a point; unit radius. */
static void straighten(const struct fit *f, double k, double x, double y, double ret[2])
{
    double u = (x - f->middle_x) / f->radius, v = (y - f->middle_y) / f->radius;
    double by = 1 + k * (u * u + v * v);

    ret[0] = u * by;
    ret[1] = v * by;
}

static void add_equation(double a[UNKNOWNS][UNKNOWNS + 1], const double row[UNKNOWNS + 1])
{
    for (int i = 0; i < UNKNOWNS; i++)
        for (int j = 0; j <= UNKNOWNS; j++)
            a[i][j] += row[i] * row[j];
}

/* Gauss, with the largest pivot. */
static bool solve(double a[UNKNOWNS][UNKNOWNS + 1], double ret[UNKNOWNS])
{
    for (int k = 0; k < UNKNOWNS; k++) {
        int best = k;

        for (int i = k + 1; i < UNKNOWNS; i++)
            best = fabs(a[i][k]) > fabs(a[best][k]) ? i : best;
        if (!(fabs(a[best][k]) > 1e-12))
            return false;
        for (int j = k; j <= UNKNOWNS && best != k; j++) {
            double other = a[k][j];

            a[k][j] = a[best][j];
            a[best][j] = other;
        }
        for (int i = k + 1; i < UNKNOWNS; i++)
            for (int j = UNKNOWNS; j >= k; j--)
                a[i][j] -= a[i][k] / a[k][k] * a[k][j];
    }
    for (int k = UNKNOWNS - 1; k >= 0; k--) {
        ret[k] = a[k][UNKNOWNS];
        for (int j = k + 1; j < UNKNOWNS; j++)
            ret[k] -= a[k][j] * ret[j];
        ret[k] /= a[k][k];
    }
    return true;
}

static void project(const double h[9], double column, double row, double ret[2])
{
    double w = h[6] * column + h[7] * row + 1;

    ret[0] = (h[0] * column + h[1] * row + h[2]) / w;
    ret[1] = (h[3] * column + h[4] * row + h[5]) / w;
}

/* The homography for one k, and the sum of the squares that it leaves; infinite where there is none. */
static double fit_homography(const struct fit *f, double k, double h[9], double *ret_most)
{
    double a[UNKNOWNS][UNKNOWNS + 1] = {{0}}, sum = 0, most = 0;

    for (size_t i = 0; i < f->n; i++) {
        double c = f->dots[i].column, r = f->dots[i].row, p[2];

        if (!f->dots[i].on_grid)
            continue;
        straighten(f, k, f->dots[i].x, f->dots[i].y, p);
        add_equation(a, (double[]){c, r, 1, 0, 0, 0, -c * p[0], -r * p[0], p[0]});
        add_equation(a, (double[]){0, 0, 0, c, r, 1, -c * p[1], -r * p[1], p[1]});
    }
    if (!solve(a, h))
        return INFINITY;
    h[8] = 1;
    for (size_t i = 0; i < f->n; i++) {
        double p[2], q[2], off;

        if (!f->dots[i].on_grid)
            continue;
        straighten(f, k, f->dots[i].x, f->dots[i].y, p);
        project(h, f->dots[i].column, f->dots[i].row, q);
        off = (p[0] - q[0]) * (p[0] - q[0]) + (p[1] - q[1]) * (p[1] - q[1]);
        sum += off;
        most = fmax(most, off);
    }
    *ret_most = sqrt(most) * f->radius;
    return sum;
}

/* Golden section over k. */
static int fit_lens(struct fit *f, struct ttf_geometry *ret)
{
    const double golden = (sqrt(5.0) - 1) / 2;
    double lo = -BEND_MOST, hi = BEND_MOST, most, sum;

    for (int i = 0; i < BEND_STEPS; i++) {
        double a = hi - golden * (hi - lo), b = lo + golden * (hi - lo);

        if (fit_homography(f, a, f->h, &most) < fit_homography(f, b, f->h, &most))
            hi = b;
        else
            lo = a;
    }
    f->k = (lo + hi) / 2;
    sum = fit_homography(f, f->k, f->h, &most);
    if (!isfinite(sum))
        return refuse(f, "lay it flat and square", "the dots give no plane");
    ret->residual_px = sqrt(sum / (double)f->on_grid) * f->radius;
    ret->residual_max_px = most;
    return 0;
}

/* ---- what follows ---- */

/* Columns and rows at a point of the frame. */
static void grid_at(const struct fit *f, double x, double y, double ret[2])
{
    const double *h = f->h;
    double p[2], a, b, c, d, e, g, det;

    straighten(f, f->k, x, y, p);
    a = h[0] - h[6] * p[0];
    b = h[1] - h[7] * p[0];
    c = p[0] - h[2];
    d = h[3] - h[6] * p[1];
    e = h[4] - h[7] * p[1];
    g = p[1] - h[5];
    det = a * e - b * d;
    ret[0] = (c * e - b * g) / det;
    ret[1] = (a * g - c * d) / det;
}

/* Millimetres that a pixel is wide at a point: the root of its area. ret_step: grid steps along one pixel to the right. */
static double scale_at(const struct fit *f, double x, double y, double ret_step[2])
{
    double left[2], right[2], up[2], down[2];
    double xx, xy, yx, yy;

    grid_at(f, x - 0.5, y, left);
    grid_at(f, x + 0.5, y, right);
    grid_at(f, x, y - 0.5, up);
    grid_at(f, x, y + 0.5, down);
    xx = right[0] - left[0];
    xy = right[1] - left[1];
    yx = down[0] - up[0];
    yy = down[1] - up[1];
    ret_step[0] = xx;
    ret_step[1] = xy;
    return f->pitch_mm * sqrt(fabs(xx * yy - xy * yx));
}

static void derive(const struct fit *f, struct ttf_geometry *ret)
{
    double wide = f->frames->format.width, high = f->frames->format.height, step[2], unused[2];

    ret->mm_per_px = scale_at(f, f->middle_x, f->middle_y, step);
    ret->mm_per_px_least = ret->mm_per_px_most = ret->mm_per_px;
    for (int i = 0; i < 4; i++) {
        double own = scale_at(f, i % 2 ? wide : 0, i / 2 ? high : 0, unused);

        ret->mm_per_px_least = fmin(ret->mm_per_px_least, own);
        ret->mm_per_px_most = fmax(ret->mm_per_px_most, own);
    }
    /* going right in the frame the rows rise by this: the grid is turned the other way */
    ret->rotation_deg = -atan2(step[1], step[0]) * 180 / acos(-1.0);
    ret->distortion = 1 / (1 + f->k) - 1;
}

static int check_fit(const struct fit *f, const struct ttf_geometry *g)
{
    double pitch_px = f->pitch_mm / g->mm_per_px;

    if (isfinite(g->mm_per_px) && g->residual_px < REST_MOST * pitch_px)
        return 0;
    ttf_err_set(f->err, -EINVAL, "grid",
                "the dots are %.2f pixels off a flat, even grid in the mean (of %.1f from dot to "
                "dot)",
                g->residual_px, pitch_px);
    ttf_err_hint(f->err, "lay the print flat; print it at its own size, not fitted to the page");
    return -EINVAL;
}

int ttf_calibration_fit_geometry(struct ttf_calibration *calibration,
                                 const struct ttf_raw_sum *frames, double pitch_mm,
                                 struct ttf_err *err)
{
    const struct ttf_frame_format *format = &frames->format;
    struct ttf_geometry geometry = {.frames = frames->n, .pitch_mm = pitch_mm};
    struct fit f = {.calibration = calibration,
                    .frames = frames,
                    .pitch_mm = pitch_mm,
                    .middle_x = format->width / 2.0,
                    .middle_y = format->height / 2.0,
                    .radius = hypot(format->width, format->height) / 2,
                    .err = err};
    int r;

    if (!(pitch_mm > 0 && pitch_mm < 1e4))
        return ttf_err_set(err, -EINVAL, "pitch", "%g mm from dot to dot cannot be", pitch_mm);
    r = check_frames(&f);
    if (r == 0)
        r = find_dots(&f);
    if (r == 0)
        r = check_grid(&f);
    if (r == 0)
        r = fit_lens(&f, &geometry);
    if (r == 0) {
        derive(&f, &geometry);
        geometry.dots = (unsigned)f.on_grid;
        r = check_fit(&f, &geometry);
    }
    free(f.dots);
    if (r < 0)
        return r;
    calibration->geometry = geometry;
    calibration->has_geometry = true;
    return 0;
}
