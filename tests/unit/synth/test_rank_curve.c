/* SPDX-License-Identifier: Apache-2.0 */
/* The curve of ranks is what a run's own report says of its compression. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>

#include "textures.h"
#include "ttf/synth/rank_curve.h"

static void same_as_a_plan_says(bool per_channel)
{
    struct texture_sequence texture = texture_make(TEXTURE_SPOTS, 48, 40, 30);
    struct ttf_quilt_rank_curve curve;
    struct ttf_quilt_config config;
    struct ttf_quilt_map map;

    ttf_quilt_defaults(&config);
    config.width = config.height = 50;
    config.block_width = config.block_height = 16;
    config.rank = 20;
    config.per_channel = per_channel;
    assert_int_equal(ttf_quilt_plan(&config, texture.sequence, NULL, &map, NULL), 0);
    assert_int_equal(ttf_quilt_rank_curve(&config, texture.sequence, NULL, &curve, NULL), 0);
    assert_int_equal(curve.n, 21);
    for (unsigned k = 0; k < curve.n; k++) {
        assert_float_equal(curve.errors[k], map.rank.errors[k], 1e-12);
        if (k > 0)
            assert_true(curve.errors[k] <= curve.errors[k - 1]);
    }
    assert_float_equal(curve.errors[0], 1.0, 1e-12);
    assert_float_equal(curve.rms[20], map.rank.rms, 1e-12);
    ttf_quilt_map_free(&map);
    texture_free(&texture);
}

static void a_curve_is_what_a_plan_says(void **state)
{
    (void)state;
    same_as_a_plan_says(false);
    same_as_a_plan_says(true);
}

static void a_constant_input_needs_one_number(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_CONSTANT, 20, 20, 12);
    struct ttf_quilt_rank_curve curve;
    struct ttf_quilt_config config;

    (void)state;
    ttf_quilt_defaults(&config);
    config.rank = 5;
    assert_int_equal(ttf_quilt_rank_curve(&config, texture.sequence, NULL, &curve, NULL), 0);
    assert_true(curve.rms[0] > 0.01);
    assert_true(curve.rms[1] < 1e-4);
    texture_free(&texture);
}

static void no_rank_has_no_curve(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_CONSTANT, 20, 20, 3);
    struct ttf_quilt_rank_curve curve;
    struct ttf_quilt_config config;

    (void)state;
    ttf_quilt_defaults(&config);
    config.rank = 0;
    assert_int_equal(ttf_quilt_rank_curve(&config, texture.sequence, NULL, &curve, NULL), -EINVAL);
    config.rank = 65;
    assert_int_equal(ttf_quilt_rank_curve(&config, texture.sequence, NULL, &curve, NULL), -EINVAL);
    texture_free(&texture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_curve_is_what_a_plan_says),
        cmocka_unit_test(a_constant_input_needs_one_number),
        cmocka_unit_test(no_rank_has_no_curve),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
