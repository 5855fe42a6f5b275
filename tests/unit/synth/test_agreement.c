/* SPDX-License-Identifier: Apache-2.0 */
/* Matching in k-space judged by the search over all frames. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "quilts.h"
#include "ttf/synth/agreement.h"

static struct ttf_quilt_config small_config(void)
{
    struct ttf_quilt_config config;

    ttf_quilt_defaults(&config);
    config.width = 90;
    config.height = 80;
    config.block_width = config.block_height = 16;
    return config;
}

static void agreement_of(const struct ttf_quilt_config *config, enum texture texture, uint32_t n,
                         unsigned most, struct ttf_pool *pool, struct ttf_agreement *ret)
{
    struct texture_sequence input = texture_make(texture, 44, 40, n);
    struct ttf_quilt_map map;
    struct ttf_err err = {0};

    quilt_plan_ok(config, input.sequence, pool, &map);
    if (ttf_quilt_agreement(config, input.sequence, &map, most, pool, ret, &err) < 0)
        fail_msg("%s", err.what);
    ttf_quilt_map_free(&map);
    texture_free(&input);
}

static void where_nothing_is_lost_the_searches_agree(void **state)
{
    struct ttf_quilt_config config = small_config();
    struct ttf_agreement figures;

    (void)state;
    config.rank = 40; /* of 12 frames of three channels */
    agreement_of(&config, TEXTURE_SPOTS, 12, 0, NULL, &figures);
    assert_int_equal(figures.queries, 7 * 6 - 1);
    assert_true(figures.best == 1.0 && figures.extra_cost == 0.0);
    assert_true(figures.jaccard > 0.999);
    assert_true(figures.jumps > 0 && figures.jump_best == 1.0 && figures.jump_extra_cost == 0.0);
}

static void where_most_is_lost_they_do_not(void **state)
{
    struct ttf_quilt_config config = small_config();
    struct ttf_agreement figures;

    (void)state;
    config.rank = 1;
    config.tolerance = 0.0;
    agreement_of(&config, TEXTURE_NOISE, 20, 0, NULL, &figures);
    assert_true(figures.jumps > 5);
    assert_true(figures.best < 0.8 && figures.jump_best < 0.7);
    assert_true(figures.jump_extra_cost > 0.01 && figures.extra_cost > 0.01);
    assert_true(figures.jaccard < 0.6);
}

static void as_many_queries_as_asked_for_are_compared(void **state)
{
    struct ttf_quilt_config config = small_config();

    (void)state;
    for (config.seed = 1; config.seed <= 3; config.seed++) {
        for (unsigned most = 1; most < 50; most += 12) {
            struct ttf_agreement figures;

            agreement_of(&config, TEXTURE_SPOTS, 4, most, NULL, &figures);
            assert_int_equal(figures.queries, most < 41 ? most : 41);
            assert_true(figures.best >= 0.0 && figures.best <= 1.0);
            assert_true(figures.jaccard >= 0.0 && figures.jaccard <= 1.0);
        }
    }
}

static void threads_change_no_figure(void **state)
{
    struct ttf_quilt_config config = small_config();
    struct ttf_pool *pool = ttf_pool_create(4);
    struct ttf_agreement one = {0}, four = {0};

    (void)state;
    config.rank = 2;
    agreement_of(&config, TEXTURE_SPOTS, 20, 9, NULL, &one);
    agreement_of(&config, TEXTURE_SPOTS, 20, 9, pool, &four);
    assert_memory_equal(&one, &four, sizeof(one));
    ttf_pool_destroy(pool);
}

static void a_map_made_of_larger_blocks_than_now_asked_for_is_judged_as_well(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 44, 40, 6);
    struct ttf_quilt_config config = small_config(), smaller = config;
    struct ttf_agreement a = {0}, b = {0};
    struct ttf_quilt_map map;

    (void)state;
    smaller.block_width = smaller.block_height = 5;
    quilt_plan_ok(&config, input.sequence, NULL, &map);
    assert_int_equal(ttf_quilt_agreement(&config, input.sequence, &map, 0, NULL, &a, NULL), 0);
    assert_int_equal(ttf_quilt_agreement(&smaller, input.sequence, &map, 0, NULL, &b, NULL), 0);
    assert_memory_equal(&a, &b, sizeof(a));
    ttf_quilt_map_free(&map);
    texture_free(&input);
}

static void not_compared(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                         const struct ttf_quilt_map *map)
{
    struct ttf_agreement figures;
    struct ttf_err err = {0};

    assert_int_equal(ttf_quilt_agreement(config, input, map, 0, NULL, &figures, &err), -EINVAL);
    assert_string_equal(err.where, "agreement");
    assert_true(err.what[0] != '\0');
}

static void maps_that_the_full_search_cannot_make_are_refused(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 44, 40, 6);
    struct texture_sequence other = texture_make(TEXTURE_SPOTS, 43, 40, 6);
    struct ttf_quilt_config config = small_config(), own;
    struct ttf_quilt_map map;

    (void)state;
    own = config;
    own.more = &other.sequence;
    own.n_more = 1;
    quilt_plan_ok(&own, input.sequence, NULL, &map);
    not_compared(&own, input.sequence, &map);
    ttf_quilt_map_free(&map);
    own = config;
    own.flips = own.rotations = true;
    quilt_plan_ok(&own, input.sequence, NULL, &map);
    not_compared(&own, input.sequence, &map);
    ttf_quilt_map_free(&map);
    own = config;
    own.tileable = true;
    quilt_plan_ok(&own, input.sequence, NULL, &map);
    not_compared(&own, input.sequence, &map);
    ttf_quilt_map_free(&map);
    quilt_plan_ok(&config, input.sequence, NULL, &map);
    not_compared(&config, other.sequence, &map); /* a map of another input */
    config.rank = TTF_QUILT_RANK_FULL;           /* nothing to compare with */
    not_compared(&config, input.sequence, &map);
    config.agreement_queries = 3;
    quilt_refused(&config, input.sequence, -EINVAL, "agreement");
    config.rank = 15;
    config.per_frame = true; /* before anything is searched for */
    quilt_refused(&config, input.sequence, -EINVAL, "agreement");
    config.per_frame = false;
    config.tileable = true;
    config.cancel = &(const int){1};
    quilt_refused(&config, input.sequence, -EINVAL, "agreement");
    ttf_quilt_map_free(&map);
    texture_free(&input);
    texture_free(&other);
}

static void a_comparison_can_be_cancelled(void **state)
{
    static const int stop = 1;
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 44, 40, 6);
    struct ttf_quilt_config config = small_config();
    struct ttf_agreement figures;
    struct ttf_quilt_map map;

    (void)state;
    quilt_plan_ok(&config, input.sequence, NULL, &map);
    config.cancel = &stop;
    assert_int_equal(ttf_quilt_agreement(&config, input.sequence, &map, 0, NULL, &figures, NULL),
                     -ECANCELED);
    ttf_quilt_map_free(&map);
    texture_free(&input);
}

static void one_block_is_no_query(void **state)
{
    struct ttf_quilt_config config = small_config();
    struct ttf_agreement figures;

    (void)state;
    config.width = config.height = 16;
    agreement_of(&config, TEXTURE_SPOTS, 4, 3, NULL, &figures);
    assert_int_equal(figures.queries, 0);
    assert_true(figures.best == 0.0 && figures.jaccard == 0.0 && figures.extra_cost == 0.0);
}

static void a_constant_input_agrees_everywhere(void **state)
{
    struct ttf_quilt_config config = small_config();
    struct ttf_agreement figures;

    (void)state;
    agreement_of(&config, TEXTURE_CONSTANT, 5, 0, NULL, &figures);
    assert_true(figures.best == 1.0 && figures.jaccard == 1.0 && figures.extra_cost == 0.0);
    assert_int_equal(figures.jumps, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(where_nothing_is_lost_the_searches_agree),
        cmocka_unit_test(where_most_is_lost_they_do_not),
        cmocka_unit_test(as_many_queries_as_asked_for_are_compared),
        cmocka_unit_test(threads_change_no_figure),
        cmocka_unit_test(a_map_made_of_larger_blocks_than_now_asked_for_is_judged_as_well),
        cmocka_unit_test(maps_that_the_full_search_cannot_make_are_refused),
        cmocka_unit_test(a_comparison_can_be_cancelled),
        cmocka_unit_test(one_block_is_no_query),
        cmocka_unit_test(a_constant_input_agrees_everywhere),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
