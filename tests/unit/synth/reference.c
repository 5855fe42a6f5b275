/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdbool.h>
#include <stdlib.h>

#include "reference.h"
#include "search/hash.h"

static uint64_t full_time_error(const void *ctx, size_t p, size_t q)
{
    const struct ttf_trajectories *trajectories = ctx;
    uint64_t sum = 0;

    for (size_t i = 0; i < trajectories->dims; i++) {
        int d = trajectories->codes[p * trajectories->dims + i] -
                trajectories->codes[q * trajectories->dims + i];

        sum += (uint64_t)(d * d);
    }
    return sum;
}

struct reference reference_of_trajectories(const struct ttf_trajectories *trajectories,
                                           double noise)
{
    return (struct reference){trajectories->width, trajectories->height, full_time_error,
                              trajectories, 2.0 * noise * (double)trajectories->dims};
}

static uint64_t rank_error(const void *ctx, size_t p, size_t q)
{
    const struct ttf_matching *matching = ctx;
    uint64_t sum = 0;

    for (size_t i = 0; i < matching->k; i++) {
        int64_t d =
            matching->coefs[p * matching->stride + i] - matching->coefs[q * matching->stride + i];

        sum += (uint64_t)(d * d);
    }
    return sum;
}

struct reference reference_of_matching(const struct ttf_matching *matching, uint32_t width)
{
    return (struct reference){width, (uint32_t)(matching->pixels / width), rank_error, matching,
                              2.0 * matching->noise * matching->k * matching->scale *
                                  matching->scale};
}

static uint64_t pixel_error(const struct reference *reference, size_t p, size_t q)
{
    return reference->error(reference->ctx, p, q);
}

uint64_t reference_error(const struct reference *reference, const struct ttf_overlap *overlap,
                         uint32_t x, uint32_t y)
{
    uint64_t sum = 0;

    for (uint32_t j = 0; j < overlap->height; j++) {
        for (uint32_t i = 0; i < overlap->width; i++) {
            if (i < overlap->left || j < overlap->top)
                sum += pixel_error(reference, overlap->known[j * overlap->stride + i],
                                   (size_t)(y + j) * reference->width + x + i);
        }
    }
    return sum;
}

uint32_t reference_candidates(const struct reference *reference, const struct ttf_overlap *overlap,
                              double tolerance, uint32_t *positions, uint64_t *errors,
                              uint64_t *ret_best)
{
    uint32_t columns = reference->width - overlap->width + 1;
    uint32_t rows = reference->height - overlap->height + 1;
    uint64_t best = UINT64_MAX, pixels = 0;
    uint32_t n = 0;
    double limit;

    for (uint32_t j = 0; j < overlap->height; j++) {
        for (uint32_t i = 0; i < overlap->width; i++)
            pixels += i < overlap->left || j < overlap->top;
    }
    for (uint32_t i = 0; i < columns * rows; i++) {
        errors[i] = reference_error(reference, overlap, i % columns, i / columns);
        best = errors[i] < best ? errors[i] : best;
    }
    limit = reference->floor * (double)pixels;
    limit = (1.0 + tolerance) * ((double)best > limit ? (double)best : limit);
    for (uint32_t i = 0; i < columns * rows; i++) {
        if ((double)errors[i] <= limit) {
            positions[n] = i;
            errors[n++] = errors[i];
        }
    }
    *ret_best = best;
    return n;
}

/* Where the cheapest path that ends in (step, j) costs least: straight from the recurrence, by memory. */
static void plain_cut(const uint64_t *error, uint32_t steps, uint32_t width, uint32_t *cut)
{
    uint64_t *cost = calloc((size_t)steps * width, sizeof(*cost));
    uint32_t at = 0;

    assert_non_null(cost);
    for (uint32_t i = 0; i < steps; i++) {
        for (uint32_t j = 0; j < width; j++) {
            uint64_t before = i == 0 ? 0 : UINT64_MAX;

            for (int d = -1; i > 0 && d <= 1; d++) {
                int64_t k = (int64_t)j + d;

                if (k >= 0 && k < width && cost[(i - 1) * width + k] < before)
                    before = cost[(i - 1) * width + k];
            }
            cost[i * width + j] = error[i * width + j] + before;
        }
    }
    for (uint32_t i = steps; i-- > 0;) {
        uint32_t from = i + 1 == steps || at == 0 ? 0 : at - 1;
        uint32_t to = i + 1 == steps ? width - 1 : at + 1 < width ? at + 1 : at;
        uint32_t best = from;

        for (uint32_t j = from; j <= to; j++)
            best = cost[i * width + j] < cost[i * width + best] ? j : best;
        at = cut[i] = best;
    }
    free(cost);
}

struct cuts {
    uint32_t left[4096], top[4096];
};

static void find_cuts(const struct reference *reference, const struct ttf_overlap *overlap,
                      uint32_t sx, uint32_t sy, struct cuts *cuts)
{
    size_t room = (size_t)overlap->width * overlap->height;
    uint64_t *error = calloc(room, sizeof(*error));

    assert_non_null(error);
    for (uint32_t j = 0; j < overlap->height; j++) {
        for (uint32_t i = 0; i < overlap->left; i++)
            error[j * overlap->left + i] =
                pixel_error(reference, overlap->known[j * overlap->stride + i],
                            (size_t)(sy + j) * reference->width + sx + i);
    }
    if (overlap->left)
        plain_cut(error, overlap->height, overlap->left, cuts->left);
    for (uint32_t i = 0; i < overlap->width; i++) {
        for (uint32_t j = 0; j < overlap->top; j++)
            error[i * overlap->top + j] =
                pixel_error(reference, overlap->known[j * overlap->stride + i],
                            (size_t)(sy + j) * reference->width + sx + i);
    }
    if (overlap->top)
        plain_cut(error, overlap->width, overlap->top, cuts->top);
    free(error);
}

struct work {
    uint32_t *positions;
    uint64_t *errors;
    struct cuts cuts;
};

static void place(const struct reference *reference, const struct ttf_quilt_config *config,
                  uint32_t *map, const struct ttf_overlap *overlap, unsigned block,
                  struct work *work)
{
    uint32_t columns = reference->width - overlap->width + 1;
    uint64_t random = ttf_random64(config->seed, TTF_PURPOSE_BLOCK, block);
    uint32_t position, n;
    uint64_t best;

    if (overlap->left || overlap->top) {
        n = reference_candidates(reference, overlap, config->tolerance, work->positions,
                                 work->errors, &best);
        position = work->positions[ttf_pick(random, n)];
        find_cuts(reference, overlap, position % columns, position / columns, &work->cuts);
    } else {
        n = columns * (reference->height - overlap->height + 1);
        position = ttf_pick(random, n);
    }
    for (uint32_t j = 0; j < overlap->height; j++) {
        for (uint32_t i = 0; i < overlap->width; i++) {
            bool new_x = i >= overlap->left || i >= work->cuts.left[j];
            bool new_y = j >= overlap->top || j >= work->cuts.top[i];

            if (new_x && new_y)
                map[j * config->width + i] =
                    (position / columns + j) * reference->width + position % columns + i;
        }
    }
}

static uint32_t sixth(uint32_t block)
{
    uint32_t o = (uint32_t)((double)block / 6.0 + 0.5);

    return o > 2 ? o : 2;
}

uint32_t *reference_plan(const struct reference *reference, const struct ttf_quilt_config *config)
{
    size_t pixels = (size_t)reference->width * reference->height;
    uint32_t ox = config->overlap_x ? config->overlap_x : sixth(config->block_width);
    uint32_t oy = config->overlap_y ? config->overlap_y : sixth(config->block_height);
    uint32_t *map = calloc((size_t)config->width * config->height, sizeof(*map));
    struct work *work = calloc(1, sizeof(*work));
    unsigned block = 0;

    assert_true(map && work);
    work->positions = calloc(pixels, sizeof(*work->positions));
    work->errors = calloc(pixels, sizeof(*work->errors));
    assert_true(work->positions && work->errors);
    for (uint32_t y = 0;; y += config->block_height - oy) {
        bool last_y = y + config->block_height >= config->height;

        for (uint32_t x = 0;; x += config->block_width - ox) {
            bool last_x = x + config->block_width >= config->width;
            struct ttf_overlap overlap = {.width = last_x ? config->width - x : config->block_width,
                                          .height =
                                              last_y ? config->height - y : config->block_height,
                                          .left = x ? ox : 0,
                                          .top = y ? oy : 0,
                                          .known = map + (size_t)y * config->width + x,
                                          .stride = config->width};

            place(reference, config, map + (size_t)y * config->width + x, &overlap, block++, work);
            if (last_x)
                break;
        }
        if (last_y)
            break;
    }
    free(work->positions);
    free(work->errors);
    free(work);
    return map;
}
