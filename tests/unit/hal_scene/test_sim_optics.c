/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "plain_box.h"

#define W 120u
#define H 90u

static uint16_t frame[W * H];

/* A frame's pixel as a number to reckon with. */
static double at(uint32_t x, uint32_t y)
{
    return frame[y * W + x];
}

static unsigned channel_of(uint32_t x, uint32_t y)
{
    return (x & 1u) + (y & 1u);
}

static float checker(uint32_t x, uint32_t y, uint32_t w, uint32_t h, unsigned c)
{
    /* Different in every pixel and channel, and exact as an electron count. */
    return (float)((x * 37 + y * 101 + c * 300) % 1000) / 1000.0f;
}

static void without_distortion_a_pixel_of_the_frame_is_a_pixel_of_the_scene(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;

    plain_config(W, H, &config);
    plain_scene_init(&s, checker);
    plain_expose(&config, &s, 1.0f, frame);
    for (uint32_t y = 0; y < H; y++) {
        for (uint32_t x = 0; x < W; x++) {
            const long e = lroundf(1000.0f * checker(x, y, W, H, channel_of(x, y)));

            assert_int_equal(frame[y * W + x], e);
        }
    }
}

static void a_margin_shifts_the_scene_by_whole_pairs_of_pixels(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;
    double corner[4][2];
    struct sim_image_model *model;
    uint32_t x0, y0, w, h;

    plain_config(W, H, &config);
    config.margin = 0.11;
    config.margin_reflectance = 0.25;
    plain_scene_init(&s, checker);
    model = plain_model(&config, &s);
    sim_image_corners(model, corner);
    plain_shoot(model, H, 1.0f, INT64_C(1000000000), 1000, 25.0, 1, frame);
    sim_image_model_destroy(model);
    x0 = (uint32_t)corner[0][0];
    y0 = (uint32_t)corner[0][1];
    w = (uint32_t)corner[2][0] - x0;
    h = (uint32_t)corner[2][1] - y0;
    assert_true(corner[0][0] == x0 && corner[0][1] == y0);
    assert_int_equal(x0 % 2 + y0 % 2, 0);
    assert_in_range(x0, 12, 14);
    for (uint32_t y = 0; y < H; y++) {
        for (uint32_t x = 0; x < W; x++) {
            const int in = x >= x0 && x < x0 + w && y >= y0 && y < y0 + h;
            const float r = in ? checker(x - x0, y - y0, w, h, channel_of(x, y)) : 0.25f;

            assert_int_equal(frame[y * W + x], lroundf(1000.0f * r));
        }
    }
}

/* Where a row of a white sample on black begins and ends: the light lost left and right of the middle. */
static void edges_of_row(uint32_t y, double *ret_left, double *ret_right)
{
    *ret_left = 0.0;
    *ret_right = W;
    for (uint32_t x = 0; x < W / 2; x++) {
        *ret_left += 1.0 - at(x, y) / 1000.0;
        *ret_right -= 1.0 - at(W - 1 - x, y) / 1000.0;
    }
}

static void the_samples_edges_run_between_the_corners_the_model_names(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;
    struct sim_image_model *model;
    double corner[4][2];

    plain_config(W, H, &config);
    config.margin = 0.1;
    config.perspective = 0.2;
    plain_scene_init(&s, plain_white);
    model = plain_model(&config, &s);
    sim_image_corners(model, corner);
    plain_shoot(model, H, 1.0f, INT64_C(1000000000), 1000, 25.0, 1, frame);
    sim_image_model_destroy(model);
    /* The top edge is a fifth shorter than the bottom one. */
    assert_float_equal((corner[1][0] - corner[0][0]) / (corner[2][0] - corner[3][0]), 0.8, 1e-9);
    for (uint32_t y = (uint32_t)corner[0][1] + 1; y + 1 < (uint32_t)corner[3][1]; y++) {
        const double t = (y + 0.5 - corner[0][1]) / (corner[3][1] - corner[0][1]);
        double left, right;

        edges_of_row(y, &left, &right);
        assert_float_equal(left, corner[0][0] + t * (corner[3][0] - corner[0][0]), 0.03);
        assert_float_equal(right, corner[1][0] + t * (corner[2][0] - corner[1][0]), 0.03);
    }
    assert_int_equal(frame[((uint32_t)corner[0][1] - 1) * W + W / 2], 0);
    assert_int_equal(frame[(uint32_t)corner[0][1] * W + W / 2], 1000);
    assert_int_equal(frame[((uint32_t)corner[3][1] - 1) * W + W / 2], 1000);
    assert_int_equal(frame[(uint32_t)corner[3][1] * W + W / 2], 0);
}

static float lower_half(uint32_t x, uint32_t y, uint32_t w, uint32_t h, unsigned c)
{
    return 2 * y >= h ? 1.0f : 0.0f;
}

static void the_samples_middle_lands_where_the_diagonals_cross(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;
    struct sim_image_model *model;
    double c[4][2], dark = 0.0, t;

    plain_config(W, H, &config);
    config.perspective = 0.2;
    plain_scene_init(&s, lower_half);
    model = plain_model(&config, &s);
    sim_image_corners(model, c);
    plain_shoot(model, H, 1.0f, INT64_C(1000000000), 1000, 25.0, 1, frame);
    sim_image_model_destroy(model);
    for (uint32_t y = 0; y < H; y++)
        dark += 1.0 - at(W / 2, y) / 1000.0;
    /* Symmetric, so they cross in the column's middle: where the diagonal TL-BR is at W / 2. */
    t = (0.5 * W - c[0][0]) / (c[2][0] - c[0][0]);
    assert_float_equal(dark, c[0][1] + t * (c[2][1] - c[0][1]), 0.6);
    assert_true(dark < 0.5 * H - 2.0); /* not simply squeezed */
}

static void vignetting_takes_its_share_in_the_corner(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;

    plain_config(W, H, &config);
    config.vignetting = 0.4;
    config.sensitivity_e = 50000.0;
    plain_scene_init(&s, plain_white);
    plain_expose(&config, &s, 1.0f, frame);
    assert_float_equal(at(W / 2, H / 2) / 50000.0, 1.0, 0.001);
    assert_float_equal(at(0, 0) / 50000.0, 0.6, 0.01);
    assert_float_equal(at(W - 1, H - 1) / 50000.0, 0.6, 0.01);
    assert_true(frame[W / 2] > frame[0] && frame[W / 2] < frame[H / 2 * W + W / 2]);
}

static float dot(uint32_t x, uint32_t y, uint32_t w, uint32_t h, unsigned c)
{
    return x == w / 2 && y == h / 2 ? 1.0f : 0.0f;
}

static void a_point_is_spread_as_wide_as_asked_and_loses_no_light(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;
    double sum = 0.0, xx = 0.0, yy = 0.0;

    plain_config(W, H, &config);
    config.blur_px = 1.5;
    config.sensitivity_e = 60000.0;
    plain_scene_init(&s, dot);
    plain_expose(&config, &s, 1.0f, frame);
    for (uint32_t y = 0; y < H; y++) {
        for (uint32_t x = 0; x < W; x++) {
            const int cx = W / 2, cy = H / 2;
            const double dx = (int)x - cx, dy = (int)y - cy;
            const double v = at(x, y);

            sum += v;
            xx += v * dx * dx;
            yy += v * dy * dy;
        }
    }
    assert_float_equal(sum / 60000.0, 1.0, 0.01);
    /* A pixel's own width adds 1/12 on either side of the integral. */
    assert_float_equal(sqrt(xx / sum), 1.5, 0.05);
    assert_float_equal(sqrt(yy / sum), 1.5, 0.05);
}

static void expose_with_lamp(const struct ttf_sim_config *config, const float *rows)
{
    struct plain_scene s;
    struct sim_image_model *model;
    const struct ttf_exposure granted = {.exposure_ns = INT64_C(1000000000), .gain_milli = 1000};
    const struct sim_exposure_light light = {.n_lamps = 1, .lamp_rows = {rows}};

    plain_scene_init(&s, plain_white);
    model = plain_model(config, &s);
    assert_int_equal(sim_image_expose(model, 0, &light, &granted, 25.0, 1, frame, NULL), 0);
    sim_image_model_destroy(model);
}

static void a_lamp_falls_off_with_distance_and_slant(void **state)
{
    struct ttf_sim_config config;
    float rows[H];
    double near3, far3;

    for (uint32_t y = 0; y < H; y++)
        rows[y] = 1.0f;
    plain_config(W, H, &config);
    config.n_lamps = 1;
    config.lamps[0].x = 0.2;
    config.lamps[0].y = 0.5;
    config.lamps[0].height = 0.5;
    config.lamps[0].strength = 0.8;
    config.lamps[0].colour[0] = config.lamps[0].colour[1] = config.lamps[0].colour[2] = 1.0;
    config.sensitivity_e = 20000.0;
    expose_with_lamp(&config, rows);
    assert_float_equal(at(W / 2, H / 2) / 20000.0, 0.8, 0.01);
    /* Irradiance goes as height / r^3. Of the pixels at u = 0.2 and u = 0.9: */
    near3 = pow(0.25, 1.5);
    far3 = pow(0.25 + 0.49, 1.5);
    assert_float_equal(at(W * 9 / 10, H / 2) / at(W / 5, H / 2), near3 / far3, 0.015);
}

static void a_lamps_colour_and_its_rows_reach_the_pixels(void **state)
{
    struct ttf_sim_config config;
    float rows[H];

    for (uint32_t y = 0; y < H; y++)
        rows[y] = y < H / 2 ? 1.0f : 0.5f;
    plain_config(W, H, &config);
    config.n_lamps = 1;
    config.lamps[0].x = config.lamps[0].y = 0.5;
    config.lamps[0].height = 1000.0; /* even */
    config.lamps[0].strength = 1.0;
    config.lamps[0].colour[0] = 0.5;
    config.lamps[0].colour[1] = 1.0;
    config.lamps[0].colour[2] = 0.25;
    config.channel_gain[2] = 0.8;
    expose_with_lamp(&config, rows);
    assert_int_equal(frame[10 * W + 10], 500);
    assert_int_equal(frame[10 * W + 11], 1000);
    assert_int_equal(frame[11 * W + 10], 1000);
    assert_int_equal(frame[11 * W + 11], 200);
    assert_int_equal(frame[(H - 10) * W + 10], 250);
    assert_int_equal(frame[(H - 10) * W + 11], 500);
}

/* The cos^4 law with so much lost in the corner, at (x, y) of a frame of w x h. */
static double cos4(double lost, double x, double y, double w, double h)
{
    const double t = 1.0 / sqrt(1.0 - lost) - 1.0;
    const double r2 = (pow(x - w / 2, 2) + pow(y - h / 2, 2)) / (w * w / 4 + h * h / 4);

    return 1.0 / pow(1.0 + t * r2, 2);
}

/* A light map keeps only some pixels of a wide frame's row; what lies between is as right, to the last pixel. */
static void vignetting_of_a_wide_frame_follows_the_law_in_every_pixel(void **state)
{
    enum {
        WIDE = 4058,
        HIGH = 16
    };
    struct ttf_sim_config config;
    struct plain_scene s;
    uint16_t *wide = calloc((size_t)WIDE * HIGH, sizeof(*wide));

    assert_non_null(wide);
    if (!wide)
        return; /* cmocka is gone by now: for the analyser */
    plain_config(WIDE, HIGH, &config);
    config.vignetting = 0.4;
    config.sensitivity_e = 60000;
    plain_scene_init(&s, plain_white);
    plain_expose(&config, &s, 1.0f, wide);
    for (uint32_t y = 0; y < HIGH; y++)
        for (uint32_t x = 0; x < WIDE; x++)
            assert_float_equal(wide[y * WIDE + x], 60000 * cos4(0.4, x + 0.5, y + 0.5, WIDE, HIGH),
                               1.0);
    free(wide);
}

/* The size at which the sample was asked for. */
static uint32_t asked_w, asked_h;

static float slope(uint32_t x, uint32_t y, uint32_t w, uint32_t h, unsigned c)
{
    asked_w = w;
    asked_h = h;
    return ((float)x + 0.5f) / (float)w;
}

static void a_sample_drawn_coarser_is_magnified_to_the_frame(void **state)
{
    struct ttf_sim_config config;
    struct plain_scene s;

    plain_config(W, H, &config);
    config.detail_px = 40;
    plain_scene_init(&s, slope);
    plain_expose(&config, &s, 1.0f, frame);
    assert_int_equal(asked_w, 40);
    assert_int_equal(asked_h, 30);
    for (uint32_t y = 0; y < H; y++)
        for (uint32_t x = 2; x + 2 < W; x++) /* the outermost pixels repeat the sample's edge */
            assert_float_equal(at(x, y), 1000.0 * (x + 0.5) / W, 1.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_distortion_a_pixel_of_the_frame_is_a_pixel_of_the_scene),
        cmocka_unit_test(vignetting_of_a_wide_frame_follows_the_law_in_every_pixel),
        cmocka_unit_test(a_sample_drawn_coarser_is_magnified_to_the_frame),
        cmocka_unit_test(a_margin_shifts_the_scene_by_whole_pairs_of_pixels),
        cmocka_unit_test(the_samples_edges_run_between_the_corners_the_model_names),
        cmocka_unit_test(the_samples_middle_lands_where_the_diagonals_cross),
        cmocka_unit_test(vignetting_takes_its_share_in_the_corner),
        cmocka_unit_test(a_point_is_spread_as_wide_as_asked_and_loses_no_light),
        cmocka_unit_test(a_lamp_falls_off_with_distance_and_slant),
        cmocka_unit_test(a_lamps_colour_and_its_rows_reach_the_pixels),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
