/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "metrics/patches.h"
#include "metrics/sliced.h"
#include "ttf/base/checked.h"
#include "ttf/synth/likeness.h"

#define DIRECTIONS 64u
#define SIZES      3u
#define SIDE_MIN   (TTF_PATCH_SIDE << (SIZES - 1))
/* the sum of a unit vector's absolute values is at most sqrt(147), by 255 codes of four bins; and the rounding */
#define BINS       12544u

static int allocate(uint32_t width, uint32_t height, struct ttf_patches *ret)
{
    size_t numbers, bytes;

    *ret = (struct ttf_patches){.width = width,
                                .height = height,
                                .patches_x = width - (TTF_PATCH_SIDE - 1),
                                .patches_y = height - (TTF_PATCH_SIDE - 1),
                                .stride = (size_t)width * 3};
    if (!ttf_mul_size(ret->stride, height, &numbers) ||
        !ttf_add_size(numbers, TTF_PATCH_ROW, &numbers) ||
        !ttf_mul_size(numbers, sizeof(*ret->codes), &bytes))
        return -ENOMEM;
    ret->codes = malloc(bytes);
    if (!ret->codes)
        return -ENOMEM;
    memset(ret->codes + numbers - TTF_PATCH_ROW, 0, TTF_PATCH_ROW * sizeof(*ret->codes));
    return 0;
}

int ttf_patches_of_picture(const uint8_t *rgb, uint32_t width, uint32_t height,
                           struct ttf_patches *ret)
{
    struct ttf_patches patches;
    int r = allocate(width, height, &patches);

    if (r < 0)
        return r;
    for (size_t i = 0; i < patches.stride * height; i++)
        patches.codes[i] = rgb[i];
    *ret = patches;
    return 0;
}

int ttf_patches_halve(const struct ttf_patches *from, struct ttf_patches *ret)
{
    struct ttf_patches half;
    int r = allocate(from->width / 2, from->height / 2, &half);

    if (r < 0)
        return r;
    for (size_t y = 0; y < half.height; y++) {
        const int16_t *above = from->codes + 2 * y * from->stride;
        const int16_t *below = above + from->stride;
        int16_t *to = half.codes + y * half.stride;

        for (size_t i = 0; i < half.stride; i++) {
            size_t k = i / 3 * 6 + i % 3;

            to[i] = (int16_t)((above[k] + above[k + 3] + below[k] + below[k + 3] + 2) / 4);
        }
    }
    *ret = half;
    return 0;
}

void ttf_patches_free(struct ttf_patches *patches)
{
    free(patches->codes);
    *patches = (struct ttf_patches){0};
}

/* ---- sliced distance ---- */

struct sliced {
    const struct ttf_patches *pictures[2];
    uint32_t *histograms; /* for each worker two of BINS */
    double distances[DIRECTIONS];
};

/* Along weights of TTF_PATCH_SIDE rows of TTF_PATCH_ROW, of which the last 3 are 0. */
static int32_t projection(const int16_t *patch, size_t stride, const int16_t *weights)
{
    int32_t sum = 0;

    for (unsigned y = 0; y < TTF_PATCH_SIDE; y++) {
        for (unsigned i = 0; i < TTF_PATCH_ROW; i++)
            sum += patch[y * stride + i] * weights[y * TTF_PATCH_ROW + i];
    }
    return sum;
}

static void count_projections(const struct ttf_patches *picture, const int16_t *weights,
                              int32_t offset, uint32_t *histogram)
{
    for (uint32_t y = 0; y < picture->patches_y; y++) {
        for (uint32_t x = 0; x < picture->patches_x; x++) {
            int32_t p = projection(ttf_patch_at(picture, x, y), picture->stride, weights);

            histogram[(p + offset) >> TTF_SLICED_SHIFT]++;
        }
    }
}

/* One direction over all patches: nothing is left to add up over tiles. */
static void sliced_tile(void *ctx, unsigned which, unsigned worker)
{
    struct sliced *sliced = ctx;
    uint32_t *histograms = sliced->histograms + (size_t)worker * 2 * BINS;
    int16_t direction[TTF_PATCH_NUMBERS], weights[TTF_PATCH_SIDE * TTF_PATCH_ROW] = {0};
    int32_t offset;

    ttf_sliced_direction(TTF_PURPOSE_PATCH_DIRECTION, which, TTF_PATCH_NUMBERS, direction);
    offset = ttf_sliced_offset(direction, TTF_PATCH_NUMBERS);
    for (unsigned i = 0; i < TTF_PATCH_NUMBERS; i++)
        weights[i / (3 * TTF_PATCH_SIDE) * TTF_PATCH_ROW + i % (3 * TTF_PATCH_SIDE)] = direction[i];
    memset(histograms, 0, sizeof(*histograms) * 2 * BINS);
    for (unsigned p = 0; p < 2; p++)
        count_projections(sliced->pictures[p], weights, offset, histograms + (size_t)p * BINS);
    sliced->distances[which] = ttf_sliced_distance(
        histograms, ttf_patches_count(sliced->pictures[0]), histograms + BINS,
        ttf_patches_count(sliced->pictures[1]), ttf_sliced_bins(direction, TTF_PATCH_NUMBERS));
}

int ttf_patches_sliced(const struct ttf_patches *a, const struct ttf_patches *b,
                       struct ttf_pool *pool, double *ret)
{
    struct sliced sliced = {.pictures = {a, b}};
    double sum = 0.0;

    sliced.histograms = malloc(sizeof(uint32_t) * 2 * BINS * (pool ? ttf_pool_threads(pool) : 1));
    if (!sliced.histograms)
        return -ENOMEM;
    ttf_pool_run(pool, DIRECTIONS, sliced_tile, &sliced);
    free(sliced.histograms);
    for (unsigned i = 0; i < DIRECTIONS; i++)
        sum += sliced.distances[i];
    *ret = sum / DIRECTIONS;
    return 0;
}

/* ---- all figures ---- */

static int compare_sizes(struct ttf_patches input[SIZES], struct ttf_patches output[SIZES],
                         struct ttf_pool *pool, double ret[SIZES])
{
    int r = 0;

    for (unsigned i = 0; i < SIZES && r == 0; i++) {
        if (i > 0)
            r = ttf_patches_halve(&input[i - 1], &input[i]);
        if (i > 0 && r == 0)
            r = ttf_patches_halve(&output[i - 1], &output[i]);
        if (r == 0)
            r = ttf_patches_sliced(&input[i], &output[i], pool, &ret[i]);
    }
    return r;
}

int ttf_patch_compare(const uint8_t *input, uint32_t input_width, uint32_t input_height,
                      const uint8_t *output, uint32_t output_width, uint32_t output_height,
                      unsigned samples, struct ttf_pool *pool, struct ttf_patch_figures *ret)
{
    struct ttf_patches in[SIZES] = {0}, out[SIZES] = {0};
    struct ttf_patch_figures figures = {0};
    int r;

    if (input_width < SIDE_MIN || input_height < SIDE_MIN || output_width < SIDE_MIN ||
        output_height < SIDE_MIN)
        return -EINVAL;
    r = ttf_patches_of_picture(input, input_width, input_height, &in[0]);
    if (r == 0)
        r = ttf_patches_of_picture(output, output_width, output_height, &out[0]);
    if (r == 0)
        r = compare_sizes(in, out, pool, figures.sliced);
    if (r == 0)
        r = ttf_patches_nearest(&out[0], &in[0], samples, pool, &figures.to_input);
    if (r == 0)
        r = ttf_patches_nearest(&in[0], &out[0], samples, pool, &figures.from_input);
    for (unsigned i = 0; i < SIZES; i++) {
        ttf_patches_free(&in[i]);
        ttf_patches_free(&out[i]);
    }
    if (r == 0)
        *ret = figures;
    return r;
}
