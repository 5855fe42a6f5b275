/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The colour matrix. The flat has made every pixel of a grey target alike, so what is left between the camera's colours and
 * sRGB's is how their filters differ: a 3 x 3 matrix that leaves grey as it is.
 */
#include <errno.h>
#include <math.h>
#include <string.h>

#include "calibration_private.h"

#define MIDDLE       0.25 /* of a patch's side that is left out at each edge */
#define PIXELS_LEAST 16   /* of each colour in a patch */
#define SATURATED    0.98 /* of the range */
#define UNEVEN       0.25 /* deviation of a patch's pixels, of their mean */
#define DARK_PATCH   0.02 /* below it noise alone is as large as that */
#define LIGHT_OFF    2.0  /* as much brighter or darker than the flat a chart may be */
#define DELTA_E_MOST 8.0  /* mean: more is another chart, or another way round */
#define GREY_CHROMA  6.0  /* of a grey patch's values */
#define EPSILON      1e-9

/* Of one patch, by colours: reflectances as the camera sees them. */
struct patch {
    double sum[3], squares[3], most_code;
    size_t n[3];
};

struct fitting {
    const struct ttf_calibration *calibration;
    const struct ttf_raw_sum *frames;
    const struct ttf_chart *chart;
    double to_unit[9]; /* homography: homogeneous pixels to the chart's unit square */
    struct patch patches[TTF_CHART_PATCHES];
    double seen[TTF_CHART_PATCHES][3], wanted[TTF_CHART_PATCHES][3];
    struct ttf_err *err;
};

/* Twice the area of the triangle a, b, c: above 0 where they go clockwise (y goes down). */
static double turn(const double a[2], const double b[2], const double c[2])
{
    return (b[0] - a[0]) * (c[1] - b[1]) - (b[1] - a[1]) * (c[0] - b[0]);
}

static int check_corners(const struct fitting *f, const struct ttf_chart_view *view)
{
    const double(*q)[2] = view->corners;

    for (int i = 0; i < 4; i++) {
        if (!(q[i][0] >= 0 && q[i][0] <= f->calibration->width && q[i][1] >= 0 &&
              q[i][1] <= f->calibration->height))
            return ttf_err_set(f->err, -EINVAL, "corners",
                               "(%g, %g) lies outside the frame of %u x %u", q[i][0], q[i][1],
                               f->calibration->width, f->calibration->height);
    }
    for (int i = 0; i < 4; i++) {
        if (turn(q[i], q[(i + 1) % 4], q[(i + 2) % 4]) > 1)
            continue;
        ttf_err_set(f->err, -EINVAL, "corners", "the four corners do not go round a chart");
        ttf_err_hint(f->err,
                     "from the corner at 'dark skin' along the first row, clockwise: top left, "
                     "top right, bottom right, bottom left");
        return -EINVAL;
    }
    return 0;
}

/* The inverse of the square's homography onto the corners (Heckbert 1989, section 2.2.3), up to a factor. */
static void set_homography(struct fitting *f, const struct ttf_chart_view *view)
{
    const double(*q)[2] = view->corners;
    const double dx1 = q[1][0] - q[2][0], dx2 = q[3][0] - q[2][0];
    const double dy1 = q[1][1] - q[2][1], dy2 = q[3][1] - q[2][1];
    const double sx = q[0][0] - q[1][0] + q[2][0] - q[3][0];
    const double sy = q[0][1] - q[1][1] + q[2][1] - q[3][1];
    const double det = dx1 * dy2 - dx2 * dy1;
    const double g = (sx * dy2 - dx2 * sy) / det, h = (dx1 * sy - sx * dy1) / det;
    const double a = q[1][0] - q[0][0] + g * q[1][0], b = q[3][0] - q[0][0] + h * q[3][0];
    const double c = q[0][0];
    const double d = q[1][1] - q[0][1] + g * q[1][1], e = q[3][1] - q[0][1] + h * q[3][1];
    const double k = q[0][1];
    const double adjugate[9] = {e - k * h,     c * h - b,     b * k - c * e,
                                k * g - d,     a - c * g,     c * d - a * k,
                                d * h - e * g, b * g - a * h, a * e - b * d};

    memcpy(f->to_unit, adjugate, sizeof adjugate);
}

/* The patch in whose middle a point lies, or -1. */
static int patch_at(const struct fitting *f, double x, double y)
{
    const double *m = f->to_unit;
    const double w = m[6] * x + m[7] * y + m[8];
    const double u = (m[0] * x + m[1] * y + m[2]) / w * TTF_CHART_COLUMNS;
    const double v = (m[3] * x + m[4] * y + m[5]) / w * TTF_CHART_ROWS;
    const double in_u = u - floor(u), in_v = v - floor(v);

    if (!(u >= 0 && u < TTF_CHART_COLUMNS && v >= 0 && v < TTF_CHART_ROWS) || in_u < MIDDLE ||
        in_u > 1 - MIDDLE || in_v < MIDDLE || in_v > 1 - MIDDLE)
        return -1;
    return (int)v * TTF_CHART_COLUMNS + (int)u;
}

/* Which of R, G, B a pixel sees: where red's row and column are, blue's are the others. */
static unsigned colour_at(enum ttf_cfa cfa, uint32_t x, uint32_t y)
{
    const unsigned red_x = cfa == TTF_CFA_GRBG || cfa == TTF_CFA_BGGR;
    const unsigned red_y = cfa == TTF_CFA_GBRG || cfa == TTF_CFA_BGGR;

    return ((x & 1u) ^ red_x) + ((y & 1u) ^ red_y);
}

/* What a perfect diffuser gives at the chart's settings, in 1/16 codes times gain. */
static double white_of(const struct fitting *f)
{
    const struct ttf_calibration *c = f->calibration;

    return c->flat_level * 16.0 * 16384.0 /
           calibration_exposure_ratio(&c->flat_settings, &f->frames->settings);
}

static void add_pixel(struct fitting *f, uint32_t x, uint32_t y, uint16_t black, double white)
{
    const struct ttf_calibration *c = f->calibration;
    const int at = patch_at(f, x + 0.5, y + 0.5);
    const size_t i = (size_t)y * c->width + x;
    struct patch *patch;
    double code, value;
    unsigned colour;

    if (at < 0 || calibration_is_hot(c, x, y))
        return;
    patch = &f->patches[at];
    colour = colour_at(c->cfa, x, y);
    code = calibration_mean_16(f->frames, i) / 16.0;
    value = calibration_signal_16(c, f->frames, i, black) * (double)c->flat_gain[i] / white;
    patch->sum[colour] += value;
    patch->squares[colour] += value * value;
    patch->n[colour]++;
    if (code > patch->most_code)
        patch->most_code = code;
}

static void look(struct fitting *f, const struct ttf_chart_view *view)
{
    const double white = white_of(f);
    double x0 = f->calibration->width, x1 = 0, y0 = f->calibration->height, y1 = 0;
    uint16_t black, full;

    ttf_raw_sum_levels(&f->frames->format, &black, &full);
    for (int i = 0; i < 4; i++) {
        x0 = fmin(x0, view->corners[i][0]);
        x1 = fmax(x1, view->corners[i][0]);
        y0 = fmin(y0, view->corners[i][1]);
        y1 = fmax(y1, view->corners[i][1]);
    }
    for (uint32_t y = (uint32_t)y0; y < (uint32_t)y1; y++)
        for (uint32_t x = (uint32_t)x0; x < (uint32_t)x1; x++)
            add_pixel(f, x, y, black, white);
}

static int refuse_patch(const struct fitting *f, unsigned i, const char *what, const char *hint)
{
    ttf_err_set(f->err, -EINVAL, "chart", "patch %u (%s) %s", i + 1, ttf_chart_patch_name(i), what);
    ttf_err_hint(f->err, "%s", hint);
    return -EINVAL;
}

/* Means of the patches, or why they cannot be used. */
static int means(struct fitting *f)
{
    uint16_t black, full;

    ttf_raw_sum_levels(&f->frames->format, &black, &full);
    for (unsigned i = 0; i < TTF_CHART_PATCHES; i++) {
        const struct patch *p = &f->patches[i];

        for (int c = 0; c < 3; c++) {
            const double mean = p->n[c] ? p->sum[c] / (double)p->n[c] : 0;
            const double squares = p->n[c] ? p->squares[c] / (double)p->n[c] : 0;
            const double deviation = sqrt(fmax(0, squares - mean * mean));

            if (p->n[c] < PIXELS_LEAST)
                return refuse_patch(f, i, "has too few pixels",
                                    "let the chart fill more of the frame");
            if (p->most_code > black + SATURATED * (full - black))
                return refuse_patch(f, i, "is saturated", "expose shorter, the flat too");
            if (deviation > UNEVEN * fmax(mean, DARK_PATCH))
                return refuse_patch(f, i, "is not even",
                                    "give the corners of the field of patches, not of the frame "
                                    "around it; mind reflections");
            f->seen[i][c] = mean;
        }
        ttf_lab_to_linear(f->chart->lab[i], f->wanted[i]);
    }
    return 0;
}

static double luminance(const double rgb[3])
{
    return 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
}

/* The light on the chart, by its grey scale, taken out of what was seen. */
static int level(struct fitting *f, double *ret_light)
{
    double seen_wanted = 0, wanted_2 = 0;

    for (unsigned i = TTF_CHART_GREY; i < TTF_CHART_PATCHES; i++) {
        const double seen = luminance(f->seen[i]), wanted = luminance(f->wanted[i]);

        seen_wanted += seen * wanted;
        wanted_2 += wanted * wanted;
    }
    *ret_light = wanted_2 > EPSILON ? seen_wanted / wanted_2 : 0;
    if (!(*ret_light > 1 / LIGHT_OFF && *ret_light < LIGHT_OFF)) {
        ttf_err_set(f->err, -EINVAL, "chart",
                    "the grey scale is %.2f times as bright as the flat says", *ret_light);
        ttf_err_hint(f->err,
                     "are the lamps those of the flat, the corners in order, and is the last row "
                     "the grey scale, white first?");
        return -EINVAL;
    }
    for (unsigned i = 0; i < TTF_CHART_PATCHES; i++)
        for (int c = 0; c < 3; c++)
            f->seen[i][c] /= *ret_light;
    return 0;
}

/* One row (p, q, 1 - p - q): wanted - B = p (R - B) + q (G - B), by normal equations. */
static bool fit_row(const struct fitting *f, int row, double ret[3])
{
    double xx = 0, xy = 0, yy = 0, xz = 0, yz = 0, det;

    for (unsigned i = 0; i < TTF_CHART_PATCHES; i++) {
        const double *s = f->seen[i];
        const double weight = 1 / (fmax(0, luminance(f->wanted[i])) + 0.02);
        const double x = s[0] - s[2], y = s[1] - s[2], z = f->wanted[i][row] - s[2];

        xx += weight * x * x;
        xy += weight * x * y;
        yy += weight * y * y;
        xz += weight * x * z;
        yz += weight * y * z;
    }
    det = xx * yy - xy * xy;
    if (!(det > EPSILON * (1 + xx * yy)))
        return false;
    ret[0] = (xz * yy - yz * xy) / det;
    ret[1] = (yz * xx - xz * xy) / det;
    ret[2] = 1 - ret[0] - ret[1];
    return true;
}

/* How far the patches are off by a matrix. */
static void judge(const struct fitting *f, const double m[9], double *ret_mean, double *ret_max,
                  unsigned *ret_worst)
{
    *ret_mean = *ret_max = 0;
    for (unsigned i = 0; i < TTF_CHART_PATCHES; i++) {
        const double *s = f->seen[i];
        double rgb[3], lab[3], off;

        for (int c = 0; c < 3; c++)
            rgb[c] = m[3 * c] * s[0] + m[3 * c + 1] * s[1] + m[3 * c + 2] * s[2];
        ttf_linear_to_lab(rgb, lab);
        off = ttf_delta_e2000(lab, f->chart->lab[i]);
        *ret_mean += off / TTF_CHART_PATCHES;
        if (off > *ret_max) {
            *ret_max = off;
            *ret_worst = i;
        }
    }
}

/* Values in another order, or of what is no chart, would fit something too. */
static int check_values(const struct fitting *f)
{
    for (unsigned i = TTF_CHART_GREY; i < TTF_CHART_PATCHES; i++) {
        const double *lab = f->chart->lab[i];

        if (hypot(lab[1], lab[2]) < GREY_CHROMA &&
            (i == TTF_CHART_GREY || lab[0] < f->chart->lab[i - 1][0]))
            continue;
        ttf_err_set(
            f->err, -EINVAL, "chart",
            "the values' last row is no grey scale from white to black: patch %u is %.1f %.1f %.1f",
            i + 1, lab[0], lab[1], lab[2]);
        ttf_err_hint(f->err,
                     "values go by rows from 'dark skin'; of a simulated box say --scene chart");
        return -EINVAL;
    }
    return 0;
}

static int check(const struct fitting *f, const struct ttf_chart_view *view)
{
    int r = calibration_check_sum(f->calibration, f->frames, "chart", f->err);

    if (r == 0)
        r = ttf_calibration_may_take(f->calibration, TTF_CALIBRATION_CHART, f->err);
    if (r < 0)
        return r;
    if (f->calibration->cfa == TTF_CFA_NONE)
        return ttf_err_set(f->err, -EINVAL, "chart",
                           "this camera sees no colours: there is no matrix to fit");
    r = check_values(f);
    return r < 0 ? r : check_corners(f, view);
}

static int fit_matrix(struct fitting *f, struct ttf_chart_fit *fit, double ret[9])
{
    static const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    double before_max;

    for (int row = 0; row < 3; row++) {
        if (!fit_row(f, row, ret + 3 * (size_t)row))
            return ttf_err_set(f->err, -EINVAL, "chart", "the patches are all of one colour");
    }
    judge(f, identity, &fit->delta_e_before_mean, &before_max, &fit->worst);
    judge(f, ret, &fit->delta_e_mean, &fit->delta_e_max, &fit->worst);
    if (fit->delta_e_mean <= DELTA_E_MOST)
        return 0;
    ttf_err_set(f->err, -EINVAL, "chart",
                "these are not the colours of this chart: CIEDE2000 %.1f in the mean, %.1f at "
                "patch %u (%s)",
                fit->delta_e_mean, fit->delta_e_max, fit->worst + 1,
                ttf_chart_patch_name(fit->worst));
    ttf_err_hint(f->err, "begin at the corner of 'dark skin' and go clockwise; another chart "
                         "needs values of its own");
    return -EINVAL;
}

int ttf_calibration_fit_chart(struct ttf_calibration *calibration, const struct ttf_raw_sum *frames,
                              const struct ttf_chart_view *view, const struct ttf_chart *chart,
                              struct ttf_err *err)
{
    struct fitting f = {.calibration = calibration, .frames = frames, .chart = chart, .err = err};
    struct ttf_chart_fit fit = {.frames = frames->n, .view = *view};
    double matrix[9];
    int r = check(&f, view);

    if (r < 0)
        return r;
    set_homography(&f, view);
    look(&f, view);
    r = means(&f);
    if (r == 0)
        r = level(&f, &fit.light);
    if (r == 0)
        r = fit_matrix(&f, &fit, matrix);
    if (r < 0)
        return r;
    memcpy(calibration->colour_matrix, matrix, sizeof matrix);
    calibration->chart = fit;
    calibration->has_chart = true;
    return 0;
}
