/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scratch.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/calibration.h"

#define W     640
#define H     480
#define BLACK 200
#define WHITE 4095
#define FINE  4 /* looks at a pixel, each way */

static uint16_t codes[W * H];

/* A print under a camera. A point of the plane is seen where a straight lens shows it, bent by straight = seen (1 + bend r^2). */
struct shown {
    double pitch_px, turn_deg;
    double tilt;   /* the plane's denominator, at the frame's right edge */
    double bend;   /* r: 1 in the corner */
    double jitter; /* of the dots, of the pitch */
    double reach;  /* of the frame's half sides: the print ends there */
    double uneven; /* light falls by that to the corner */
    double radius; /* of the dots, of the pitch */
    bool dirt;     /* blots beside the dots, and one dot gone */
    bool litter;   /* dots without an order lie over a part of it */
    enum ttf_cfa cfa;
};

static const struct shown plain = {
    .pitch_px = 24, .turn_deg = 2.5, .reach = 2, .radius = 0.25, .cfa = TTF_CFA_NONE};

static double noise_of(int column, int row, unsigned which)
{
    uint32_t seed = (uint32_t)(column * 7919 + row * 104729) * 2u + which;

    scratch_random(&seed);
    return (scratch_random(&seed) >> 8) / 16777216.0 - 0.5;
}

/* Reflectance of a point of the frame. */
static double seen_at(const struct shown *s, double x, double y)
{
    const double radius = hypot(W, H) / 2, angle = s->turn_deg * acos(-1.0) / 180;
    const double u = (x - W / 2.0) / radius, v = (y - H / 2.0) / radius;
    const double by = (1 + s->bend * (u * u + v * v)) * radius;
    const double px = u * by, py = v * by;
    const double w = 1 + s->tilt * px / (W / 2.0);
    const double column = (px * cos(angle) + py * sin(angle)) / w / s->pitch_px;
    const double row = (-px * sin(angle) + py * cos(angle)) / w / s->pitch_px;
    const double own_column = floor(column + 0.5), own_row = floor(row + 0.5);
    const double jitter = s->litter && fabs(py) > H / 4.0 ? 0.9 : s->jitter;
    const double dx = jitter * noise_of((int)own_column, (int)own_row, 0);
    const double dy = jitter * noise_of((int)own_column, (int)own_row, 1);
    const bool gone = s->dirt && own_column == 3 && own_row == -2;

    if (fabs(px) > s->reach * W / 2 || fabs(py) > s->reach * H / 2)
        return 0.85;
    if (s->dirt && hypot(column - 2.5, row - 3.5) < 0.08)
        return 0.1;
    return !gone && hypot(column - own_column - dx, row - own_row - dy) < s->radius ? 0.05 : 0.85;
}

static double pixel(const struct shown *s, unsigned x, unsigned y)
{
    static const double colours[3] = {0.6, 1, 0.75};
    const double u = (double)x / W - 0.5, v = (double)y / H - 0.5;
    const double light = 1 - s->uneven * 2 * (u * u + v * v);
    double sum = 0;

    for (int i = 0; i < FINE; i++)
        for (int k = 0; k < FINE; k++)
            sum += seen_at(s, x + (k + 0.5) / FINE, y + (i + 0.5) / FINE);
    return sum / (FINE * FINE) * light *
           (s->cfa == TTF_CFA_NONE ? 1 : colours[x % 2 + (1 - y % 2)]);
}

static int measure(const struct shown *s, struct ttf_calibration *calibration, struct ttf_err *err)
{
    struct ttf_frame frame = {.format = {.width = W,
                                         .height = H,
                                         .stride = (size_t)W * 2,
                                         .packing = TTF_PACKING_RAW16,
                                         .cfa = s->cfa,
                                         .bits = 12,
                                         .black_level = BLACK,
                                         .white_level = WHITE},
                              .data = codes,
                              .bytes = sizeof(codes),
                              .settings = {10000000, 1000, 1000, 1000, 0}};
    struct ttf_raw_sum sum = {0};
    int r;

    for (unsigned y = 0; y < H; y++)
        for (unsigned x = 0; x < W; x++)
            codes[y * W + x] = (uint16_t)(BLACK + 3500 * pixel(s, x, y) + 0.5);
    assert_int_equal(ttf_raw_sum_init(&sum, &frame.format), 0);
    assert_int_equal(ttf_raw_sum_add(&sum, &frame), 0);
    r = ttf_calibration_fit_geometry(calibration, &sum, 5.0, err);
    ttf_raw_sum_free(&sum);
    return r;
}

static struct ttf_geometry measured(const struct shown *s)
{
    struct ttf_calibration calibration;
    struct ttf_err err = {0};

    ttf_calibration_init(&calibration);
    if (measure(s, &calibration, &err) < 0)
        fail_msg("refused: %s", err.what);
    assert_true(calibration.has_geometry);
    return calibration.geometry;
}

static void near_to(double is, double wanted, double within)
{
    if (!(fabs(is - wanted) <= within))
        fail_msg("%.8g is not %.8g, give or take %g", is, wanted, within);
}

static void a_square_look_gives_the_scale_and_the_turn(void **state)
{
    struct ttf_geometry g = measured(&plain);

    (void)state;
    near_to(g.mm_per_px, 5.0 / 24, 5.0 / 24 * 2e-4);
    near_to(g.rotation_deg, 2.5, 0.02);
    near_to(g.distortion, 0, 5e-4);
    near_to(g.mm_per_px_most / g.mm_per_px_least, 1, 2e-3);
    assert_true(g.residual_px < 0.1 && g.dots > 400);
}

static void tilt_lens_and_uneven_light_of_a_colour_camera_are_told_apart(void **state)
{
    struct shown s = plain;
    struct ttf_geometry g;

    (void)state;
    s.cfa = TTF_CFA_GBRG;
    s.pitch_px = 30;
    s.tilt = 0.05;
    s.bend = 0.06;
    s.uneven = 0.5;
    s.turn_deg = -12;
    g = measured(&s);
    /* in the middle neither tilt nor lens changes the scale */
    near_to(g.mm_per_px, 5.0 / 30, 5.0 / 30 * 1e-3);
    near_to(g.rotation_deg, -12, 0.05);
    near_to(g.distortion, 1 / 1.06 - 1, 2e-3);
    assert_true(g.residual_px < 0.15);
}

static void a_tilt_alone_makes_one_side_finer_than_the_other(void **state)
{
    struct shown s = plain;
    struct ttf_geometry g;

    (void)state;
    s.tilt = 0.05;
    g = measured(&s);
    near_to(g.mm_per_px, 5.0 / 24, 5.0 / 24 * 1e-3);
    near_to(g.distortion, 0, 1e-3);
    /* at the edges the root of the area goes as (1 + t)^-1.5 and (1 - t)^-1.5, in the plane's own points */
    assert_true(g.mm_per_px_least < 0.95 * g.mm_per_px && g.mm_per_px_most > 1.05 * g.mm_per_px);
}

static void a_pincushion_has_the_other_sign(void **state)
{
    struct shown s = plain;

    (void)state;
    s.bend = -0.05;
    near_to(measured(&s).distortion, 1 / 0.95 - 1, 2e-3);
}

static void blots_and_a_dot_that_is_gone_change_little(void **state)
{
    struct shown s = plain;

    (void)state;
    s.dirt = true;
    near_to(measured(&s).mm_per_px, 5.0 / 24, 5.0 / 24 * 3e-4);
}

static void refused(const struct shown *s, const char *why)
{
    struct ttf_calibration calibration;
    struct ttf_err err = {0};

    ttf_calibration_init(&calibration);
    assert_int_equal(measure(s, &calibration, &err), -EINVAL);
    if (!strstr(err.what, why))
        fail_msg("'%s' does not say '%s'", err.what, why);
    assert_false(calibration.has_geometry);
}

static void what_is_no_even_grid_is_refused_with_the_reason(void **state)
{
    struct shown s = plain;
    struct ttf_calibration calibration;
    struct ttf_raw_sum none = {.samples = 1};

    (void)state;
    s.radius = 0;
    refused(&s, "0 dots are seen");
    s = plain;
    s.pitch_px = 150;
    refused(&s, "5 columns and 5 rows are needed");
    s = plain;
    s.pitch_px = 16;
    s.reach = 0.3;
    refused(&s, "less than two fifths of the frame");
    s = plain;
    s.jitter = 0.25;
    refused(&s, "pixels off a flat, even grid");
    s = plain;
    s.litter = true;
    refused(&s, "many dots are on no grid");
    s = plain;
    s.pitch_px = 5.2;
    s.radius = 0.36;
    refused(&s, "there are too many dots");
    ttf_calibration_init(&calibration);
    assert_int_equal(ttf_calibration_fit_geometry(&calibration, &none, 5.0, NULL), -EINVAL);
    assert_int_equal(ttf_calibration_fit_geometry(&calibration, &none, 0.0, NULL), -EINVAL);
}

static void what_was_measured_is_kept_with_the_calibration(void **state)
{
    struct ttf_calibration kept, back;

    ttf_calibration_init(&kept);
    ttf_calibration_init(&back);
    kept.has_dark = true;
    kept.width = W;
    kept.height = H;
    kept.black_level = BLACK;
    kept.white_level = WHITE;
    kept.dark_frames = 1;
    kept.dark_settings.exposure_ns = 1000;
    kept.dark_offset_16 = calloc((size_t)W * H, sizeof(*kept.dark_offset_16));
    assert_non_null(kept.dark_offset_16);
    assert_int_equal(ttf_calibration_name(&kept, NULL), 0);
    assert_int_equal(measure(&plain, &kept, NULL), 0);
    assert_int_equal(ttf_calibration_save(&kept, ttf_io_posix(), scratch_path(state, "cal"), NULL),
                     0);
    assert_int_equal(ttf_calibration_load(ttf_io_posix(), scratch_path(state, "cal"), &back, NULL),
                     0);
    assert_true(back.has_geometry);
    assert_int_equal(back.geometry.dots, kept.geometry.dots);
    assert_true(back.geometry.mm_per_px == kept.geometry.mm_per_px);
    assert_true(back.geometry.distortion == kept.geometry.distortion);
    assert_true(back.geometry.rotation_deg == kept.geometry.rotation_deg);
    /* frames of another mode do not belong to it */
    kept.width = W / 2;
    assert_int_equal(measure(&plain, &kept, NULL), -EINVAL);
    ttf_calibration_free(&kept);
    ttf_calibration_free(&back);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_square_look_gives_the_scale_and_the_turn),
        cmocka_unit_test(tilt_lens_and_uneven_light_of_a_colour_camera_are_told_apart),
        cmocka_unit_test(a_tilt_alone_makes_one_side_finer_than_the_other),
        cmocka_unit_test(a_pincushion_has_the_other_sign),
        cmocka_unit_test(blots_and_a_dot_that_is_gone_change_little),
        cmocka_unit_test(what_is_no_even_grid_is_refused_with_the_reason),
        cmocka_unit_test_setup_teardown(what_was_measured_is_kept_with_the_calibration,
                                        scratch_make, scratch_remove),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
