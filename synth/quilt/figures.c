/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/figures.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "metrics/activity.h"
#include "quilt/compose.h"
#include "search/second_differences.h"
#include "ttf/synth/likeness.h"

/* Frames that seams are measured on, evenly spread. */
#define SEAM_FRAMES 16u

#define SYNCHRONY_PAIRS 2048u

struct ttf_figures {
    const struct ttf_quilt_config *config;
    const struct ttf_sources *sources;
    const struct ttf_quilt_map *map;
    uint32_t frames;
    struct ttf_activity *in[TTF_QUILT_INPUTS_MAX], *out;
    struct ttf_activity
        *plain; /* of what was copied, without jitter and feathering; NULL: slowed or per frame */
    /* display codes of a frame: of the sources, and of the output */
    uint8_t *table, *source8, *output8;
    struct ttf_second_differences noise; /* of the sources, over all frames */
    struct ttf_seams *seams;
    struct ttf_seams_figures last_seams;
    uint32_t last_seams_at;
    struct ttf_colour_distance *colour;
    struct ttf_synchrony *synchrony;
    unsigned n_colour;
    uint32_t colour_at[TTF_REPORT_TIMES];
    double colour_distance[TTF_REPORT_TIMES];
};

int ttf_figures_create(const struct ttf_quilt_config *config, const struct ttf_sources *sources,
                       uint32_t frames, struct ttf_figures **ret)
{
    const struct ttf_encoding *encoding = &sources->list[0]->encoding;
    struct ttf_figures *f = calloc(1, sizeof(*f));
    bool ok;

    if (!f)
        return -ENOMEM;
    f->config = config;
    f->sources = sources;
    f->frames = frames;
    f->out = ttf_activity_create(config->width, config->height, encoding);
    f->colour = ttf_colour_distance_create(encoding);
    ok = f->out && f->colour;
    for (unsigned i = 0; i < sources->n; i++) {
        f->in[i] = ttf_activity_create(sources->list[i]->width, sources->list[i]->height, encoding);
        ok = ok && f->in[i] && ttf_activity_keep_pixels(f->in[i]) == 0;
    }
    f->table = malloc(65536);
    f->source8 = malloc((size_t)sources->pixels * 3);
    f->output8 = malloc((size_t)config->width * config->height * 3);
    ok = ok && f->table && f->source8 && f->output8;
    if (ok)
        ttf_display8_table(encoding, f->table);
    if (!ok) {
        ttf_figures_destroy(f);
        return -ENOMEM;
    }
    *ret = f;
    return 0;
}

void ttf_figures_destroy(struct ttf_figures *figures)
{
    if (!figures)
        return;
    for (unsigned i = 0; i < TTF_QUILT_INPUTS_MAX; i++)
        ttf_activity_destroy(figures->in[i]);
    ttf_activity_destroy(figures->out);
    ttf_activity_destroy(figures->plain);
    free(figures->table);
    free(figures->source8);
    free(figures->output8);
    ttf_seams_destroy(figures->seams);
    ttf_colour_distance_destroy(figures->colour);
    ttf_synchrony_destroy(figures->synchrony);
    free(figures);
}

size_t ttf_figures_bytes(const struct ttf_figures *f)
{
    size_t in = f->sources->pixels, out = (size_t)f->config->width * f->config->height;

    /* frames as 8-bit codes, sums over 4 x 4 pixels, sums of pixels */
    return in * 11 + out * (f->plain ? 11 : 7);
}

/* What the output would be if it were copied at its own time and nothing else: often it is. */
static int watch_plain(struct ttf_figures *f, const struct ttf_quilt_map *map)
{
    if (f->config->rate)
        return 0;
    f->plain = ttf_activity_create(map->width, map->height, &f->sources->list[0]->encoding);
    return f->plain ? 0 : -ENOMEM;
}

int ttf_figures_map(struct ttf_figures *f, const struct ttf_quilt_map *map)
{
    const struct ttf_encoding *encoding = &f->sources->list[0]->encoding;

    f->map = map;
    ttf_seams_destroy(f->seams);
    f->seams = ttf_seams_create(map, encoding);
    if (!f->seams)
        return -ENOMEM;
    if (f->config->per_frame || f->synchrony)
        return 0;
    f->synchrony = ttf_synchrony_create(map->source, (size_t)map->width * map->height,
                                        SYNCHRONY_PAIRS, f->config->seed, encoding);
    return f->synchrony ? watch_plain(f, map) : -ENOMEM;
}

/* Each of the first frames of `parts` equal parts. */
static bool is_one_of(uint32_t t, uint32_t frames, uint32_t parts)
{
    uint32_t n = frames < parts ? frames : parts;

    return t == 0 || (uint64_t)t * n / frames != (uint64_t)(t - 1) * n / frames;
}

static void add_colours(struct ttf_figures *f, uint32_t t, const uint16_t *source,
                        const uint16_t *output, struct ttf_pool *pool)
{
    double distance;

    if (f->config->rate || !is_one_of(t, f->frames, TTF_REPORT_TIMES))
        return;
    distance = ttf_colour_distance_add(f->colour, pool, source, f->sources->pixels, output,
                                       (size_t)f->config->width * f->config->height);
    if (f->n_colour < TTF_REPORT_TIMES) {
        f->colour_at[f->n_colour] = t;
        f->colour_distance[f->n_colour++] = distance;
    }
}

static void encode(const struct ttf_figures *f, const uint16_t *codes, size_t n, uint8_t *ret)
{
    for (size_t i = 0; i < n; i++)
        ret[i] = f->table[codes[i]];
}

/* The output is measured as it came, what was copied by copying anew: neither takes the other's word. */
static void add_activity(struct ttf_figures *f, const uint16_t *source, const uint16_t *output,
                         struct ttf_pool *pool)
{
    uint32_t height = f->map->height;

    if (source) {
        encode(f, source, (size_t)f->sources->pixels * 3, f->source8);
        ttf_second_differences_add(&f->noise, f->source8, f->sources->pixels);
    }
    for (unsigned i = 0; source && i < f->sources->n; i++)
        ttf_activity_add8(f->in[i], pool, f->source8 + (size_t)f->sources->first[i] * 3);
    if (source && f->plain) {
        ttf_compose_rows8(f->map, f->source8, 0, height, f->output8);
        ttf_activity_add8(f->plain, pool, f->output8);
    }
    encode(f, output, (size_t)f->config->width * height * 3, f->output8);
    ttf_activity_add8(f->out, pool, f->output8);
}

void ttf_figures_add(struct ttf_figures *f, uint32_t t, const uint16_t *source,
                     const uint16_t *output, struct ttf_pool *pool)
{
    add_activity(f, source, output, pool);
    if (f->synchrony)
        ttf_synchrony_add(f->synchrony, output);
    if (!source)
        return;
    /* seams are told from steps that pixels made in the source at the same time */
    if (is_one_of(t, f->frames, SEAM_FRAMES) && !f->config->rate) {
        ttf_seams_add(f->seams, source, output);
        if (f->config->per_frame) {
            ttf_seams_figures(f->seams, &f->last_seams);
            f->last_seams_at = t;
        }
    }
    add_colours(f, t, source, output, pool);
}

/* NAN of nothing: 0 would read as perfectly still. */
static double ratio(double a, double b)
{
    return b > 0.0 ? a / b : (double)NAN;
}

/* Activity of the source pixels, each counted as often as it was copied, over all frames. */
static double copied_difference(const struct ttf_figures *f, const struct ttf_quilt_map *map)
{
    size_t pixels = (size_t)map->width * map->height;
    uint64_t sum = 0;

    for (size_t i = 0; i < pixels; i++) {
        unsigned input = map->blocks[map->owner[i]].input;

        sum += ttf_activity_pixels(f->in[input])[map->source[i] - f->sources->first[input]];
    }
    return f->sources->frames < 2 ? 0.0
                                  : (double)sum / (3.0 * (double)pixels * (f->sources->frames - 1));
}

/* All inputs together, weighted by their pixels. */
static void input_activity(const struct ttf_figures *f, struct ttf_activity_figures *ret)
{
    memset(ret, 0, sizeof(*ret));
    for (unsigned i = 0; i < f->sources->n; i++) {
        const struct ttf_sequence *input = f->sources->list[i];
        double share = (double)input->width * input->height / f->sources->pixels;
        struct ttf_activity_figures own;

        ttf_activity_figures(f->in[i], &own);
        ret->frames = own.frames;
        ret->mean_difference += share * own.mean_difference;
        ret->second_difference += share * own.second_difference;
        for (int c = 0; c < 3; c++)
            ret->mean_rgb[c] += share * own.mean_rgb[c];
    }
}

/* Two frames of the same thing differ by 2 sigma / sqrt(pi) on average: taken off in quadrature. */
static double without_noise(double difference, double noise_variance)
{
    double square = difference * difference - 4.0 * noise_variance / 3.14159265358979323846;

    return square > 0.0 ? sqrt(square) : 0.0;
}

static void finish_coherence(const struct ttf_figures *f, const struct ttf_quilt_map *map,
                             struct ttf_quilt_report *report)
{
    double noise = ttf_second_differences_noise(f->noise.counts);

    input_activity(f, &report->input);
    ttf_activity_figures(f->out, &report->output);
    report->coherence = ratio(report->output.mean_difference, report->input.mean_difference);
    report->coherence_noise_free = ratio(without_noise(report->output.mean_difference, noise),
                                         without_noise(report->input.mean_difference, noise));
    report->flicker = ratio(report->output.second_difference, report->input.second_difference);
    report->coherence_copied = report->flicker_copied = (double)NAN;
    if (f->config->per_frame || f->config->rate)
        return;
    report->coherence_copied = ratio(report->output.mean_difference, copied_difference(f, map));
    ttf_activity_figures(f->plain, &report->copied);
    report->flicker_copied =
        ratio(report->output.second_difference, report->copied.second_difference);
}

int ttf_figures_finish(struct ttf_figures *f, const struct ttf_quilt_map *map,
                       struct ttf_quilt_report *report)
{
    struct ttf_synchrony_figures synchrony = {0};

    finish_coherence(f, map, report);
    if (f->config->per_frame)
        report->seams = f->last_seams;
    report->seams_of_frame = f->last_seams_at;
    if (!f->config->per_frame)
        ttf_seams_figures(f->seams, &report->seams);
    ttf_colour_distance_figures(f->colour, &report->colour);
    report->n_colour = f->n_colour;
    memcpy(report->colour_at, f->colour_at, sizeof(f->colour_at));
    memcpy(report->colour_distance, f->colour_distance, sizeof(f->colour_distance));
    if (f->synchrony)
        ttf_synchrony_figures(f->synchrony, &synchrony);
    report->synchrony_pairs = synchrony.pairs;
    report->synchrony = synchrony.synchrony;
    return ttf_repetition_of_map(map, &report->repetition);
}
