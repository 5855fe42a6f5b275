/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "reference.h"
#include "search/rank_search.h"
#include "textures.h"

#define W 40
#define H 34
#define N 20

/* ---- kernels ---- */

static int16_t value(uint32_t key, int most)
{
    uint32_t random = texture_hash(key, 17, 3);

    /* the extremes often, so that overflow would show */
    if (random % 3 == 0)
        return (int16_t)(random % 2 ? most : -most);
    return (int16_t)((int)(random % (2u * (unsigned)most + 1)) - most);
}

/* Sums of several places, of which the limit leaves all, some or none. */
static void within_limit_the_same(const uint64_t *want, const uint64_t *got, int n, uint64_t limit)
{
    for (int i = 0; i < n; i++)
        assert_true(want[i] <= limit ? got[i] == want[i] : got[i] > limit);
}

static void same_at_four_as_scalar(const struct ttf_rank_kernels *kernels, const int16_t *a,
                                   const int16_t *b)
{
    const int16_t *at[4] = {a, a + 16, a + 48, a + 16};
    uint32_t offsets[256];
    uint64_t want[4], got[4];

    for (uint32_t i = 0; i < 256; i++)
        offsets[i] = texture_hash(i, 5, 1) % 250;
    for (size_t n = 1; n <= 256; n += n < 40 ? 1 : 37) {
        ttf_rank_kernels_scalar()->ssd_at4(at, offsets, b, n, UINT64_MAX, want);
        for (int k = -1; k < 4; k++) {
            uint64_t limit = k < 0 ? UINT64_MAX : want[k] - (k == 3);

            kernels->ssd_at4(at, offsets, b, n, limit, got);
            within_limit_the_same(want, got, 4, limit);
        }
    }
}

/* Each place of a pair by itself, as the pairs are. */
static void same_at_pairs_as_scalar(const struct ttf_rank_kernels *kernels, const int16_t *a,
                                    const int16_t *b, size_t most)
{
    const int16_t *at[4] = {a, a + 16, a + 64, a + 48};
    uint32_t offsets[TTF_CELLS_MAX];
    uint64_t want[8], got[8];

    for (uint32_t i = 0; i < TTF_CELLS_MAX; i++)
        offsets[i] = texture_hash(i, 5, 1) % 250;
    for (size_t n = 1; n <= most; n += n < 80 ? 1 : 37) {
        for (int k = 0; k < 8; k++) {
            want[k] = 0;
            for (size_t i = 0; i < n; i++)
                want[k] += ttf_rank_kernels_scalar()->ssd_i16(
                    at[k / 2] + 16 * (k % 2) + (size_t)offsets[i] * 16, b + i * 16, 16);
        }
        for (int k = -1; k < 8; k++) {
            uint64_t limit = k < 0 ? UINT64_MAX : want[k] - (k % 3 == 2);

            kernels->ssd_at_pairs(at, offsets, b, n, limit, got);
            within_limit_the_same(want, got, 8, limit);
        }
    }
}

/* Rows of cells, of any length, and vectors that lie anywhere. */
static void same_in_a_row_as_scalar(const struct ttf_rank_kernels *kernels, const int16_t *a,
                                    const int16_t *b, size_t most)
{
    uint32_t offsets[TTF_CELLS_MAX];
    uint64_t want[TTF_ROW_PLACES], got[TTF_ROW_PLACES];

    for (uint32_t i = 0; i < TTF_CELLS_MAX; i++)
        offsets[i] = i > 0 && offsets[i - 1] < 220 && texture_hash(i, 6, 1) % 12 != 0
                         ? offsets[i - 1] + 2
                         : texture_hash(i, 5, 1) % 220;
    for (size_t n = 1; n <= most; n += n < 80 ? 1 : 37) {
        for (size_t k = 0; k < TTF_ROW_PLACES; k++) {
            want[k] = 0;
            for (size_t i = 0; i < n; i++)
                want[k] +=
                    ttf_rank_kernels_scalar()->ssd_i16(a + 16 * (offsets[i] + k), b + i * 16, 16);
        }
        for (int k = -1; k < TTF_ROW_PLACES; k++) {
            uint64_t limit = k < 0 ? UINT64_MAX : want[k] - (k % 3 == 2);

            kernels->ssd_at_row(a, offsets, b, n, limit, got);
            within_limit_the_same(want, got, TTF_ROW_PLACES, limit);
        }
    }
}

/* As far apart as numbers can be, in every lane, as many at once as there can be. */
static void no_lane_overflows(const struct ttf_rank_kernels *kernels)
{
    static int16_t a[16 * 600], b[16 * 256];
    const int16_t *const at[4] = {a, a + 16, a + 32, a + 48};
    uint32_t offsets[256];
    uint64_t got[8];

    for (size_t i = 0; i < 16 * 600; i++)
        a[i] = TTF_COEF_MAX;
    for (uint32_t i = 0; i < 256; i++) {
        offsets[i] = i;
        for (size_t k = 0; k < 16; k++)
            b[16 * i + k] = -TTF_COEF_MAX;
    }
    for (size_t n = 1; n <= 256; n += n < 70 ? 1 : 31) {
        uint64_t want = 16 * n * (2 * TTF_COEF_MAX) * (2 * TTF_COEF_MAX);

        kernels->ssd_at4(at, offsets, b, n, UINT64_MAX, got);
        for (int i = 0; i < 4; i++)
            assert_true(got[i] == want);
        kernels->ssd_at_pairs(at, offsets, b, n, UINT64_MAX, got);
        for (int i = 0; i < 8; i++)
            assert_true(got[i] == want);
        assert_true(kernels->ssd_i16(a, b, 16 * n) == want);
    }
}

static void no_lane_of_a_row_overflows(const struct ttf_rank_kernels *kernels)
{
    static int16_t a[16 * (2 * TTF_CELLS_MAX + TTF_ROW_PLACES)], b[16 * TTF_CELLS_MAX];
    uint32_t offsets[TTF_CELLS_MAX];
    uint64_t got[TTF_ROW_PLACES];

    for (size_t i = 0; i < sizeof(a) / sizeof(*a); i++)
        a[i] = TTF_CELL_MAX;
    for (uint32_t i = 0; i < TTF_CELLS_MAX; i++) {
        offsets[i] = 2 * i;
        for (size_t k = 0; k < 16; k++)
            b[16 * i + k] = -TTF_CELL_MAX;
    }
    for (size_t n = 1; n <= TTF_CELLS_MAX; n += n < 70 ? 1 : 31) {
        kernels->ssd_at_row(a, offsets, b, n, UINT64_MAX, got);
        for (int i = 0; i < TTF_ROW_PLACES; i++)
            assert_true(got[i] == 16 * n * (2 * TTF_CELL_MAX) * (2 * TTF_CELL_MAX));
    }
}

static void same_as_scalar(const struct ttf_rank_kernels *kernels)
{
    const struct ttf_rank_kernels *scalar = ttf_rank_kernels_scalar();
    static int16_t a[4096], b[4096], cells_of_b[16 * TTF_CELLS_MAX];
    static struct ttf_cell_target targets[TTF_CELLS_MAX];
    uint32_t want[40], got[40];
    static float w[120 * 32], in[4 * 128];
    float x[4 * 32], y[4 * 32];

    for (uint32_t i = 0; i < 4096; i++) {
        a[i] = value(i, TTF_COEF_MAX);
        b[i] = value(i + 9999, TTF_COEF_MAX);
    }
    for (size_t n = 16; n <= 4096; n += n < 400 ? 16 : 336)
        assert_int_equal(kernels->ssd_i16(a, b, n), scalar->ssd_i16(a, b, n));
    same_at_four_as_scalar(kernels, a, b);
    same_at_pairs_as_scalar(kernels, a, b, 256);
    no_lane_overflows(kernels);
    no_lane_of_a_row_overflows(kernels);
    for (uint32_t i = 0; i < 4096; i++)
        a[i] = value(i + 77, TTF_CELL_MAX);
    for (uint32_t i = 0; i < 16 * TTF_CELLS_MAX; i++)
        cells_of_b[i] = value(i + 7, TTF_CELL_MAX);
    same_at_pairs_as_scalar(kernels, a, cells_of_b, TTF_CELLS_MAX);
    same_in_a_row_as_scalar(kernels, a, cells_of_b, TTF_CELLS_MAX);
    for (uint32_t i = 0; i < TTF_CELLS_MAX; i++) {
        for (int d = 0; d < TTF_CELL_DIMS; d++)
            targets[i].value[d] = value(i * 8 + (uint32_t)d + 55, TTF_CELL_MAX);
        targets[i].offset = texture_hash(i, 1, 1) % 200;
    }
    for (size_t n = 1; n <= 40; n++) {
        for (size_t cells = 1; cells <= TTF_CELLS_MAX; cells += 73) {
            uint32_t limit = n % 2 ? UINT32_MAX : (uint32_t)cells * 2000000u;

            scalar->bound_cells(a, targets, cells, n, UINT32_MAX, want);
            kernels->bound_cells(a, targets, cells, n, limit, got);
            for (size_t x1 = 0; x1 < n; x1++)
                assert_true(want[x1] <= limit ? got[x1] == want[x1] : got[x1] > limit);
        }
    }
    for (uint32_t i = 0; i < 120 * 32; i++)
        w[i] = (float)value(i, 3000) / 3001.0f;
    for (uint32_t i = 0; i < 4 * 128; i++)
        in[i] = (float)value(i + 3, 9000) / 7.0f;
    for (size_t room = 8; room <= 32; room += 8) {
        scalar->rotate4(w, 120, room, in, 128, x);
        kernels->rotate4(w, 120, room, in, 128, y);
        assert_memory_equal(x, y, 4 * room * sizeof(float)); /* the same bits */
    }
}

static void all_kernels_come_to_what_the_scalar_ones_do(void **state)
{
    (void)state;
    same_as_scalar(ttf_rank_kernels_scalar());
    same_as_scalar(ttf_rank_kernels_best());
    if (ttf_rank_kernels_avx2())
        same_as_scalar(ttf_rank_kernels_avx2());
    if (ttf_rank_kernels_avx512())
        same_as_scalar(ttf_rank_kernels_avx512());
}

/* ---- search ---- */

struct bed {
    struct texture_sequence texture[2];
    struct ttf_sources sources;
    struct ttf_quilt_config config;
    struct ttf_matching matching;
    struct ttf_views views;
    struct ttf_rank_search search;
    struct ttf_rank_workspace *room;
};

static void bed_make_sized(struct bed *bed, enum texture texture, uint32_t width, uint32_t height,
                           unsigned inputs, unsigned turns, uint32_t overlap,
                           const struct ttf_rank_kernels *kernels)
{
    memset(bed, 0, sizeof(*bed));
    ttf_quilt_defaults(&bed->config);
    bed->texture[0] = texture_make(texture, width, height, N);
    bed->texture[1] = texture_make(TEXTURE_STRIPES, H, W - 3, N);
    bed->config.more = &bed->texture[1].sequence;
    bed->config.n_more = inputs - 1;
    assert_int_equal(ttf_sources_of(&bed->config, bed->texture[0].sequence, &bed->sources, NULL),
                     0);
    assert_int_equal(
        ttf_matching_build(&bed->config, &bed->sources, 0, N, NULL, NULL, &bed->matching, NULL), 0);
    assert_int_equal(
        ttf_views_create(&bed->sources, &bed->matching, turns, overlap, NULL, &bed->views), 0);
    bed->search = (struct ttf_rank_search){&bed->matching, &bed->views, kernels, 0.1};
    assert_int_equal(ttf_rank_workspace_create(&bed->room), 0);
}

static void bed_make(struct bed *bed, enum texture texture, unsigned inputs, unsigned turns,
                     uint32_t overlap, const struct ttf_rank_kernels *kernels)
{
    bed_make_sized(bed, texture, W, H, inputs, turns, overlap, kernels);
}

static void bed_free(struct bed *bed)
{
    ttf_rank_workspace_destroy(bed->room);
    ttf_views_free(&bed->views);
    ttf_matching_free(&bed->matching);
    texture_free(&bed->texture[0]);
    texture_free(&bed->texture[1]);
}

#define BW 14
#define BH 12

/* An L of pixels from two places of the first input, or a frame of four arms. */
static void make_query(uint32_t key, bool four, uint32_t *known)
{
    uint32_t ax = texture_hash(key, 1, 0) % (W - BW + 1), ay = texture_hash(key, 2, 0) % (H - BH);
    uint32_t bx = texture_hash(key, 3, 0) % (W - BW + 1), by = texture_hash(key, 4, 0) % (H - BH);

    for (uint32_t i = 0; i < BW * BH; i++) {
        uint32_t x = i % BW, y = i / BW;
        bool top = y < 3, left = x < 4, rest = four && (x >= BW - 3 || y >= BH - 5);

        known[i] = top || left || rest ? (top ? (ay + y) * W + ax + x : (by + y) * W + bx + x)
                                       : TTF_UNKNOWN_ID;
    }
}

/* Every position of every view, one difference at a time. */
static void plain(const struct bed *bed, const struct ttf_rank_query *query,
                  uint64_t *errors /* by view, row, column */, uint64_t *ret_best)
{
    const struct ttf_matching *m = &bed->matching;

    *ret_best = UINT64_MAX;
    for (unsigned v = 0; v < bed->views.n; v++) {
        const struct ttf_view *view = &bed->views.list[v];

        for (uint32_t y0 = 0; y0 + query->height <= view->height; y0++) {
            for (uint32_t x0 = 0; x0 + query->width <= view->width; x0++) {
                uint64_t sum = 0;

                for (uint32_t i = 0; i < query->width * query->height; i++) {
                    uint32_t own = ttf_view_id(view, x0 + i % query->width, y0 + i / query->width);

                    for (unsigned k = 0; query->known[i] != TTF_UNKNOWN_ID && k < m->k; k++) {
                        int64_t d = m->coefs[(size_t)query->known[i] * m->stride + k] -
                                    m->coefs[(size_t)own * m->stride + k];

                        sum += (uint64_t)(d * d);
                    }
                }
                for (unsigned e = 0; e < query->n_excluded; e++) {
                    const struct ttf_position_rect *r = &query->excluded[e];

                    if (r->view == v && x0 >= r->x0 && x0 < r->x1 && y0 >= r->y0 && y0 < r->y1)
                        sum = UINT64_MAX;
                }
                *errors++ = sum;
                *ret_best = sum < *ret_best ? sum : *ret_best;
            }
        }
    }
}

static void compare(const struct bed *bed, const struct ttf_rank_query *query)
{
    static uint64_t errors[16 * W * H];
    struct ttf_rank_result result;
    uint64_t best;
    uint32_t n = 0;
    size_t at = 0;

    plain(bed, query, errors, &best);
    assert_int_equal(ttf_rank_search_run(&bed->search, bed->room, query, &result), 0);
    assert_int_equal(result.best, best);
    for (unsigned v = 0; v < bed->views.n; v++) {
        const struct ttf_view *view = &bed->views.list[v];

        for (uint32_t y = 0; y + query->height <= view->height; y++) {
            for (uint32_t x = 0; x + query->width <= view->width; x++, at++) {
                const struct ttf_rank_candidate *c = &result.list[n];

                if ((double)errors[at] > ttf_rank_limit(&bed->search, result.overlap_pixels, best))
                    continue;
                assert_true(n < result.n);
                assert_true(c->position.view == v && c->position.x == x && c->position.y == y);
                assert_int_equal(c->error, errors[at]);
                n++;
            }
        }
    }
    assert_int_equal(n, result.n);
}

static void search_texture(enum texture texture, unsigned inputs, unsigned turns, uint32_t overlap,
                           const struct ttf_rank_kernels *kernels)
{
    uint32_t known[BW * BH];
    struct ttf_rank_query query = {.width = BW, .height = BH, .known = known};
    struct bed bed;

    bed_make(&bed, texture, inputs, turns, overlap, kernels);
    for (uint32_t key = 0; key < 6; key++) {
        const struct ttf_rank_position hints[2] = {{0, key, 3}, {0, 9000, 1}};

        make_query(key, key % 2, known);
        query.hints = hints;
        query.n_hints = key % 3;
        compare(&bed, &query);
    }
    bed_free(&bed);
}

static void all_candidates_of_all_positions_are_found(void **state)
{
    (void)state;
    search_texture(TEXTURE_SPOTS, 1, 1, 4, ttf_rank_kernels_best());
    search_texture(TEXTURE_SPOTS, 1, 1, 2, ttf_rank_kernels_scalar());
    search_texture(TEXTURE_SPOTS, 1, 1, 1, ttf_rank_kernels_best());
    search_texture(TEXTURE_NOISE, 1, 1, 4, ttf_rank_kernels_best());
    search_texture(TEXTURE_STRIPES, 1, 1, 4, ttf_rank_kernels_best());
    search_texture(TEXTURE_OBJECT, 1, 1, 4, ttf_rank_kernels_best());
    search_texture(TEXTURE_CONSTANT, 1, 1, 4, ttf_rank_kernels_best());
}

#define LARGE_W     90u
#define LARGE_H     74u
#define LARGE_BLOCK 56u

/* A block's upper 53 rows, four at a time of any place of the input: no place fits all well, so bounds have to be tight. */
static void search_large(enum texture texture)
{
    static uint32_t known[LARGE_BLOCK * LARGE_BLOCK];
    const struct ttf_rank_query query = {
        .width = LARGE_BLOCK, .height = LARGE_BLOCK, .known = known};
    struct ttf_rank_counts counts;
    struct bed bed;

    bed_make_sized(&bed, texture, LARGE_W, LARGE_H, 1, 1, 4, ttf_rank_kernels_best());
    bed.search.tolerance = 0.5; /* enough pass by coarse cells for fine ones to be asked */
    for (uint32_t key = 0; key < 3; key++) {
        for (uint32_t i = 0; i < LARGE_BLOCK * LARGE_BLOCK; i++) {
            uint32_t x = i % LARGE_BLOCK + (i / LARGE_BLOCK < 30 ? 0 : LARGE_W - LARGE_BLOCK);

            known[i] =
                i < 53 * LARGE_BLOCK ? (i / LARGE_BLOCK + 5 * key) * LARGE_W + x : TTF_UNKNOWN_ID;
        }
        compare(&bed, &query);
    }
    counts = ttf_rank_workspace_counts(bed.room);
    assert_true(counts.survived_cells > counts.positions / 64); /* so fine cells were asked */
    bed_free(&bed);
}

/* Of so many fine cells some are left out: their pixels are compared all the same. */
static void an_overlap_of_more_cells_than_are_kept_is_searched_as_well(void **state)
{
    (void)state;
    search_large(TEXTURE_SPOTS);
    search_large(TEXTURE_NOISE);
}

static void turned_blocks_and_further_inputs_are_looked_for_as_well(void **state)
{
    (void)state;
    search_texture(TEXTURE_SPOTS, 1, 0xff, 4, ttf_rank_kernels_best());
    search_texture(TEXTURE_SPOTS, 2, 1, 4, ttf_rank_kernels_best());
    search_texture(TEXTURE_SPOTS, 2, 0xff, 4, ttf_rank_kernels_best());
}

static void a_turned_view_shows_each_pixel_once_and_neighbours_stay_neighbours(void **state)
{
    (void)state;
    for (unsigned turn = 0; turn < TTF_TURN_COUNT; turn++) {
        const struct ttf_quilt_map map = {.n_inputs = 1, .inputs = {{7, 5, 0}}};
        uint8_t seen[35] = {0};
        struct ttf_view view;

        ttf_view_geometry(7, 5, 0, turn, &view);
        assert_int_equal(view.width, turn & 4 ? 5 : 7);
        for (uint32_t y = 0; y < view.height; y++) {
            for (uint32_t x = 0; x < view.width; x++) {
                uint32_t id = ttf_view_id(&view, x, y), next;

                assert_true(id < 35 && !seen[id]++);
                assert_int_equal(ttf_quilt_neighbour(&map, id, turn, 1, 0, &next),
                                 x + 1 < view.width);
                if (x + 1 < view.width)
                    assert_int_equal(next, ttf_view_id(&view, x + 1, y));
                assert_int_equal(ttf_quilt_neighbour(&map, id, turn, 0, -1, &next), y > 0);
                if (y > 0)
                    assert_int_equal(next, ttf_view_id(&view, x, y - 1));
            }
        }
    }
}

static void leave_out_positions(enum texture texture, const struct ttf_position_rect *some,
                                unsigned n)
{
    const struct ttf_rank_position hint = {0, 6, 10}; /* excluded: must not leak in */
    uint32_t known[BW * BH];
    const struct ttf_rank_query query = {.width = BW,
                                         .height = BH,
                                         .known = known,
                                         .excluded = some,
                                         .n_excluded = n,
                                         .hints = &hint,
                                         .n_hints = 1};
    struct bed bed;

    bed_make(&bed, texture, 1, 1, 4, ttf_rank_kernels_best());
    for (uint32_t key = 0; key < 4; key++) {
        make_query(key, false, known);
        compare(&bed, &query);
    }
    /* what fits exactly is among them, in a row that is not sampled */
    for (uint32_t i = 0; i < BW * BH; i++)
        known[i] = i < 5 * BW ? (10 + i / BW) * W + 7 + i % BW : TTF_UNKNOWN_ID;
    compare(&bed, &query);
    bed_free(&bed);
}

static void excluded_positions_are_left_out(void **state)
{
    const struct ttf_position_rect most[] = {{0, 0, 0, 20, 12}, {0, 5, 9, 9000, 9000}};
    const struct ttf_position_rect few = {0, 5, 9, 9, 14};

    (void)state;
    leave_out_positions(TEXTURE_SPOTS, most, 2);
    leave_out_positions(TEXTURE_NOISE, most, 2);
    leave_out_positions(TEXTURE_NOISE, &few, 1); /* coarse cells let all others pass */
}

static void exclusions_that_leave_nothing_are_not_heeded(void **state)
{
    const struct ttf_position_rect all = {0, 0, 0, 9000, 9000};
    uint32_t known[BW * BH], n;
    struct ttf_rank_query query = {.width = BW, .height = BH, .known = known};
    struct ttf_rank_result result;
    struct bed bed;
    uint64_t best;

    (void)state;
    bed_make(&bed, TEXTURE_SPOTS, 1, 1, 4, ttf_rank_kernels_best());
    make_query(3, false, known);
    assert_int_equal(ttf_rank_search_run(&bed.search, bed.room, &query, &result), 0);
    best = result.best;
    n = result.n;
    query.excluded = &all;
    query.n_excluded = 1;
    assert_int_equal(ttf_rank_search_run(&bed.search, bed.room, &query, &result), 0);
    assert_int_equal(result.best, best);
    assert_int_equal(result.n, n);
    bed_free(&bed);
}

static void a_query_without_known_pixels_or_too_large_is_refused(void **state)
{
    static uint32_t known[(W + 1) * BH];
    struct ttf_rank_query query = {.width = BW, .height = BH, .known = known};
    struct ttf_rank_result result;
    struct bed bed;

    (void)state;
    bed_make(&bed, TEXTURE_SPOTS, 1, 1, 4, ttf_rank_kernels_best());
    memset(known, 0xff, sizeof(known));
    assert_int_equal(ttf_rank_search_run(&bed.search, bed.room, &query, &result), -EINVAL);
    memset(known, 0, sizeof(known));
    query.width = W + 1;
    assert_int_equal(ttf_rank_search_run(&bed.search, bed.room, &query, &result), -EINVAL);
    bed_free(&bed);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(all_kernels_come_to_what_the_scalar_ones_do),
        cmocka_unit_test(all_candidates_of_all_positions_are_found),
        cmocka_unit_test(an_overlap_of_more_cells_than_are_kept_is_searched_as_well),
        cmocka_unit_test(turned_blocks_and_further_inputs_are_looked_for_as_well),
        cmocka_unit_test(a_turned_view_shows_each_pixel_once_and_neighbours_stay_neighbours),
        cmocka_unit_test(excluded_positions_are_left_out),
        cmocka_unit_test(exclusions_that_leave_nothing_are_not_heeded),
        cmocka_unit_test(a_query_without_known_pixels_or_too_large_is_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
