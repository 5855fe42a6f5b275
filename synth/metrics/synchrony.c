/* SPDX-License-Identifier: Apache-2.0 */
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "metrics/samples.h"
#include "ttf/base/checked.h"
#include "ttf/synth/likeness.h"

/* One pair of pixels, and sums over time of their changes: integers, at most 765 each. */
struct pair {
    uint32_t pixel[2];
    uint8_t last[2][3]; /* display codes of the last frame */
    uint64_t sum[2], square[2], product;
};

struct ttf_synchrony {
    unsigned n;
    uint32_t frames;
    struct pair *pairs;
    uint8_t table[65536];
};

static int by_number(const void *a, const void *b)
{
    uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;

    return (x > y) - (x < y);
}

/* Output pixels in the order of what they show: the source pixel above, the output pixel below. */
static uint64_t *sort_by_source(const uint32_t *source, size_t pixels)
{
    uint64_t *sorted;
    size_t bytes;

    if (!ttf_mul_size(pixels, sizeof(*sorted), &bytes))
        return NULL;
    sorted = malloc(bytes + 1);
    if (!sorted)
        return NULL;
    for (size_t i = 0; i < pixels; i++)
        sorted[i] = (uint64_t)source[i] << 32 | i;
    qsort(sorted, pixels, sizeof(*sorted), by_number);
    return sorted;
}

static bool same_source(uint64_t a, uint64_t b)
{
    return a >> 32 == b >> 32;
}

/* Pixels that show what an earlier one shows: as many pairs as can be made without one twice. */
static size_t count_repeated(const uint64_t *sorted, size_t pixels)
{
    size_t n = 0;

    for (size_t i = 1; i < pixels; i++)
        n += same_source(sorted[i], sorted[i - 1]);
    return n;
}

/* Of the repeated pixels `pairs` hashed ones, each with a hashed one of the earlier that show the same. */
static void choose_pairs(struct ttf_synchrony *synchrony, const uint64_t *sorted, size_t pixels,
                         size_t repeated, uint64_t seed)
{
    size_t first = 0, seen = 0;
    unsigned chosen = 0;

    for (size_t i = 1; i < pixels && chosen < synchrony->n; i++) {
        if (!same_source(sorted[i], sorted[first])) {
            first = i;
            continue;
        }
        if (seen++ ==
            ttf_stratum(seed, TTF_PURPOSE_SYNCHRONY_PAIR, chosen, repeated, synchrony->n)) {
            uint64_t random = ttf_random64(seed, TTF_PURPOSE_SYNCHRONY_PARTNER, i);
            struct pair *pair = &synchrony->pairs[chosen++];

            pair->pixel[0] = (uint32_t)sorted[first + ttf_pick(random, (uint32_t)(i - first))];
            pair->pixel[1] = (uint32_t)sorted[i];
        }
    }
}

struct ttf_synchrony *ttf_synchrony_create(const uint32_t *source, size_t pixels,
                                           unsigned pairs_max, uint64_t seed,
                                           const struct ttf_encoding *encoding)
{
    struct ttf_synchrony *synchrony = calloc(1, sizeof(*synchrony));
    uint64_t *sorted = sort_by_source(source, pixels);
    size_t repeated;

    if (!synchrony || !sorted)
        goto fail;
    repeated = count_repeated(sorted, pixels);
    synchrony->n = repeated < pairs_max ? (unsigned)repeated : pairs_max;
    synchrony->pairs = calloc((size_t)synchrony->n + 1, sizeof(*synchrony->pairs));
    if (!synchrony->pairs)
        goto fail;
    choose_pairs(synchrony, sorted, pixels, repeated, seed);
    ttf_display8_table(encoding, synchrony->table);
    free(sorted);
    return synchrony;

fail:
    free(sorted);
    ttf_synchrony_destroy(synchrony);
    return NULL;
}

void ttf_synchrony_destroy(struct ttf_synchrony *synchrony)
{
    if (!synchrony)
        return;
    free(synchrony->pairs);
    free(synchrony);
}

/* Sum over channels of how much a pixel's display codes changed since the last frame. */
static unsigned change(const uint8_t *table, const uint16_t *rgb, uint8_t last[3])
{
    unsigned sum = 0;

    for (unsigned c = 0; c < 3; c++) {
        int now = table[rgb[c]];

        sum += (unsigned)abs(now - last[c]);
        last[c] = (uint8_t)now;
    }
    return sum;
}

void ttf_synchrony_add(struct ttf_synchrony *synchrony, const uint16_t *output)
{
    for (unsigned i = 0; i < synchrony->n; i++) {
        struct pair *pair = &synchrony->pairs[i];
        uint64_t changes[2];

        for (unsigned k = 0; k < 2; k++)
            changes[k] =
                change(synchrony->table, output + (size_t)pair->pixel[k] * 3, pair->last[k]);
        if (synchrony->frames == 0)
            continue;
        for (unsigned k = 0; k < 2; k++) {
            pair->sum[k] += changes[k];
            pair->square[k] += changes[k] * changes[k];
        }
        pair->product += changes[0] * changes[1];
    }
    synchrony->frames++;
}

/*
 * n squared times the covariance of the sums' two series: exact in 64 bits up to two
 * million frames (a change squared is below 2^20).
 */
static double covariance(uint64_t n, uint64_t product, uint64_t sum_x, uint64_t sum_y)
{
    return (double)((int64_t)(n * product) - (int64_t)(sum_x * sum_y));
}

void ttf_synchrony_figures(const struct ttf_synchrony *synchrony, struct ttf_synchrony_figures *ret)
{
    uint64_t n = synchrony->frames > 0 ? synchrony->frames - 1 : 0;
    double sum = 0.0, weights = 0.0;
    unsigned pairs = 0;

    for (unsigned i = 0; i < synchrony->n; i++) {
        const struct pair *pair = &synchrony->pairs[i];
        double x = covariance(n, pair->square[0], pair->sum[0], pair->sum[0]);
        double y = covariance(n, pair->square[1], pair->sum[1], pair->sum[1]);
        double weight = (double)(pair->sum[0] + pair->sum[1]);

        /* two pixels that change evenly, or never, have no moments to share */
        if (x == 0.0 && y == 0.0)
            continue;
        pairs++;
        weights += weight;
        if (x > 0.0 && y > 0.0)
            sum += weight * covariance(n, pair->product, pair->sum[0], pair->sum[1]) / sqrt(x * y);
    }
    ret->pairs = pairs;
    ret->synchrony = pairs ? sum / weights : 0.0;
}
