/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include <math.h>

#include "rehearsal.h"

#define SIDE 64

static uint32_t samples[SIDE * SIDE];

/* Two frames added up, all samples at this code. */
static struct ttf_raw_sum even(unsigned code)
{
    struct ttf_raw_sum raw = {
        .format = {.width = SIDE,
                   .height = SIDE,
                   .stride = SIDE * 2,
                   .packing = TTF_PACKING_RAW16,
                   .cfa = TTF_CFA_RGGB,
                   .bits = 12,
                   .black_level = 64,
                   .white_level = 4095},
        .sum = samples,
        .n = 2,
        .samples = 1,
    };

    for (unsigned i = 0; i < SIDE * SIDE; i++)
        samples[i] = code * 2;
    return raw;
}

static void headroom_counts_stops_to_saturation(void **state)
{
    struct ttf_raw_sum raw = even(64 + 4031 / 4);

    (void)state;
    assert_true(fabs(ttf_raw_headroom_stops(&raw) - 2) < 0.01);
    raw = even(4095);
    assert_true(ttf_raw_headroom_stops(&raw) == 0);
}

static void a_few_highlights_do_not_count(void **state)
{
    struct ttf_raw_sum raw = even(64 + 4031 / 4);

    (void)state;
    samples[5] = samples[77] = 4095 * 2;
    assert_true(fabs(ttf_raw_headroom_stops(&raw) - 2) < 0.01);
    for (unsigned i = 0; i < SIDE; i++)
        samples[i] = 4095 * 2;
    assert_true(ttf_raw_headroom_stops(&raw) == 0);
}

static void of_no_frame_and_of_a_black_one_there_is_something_to_say_too(void **state)
{
    struct ttf_raw_sum raw = even(64);

    (void)state;
    assert_true(fabs(ttf_raw_headroom_stops(&raw) - log2(4031)) < 0.01); /* all there is */
    raw = even(10);                                                      /* darker than black */
    assert_true(fabs(ttf_raw_headroom_stops(&raw) - log2(4031)) < 0.01);
    raw = even(100000); /* a sum that no sensor gives */
    assert_true(ttf_raw_headroom_stops(&raw) == 0);
    raw.n = 0;
    assert_true(isnan(ttf_raw_headroom_stops(&raw)));
}

static void only_the_reference_of_the_first_shot_tells_how_lamps_settle(void **state)
{
    struct ttf_raw_sum raw = even(1064);
    struct ttf_image image = {.reference_level = 0.5, .sharpness = NAN, .bracket = 0};
    struct ttf_rehearsal h;

    (void)state;
    ttf_rehearsal_init(&h);
    ttf_rehearsal_image(&h, 1, &raw, &image);
    assert_true(isnan(h.first_level));
    image.bracket = 1;
    ttf_rehearsal_image(&h, 0, &raw, &image);
    assert_true(isnan(h.first_level));
    image.bracket = 0;
    ttf_rehearsal_image(&h, 0, &raw, &image);
    image.reference_level = 0.25;
    ttf_rehearsal_image(&h, 0, &raw, &image);
    assert_true(h.first_level == 0.5 && h.last_level == 0.25);
    assert_true(isnan(h.sharpness));
}

static void the_first_and_the_last_slot_tell_how_well_lamps_settle(void **state)
{
    struct ttf_rehearsal h;
    struct ttf_raw_sum raw = even(1064);
    struct ttf_image image = {
        .bracket = -1, .mean_level = NAN, .reference_level = NAN, .sharpness = NAN};

    (void)state;
    ttf_rehearsal_init(&h);
    ttf_rehearsal_image(&h, 0, &raw, &image);
    raw = even(1164);
    ttf_rehearsal_image(&h, 0, &raw, &image);
    assert_true(fabs(h.first_level - 1000) < 1e-9);
    assert_true(fabs(h.last_level - 1100) < 1e-9);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(headroom_counts_stops_to_saturation),
        cmocka_unit_test(a_few_highlights_do_not_count),
        cmocka_unit_test(of_no_frame_and_of_a_black_one_there_is_something_to_say_too),
        cmocka_unit_test(only_the_reference_of_the_first_shot_tells_how_lamps_settle),
        cmocka_unit_test(the_first_and_the_last_slot_tell_how_well_lamps_settle),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
