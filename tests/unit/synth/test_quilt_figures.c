/* SPDX-License-Identifier: Apache-2.0 */
/* What a run's report says of its frames. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <jansson.h>
#include <math.h>
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

static void measured_runs_are_16_bit_and_threads_change_no_figure(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct quilt_taker taker = quilt_taker_make(&config, N);
    struct ttf_pool *pool = ttf_pool_create(5);
    struct ttf_quilt_report a, b;

    (void)state;
    config.jitter_frames = 2;
    config.feather_px = 2;
    for (int jittered = 0; jittered < 2; jittered++) {
        config.jitter_frames = jittered ? 2 : 0;
        quilt_run_ok(&config, input.sequence, NULL, &taker, &a, NULL);
        quilt_run_ok(&config, input.sequence, pool, &taker, &b, NULL);
        assert_true(a.map_digest == b.map_digest && a.coherence == b.coherence);
        assert_true(a.flicker_copied == b.flicker_copied && a.synchrony == b.synchrony);
        assert_true(a.colour.mean == b.colour.mean && a.seams.excess == b.seams.excess);
    }
    ttf_pool_destroy(pool);
    quilt_taker_free(&taker);
    texture_free(&input);
}

static void copies_at_their_own_time_are_exactly_as_active(void **state)
{
    static const enum texture textures[] = {TEXTURE_SPOTS, TEXTURE_NOISE, TEXTURE_STRIPES};

    (void)state;
    for (int i = 0; i < 3; i++) {
        struct texture_sequence input = texture_make(textures[i], W, H, N);
        struct ttf_quilt_config config = small_config();
        struct quilt_taker taker = quilt_taker_make(&config, N);
        struct ttf_quilt_report report;

        config.seed = (uint64_t)i;
        quilt_run_ok(&config, input.sequence, NULL, &taker, &report, NULL);
        assert_true(report.coherence_copied == 1.0 && report.flicker_copied == 1.0);
        quilt_taker_free(&taker);
        texture_free(&input);
    }
}

/* Mean absolute difference of successive frames that were taken, display codes. */
static double activity_of(const struct quilt_taker *taker)
{
    static uint8_t table[65536];
    double sum = 0.0;

    ttf_display8_table(&texture_encoding, table);
    for (size_t i = taker->frame; i < taker->room * taker->frame; i++)
        sum += abs(table[taker->codes[i]] - table[taker->codes[i - taker->frame]]);
    return sum / ((double)taker->frame * (taker->room - 1));
}

static void figures_are_of_what_was_put_out(void **state)
{
    static const uint32_t kinds[][3] = {{0, 0, 0}, {3, 0, 0}, {0, 3, 0}, {3, 3, 0}, {0, 3, 1}};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct quilt_taker taker = quilt_taker_make(&config, N);
    struct ttf_quilt_report report;

    (void)state;
    for (int i = 0; i < 5; i++) {
        config.jitter_frames = kinds[i][0];
        config.feather_px = kinds[i][1];
        config.per_frame = kinds[i][2];
        quilt_run_ok(&config, input.sequence, NULL, &taker, &report, NULL);
        assert_true(fabs(report.output.mean_difference - activity_of(&taker)) < 1e-9);
    }
    quilt_taker_free(&taker);
    texture_free(&input);
}

static void jitter_takes_repeated_blocks_out_of_step(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct quilt_taker taker;
    struct ttf_quilt_report still, jittered;

    (void)state;
    config.width = config.height = 120; /* many times its input */
    taker = quilt_taker_make(&config, N);
    quilt_run_ok(&config, input.sequence, NULL, &taker, &still, NULL);
    config.jitter_frames = 3;
    config.jitter_every = 4;
    quilt_run_ok(&config, input.sequence, NULL, &taker, &jittered, NULL);
    assert_true(jittered.synchrony < 0.9);
    config.jitter_every = 1;
    quilt_run_ok(&config, input.sequence, NULL, &taker, &jittered, NULL);
    assert_true(still.synchrony_pairs > 1000 && jittered.synchrony_pairs > 1000);
    assert_true(still.synchrony > 0.999);
    assert_true(jittered.synchrony < 0.7);
    assert_true(jittered.coherence_copied > 0.5 && jittered.coherence_copied < 1.2);
    quilt_taker_free(&taker);
    texture_free(&input);
}

static json_t *json_of(const struct ttf_quilt_report *report)
{
    struct ttf_json json;
    const char *text;
    json_t *root;
    size_t bytes;

    ttf_json_init(&json, true);
    ttf_quilt_report_json(report, &json);
    assert_int_equal(ttf_json_finish(&json, &text, &bytes), 0);
    root = json_loads(text, 0, NULL);
    assert_non_null(root);
    ttf_json_free(&json);
    return root;
}

static void without_measuring_the_report_has_no_figures_of_frames(void **state)
{
    static const char *const figures[] = {"temporal_coherence", "synchrony", "colour_distance",
                                          "seams"};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct quilt_taker taker = quilt_taker_make(&config, N);
    struct ttf_quilt_report report;

    (void)state;
    for (int measure = 0; measure < 2; measure++) {
        json_t *root;

        config.measure = measure;
        quilt_run_ok(&config, input.sequence, NULL, &taker, &report, NULL);
        root = json_of(&report);
        assert_int_equal(json_is_true(json_object_get(root, "measured")), measure);
        for (int i = 0; i < 4; i++)
            assert_int_equal(json_object_get(root, figures[i]) != NULL, measure);
        assert_non_null(json_object_get(root, "repetition")); /* of the map, not of frames */
        assert_true(report.repetition.max_uses > 0);
        json_decref(root);
    }
    quilt_taker_free(&taker);
    texture_free(&input);
}

static void seams_of_a_slowed_output_are_unknown_rather_than_none(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct ttf_quilt_report report;
    struct ttf_rate_map rate = {config.width, config.height, NULL};
    size_t pixels = (size_t)config.width * config.height;

    (void)state;
    rate.m = malloc(pixels * sizeof(*rate.m));
    assert_non_null(rate.m);
    for (size_t i = 0; i < pixels; i++)
        rate.m[i] = i % 2 ? 1.0f : 0.5f;
    for (int slowed = 0; slowed < 2; slowed++) {
        struct quilt_taker taker = quilt_taker_make(&config, N);
        json_t *root, *seams;

        config.rate = slowed ? &rate : NULL;
        quilt_run_ok(&config, input.sequence, NULL, &taker, &report, NULL);
        root = json_of(&report);
        seams = json_object_get(root, "seams");
        assert_true(json_integer_value(json_object_get(seams, "pairs")) > 0);
        assert_int_equal(json_is_null(json_object_get(seams, "excess")), slowed);
        assert_int_equal(json_is_null(json_object_get(seams, "seam_gradient")), slowed);
        json_decref(root);
        quilt_taker_free(&taker);
    }
    ttf_rate_map_free(&rate);
    texture_free(&input);
}

/* Noise in space that does not change in time, but for `moving` pixels that brighten by a code a frame. */
static struct texture_sequence nearly_still(uint32_t moving)
{
    struct texture_sequence input = texture_make(TEXTURE_NOISE, W, H, N);
    size_t frame = (size_t)W * H * 3;

    for (uint32_t t = 1; t < N; t++) {
        memcpy(input.codes + t * frame, input.codes, frame * sizeof(*input.codes));
        for (uint32_t i = 0; i < moving * 3; i++)
            input.codes[t * frame + i] = ttf_srgb8_to_linear16((uint8_t)(100 + t));
    }
    return input;
}

/* The report's temporal coherence of such an input; *ret_output: the output's mean difference. */
static json_t *coherence_of(uint32_t moving, bool per_frame, double *ret_output)
{
    struct texture_sequence input = nearly_still(moving);
    struct ttf_quilt_config config = small_config();
    struct quilt_taker taker = quilt_taker_make(&config, N);
    struct ttf_quilt_report report;
    json_t *root, *coherence;

    config.per_frame = per_frame;
    quilt_run_ok(&config, input.sequence, NULL, &taker, &report, NULL);
    *ret_output = report.output.mean_difference;
    root = json_of(&report);
    coherence = json_incref(json_object_get(root, "temporal_coherence"));
    assert_non_null(coherence);
    json_decref(root);
    quilt_taker_free(&taker);
    texture_free(&input);
    return coherence;
}

/* 0 would call the worst flicker there is perfectly still. */
static void an_input_within_its_noise_leaves_nothing_to_compare_with(void **state)
{
    double output;
    json_t *coherence = coherence_of(40, true, &output);

    (void)state;
    assert_true(output > 10.0);
    assert_true(json_number_value(json_object_get(coherence, "difference_ratio")) > 10.0);
    assert_true(json_is_null(json_object_get(coherence, "difference_ratio_noise_subtracted")));
    json_decref(coherence);
}

static void an_input_that_does_not_change_has_no_ratios(void **state)
{
    static const char *const RATIOS[] = {"difference_ratio", "difference_ratio_noise_subtracted",
                                         "difference_ratio_copied", "second_difference_ratio",
                                         "second_difference_ratio_copied"};

    (void)state;
    for (int per_frame = 0; per_frame < 2; per_frame++) {
        double output;
        json_t *coherence = coherence_of(0, per_frame, &output);

        assert_int_equal(output > 0.0, per_frame);
        for (int i = 0; i < 5; i++)
            assert_true(json_is_null(json_object_get(coherence, RATIOS[i])));
        json_decref(coherence);
    }
}

/* A replay looks for nothing: what its map does not say of how it was found is null, not what was never asked for. */
static void a_replay_reports_no_search_that_never_was(void **state)
{
    static const char *const UNKNOWN[] = {"tolerance", "seed",      "metric",  "mirror",
                                          "flips",     "rotations", "avoid_px"};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct texture_sequence few = texture_make(TEXTURE_SPOTS, W, H, 3);
    struct ttf_quilt_config config = small_config(), again = small_config();
    struct quilt_taker taker = quilt_taker_make(&config, N),
                       taker_few = quilt_taker_make(&config, 3);
    struct ttf_quilt_report found, replayed;
    struct ttf_quilt_map map;
    json_t *root, *parameters;

    (void)state;
    config.seed = 7;
    config.mirror = true;
    quilt_run_ok(&config, input.sequence, NULL, &taker, &found, &map);
    again.replay = &map;
    quilt_run_ok(&again, few.sequence, NULL, &taker_few, &replayed, NULL);
    assert_true(found.mean_rms_error > 0.0);
    assert_true(replayed.mean_rms_error == found.mean_rms_error);
    assert_true(replayed.max_rms_error == found.max_rms_error);
    root = json_of(&replayed);
    parameters = json_object_get(root, "parameters");
    for (size_t i = 0; i < sizeof(UNKNOWN) / sizeof(*UNKNOWN); i++)
        assert_true(json_is_null(json_object_get(parameters, UNKNOWN[i])));
    assert_true(json_is_array(json_object_get(parameters, "block")));
    json_decref(root);
    map.frames = map.block_width = map.block_height = 0; /* an older file */
    quilt_run_ok(&again, few.sequence, NULL, &taker_few, &replayed, NULL);
    root = json_of(&replayed);
    assert_true(json_is_null(json_object_get(json_object_get(root, "blocks"), "mean_rms_error")));
    assert_true(json_is_null(json_object_get(json_object_get(root, "parameters"), "block")));
    json_decref(root);
    ttf_quilt_map_free(&map);
    quilt_taker_free(&taker);
    quilt_taker_free(&taker_few);
    texture_free(&input);
    texture_free(&few);
}

/* A map of a run at a pace of its own lays the same frames again, without being told the pace. */
static void a_replay_goes_at_its_maps_pace(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config(), again = small_config();
    struct ttf_rate_map rate = {config.width, config.height, NULL};
    size_t pixels = (size_t)config.width * config.height;
    struct quilt_taker taker = quilt_taker_make(&config, N), twice = quilt_taker_make(&config, N);
    struct ttf_quilt_report report;
    struct ttf_quilt_map map;

    (void)state;
    rate.m = malloc(pixels * sizeof(*rate.m));
    assert_non_null(rate.m);
    for (size_t i = 0; i < pixels; i++)
        rate.m[i] = (float)(i % config.width) / (float)(config.width - 1);
    config.rate = &rate;
    config.jitter_frames = 2;
    config.jitter_every = 4;
    config.jitter_round = true;
    quilt_run_ok(&config, input.sequence, NULL, &taker, &report, &map);
    again.replay = &map;
    quilt_run_ok(&again, input.sequence, NULL, &twice, &report, NULL);
    assert_memory_equal(taker.codes, twice.codes, N * taker.frame * sizeof(*taker.codes));
    assert_true(report.config.rate && report.config.jitter_round);
    for (size_t i = 0; i < pixels; i++)
        rate.m[i] = 1.0f;
    again.rate = &rate; /* a caller's own pace goes before */
    quilt_run_ok(&again, input.sequence, NULL, &twice, &report, NULL);
    assert_memory_not_equal(taker.codes, twice.codes, N * taker.frame * sizeof(*taker.codes));
    ttf_rate_map_free(&rate);
    ttf_quilt_map_free(&map);
    quilt_taker_free(&taker);
    quilt_taker_free(&twice);
    texture_free(&input);
}

/* Each frame has blocks of its own: the table would else be taken for that of all. */
static void figures_of_frames_quilted_alone_say_of_which_frame_they_are(void **state)
{
    static const char *const TABLES[] = {"blocks", "repetition", "seams"};
    static const json_int_t FRAMES[] = {0, 0, 23}; /* seams: the last of 16 that are looked at */
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct quilt_taker taker = quilt_taker_make(&config, N);
    struct ttf_quilt_report report;

    (void)state;
    for (int per_frame = 0; per_frame < 2; per_frame++) {
        json_t *root;

        config.per_frame = per_frame;
        quilt_run_ok(&config, input.sequence, NULL, &taker, &report, NULL);
        root = json_of(&report);
        for (int i = 0; i < 3; i++) {
            const json_t *of = json_object_get(json_object_get(root, TABLES[i]), "of_frame");

            assert_int_equal(json_is_integer(of), per_frame);
            assert_int_equal(json_integer_value(of), per_frame ? FRAMES[i] : 0);
        }
        json_decref(root);
    }
    quilt_taker_free(&taker);
    texture_free(&input);
}

static void odd_inputs_have_defined_reports(void **state)
{
    static const uint32_t lengths[] = {1, 2, 3};
    static const enum texture textures[] = {TEXTURE_CONSTANT, TEXTURE_SPOTS};

    (void)state;
    for (int i = 0; i < 6; i++) {
        struct texture_sequence input = texture_make(textures[i % 2], W, H, lengths[i / 2]);
        struct ttf_quilt_config config = small_config();
        struct quilt_taker taker = quilt_taker_make(&config, lengths[i / 2]);
        struct ttf_quilt_report report;

        config.jitter_frames = 2;
        config.agreement_queries = 4;
        quilt_run_ok(&config, input.sequence, NULL, &taker, &report, NULL);
        json_decref(json_of(&report)); /* no NaN anywhere */
        config.jitter_frames = config.agreement_queries = 0;
        config.per_frame = true;
        quilt_run_ok(&config, input.sequence, NULL, &taker, &report, NULL);
        json_decref(json_of(&report));
        quilt_taker_free(&taker);
        texture_free(&input);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(measured_runs_are_16_bit_and_threads_change_no_figure),
        cmocka_unit_test(copies_at_their_own_time_are_exactly_as_active),
        cmocka_unit_test(figures_are_of_what_was_put_out),
        cmocka_unit_test(jitter_takes_repeated_blocks_out_of_step),
        cmocka_unit_test(without_measuring_the_report_has_no_figures_of_frames),
        cmocka_unit_test(seams_of_a_slowed_output_are_unknown_rather_than_none),
        cmocka_unit_test(an_input_within_its_noise_leaves_nothing_to_compare_with),
        cmocka_unit_test(an_input_that_does_not_change_has_no_ratios),
        cmocka_unit_test(a_replay_reports_no_search_that_never_was),
        cmocka_unit_test(a_replay_goes_at_its_maps_pace),
        cmocka_unit_test(figures_of_frames_quilted_alone_say_of_which_frame_they_are),
        cmocka_unit_test(odd_inputs_have_defined_reports),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
