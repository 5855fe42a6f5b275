/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "reference.h"
#include "search/kernels.h"
#include "textures.h"

#define W 37u
#define H 33u

/* One overlap whose known pixels come from the input itself, from two places, so that it has seams in it. */
struct query {
    struct ttf_overlap overlap;
    uint32_t known[W * H];
};

static void query_make(struct query *query, uint32_t key, uint32_t width, uint32_t height,
                       uint32_t left, uint32_t top)
{
    uint32_t ax = texture_hash(key, 1, 0) % (W - width + 1);
    uint32_t ay = texture_hash(key, 2, 0) % (H - height + 1);
    uint32_t bx = texture_hash(key, 3, 0) % (W - width + 1);
    uint32_t by = texture_hash(key, 4, 0) % (H - height + 1);

    query->overlap = (struct ttf_overlap){width, height, left, top, query->known, width};
    for (uint32_t i = 0; i < width * height; i++) {
        uint32_t x = i % width, y = i / width;

        query->known[i] = y < top ? (ay + y) * W + ax + x : (by + y) * W + bx + x;
    }
}

static void compare(struct ttf_search *search, const struct ttf_trajectories *trajectories,
                    const struct query *query, double tolerance, double noise)
{
    static uint32_t positions[W * H];
    static uint64_t errors[W * H];
    struct ttf_candidates candidates;
    uint64_t best;
    struct reference reference = reference_of_trajectories(trajectories, noise);
    uint32_t n =
        reference_candidates(&reference, &query->overlap, tolerance, positions, errors, &best);

    assert_int_equal(ttf_search_run(search, &query->overlap, &candidates), 0);
    assert_int_equal(candidates.best, best);
    assert_int_equal(candidates.n, n);
    assert_int_equal(candidates.columns, W - query->overlap.width + 1);
    for (uint32_t i = 0; i < n; i++) {
        assert_int_equal(candidates.positions[i], positions[i]);
        assert_int_equal(candidates.errors[i], errors[i]);
    }
}

static void search_texture(enum texture texture, uint32_t frames, double tolerance, double noise,
                           const struct ttf_kernels *kernels)
{
    struct texture_sequence made = texture_make(texture, W, H, frames);
    struct ttf_trajectories trajectories;
    static struct query query;

    assert_int_equal(ttf_trajectories_load(made.sequence, 0, frames, TTF_METRIC_DISPLAY, NULL, NULL,
                                           &trajectories, NULL),
                     0);
    for (uint32_t overlap = 1; overlap <= 5; overlap += 2) {
        struct ttf_search *search;

        assert_int_equal(
            ttf_search_create(&trajectories, overlap, tolerance, noise, kernels, NULL, &search), 0);
        for (uint32_t key = 0; key < 2; key++) {
            query_make(&query, key, 16, 12, overlap, 0);
            compare(search, &trajectories, &query, tolerance, noise);
            query_make(&query, key + 10, 12, 17, 0, overlap);
            compare(search, &trajectories, &query, tolerance, noise);
            query_make(&query, key + 20, 16, 16, overlap, overlap + 1);
            compare(search, &trajectories, &query, tolerance, noise);
        }
        query_make(&query, 30, W, H, overlap, overlap);
        compare(search, &trajectories, &query, tolerance, noise);
        ttf_search_destroy(search);
    }
    ttf_trajectories_free(&trajectories);
    texture_free(&made);
}

static void the_search_finds_what_a_plain_search_finds(void **state)
{
    (void)state;
    search_texture(TEXTURE_SPOTS, 40, 0.1, 1.0, NULL); /* both bounds */
    search_texture(TEXTURE_SPOTS, 7, 0.1, 1.0, NULL);  /* cells only */
    search_texture(TEXTURE_SPOTS, 1, 0.1, 0.1, NULL);  /* one frame: the codes are the basis */
    search_texture(TEXTURE_SPOTS, 40, 0.0, 0.0, NULL); /* the very best only */
    search_texture(TEXTURE_SPOTS, 33, 2.0, 5.0, NULL); /* many candidates */
}

static void noise_that_no_bound_excludes_is_searched_as_exactly(void **state)
{
    (void)state;
    search_texture(TEXTURE_NOISE, 34, 0.1, 1.0, NULL);
    search_texture(TEXTURE_NOISE, 2, 0.1, 1.0, NULL);
}

static void exact_matches_and_constants_are_all_found(void **state)
{
    (void)state;
    search_texture(TEXTURE_STRIPES, 34, 0.1, 0.0, NULL);
    search_texture(TEXTURE_STRIPES, 3, 0.1, 0.0, NULL);
    search_texture(TEXTURE_CONSTANT, 34, 0.1, 0.0, NULL);
    search_texture(TEXTURE_CONSTANT, 1, 0.1, 0.1, NULL);
}

static void an_object_on_a_plain_ground_is_searched_as_exactly(void **state)
{
    (void)state;
    search_texture(TEXTURE_OBJECT, 34, 0.1, 1.0, NULL);
    search_texture(TEXTURE_OBJECT, 5, 0.1, 1.0 / 12.0, NULL);
    search_texture(TEXTURE_OBJECT, 5, 10.0, 20.0, NULL); /* the object too is within tolerance */
}

static void the_scalar_kernels_lead_to_the_same_candidates(void **state)
{
    (void)state;
    search_texture(TEXTURE_SPOTS, 40, 0.1, 1.0, ttf_kernels_scalar());
}

static void bounds_exclude_most_of_a_texture(void **state)
{
    struct texture_sequence made = texture_make(TEXTURE_SPOTS, W, H, 40);
    struct ttf_trajectories trajectories;
    struct ttf_search_counts counts;
    struct ttf_candidates candidates;
    struct ttf_search *search;
    static struct query query;

    (void)state;
    assert_int_equal(ttf_trajectories_load(made.sequence, 0, 40, TTF_METRIC_DISPLAY, NULL, NULL,
                                           &trajectories, NULL),
                     0);
    assert_int_equal(ttf_search_create(&trajectories, 4, 0.1, 0.1, NULL, NULL, &search), 0);
    query_make(&query, 3, 16, 16, 4, 0);
    assert_int_equal(ttf_search_run(search, &query.overlap, &candidates), 0);
    ttf_search_counts(search, &counts);
    assert_int_equal(counts.positions, (W - 15) * (H - 15));
    assert_true(counts.exact < counts.positions / 4);
    ttf_search_destroy(search);
    ttf_trajectories_free(&trajectories);
    texture_free(&made);
}

/* Every kernel against the reference, on all-equal, all-extreme and random bytes. */
static void fast_kernels_agree_with_the_reference(void **state)
{
    const struct ttf_kernels *all[] = {ttf_kernels_best(), ttf_kernels_scalar()};
    const struct ttf_kernels *scalar = ttf_kernels_scalar();
    enum {
        N = 70000
    };
    uint8_t *a = malloc(N), *b = malloc(N);

    (void)state;
    assert_true(a && b);
    for (int fill = 0; fill < 3; fill++) {
        for (uint32_t i = 0; i < N; i++) {
            a[i] = fill == 0 ? 255 : (uint8_t)texture_hash(i, 1, 0);
            b[i] = fill == 0 ? 0 : fill == 1 ? a[i] : (uint8_t)texture_hash(i, 2, 0);
        }
        for (size_t n = 0; n < N; n = n < 70 ? n + 1 : n * 3 + 1) {
            for (size_t k = 0; k < 2; k++)
                assert_int_equal(all[k]->ssd_u8(a + 1, b + n % 7, n), /* any alignment */
                                 scalar->ssd_u8(a + 1, b + n % 7, n));
        }
        assert_int_equal(ttf_kernels_best()->ssd_u8(a, b, N), scalar->ssd_u8(a, b, N));
    }
    free(a);
    free(b);
}

static void fast_float_kernels_agree_within_rounding(void **state)
{
    const struct ttf_kernels *best = ttf_kernels_best(), *scalar = ttf_kernels_scalar();
    static float a[64 * TTF_PIXEL_COEFS], b[64 * TTF_PIXEL_COEFS], x[100], y[100];
    const float *planes[TTF_CELL_PLANES];
    float target[TTF_CELL_PLANES];

    (void)state;
    for (uint32_t i = 0; i < 64 * TTF_PIXEL_COEFS; i++) {
        a[i] = (float)(texture_hash(i, 5, 0) % 10000) - 5000.0f;
        b[i] = (float)(texture_hash(i, 6, 0) % 10000) - 5000.0f;
    }
    for (size_t n = 0; n <= 64 * TTF_PIXEL_COEFS; n += TTF_PIXEL_COEFS) {
        double want = (double)scalar->ssd_f32(a, b, n);

        assert_true(fabs((double)best->ssd_f32(a, b, n) - want) <= 1e-5 * want);
    }
    for (int d = 0; d < TTF_CELL_PLANES; d++) {
        planes[d] = a + 97 * d;
        target[d] = b[d];
    }
    for (size_t n = 0; n < 100; n += 7) {
        for (int i = 0; i < 100; i++)
            x[i] = y[i] = (float)i;
        best->add_cells(x, planes, target, n);
        scalar->add_cells(y, planes, target, n);
        for (int i = 0; i < 100; i++)
            assert_true(fabsf(x[i] - y[i]) <= 1e-5f * y[i]);
    }
}

static void trajectories_hold_every_frame_and_channel_of_a_pixel_together(void **state)
{
    struct texture_sequence made = texture_make(TEXTURE_NOISE, W, H, 50);
    struct ttf_pool *pool = ttf_pool_create(3);
    struct ttf_trajectories display, linear;

    (void)state;
    assert_int_equal(
        ttf_trajectories_load(made.sequence, 3, 44, TTF_METRIC_DISPLAY, pool, NULL, &display, NULL),
        0);
    assert_int_equal(
        ttf_trajectories_load(made.sequence, 3, 44, TTF_METRIC_LINEAR, pool, NULL, &linear, NULL),
        0);
    assert_int_equal(display.dims, 3 * 44);
    for (size_t p = 0; p < (size_t)W * H; p++) {
        for (size_t i = 0; i < display.dims; i++) {
            uint16_t code = made.codes[((3 + i / 3) * W * H + p) * 3 + i % 3];

            assert_int_equal(ttf_trajectory(&display, p)[i], ttf_linear16_to_srgb8(code));
            assert_int_equal(ttf_trajectory(&linear, p)[i], (int)(code / 257.0 + 0.5));
        }
    }
    ttf_trajectories_free(&display);
    ttf_trajectories_free(&linear);
    ttf_pool_destroy(pool);
    texture_free(&made);
}

static void noise_is_estimated_from_time_and_never_below_rounding(void **state)
{
    struct texture_sequence made = texture_make(TEXTURE_CONSTANT, W, H, 12);
    struct ttf_trajectories trajectories;
    double noise;

    (void)state;
    assert_int_equal(ttf_trajectories_load(made.sequence, 0, 12, TTF_METRIC_DISPLAY, NULL, NULL,
                                           &trajectories, NULL),
                     0);
    assert_true(ttf_trajectories_noise(&trajectories) == 1.0 / 12.0);
    ttf_trajectories_free(&trajectories);
    texture_free(&made);

    /* the spots' own noise is uniform on -2..2: variance 2 */
    made = texture_make(TEXTURE_SPOTS, W, H, 60);
    assert_int_equal(ttf_trajectories_load(made.sequence, 0, 60, TTF_METRIC_DISPLAY, NULL, NULL,
                                           &trajectories, NULL),
                     0);
    noise = ttf_trajectories_noise(&trajectories);
    assert_true(noise > 1.7 && noise < 2.4);
    ttf_trajectories_free(&trajectories);
    texture_free(&made);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_search_finds_what_a_plain_search_finds),
        cmocka_unit_test(noise_that_no_bound_excludes_is_searched_as_exactly),
        cmocka_unit_test(exact_matches_and_constants_are_all_found),
        cmocka_unit_test(an_object_on_a_plain_ground_is_searched_as_exactly),
        cmocka_unit_test(the_scalar_kernels_lead_to_the_same_candidates),
        cmocka_unit_test(bounds_exclude_most_of_a_texture),
        cmocka_unit_test(fast_kernels_agree_with_the_reference),
        cmocka_unit_test(fast_float_kernels_agree_within_rounding),
        cmocka_unit_test(trajectories_hold_every_frame_and_channel_of_a_pixel_together),
        cmocka_unit_test(noise_is_estimated_from_time_and_never_below_rounding),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
