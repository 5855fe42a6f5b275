/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "textures.h"
#include "ttf/synth/metrics.h"

#define W 23u
#define H 18u
#define N 6u

static int code(const struct texture_sequence *s, uint32_t t, uint32_t x, uint32_t y, uint32_t c)
{
    return ttf_linear16_to_srgb8(s->codes[(((size_t)t * H + y) * W + x) * 3 + c]);
}

static double plain_difference(const struct texture_sequence *s)
{
    double sum = 0.0;

    for (uint32_t t = 1; t < N; t++) {
        for (uint32_t i = 0; i < W * H * 3; i++)
            sum += abs(code(s, t, i / 3 % W, i / 3 / W, i % 3) -
                       code(s, t - 1, i / 3 % W, i / 3 / W, i % 3));
    }
    return sum / (W * H * 3 * (N - 1));
}

static double box(const struct texture_sequence *s, uint32_t t, uint32_t i, uint32_t j, uint32_t c)
{
    double sum = 0.0;

    for (uint32_t k = 0; k < 16; k++)
        sum += code(s, t, 4 * i + k % 4, 4 * j + k / 4, c);
    return sum / 16.0;
}

static double plain_second(const struct texture_sequence *s)
{
    double sum = 0.0;
    uint32_t n = 0;

    for (uint32_t t = 2; t < N; t++) {
        for (uint32_t j = 0; j < H / 4; j++) {
            for (uint32_t i = 0; i < W / 4; i++) {
                for (uint32_t c = 0; c < 3; c++, n++)
                    sum += fabs(box(s, t, i, j, c) - 2.0 * box(s, t - 1, i, j, c) +
                                box(s, t - 2, i, j, c));
            }
        }
    }
    return sum / n;
}

static void activity_is_what_its_definition_says(void **state)
{
    struct texture_sequence s = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_activity *activity = ttf_activity_create(W, H, &texture_encoding);
    struct ttf_activity_figures figures;

    (void)state;
    assert_non_null(activity);
    for (uint32_t t = 0; t < N; t++)
        assert_int_equal(ttf_activity_add(activity, NULL, s.codes + (size_t)t * W * H * 3), 0);
    ttf_activity_figures(activity, &figures);
    assert_int_equal(figures.frames, N);
    assert_true(fabs(figures.mean_difference - plain_difference(&s)) < 1e-9);
    assert_true(fabs(figures.second_difference - plain_second(&s)) < 1e-9);
    ttf_activity_destroy(activity);
    texture_free(&s);
}

static void a_still_sequence_has_no_activity(void **state)
{
    struct texture_sequence s = texture_make(TEXTURE_CONSTANT, W, H, N);
    struct ttf_activity *activity = ttf_activity_create(W, H, &texture_encoding);
    struct ttf_activity_figures figures;

    (void)state;
    for (uint32_t t = 0; t < N; t++)
        assert_int_equal(ttf_activity_add(activity, NULL, s.codes + (size_t)t * W * H * 3), 0);
    ttf_activity_figures(activity, &figures);
    assert_true(figures.mean_difference == 0.0 && figures.second_difference == 0.0);
    assert_true(figures.mean_rgb[0] == 90.0 && figures.mean_rgb[2] == 130.0);
    ttf_activity_destroy(activity);
    texture_free(&s);
    assert_null(ttf_activity_create(0, 5, &texture_encoding));
}

/* A map of 6 x 2 pixels made of two pieces of a source of 8 x 4. */
static uint32_t two_pieces[12] = {0, 1, 2, 12, 13, 14, 8, 9, 10, 20, 21, 22};

static struct ttf_quilt_map map_of_two_pieces(void)
{
    static uint32_t owner[12];
    static struct ttf_quilt_block block;

    return (struct ttf_quilt_map){.width = 6,
                                  .height = 2,
                                  .n_inputs = 1,
                                  .inputs = {{8, 4, 0}},
                                  .source_pixels = 32,
                                  .source = two_pieces,
                                  .owner = owner,
                                  .n_blocks = 1,
                                  .blocks = &block};
}

static void seams_are_counted_and_measured_where_the_map_jumps(void **state)
{
    const struct ttf_quilt_map map = map_of_two_pieces();
    struct ttf_seams *seams = ttf_seams_create(&map, &texture_encoding);
    uint16_t source[8 * 4 * 3], output[6 * 2 * 3];
    struct ttf_seams_figures figures;

    (void)state;
    assert_non_null(seams);
    /* a ramp of 10 codes per column: 2 -> 12 jumps from column 2 to column 4, two steps at once */
    for (uint32_t i = 0; i < 8 * 4 * 3; i++)
        source[i] = ttf_srgb8_to_linear16((uint8_t)(10 * (i / 3 % 8)));
    ttf_quilt_compose(&map, source, output);
    ttf_seams_add(seams, source, output);
    ttf_seams_figures(seams, &figures);
    assert_int_equal(figures.pairs, 2); /* one in each row */
    assert_true(figures.seam_gradient == 20.0);
    assert_true(figures.source_gradient == 10.0);
    assert_true(figures.excess == 1.0);
    /* 28 steps of 10 across, 24 of 0 down */
    assert_true(fabs(figures.input_gradient - 280.0 / 52.0) < 1e-12);
    ttf_seams_destroy(seams);
}

/* 0 would say that the seams are no stronger than the texture: there is none. */
static void seams_through_one_flat_colour_exceed_nothing(void **state)
{
    const struct ttf_quilt_map map = map_of_two_pieces();
    struct ttf_seams *seams = ttf_seams_create(&map, &texture_encoding);
    uint16_t source[8 * 4 * 3] = {0}, output[6 * 2 * 3];
    struct ttf_seams_figures figures;

    (void)state;
    assert_non_null(seams);
    memset(output, 0, sizeof(output));
    output[0] = 40000; /* whatever steps the output has */
    ttf_seams_add(seams, source, output);
    ttf_seams_figures(seams, &figures);
    assert_int_equal(figures.pairs, 2);
    assert_true(isnan(figures.excess) && isnan(figures.input_excess));
    ttf_seams_destroy(seams);
}

static void repetition_counts_uses_of_source_pixels(void **state)
{
    struct ttf_quilt_block blocks[] = {
        {.out_x = 0, .out_y = 0, .src_x = 3, .src_y = 1},
        {.out_x = 4, .out_y = 0, .src_x = 7, .src_y = 1}, /* goes on where the left one was */
        {.out_x = 0, .out_y = 4, .src_x = 0, .src_y = 0},
        {.out_x = 4, .out_y = 4, .src_x = 1, .src_y = 2},
    };
    struct ttf_quilt_map map = map_of_two_pieces();
    struct ttf_repetition_figures figures;

    (void)state;
    map.blocks = blocks;
    map.n_blocks = 4;
    assert_int_equal(ttf_repetition_of_map(&map, &figures), 0);
    assert_true(fabs(figures.verbatim_share - 1.0 / 3.0) < 1e-12);
    assert_true(figures.source_coverage == 12.0 / 32.0);
    assert_true(figures.mean_uses == 1.0);
    assert_int_equal(figures.max_uses, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(activity_is_what_its_definition_says),
        cmocka_unit_test(a_still_sequence_has_no_activity),
        cmocka_unit_test(seams_are_counted_and_measured_where_the_map_jumps),
        cmocka_unit_test(seams_through_one_flat_colour_exceed_nothing),
        cmocka_unit_test(repetition_counts_uses_of_source_pixels),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
