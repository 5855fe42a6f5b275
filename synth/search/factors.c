/* SPDX-License-Identifier: Apache-2.0 */
#include "search/factors.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "search/eigen.h"
#include "search/factor_kernels.h"
#include "search/hash.h"
#include "search/lanes.h"
#include "search/rank_kernels.h"
#include "ttf/base/checked.h"

#define SAMPLES    2048u
#define ROUNDS     5
#define TILE       2048u /* pixels of one tile */
#define DIMS_MAX   (TTF_FACTORS_ROOM_MAX + 3 * TTF_FACTORS_BATCH)
#define ROW_MAX    (DIMS_MAX + 4) /* kernels write a little more */
#define GRAM_TILES 64             /* at most */

static size_t columns_of(const struct ttf_factors *f, unsigned n)
{
    return f->channel < 0 ? (size_t)3 * n : n;
}

unsigned ttf_factors_tiles(const struct ttf_factors *f)
{
    return (unsigned)((f->pixels + TILE - 1) / TILE);
}

int ttf_factors_create(size_t pixels, unsigned room, int channel, struct ttf_factors *ret)
{
    struct ttf_factors f = {.pixels = pixels, .room = room, .channel = channel};
    size_t dims = room + columns_of(&f, TTF_FACTORS_BATCH), bytes;

    f.n_samples = pixels < SAMPLES ? pixels : SAMPLES;
    if (!ttf_mul_size(pixels, room * sizeof(float), &bytes))
        return -ENOMEM;
    f.coefs = (float *)(void *)ttf_lanes_alloc(bytes / sizeof(int16_t));
    f.singular = calloc(room, sizeof(*f.singular));
    f.w = calloc(dims * room, sizeof(*f.w));
    f.gram = calloc(dims * dims, sizeof(*f.gram));
    f.vector = calloc(2 * room * dims, sizeof(*f.vector));
    f.sample = malloc(f.n_samples * sizeof(*f.sample));
    f.energy = calloc(pixels, sizeof(*f.energy));
    f.tile_energy = calloc(ttf_factors_tiles(&f), sizeof(*f.tile_energy));
    if (!f.coefs || !f.singular || !f.w || !f.gram || !f.vector || !f.sample || !f.tile_energy ||
        !f.energy) {
        ttf_factors_free(&f);
        return -ENOMEM;
    }
    for (size_t s = 0; s < f.n_samples; s++) {
        size_t from = pixels * s / f.n_samples, to = pixels * (s + 1) / f.n_samples;

        f.sample[s] = (uint32_t)(from + ttf_pick(ttf_random64(0, TTF_PURPOSE_BASIS, s),
                                                 (uint32_t)(to - from)));
    }
    *ret = f;
    return 0;
}

void ttf_factors_free(struct ttf_factors *factors)
{
    ttf_lanes_free(factors->coefs);
    free(factors->singular);
    free(factors->w);
    free(factors->gram);
    free(factors->vector);
    free(factors->sample);
    free(factors->tile_energy);
    free(factors->energy);
    memset(factors, 0, sizeof(*factors));
}

/* One pixel's row of [C D]. */
static void row_of(const struct ttf_factors *f, const uint8_t *const *frames, unsigned n,
                   size_t pixel, float *ret)
{
    memcpy(ret, f->coefs + pixel * f->room, f->room * sizeof(*ret));
    ret += f->room;
    if (f->channel >= 0) {
        for (unsigned t = 0; t < n; t++)
            *ret++ = frames[t][3 * pixel + (size_t)f->channel];
        return;
    }
    for (unsigned t = 0; t < n; t++, ret += 3) {
        const uint8_t *codes = frames[t] + 3 * pixel;

        ret[0] = codes[0];
        ret[1] = codes[1];
        ret[2] = codes[2];
    }
}

/* [C D]^T [C D] of the sampled pixels. */
static void sample_gram(struct ttf_factors *f, const uint8_t *const *frames, unsigned n)
{
    const struct ttf_factor_kernels *kernels = ttf_factor_kernels_best();
    size_t dims = f->dims;
    float row[DIMS_MAX];
    double wide[4][DIMS_MAX] = {{0}};

    memset(f->gram, 0, dims * dims * sizeof(*f->gram));
    for (size_t s = 0; s < f->n_samples; s += 4) {
        for (size_t k = 0; k < 4; k++) {
            if (s + k < f->n_samples)
                row_of(f, frames, n, f->sample[s + k], row);
            for (size_t i = 0; i < dims; i++)
                wide[k][i] = s + k < f->n_samples ? row[i] : 0.0; /* adds nothing */
        }
        kernels->add_gram4(wide[0], DIMS_MAX, dims, f->gram);
    }
    for (size_t i = 0; i < dims; i++) {
        for (size_t j = i + 1; j < dims; j++)
            f->gram[i * dims + j] = f->gram[j * dims + i];
    }
}

/* The old directions, and a little of everything, so that nothing new is overlooked. */
static void first_guess(struct ttf_factors *f)
{
    for (size_t k = 0; k < f->room; k++) {
        for (size_t i = 0; i < f->dims; i++) {
            uint64_t random = ttf_random64(1, TTF_PURPOSE_BASIS, k * f->dims + i);

            f->vector[k * f->dims + i] =
                ((double)(random >> 11) / (double)(1ull << 52) - 1.0) * 0.05 + (i == k);
        }
    }
}

void ttf_factors_learn(struct ttf_factors *f, const uint8_t *const *frames, unsigned n)
{
    f->dims = f->room + columns_of(f, n);
    sample_gram(f, frames, n);
    first_guess(f);
    ttf_eigen_iterate(f->gram, f->dims, f->vector, f->room, ROUNDS, f->vector + f->room * f->dims);
    for (size_t i = 0; i < f->dims; i++) {
        for (size_t k = 0; k < f->room; k++)
            f->w[i * f->room + k] = (float)f->vector[k * f->dims + i];
    }
}

struct rotation {
    const struct ttf_factors *factors;
    const uint8_t *const *frames;
    unsigned n;
};

/* A pixel's squared codes: 3 x 16 frames x 255^2 fit 32 bits. */
static uint32_t energy_of(const struct rotation *r, size_t pixel)
{
    int channel = r->factors->channel;
    uint32_t sum = 0;

    for (unsigned t = 0; t < r->n; t++) {
        const uint8_t *codes = r->frames[t] + 3 * pixel;

        for (int c = channel < 0 ? 0 : channel; c < (channel < 0 ? 3 : channel + 1); c++)
            sum += (uint32_t)codes[c] * codes[c];
    }
    return sum;
}

/* Rows of [C D] of up to four pixels, zeros where there are none, and what their codes weigh. */
static void rows_of(const struct rotation *r, size_t pixel, size_t n, float in[4][ROW_MAX],
                    uint32_t energy[4])
{
    const struct ttf_factors *f = r->factors;

    if (n == 4 && f->channel < 0) {
        ttf_factor_kernels_best()->rows4(f->coefs + pixel * f->room, f->room, r->frames, r->n,
                                         pixel, in[0], ROW_MAX, energy);
        return;
    }
    for (size_t i = 0; i < 4; i++) {
        energy[i] = i < n ? energy_of(r, pixel + i) : 0;
        if (i < n)
            row_of(f, r->frames, r->n, pixel + i, in[i]);
        else
            memset(in[i], 0, f->dims * sizeof(in[i][0]));
    }
}

void ttf_factors_rotate(struct ttf_factors *f, const uint8_t *const *frames, unsigned n,
                        unsigned tile)
{
    const struct ttf_rank_kernels *kernels = ttf_rank_kernels_best();
    const struct rotation r = {f, frames, n};
    size_t from = (size_t)tile * TILE;
    size_t to = from + TILE < f->pixels ? from + TILE : f->pixels;
    float in[4][ROW_MAX], out[4 * TTF_FACTORS_ROOM_MAX];

    for (size_t p = from; p < to; p += 4) {
        size_t pixels = to - p < 4 ? to - p : 4;
        uint32_t energy[4];

        rows_of(&r, p, pixels, in, energy);
        kernels->rotate4(f->w, f->dims, f->room, in[0], ROW_MAX, out);
        memcpy(f->coefs + p * f->room, out, pixels * f->room * sizeof(*out));
        for (size_t i = 0; i < pixels; i++) {
            f->energy[p + i] += energy[i];
            f->tile_energy[tile] += energy[i];
        }
    }
}

void ttf_factors_rotated(struct ttf_factors *f, unsigned n)
{
    f->frames += n;
}

/* ---- principal axes ---- */

struct gram {
    const struct ttf_factors *factors;
    size_t pixels; /* of a tile */
    double *parts; /* room x room each */
};

static void gram_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct gram *gram = ctx;
    const struct ttf_factors *f = gram->factors;
    size_t room = f->room, from = tile * gram->pixels;
    size_t to = from + gram->pixels < f->pixels ? from + gram->pixels : f->pixels;
    double *part = gram->parts + tile * room * room;
    double wide[4][TTF_FACTORS_ROOM_MAX];

    (void)worker;
    for (size_t p = from; p < to; p += 4) {
        for (size_t k = 0; k < 4; k++) {
            for (size_t i = 0; i < room; i++)
                wide[k][i] = p + k < to ? f->coefs[(p + k) * room + i] : 0.0; /* adds nothing */
        }
        ttf_factor_kernels_best()->add_gram4(wide[0], TTF_FACTORS_ROOM_MAX, room, part);
    }
}

/* C^T C over all pixels, into the Gram matrix's place; sums in the order of tiles. */
static int whole_gram(struct ttf_factors *f, struct ttf_pool *pool)
{
    size_t room = f->room, tiles;
    struct gram gram = {.factors = f, .pixels = (f->pixels + GRAM_TILES - 1) / GRAM_TILES};

    gram.pixels = gram.pixels > TILE ? gram.pixels : TILE;
    tiles = (f->pixels + gram.pixels - 1) / gram.pixels;
    gram.parts = calloc(tiles * room * room, sizeof(*gram.parts));
    if (!gram.parts)
        return -ENOMEM;
    ttf_pool_run(pool, (unsigned)tiles, gram_tile, &gram);
    memset(f->gram, 0, room * room * sizeof(*f->gram));
    for (size_t i = 0; i < room; i++) {
        for (size_t j = 0; j <= i; j++) {
            for (size_t tile = 0; tile < tiles; tile++)
                f->gram[i * room + j] += gram.parts[(tile * room + i) * room + j];
            f->gram[j * room + i] = f->gram[i * room + j];
        }
    }
    free(gram.parts);
    return 0;
}

static void last_rotation(void *ctx, unsigned tile, unsigned worker)
{
    (void)worker;
    ttf_factors_rotate(ctx, NULL, 0, tile);
}

int ttf_factors_finish(struct ttf_factors *f, struct ttf_pool *pool)
{
    size_t room = f->room;
    int r = whole_gram(f, pool);

    if (r < 0)
        return r;
    ttf_eigen_all(f->gram, room, f->vector, f->singular);
    for (size_t k = 0; k < room; k++) {
        f->singular[k] = f->singular[k] > 0.0 ? sqrt(f->singular[k]) : 0.0;
        for (size_t i = 0; i < room; i++)
            f->w[i * room + k] = (float)f->vector[k * room + i];
    }
    f->dims = room;
    ttf_pool_run(pool, ttf_factors_tiles(f), last_rotation, f);
    return 0;
}

double ttf_factors_energy(const struct ttf_factors *f)
{
    uint64_t sum = 0;

    for (size_t i = 0; i < ttf_factors_tiles(f); i++)
        sum += f->tile_energy[i];
    return (double)sum;
}

double ttf_factors_missed(const struct ttf_factors *f, unsigned k)
{
    double missed = ttf_factors_energy(f);

    for (unsigned i = 0; i < k; i++)
        missed -= f->singular[i] * f->singular[i];
    return missed > 0.0 ? missed : 0.0;
}

double ttf_factors_error(const struct ttf_factors *f, unsigned k)
{
    double energy = ttf_factors_energy(f);

    return energy > 0.0 ? sqrt(ttf_factors_missed(f, k) / energy) : 0.0;
}
