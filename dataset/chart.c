/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/chart.h"

#include <math.h>
#include <string.h>

/* X-Rite, "ColorChecker Classic", L*a*b* D50 of charts made since November 2014. */
static const struct ttf_chart classic = {{
    {37.54, 14.37, 14.92},  {64.66, 19.27, 17.50},   {49.32, -3.82, -22.54}, {43.46, -12.74, 22.72},
    {54.94, 9.61, -24.79},  {70.48, -32.26, -0.37},  {62.73, 35.83, 56.50},  {39.43, 10.75, -45.17},
    {50.57, 48.64, 16.67},  {30.10, 22.54, -20.87},  {71.77, -24.13, 58.19}, {71.51, 18.24, 67.37},
    {28.37, 15.42, -49.80}, {54.38, -39.72, 32.27},  {42.43, 51.05, 28.62},  {81.80, 2.67, 80.41},
    {50.63, 51.28, -14.12}, {49.57, -29.71, -28.32}, {95.19, -1.03, 2.93},   {81.29, -0.57, 0.44},
    {66.89, -0.75, -0.06},  {50.76, -0.13, 0.14},    {35.63, -0.46, -0.48},  {20.64, 0.07, -0.46},
}};

static const char *const names[TTF_CHART_PATCHES] = {
    "dark skin", "light skin",    "blue sky",     "foliage",   "blue flower",  "bluish green",
    "orange",    "purplish blue", "moderate red", "purple",    "yellow green", "orange yellow",
    "blue",      "green",         "red",          "yellow",    "magenta",      "cyan",
    "white",     "neutral 8",     "neutral 6.5",  "neutral 5", "neutral 3.5",  "black",
};

void ttf_chart_classic(struct ttf_chart *ret)
{
    *ret = classic;
}

const char *ttf_chart_patch_name(unsigned i)
{
    return i < TTF_CHART_PATCHES ? names[i] : "";
}

/* ---- L*a*b* and linear light ---- */

static const double white_d50[3] = {0.96422, 1.0, 0.82521};

/* XYZ of D50 to linear sRGB (white D65) by Bradford, and back; rows sum to the whites. */
static const double to_srgb[9] = {3.1338561, -1.6168667, -0.4906146, -0.9787684, 1.9161415,
                                  0.0334540, 0.0719453,  -0.2289914, 1.4052427};
static const double to_xyz[9] = {0.4360747, 0.3850649, 0.1430804, 0.2225045, 0.7168786,
                                 0.0606169, 0.0139322, 0.0971045, 0.7141733};

#define LAB_KNEE  (216.0 / 24389.0)
#define LAB_SLOPE (24389.0 / 27.0)

static void times(const double m[9], const double v[3], double ret[3])
{
    for (int i = 0; i < 3; i++)
        ret[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
}

static double from_lightness(double f)
{
    const double cube = f * f * f;

    return cube > LAB_KNEE ? cube : (116.0 * f - 16.0) / LAB_SLOPE;
}

static double lightness(double t)
{
    return t > LAB_KNEE ? cbrt(t) : (LAB_SLOPE * t + 16.0) / 116.0;
}

void ttf_lab_to_linear(const double lab[3], double ret_rgb[3])
{
    const double fy = (lab[0] + 16.0) / 116.0;
    const double f[3] = {fy + lab[1] / 500.0, fy, fy - lab[2] / 200.0};
    double xyz[3];

    for (int i = 0; i < 3; i++)
        xyz[i] = white_d50[i] * from_lightness(f[i]);
    times(to_srgb, xyz, ret_rgb);
}

void ttf_linear_to_lab(const double rgb[3], double ret_lab[3])
{
    double xyz[3], f[3];

    times(to_xyz, rgb, xyz);
    for (int i = 0; i < 3; i++)
        f[i] = lightness(xyz[i] / white_d50[i]);
    ret_lab[0] = 116.0 * f[1] - 16.0;
    ret_lab[1] = 500.0 * (f[0] - f[1]);
    ret_lab[2] = 200.0 * (f[1] - f[2]);
}

/* ---- CIEDE2000 ---- */

#define DEGREES (180.0 / 3.14159265358979323846)

/* A colour with a* stretched where it is nearly grey. */
struct polar {
    double lightness, chroma, hue; /* hue in degrees, 0..360 */
};

static struct polar polar_of(const double lab[3], double stretch)
{
    const double a = lab[1] * stretch;
    struct polar p = {.lightness = lab[0], .chroma = hypot(a, lab[2])};

    p.hue = p.chroma > 0 ? atan2(lab[2], a) * DEGREES : 0;
    if (p.hue < 0)
        p.hue += 360;
    return p;
}

/* c^7 / (c^7 + 25^7), under a root: how far a colour is from grey. */
static double vividness(double chroma)
{
    const double c7 = pow(chroma, 7);

    return sqrt(c7 / (c7 + 6103515625.0));
}

static double hue_difference(const struct polar *a, const struct polar *b)
{
    double d = b->hue - a->hue;

    if (a->chroma * b->chroma == 0)
        return 0;
    if (d > 180)
        d -= 360;
    else if (d < -180)
        d += 360;
    return d;
}

static double mean_hue(const struct polar *a, const struct polar *b)
{
    const double sum = a->hue + b->hue;

    if (a->chroma * b->chroma == 0)
        return sum;
    if (fabs(a->hue - b->hue) <= 180)
        return sum / 2;
    return sum < 360 ? (sum + 360) / 2 : (sum - 360) / 2;
}

double ttf_delta_e2000(const double lab_a[3], const double lab_b[3])
{
    const double c_mean = (hypot(lab_a[1], lab_a[2]) + hypot(lab_b[1], lab_b[2])) / 2;
    const double stretch = 1 + 0.5 * (1 - vividness(c_mean));
    const struct polar a = polar_of(lab_a, stretch), b = polar_of(lab_b, stretch);
    const double l = (a.lightness + b.lightness) / 2 - 50, c = (a.chroma + b.chroma) / 2;
    const double h = mean_hue(&a, &b);
    const double t = 1 - 0.17 * cos((h - 30) / DEGREES) + 0.24 * cos(2 * h / DEGREES) +
                     0.32 * cos((3 * h + 6) / DEGREES) - 0.20 * cos((4 * h - 63) / DEGREES);
    const double dl = (b.lightness - a.lightness) / (1 + 0.015 * l * l / sqrt(20 + l * l));
    const double dc = (b.chroma - a.chroma) / (1 + 0.045 * c);
    const double dh = 2 * sqrt(a.chroma * b.chroma) * sin(hue_difference(&a, &b) / 2 / DEGREES) /
                      (1 + 0.015 * c * t);
    const double turn = 30 * exp(-(h - 275) / 25 * ((h - 275) / 25));
    const double turned = -sin(2 * turn / DEGREES) * 2 * vividness(c);

    return sqrt(fmax(0, dl * dl + dc * dc + dh * dh + turned * dc * dh));
}
