/* SPDX-License-Identifier: Apache-2.0 */
#include "control/fill.h"

#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>

#define SWEEPS_MAX 8 /* of relaxation on each level: the coarser levels have done the rest */

/* A picture whose pixels count by weight, 0 (nothing known) to 1. */
struct level {
    uint32_t width, height, samples;
    float *values;
    float *weights;
};

static int level_alloc(struct level *level, uint32_t width, uint32_t height, uint32_t samples)
{
    size_t n = (size_t)width * height;

    *level = (struct level){.width = width, .height = height, .samples = samples};
    if (n == 0 || samples == 0)
        return -EINVAL;
    level->values = calloc(n * samples, sizeof(*level->values));
    level->weights = calloc(n, sizeof(*level->weights));
    return level->values && level->weights ? 0 : -ENOMEM;
}

static void level_free(struct level *level)
{
    free(level->values);
    free(level->weights);
}

/* One pixel of the halved picture: the mean of up to four by their weights. */
static void pull_pixel(const struct level *fine, struct level *coarse, uint32_t x, uint32_t y)
{
    uint32_t k = fine->samples;
    size_t to = (size_t)y * coarse->width + x;
    float sum = 0.0f;

    for (uint32_t fy = 2 * y; fy < 2 * y + 2 && fy < fine->height; fy++) {
        for (uint32_t fx = 2 * x; fx < 2 * x + 2 && fx < fine->width; fx++) {
            size_t from = (size_t)fy * fine->width + fx;
            float w = fine->weights[from];

            sum += w;
            for (uint32_t c = 0; c < k; c++)
                coarse->values[to * k + c] += w * fine->values[from * k + c];
        }
    }
    for (uint32_t c = 0; c < k && sum > 0.0f; c++)
        coarse->values[to * k + c] /= sum;
    coarse->weights[to] = sum < 1.0f ? sum : 1.0f;
}

/* Places of the halved picture on either side of fine place i, and how much the second counts. */
struct between {
    uint32_t first, second;
    float part;
};

static struct between between_coarse(uint32_t i, uint32_t n)
{
    uint32_t own = i / 2, other = i % 2 ? own + 1 : own - 1;

    if ((i % 2 == 0 && own == 0) || other >= n)
        other = own;
    return (struct between){own, other, 0.25f};
}

static float coarse_at(const struct level *coarse, struct between bx, struct between by, uint32_t c)
{
    const float *v = coarse->values + c;
    uint32_t k = coarse->samples;
    size_t top = (size_t)by.first * coarse->width, bottom = (size_t)by.second * coarse->width;
    float a = v[(top + bx.first) * k], b = v[(top + bx.second) * k];
    float d = v[(bottom + bx.first) * k], e = v[(bottom + bx.second) * k];
    float above = a + bx.part * (b - a), below = d + bx.part * (e - d);

    return above + by.part * (below - above);
}

static void push(const struct level *coarse, struct level *fine)
{
    uint32_t k = fine->samples;

    for (uint32_t y = 0; y < fine->height; y++) {
        for (uint32_t x = 0; x < fine->width; x++) {
            size_t i = (size_t)y * fine->width + x;
            struct between bx = between_coarse(x, coarse->width);
            struct between by = between_coarse(y, coarse->height);

            for (uint32_t c = 0; c < k && fine->weights[i] < 1.0f; c++) {
                float *v = &fine->values[i * k + c];

                *v = fine->weights[i] * *v +
                     (1.0f - fine->weights[i]) * coarse_at(coarse, bx, by, c);
            }
        }
    }
}

/* The mean of the up to four neighbours: what Laplace's equation asks of an unknown pixel. */
static float around(const struct level *level, uint32_t x, uint32_t y, uint32_t c)
{
    uint32_t k = level->samples;
    size_t row = (size_t)level->width * k;
    const float *at = level->values + (size_t)y * row + (size_t)x * k + c;
    float sum = 0.0f, n = 0.0f;

    if (x > 0)
        sum += *(at - k), n += 1.0f;
    if (x + 1 < level->width)
        sum += at[k], n += 1.0f;
    if (y > 0)
        sum += *(at - row), n += 1.0f;
    if (y + 1 < level->height)
        sum += at[row], n += 1.0f;
    return n > 0.0f ? sum / n : *at;
}

/* Gauss-Seidel, in one order: the same bits always. */
static void relax(struct level *level)
{
    uint32_t k = level->samples;

    for (unsigned sweep = 0; sweep < SWEEPS_MAX; sweep++) {
        for (uint32_t y = 0; y < level->height; y++) {
            for (uint32_t x = 0; x < level->width; x++) {
                size_t i = (size_t)y * level->width + x;

                for (uint32_t c = 0; c < k && level->weights[i] < 1.0f; c++) {
                    float w = level->weights[i];

                    /* partly known: only its unknown part gives way */
                    level->values[i * k + c] +=
                        (1.0f - w) * (around(level, x, y, c) - level->values[i * k + c]);
                }
            }
        }
    }
}

static bool all_known(const struct level *level)
{
    size_t n = (size_t)level->width * level->height;

    for (size_t i = 0; i < n; i++) {
        if (level->weights[i] < 1.0f)
            return false;
    }
    return true;
}

static int fill_level(struct level *level)
{
    struct level coarse = {0};
    int r;

    if (all_known(level) || (level->width == 1 && level->height == 1))
        return 0;
    r = level_alloc(&coarse, (level->width + 1) / 2, (level->height + 1) / 2, level->samples);
    if (r == 0) {
        for (uint32_t y = 0; y < coarse.height; y++) {
            for (uint32_t x = 0; x < coarse.width; x++)
                pull_pixel(level, &coarse, x, y);
        }
        r = fill_level(&coarse);
    }
    if (r == 0) {
        push(&coarse, level);
        relax(level);
    }
    level_free(&coarse);
    return r;
}

int ttf_control_fill(float *values, uint32_t samples, const uint8_t *known, uint32_t width,
                     uint32_t height)
{
    struct level level = {.width = width, .height = height, .samples = samples};
    size_t n = (size_t)width * height;
    int r;

    level.values = values;
    level.weights = calloc(n ? n : 1, sizeof(*level.weights));
    if (!level.weights)
        return -ENOMEM;
    for (size_t i = 0; i < n; i++)
        level.weights[i] = known[i] ? 1.0f : 0.0f;
    r = fill_level(&level);
    free(level.weights);
    return r;
}
