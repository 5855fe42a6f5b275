/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Exact nearest patches. By Cauchy's inequality the squared difference of two patches
 * is at least a ninth of the squared difference of sums over 3 x 3 pixels, added up
 * over squares that do not overlap: the four corners. One pass over a plane of such
 * sums excludes most patches; the rest is compared number by number, given up as soon
 * as it passes the best so far. All of it integers, so the order does not matter.
 */
#include <errno.h>
#include <math.h>
#include <stdlib.h>

#include "metrics/patches.h"
#include "metrics/samples.h"

#define CELL    3u                      /* side of the squares */
#define CORNER  (TTF_PATCH_SIDE - CELL) /* from one corner's square to the next */
#define SEGMENT 256u                    /* patches of one row looked at together */
#define BATCH   8u /* samples that share a pass over the picture, and so the cache */

struct query {
    int16_t numbers[TTF_PATCH_SIDE * TTF_PATCH_ROW];
    int16_t sums[4][3]; /* corners, channels */
    uint32_t best;      /* least squared difference so far */
};

struct nearest {
    const struct ttf_patches *of, *in;
    /* sums over CELL x CELL of `in`, a plane for each channel, and SEGMENT behind the last */
    int16_t *planes[3];
    size_t plane_stride;
    uint64_t samples;
    uint32_t *best; /* for each sample */
};

/* Adds up the plane of one channel, row by row. */
static void make_plane(const struct ttf_patches *in, unsigned channel, int16_t *plane,
                       size_t stride)
{
    for (uint32_t y = 0; y + CELL <= in->height; y++) {
        for (uint32_t x = 0; x + CELL <= in->width; x++) {
            const int16_t *at = ttf_patch_at(in, x, y) + channel;
            int sum = 0;

            for (unsigned k = 0; k < CELL; k++, at += in->stride)
                sum += at[0] + at[3] + at[6];
            plane[y * stride + x] = (int16_t)sum;
        }
    }
}

static void make_query(const struct ttf_patches *of, uint64_t patch, struct query *ret)
{
    const int16_t *at =
        ttf_patch_at(of, (uint32_t)(patch % of->patches_x), (uint32_t)(patch / of->patches_x));

    *ret = (struct query){.best = UINT32_MAX};
    for (unsigned y = 0; y < TTF_PATCH_SIDE; y++) {
        for (unsigned i = 0; i < 3 * TTF_PATCH_SIDE; i++)
            ret->numbers[y * TTF_PATCH_ROW + i] = at[y * of->stride + i];
    }
    for (unsigned i = 0; i < 4 * 3 * CELL * CELL; i++) {
        unsigned corner = i / (3 * CELL * CELL), channel = i % 3;
        unsigned x = corner % 2 * CORNER + i / 3 % CELL, y = corner / 2 * CORNER + i / 9 % CELL;

        ret->sums[corner][channel] =
            (int16_t)(ret->sums[corner][channel] + at[y * of->stride + (size_t)3 * x + channel]);
    }
}

/* CELL squared times the least squared difference that the corners leave possible. */
static void find_bounds(const struct nearest *nearest, const struct query *query, uint32_t x,
                        uint32_t y, int32_t bounds[SEGMENT])
{
    for (unsigned i = 0; i < SEGMENT; i++)
        bounds[i] = 0;
    for (unsigned channel = 0; channel < 3; channel++) {
        const int16_t *above = nearest->planes[channel] + y * nearest->plane_stride + x;
        const int16_t *below = above + CORNER * nearest->plane_stride;
        const int16_t a = query->sums[0][channel], b = query->sums[1][channel],
                      c = query->sums[2][channel], d = query->sums[3][channel];

        for (unsigned i = 0; i < SEGMENT; i++) {
            int16_t da = (int16_t)(above[i] - a), db = (int16_t)(above[i + CORNER] - b);
            int16_t dc = (int16_t)(below[i] - c), dd = (int16_t)(below[i + CORNER] - d);

            bounds[i] += da * da + db * db + dc * dc + dd * dd;
        }
    }
}

/* Squared difference, or something beyond `limit` that it is not below. */
static uint32_t difference(const int16_t *patch, size_t stride, const int16_t *numbers,
                           uint32_t limit)
{
    static const int16_t mask[TTF_PATCH_ROW] = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1, -1,
                                                -1, -1, -1, -1, -1, -1, -1, -1, -1, -1};
    uint32_t total = 0;

    for (unsigned y = 0; y < TTF_PATCH_SIDE && total <= limit; y++) {
        int32_t sum = 0;

        for (unsigned i = 0; i < TTF_PATCH_ROW; i++) {
            int16_t d = (int16_t)((patch[i] - numbers[i]) & mask[i]);

            sum += d * d;
        }
        total += (uint32_t)sum;
        patch += stride;
        numbers += TTF_PATCH_ROW;
    }
    return total;
}

static void try_patch(const struct nearest *nearest, struct query *query, uint32_t x, uint32_t y)
{
    uint32_t found = difference(ttf_patch_at(nearest->in, x, y), nearest->in->stride,
                                query->numbers, query->best);

    if (found < query->best)
        query->best = found;
}

/* Patches x..x+n-1 of row y, the most promising first: what it leaves to beat excludes others. */
static void search_segment(const struct nearest *nearest, struct query *query, uint32_t x,
                           uint32_t y, uint32_t n)
{
    int32_t bounds[SEGMENT];
    uint32_t first = 0;

    find_bounds(nearest, query, x, y, bounds);
    for (uint32_t i = 1; i < n; i++)
        first = bounds[i] < bounds[first] ? i : first;
    if ((uint64_t)bounds[first] >= (uint64_t)query->best * (CELL * CELL))
        return;
    try_patch(nearest, query, x + first, y);
    for (uint32_t i = 0; i < n; i++) {
        if ((uint64_t)bounds[i] < (uint64_t)query->best * (CELL * CELL))
            try_patch(nearest, query, x + i, y);
    }
}

static void nearest_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct nearest *nearest = ctx;
    const struct ttf_patches *in = nearest->in;
    uint64_t from = (uint64_t)tile * BATCH;
    unsigned n = nearest->samples - from < BATCH ? (unsigned)(nearest->samples - from) : BATCH;
    struct query queries[BATCH];

    for (unsigned i = 0; i < n; i++)
        make_query(nearest->of,
                   ttf_stratum(0, TTF_PURPOSE_PATCH, from + i, ttf_patches_count(nearest->of),
                               nearest->samples),
                   &queries[i]);
    for (uint32_t y = 0; y < in->patches_y; y++) {
        for (uint32_t x = 0; x < in->patches_x; x += SEGMENT) {
            uint32_t left = in->patches_x - x;

            for (unsigned i = 0; i < n; i++)
                search_segment(nearest, &queries[i], x, y, left < SEGMENT ? left : SEGMENT);
        }
    }
    for (unsigned i = 0; i < n; i++)
        nearest->best[from + i] = queries[i].best;
}

static int prepare(struct nearest *nearest)
{
    const struct ttf_patches *in = nearest->in;
    size_t numbers;

    nearest->plane_stride = in->width;
    numbers = (size_t)in->width * in->height + SEGMENT + TTF_PATCH_SIDE;
    nearest->best = malloc(nearest->samples * sizeof(*nearest->best));
    nearest->planes[0] = calloc(numbers, 3 * sizeof(int16_t));
    if (!nearest->best || !nearest->planes[0])
        return -ENOMEM;
    for (unsigned c = 0; c < 3; c++) {
        nearest->planes[c] = nearest->planes[0] + c * numbers;
        make_plane(in, c, nearest->planes[c], nearest->plane_stride);
    }
    return 0;
}

int ttf_patches_nearest(const struct ttf_patches *of, const struct ttf_patches *in,
                        unsigned samples, struct ttf_pool *pool, double *ret)
{
    struct nearest nearest = {.of = of, .in = in};
    uint64_t patches = ttf_patches_count(of);
    double sum = 0.0;
    int r;

    nearest.samples = samples < patches ? samples : patches;
    if (nearest.samples == 0) {
        *ret = 0.0;
        return 0;
    }
    r = prepare(&nearest);
    if (r == 0) {
        ttf_pool_run(pool, (unsigned)((nearest.samples + BATCH - 1) / BATCH), nearest_tile,
                     &nearest);
        for (uint64_t i = 0; i < nearest.samples; i++)
            sum += sqrt((double)nearest.best[i] / TTF_PATCH_NUMBERS);
        *ret = sum / (double)nearest.samples;
    }
    free(nearest.planes[0]);
    free(nearest.best);
    return r;
}
