/* SPDX-License-Identifier: Apache-2.0 */
/* Frames whose pixels are of different times (eq. 6 to 8), against one pixel at a time. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/time_jitter.h"
#include "quilt/timed.h"
#include "quilts.h"
#include "search/sources.h"

#define W 40u
#define H 36u
#define N 11u

static struct ttf_quilt_config small_config(void)
{
    struct ttf_quilt_config config;

    ttf_quilt_defaults(&config);
    config.width = 61;
    config.height = 47;
    config.block_width = config.block_height = 18;
    config.jitter_every = 1;
    return config;
}

static struct ttf_rate_map rates_make(const struct ttf_quilt_config *config, const float *rates,
                                      unsigned n)
{
    struct ttf_rate_map map = {.width = config->width, .height = config->height};
    size_t pixels = (size_t)map.width * map.height;

    map.m = malloc(pixels * sizeof(*map.m));
    assert_non_null(map.m);
    for (size_t i = 0; i < pixels; i++)
        map.m[i] = rates[texture_hash((uint32_t)i, 8, 8) % n];
    return map;
}

/* ---- one pixel at a time ---- */

struct plain {
    const struct ttf_quilt_config *config;
    const struct ttf_quilt_map *map;
    const struct texture_sequence *inputs; /* one, or two */
};

static uint16_t code_of(const struct plain *p, uint32_t id, uint32_t frame, int c)
{
    unsigned which = p->map->n_inputs > 1 && id >= p->map->inputs[1].first;
    const struct ttf_quilt_input *input = &p->map->inputs[which];
    size_t pixels = (size_t)input->width * input->height;

    return p->inputs[which].codes[(frame * pixels + id - input->first) * 3 + (size_t)c];
}

static uint16_t mixed(uint16_t a, uint16_t b, uint32_t weight)
{
    return (uint16_t)floor(((double)a * (65536.0 - weight) + (double)b * weight) / 65536.0 + 0.5);
}

/* Source time in frames x 65536: f(t M), clamped, rounded where asked. */
static uint32_t time_of(const struct plain *p, uint32_t t, size_t pixel, uint32_t block)
{
    double last = (N - 1.0) * 65536.0, time = t * 65536.0;

    if (p->config->rate)
        time = floor(time * (double)p->config->rate->m[pixel] + 0.5);
    time = time < last ? time : last;
    if (p->map->times) {
        const uint32_t *f = p->map->times + (size_t)block * N;
        uint32_t frame = (uint32_t)(time / 65536.0);
        double part = time / 65536.0 - frame;

        time = f[frame] + (part > 0.0 ? floor((f[frame + 1] - f[frame]) * part) : 0.0);
        time = time < last ? time : last;
    }
    if (p->config->jitter_round)
        time = floor(time / 65536.0 + 0.5) * 65536.0;
    return (uint32_t)time;
}

static uint16_t at_own_time(const struct plain *p, uint32_t id, uint32_t time, int c)
{
    uint32_t frame = time / 65536, part = time % 65536;
    uint16_t code = code_of(p, id, frame, c);

    return part > 0 ? mixed(code, code_of(p, id, frame + 1, c), part) : code;
}

static void plain_frame(const struct plain *p, uint32_t t, uint16_t *dst)
{
    const struct ttf_quilt_map *map = p->map;

    for (size_t i = 0; i < (size_t)map->width * map->height; i++) {
        for (int c = 0; c < 3; c++)
            dst[3 * i + (size_t)c] =
                at_own_time(p, map->source[i], time_of(p, t, i, map->owner[i]), c);
    }
    for (size_t i = 0; i < map->n_layers; i++) {
        const struct ttf_quilt_layer *layer = &map->layers[i];
        uint16_t *at = dst + 3ul * layer->pixel;

        for (int c = 0; c < 3; c++)
            at[c] = mixed(
                at[c], at_own_time(p, layer->source, time_of(p, t, layer->pixel, layer->block), c),
                layer->weight);
    }
}

/* All output frames with all windows: so small that every frame takes several passes, and roomy. */
static void matches_plain(const struct ttf_quilt_config *config,
                          const struct texture_sequence *inputs)
{
    static const size_t windows[] = {0, 5ul * 3300 * 6, (size_t)1 << 30};
    size_t codes = (size_t)config->width * config->height * 3;
    uint16_t *want = malloc(codes * sizeof(*want)), *got = malloc(codes * sizeof(*got));
    struct ttf_pool *pool = ttf_pool_create(3);
    struct ttf_sources sources;
    struct ttf_quilt_map map;
    struct plain plain = {config, &map, inputs};
    uint32_t frames;

    assert_true(want && got && pool);
    quilt_plan_ok(config, inputs[0].sequence, pool, &map);
    assert_int_equal(ttf_sources_of(config, inputs[0].sequence, &sources, NULL), 0);
    assert_int_equal(ttf_quilt_output_frames(config, N, &frames, NULL), 0);
    for (int w = 0; w < 3; w++) {
        struct ttf_timed *timed;

        assert_int_equal(ttf_timed_create(config, &map, &sources, windows[w], &timed), 0);
        for (uint32_t t = 0; t < frames; t++) {
            memset(got, 0xa5, codes * sizeof(*got));
            plain_frame(&plain, t, want);
            assert_int_equal(ttf_timed_frame(timed, t, w ? pool : NULL, got, NULL), 0);
            assert_memory_equal(got, want, codes * sizeof(*got));
        }
        assert_int_equal(ttf_timed_frame(timed, 2, pool, got, NULL), 0); /* in any order */
        plain_frame(&plain, 2, want);
        assert_memory_equal(got, want, codes * sizeof(*got));
        ttf_timed_destroy(timed);
    }
    ttf_quilt_map_free(&map);
    ttf_pool_destroy(pool);
    free(want);
    free(got);
}

static void jittered_frames_are_those_of_the_plainest_implementation(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_NOISE, W, H, N);
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.jitter_frames = 3;
    matches_plain(&config, &input);
    config.feather_px = 3;
    matches_plain(&config, &input);
    config.jitter_round = true;
    matches_plain(&config, &input);
    config.jitter_round = false;
    config.jitter_every = 3;
    matches_plain(&config, &input);
    config.jitter_frames = 1000; /* farther than there are frames */
    matches_plain(&config, &input);
    texture_free(&input);
}

static void controlled_frames_are_those_of_the_plainest_implementation(void **state)
{
    static const float rates[][4] = {{0.0f}, {0.5f}, {1.0f}, {2.0f}, {0.0f, 0.31f, 1.0f, 1.7f}};
    struct texture_sequence input = texture_make(TEXTURE_NOISE, W, H, N);
    struct ttf_quilt_config config = small_config();

    (void)state;
    for (int i = 0; i < 5; i++) {
        struct ttf_rate_map map = rates_make(&config, rates[i], i == 4 ? 4 : 1);

        config.rate = &map;
        config.feather_px = i == 4 ? 3 : 0;
        matches_plain(&config, &input);
        config.jitter_frames = 2; /* both at once */
        matches_plain(&config, &input);
        config.jitter_frames = 0;
        config.jitter_round = true; /* whole frames of a slowed output */
        matches_plain(&config, &input);
        config.jitter_round = false;
        ttf_rate_map_free(&map);
    }
    texture_free(&input);
}

static void several_inputs_keep_their_own_pixels(void **state)
{
    struct texture_sequence inputs[2] = {texture_make(TEXTURE_NOISE, W, H, N),
                                         texture_make(TEXTURE_SPOTS, 50, 30, N)};
    struct ttf_quilt_config config = small_config();

    (void)state;
    config.more = &inputs[1].sequence;
    config.n_more = 1;
    config.jitter_frames = 2;
    config.feather_px = 2;
    config.tileable = true;
    matches_plain(&config, inputs);
    texture_free(&inputs[0]);
    texture_free(&inputs[1]);
}

/* ---- whole runs ---- */

static void a_slower_pixel_lags(void **state)
{
    struct texture_sequence input = texture_make(TEXTURE_NOISE, W, H, N);
    struct ttf_quilt_config config = small_config();
    struct ttf_rate_map rates = rates_make(&config, (const float[]){1.0f}, 1);
    struct ttf_quilt_report report;
    struct ttf_quilt_map map;
    struct quilt_taker taker;
    uint32_t frames;

    (void)state;
    for (size_t i = 0; i < (size_t)rates.width * rates.height; i++)
        rates.m[i] = i % rates.width < 30 ? 0.25f : 0.5f;
    config.rate = &rates;
    assert_int_equal(ttf_quilt_output_frames(&config, N, &frames, NULL), 0);
    assert_int_equal(frames, 2 * (N - 1) + 1); /* by the fastest pixel */
    taker = quilt_taker_make(&config, frames);
    quilt_run_ok(&config, input.sequence, NULL, &taker, &report, &map);
    assert_int_equal(report.out_frames, frames);
    for (uint32_t t = 0; t < frames; t++) {
        for (size_t i = 0; i < (size_t)rates.width * rates.height; i++) {
            bool slow = i % rates.width < 30;
            size_t own = slow ? t / 4 : t / 2;

            if (t % (slow ? 4 : 2) != 0)
                continue;
            assert_memory_equal(taker.codes + t * taker.frame + 3 * i,
                                input.codes + (own * W * H + map.source[i]) * 3, 6);
        }
    }
    ttf_quilt_map_free(&map);
    quilt_taker_free(&taker);
    ttf_rate_map_free(&rates);
    texture_free(&input);
}

static void the_length_of_a_run_is_that_of_the_fastest_pixel(void **state)
{
    static const struct {
        float rates[2];
        uint32_t frames;
    } cases[] = {{{0.0f, 0.0f}, N}, {{0.0f, 2.0f}, 6}, {{1.0f, 3.0f}, 5}, {{0.1f, 0.3f}, 35}};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, N);
    struct ttf_quilt_config config = small_config();

    (void)state;
    for (int i = 0; i < 4; i++) {
        struct ttf_rate_map rates = rates_make(&config, cases[i].rates, 2);
        struct quilt_taker taker;
        struct ttf_quilt_report report;

        config.rate = &rates;
        taker = quilt_taker_make(&config, cases[i].frames);
        quilt_run_ok(&config, input.sequence, NULL, &taker, &report, NULL);
        for (uint32_t t = 1; t < cases[i].frames && cases[i].rates[1] == 0.0f; t++)
            assert_memory_equal(taker.codes, taker.codes + t * taker.frame, taker.frame * 2);
        assert_true(isfinite(report.coherence) && isfinite(report.flicker));
        quilt_taker_free(&taker);
        ttf_rate_map_free(&rates);
    }
    texture_free(&input);
}

static void impossible_times_are_refused_by_name(void **state)
{
    static const struct ttf_sequence_ops none = {0};
    struct ttf_sequence endless = {
        .ops = &none, .width = W, .height = H, .n = 65537, .encoding = texture_encoding};
    struct texture_sequence input = texture_make(TEXTURE_SPOTS, W, H, 3);
    struct ttf_quilt_config config = small_config();
    struct ttf_rate_map rates = rates_make(&config, (const float[]){1.0f}, 1);

    (void)state;
    config.rate = &rates;
    config.per_frame = true;
    quilt_refused(&config, input.sequence, -EINVAL, "per_frame");
    config.rate = NULL;
    config.jitter_frames = 1;
    quilt_refused(&config, input.sequence, -EINVAL, "per_frame");
    config.per_frame = false;
    quilt_refused(&config, &endless, -EINVAL, "jitter");
    config.jitter_frames = (1u << 20) + 1;
    quilt_refused(&config, input.sequence, -EINVAL, "jitter");
    config.jitter_frames = 1;
    config.jitter_every = 0;
    quilt_refused(&config, input.sequence, -EINVAL, "jitter_every");
    config.jitter_every = 1;
    config.jitter_frames = 0;
    config.rate = &rates;
    quilt_refused(&config, &endless, -EINVAL, "rate map");
    rates.width--;
    quilt_refused(&config, input.sequence, -EINVAL, "rate map");
    rates.width++;
    for (size_t i = 0; i < (size_t)rates.width * rates.height; i++)
        rates.m[i] = 1e-9f;
    quilt_refused(&config, input.sequence, -ERANGE, "rate map");
    rates.m[5] = NAN;
    quilt_refused(&config, input.sequence, -EINVAL, "rate map");
    rates.m[5] = INFINITY;
    quilt_refused(&config, input.sequence, -EINVAL, "rate map");
    rates.m[5] = -0.5f;
    quilt_refused(&config, input.sequence, -EINVAL, "rate map");
    ttf_rate_map_free(&rates);
    texture_free(&input);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(jittered_frames_are_those_of_the_plainest_implementation),
        cmocka_unit_test(controlled_frames_are_those_of_the_plainest_implementation),
        cmocka_unit_test(several_inputs_keep_their_own_pixels),
        cmocka_unit_test(a_slower_pixel_lags),
        cmocka_unit_test(the_length_of_a_run_is_that_of_the_fastest_pixel),
        cmocka_unit_test(impossible_times_are_refused_by_name),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
