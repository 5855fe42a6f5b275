/* SPDX-License-Identifier: Apache-2.0 */
/* Plans that take blocks from several inputs, and turned ones. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>

#include "quilts.h"

static struct ttf_quilt_config small_config(void)
{
    struct ttf_quilt_config config;

    ttf_quilt_defaults(&config);
    config.width = 70;
    config.height = 60;
    config.block_width = config.block_height = 18;
    config.seed = 5;
    return config;
}

/* ---- several inputs ---- */

static void a_plan_of_two_inputs_uses_both(void **state)
{
    struct texture_sequence whole = texture_make(TEXTURE_SPOTS, 90, 40, 9);
    struct texture_sequence left = texture_crop(&whole, 0, 0, 40, 36);
    struct texture_sequence right = texture_crop(&whole, 40, 3, 50, 30);
    struct ttf_quilt_config config = small_config();
    size_t used[2] = {0};
    struct ttf_quilt_map map;

    (void)state;
    config.width = 120;
    config.height = 110;
    config.more = &right.sequence;
    config.n_more = 1;
    quilt_plan_ok(&config, left.sequence, NULL, &map);
    quilt_blocks_are_what_is_shown(&map);
    assert_int_equal(map.n_inputs, 2);
    assert_int_equal(map.inputs[1].first, 40 * 36);
    assert_int_equal(map.source_pixels, 40 * 36 + 50 * 30);
    for (size_t i = 0; i < (size_t)map.width * map.height; i++)
        used[map.source[i] >= map.inputs[1].first]++;
    assert_true(used[0] > 1500 && used[1] > 1500);
    ttf_quilt_map_free(&map);
    texture_free(&whole);
    texture_free(&left);
    texture_free(&right);
}

static void a_further_input_may_be_smaller_than_a_block(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 5);
    struct texture_sequence tiny = texture_make(TEXTURE_SPOTS, 17, 3, 5);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map map;

    (void)state;
    config.more = &tiny.sequence;
    config.n_more = 1;
    config.flips = config.rotations = true;
    quilt_plan_ok(&config, input.sequence, NULL, &map);
    quilt_blocks_are_what_is_shown(&map);
    ttf_quilt_map_free(&map);
    texture_free(&input);
    texture_free(&tiny);
}

static void inputs_that_do_not_go_together_are_refused(void **state)
{
    static const struct ttf_encoding other_encoding = {64.0, 4095.0};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 5);
    struct texture_sequence longer = texture_make(TEXTURE_SPOTS, 40, 36, 6);
    struct ttf_quilt_config config = small_config();
    struct ttf_sequence *other, *many[TTF_QUILT_INPUTS_MAX];

    (void)state;
    config.more = &longer.sequence;
    config.n_more = 1;
    quilt_refused(&config, input.sequence, -EINVAL, "sources");
    assert_int_equal(ttf_sequence_of_memory(input.codes, 40, 36, 5, &other_encoding, &other, NULL),
                     0);
    config.more = &other;
    quilt_refused(&config, input.sequence, -EINVAL, "sources");
    ttf_sequence_destroy(other);
    for (int i = 0; i < TTF_QUILT_INPUTS_MAX; i++)
        many[i] = input.sequence;
    config.more = many;
    config.n_more = TTF_QUILT_INPUTS_MAX;
    quilt_refused(&config, input.sequence, -EINVAL, "sources");
    config.n_more = UINT32_MAX;
    quilt_refused(&config, input.sequence, -EINVAL, "sources");
    texture_free(&input);
    texture_free(&longer);
}

/* ---- turned blocks ---- */

/* How the output's step to the right and down looks in the input. */
static void steps_of(const struct ttf_quilt_map *map, const struct ttf_quilt_block *block,
                     int right[2], int down[2])
{
    const struct ttf_quilt_input *input = &map->inputs[block->input];
    uint32_t middle = input->first + input->width * (input->height / 2) + input->width / 2, id[2];

    assert_true(ttf_quilt_neighbour(map, middle, block->turn, 1, 0, &id[0]));
    assert_true(ttf_quilt_neighbour(map, middle, block->turn, 0, 1, &id[1]));
    for (int i = 0; i < 2; i++) {
        int64_t step = (int64_t)id[i] - middle;
        int *out = i == 0 ? right : down;

        out[0] = step == 1 || step == -1 ? (int)step : 0;
        out[1] = out[0] != 0 ? 0 : step > 0 ? 1 : -1;
    }
}

/* Are all turns of the kinds that were asked for, and is there any? */
static void only_turns_asked_for(bool flips, bool rotations)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 44, 36, 6);
    struct ttf_quilt_config config = small_config();
    unsigned n = 0, mirrored = 0, swapped = 0;
    struct ttf_quilt_map map;

    config.width = config.height = 140;
    config.flips = flips;
    config.rotations = rotations;
    quilt_plan_ok(&config, input.sequence, NULL, &map);
    quilt_blocks_are_what_is_shown(&map);
    for (unsigned i = 0; i < map.n_blocks; i++) {
        int right[2], down[2];

        steps_of(&map, &map.blocks[i], right, down);
        n += map.blocks[i].turn != 0;
        mirrored += right[0] * down[1] - right[1] * down[0] < 0;
        swapped += right[0] == 0;
    }
    assert_true((n > 0) == (flips || rotations));
    assert_true((mirrored > 0) == flips);
    assert_true((swapped > 0) == rotations);
    assert_true(rotations || mirrored == n); /* a flip alone is a mirror, never half a turn */
    ttf_quilt_map_free(&map);
    texture_free(&input);
}

static void a_mirror_leaves_upright_what_stands(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 44, 36, 6);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map map;
    unsigned mirrored = 0;

    (void)state;
    config.width = config.height = 140;
    config.mirror = true;
    quilt_plan_ok(&config, input.sequence, NULL, &map);
    quilt_blocks_are_what_is_shown(&map);
    for (unsigned i = 0; i < map.n_blocks; i++) {
        int right[2], down[2];

        steps_of(&map, &map.blocks[i], right, down);
        assert_true(down[0] == 0 && down[1] == 1);
        mirrored += right[0] == -1;
    }
    assert_true(mirrored > 0 && mirrored < map.n_blocks);
    ttf_quilt_map_free(&map);
    texture_free(&input);
}

static void blocks_are_turned_as_asked_and_no_other_way(void **state)
{
    (void)state;
    only_turns_asked_for(false, false);
    only_turns_asked_for(true, false);
    only_turns_asked_for(false, true);
    only_turns_asked_for(true, true);
}

/* Mean error of the best candidates per overlap pixel, of several seeds' plans. */
static double mean_best_error(struct ttf_quilt_config config, struct ttf_sequence *input)
{
    double sum = 0.0, pixels = 0.0;

    for (config.seed = 1; config.seed <= 6; config.seed++) {
        struct ttf_quilt_map map;

        quilt_plan_ok(&config, input, NULL, &map);
        for (unsigned i = 0; i < map.n_blocks; i++) {
            sum += map.blocks[i].best_error;
            pixels += map.blocks[i].overlap_pixels;
        }
        ttf_quilt_map_free(&map);
    }
    return sum / pixels;
}

static void turned_blocks_fit_better(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 32, 40, 6);
    struct ttf_quilt_config config = small_config();
    double plain, flipped, turned;

    (void)state;
    plain = mean_best_error(config, input.sequence);
    config.flips = true;
    flipped = mean_best_error(config, input.sequence);
    config.rotations = true;
    turned = mean_best_error(config, input.sequence);
    assert_true(flipped < 0.97 * plain);
    assert_true(turned < 0.97 * flipped);
    texture_free(&input);
}

static void a_ramp_that_ends_is_gone_back_on_by_its_mirror(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 6);
    struct ttf_quilt_config config = small_config();
    double plain;

    (void)state;
    for (size_t i = 0; i < (size_t)40 * 36 * 6 * 3; i++) /* brighter and brighter to the right */
        input.codes[i] = (uint16_t)(input.codes[i] * (10 + i / 3 % 40) / 50);
    config.width = 160;
    config.height = 18; /* one row: what lies above does not matter */
    plain = mean_best_error(config, input.sequence);
    config.flips = true;
    assert_true(mean_best_error(config, input.sequence) < 0.5 * plain);
    texture_free(&input);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plan_of_two_inputs_uses_both),
        cmocka_unit_test(a_further_input_may_be_smaller_than_a_block),
        cmocka_unit_test(inputs_that_do_not_go_together_are_refused),
        cmocka_unit_test(a_mirror_leaves_upright_what_stands),
        cmocka_unit_test(blocks_are_turned_as_asked_and_no_other_way),
        cmocka_unit_test(turned_blocks_fit_better),
        cmocka_unit_test(a_ramp_that_ends_is_gone_back_on_by_its_mirror),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
