/* SPDX-License-Identifier: Apache-2.0 */
/* What maps and shadows are made with: quantiles, smoothing, sets of pixels, filling. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "control/fill.h"
#include "control/gaussian.h"
#include "control/mask.h"
#include "control/rates.h"

static void a_quantile_is_what_sorting_would_give(void **state)
{
    static const double shares[] = {0.0, 0.01, 0.5, 0.77, 0.99, 1.0};
    double values[200];
    uint32_t random = 3;

    (void)state;
    for (int s = 0; s < 6; s++) {
        for (int kinds = 1; kinds <= 200; kinds += 66) { /* with few kinds, many ties */
            size_t below = 0, equal = 0, rank = (size_t)ceil(shares[s] * 200);
            double got;

            for (int i = 0; i < 200; i++) {
                random = random * 1664525u + 1013904223u;
                values[i] = (double)((random >> 8) % (unsigned)kinds);
            }
            got = ttf_control_quantile(values, 200, shares[s]);
            for (int i = 0; i < 200; i++) {
                below += values[i] < got;
                equal += values[i] == got;
            }
            rank = rank ? rank - 1 : 0;
            assert_true(below <= rank && rank < below + equal);
        }
    }
}

static void a_gaussian_spreads_a_point_as_its_formula_has_it(void **state)
{
    double plane[31 * 31] = {0};

    (void)state;
    plane[15 * 31 + 15] = 1.0;
    assert_int_equal(ttf_control_gaussian(plane, 31, 31, 2.0, TTF_BORDER_HOLD), 0);
    for (int y = 8; y < 23; y++) {
        for (int x = 8; x < 23; x++) {
            double r2 = (x - 15) * (x - 15) + (y - 15) * (y - 15);

            assert_true(fabs(plane[y * 31 + x] - exp(-r2 / 8.0) / (8.0 * 3.14159265)) < 1e-5);
        }
    }
}

static void held_borders_keep_a_constant_and_odd_ones_a_slope(void **state)
{
    double held[12], odd[12];

    (void)state;
    for (int i = 0; i < 12; i++) {
        held[i] = 3.0;
        odd[i] = 1.0 + 0.5 * i;
    }
    assert_int_equal(ttf_control_gaussian(held, 12, 1, 3.0, TTF_BORDER_HOLD), 0);
    assert_int_equal(ttf_control_gaussian(odd, 12, 1, 2.0, TTF_BORDER_ODD), 0);
    for (int i = 0; i < 12; i++) {
        assert_true(fabs(held[i] - 3.0) < 1e-12);
        assert_true(fabs(odd[i] - (1.0 + 0.5 * i)) < 1e-12);
    }
    assert_int_equal(ttf_control_gaussian(odd, 12, 1, 300.0, TTF_BORDER_ODD), -EINVAL);
}

/* Rows of '.' and '#' */
static struct ttf_mask mask_of(const char *rows, uint32_t width, uint8_t *room)
{
    struct ttf_mask mask = {width, (uint32_t)(strlen(rows) / width), room};

    for (size_t i = 0; rows[i]; i++)
        room[i] = rows[i] == '#';
    return mask;
}

static void is_mask(const struct ttf_mask *mask, const char *rows)
{
    char got[100] = "";

    for (size_t i = 0; i < (size_t)mask->width * mask->height; i++)
        got[i] = mask->at[i] ? '#' : '.';
    assert_string_equal(got, rows);
}

static void only_the_largest_piece_stays_and_corners_hold_it_together(void **state)
{
    uint8_t room[100];
    size_t pixels = 0;
    struct ttf_mask mask = mask_of("##...#"
                                   "##..#."
                                   "...#.."
                                   "#.#..."
                                   "#..#..",
                                   6, room);

    (void)state;
    assert_int_equal(ttf_mask_keep_largest(&mask, &pixels), 0);
    is_mask(&mask, ".....#"
                   "....#."
                   "...#.."
                   "..#..."
                   "...#..");
    assert_int_equal(pixels, 5);
}

static void holes_are_filled_and_bays_are_not(void **state)
{
    uint8_t room[100];
    size_t pixels = 0;
    struct ttf_mask mask = mask_of(".####."
                                   "#....#"
                                   "#.##.#"
                                   ".####."
                                   "#.#...",
                                   6, room);

    (void)state;
    assert_int_equal(ttf_mask_fill_holes(&mask, &pixels), 0);
    is_mask(&mask, ".####."
                   "######"
                   "######"
                   ".####."
                   "#.#...");
    assert_int_equal(pixels, 22);
}

static void growing_and_shrinking_go_by_rows_and_columns(void **state)
{
    uint8_t room[100];
    struct ttf_mask mask = mask_of("......"
                                   "......"
                                   "..#..."
                                   "......"
                                   "......",
                                   6, room);

    (void)state;
    assert_int_equal(ttf_mask_grow(&mask, 1), 0);
    is_mask(&mask, "......"
                   ".###.."
                   ".###.."
                   ".###.."
                   "......");
    assert_int_equal(ttf_mask_grow(&mask, 2), 0);
    is_mask(&mask, "######"
                   "######"
                   "######"
                   "######"
                   "######");
    mask = mask_of("####.."
                   "####.."
                   "####.."
                   "......",
                   6, room);
    assert_int_equal(ttf_mask_grow(&mask, -1), 0); /* the picture's own border is no outside */
    is_mask(&mask, "###..."
                   "###..."
                   "......"
                   "......");
}

static void closing_mends_narrow_bites_and_nothing_else(void **state)
{
    uint8_t room[100];
    struct ttf_mask mask = mask_of("........."
                                   ".###.###."
                                   ".###.###."
                                   ".#######."
                                   "..#####.."
                                   "...###...",
                                   9, room);

    (void)state;
    assert_int_equal(ttf_mask_close(&mask, 1), 0);
    is_mask(&mask, "........."
                   ".#######."
                   ".#######."
                   ".#######."
                   "..#####.."
                   "...###..."); /* and the picture's border is no wall */
}

static void what_is_filled_lies_between_what_is_around_it_and_goes_on_smoothly(void **state)
{
    enum {
        W = 61,
        H = 45
    };
    float values[2 * W * H];
    uint8_t known[W * H];

    (void)state;
    for (int i = 0; i < W * H; i++) {
        int x = i % W, y = i / W;

        known[i] = (x - 30) * (x - 30) + (y - 22) * (y - 22) > 150;
        values[2 * i] = known[i] ? 0.25f + 0.01f * (float)x : 9.0f;
        values[2 * i + 1] = known[i] ? 0.5f : -9.0f;
    }
    assert_int_equal(ttf_control_fill(values, 2, known, W, H), 0);
    for (int i = 0; i < W * H; i++) { /* a plane solves Laplace's equation */
        double want = 0.25 + 0.01 * (i % W);

        assert_true(fabs((double)values[2 * i] - want) < (known[i] ? 1e-6 : 0.01));
        assert_true(fabsf(values[2 * i + 1] - 0.5f) < 1e-5f);
    }
}

static void one_known_pixel_fills_everything(void **state)
{
    float values[7 * 5] = {0};
    uint8_t known[7 * 5] = {0};

    (void)state;
    values[9] = 0.75f;
    known[9] = 1;
    assert_int_equal(ttf_control_fill(values, 1, known, 7, 5), 0);
    for (int i = 0; i < 35; i++)
        assert_true(fabsf(values[i] - 0.75f) < 1e-6f);
}

static void the_scale_of_curvature_forgives_flat_pictures(void **state)
{
    const struct ttf_rate_scale scale = {0.0, 1.0};
    double k[1000] = {0};
    float m[1000];

    (void)state;
    k[7] = -2.0; /* less than 1% is bent */
    k[8] = 1.0;
    assert_int_equal(ttf_rates_of_curvature(k, 1000, 0.5, &scale, m, NULL), 0);
    assert_true(m[7] == 1.0f && m[8] == 0.5f && m[9] == 0.0f);
    assert_int_equal(ttf_rates_of_curvature(k, 1000, 3.0, &scale, m, NULL), 0);
    assert_true(m[7] == 0.0f); /* all of it may be rounding */
    for (int i = 0; i < 1000; i++)
        k[i] = i + 1;
    assert_int_equal(ttf_rates_of_curvature(k, 1000, 0.5, &scale, m, NULL), 0);
    assert_true(m[989] == 1.0f && m[999] == 1.0f && m[494] == 0.5f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_quantile_is_what_sorting_would_give),
        cmocka_unit_test(a_gaussian_spreads_a_point_as_its_formula_has_it),
        cmocka_unit_test(held_borders_keep_a_constant_and_odd_ones_a_slope),
        cmocka_unit_test(only_the_largest_piece_stays_and_corners_hold_it_together),
        cmocka_unit_test(holes_are_filled_and_bays_are_not),
        cmocka_unit_test(growing_and_shrinking_go_by_rows_and_columns),
        cmocka_unit_test(closing_mends_narrow_bites_and_nothing_else),
        cmocka_unit_test(what_is_filled_lies_between_what_is_around_it_and_goes_on_smoothly),
        cmocka_unit_test(one_known_pixel_fills_everything),
        cmocka_unit_test(the_scale_of_curvature_forgives_flat_pictures),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
