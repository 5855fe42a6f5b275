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

#include "search/eigen.h"
#include "search/factor_kernels.h"
#include "search/factors.h"
#include "search/learner.h"
#include "search/matching.h"
#include "search/trajectories.h"
#include "textures.h"

#define W 24
#define H 20
#define N 40

static const uint8_t *table_of_display(void)
{
    static uint8_t table[65536];

    ttf_metric_table(TTF_METRIC_DISPLAY, &texture_encoding, table);
    return table;
}

static struct ttf_sources sources_of(struct texture_sequence *texture)
{
    const struct ttf_quilt_config config = {0};
    struct ttf_sources sources;

    assert_int_equal(ttf_sources_of(&config, texture->sequence, &sources, NULL), 0);
    return sources;
}

/* The singular values of T, from T^T T whole, by rotations alone. */
static void plain_singular(struct texture_sequence *texture, uint32_t n, double *ret)
{
    struct ttf_trajectories t;
    size_t dims;
    double *gram, *v;

    assert_int_equal(
        ttf_trajectories_load(texture->sequence, 0, n, TTF_METRIC_DISPLAY, NULL, NULL, &t, NULL),
        0);
    dims = t.dims;
    gram = calloc(dims * dims, sizeof(*gram));
    v = calloc(dims * dims, sizeof(*v));
    assert_true(gram && v);
    for (size_t p = 0; p < W * H; p++) {
        for (size_t i = 0; i < dims; i++) {
            for (size_t j = 0; j < dims; j++)
                gram[i * dims + j] += (double)ttf_trajectory(&t, p)[i] * ttf_trajectory(&t, p)[j];
        }
    }
    ttf_eigen_all(gram, dims, v, ret);
    for (size_t i = 0; i < dims; i++)
        ret[i] = sqrt(ret[i] > 0.0 ? ret[i] : 0.0);
    free(gram);
    free(v);
    ttf_trajectories_free(&t);
}

static double plain_error(const double *singular, size_t n, unsigned k)
{
    double all = 0.0, missed = 0.0;

    for (size_t i = 0; i < n; i++) {
        all += singular[i] * singular[i];
        missed += i >= k ? singular[i] * singular[i] : 0.0;
    }
    return sqrt(missed / all);
}

static void learn(struct texture_sequence *texture, uint32_t n, unsigned room, bool per_channel,
                  struct ttf_pool *pool, struct ttf_learner *ret)
{
    struct ttf_sources sources = sources_of(texture);

    assert_int_equal(ttf_learner_create(W * H, room, per_channel, ret), 0);
    assert_int_equal(
        ttf_learner_add(ret, &sources, 0, n, table_of_display(), NULL, NULL, pool, NULL), 0);
}

/* ---- kernels ---- */

static void same_rows(const struct ttf_factor_kernels *kernels)
{
    enum {
        FRAMES = 16,
        PIXELS = 13,
        ROOM = 24,
        STRIDE = ROOM + 3 * FRAMES + 1
    };
    static uint8_t codes[FRAMES][3 * PIXELS];
    static float coefs[PIXELS * ROOM], want[4 * STRIDE], got[4 * STRIDE];
    const uint8_t *frames[FRAMES];
    uint32_t weighs[4], weighed[4];

    for (uint32_t t = 0; t < FRAMES; t++) {
        frames[t] = codes[t];
        for (uint32_t i = 0; i < 3 * PIXELS; i++)
            codes[t][i] = (uint8_t)(i % 3 == 1 ? 255 : texture_hash(t, i, 9));
    }
    for (uint32_t i = 0; i < PIXELS * ROOM; i++)
        coefs[i] = (float)texture_hash(i, 2, 2) / 77.0f;
    for (unsigned n = 0; n <= FRAMES; n++) {
        for (size_t room = 8; room <= ROOM; room += 8) {
            for (size_t pixel = 0; pixel + 4 <= PIXELS; pixel += 3) {
                ttf_factor_kernels_scalar()->rows4(coefs + pixel * room, room, frames, n, pixel,
                                                   want, STRIDE, weighs);
                kernels->rows4(coefs + pixel * room, room, frames, n, pixel, got, STRIDE, weighed);
                for (size_t p = 0; p < 4; p++) {
                    assert_memory_equal(got + p * STRIDE, want + p * STRIDE,
                                        (room + 3 * n) * sizeof(*got));
                    assert_int_equal(weighed[p], weighs[p]);
                }
            }
        }
    }
}

static void same_gram(const struct ttf_factor_kernels *kernels)
{
    enum {
        DIMS = 37
    };
    double rows[4 * (DIMS + 2)], want[DIMS * DIMS], got[DIMS * DIMS];

    for (uint32_t i = 0; i < 4 * (DIMS + 2); i++)
        rows[i] =
            (double)texture_hash(i, 4, 4) / 3.0e5 - 7000.0; /* sums that depend on their order */
    for (size_t dims = 1; dims <= DIMS; dims++) {
        for (size_t i = 0; i < dims * dims; i++)
            want[i] = got[i] = (double)texture_hash((uint32_t)i, 5, 5) / 7.0;
        ttf_factor_kernels_scalar()->add_gram4(rows, DIMS + 2, dims, want);
        kernels->add_gram4(rows, DIMS + 2, dims, got);
        assert_memory_equal(got, want,
                            dims * dims * sizeof(*got)); /* what lies above is left alone, too */
    }
}

static void all_kernels_come_to_what_the_scalar_ones_do(void **state)
{
    (void)state;
    same_rows(ttf_factor_kernels_best());
    same_gram(ttf_factor_kernels_best());
    if (ttf_factor_kernels_avx2()) {
        same_rows(ttf_factor_kernels_avx2());
        same_gram(ttf_factor_kernels_avx2());
    }
}

/* The scalar rows are what they are to be: coefficients, then codes, and what the codes weigh. */
static void a_row_is_coefficients_and_codes(void **state)
{
    const uint8_t codes[2][12] = {{1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 255}, {0, 0, 1}};
    const uint8_t *const frames[] = {codes[0], codes[1]};
    float coefs[32], out[4 * 16];
    uint32_t energy[4];

    (void)state;
    for (int i = 0; i < 32; i++)
        coefs[i] = (float)i;
    ttf_factor_kernels_scalar()->rows4(coefs, 8, frames, 2, 0, out, 16, energy);
    assert_true(out[7] == 7.0f && out[8] == 1.0f && out[10] == 3.0f && out[13] == 1.0f);
    assert_true(out[48] == 24.0f && out[48 + 10] == 255.0f && out[48 + 11] == 0.0f);
    assert_int_equal(energy[0], 1 + 4 + 9 + 1);
    assert_int_equal(energy[3], 100 + 121 + 65025);
}

static void streamed_factors_are_nearly_as_good_as_the_whole_decomposition(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_SPOTS, W, H, N);
    double singular[3 * N];
    struct ttf_learner learner;

    (void)state;
    plain_singular(&texture, N, singular);
    learn(&texture, N, 24, false, NULL, &learner);
    for (unsigned k = 1; k <= 16; k++) {
        double own = ttf_factors_error(&learner.factors[0], k);
        double best = plain_error(singular, 3 * N, k);

        /* no factorisation can be better, single precision aside */
        assert_true(own * own >= best * best - 1e-6);
        assert_true(own <= best * 1.03 + 1e-4);
    }
    for (unsigned k = 0; k < 8; k++)
        assert_true(fabs(learner.factors[0].singular[k] - singular[k]) <= 0.02 * singular[k]);
    ttf_learner_free(&learner);
    texture_free(&texture);
}

static void distances_between_factors_never_exceed_those_between_trajectories(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_trajectories t;
    struct ttf_learner learner;
    double near = 0.0, full_sum = 0.0;

    (void)state;
    learn(&texture, N, 24, false, NULL, &learner);
    assert_int_equal(
        ttf_trajectories_load(texture.sequence, 0, N, TTF_METRIC_DISPLAY, NULL, NULL, &t, NULL), 0);
    for (uint32_t i = 0; i < 2000; i++) {
        size_t p = texture_hash(i, 1, 0) % (W * H), q = texture_hash(i, 2, 0) % (W * H);
        double full = 0.0, own = 0.0;

        for (size_t d = 0; d < t.dims; d++) {
            double x = (double)ttf_trajectory(&t, p)[d] - ttf_trajectory(&t, q)[d];

            full += x * x;
        }
        for (unsigned k = 0; k < 24; k++) {
            double x = (double)learner.factors[0].coefs[p * 24 + k] -
                       (double)learner.factors[0].coefs[q * 24 + k];

            own += x * x;
        }
        assert_true(own <= full * (1.0 + 1e-4) + 1e-3);
        near += own;
        full_sum += full;
    }
    assert_true(near > 0.97 * full_sum); /* and they are most of them */
    ttf_trajectories_free(&t);
    ttf_learner_free(&learner);
    texture_free(&texture);
}

static void few_frames_are_represented_exactly(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_NOISE, W, H, 4);
    struct ttf_learner learner;

    (void)state;
    learn(&texture, 4, 24, false, NULL, &learner);
    assert_true(ttf_factors_error(&learner.factors[0], 12) < 2e-3);
    ttf_learner_free(&learner);
    texture_free(&texture);
}

struct before {
    const struct ttf_kept *kept;
    int64_t now_ns;
};

/* Asked for the time before and after each large page is asked for: nothing was read into what lies behind it. */
static int64_t next_ns(void *ctx)
{
    struct before *before = ctx;
    const struct ttf_kept *kept = before->kept;

    for (size_t i = kept->touched; i < kept->touched + 4096 && i < kept->frames * kept->frame; i++)
        assert_int_equal(kept->codes[i], 0);
    return ++before->now_ns;
}

static void frames_are_kept_in_memory_that_was_asked_for_before(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_SPOTS, 256, 192, N);
    struct ttf_sources sources = sources_of(&texture);
    struct ttf_pool *pool = ttf_pool_create(2);
    uint16_t *scratch = malloc(TTF_SOURCES_PIECE * sizeof(*scratch));
    struct ttf_learner learner;
    struct ttf_kept kept;
    struct before before = {.kept = &kept};
    struct ttf_aside aside = {.kept = &kept, .now_ns = next_ns, .now_ctx = &before};
    uint8_t *codes;

    (void)state;
    assert_int_equal(ttf_kept_create(sources.pixels, N, SIZE_MAX, &kept), 0);
    codes = malloc(kept.frame);
    assert_true(pool && scratch && codes && kept.frames == N);
    assert_int_equal(ttf_learner_create(sources.pixels, 24, false, &learner), 0);
    assert_int_equal(
        ttf_learner_add(&learner, &sources, 0, N, table_of_display(), &aside, NULL, pool, NULL), 0);
    assert_true(kept.touched >= N * kept.frame);
    for (uint32_t t = 0; t < N; t++) {
        assert_int_equal(
            ttf_sources_read_codes(&sources, t, table_of_display(), scratch, codes, NULL), 0);
        assert_memory_equal(kept.codes + t * kept.frame, codes, kept.frame);
    }
    ttf_kept_free(&kept);
    ttf_learner_free(&learner);
    ttf_pool_destroy(pool);
    free(codes);
    free(scratch);
    texture_free(&texture);
}

static void a_grown_dataset_is_gone_on_with(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_sources sources = sources_of(&texture);
    struct ttf_learner half, whole, grown;
    struct ttf_quilt_factors packed;

    (void)state;
    learn(&texture, N, 24, false, NULL, &whole);
    learn(&texture, N / 2, 24, false, NULL, &half);
    assert_int_equal(ttf_learner_pack(&half, TTF_METRIC_DISPLAY, &packed), 0);
    ttf_learner_free(&half);
    assert_int_equal(ttf_learner_unpack(&packed, &sources, 24, false, TTF_METRIC_DISPLAY,
                                        table_of_display(), &grown, NULL),
                     0);
    assert_int_equal(grown.known, N / 2);
    assert_int_equal(ttf_learner_add(&grown, &sources, grown.known, N, table_of_display(), NULL,
                                     NULL, NULL, NULL),
                     0);
    assert_int_equal(grown.factors[0].frames, N);
    assert_true(ttf_factors_energy(&grown.factors[0]) == ttf_factors_energy(&whole.factors[0]));
    assert_memory_equal(grown.noise.counts, whole.noise.counts, sizeof(whole.noise.counts));
    for (unsigned k = 1; k <= 15; k++)
        assert_true(ttf_factors_error(&grown.factors[0], k) <=
                    1.02 * ttf_factors_error(&whole.factors[0], k));
    free((void *)packed.bytes);
    ttf_learner_free(&whole);
    ttf_learner_free(&grown);
    texture_free(&texture);
}

static void refused(const struct ttf_quilt_factors *packed, struct texture_sequence *texture,
                    unsigned room, enum ttf_metric metric)
{
    struct ttf_sources sources = sources_of(texture);
    struct ttf_learner learner;
    struct ttf_err err = {0};

    assert_int_equal(ttf_learner_unpack(packed, &sources, room, false, metric, table_of_display(),
                                        &learner, &err),
                     -EINVAL);
    assert_string_equal(err.where, "factors");
}

static void foreign_or_damaged_factors_are_refused(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_SPOTS, W, H, N);
    struct texture_sequence other = texture_make(TEXTURE_NOISE, W, H, N);
    struct texture_sequence small = texture_make(TEXTURE_SPOTS, W, H - 1, N);
    struct texture_sequence shorter = texture_make(TEXTURE_SPOTS, W, H, N - 1);
    struct ttf_quilt_factors packed, cut;
    struct ttf_learner learner;

    (void)state;
    learn(&texture, N, 24, false, NULL, &learner);
    assert_int_equal(ttf_learner_pack(&learner, TTF_METRIC_DISPLAY, &packed), 0);
    refused(&packed, &other, 24, TTF_METRIC_DISPLAY);
    refused(&packed, &small, 24, TTF_METRIC_DISPLAY);
    refused(&packed, &shorter, 24, TTF_METRIC_DISPLAY);
    refused(&packed, &texture, 32, TTF_METRIC_DISPLAY);
    refused(&packed, &texture, 24, TTF_METRIC_LINEAR);
    for (size_t size = 0; size < packed.size; size += 1 + size / 3) {
        cut = (struct ttf_quilt_factors){packed.bytes, size};
        refused(&cut, &texture, 24, TTF_METRIC_DISPLAY);
    }
    free((void *)packed.bytes);
    ttf_learner_free(&learner);
    texture_free(&texture);
    texture_free(&other);
    texture_free(&small);
    texture_free(&shorter);
}

static void build(const struct ttf_quilt_config *config, struct texture_sequence *texture,
                  struct ttf_pool *pool, struct ttf_matching *ret)
{
    struct ttf_sources sources = sources_of(texture);

    assert_int_equal(
        ttf_matching_build(config, &sources, 0, texture->sequence->n, NULL, pool, ret, NULL), 0);
}

static void threads_change_no_bit_of_the_numbers(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_SPOTS, 80, 70, N);
    struct ttf_pool *pool = ttf_pool_create(3);
    struct ttf_quilt_config config;
    struct ttf_matching one, three;

    (void)state;
    ttf_quilt_defaults(&config);
    for (int per_channel = 0; per_channel < 2; per_channel++) {
        config.per_channel = per_channel;
        build(&config, &texture, NULL, &one);
        build(&config, &texture, pool, &three);
        assert_int_equal(one.k, per_channel ? 45 : 15);
        assert_int_equal(one.stride, per_channel ? 48 : 16);
        assert_memory_equal(one.coefs, three.coefs, one.pixels * one.stride * sizeof(*one.coefs));
        assert_true(one.scale == three.scale && one.noise == three.noise);
        ttf_matching_free(&one);
        ttf_matching_free(&three);
    }
    ttf_pool_destroy(pool);
    texture_free(&texture);
}

static void the_rank_is_the_smallest_whose_error_is_small_enough(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config;
    struct ttf_matching m;

    (void)state;
    ttf_quilt_defaults(&config);
    for (int i = 1; i < 20; i += 6) {
        config.rank_error = i / 200.0;
        build(&config, &texture, NULL, &m);
        assert_true(m.figures.error <= config.rank_error || m.figures.rank == TTF_QUILT_RANK_MAX);
        assert_true(m.figures.rank == 1 ||
                    m.figures.errors[m.figures.rank - 1] > config.rank_error);
        assert_true(m.figures.errors[m.figures.rank] == m.figures.error);
        ttf_matching_free(&m);
    }
    texture_free(&texture);
}

static void a_constant_input_is_all_zeros(void **state)
{
    struct texture_sequence texture = texture_make(TEXTURE_CONSTANT, W, H, 9);
    struct ttf_quilt_config config;
    struct ttf_matching m;

    (void)state;
    ttf_quilt_defaults(&config);
    build(&config, &texture, NULL, &m);
    assert_true(m.figures.error < 1e-3);
    for (size_t i = 1; i < m.pixels; i++) /* rounding aside, all pixels are alike */
        assert_memory_equal(m.coefs, m.coefs + i * m.stride, m.stride * sizeof(*m.coefs));
    ttf_matching_free(&m);
    texture_free(&texture);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_kernels_come_to_what_the_scalar_ones_do),
        cmocka_unit_test(a_row_is_coefficients_and_codes),
        cmocka_unit_test(streamed_factors_are_nearly_as_good_as_the_whole_decomposition),
        cmocka_unit_test(distances_between_factors_never_exceed_those_between_trajectories),
        cmocka_unit_test(few_frames_are_represented_exactly),
        cmocka_unit_test(frames_are_kept_in_memory_that_was_asked_for_before),
        cmocka_unit_test(a_grown_dataset_is_gone_on_with),
        cmocka_unit_test(foreign_or_damaged_factors_are_refused),
        cmocka_unit_test(threads_change_no_bit_of_the_numbers),
        cmocka_unit_test(the_rank_is_the_smallest_whose_error_is_small_enough),
        cmocka_unit_test(a_constant_input_is_all_zeros),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
