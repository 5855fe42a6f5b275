/* SPDX-License-Identifier: Apache-2.0 */
/* Whole runs beyond the plain one: 8-bit sinks, replayed maps, several inputs, errors on the way. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "quilts.h"

#define W 48u
#define H 44u
#define N 24u

static struct ttf_quilt_config small_config(void)
{
    struct ttf_quilt_config config;

    ttf_quilt_defaults(&config);
    config.width = 83;
    config.height = 70;
    config.block_width = config.block_height = 20;
    return config;
}

/* ---- 8-bit sinks ---- */

/* Of the map, however it was summed up. */
static void says_the_same(const struct ttf_quilt_report *a, const struct ttf_quilt_report *b)
{
    assert_true(a->map_digest == b->map_digest);
    assert_int_equal(a->repetition.max_uses, b->repetition.max_uses);
    assert_true(a->repetition.mean_uses == b->repetition.mean_uses &&
                a->repetition.source_coverage == b->repetition.source_coverage &&
                a->repetition.verbatim_share == b->repetition.verbatim_share);
}

static void has_the_same_runs(const struct ttf_quilt_map *a, const struct ttf_quilt_map *b)
{
    assert_memory_equal(a->row_runs, b->row_runs, (a->height + 1) * sizeof(*a->row_runs));
    assert_memory_equal(a->runs, b->runs, a->row_runs[a->height] * sizeof(*a->runs));
}

static void is_the_16_bit_run_as_display_codes(const struct ttf_quilt_config *config,
                                               struct ttf_sequence *input)
{
    uint32_t n = input->n;
    struct quilt_taker wide = quilt_taker_make(config, n), narrow = quilt_taker_make(config, n);
    const struct ttf_quilt_sink sink = quilt_sink(&narrow, true);
    static uint8_t table[65536];
    uint8_t *want = malloc(n * wide.frame);
    struct ttf_quilt_report report, own;
    struct ttf_quilt_map map, own_map;

    assert_non_null(want);
    ttf_display8_table(&texture_encoding, table);
    quilt_run_ok(config, input, NULL, &wide, &report, &map);
    for (size_t i = 0; i < n * wide.frame; i++)
        want[i] = table[wide.codes[i]];
    for (unsigned threads = 1; threads <= 5; threads += 2) {
        struct ttf_pool *pool = ttf_pool_create(threads);

        quilt_taker_reset(&narrow);
        assert_int_equal(ttf_quilt_run(config, input, pool, &sink, &own, &own_map, NULL), 0);
        assert_true(quilt_taker_has_all_rows(&narrow));
        assert_int_equal(narrow.next, 0); /* nothing as 16 bits */
        assert_memory_equal(narrow.codes8, want, n * wide.frame);
        says_the_same(&own, &report);
        has_the_same_runs(&own_map, &map);
        ttf_quilt_map_free(&own_map);
        ttf_pool_destroy(pool);
    }
    ttf_quilt_map_free(&map);
    free(want);
    quilt_taker_free(&wide);
    quilt_taker_free(&narrow);
}

static void eight_bit_frames_are_the_16_bit_ones_as_display_codes(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_NOISE, W, H, N);
    struct texture_sequence other = texture_make(TEXTURE_NOISE, 61, 31, N);
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.measure = false;
    is_the_16_bit_run_as_display_codes(&config, input.sequence);
    config.more = &other.sequence;
    config.n_more = 1;
    config.flips = true;
    config.width = 7; /* less than there are parts */
    config.height = 5;
    is_the_16_bit_run_as_display_codes(&config, input.sequence);
    texture_free(&input);
    texture_free(&other);
}

/* Rows leave before the last block lies, of as many frames as may be kept: of all, some, or none; all come to the same. */
static void rows_that_go_ahead_are_those_of_the_whole(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_NOISE, W, H, N);
    struct ttf_quilt_config config = small_config();
    size_t frame = (size_t)W * H * 3;
    const size_t keep[] = {
        0, frame - 1, frame + 64, 7 * frame + 64, N * frame + 63, N * frame + 64};

    (void)state;
    config.measure = false;
    config.width = 256; /* strips end where pages do */
    config.height = 150;
    for (size_t i = 0; i < sizeof(keep) / sizeof(keep[0]); i++) {
        config.keep_bytes = keep[i];
        is_the_16_bit_run_as_display_codes(&config, input.sequence);
    }
    config.avoid_px = 8; /* rows stay further behind one another */
    is_the_16_bit_run_as_display_codes(&config, input.sequence);
    config.avoid_px = 0;
    config.width = 20; /* one column, one row */
    is_the_16_bit_run_as_display_codes(&config, input.sequence);
    config.height = 20;
    is_the_16_bit_run_as_display_codes(&config, input.sequence);
    texture_free(&input);
}

/* Each look at it takes 1 ns, from the `slow_from`th on 4.4 ms. By any thread. */
struct looks {
    int64_t now_ns;
    unsigned looks, slow_from;
};

static int64_t look(void *ctx)
{
    struct looks *l = ctx;
    bool slow = __atomic_add_fetch(&l->looks, 1, __ATOMIC_RELAXED) >= l->slow_from;

    return __atomic_add_fetch(&l->now_ns, slow ? 4400000 : 1, __ATOMIC_RELAXED);
}

/* Memory of frames that are kept is taken by the clock, whatever that says, all or some of them kept. */
static void how_long_memory_takes_changes_no_bit(void **state)
{
    struct texture_sequence input =
        texture_make(TEXTURE_NOISE, 200, 150, 100); /* five large pages */
    struct ttf_quilt_config config = small_config();
    const unsigned slow_from[] = {1, UINT32_MAX};

    (void)state;
    config.measure = false;
    config.now_ns = look;
    for (size_t i = 0; i < sizeof(slow_from) / sizeof(slow_from[0]); i++) {
        struct looks looks = {.slow_from = slow_from[i]};

        config.now_ctx = &looks;
        config.width = 64;
        config.height = 48;
        config.keep_bytes = (i == 0 ? 100u : 80u) * 90000u + 64;
        is_the_16_bit_run_as_display_codes(&config, input.sequence);
    }
    texture_free(&input);
}

/* Several times the input's pixels are handed on at once, in pieces that a core has near. */
static void long_strips_are_handed_on_band_by_band(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, 240, 200, 2);
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.measure = false;
    config.block_width = config.block_height = 60;
    config.width = 1000; /* 131 rows a band, 144 a strip */
    config.height = 620;
    is_the_16_bit_run_as_display_codes(&config, input.sequence);
    config.block_height = 200; /* rows become final in larger steps */
    is_the_16_bit_run_as_display_codes(&config, input.sequence);
    texture_free(&input);
}

struct reserving {
    struct quilt_taker taker;
    unsigned asked, rows; /* parts so far; calls of rows8 */
    unsigned asking;      /* threads that are at it */
    unsigned fail_at, cancel_at;
    int cancel;
    bool out_of_order;
};

static int reserve_part(void *ctx, unsigned part, unsigned parts, struct ttf_err *err)
{
    struct reserving *r = ctx;

    if (part == r->fail_at)
        return ttf_err_set(err, -ENOSPC, "disk", "is full");
    if (part == r->cancel_at)
        r->cancel = 1;
    if (__atomic_fetch_add(&r->asking, 1, __ATOMIC_RELAXED) > 0 || part != r->asked ||
        part >= parts)
        r->out_of_order = true;
    r->asked = part + 1;
    __atomic_fetch_sub(&r->asking, 1, __ATOMIC_RELAXED);
    return 0;
}

static int count_rows(void *ctx, uint32_t t, uint32_t y0, uint32_t y1, const uint8_t *codes,
                      struct ttf_err *err)
{
    struct reserving *r = ctx;
    const struct ttf_quilt_sink sink = quilt_sink(&r->taker, true);

    __atomic_add_fetch(&r->rows, 1, __ATOMIC_RELAXED);
    return sink.rows8(&r->taker, t, y0, y1, codes, err);
}

static void room_is_asked_for_in_order_by_one_thread_at_a_time(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_NOISE, W, H, N);
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.measure = false;
    for (unsigned threads = 1; threads <= 3; threads++) {
        struct reserving r = {
            .taker = quilt_taker_make(&config, N), .fail_at = UINT32_MAX, .cancel_at = UINT32_MAX};
        struct ttf_quilt_sink sink = quilt_sink(&r.taker, true);
        struct ttf_pool *pool = ttf_pool_create(threads);
        struct ttf_err err = {0};

        sink.rows8 = count_rows;
        sink.reserve = reserve_part;
        sink.ctx = &r;
        assert_int_equal(ttf_quilt_run(&config, input.sequence, pool, &sink, NULL, NULL, NULL), 0);
        assert_true(r.asked > 0);
        assert_false(r.out_of_order);
        assert_true(quilt_taker_has_all_rows(&r.taker));
        r.fail_at = 0; /* the disk is full: that is known before anything is written */
        r.rows = 0;
        assert_int_equal(ttf_quilt_run(&config, input.sequence, pool, &sink, NULL, NULL, &err),
                         -ENOSPC);
        assert_string_equal(err.where, "disk");
        if (threads == 1) /* others may be at the first rows already */
            assert_int_equal(r.rows, 0);
        ttf_pool_destroy(pool);
        quilt_taker_free(&r.taker);
    }
    texture_free(&input);
}

/* One thread asks for all of the room before it reads a frame. */
static void who_cancels_does_not_wait_for_room(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_NOISE, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct reserving r;
    struct ttf_quilt_sink sink;

    (void)state;
    config.measure = false;
    r = (struct reserving){
        .taker = quilt_taker_make(&config, N), .fail_at = UINT32_MAX, .cancel_at = 4};
    sink = quilt_sink(&r.taker, true);
    sink.rows8 = count_rows;
    sink.reserve = reserve_part;
    sink.ctx = &r;
    config.cancel = &r.cancel;
    assert_int_equal(ttf_quilt_run(&config, input.sequence, NULL, &sink, NULL, NULL, NULL),
                     -ECANCELED);
    assert_int_equal(r.asked, 5);
    assert_int_equal(r.rows, 0);
    quilt_taker_free(&r.taker);
    texture_free(&input);
}

/* What is kept counts: within the memory that is allowed, and only where rows can go ahead. */
static void what_is_kept_stays_within_the_memory_allowed(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_NOISE, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct quilt_taker taker = quilt_taker_make(&config, N);
    const struct ttf_quilt_sink sink = quilt_sink(&taker, true);
    size_t matching = ttf_quilt_matching_bytes(&config, W * H, N), frame = (size_t)W * H * 3;
    struct ttf_quilt_report all, some, tight, none;

    (void)state;
    config.measure = false;
    assert_int_equal(ttf_quilt_run(&config, input.sequence, NULL, &sink, &all, NULL, NULL), 0);
    config.memory_bytes =
        matching + 5 * frame + 64 + (size_t)W * H * 4; /* and what its uses are counted in */
    assert_int_equal(ttf_quilt_run(&config, input.sequence, NULL, &sink, &some, NULL, NULL), 0);
    config.memory_bytes = matching;
    assert_int_equal(ttf_quilt_run(&config, input.sequence, NULL, &sink, &tight, NULL, NULL), 0);
    config.memory_bytes = 0;
    config.keep_bytes = 0;
    assert_int_equal(ttf_quilt_run(&config, input.sequence, NULL, &sink, &none, NULL, NULL), 0);
    assert_int_equal(all.frame_bytes - some.frame_bytes, (N - 5) * frame);
    assert_int_equal(tight.frame_bytes, none.frame_bytes);
    assert_true(none.frame_bytes < some.frame_bytes);
    quilt_taker_free(&taker);
    texture_free(&input);
}

/* Blends and times between frames need 16 bits: then the 16-bit sink is used, also for a replayed map. */
static void wide_although_narrow_is_offered(struct ttf_quilt_config config,
                                            struct ttf_sequence *input)
{
    struct quilt_taker want = quilt_taker_make(&config, N), got = quilt_taker_make(&config, N);
    const struct ttf_quilt_sink sink = quilt_sink(&got, true);
    struct ttf_quilt_map map;

    quilt_run_ok(&config, input, NULL, &want, NULL, &map);
    assert_int_equal(ttf_quilt_run(&config, input, NULL, &sink, NULL, NULL, NULL), 0);
    assert_memory_equal(got.codes, want.codes, N * got.frame * sizeof(*got.codes));
    got.next = 0;
    memset(got.codes, 0, N * got.frame * sizeof(*got.codes));
    config.replay = &map; /* what the map says counts, whatever the settings beside it */
    config.feather_px = 0;
    config.jitter_frames = 0;
    assert_int_equal(ttf_quilt_run(&config, input, NULL, &sink, NULL, NULL, NULL), 0);
    assert_memory_equal(got.codes, want.codes, N * got.frame * sizeof(*got.codes));
    ttf_quilt_map_free(&map);
    quilt_taker_free(&want);
    quilt_taker_free(&got);
}

static void blends_and_times_between_frames_stay_16_bit(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.measure = false;
    config.feather_px = 3;
    wide_although_narrow_is_offered(config, input.sequence);
    config.feather_px = 0;
    config.jitter_frames = 3;
    wide_although_narrow_is_offered(config, input.sequence);
    config.feather_px = 3;
    wide_although_narrow_is_offered(config, input.sequence);
    texture_free(&input);
}

/* ---- the check ---- */

static void several_inputs_are_copied_bit_for_bit(void **state)
{
    struct texture_sequence whole = texture_make(TEXTURE_SPOTS, 80, 50, N);
    struct texture_sequence input = texture_crop(&whole, 0, 0, W, H);
    struct texture_sequence other = texture_crop(&whole, W, 0, 80 - W, 50);
    struct ttf_quilt_config config = small_config();
    struct quilt_taker taker = quilt_taker_make(&config, N);
    struct ttf_quilt_check check;
    struct ttf_quilt_report report;
    struct ttf_sequence *output;
    struct ttf_quilt_map map;
    size_t used[2] = {0};

    (void)state;
    config.more = &other.sequence;
    config.n_more = 1;
    config.flips = config.rotations = config.tileable = true;
    quilt_run_ok(&config, input.sequence, NULL, &taker, &report, &map);
    assert_int_equal(report.inputs, 2);
    for (unsigned i = 0; i < map.n_blocks; i++)
        used[map.blocks[i].input]++;
    assert_true(used[0] > 3 && used[1] > 3);
    assert_true(report.coherence_copied == 1.0);
    output = quilt_taken(&taker, &config);
    assert_int_equal(ttf_quilt_verify(&config, input.sequence, output, &map, &check, NULL), 0);
    assert_int_equal(check.unmatched, 0);
    assert_int_equal(ttf_quilt_verify(&config, input.sequence, output, NULL, &check, NULL), 0);
    assert_int_equal(check.unmatched, 0);
    config.n_more = 0; /* the map is of two */
    assert_int_equal(ttf_quilt_verify(&config, input.sequence, output, &map, &check, NULL),
                     -EINVAL);
    ttf_sequence_destroy(output);
    ttf_quilt_map_free(&map);
    quilt_taker_free(&taker);
    texture_free(&whole);
    texture_free(&input);
    texture_free(&other);
}

/* ---- replay ---- */

static void a_map_is_replayed_on_another_exposure(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct texture_sequence darker = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct quilt_taker taker = quilt_taker_make(&config, N);
    struct ttf_quilt_report first, second;
    struct ttf_quilt_check check;
    struct ttf_sequence *output;
    struct ttf_quilt_map map;

    (void)state;
    for (size_t i = 0; i < (size_t)W * H * N * 3; i++)
        darker.codes[i] = (uint16_t)(darker.codes[i] / 2 + i % 7);
    config.agreement_queries = 5;
    quilt_run_ok(&config, input.sequence, NULL, &taker, &first, &map);
    assert_int_equal(first.agreement.queries, 5);
    config.replay = &map;
    config.agreement_queries = 0;
    quilt_run_ok(&config, darker.sequence, NULL, &taker, &second, NULL);
    assert_true(first.map_digest == second.map_digest);
    assert_true(second.coherence_copied == 1.0);
    output = quilt_taken(&taker, &config);
    assert_int_equal(ttf_quilt_verify(&config, darker.sequence, output, &map, &check, NULL), 0);
    assert_int_equal(check.unmatched, 0);
    ttf_sequence_destroy(output);
    ttf_quilt_map_free(&map);
    quilt_taker_free(&taker);
    texture_free(&input);
    texture_free(&darker);
}

static void a_jittered_map_is_replayed_with_its_times(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct quilt_taker a = quilt_taker_make(&config, N), b = quilt_taker_make(&config, N);
    struct ttf_quilt_report first, second;
    struct ttf_quilt_map map;

    (void)state;
    config.jitter_frames = 3;
    config.feather_px = 2;
    quilt_run_ok(&config, input.sequence, NULL, &a, &first, &map);
    config.replay = &map;
    config.jitter_frames = 0;
    config.feather_px = 0;
    quilt_run_ok(&config, input.sequence, NULL, &b, &second, NULL);
    assert_memory_equal(a.codes, b.codes, N * a.frame * sizeof(*a.codes));
    assert_true(first.flicker_copied == second.flicker_copied);
    assert_true(first.copied.mean_difference == second.copied.mean_difference);
    assert_true(first.coherence_copied == second.coherence_copied);
    ttf_quilt_map_free(&map);
    quilt_taker_free(&a);
    quilt_taker_free(&b);
    texture_free(&input);
}

static void a_map_of_other_sizes_is_not_replayed(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, 4);
    struct texture_sequence wider = texture_make(TEXTURE_SPOTS, W + 1, H, 4);
    struct texture_sequence longer = texture_make(TEXTURE_SPOTS, W, H, 5);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_map map;

    (void)state;
    config.jitter_frames = 1;
    quilt_plan_ok(&config, input.sequence, NULL, &map);
    config.replay = &map;
    quilt_refused(&config, wider.sequence, -EINVAL, "map");
    quilt_refused(&config, longer.sequence, -EINVAL, "map"); /* its times are too few */
    config.more = &input.sequence;
    config.n_more = 1;
    quilt_refused(&config, input.sequence, -EINVAL, "map");
    config.n_more = 0;
    config.width--;
    quilt_refused(&config, input.sequence, -EINVAL, "map");
    config.width++;
    config.jitter_frames = 0;
    config.per_frame = true; /* each frame alone has no one map */
    quilt_refused(&config, input.sequence, -EINVAL, "per_frame");
    ttf_quilt_map_free(&map);
    texture_free(&input);
    texture_free(&wider);
    texture_free(&longer);
}

/* ---- errors on the way ---- */

struct leaky {
    struct ttf_sequence base;
    struct texture_sequence *texture;
    uint32_t fail_at;
    unsigned passes; /* over its first row of that frame before it fails */
};

static int leaky_read(struct ttf_sequence *sequence, uint32_t t, uint32_t y0, uint32_t rows,
                      uint16_t *dst, struct ttf_err *err)
{
    struct leaky *leaky = (struct leaky *)sequence;

    if (t == leaky->fail_at && y0 == 0 && leaky->passes-- == 0)
        return ttf_err_set(err, -EIO, "frame", "cannot be read");
    return ttf_sequence_read_rows(leaky->texture->sequence, t, y0, rows, dst, err);
}

static void errors_in_the_pipeline_end_it_as_what_they_are(unsigned threads, bool narrow,
                                                           uint32_t jitter)
{
    static const struct ttf_sequence_ops ops = {.read_rows = leaky_read};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct leaky leaky = {.base = *input.sequence, .texture = &input, .fail_at = 9, .passes = 1};
    struct ttf_quilt_config config = small_config();
    struct quilt_taker taker = quilt_taker_make(&config, N);
    const struct ttf_quilt_sink sink = quilt_sink(&taker, narrow);
    struct ttf_pool *pool = ttf_pool_create(threads);
    struct ttf_err err = {0};
    bool by_rows = narrow && jitter == 0;

    leaky.base.ops = &ops;
    config.measure = false;
    config.jitter_frames = jitter;
    config.keep_bytes = 6 * (size_t)W * H * 3; /* five frames: the others are read a second time */
    taker.fail_at = 4;
    assert_int_equal(ttf_quilt_run(&config, input.sequence, pool, &sink, NULL, NULL, &err),
                     -ENOSPC);
    assert_string_equal(err.where, "disk");
    assert_int_equal(taker.next, by_rows ? 0 : 5);
    quilt_taker_reset(&taker);
    taker.fail_at = UINT32_MAX;
    assert_int_equal(ttf_quilt_run(&config, &leaky.base, pool, &sink, NULL, NULL, &err), -EIO);
    assert_string_equal(err.where, "frame");
    assert_true(by_rows || (taker.next <= 10 && taker.next >= 5));
    assert_false(quilt_taker_has_all_rows(&taker));
    quilt_taker_reset(&taker);
    taker.cancel_at = 7;
    config.cancel = &taker.cancel;
    assert_int_equal(ttf_quilt_run(&config, input.sequence, pool, &sink, NULL, NULL, &err),
                     -ECANCELED);
    assert_int_equal(taker.next, by_rows ? 0 : 8);
    assert_false(taker.out_of_order);
    assert_false(quilt_taker_has_all_rows(&taker));
    quilt_taker_reset(&taker);
    taker.cancel_at = 2; /* a frame whose rows go ahead */
    assert_int_equal(ttf_quilt_run(&config, input.sequence, pool, &sink, NULL, NULL, &err),
                     -ECANCELED);
    assert_false(quilt_taker_has_all_rows(&taker));
    ttf_pool_destroy(pool);
    quilt_taker_free(&taker);
    texture_free(&input);
}

static void any_thread_may_meet_the_error(void **state)
{
    (void)state;
    for (unsigned threads = 1; threads <= 5; threads += 2) {
        errors_in_the_pipeline_end_it_as_what_they_are(threads, false, 0);
        errors_in_the_pipeline_end_it_as_what_they_are(threads, true, 0);
        errors_in_the_pipeline_end_it_as_what_they_are(threads, true, 2);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eight_bit_frames_are_the_16_bit_ones_as_display_codes),
        cmocka_unit_test(rows_that_go_ahead_are_those_of_the_whole),
        cmocka_unit_test(how_long_memory_takes_changes_no_bit),
        cmocka_unit_test(long_strips_are_handed_on_band_by_band),
        cmocka_unit_test(room_is_asked_for_in_order_by_one_thread_at_a_time),
        cmocka_unit_test(who_cancels_does_not_wait_for_room),
        cmocka_unit_test(what_is_kept_stays_within_the_memory_allowed),
        cmocka_unit_test(blends_and_times_between_frames_stay_16_bit),
        cmocka_unit_test(several_inputs_are_copied_bit_for_bit),
        cmocka_unit_test(a_map_is_replayed_on_another_exposure),
        cmocka_unit_test(a_jittered_map_is_replayed_with_its_times),
        cmocka_unit_test(a_map_of_other_sizes_is_not_replayed),
        cmocka_unit_test(any_thread_may_meet_the_error),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
