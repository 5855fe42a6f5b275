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

#include "pictures.h"
#include "ttf/synth/prepare.h"

#define W 32u
#define H 24u
#define N 48u

/* What one frame's light is multiplied by, beside the slow evolution. */
typedef double gain_fn(uint32_t t);

/* Bright and dark parts, the bright ones darkening: the level falls to a third, fast at first. */
static double evolution(uint32_t t)
{
    return 0.15 + 0.3 * exp(-(double)t / 20.0);
}

static double flickering(const void *ctx, double x, double y, uint32_t t, int c)
{
    gain_fn *const *gain = (gain_fn *const *)ctx;

    return (0.4 + 1.2 * ground(x, y, 1)) * evolution(t) * (1.0 - 0.2 * c) * (*gain)(t);
}

static double steady(uint32_t t)
{
    (void)t;
    return 1.0;
}

static double at_random(uint32_t t)
{
    return 1.0 + 0.24 * (chance(t, 0, 5) - 0.5);
}

static double alternating(uint32_t t)
{
    return t % 2 ? 1.1 : 1.0 / 1.1;
}

static double one_flash(uint32_t t)
{
    return t == 20 ? 1.5 : 1.0;
}

static double lamps_off_once(uint32_t t)
{
    return t == 20 ? 0.0001 : 1.0;
}

static struct pictures make(gain_fn *gain, uint32_t n, const struct ttf_encoding *encoding)
{
    return pictures_make(W, H, n, encoding, flickering, (const void *)&gain);
}

static struct ttf_sequence *deflickered(struct ttf_sequence *input, uint32_t window,
                                        struct ttf_deflicker_figures *ret)
{
    struct ttf_sequence *made = NULL;
    struct ttf_err err = {0};

    if (ttf_deflicker_create(input, window, &made, ret, &err) < 0)
        fail_msg("%s", err.what);
    return made;
}

/* How far frames' levels are from what they would be without flicker: the largest, as a part of it. */
static double off(struct ttf_sequence *sequence, struct ttf_sequence *without, uint32_t from,
                  uint32_t to)
{
    double most = 0.0;

    for (uint32_t t = from; t < to; t++)
        most = fmax(most, fabs(mean_value(sequence, t) / mean_value(without, t) - 1.0));
    return most;
}

static void flicker_goes_and_slow_evolution_stays(void **state)
{
    const struct ttf_encoding *encodings[] = {&imported, &captured};

    (void)state;
    for (int i = 0; i < 2; i++) {
        struct pictures input = make(at_random, N, encodings[i]);
        struct pictures without = make(steady, N, encodings[i]);
        struct ttf_deflicker_figures figures, after;
        struct ttf_sequence *made = deflickered(input.sequence, 9, &figures), *again;

        assert_true(off(input.sequence, without.sequence, 0, N) > 0.10);
        assert_true(off(made, without.sequence, 6, N - 6) < 0.045);
        assert_true(off(made, without.sequence, 0, N) < 0.09);
        assert_true(figures.before > 0.08 && figures.after < figures.before / 20.0);
        assert_true(figures.largest_gain > 1.05 && figures.largest_gain < 1.2);
        assert_true(figures.smallest_gain < 0.95 && figures.smallest_gain > 0.8);
        /* measured, not believed */
        again = deflickered(made, 9, &after);
        assert_true(fabs(after.before - figures.after) < 1e-3);
        assert_reads_by_rows(made);
        ttf_sequence_destroy(again);
        ttf_sequence_destroy(made);
        pictures_free(&without);
        pictures_free(&input);
    }
}

static void only_the_level_changes_not_the_picture(void **state)
{
    struct pictures input = make(at_random, N, &captured);
    struct ttf_sequence *made = deflickered(input.sequence, 9, NULL);
    uint16_t *before = frame_of(input.sequence, 14), *after = frame_of(made, 14);
    double gain = (after[300] - 2047.0) / (before[300] - 2047.0);

    (void)state;
    assert_true(fabs(gain - 1.0) > 0.02);
    for (size_t i = 0; i < (size_t)W * H * 3; i++)
        assert_true(fabs((before[i] - 2047.0) * gain - (after[i] - 2047.0)) < 1.5);
    free(before);
    free(after);
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

static void light_that_alternates_is_evened_out_altogether(void **state)
{
    struct pictures input = make(alternating, N, &imported);
    struct pictures without = make(steady, N, &imported);
    struct ttf_sequence *made = deflickered(input.sequence, 7, NULL);

    (void)state;
    assert_true(off(made, without.sequence, 6, N - 6) < 0.015);
    assert_true(off(made, without.sequence, 0, N) < 0.06);
    ttf_sequence_destroy(made);
    pictures_free(&without);
    pictures_free(&input);
}

static void one_flash_is_undone_and_its_neighbours_do_not_notice(void **state)
{
    struct pictures input = make(one_flash, N, &imported);
    struct pictures without = make(steady, N, &imported);
    struct ttf_sequence *made = deflickered(input.sequence, 5, NULL);

    (void)state;
    assert_true(off(input.sequence, without.sequence, 20, 21) > 0.45);
    assert_true(off(made, without.sequence, 4, N) < 0.01);
    ttf_sequence_destroy(made);
    pictures_free(&without);
    pictures_free(&input);
}

static void a_frame_without_light_is_left_alone(void **state)
{
    struct pictures input = make(lamps_off_once, N, &captured);
    struct pictures without = make(steady, N, &captured);
    struct ttf_deflicker_figures figures;
    struct ttf_sequence *made = deflickered(input.sequence, 5, &figures);
    uint16_t *dark = frame_of(made, 20);

    (void)state;
    assert_memory_equal(dark, input.codes + (size_t)20 * W * H * 3, (size_t)W * H * 6);
    assert_true(off(made, without.sequence, 10, 20) < 0.01);
    assert_true(off(made, without.sequence, 21, 30) < 0.01);
    assert_true(figures.largest_gain < 1.05 && figures.before < 0.01);
    free(dark);
    ttf_sequence_destroy(made);
    pictures_free(&without);
    pictures_free(&input);
}

static double exponential(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    return (0.4 + 1.2 * ground(x, y, 1)) * (1.0 - 0.2 * c) * 0.5 * exp(-0.03 * t);
}

static void a_steady_trend_comes_out_as_it_was_to_its_ends(void **state)
{
    struct pictures input = pictures_make(W, H, 30, &imported, exponential, NULL);
    struct ttf_sequence *made = deflickered(input.sequence, 11, NULL);
    size_t frame = (size_t)W * H * 3;

    (void)state;
    for (uint32_t t = 0; t < 30; t++) {
        uint16_t *codes = frame_of(made, t);

        for (size_t i = 0; i < frame; i++)
            assert_in_range(codes[i], input.codes[t * frame + i] - 3,
                            input.codes[t * frame + i] + 3);
        free(codes);
    }
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

static double glinting(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    (void)c;
    return y < 2 && t % 3 == 0 ? 1.0 : 0.2 + 0.1 * ground(x, y, 1);
}

static void a_glint_is_no_flicker(void **state)
{
    struct pictures input = pictures_make(W, H, 20, &imported, glinting, NULL);
    struct ttf_deflicker_figures figures;
    struct ttf_sequence *made = deflickered(input.sequence, 5, &figures);

    (void)state;
    assert_true(fabs(mean_value(input.sequence, 3) / mean_value(input.sequence, 4) - 1.0) > 0.2);
    assert_true(figures.largest_gain < 1.03 && figures.smallest_gain > 0.97);
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

static double constant(const void *ctx, double x, double y, uint32_t t, int c)
{
    (void)ctx;
    (void)t;
    return 0.3 * ground(x, y, (unsigned)c);
}

static void what_does_not_flicker_comes_out_bit_for_bit(void **state)
{
    struct pictures input = pictures_make(W, H, 12, &captured, constant, NULL);
    struct ttf_deflicker_figures figures;
    struct ttf_sequence *made = deflickered(input.sequence, 101, &figures);

    (void)state;
    assert_same_frames(made, input.sequence);
    assert_true(figures.before == 0.0 && figures.largest_gain == 1.0 &&
                figures.smallest_gain == 1.0);
    ttf_sequence_destroy(made);
    pictures_free(&input);
}

static void one_frame_or_two_have_no_flicker(void **state)
{
    (void)state;
    for (uint32_t n = 1; n < 3; n++) {
        struct pictures input = make(at_random, n, &imported);
        struct ttf_sequence *made = deflickered(input.sequence, 3, NULL);

        assert_same_frames(made, input.sequence);
        ttf_sequence_destroy(made);
        pictures_free(&input);
    }
}

static void refused(struct ttf_sequence *input, uint32_t window, int code, const char *where)
{
    struct ttf_deflicker_figures figures = {.before = 7.0};
    struct ttf_sequence *made = NULL;
    struct ttf_err err = {0};

    assert_int_equal(ttf_deflicker_create(input, window, &made, &figures, &err), code);
    assert_string_equal(err.where, where);
    assert_true(!made && figures.before == 7.0 && err.what[0] != '\0');
}

static void what_makes_no_sense_is_refused_by_name(void **state)
{
    struct pictures input = make(steady, 5, &imported);
    struct ttf_sequence broken = unreadable_from(4, 6);

    (void)state;
    refused(input.sequence, 0, -EINVAL, "window");
    refused(input.sequence, 1, -EINVAL, "window");
    refused(input.sequence, 8, -EINVAL, "window");
    refused(&broken, 3, -EIO, "frame");
    pictures_free(&input);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(flicker_goes_and_slow_evolution_stays),
        cmocka_unit_test(only_the_level_changes_not_the_picture),
        cmocka_unit_test(light_that_alternates_is_evened_out_altogether),
        cmocka_unit_test(one_flash_is_undone_and_its_neighbours_do_not_notice),
        cmocka_unit_test(a_frame_without_light_is_left_alone),
        cmocka_unit_test(a_steady_trend_comes_out_as_it_was_to_its_ends),
        cmocka_unit_test(a_glint_is_no_flicker),
        cmocka_unit_test(what_does_not_flicker_comes_out_bit_for_bit),
        cmocka_unit_test(one_frame_or_two_have_no_flicker),
        cmocka_unit_test(what_makes_no_sense_is_refused_by_name),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
