/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "scratch.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/colour.h"

#define W     480
#define H     320
#define BLACK 256
#define WHITE 4095
#define FULL  3000.0 /* codes of a perfect diffuser above black */

static uint16_t codes[W * H];

static struct ttf_frame_format format = {.width = W,
                                         .height = H,
                                         .stride = (size_t)W * 2,
                                         .packing = TTF_PACKING_RAW16,
                                         .cfa = TTF_CFA_GBRG,
                                         .bits = 12,
                                         .black_level = BLACK,
                                         .white_level = WHITE};

/* What the camera's filters are to be undone by: rows sum to 1. */
static const double wanted_matrix[9] = {1.6, -0.5, -0.1, -0.3, 1.5, -0.2, 0.05, -0.45, 1.4};

/* The chart's unit square to pixels, with a keystone, and how much light falls on it. */
static const double to_pixels[9] = {400, 25, 30, 10, 260, 22, 0.05, 0.12, 1};

struct shown {
    struct ttf_chart chart;
    double light, camera[9];
    bool turned; /* by half a turn */
};

static void invert(const double m[9], double ret[9])
{
    const double det = m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) +
                       m[2] * (m[3] * m[7] - m[4] * m[6]);

    for (int i = 0; i < 3; i++) {
        for (int k = 0; k < 3; k++) {
            const int a = (k + 1) % 3, b = (k + 2) % 3, c = (i + 1) % 3, d = (i + 2) % 3;

            ret[3 * i + k] = (m[3 * a + c] * m[3 * b + d] - m[3 * a + d] * m[3 * b + c]) / det;
        }
    }
}

static void times(const double m[9], const double v[3], double ret[3])
{
    for (int i = 0; i < 3; i++)
        ret[i] = m[3 * i] * v[0] + m[3 * i + 1] * v[1] + m[3 * i + 2] * v[2];
}

static void corner(double u, double v, double ret[2])
{
    const double at[3] = {u, v, 1};
    double p[3];

    times(to_pixels, at, p);
    ret[0] = p[0] / p[2];
    ret[1] = p[1] / p[2];
}

static struct ttf_chart_view view_of_all(void)
{
    struct ttf_chart_view view;

    corner(0, 0, view.corners[0]);
    corner(1, 0, view.corners[1]);
    corner(1, 1, view.corners[2]);
    corner(0, 1, view.corners[3]);
    return view;
}

/* Uneven light and a white balance, the same on flat and chart. */
static double light_at(unsigned x, unsigned y)
{
    static const double colours[3] = {0.55, 1, 0.7};
    const unsigned colour = (x % 2) + (1 - y % 2); /* GBRG */
    const double u = (double)x / W - 0.5, v = (double)y / H - 0.5;

    return FULL / 1.1 * colours[colour] * (1.1 - u * u - v * v);
}

/* Reflectance of colour c at a pixel, in the camera's colours: patches with dark gaps between. */
static double seen_at(const struct shown *s, const double back[9], unsigned x, unsigned y, int c)
{
    const double at[3] = {x + 0.5, y + 0.5, 1};
    double p[3], rgb[3], camera[3], u, v;
    int patch;

    times(back, at, p);
    u = p[0] / p[2] * TTF_CHART_COLUMNS;
    v = p[1] / p[2] * TTF_CHART_ROWS;
    if (!(u >= 0 && u < TTF_CHART_COLUMNS && v >= 0 && v < TTF_CHART_ROWS) ||
        fabs(u - floor(u) - 0.5) > 0.42 || fabs(v - floor(v) - 0.5) > 0.42)
        return 0.04;
    patch = (int)v * TTF_CHART_COLUMNS + (int)u;
    ttf_lab_to_linear(s->chart.lab[s->turned ? TTF_CHART_PATCHES - 1 - patch : patch], rgb);
    times(s->camera, rgb, camera);
    return fmax(0, camera[c]);
}

static void shoot(struct ttf_raw_sum *sum, const struct shown *s)
{
    struct ttf_frame frame = {.format = format,
                              .data = codes,
                              .bytes = sizeof(codes),
                              .settings = {10000000, 1000, 1000, 1000, 0}};
    double back[9];

    invert(to_pixels, back);
    for (unsigned y = 0; y < H; y++) {
        for (unsigned x = 0; x < W; x++) {
            const int colour = (int)(x % 2 + (1 - y % 2));
            const double seen = s ? s->light * seen_at(s, back, x, y, colour) : 0.8;

            codes[y * W + x] = (uint16_t)fmin(WHITE, BLACK + light_at(x, y) * seen + 0.5);
        }
    }
    assert_int_equal(ttf_raw_sum_init(sum, &format), 0);
    assert_int_equal(ttf_raw_sum_add(sum, &frame), 0);
}

static void begin(struct ttf_calibration *calibration, struct shown *s)
{
    struct ttf_raw_sum flat;
    struct ttf_err err = {0};

    ttf_calibration_init(calibration);
    shoot(&flat, NULL);
    if (ttf_calibration_fit_flat(calibration, &flat, 0.8, &err) < 0)
        fail_msg("%s", err.what);
    ttf_raw_sum_free(&flat);
    memset(s, 0, sizeof(*s));
    ttf_chart_classic(&s->chart);
    s->light = 0.93;
    invert(wanted_matrix, s->camera);
}

static int fit(struct ttf_calibration *calibration, const struct shown *s,
               const struct ttf_chart_view *view, struct ttf_err *err)
{
    struct ttf_raw_sum sum;
    struct ttf_chart chart;
    int r;

    ttf_chart_classic(&chart);
    shoot(&sum, s);
    r = ttf_calibration_fit_chart(calibration, &sum, view, &chart, err);
    ttf_raw_sum_free(&sum);
    return r;
}

static void a_chart_seen_at_a_slant_gives_the_matrix_back(void **state)
{
    const struct ttf_chart_view view = view_of_all();
    struct ttf_calibration c;
    struct ttf_err err = {0};
    struct shown s;

    begin(&c, &s);
    if (fit(&c, &s, &view, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_true(c.has_chart);
    for (int i = 0; i < 9; i++)
        assert_float_equal(c.colour_matrix[i], wanted_matrix[i], 0.03);
    for (int row = 0; row < 3; row++) /* grey stays grey */
        assert_float_equal(c.colour_matrix[3 * row] + c.colour_matrix[3 * row + 1] +
                               c.colour_matrix[3 * row + 2],
                           1.0, 1e-12);
    assert_float_equal(c.chart.light, 0.93, 0.005);
    assert_true(c.chart.delta_e_before_mean > 5);
    assert_true(c.chart.delta_e_mean < 0.7);
    ttf_calibration_free(&c);
}

static void an_exposure_unlike_the_flats_is_accounted_for(void **state)
{
    const struct ttf_chart_view view = view_of_all();
    struct ttf_calibration c;
    struct ttf_err err = {0};
    struct shown s;

    begin(&c, &s);
    c.flat_settings.exposure_ns *=
        2; /* as if the flat had been exposed twice as long: the same codes are half the light */
    s.light = 0.45;
    assert_int_equal(fit(&c, &s, &view, &err), 0);
    assert_float_equal(c.chart.light, 0.9, 0.005);
    ttf_calibration_free(&c);
}

static void assert_refused(struct ttf_calibration *c, const struct shown *s,
                           const struct ttf_chart_view *view, const char *what, const char *hint)
{
    struct ttf_err err = {0};

    if (fit(c, s, view, &err) != -EINVAL)
        fail_msg("is not refused: '%s', CIEDE2000 %g", what, c->chart.delta_e_mean);
    if (!strstr(err.what, what))
        fail_msg("'%s' does not say '%s'", err.what, what);
    if (!strstr(err.hint, hint))
        fail_msg("'%s' does not say '%s'", err.hint, hint);
    assert_false(c->has_chart);
    assert_float_equal(c->colour_matrix[0], 1, 0);
    assert_float_equal(c->colour_matrix[1], 0, 0);
}

static void what_is_no_chart_is_refused_with_the_reason(void **state)
{
    const struct ttf_chart_view all = view_of_all();
    struct ttf_chart_view view = all;
    struct ttf_calibration c;
    struct shown s;

    begin(&c, &s);
    s.turned = true;
    assert_refused(&c, &s, &all, "grey scale is", "white first");
    s.turned = false;
    s.light = 1.95;
    assert_refused(&c, &s, &all, "patch 19 (white) is saturated", "shorter");
    s.light = 0.93;
    for (int i = 0; i < 4; i++)
        view.corners[i][0] += 30; /* half a patch */
    assert_refused(&c, &s, &view, "is not even", "corners of the field");
    view = all;
    view.corners[1][0] = all.corners[3][0];
    view.corners[1][1] = all.corners[3][1];
    view.corners[3][0] = all.corners[1][0];
    view.corners[3][1] = all.corners[1][1];
    assert_refused(&c, &s, &view, "do not go round", "clockwise");
    view = all;
    view.corners[2][0] = W + 5;
    assert_refused(&c, &s, &view, "outside the frame", "");
    for (int i = 0; i < 4; i++) {
        view.corners[i][0] = 200 + 20 * (i == 1 || i == 2);
        view.corners[i][1] = 150 + 14 * (i >= 2);
    }
    assert_refused(&c, &s, &view, "too few pixels", "fill more");
    for (unsigned i = 0; i < TTF_CHART_GREY / 2; i++) { /* another chart, with the same greys */
        double other[3];

        memcpy(other, s.chart.lab[i], sizeof(other));
        memcpy(s.chart.lab[i], s.chart.lab[TTF_CHART_GREY - 1 - i], sizeof(other));
        memcpy(s.chart.lab[TTF_CHART_GREY - 1 - i], other, sizeof(other));
    }
    assert_refused(&c, &s, &all, "not the colours of this chart", "values of its own");
    ttf_calibration_free(&c);
}

static void charts_without_colours_are_refused(void **state)
{
    const struct ttf_chart_view view = view_of_all();
    struct ttf_calibration c;
    struct ttf_raw_sum sum;
    struct ttf_chart grey;
    struct ttf_err err = {0};
    struct shown s;

    (void)state;
    begin(&c, &s);
    for (unsigned i = 0; i < TTF_CHART_PATCHES; i++)
        s.chart.lab[i][1] = s.chart.lab[i][2] = 0;
    grey = s.chart;
    shoot(&sum, &s);
    assert_int_equal(ttf_calibration_fit_chart(&c, &sum, &view, &grey, &err), -EINVAL);
    assert_non_null(strstr(err.what, "all of one colour"));
    /* nor is there a matrix for a camera that sees none */
    ttf_raw_sum_free(&sum);
    c.cfa = TTF_CFA_NONE;
    assert_int_equal(fit(&c, &s, &view, &err), -EINVAL);
    assert_false(c.has_chart);
    ttf_calibration_free(&c);
}

static void a_chart_is_measured_after_the_flat(void **state)
{
    const struct ttf_chart_view view = view_of_all();
    struct ttf_calibration c, empty;
    struct shown s;

    begin(&c, &s);
    ttf_calibration_init(&empty);
    assert_refused(&empty, &s, &view, "no flat yet", "after a flat");
    ttf_calibration_free(&c);
}

static void what_was_fitted_is_kept_in_the_folder(void **state)
{
    const struct ttf_chart_view view = view_of_all();
    const char *folder = scratch_path(state, "cal");
    struct ttf_io *io = ttf_io_posix();
    struct ttf_calibration c, again;
    struct ttf_err err = {0};
    struct shown s;

    begin(&c, &s);
    assert_int_equal(fit(&c, &s, &view, &err), 0);
    assert_int_equal(ttf_calibration_name(&c, &err), 0);
    assert_int_equal(ttf_calibration_save(&c, io, folder, &err), 0);
    if (ttf_calibration_load(io, folder, &again, &err) < 0)
        fail_msg("%s", err.what);
    assert_string_equal(again.id, c.id);
    assert_true(again.has_chart);
    assert_memory_equal(again.colour_matrix, c.colour_matrix, sizeof(c.colour_matrix));
    assert_int_equal(again.chart.frames, 1);
    assert_int_equal(again.chart.worst, c.chart.worst);
    assert_float_equal(again.chart.delta_e_max, c.chart.delta_e_max, 1e-12);
    assert_float_equal(again.chart.view.corners[2][1], view.corners[2][1], 1e-9);
    ttf_calibration_free(&again);
    ttf_calibration_free(&c);
}

/* Sharma, Wu and Dalal 2005, table 1: pairs 1, 7, 9, 11, 17, 25, 34. */
static void ciede2000_gives_its_authors_figures(void **state)
{
    static const struct {
        double a[3], b[3], delta;
    } pairs[] = {
        {{50, 2.6772, -79.7751}, {50, 0, -82.7485}, 2.0425},
        {{50, 0, 0}, {50, -1, 2}, 2.3669},
        {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0009}, 7.1792},
        {{50, 2.4900, -0.0010}, {50, -2.4900, 0.0011}, 7.2195},
        {{50, 2.5, 0}, {73, 25, -18}, 27.1492},
        {{60.2574, -34.0099, 36.2677}, {60.4626, -34.1751, 39.4387}, 1.2644},
        {{2.0776, 0.0795, -1.1350}, {0.9033, -0.0636, -0.5514}, 0.9082},
    };

    for (unsigned i = 0; i < TTF_COUNT_OF(pairs); i++) {
        assert_float_equal(ttf_delta_e2000(pairs[i].a, pairs[i].b), pairs[i].delta, 5e-5);
        assert_float_equal(ttf_delta_e2000(pairs[i].b, pairs[i].a), pairs[i].delta, 5e-5);
    }
}

static void lab_and_linear_light_are_two_names_of_one_colour(void **state)
{
    static const double white[3] = {100, 0, 0}, dark_skin[3] = {37.986, 13.555, 14.059};
    double rgb[3], lab[3];

    ttf_lab_to_linear(white, rgb);
    for (int c = 0; c < 3; c++)
        assert_float_equal(rgb[c], 1, 1e-5);
    ttf_lab_to_linear(
        dark_skin,
        rgb); /* 115, 81, 67 in sRGB: D. Pascale, RGB coordinates of the ColorChecker, 2006 */
    assert_float_equal(255 * (double)ttf_srgb_encode((float)rgb[0]), 115, 1);
    assert_float_equal(255 * (double)ttf_srgb_encode((float)rgb[1]), 81, 1);
    assert_float_equal(255 * (double)ttf_srgb_encode((float)rgb[2]), 67, 1);
    ttf_linear_to_lab(rgb, lab);
    for (int c = 0; c < 3; c++)
        assert_float_equal(lab[c], dark_skin[c], 1e-4);
}

/* ---- files of values ---- */

static int load(void **state, const char *text, struct ttf_chart *chart, struct ttf_err *err)
{
    memset(err, 0, sizeof(*err));
    scratch_write(state, "values.txt", text, strlen(text));
    return ttf_chart_load(ttf_io_posix(), scratch_path(state, "values.txt"), chart, err);
}

/* 24 lines: L* is 10 + the patch by rows; named: A1, A2, ... as makers order them, by columns. */
static void put_lines(char *text, size_t size, bool named, const char *between)
{
    size_t used = strlen(text);

    for (unsigned i = 0; i < TTF_CHART_PATCHES; i++) {
        const unsigned column = i / TTF_CHART_ROWS, row = i % TTF_CHART_ROWS;
        const unsigned patch = named ? row * TTF_CHART_COLUMNS + column : i;
        char name[8] = "";

        if (named)
            (void)snprintf(name, sizeof(name), "%c%u%s", (char)('A' + column), row + 1, between);
        used += (size_t)snprintf(text + used, size - used, "%s%u%s-1.5%s2\n", name, 10 + patch,
                                 between, between);
    }
}

static void assert_in_order(const struct ttf_chart *chart)
{
    for (unsigned i = 0; i < TTF_CHART_PATCHES; i++) {
        assert_float_equal(chart->lab[i][0], 10 + i, 0);
        assert_float_equal(chart->lab[i][1], -1.5, 0);
        assert_float_equal(chart->lab[i][2], 2, 0);
    }
}

static void values_are_read_as_makers_and_programs_write_them(void **state)
{
    char text[4096] = "# measured in May\nL,a,b\n";
    struct ttf_chart chart;
    struct ttf_err err;

    put_lines(text, sizeof(text), false, ",");
    assert_int_equal(load(state, text, &chart, &err), 0);
    assert_in_order(&chart);
    (void)snprintf(text, sizeof(text),
                   "CGATS.17\nNUMBER_OF_FIELDS 4\nREFERENCE 1 2 3\nBEGIN_DATA_FORMAT\n"
                   "SAMPLE_NAME LAB_L LAB_A LAB_B\nEND_DATA_FORMAT\nBEGIN_DATA\n");
    put_lines(text, sizeof(text), true, "\t");
    (void)snprintf(text + strlen(text), sizeof(text) - strlen(text), "END_DATA\nA1 1 2 3\n");
    assert_int_equal(load(state, text, &chart, &err), 0);
    assert_in_order(&chart);
    text[0] = '\0'; /* as spreadsheets elsewhere write it: quotes, semicolons, CR LF */
    for (int row = 0, i = 0; row < 4; row++)
        for (int column = 0; column < 6; column++, i++)
            (void)snprintf(text + strlen(text), sizeof(text) - strlen(text),
                           " \"%c%d\"; skin, dark; %d; %d; %d\r\n", 'a' + column, row + 1, 10 + i,
                           i, -i);
    assert_int_equal(load(state, text, &chart, &err), 0);
    for (int i = 0; i < TTF_CHART_PATCHES; i++) {
        assert_float_equal(chart.lab[i][0], 10 + i, 1e-9);
        assert_float_equal(chart.lab[i][2], -i, 1e-9);
    }
}

static void decimal_commas_are_refused_and_not_misread(void **state)
{
    struct ttf_chart chart;
    struct ttf_err err;

    assert_int_equal(load(state, "A1;37,99;13,56;14,06\n", &chart, &err), -EINVAL);
    assert_non_null(strstr(err.what, "with a point"));
    assert_non_null(strstr(err.where, "values.txt:1"));
    assert_int_equal(load(state, "37,99\t13,56\t14,06\n", &chart, &err), -EINVAL);
    assert_non_null(strstr(err.what, "with a point"));
}

static void values_that_do_not_make_a_chart_are_refused_with_their_line(void **state)
{
    char text[4096] = "";
    struct ttf_chart chart;
    struct ttf_err err;

    assert_int_equal(load(state, "37 13 14\n65 18 17\n", &chart, &err), -EINVAL);
    assert_non_null(strstr(err.what, "of 2 patches"));
    assert_int_equal(load(state, "A1 37 13 14\nA1 65 18 17\n", &chart, &err), -EINVAL);
    assert_non_null(strstr(err.where, "values.txt:2"));
    assert_int_equal(load(state, "A1 37 13 14\n65 18 17\n", &chart, &err), -EINVAL);
    assert_non_null(strstr(err.what, "some do not"));
    for (unsigned i = 0; i < 4; i++) {
        static const char *const WRONG[4] = {"337 13 14\n", "-1 13 14\n", "37 213 14\n",
                                             "37 13 -214\n"};

        assert_int_equal(load(state, WRONG[i], &chart, &err), -EINVAL);
        assert_non_null(strstr(err.what, "no L*"));
    }
    /* G1, A5, A11 and a word name no patch: these are lines without names, of which there are too few. */
    assert_int_equal(
        load(state, "G1 37 13 14\nA5 1 2 3\nA11 1 2 3\nx 1 2 3\n1 2 inf\n", &chart, &err), -EINVAL);
    assert_non_null(strstr(err.what, "of 4 patches"));
    put_lines(text, sizeof(text), false, " ");
    (void)snprintf(text + strlen(text), sizeof(text) - strlen(text), "50 0 0\n");
    assert_int_equal(load(state, text, &chart, &err), -EINVAL);
    assert_non_null(strstr(err.what, "more than 24"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_chart_seen_at_a_slant_gives_the_matrix_back),
        cmocka_unit_test(an_exposure_unlike_the_flats_is_accounted_for),
        cmocka_unit_test(what_is_no_chart_is_refused_with_the_reason),
        cmocka_unit_test(charts_without_colours_are_refused),
        cmocka_unit_test(a_chart_is_measured_after_the_flat),
        cmocka_unit_test(what_was_fitted_is_kept_in_the_folder),
        cmocka_unit_test(ciede2000_gives_its_authors_figures),
        cmocka_unit_test(lab_and_linear_light_are_two_names_of_one_colour),
        cmocka_unit_test(values_are_read_as_makers_and_programs_write_them),
        cmocka_unit_test(decimal_commas_are_refused_and_not_misread),
        cmocka_unit_test(values_that_do_not_make_a_chart_are_refused_with_their_line),
    };

    return cmocka_run_group_tests(tests, scratch_make, scratch_remove);
}
