/* SPDX-License-Identifier: Apache-2.0 */
/* Plans in k-space: against the plain reference, from known factors; their maps. */
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
#include "reference.h"
#include "search/matching.h"
#include "search/sources.h"

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

/* ---- against the plain reference ---- */

static void input_matches_reference(struct ttf_sequence *input,
                                    const struct ttf_quilt_config *config, unsigned threads)
{
    struct ttf_pool *pool = ttf_pool_create(threads);
    struct ttf_sources sources;
    struct ttf_matching matching;
    struct reference reference;
    struct ttf_quilt_map map;
    uint32_t *want;

    assert_non_null(pool);
    quilt_plan_ok(config, input, pool, &map);
    assert_int_equal(ttf_sources_of(config, input, &sources, NULL), 0);
    assert_int_equal(ttf_matching_build(config, &sources, 0, input->n, NULL, NULL, &matching, NULL),
                     0);
    reference = reference_of_matching(&matching, input->width);
    want = reference_plan(&reference, config);
    assert_memory_equal(map.source, want, (size_t)config->width * config->height * sizeof(*want));
    quilt_blocks_are_what_is_shown(&map);
    assert_int_equal(map.rank.numbers, matching.k);
    assert_true(!(config->rank_error > 0.0) || map.rank.error <= config->rank_error);
    free(want);
    ttf_matching_free(&matching);
    ttf_quilt_map_free(&map);
    ttf_pool_destroy(pool);
}

static void matches_reference(enum texture texture, uint32_t width, uint32_t height, uint32_t n,
                              const struct ttf_quilt_config *config, unsigned threads)
{
    struct texture_sequence input = texture_make(texture, width, height, n);

    input_matches_reference(input.sequence, config, threads);
    texture_free(&input);
}

static void the_map_is_that_of_the_plainest_implementation(void **state)
{
    struct ttf_quilt_config config = small_config();

    (void)state;
    matches_reference(TEXTURE_SPOTS, 40, 36, 12, &config, 1);
    matches_reference(TEXTURE_SPOTS, 40, 36, 36, &config, 2);
    matches_reference(TEXTURE_NOISE, 30, 34, 3, &config, 5);
    matches_reference(TEXTURE_OBJECT, 40, 36, 6, &config, 5);
    matches_reference(TEXTURE_STRIPES, 40, 30, 4, &config, 2);
    matches_reference(TEXTURE_CONSTANT, 30, 30, 4, &config, 5);
    config.tolerance = 0.5;
    config.metric = TTF_METRIC_LINEAR;
    matches_reference(TEXTURE_SPOTS, 40, 36, 12, &config, 5);
}

static void any_rank_and_kind_of_factorisation_matches_as_well(void **state)
{
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.rank = 1;
    matches_reference(TEXTURE_SPOTS, 40, 36, 20, &config, 2);
    config.rank = TTF_QUILT_RANK_MAX;
    matches_reference(TEXTURE_NOISE, 30, 34, 24, &config, 2);
    config.rank = 5;
    config.per_channel = true;
    matches_reference(TEXTURE_SPOTS, 40, 36, 20, &config, 5);
    config.per_channel = false;
    config.rank = TTF_QUILT_RANK_FULL; /* rank_error is heeded instead */
    config.rank_error = 0.03;
    matches_reference(TEXTURE_SPOTS, 40, 36, 20, &config, 5);
}

static void noise_decides_which_repeats_are_alike(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_STRIPES, 40, 30, 12);
    struct ttf_quilt_config config = small_config();
    unsigned most = 0;

    (void)state;
    for (uint32_t i = 0; i < 40 * 30 * 12 * 3; i++)
        input.codes[i] = (uint16_t)(input.codes[i] + 2000 + texture_hash(i, 1, 2) % 700);
    for (int per_channel = 0; per_channel < 2; per_channel++) {
        struct ttf_quilt_map map;

        config.per_channel = per_channel;
        config.rank = per_channel ? 4 : 12;
        input_matches_reference(input.sequence, &config, 2);
        quilt_plan_ok(&config, input.sequence, NULL, &map);
        for (unsigned i = 1; i < map.n_blocks; i++)
            most = map.blocks[i].candidates > most ? map.blocks[i].candidates : most;
        assert_in_range(most, 2, 200); /* not just the one that goes on, nor any */
        ttf_quilt_map_free(&map);
    }
    texture_free(&input);
}

static void elongated_blocks_and_wide_overlaps_work_as_well(void **state)
{
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.block_width = 10;
    config.block_height = 30;
    matches_reference(TEXTURE_SPOTS, 40, 36, 12, &config, 5);
    config.block_width = 31;
    config.block_height = 8;
    matches_reference(TEXTURE_SPOTS, 40, 36, 12, &config, 2);
    config.overlap_x = 15;
    config.overlap_y = 4; /* half a block: the most that rows must stay apart */
    matches_reference(TEXTURE_SPOTS, 40, 36, 12, &config, 5);
    config.block_width = config.block_height = 4; /* the smallest */
    config.overlap_x = config.overlap_y = 0;
    matches_reference(TEXTURE_SPOTS, 24, 20, 5, &config, 5);
    config.overlap_x = config.overlap_y = 1;
    matches_reference(TEXTURE_SPOTS, 24, 20, 5, &config, 2);
    config.block_width = 20; /* as large as the input */
    config.block_height = 16;
    config.overlap_x = config.overlap_y = 0;
    matches_reference(TEXTURE_SPOTS, 20, 16, 5, &config, 2);
}

static void any_output_size_is_covered_to_its_last_pixel(void **state)
{
    static const uint32_t sizes[][2] = {{1, 1},   {18, 18}, {19, 18}, {18, 33}, {17, 5},
                                        {48, 48}, {49, 47}, {3, 100}, {95, 1}};
    struct ttf_quilt_config config = small_config();

    (void)state;
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++) {
        config.width = sizes[i][0];
        config.height = sizes[i][1];
        matches_reference(TEXTURE_SPOTS, 40, 36, 4, &config, 2);
    }
}

static uint64_t digest_of(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                          unsigned threads)
{
    struct ttf_pool *pool = ttf_pool_create(threads);
    struct ttf_quilt_map map;
    uint64_t digest;

    assert_non_null(pool);
    quilt_plan_ok(config, input, pool, &map);
    digest = ttf_quilt_map_digest(&map);
    ttf_quilt_map_free(&map);
    ttf_pool_destroy(pool);
    return digest;
}

static void everything_asked_for_at_once_is_the_same_for_any_threads(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 50, 44, 12);
    struct texture_sequence other = texture_make(TEXTURE_NOISE, 31, 52, 12);
    struct ttf_quilt_config config = small_config();
    uint64_t digest;

    (void)state;
    config.width = 130;
    config.height = 110;
    config.more = &other.sequence;
    config.n_more = 1;
    config.flips = config.rotations = true;
    config.avoid_px = 3;
    config.feather_px = 2;
    config.jitter_frames = 2;
    config.jitter_every = 3;
    for (int tileable = 0; tileable < 2; tileable++) {
        config.tileable = tileable;
        digest = digest_of(&config, input.sequence, 1);
        assert_true(digest == digest_of(&config, input.sequence, 1));
        assert_true(digest == digest_of(&config, input.sequence, 2));
        assert_true(digest == digest_of(&config, input.sequence, 5));
        config.seed++;
        assert_true(digest != digest_of(&config, input.sequence, 2));
    }
    texture_free(&input);
    texture_free(&other);
}

/* ---- maps and factors ---- */

static void a_copied_map_is_equal_and_lives_alone(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 9);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map map, copy, empty = {0};
    uint64_t digest;

    (void)state;
    config.feather_px = 2;
    config.jitter_frames = 2;
    config.jitter_every = 3;
    quilt_plan_ok(&config, input.sequence, NULL, &map);
    digest = ttf_quilt_map_digest(&map);
    assert_int_equal(ttf_quilt_map_copy(&map, &copy), 0);
    assert_memory_equal(copy.blocks, map.blocks, map.n_blocks * sizeof(*map.blocks));
    assert_memory_equal(copy.cuts, map.cuts, map.n_cuts * sizeof(*map.cuts));
    assert_memory_equal(copy.owner, map.owner, (size_t)70 * 60 * sizeof(*map.owner));
    ttf_quilt_map_free(&map);
    assert_true(ttf_quilt_map_digest(&copy) == digest);
    copy.source[17] ^= 1;
    assert_true(ttf_quilt_map_digest(&copy) != digest);
    copy.source[17] ^= 1;
    copy.times[20] ^= 1;
    assert_true(ttf_quilt_map_digest(&copy) != digest);
    ttf_quilt_map_free(&copy);
    assert_int_equal(ttf_quilt_map_copy(&empty, &copy), 0);
    ttf_quilt_map_free(&copy);
    texture_free(&input);
}

struct kept {
    uint8_t *bytes;
    size_t size;
};

static int keep(void *ctx, const struct ttf_quilt_factors *factors)
{
    struct kept *kept = ctx;

    free(kept->bytes);
    kept->bytes = malloc(factors->size);
    if (!kept->bytes)
        return -ENOMEM;
    memcpy(kept->bytes, factors->bytes, factors->size);
    kept->size = factors->size;
    return 0;
}

/* A sequence whose first 24 frames are gone. */
struct late {
    struct ttf_sequence base, *whole;
};

static int late_read(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                     uint16_t *dst, struct ttf_err *err)
{
    const struct late *late = (const struct late *)sequence;

    if (t < 24)
        return ttf_err_set(err, -EIO, "frame", "cannot be read");
    return ttf_sequence_read_rows(late->whole, t, y0, rows, dst, err);
}

static void known_factors_are_gone_on_with(void **state)
{
    struct texture_sequence long_one = texture_make(TEXTURE_SPOTS, 40, 36, 40);
    struct ttf_quilt_config config = small_config();
    static const struct ttf_sequence_ops ops = {.read_rows = late_read};
    struct late late = {*long_one.sequence, long_one.sequence};
    struct kept kept = {0};
    struct ttf_sequence *shorter;
    struct ttf_quilt_map first, again, grown;

    (void)state;
    assert_int_equal(
        ttf_sequence_of_memory(long_one.codes, 40, 36, 25, &texture_encoding, &shorter, NULL), 0);
    config.keep_factors = keep;
    config.keep_ctx = &kept;
    quilt_plan_ok(&config, shorter, NULL, &first);
    assert_int_equal(first.rank.known_frames, 0);
    config.known = (struct ttf_quilt_factors){kept.bytes, kept.size};
    config.keep_factors = NULL;
    quilt_plan_ok(&config, shorter, NULL, &again); /* nothing is new */
    assert_int_equal(again.rank.known_frames, 25);
    assert_true(fabs(again.rank.error - first.rank.error) < 1e-4);
    late.base.ops = &ops; /* what is known is not read again, but for its last frame */
    quilt_plan_ok(&config, &late.base, NULL, &grown);
    assert_int_equal(grown.rank.known_frames, 25);
    quilt_blocks_are_what_is_shown(&grown);
    config.rank += 8;
    quilt_refused(&config, long_one.sequence, -EINVAL, "factors");
    ttf_quilt_map_free(&first);
    ttf_quilt_map_free(&again);
    ttf_quilt_map_free(&grown);
    free(kept.bytes);
    ttf_sequence_destroy(shorter);
    texture_free(&long_one);
}

static int cannot_keep(void *ctx, const struct ttf_quilt_factors *factors)
{
    (void)ctx;
    (void)factors;
    return -EROFS;
}

static void impossible_settings_are_refused_by_name(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 40, 36, 3);
    struct ttf_quilt_config good = small_config(), bad;

    (void)state;
#define REFUSED(field, value, code, where)                \
    do {                                                  \
        bad = good;                                       \
        bad.field = (value);                              \
        quilt_refused(&bad, input.sequence, code, where); \
    } while (0)
    REFUSED(rank, TTF_QUILT_RANK_MAX + 1, -EINVAL, "rank");
    REFUSED(rank_error, (double)NAN, -EINVAL, "rank_error");
    REFUSED(rank_error, (double)INFINITY, -EINVAL, "rank_error");
    REFUSED(rank_error, -0.01, -EINVAL, "rank_error");
    REFUSED(rank_error, 1.5, -EINVAL, "rank_error");
    REFUSED(tolerance, (double)NAN, -EINVAL, "tolerance");
    REFUSED(tolerance, (double)INFINITY, -EINVAL, "tolerance");
    REFUSED(block_width, 41, -EINVAL, "block");
    REFUSED(block_height, 37, -EINVAL, "block");
    REFUSED(memory_bytes, 1000, -EFBIG, "");
    REFUSED(keep_factors, cannot_keep, -EROFS, "factors");
    good.rank = TTF_QUILT_RANK_FULL;
    REFUSED(flips, true, -EINVAL, "rank");
    REFUSED(rotations, true, -EINVAL, "rank");
    REFUSED(tileable, true, -EINVAL, "rank");
    REFUSED(avoid_px, 1, -EINVAL, "rank");
#undef REFUSED
    texture_free(&input);
}

static void one_frame_and_one_colour_have_defined_plans(void **state)
{
    struct ttf_quilt_config config = small_config();

    (void)state;
    matches_reference(TEXTURE_SPOTS, 40, 36, 1, &config, 2);
    matches_reference(TEXTURE_CONSTANT, 40, 36, 1, &config, 2);
    config.rank_error = 1e-9;
    matches_reference(TEXTURE_CONSTANT, 40, 36, 5, &config, 2);
    config.rank_error = 1.0;
    matches_reference(TEXTURE_SPOTS, 40, 36, 5, &config, 2);
    config.tolerance = 0.0;
    matches_reference(TEXTURE_SPOTS, 40, 36, 2, &config, 2);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_map_is_that_of_the_plainest_implementation),
        cmocka_unit_test(any_rank_and_kind_of_factorisation_matches_as_well),
        cmocka_unit_test(noise_decides_which_repeats_are_alike),
        cmocka_unit_test(elongated_blocks_and_wide_overlaps_work_as_well),
        cmocka_unit_test(any_output_size_is_covered_to_its_last_pixel),
        cmocka_unit_test(everything_asked_for_at_once_is_the_same_for_any_threads),
        cmocka_unit_test(a_copied_map_is_equal_and_lives_alone),
        cmocka_unit_test(known_factors_are_gone_on_with),
        cmocka_unit_test(impossible_settings_are_refused_by_name),
        cmocka_unit_test(one_frame_and_one_colour_have_defined_plans),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
