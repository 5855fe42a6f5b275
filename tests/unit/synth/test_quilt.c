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

#include "quilt/layers.h"
#include "reference.h"
#include "textures.h"
#include "ttf/synth/quilt.h"

static struct ttf_quilt_config small_config(void)
{
    struct ttf_quilt_config config;

    ttf_quilt_defaults(&config);
    config.width = 70;
    config.height = 60;
    config.block_width = 18;
    config.block_height = 18;
    config.seed = 5;
    config.rank = TTF_QUILT_RANK_FULL;
    return config;
}

static void plan_ok(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                    struct ttf_pool *pool, struct ttf_quilt_map *ret)
{
    struct ttf_err err = {0};
    int r = ttf_quilt_plan(config, input, pool, ret, &err);

    if (r < 0)
        fail_msg("%s", err.what);
}

/* The plan against the plain reference, pixel for pixel. */
static void matches_reference(enum texture texture, uint32_t width, uint32_t height, uint32_t n,
                              const struct ttf_quilt_config *config)
{
    struct texture_sequence input = texture_make(texture, width, height, n);
    struct ttf_trajectories trajectories;
    struct reference reference;
    struct ttf_quilt_map map;
    uint32_t *want;

    plan_ok(config, input.sequence, NULL, &map);
    assert_int_equal(ttf_trajectories_load(input.sequence, 0, n, config->metric, NULL, NULL,
                                           &trajectories, NULL),
                     0);
    reference = reference_of_trajectories(&trajectories, map.figures.noise_variance);
    want = reference_plan(&reference, config);
    assert_memory_equal(map.source, want, (size_t)config->width * config->height * sizeof(*want));
    free(want);
    ttf_trajectories_free(&trajectories);
    ttf_quilt_map_free(&map);
    texture_free(&input);
}

static void the_map_is_that_of_the_plainest_implementation(void **state)
{
    struct ttf_quilt_config config = small_config();

    (void)state;
    matches_reference(TEXTURE_SPOTS, 40, 36, 12, &config);
    matches_reference(TEXTURE_SPOTS, 40, 36, 36, &config);
    matches_reference(TEXTURE_NOISE, 30, 34, 3, &config);
    matches_reference(TEXTURE_OBJECT, 40, 36, 6, &config);
    matches_reference(TEXTURE_STRIPES, 40, 30, 4, &config);
    config.tolerance = 0.5;
    config.metric = TTF_METRIC_LINEAR;
    matches_reference(TEXTURE_SPOTS, 40, 36, 12, &config);
}

static void elongated_blocks_and_wide_overlaps_work_as_well(void **state)
{
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.block_width = 10;
    config.block_height = 30;
    matches_reference(TEXTURE_SPOTS, 40, 36, 12, &config);
    config.block_width = 31;
    config.block_height = 8;
    matches_reference(TEXTURE_SPOTS, 40, 36, 12, &config);
    config.overlap_x = 15;
    config.overlap_y = 4;
    matches_reference(TEXTURE_SPOTS, 40, 36, 12, &config);
    config.block_width = config.block_height = 4; /* the smallest */
    config.overlap_x = config.overlap_y = 0;
    matches_reference(TEXTURE_SPOTS, 24, 20, 5, &config);
    config.overlap_x = config.overlap_y = 1;
    matches_reference(TEXTURE_SPOTS, 24, 20, 5, &config);
}

static void any_output_size_is_covered_to_its_last_pixel(void **state)
{
    static const uint32_t sizes[][2] = {{1, 1},   {18, 18}, {19, 18}, {18, 33}, {17, 5},
                                        {48, 48}, {49, 47}, {3, 100}, {95, 1}};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 4);
    struct ttf_quilt_config config = small_config();

    (void)state;
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++) {
        struct ttf_quilt_map map;

        config.width = sizes[i][0];
        config.height = sizes[i][1];
        matches_reference(TEXTURE_SPOTS, 40, 36, 4, &config);
        plan_ok(&config, input.sequence, NULL, &map);
        for (uint32_t p = 0; p < config.width * config.height; p++)
            assert_true(map.source[p] < 40 * 36);
        for (unsigned b = 0; b < map.n_blocks; b++) {
            const struct ttf_quilt_block *block = &map.blocks[b];

            assert_true(block->src_x + block->width <= 40 && block->src_y + block->height <= 36);
            assert_true(block->out_x + block->width <= config.width);
            assert_true(block->out_y + block->height <= config.height);
        }
        ttf_quilt_map_free(&map);
    }
    texture_free(&input);
}

static void a_block_as_large_as_the_input_leaves_no_choice(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 4);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map map;

    (void)state;
    config.block_width = config.width = 40;
    config.block_height = config.height = 36;
    plan_ok(&config, input.sequence, NULL, &map);
    assert_int_equal(map.n_blocks, 1);
    for (uint32_t p = 0; p < 40 * 36; p++)
        assert_int_equal(map.source[p], p);
    ttf_quilt_map_free(&map);
    config.width = 90;
    config.height = 80;
    matches_reference(TEXTURE_SPOTS, 40, 36, 4, &config);
    texture_free(&input);
}

static void every_output_pixel_is_copied_bit_for_bit_through_one_map(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 9);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map map;
    uint16_t *frame = malloc((size_t)config.width * config.height * 3 * sizeof(*frame));

    (void)state;
    assert_non_null(frame);
    plan_ok(&config, input.sequence, NULL, &map);
    for (uint32_t t = 0; t < 9; t++) {
        const uint16_t *source = input.codes + (size_t)t * 40 * 36 * 3;

        ttf_quilt_compose(&map, source, frame);
        for (uint32_t p = 0; p < config.width * config.height; p++)
            assert_memory_equal(frame + 3 * (size_t)p, source + 3 * (size_t)map.source[p], 6);
    }
    free(frame);
    ttf_quilt_map_free(&map);
    texture_free(&input);
}

static void blocks_agree_with_the_map(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 9);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map map;

    (void)state;
    plan_ok(&config, input.sequence, NULL, &map);
    assert_int_equal(map.overlap_x, 3);
    assert_int_equal(map.n_blocks, 5 * 4);
    for (unsigned b = 0; b < map.n_blocks; b++) {
        const struct ttf_quilt_block *block = &map.blocks[b];
        uint32_t y = block->out_y + block->height / 2, x = block->out_x + block->width / 2;

        /* the middle of a block belongs to no overlap */
        if (block->width > 8 && block->height > 8)
            assert_int_equal(map.source[y * map.width + x],
                             (block->src_y + block->height / 2) * 40 + block->src_x +
                                 block->width / 2);
        assert_true(block->candidates >= 1);
        assert_true(block->error >= block->best_error);
        assert_true(b == 0 || block->overlap_pixels > 0);
    }
    ttf_quilt_map_free(&map);
    texture_free(&input);
}

static void any_number_of_threads_gives_the_same_map(void **state)
{
    static const unsigned threads[] = {1, 2, 5};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 64, 50, 40);
    struct ttf_quilt_config config = small_config();
    uint64_t digest = 0;

    (void)state;
    for (int i = 0; i < 3; i++) {
        struct ttf_pool *pool = ttf_pool_create(threads[i]);
        struct ttf_quilt_map map;

        assert_non_null(pool);
        plan_ok(&config, input.sequence, pool, &map);
        assert_true(i == 0 || ttf_quilt_map_digest(&map) == digest);
        digest = ttf_quilt_map_digest(&map);
        ttf_quilt_map_free(&map);
        ttf_pool_destroy(pool);
    }
    texture_free(&input);
}

static void seeds_give_different_pictures_and_each_seed_always_the_same(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 9);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map a, b, c;

    (void)state;
    plan_ok(&config, input.sequence, NULL, &a);
    plan_ok(&config, input.sequence, NULL, &b);
    config.seed++;
    plan_ok(&config, input.sequence, NULL, &c);
    assert_true(ttf_quilt_map_digest(&a) == ttf_quilt_map_digest(&b));
    assert_true(ttf_quilt_map_digest(&a) != ttf_quilt_map_digest(&c));
    ttf_quilt_map_free(&a);
    ttf_quilt_map_free(&b);
    ttf_quilt_map_free(&c);
    texture_free(&input);
}

static void a_constant_input_offers_every_position(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_CONSTANT, 40, 36, 9);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map map;

    (void)state;
    plan_ok(&config, input.sequence, NULL, &map);
    for (unsigned b = 0; b < map.n_blocks; b++) {
        const struct ttf_quilt_block *block = &map.blocks[b];

        assert_int_equal(block->candidates, (40 - block->width + 1) * (36 - block->height + 1));
        assert_true(block->error == 0.0);
    }
    ttf_quilt_map_free(&map);
    texture_free(&input);
}

static void feathering_blends_light_near_seams_and_nowhere_else(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 9);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map hard, soft;
    size_t pixels = (size_t)config.width * config.height, changed = 0;
    uint16_t *a = malloc(pixels * 6), *b = malloc(pixels * 6);
    uint8_t *layered = calloc(pixels, 1);

    (void)state;
    assert_true(a && b && layered);
    config.block_width = config.block_height = 24; /* overlap 4 */
    plan_ok(&config, input.sequence, NULL, &hard);
    config.feather_px = 4;
    plan_ok(&config, input.sequence, NULL, &soft);
    assert_int_equal(hard.n_layers, 0);
    assert_true(soft.n_layers > 0);
    assert_memory_equal(hard.source, soft.source, pixels * sizeof(*hard.source));
    for (size_t i = 0; i < soft.n_layers; i++)
        layered[soft.layers[i].pixel] = 1;
    ttf_quilt_compose(&hard, input.codes, a);
    ttf_quilt_compose(&soft, input.codes, b);
    for (size_t p = 0; p < pixels; p++) {
        changed += memcmp(a + 3 * p, b + 3 * p, 6) != 0;
        if (!layered[p])
            assert_memory_equal(a + 3 * p, b + 3 * p, 6);
    }
    assert_true(changed > 100 && changed < pixels / 2);
    free(a);
    free(b);
    free(layered);
    ttf_quilt_map_free(&hard);
    ttf_quilt_map_free(&soft);
    texture_free(&input);
}

static void a_feather_is_a_ramp_centred_on_the_cut(void **state)
{
    (void)state;
    /* 12 pixels, cut before 6, 4 wide: eighths at the centres of four pixels */
    assert_int_equal(ttf_layers_weight(3, 6, 12, 4), 0);
    assert_int_equal(ttf_layers_weight(4, 6, 12, 4), 65536 / 8);
    assert_int_equal(ttf_layers_weight(5, 6, 12, 4), 65536 * 3 / 8);
    assert_int_equal(ttf_layers_weight(6, 6, 12, 4), 65536 * 5 / 8);
    assert_int_equal(ttf_layers_weight(7, 6, 12, 4), 65536 * 7 / 8);
    assert_int_equal(ttf_layers_weight(8, 6, 12, 4), 65536);
    /* none asked for, one pixel, or no room: a step */
    for (uint32_t i = 0; i < 12; i++) {
        assert_int_equal(ttf_layers_weight(i, 6, 12, 0), i < 6 ? 0 : 65536);
        assert_int_equal(ttf_layers_weight(i, 6, 12, 1), i < 6 ? 0 : 65536);
        assert_int_equal(ttf_layers_weight(i, 0, 12, 4), 65536);
    }
    /* near the edge of the overlap the ramp is narrower and never leaves it */
    assert_int_equal(ttf_layers_weight(0, 1, 12, 8), 65536 / 4);
    assert_int_equal(ttf_layers_weight(1, 1, 12, 8), 65536 * 3 / 4);
    assert_int_equal(ttf_layers_weight(2, 1, 12, 8), 65536);
}

static void layers_are_laid_one_over_the_other(void **state)
{
    uint32_t source[2] = {0, 1};
    struct ttf_quilt_layer layers[] = {{1, 1, 65536, 0}, {1, 2, 16384, 0}, {1, 0, 32768, 0}};
    const struct ttf_quilt_map map = {.width = 2,
                                      .height = 1,
                                      .n_inputs = 1,
                                      .inputs = {{3, 1, 0}},
                                      .source_pixels = 3,
                                      .source = source,
                                      .n_layers = 3,
                                      .layers = layers};
    const uint16_t codes[9] = {0, 100, 65535, 1000, 2000, 3000, 5000, 2000, 65535};
    uint16_t got[6];

    (void)state;
    ttf_quilt_compose(&map, codes, got);
    assert_memory_equal(got, codes, 6);
    assert_int_equal(got[3], 1000); /* (1000 * 3 + 5000) / 4 / 2 */
    assert_int_equal(got[4], 1050); /* (2000 + 100) / 2 */
    assert_int_equal(got[5], ((3000 * 3 + 65535 + 2) / 4 + 65535 + 1) / 2); /* rounded each time */
}

static void a_blend_of_equal_light_changes_nothing(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_CONSTANT, 40, 36, 2);
    struct ttf_quilt_config config = small_config();
    uint16_t *frame = malloc((size_t)config.width * config.height * 6);
    struct ttf_quilt_map map;

    (void)state;
    assert_non_null(frame);
    config.feather_px = 3;
    plan_ok(&config, input.sequence, NULL, &map);
    ttf_quilt_compose(&map, input.codes, frame);
    for (uint32_t p = 0; p < config.width * config.height; p++)
        assert_memory_equal(frame + 3 * (size_t)p, input.codes, 6);
    free(frame);
    ttf_quilt_map_free(&map);
    texture_free(&input);
}

static void frames_quilted_alone_have_maps_of_their_own(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 9);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map a, b;

    (void)state;
    config.per_frame = true;
    assert_int_equal(ttf_quilt_plan(&config, input.sequence, NULL, &a, NULL), -EINVAL);
    assert_int_equal(ttf_quilt_frame_map(&config, input.sequence, 9, NULL, &a, NULL), -EINVAL);
    assert_int_equal(ttf_quilt_frame_map(&config, input.sequence, 3, NULL, &a, NULL), 0);
    assert_int_equal(ttf_quilt_frame_map(&config, input.sequence, 4, NULL, &b, NULL), 0);
    assert_true(ttf_quilt_map_digest(&a) != ttf_quilt_map_digest(&b));
    ttf_quilt_map_free(&a);
    ttf_quilt_map_free(&b);
    texture_free(&input);
}

static void refused(struct ttf_quilt_config config, struct ttf_sequence *input, int code,
                    const char *where)
{
    struct ttf_err err = {0};
    struct ttf_quilt_map map;

    assert_int_equal(ttf_quilt_plan(&config, input, NULL, &map, &err), code);
    assert_int_equal(err.code, code);
    assert_string_equal(err.where, where);
    assert_true(err.what[0] != '\0');
}

static void impossible_settings_are_refused_by_name(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 3);
    struct ttf_quilt_config good = small_config(), bad;

    (void)state;
#define REFUSED(field, value, code, where)         \
    do {                                           \
        bad = good;                                \
        bad.field = (value);                       \
        refused(bad, input.sequence, code, where); \
    } while (0)
    REFUSED(width, 0, -EINVAL, "size");
    REFUSED(height, 40000, -EINVAL, "size");
    REFUSED(block_width, 3, -EINVAL, "block");
    REFUSED(block_width, 41, -EINVAL, "block");
    REFUSED(block_height, 37, -EINVAL, "block");
    REFUSED(overlap_x, 10, -EINVAL, "overlap");
    REFUSED(overlap_y, 18, -EINVAL, "overlap");
    REFUSED(feather_px, 4, -EINVAL, "feather");
    REFUSED(tolerance, -0.1, -EINVAL, "tolerance");
    REFUSED(tolerance, (double)NAN, -EINVAL, "tolerance");
    REFUSED(metric, (enum ttf_metric)7, -EINVAL, "metric");
    REFUSED(memory_bytes, 1000, -EFBIG, "");
#undef REFUSED
    texture_free(&input);
}

static int stop_now;

static void stop_after_half(void *ctx, double done)
{
    (void)ctx;
    if (done > 0.5)
        stop_now = 1;
}

static void a_plan_can_be_cancelled(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 3);
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.cancel = &stop_now;
    stop_now = 1;
    refused(config, input.sequence, -ECANCELED, "");
    stop_now = 0;
    config.progress = stop_after_half;
    refused(config, input.sequence, -ECANCELED, "");
    stop_now = 0;
    texture_free(&input);
}

static int broken_read(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                       uint16_t *dst, struct ttf_err *err)
{
    (void)y0;
    memset(dst, 0, (size_t)rows * sequence->width * 6);
    return t < 5 ? 0 : ttf_err_set(err, -EIO, "frame", "cannot be read");
}

static void an_unreadable_frame_is_reported_as_what_it_is(void **state)
{
    static const struct ttf_sequence_ops ops = {.read_rows = broken_read};
    struct ttf_sequence input = {
        .ops = &ops, .width = 40, .height = 36, .n = 60, .encoding = texture_encoding};

    (void)state;
    refused(small_config(), &input, -EIO, "frame");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_map_is_that_of_the_plainest_implementation),
        cmocka_unit_test(elongated_blocks_and_wide_overlaps_work_as_well),
        cmocka_unit_test(any_output_size_is_covered_to_its_last_pixel),
        cmocka_unit_test(a_block_as_large_as_the_input_leaves_no_choice),
        cmocka_unit_test(every_output_pixel_is_copied_bit_for_bit_through_one_map),
        cmocka_unit_test(blocks_agree_with_the_map),
        cmocka_unit_test(any_number_of_threads_gives_the_same_map),
        cmocka_unit_test(seeds_give_different_pictures_and_each_seed_always_the_same),
        cmocka_unit_test(a_constant_input_offers_every_position),
        cmocka_unit_test(feathering_blends_light_near_seams_and_nowhere_else),
        cmocka_unit_test(a_feather_is_a_ramp_centred_on_the_cut),
        cmocka_unit_test(layers_are_laid_one_over_the_other),
        cmocka_unit_test(a_blend_of_equal_light_changes_nothing),
        cmocka_unit_test(frames_quilted_alone_have_maps_of_their_own),
        cmocka_unit_test(impossible_settings_are_refused_by_name),
        cmocka_unit_test(a_plan_can_be_cancelled),
        cmocka_unit_test(an_unreadable_frame_is_reported_as_what_it_is),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
