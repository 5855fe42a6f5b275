/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "control/curvature.h"
#include "made.h"
#include "ttf/synth/rate_map.h"

/* Of the paper's sigmoid, by solving k' = 0 of the closed form elsewhere. */
#define SIGMOID_PEAK_X 1.36375
#define SIGMOID_PEAK_K 0.0924509

static void near(double got, double want, double by)
{
    if (!(fabs(got - want) <= by))
        fail_msg("%.9g is not within %g of %.9g", got, by, want);
}

static struct ttf_rate_map bent(const struct ttf_curve *curve, uint32_t width, double offset,
                                double gain)
{
    struct ttf_rate_map map = {0};
    struct ttf_err err = {0};

    if (ttf_rate_map_of_curve(curve, width, 3, offset, gain, &map, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    return map;
}

static double sigmoid(void *ctx, double x)
{
    (void)ctx;
    return 1.0 / (1.0 + exp(-x));
}

static void the_paper_s_curve_bends_most_at_the_known_places(void **state)
{
    const struct ttf_curve curve = {.from = -8.0, .to = 8.0};
    struct ttf_rate_map map = bent(&curve, 1600, 0.0, 1.0);
    double sum = 0.0, n = 0.0;

    (void)state;
    for (uint32_t i = 800; i < 1600; i++) {
        near(made_at(&map, i, 0), made_at(&map, 1599 - i, 0), 1e-5);
        assert_true(made_at(&map, i, 0) == made_at(&map, i, 2)); /* swept along y */
        if (made_at(&map, i, 0) == 1.0f) {
            sum += -8.0 + (i + 0.5) / 100;
            n += 1.0;
        }
    }
    near(n, 8.0, 1.0); /* half of the 1% at and above p99 */
    near(sum / n, SIGMOID_PEAK_X, 0.01);
    near(made_at(&map, 800, 0), 0.0, 0.02); /* the turning point */
    near(made_at(&map, 1599, 0), 0.0, 0.02);
    near(ttf_control_curve_curvature(sigmoid, NULL, SIGMOID_PEAK_X, 1e-3), SIGMOID_PEAK_K, 1e-6);
    ttf_rate_map_free(&map);
}

static void offset_and_gain_scale_a_curve(void **state)
{
    const struct ttf_curve curve = {.from = -8.0, .to = 8.0};
    struct ttf_rate_map plain = bent(&curve, 200, 0.0, 1.0);
    struct ttf_rate_map map = bent(&curve, 200, 0.5, 2.0);

    (void)state;
    for (uint32_t i = 0; i < 200; i++)
        near(made_at(&map, i, 1), 0.5 + 2.0 * (double)made_at(&plain, i, 1), 1e-6);
    ttf_rate_map_free(&plain);
    ttf_rate_map_free(&map);
}

static double straight(void *ctx, double x)
{
    return *(double *)ctx + 0.3 * x;
}

static void a_straight_line_has_no_curvature_but_for_its_offset(void **state)
{
    double at = 1.0 / 3.0;
    const struct ttf_curve curve = {.y = straight, .ctx = &at, .from = -1.0, .to = 2.0};
    struct ttf_rate_map map = bent(&curve, 333, 0.25, 1.0);

    (void)state;
    for (uint32_t i = 0; i < 333; i++)
        assert_true(made_at(&map, i, 0) == 0.25f);
    ttf_rate_map_free(&map);
}

static struct ttf_spline *arc(double radius, unsigned n)
{
    struct ttf_spline *spline = NULL;
    double *xs = calloc(2 * (size_t)n, sizeof(*xs)), *ys = xs + n;

    assert_non_null(xs);
    for (unsigned i = 0; i < n; i++) {
        double angle = 0.5 + 2.0 * i / (n - 1); /* radians, from the right end of a half circle */

        xs[i] = -radius * cos(angle);
        ys[i] = radius * sin(angle);
    }
    assert_int_equal(ttf_spline_create(xs, ys, n, &spline, NULL), 0);
    free(xs);
    return spline;
}

static void a_circle_given_as_points_has_one_curvature(void **state)
{
    const double radius = 2.5;
    struct ttf_spline *spline = arc(radius, 201);
    struct ttf_curve curve = {.y = ttf_spline_at, .ctx = spline, .from = -1.5, .to = 1.5};
    struct ttf_rate_map map = bent(&curve, 300, 0.0, 1.0);

    (void)state;
    for (int i = -50; i <= 50; i++)
        near(ttf_control_curve_curvature(ttf_spline_at, spline, 0.03 * i, 1e-3), 1.0 / radius,
             2e-4);
    for (uint32_t i = 0; i < 300; i++)
        near(made_at(&map, i, 0), 1.0, 1e-3);
    ttf_rate_map_free(&map);
    ttf_spline_destroy(spline);
}

static void a_spline_goes_through_its_points_and_straight_on(void **state)
{
    const double xs[5] = {0.0, 1.0, 1.5, 4.0, 5.0}, ys[5] = {1.0, 3.0, -1.0, 0.5, 0.5};
    struct ttf_spline *spline = NULL;

    (void)state;
    assert_int_equal(ttf_spline_create(xs, ys, 5, &spline, NULL), 0);
    for (int i = 0; i < 5; i++)
        near(ttf_spline_at(spline, xs[i]), ys[i], 1e-12);
    for (int i = 1; i < 4; i++) { /* neither slope nor bend jumps at a point */
        double h = 1e-4, y[5];

        for (int k = -2; k <= 2; k++)
            y[k + 2] = ttf_spline_at(spline, xs[i] + k * h);
        near((y[4] - y[2]) / h / 2, (y[2] - y[0]) / h / 2, 0.02);
        near((y[4] - 2 * y[3] + y[2]) / (h * h), (y[2] - 2 * y[1] + y[0]) / (h * h), 0.1);
    }
    near(ttf_control_curve_curvature(ttf_spline_at, spline, 0.0, 1e-4), 0.0, 0.01);
    near(ttf_spline_at(spline, -2.0) - 1.0, 2.0 * (ttf_spline_at(spline, -1.0) - 1.0), 1e-9);
    near(ttf_spline_at(spline, 7.0) - 0.5, 2.0 * (ttf_spline_at(spline, 6.0) - 0.5), 1e-9);
    near(ttf_spline_at(spline, 5.001), 2 * 0.5 - ttf_spline_at(spline, 4.999), 1e-6);
    ttf_spline_destroy(spline);
    ttf_spline_destroy(NULL);
}

static void points_that_make_no_curve_are_refused(void **state)
{
    const double xs[4] = {0.0, 1.0, 1.0, 2.0}, ys[4] = {0.0, 1.0, (double)NAN, 3.0};
    struct ttf_spline *spline = NULL;
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(ttf_spline_create(xs, xs, 2, &spline, &err), -EINVAL);
    assert_int_equal(ttf_spline_create(xs, xs, 4, &spline, &err), -EINVAL);
    assert_true(err.hint[0] != '\0');
    assert_int_equal(ttf_spline_create(xs, ys, 3, &spline, &err), -EINVAL);
    assert_string_equal(err.where, "curve");
    assert_null(spline);
}

static double pole(void *ctx, double x)
{
    (void)ctx;
    return x > 0.0 ? 1.0 / x : (double)NAN;
}

static void impossible_curves_are_refused(void **state)
{
    struct ttf_curve curve = {.from = 1.0, .to = 1.0};
    struct ttf_rate_map map = {0};
    struct ttf_err err = {0};

    (void)state;
#define REFUSED(where)                                                                             \
    made_refused(ttf_rate_map_of_curve(&curve, 50, 5, 0.0, 1.0, &map, &err), -EINVAL, where, &err, \
                 &map)
    REFUSED("curve");
    curve.to = (double)NAN;
    REFUSED("curve");
    curve = (struct ttf_curve){.y = pole, .from = -1.0, .to = 1.0};
    REFUSED("curve");
    made_refused(ttf_rate_map_of_curve(&curve, 50, 5, 0.0, (double)NAN, &map, &err), -EINVAL,
                 "gain", &err, &map);
#undef REFUSED
}

/* A dome of radius 0.8, heights 0..1 */
static double dome(double x, double y)
{
    return sqrt(0.64 - (x - 0.5) * (x - 0.5) - (y - 0.5) * (y - 0.5));
}

static void a_dome_has_the_mean_curvature_of_its_radius(void **state)
{
    enum {
        N = 101
    };
    double *z = calloc(2 * (size_t)N * N, sizeof(*z)), *k = z + N * N;

    (void)state;
    assert_non_null(z);
    for (int y = 0; y < N; y++)
        for (int x = 0; x < N; x++)
            z[y * N + x] = dome((x + 0.5) / N, (y + 0.5) / N);
    ttf_control_mean_curvature(z, N, N, 1.0 / N, k);
    for (int i = 0; i < N * N; i++)
        near(k[i], -1.0 / 0.8, 0.005);
    free(z);
}

static double cylinder(double x, double y)
{
    double across = (x - y) / sqrt(2.0); /* its axis lies diagonally */

    return sqrt(1.0 - across * across);
}

static void a_cylinder_has_half_the_curvature_of_a_dome_whichever_way_it_lies(void **state)
{
    enum {
        N = 64
    };
    double *z = calloc(2 * (size_t)N * N, sizeof(*z)), *k = z + N * N;

    (void)state;
    assert_non_null(z);
    for (int y = 0; y < N; y++)
        for (int x = 0; x < N; x++)
            z[y * N + x] = cylinder((x + 0.5) / N, (y + 0.5) / N);
    ttf_control_mean_curvature(z, N, N, 1.0 / N, k);
    for (int i = 0; i < N * N; i++)
        near(k[i], -0.5, 0.005);
    free(z);
}

static double two_domes(double x, double y)
{
    double radius = x < 0.5 ? 0.4 : 0.8, dx = x < 0.5 ? x - 0.25 : x - 0.75, dy = y - 0.25;

    return sqrt(radius * radius - dx * dx - dy * dy); /* nowhere flat */
}

static void the_tighter_dome_ages_faster_by_the_ratio_of_radii(void **state)
{
    struct ttf_pixbuf heights = made_grey(200, 100, two_domes);
    struct ttf_rate_map map;

    (void)state;
    assert_int_equal(ttf_rate_map_of_heights(&heights, 1.0, 1.0, 200, 100, 0.0, 1.0, &map, NULL),
                     0);
    near((double)made_at(&map, 50, 50) / (double)made_at(&map, 150, 50), 2.0, 0.05);
    assert_true(made_at(&map, 97, 50) == 1.0f); /* at the step between them */
    ttf_rate_map_free(&map);
    assert_int_equal(ttf_rate_map_of_heights(&heights, -1.0, 1.0, 200, 100, 0.5, 0.25, &map, NULL),
                     0);
    assert_true(made_at(&map, 97, 50) == 0.75f); /* dents count as bumps do */
    ttf_rate_map_free(&map);
    ttf_pixbuf_free(&heights);
}

static double tilted(double x, double y)
{
    return 0.1 + 0.37 * x + 0.21 * y;
}

static void a_tilted_plane_has_no_curvature_smoothed_or_not(void **state)
{
    struct ttf_pixbuf heights = made_grey(60, 40, tilted);
    const double sigmas[3] = {0.0, 2.0, 30.0};

    (void)state;
    for (int s = 0; s < 3; s++) {
        struct ttf_rate_map map;

        assert_int_equal(
            ttf_rate_map_of_heights(&heights, 1.0, sigmas[s], 60, 40, 0.0, 1.0, &map, NULL), 0);
        for (uint32_t i = 0; i < 60 * 40; i++)
            assert_true(map.m[i] == 0.0f);
        ttf_rate_map_free(&map);
    }
    ttf_pixbuf_free(&heights);
}

static double parabola(double x, double y)
{
    (void)y;
    return x * x;
}

static void a_strip_of_one_pixel_is_a_curve(void **state)
{
    struct ttf_pixbuf heights = made_grey(50, 1, parabola);
    struct ttf_rate_map map;

    (void)state;
    assert_int_equal(ttf_rate_map_of_heights(&heights, 1.0, 0.0, 50, 1, 0.0, 1.0, &map, NULL), 0);
    for (uint32_t x = 5; x < 45; x++)
        assert_true(made_at(&map, x, 0) <
                    made_at(&map, x - 1, 0)); /* 2 / (1 + 4 x^2)^(3/2) falls */
    ttf_rate_map_free(&map);
    ttf_pixbuf_free(&heights);
}

static void impossible_heights_are_refused(void **state)
{
    struct ttf_pixbuf heights = made_grey(20, 20, tilted);
    struct ttf_rate_map map = {0};
    struct ttf_err err = {0};

    (void)state;
#define REFUSED(scale, sigma, where)                                                       \
    made_refused(                                                                          \
        ttf_rate_map_of_heights(&heights, (scale), (sigma), 20, 20, 0.0, 1.0, &map, &err), \
        -EINVAL, where, &err, &map)
    REFUSED((double)NAN, 1.0, "height_scale");
    REFUSED(1.0, -1.0, "sigma");
    REFUSED(1.0, (double)NAN, "sigma");
    REFUSED(1.0, 1000.0, "sigma");
    ((float *)ttf_pixbuf_row(&heights, 19))[0] = NAN;
    REFUSED(1.0, 1.0, "heights");
#undef REFUSED
    made_refused(ttf_rate_map_of_heights(&heights, 1.0, 1.0, 0, 20, 0.0, 1.0, &map, &err), -EINVAL,
                 "size", &err, &map);
    ttf_pixbuf_free(&heights);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_paper_s_curve_bends_most_at_the_known_places),
        cmocka_unit_test(offset_and_gain_scale_a_curve),
        cmocka_unit_test(a_straight_line_has_no_curvature_but_for_its_offset),
        cmocka_unit_test(a_circle_given_as_points_has_one_curvature),
        cmocka_unit_test(a_spline_goes_through_its_points_and_straight_on),
        cmocka_unit_test(points_that_make_no_curve_are_refused),
        cmocka_unit_test(impossible_curves_are_refused),
        cmocka_unit_test(a_dome_has_the_mean_curvature_of_its_radius),
        cmocka_unit_test(a_cylinder_has_half_the_curvature_of_a_dome_whichever_way_it_lies),
        cmocka_unit_test(the_tighter_dome_ages_faster_by_the_ratio_of_radii),
        cmocka_unit_test(a_tilted_plane_has_no_curvature_smoothed_or_not),
        cmocka_unit_test(a_strip_of_one_pixel_is_a_curve),
        cmocka_unit_test(impossible_heights_are_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
