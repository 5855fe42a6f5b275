/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "textures.h"
#include "ttf/synth/run.h"

#define W 48u
#define H 44u
#define N 24u

/* Takes all frames, or fails at one, or cancels at one. */
struct taker {
    uint16_t *codes;
    size_t frame;
    uint32_t next, fail_at, cancel_at;
    int cancel;
};

static int take(void *ctx, uint32_t t, const uint16_t *codes, struct ttf_err *err)
{
    struct taker *taker = ctx;

    assert_int_equal(t, taker->next);
    taker->next++;
    if (t == taker->fail_at)
        return ttf_err_set(err, -ENOSPC, "disk", "is full");
    if (t == taker->cancel_at)
        taker->cancel = 1;
    memcpy(taker->codes + t * taker->frame, codes, taker->frame * sizeof(*codes));
    return 0;
}

static struct taker taker_make(const struct ttf_quilt_config *config)
{
    struct taker taker = {.frame = (size_t)config->width * config->height * 3,
                          .fail_at = UINT32_MAX,
                          .cancel_at = UINT32_MAX};

    taker.codes = malloc(N * taker.frame * sizeof(*taker.codes));
    assert_non_null(taker.codes);
    return taker;
}

static int64_t tick(void *ctx)
{
    int64_t *at = ctx;

    return *at += 1000;
}

static struct ttf_quilt_config small_config(void)
{
    struct ttf_quilt_config config;

    ttf_quilt_defaults(&config);
    config.width = 80;
    config.height = 70;
    config.block_width = config.block_height = 20;
    return config;
}

static struct ttf_sequence *output_of(const struct taker *taker,
                                      const struct ttf_quilt_config *config)
{
    struct ttf_sequence *output;

    assert_int_equal(ttf_sequence_of_memory(taker->codes, config->width, config->height, N,
                                            &texture_encoding, &output, NULL),
                     0);
    return output;
}

static void run_ok(const struct ttf_quilt_config *config, struct texture_sequence *input,
                   struct taker *taker, struct ttf_quilt_report *report, struct ttf_quilt_map *map)
{
    const struct ttf_quilt_sink sink = {.frame = take, .ctx = taker};
    struct ttf_err err = {0};

    if (ttf_quilt_run(config, input->sequence, NULL, &sink, report, map, &err) < 0)
        fail_msg("%s", err.what);
    assert_int_equal(taker->next, N);
}

static void a_whole_run_copies_trajectories_and_keeps_coherence(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct taker taker = taker_make(&config);
    struct ttf_quilt_report report;
    struct ttf_quilt_check check;
    struct ttf_sequence *output;
    struct ttf_quilt_map map;

    (void)state;
    run_ok(&config, &input, &taker, &report, &map);
    output = output_of(&taker, &config);
    assert_int_equal(
        ttf_quilt_verify(&(struct ttf_quilt_config){0}, input.sequence, output, &map, &check, NULL),
        0);
    assert_int_equal(check.pixels, 80 * 70);
    assert_int_equal(check.unmatched, 0);
    assert_int_equal(
        ttf_quilt_verify(&(struct ttf_quilt_config){0}, input.sequence, output, NULL, &check, NULL),
        0);
    assert_int_equal(check.unmatched, 0);
    assert_true(report.coherence_copied == 1.0);
    assert_true(report.coherence > 0.7 && report.coherence < 1.4);
    assert_true(report.map_digest != 0 && report.blocks == map.n_blocks);
    assert_true(report.seams.pairs > 0 && report.seams.frames == 16);
    ttf_sequence_destroy(output);
    ttf_quilt_map_free(&map);
    free(taker.codes);
    texture_free(&input);
}

static void frames_quilted_alone_flicker_and_fail_the_check(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct taker taker = taker_make(&config);
    struct ttf_quilt_report report;
    struct ttf_quilt_check check;
    struct ttf_sequence *output;
    struct ttf_quilt_map first;

    (void)state;
    config.per_frame = true;
    run_ok(&config, &input, &taker, &report, &first);
    output = output_of(&taker, &config);
    assert_true(report.coherence > 3.0);
    assert_true(report.flicker > 3.0);
    assert_true(report.seams.frames == 1 && report.seams.pairs > 0);
    assert_int_equal(
        ttf_quilt_verify(&(struct ttf_quilt_config){0}, input.sequence, output, NULL, &check, NULL),
        0);
    assert_true(check.unmatched > check.pixels / 2);
    assert_int_equal(ttf_quilt_verify(&(struct ttf_quilt_config){0}, input.sequence, output, &first,
                                      &check, NULL),
                     0);
    assert_true(check.unmatched > check.pixels / 2);
    ttf_sequence_destroy(output);
    ttf_quilt_map_free(&first);
    free(taker.codes);
    texture_free(&input);
}

static void one_changed_sample_is_found_by_the_check(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct taker taker = taker_make(&config);
    struct ttf_quilt_check check;
    struct ttf_sequence *output;

    (void)state;
    run_ok(&config, &input, &taker, NULL, NULL);
    taker.codes[17 * taker.frame + ((size_t)33 * config.width + 21) * 3 + 2] ^= 1;
    output = output_of(&taker, &config);
    assert_int_equal(
        ttf_quilt_verify(&(struct ttf_quilt_config){0}, input.sequence, output, NULL, &check, NULL),
        0);
    assert_int_equal(check.unmatched, 1);
    assert_int_equal(check.first_x, 21);
    assert_int_equal(check.first_y, 33);
    ttf_sequence_destroy(output);
    free(taker.codes);
    texture_free(&input);
}

static void a_check_can_be_cancelled(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct taker taker = taker_make(&config);
    struct ttf_sequence *output;
    struct ttf_quilt_check check;
    struct ttf_quilt_map map;
    const int cancel = 1;

    (void)state;
    run_ok(&config, &input, &taker, NULL, &map);
    output = output_of(&taker, &config);
    config.cancel = &cancel;
    assert_int_equal(ttf_quilt_verify(&config, input.sequence, output, &map, &check, NULL),
                     -ECANCELED);
    assert_int_equal(ttf_quilt_verify(&config, input.sequence, output, NULL, &check, NULL),
                     -ECANCELED);
    ttf_sequence_destroy(output);
    ttf_quilt_map_free(&map);
    free(taker.codes);
    texture_free(&input);
}

static void sequences_of_other_lengths_are_not_compared(void **state)
{
    struct texture_sequence a = texture_make(TEXTURE_SPOTS, W, H, 3);
    struct texture_sequence b = texture_make(TEXTURE_SPOTS, W, H, 4);
    struct ttf_quilt_check check;

    (void)state;
    assert_int_equal(
        ttf_quilt_verify(&(struct ttf_quilt_config){0}, a.sequence, b.sequence, NULL, &check, NULL),
        -EINVAL);
    assert_int_equal(
        ttf_quilt_verify(&(struct ttf_quilt_config){0}, a.sequence, a.sequence, NULL, &check, NULL),
        0);
    assert_int_equal(check.unmatched, 0);
    texture_free(&a);
    texture_free(&b);
}

static void threads_change_no_bit_of_the_frames_and_no_figure(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct taker one = taker_make(&config), five = taker_make(&config);
    struct ttf_pool *pool = ttf_pool_create(5);
    const struct ttf_quilt_sink sink = {.frame = take, .ctx = &five};
    struct ttf_quilt_report a, b;

    (void)state;
    config.feather_px = 3;
    run_ok(&config, &input, &one, &a, NULL);
    assert_int_equal(ttf_quilt_run(&config, input.sequence, pool, &sink, &b, NULL, NULL), 0);
    assert_memory_equal(one.codes, five.codes, N * one.frame * sizeof(*one.codes));
    assert_true(a.map_digest == b.map_digest);
    assert_true(a.coherence == b.coherence && a.flicker == b.flicker);
    assert_true(a.seams.excess == b.seams.excess);
    assert_true(a.search.exact == b.search.exact);
    assert_int_equal(b.threads, 5);
    ttf_pool_destroy(pool);
    free(one.codes);
    free(five.codes);
    texture_free(&input);
}

static void a_failing_sink_and_a_cancel_end_the_run_at_once(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct taker taker = taker_make(&config);
    const struct ttf_quilt_sink sink = {.frame = take, .ctx = &taker};
    struct ttf_err err = {0};

    (void)state;
    taker.fail_at = 4;
    assert_int_equal(ttf_quilt_run(&config, input.sequence, NULL, &sink, NULL, NULL, &err),
                     -ENOSPC);
    assert_string_equal(err.where, "disk");
    assert_int_equal(taker.next, 5);
    taker.next = 0;
    taker.fail_at = UINT32_MAX;
    taker.cancel_at = 7;
    config.cancel = &taker.cancel;
    assert_int_equal(ttf_quilt_run(&config, input.sequence, NULL, &sink, NULL, NULL, &err),
                     -ECANCELED);
    assert_int_equal(taker.next, 8);
    free(taker.codes);
    texture_free(&input);
}

static double last_progress;

static void rising(void *ctx, double done)
{
    (void)ctx;
    assert_true(done >= last_progress && done <= 1.0);
    last_progress = done;
}

static void progress_rises_to_one(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct taker taker = taker_make(&config);

    (void)state;
    config.progress = rising;
    last_progress = 0.0;
    run_ok(&config, &input, &taker, NULL, NULL);
    assert_true(last_progress == 1.0);
    free(taker.codes);
    texture_free(&input);
}

static void the_report_is_json_that_says_what_was_done(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct taker taker = taker_make(&config);
    struct ttf_quilt_report report;
    struct ttf_json json;
    int64_t clock = 0;
    const char *text;
    json_t *root;
    size_t bytes;
    json_int_t total;
    double copied;
    const char *seed;

    (void)state;
    config.seed = UINT64_MAX;
    config.now_ns = tick;
    config.now_ctx = &clock;
    run_ok(&config, &input, &taker, &report, NULL);
    ttf_json_init(&json, true);
    ttf_quilt_report_json(&report, &json);
    assert_int_equal(ttf_json_finish(&json, &text, &bytes), 0);
    root = json_loads(text, 0, NULL);
    assert_non_null(root);
    assert_int_equal(json_unpack(root, "{s:{s:s},s:{s:F},s:{s:I}}", "parameters", "seed", &seed,
                                 "temporal_coherence", "difference_ratio_copied", &copied,
                                 "times_ns", "total", &total),
                     0);
    assert_string_equal(seed, "18446744073709551615"); /* no digit lost */
    assert_true(copied == 1.0);
    assert_true(total > 0 && report.search.search_ns > 0);
    json_decref(root);
    ttf_json_free(&json);
    free(taker.codes);
    texture_free(&input);
}

static void a_single_frame_and_a_constant_one_have_defined_figures(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_CONSTANT, W, H, 1);
    struct ttf_quilt_config config = small_config();
    struct taker taker = taker_make(&config);
    const struct ttf_quilt_sink sink = {.frame = take, .ctx = &taker};
    struct ttf_quilt_report report;
    struct ttf_json json;
    const char *text;
    size_t bytes;

    (void)state;
    assert_int_equal(ttf_quilt_run(&config, input.sequence, NULL, &sink, &report, NULL, NULL), 0);
    assert_int_equal(taker.next, 1);
    assert_true(isnan(report.coherence) && isnan(report.flicker));
    ttf_json_init(&json, false);
    ttf_quilt_report_json(&report, &json);
    assert_int_equal(ttf_json_finish(&json, &text, &bytes), 0); /* no NaN anywhere */
    ttf_json_free(&json);
    free(taker.codes);
    texture_free(&input);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_whole_run_copies_trajectories_and_keeps_coherence),
        cmocka_unit_test(frames_quilted_alone_flicker_and_fail_the_check),
        cmocka_unit_test(one_changed_sample_is_found_by_the_check),
        cmocka_unit_test(a_check_can_be_cancelled),
        cmocka_unit_test(sequences_of_other_lengths_are_not_compared),
        cmocka_unit_test(threads_change_no_bit_of_the_frames_and_no_figure),
        cmocka_unit_test(a_failing_sink_and_a_cancel_end_the_run_at_once),
        cmocka_unit_test(progress_rises_to_one),
        cmocka_unit_test(the_report_is_json_that_says_what_was_done),
        cmocka_unit_test(a_single_frame_and_a_constant_one_have_defined_figures),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
