/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>

#include "search/hash.h"
#include "ttf/synth/likeness.h"

#define SOURCES 60u
#define PIXELS  (2 * SOURCES)
#define FRAMES  120u
#define LASTING 12 /* frames of one event */

static const struct ttf_encoding encoding = {0.0, 65535.0};

static uint32_t random_below(uint64_t which, uint32_t n)
{
    return ttf_pick(ttf_random64(5, TTF_PURPOSE_BLOCK, which), n);
}

/* A stain that spreads once, from `begin` on, in LASTING frames: slow, fast, slow. */
static uint16_t stain(int t, int begin)
{
    int k = t - begin < 0 ? 0 : t - begin > LASTING ? LASTING : t - begin;
    double done = 0.5 - 0.5 * cos(acos(-1.0) * k / LASTING);

    return ttf_srgb8_to_linear16((uint8_t)lrint(40.0 + 150.0 * done));
}

/* Each source pixel is shown twice; the copy's event is late by up to `delay` frames. */
static void figures_of_delays(uint32_t delay, bool independent, struct ttf_synchrony_figures *ret)
{
    uint32_t source[PIXELS];
    uint16_t frame[PIXELS * 3];
    struct ttf_synchrony *synchrony;

    for (uint32_t i = 0; i < PIXELS; i++)
        source[i] = 4000000000u + i % SOURCES;
    synchrony = ttf_synchrony_create(source, PIXELS, 1000, 3, &encoding);
    assert_non_null(synchrony);
    for (uint32_t t = 0; t < FRAMES; t++) {
        for (uint32_t i = 0; i < PIXELS; i++) {
            uint32_t event = independent ? i : i % SOURCES;
            uint32_t begin = 5 + random_below(event, FRAMES - LASTING - 50);

            if (i >= SOURCES)
                begin += random_below(1000 + i, delay + 1);
            for (uint32_t c = 0; c < 3; c++)
                frame[i * 3 + c] = stain((int)t, (int)begin);
        }
        ttf_synchrony_add(synchrony, frame);
    }
    ttf_synchrony_figures(synchrony, ret);
    ttf_synchrony_destroy(synchrony);
}

static void what_is_copied_happens_at_once(void **state)
{
    struct ttf_synchrony_figures figures;

    figures_of_delays(0, false, &figures);
    assert_int_equal(figures.pairs, SOURCES);
    assert_true(fabs(figures.synchrony - 1.0) < 1e-12);
}

static void events_of_their_own_are_not_synchronous(void **state)
{
    struct ttf_synchrony_figures figures;

    figures_of_delays(0, true, &figures);
    assert_true(fabs(figures.synchrony) < 0.2);
}

static void the_more_random_the_delay_the_less_synchrony(void **state)
{
    const uint32_t delays[] = {0, 3, 6, 12, 24, 45};
    double last = 2.0;

    for (size_t i = 0; i < sizeof(delays) / sizeof(delays[0]); i++) {
        struct ttf_synchrony_figures figures;

        figures_of_delays(delays[i], false, &figures);
        assert_true(figures.synchrony < last - 0.02);
        last = figures.synchrony;
    }
    assert_true(last < 0.25);
}

/* Four output pixels in two pairs, of given grey codes at each time. */
static void figures_of_codes(const uint8_t (*codes)[4], size_t frames,
                             struct ttf_synchrony_figures *ret)
{
    static const uint32_t source[4] = {7, 9, 9, 7};
    struct ttf_synchrony *synchrony = ttf_synchrony_create(source, 4, 10, 0, &encoding);

    assert_non_null(synchrony);
    for (size_t t = 0; t < frames; t++) {
        uint16_t frame[4 * 3];

        for (size_t i = 0; i < 4 * 3; i++)
            frame[i] = ttf_srgb8_to_linear16(codes[t][i / 3]);
        ttf_synchrony_add(synchrony, frame);
    }
    ttf_synchrony_figures(synchrony, ret);
    ttf_synchrony_destroy(synchrony);
}

static void the_figure_is_what_its_definition_says(void **state)
{
    /* pixels 0 and 3 change by 10 0 5 0 and 0 10 5 1; 1 and 2 by 100 0 0 0 twice, apart by a sign */
    static const uint8_t codes[5][4] = {{50, 150, 200, 0},
                                        {60, 50, 100, 0},
                                        {60, 50, 100, 10},
                                        {55, 50, 100, 15},
                                        {55, 50, 100, 16}};
    struct ttf_synchrony_figures figures;
    double x[4] = {10, 0, 5, 0}, y[4] = {0, 10, 5, 1}, xy = 0.0, xx = 0.0, yy = 0.0;

    for (int i = 0; i < 4; i++) {
        xy += (x[i] - 3.75) * (y[i] - 4.0);
        xx += (x[i] - 3.75) * (x[i] - 3.75);
        yy += (y[i] - 4.0) * (y[i] - 4.0);
    }
    figures_of_codes(codes, 5, &figures);
    assert_int_equal(figures.pairs, 2);
    assert_true(fabs(figures.synchrony - (31.0 * xy / sqrt(xx * yy) + 200.0 * 1.0) / 231.0) <
                1e-12);
}

static void what_has_no_moment_does_not_count(void **state)
{
    /* one pair still; of the other one pixel is still while the other one is not */
    static const uint8_t half[4][4] = {{1, 3, 4, 1}, {9, 3, 4, 1}, {9, 3, 4, 1}, {2, 3, 4, 1}};
    /* one pair still, the other changing evenly */
    static const uint8_t even[4][4] = {{1, 3, 4, 1}, {3, 3, 4, 2}, {5, 3, 4, 3}, {7, 3, 4, 4}};
    struct ttf_synchrony_figures figures;

    figures_of_codes(half, 4, &figures);
    assert_int_equal(figures.pairs, 1);
    assert_true(figures.synchrony == 0.0);
    figures_of_codes(even, 4, &figures);
    assert_int_equal(figures.pairs, 0);
    assert_true(figures.synchrony == 0.0);
    figures_of_codes(half, 0, &figures);
    assert_int_equal(figures.pairs, 0);
}

static void pairs_are_of_one_source_and_as_many_as_asked_for(void **state)
{
    /* only pixels of source 3 ever move, so a pair across sources would lower the figure */
    static const uint32_t source[9] = {3, 1, 3, 2, 2, 3, 3, 1, 0};
    struct ttf_synchrony_figures figures;

    for (unsigned pairs_max = 0; pairs_max < 8; pairs_max++) {
        struct ttf_synchrony *synchrony =
            ttf_synchrony_create(source, 9, pairs_max, pairs_max, &encoding);

        assert_non_null(synchrony);
        for (uint32_t t = 0; t < 10; t++) {
            uint16_t frame[9 * 3];

            for (size_t i = 0; i < 9 * 3; i++)
                frame[i] = (uint16_t)(random_below(source[i / 3] * 100 + t, 65536));
            ttf_synchrony_add(synchrony, frame);
        }
        ttf_synchrony_figures(synchrony, &figures);
        assert_int_equal(figures.pairs, pairs_max < 5 ? pairs_max : 5);
        assert_true(pairs_max == 0 || fabs(figures.synchrony - 1.0) < 1e-12);
        ttf_synchrony_destroy(synchrony);
    }
}

static void sampled_pairs_are_from_all_over_the_source(void **state)
{
    uint32_t source[2 * 100];
    struct ttf_synchrony *synchrony;
    struct ttf_synchrony_figures figures;

    for (uint32_t i = 0; i < 200; i++)
        source[i] = i % 100;
    synchrony = ttf_synchrony_create(source, 200, 10, 1, &encoding);
    assert_non_null(synchrony);
    /* a half of the source moves, and so do half of the pairs */
    for (uint32_t t = 0; t < 10; t++) {
        uint16_t frame[200 * 3] = {0};

        for (size_t i = 0; i < (size_t)200 * 3; i++)
            frame[i] = source[i / 3] < 50 ? 0 : (uint16_t)random_below(t, 65536);
        ttf_synchrony_add(synchrony, frame);
    }
    ttf_synchrony_figures(synchrony, &figures);
    assert_int_equal(figures.pairs, 5);
    ttf_synchrony_destroy(synchrony);
}

static void a_picture_without_repetition_has_no_figure(void **state)
{
    static const uint32_t source[3] = {2, 1, 0};
    static const uint16_t frame[9] = {0};
    struct ttf_synchrony *synchrony = ttf_synchrony_create(source, 3, 10, 0, &encoding);
    struct ttf_synchrony_figures figures;

    assert_non_null(synchrony);
    ttf_synchrony_add(synchrony, frame);
    ttf_synchrony_figures(synchrony, &figures);
    assert_true(figures.pairs == 0 && figures.synchrony == 0.0);
    ttf_synchrony_destroy(synchrony);
    ttf_synchrony_destroy(NULL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_copied_happens_at_once),
        cmocka_unit_test(events_of_their_own_are_not_synchronous),
        cmocka_unit_test(the_more_random_the_delay_the_less_synchrony),
        cmocka_unit_test(the_figure_is_what_its_definition_says),
        cmocka_unit_test(what_has_no_moment_does_not_count),
        cmocka_unit_test(pairs_are_of_one_source_and_as_many_as_asked_for),
        cmocka_unit_test(sampled_pairs_are_from_all_over_the_source),
        cmocka_unit_test(a_picture_without_repetition_has_no_figure),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
