/* SPDX-License-Identifier: Apache-2.0 */
#include "search/matching.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "search/lanes.h"
#include "search/learner.h"
#include "search/rank_kernels.h"
#include "search/trajectories.h"

#define TILE        4096u
#define SPARE       8 /* columns kept beyond k, so that what a batch drops is not missed later */
#define NUMBERS_MAX (3 * TTF_QUILT_RANK_MAX)

static unsigned room_of(const struct ttf_quilt_config *config)
{
    unsigned k = config->rank_error > 0.0 ? TTF_QUILT_RANK_MAX : config->rank;

    return (k + SPARE + 7) / 8 * 8;
}

size_t ttf_matching_bytes(size_t pixels, unsigned rank, bool per_channel)
{
    unsigned room = (rank + SPARE + 7) / 8 * 8, factors = per_channel ? 3 : 1;
    unsigned stride = (rank * factors + TTF_COEF_LANES - 1) / TTF_COEF_LANES * TTF_COEF_LANES;

    return pixels * (factors * room * sizeof(float) + stride * sizeof(int16_t));
}

/* ---- the choice of k ---- */

/* e_k of all factorisations together, when each keeps k. */
static double error_of(const struct ttf_factors *factors, unsigned n, unsigned k)
{
    double missed = 0.0, energy = 0.0;

    for (unsigned i = 0; i < n; i++) {
        missed += ttf_factors_missed(&factors[i], k);
        energy += ttf_factors_energy(&factors[i]);
    }
    return energy > 0.0 ? sqrt(missed / energy) : 0.0;
}

static void fill_figures(const struct ttf_factors *factors, unsigned n, unsigned k,
                         struct ttf_quilt_rank_figures *ret)
{
    double missed = 0.0, samples = 0.0;
    unsigned most = factors->room - 1 < TTF_QUILT_RANK_MAX ? factors->room - 1 : TTF_QUILT_RANK_MAX;

    for (unsigned i = 0; i < n; i++) {
        missed += ttf_factors_missed(&factors[i], k);
        samples +=
            (double)factors[i].pixels * factors[i].frames * (factors[i].channel < 0 ? 3.0 : 1.0);
    }
    *ret = (struct ttf_quilt_rank_figures){.rank = k,
                                           .numbers = n * k,
                                           .error = error_of(factors, n, k),
                                           .rms = sqrt(missed / samples) / 255.0,
                                           .n_errors = most + 1};
    for (unsigned i = 0; i <= most; i++)
        ret->errors[i] = error_of(factors, n, i);
}

static unsigned choose_rank(const struct ttf_quilt_config *config,
                            const struct ttf_factors *factors, unsigned n)
{
    unsigned k = 1;

    if (!(config->rank_error > 0.0))
        return config->rank;
    while (k < TTF_QUILT_RANK_MAX && error_of(factors, n, k) > config->rank_error)
        k++;
    return k;
}

/* ---- quantisation ---- */

struct column {
    const struct ttf_factors *factors;
    unsigned index;
    double strength, mean;
};

struct quantise {
    struct ttf_matching *out;
    const struct column *columns;
    float *largest; /* per tile, of all columns */
    const struct ttf_factors *factors;
    unsigned n_factors;
};

static int by_strength(const void *a, const void *b)
{
    const struct column *x = a, *y = b;

    if (x->strength != y->strength)
        return x->strength > y->strength ? -1 : 1;
    if (x->factors != y->factors)
        return x->factors > y->factors ? 1 : -1;
    return (x->index > y->index) - (x->index < y->index);
}

static float at(const struct column *column, size_t pixel)
{
    return column->factors->coefs[pixel * column->factors->room + column->index];
}

static void find_largest(void *ctx, unsigned tile, unsigned worker)
{
    const struct quantise *q = ctx;
    size_t from = (size_t)tile * TILE;
    size_t to = from + TILE < q->out->pixels ? from + TILE : q->out->pixels;
    float largest = 0.0f;

    (void)worker;
    for (unsigned c = 0; c < q->out->k; c++) {
        for (size_t p = from; p < to; p++) {
            float off = fabsf(at(&q->columns[c], p) - (float)q->columns[c].mean);

            largest = off > largest ? off : largest;
        }
    }
    q->largest[tile] = largest;
}

static float missed_of(const struct quantise *q, size_t pixel)
{
    double missed = 0.0;

    for (unsigned i = 0; i < q->n_factors; i++)
        missed += (double)q->factors[i].energy[pixel];
    for (unsigned c = 0; c < q->out->k; c++)
        missed -= (double)at(&q->columns[c], pixel) * (double)at(&q->columns[c], pixel);
    return missed > 0.0 ? (float)missed : 0.0f;
}

static void quantise_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct quantise *q = ctx;
    size_t from = (size_t)tile * TILE;
    size_t to = from + TILE < q->out->pixels ? from + TILE : q->out->pixels;
    float scale = (float)q->out->scale;

    (void)worker;
    for (size_t p = from; p < to; p++) {
        int16_t *coefs = q->out->coefs + p * q->out->stride;

        for (unsigned c = 0; c < q->out->k; c++) {
            float value = (at(&q->columns[c], p) - (float)q->columns[c].mean) * scale;

            /* the addition rounds: the value lies far within 2^22 */
            coefs[c] = (int16_t)((value + 12582912.0f) - 12582912.0f);
        }
        q->out->missed[p] = missed_of(q, p);
    }
}

static double mean_of(const struct column *column, size_t pixels)
{
    double sum = 0.0;

    for (size_t p = 0; p < pixels; p++)
        sum += at(column, p);
    return sum / (double)pixels;
}

static void mean_column(void *ctx, unsigned tile, unsigned worker)
{
    struct quantise *q = ctx;
    struct column *columns = (struct column *)q->columns;

    (void)worker;
    columns[tile].mean = mean_of(&columns[tile], q->out->pixels);
}

int ttf_matching_of_factors(const struct ttf_factors *factors, unsigned n, unsigned k, double noise,
                            struct ttf_pool *pool, struct ttf_matching *ret, struct ttf_err *err)
{
    struct ttf_matching out = {.pixels = factors->pixels, .k = n * k, .scale = 1.0, .noise = noise};
    unsigned tiles = (unsigned)((out.pixels + TILE - 1) / TILE);
    struct column columns[NUMBERS_MAX];
    struct quantise q = {&out, columns, calloc((size_t)tiles + 1, sizeof(float)), factors, n};
    float largest = 0.0f;

    out.stride = (out.k + TTF_COEF_LANES - 1) / TTF_COEF_LANES * TTF_COEF_LANES;
    out.coefs = ttf_lanes_alloc(out.pixels * out.stride + TTF_COEF_LANES);
    out.missed = calloc(out.pixels + 1, sizeof(*out.missed));
    if (!out.coefs || !out.missed || !q.largest) {
        ttf_matching_free(&out);
        free(q.largest);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to match %zu pixels", out.pixels);
    }
    for (unsigned i = 0; i < out.k; i++)
        columns[i] = (struct column){
            .factors = &factors[i / k], .index = i % k, .strength = factors[i / k].singular[i % k]};
    qsort(columns, out.k, sizeof(*columns), by_strength);
    ttf_pool_run(pool, out.k, mean_column, &q);
    ttf_pool_run(pool, tiles, find_largest, &q);
    for (unsigned i = 0; i < tiles; i++)
        largest = q.largest[i] > largest ? q.largest[i] : largest;
    if (largest > 0.0f)
        out.scale = (TTF_COEF_MAX - 0.5) / (double)largest;
    ttf_pool_run(pool, tiles, quantise_tile, &q);
    fill_figures(factors, n, k, &out.figures);
    free(q.largest);
    *ret = out;
    return 0;
}

/* ---- all of it ---- */

static int learn(const struct ttf_quilt_config *config, const struct ttf_sources *sources,
                 uint32_t first, uint32_t frames, const struct ttf_aside *aside,
                 struct ttf_pool *pool, struct ttf_learner *learner, struct ttf_err *err)
{
    uint8_t *table = malloc(65536);
    uint32_t from = first;
    int r;

    if (!table)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    ttf_metric_table(config->metric, &sources->list[0]->encoding, table);
    if (config->known.bytes && !config->per_frame) {
        r = ttf_learner_unpack(&config->known, sources, room_of(config), config->per_channel,
                               config->metric, table, learner, err);
        from += learner->known;
    } else {
        r = ttf_learner_create(sources->pixels, room_of(config), config->per_channel, learner);
        if (r < 0)
            ttf_err_set(err, r, NULL, "no memory for the factors of %u pixels", sources->pixels);
    }
    if (r == 0)
        r = ttf_learner_add(learner, sources, from, first + frames, table, aside, config->cancel,
                            pool, err);
    free(table);
    return r;
}

int ttf_quilt_factors_check(const struct ttf_quilt_config *config, struct ttf_sequence *input,
                            bool *ret_other, struct ttf_err *err)
{
    struct ttf_sources sources;
    struct ttf_learner learner = {0};
    uint8_t *table;
    int r = ttf_sources_of(config, input, &sources, err);

    *ret_other = false;
    if (r < 0 || !config->known.bytes || config->per_frame)
        return r;
    table = malloc(65536);
    if (!table)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    ttf_metric_table(config->metric, &sources.list[0]->encoding, table);
    r = ttf_learner_unpack(&config->known, &sources, room_of(config), config->per_channel,
                           config->metric, table, &learner, err);
    *ret_other = r == -EINVAL && ttf_learner_is_of_other(&config->known, &sources, room_of(config),
                                                         config->per_channel, config->metric);
    ttf_learner_free(&learner);
    free(table);
    return r;
}

static int keep(const struct ttf_quilt_config *config, const struct ttf_learner *learner,
                struct ttf_err *err)
{
    struct ttf_quilt_factors packed;
    int r;

    if (!config->keep_factors || config->per_frame)
        return 0;
    r = ttf_learner_pack(learner, config->metric, &packed);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "no memory to keep the factors");
    r = config->keep_factors(config->keep_ctx, &packed);
    free((void *)packed.bytes);
    return r < 0 ? ttf_err_set(err, r, "factors", "could not be kept") : 0;
}

int ttf_matching_build(const struct ttf_quilt_config *config, const struct ttf_sources *sources,
                       uint32_t first, uint32_t frames, const struct ttf_aside *aside,
                       struct ttf_pool *pool, struct ttf_matching *ret, struct ttf_err *err)
{
    struct ttf_learner learner = {0};
    double noise;
    int r = learn(config, sources, first, frames, aside, pool, &learner, err);

    if (r == 0)
        r = keep(config, &learner, err);
    if (r == 0) {
        noise = ttf_second_differences_noise(learner.noise.counts);
        r = ttf_matching_of_factors(learner.factors, learner.n_factors,
                                    choose_rank(config, learner.factors, learner.n_factors), noise,
                                    pool, ret, err);
    }
    if (r == 0)
        ret->figures.known_frames = learner.known;
    ttf_learner_free(&learner);
    return r;
}

void ttf_matching_free(struct ttf_matching *matching)
{
    ttf_lanes_free(matching->coefs);
    free(matching->missed);
    memset(matching, 0, sizeof(*matching));
}
