/* SPDX-License-Identifier: Apache-2.0 */
#include "search/rank_ground.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

void ttf_rank_ground_free(struct ttf_rank_ground *ground)
{
    for (unsigned i = 0; ground->sums && i < ground->n_views; i++)
        free(ground->sums[i]);
    free(ground->sums);
    free(ground->g);
    free(ground->runs);
    free(ground->others);
    free(ground->coefs);
    memset(ground, 0, sizeof(*ground));
}

/* The one candidate for a majority, by pairing off pixels that differ; how many it really has. */
static size_t find_ground(const struct ttf_rank_template *template, size_t stride, size_t *ret)
{
    size_t bytes = stride * sizeof(int16_t), votes = 0, n = 0, at = 0;

    for (size_t i = 0; i < template->n_pixels; i++) {
        if (votes == 0)
            at = i;
        votes += memcmp(template->coefs + i * stride, template->coefs + at * stride, bytes) == 0
                     ? 1
                     : -1;
    }
    for (size_t i = 0; i < template->n_pixels; i++)
        n += memcmp(template->coefs + i * stride, template->coefs + at * stride, bytes) == 0;
    *ret = at;
    return n;
}

static int make_room(struct ttf_rank_ground *ground, const struct ttf_rank_search *search,
                     size_t pixels)
{
    size_t stride = search->matching->stride;

    if (pixels > ground->room) {
        free(ground->runs);
        free(ground->others);
        free(ground->coefs);
        ground->room = 0;
        ground->runs = malloc(pixels * sizeof(*ground->runs));
        ground->others = malloc(pixels * sizeof(*ground->others));
        ground->coefs = malloc(pixels * stride * sizeof(*ground->coefs));
        if (!ground->runs || !ground->others || !ground->coefs)
            return -ENOMEM;
        ground->room = pixels;
    }
    if (ground->sums)
        return 0;
    ground->sums = calloc(search->views->n, sizeof(*ground->sums));
    if (!ground->sums)
        return -ENOMEM;
    ground->n_views = search->views->n;
    for (unsigned i = 0; i < ground->n_views; i++) {
        const struct ttf_view *view = &search->views->list[i];

        ground->sums[i] =
            malloc((size_t)view->height * (view->width + 1) * sizeof(*ground->sums[i]));
        if (!ground->sums[i])
            return -ENOMEM;
    }
    return 0;
}

static void sum_view(struct ttf_rank_ground *ground, const struct ttf_rank_search *search,
                     unsigned index)
{
    const struct ttf_view *view = &search->views->list[index];
    size_t stride = search->matching->stride;
    uint64_t *out = ground->sums[index];

    for (size_t y = 0; y < view->height; y++) {
        const int16_t *row = view->coefs + y * view->width * stride;
        uint64_t sum = 0;

        *out++ = 0;
        for (size_t x = 0; x < view->width; x++) {
            sum += search->kernels->ssd_i16(row + x * stride, ground->g, stride);
            *out++ = sum;
        }
    }
}

/* Splits the template's runs into those of the ground and those of anything else. */
static void split(struct ttf_rank_ground *ground, const struct ttf_rank_template *template,
                  size_t stride)
{
    size_t bytes = stride * sizeof(int16_t), gathered = 0;

    ground->n_runs = ground->n_others = 0;
    for (size_t k = 0; k < template->n_runs; k++) {
        const struct ttf_rank_run *run = &template->runs[k];
        struct ttf_rank_run *last = NULL;
        bool last_is_ground = false;

        for (size_t x = 0; x < run->length; x++) {
            const int16_t *coefs = template->coefs + (run->first + x) * stride;
            bool is_ground = memcmp(coefs, ground->g, bytes) == 0;

            if (!last || is_ground != last_is_ground) {
                last = is_ground ? &ground->runs[ground->n_runs++]
                                 : &ground->others[ground->n_others++];
                *last = (struct ttf_rank_run){run->dx + (uint32_t)x, run->dy, 0, gathered};
                last_is_ground = is_ground;
            }
            last->length++;
            if (!is_ground)
                memcpy(ground->coefs + gathered++ * stride, coefs, bytes);
        }
    }
}

int ttf_rank_ground_prepare(struct ttf_rank_ground *ground, const struct ttf_rank_search *search,
                            const struct ttf_rank_template *template)
{
    size_t stride = search->matching->stride, at;
    const int16_t *g;
    int r;

    if (2 * find_ground(template, stride, &at) < template->n_pixels)
        return 0;
    r = make_room(ground, search, template->n_pixels);
    if (r < 0)
        return r;
    g = template->coefs + at * stride;
    if (!ground->g || memcmp(ground->g, g, stride * sizeof(*g)) != 0) {
        if (!ground->g)
            ground->g = calloc(stride + 1, sizeof(*g));
        if (!ground->g)
            return -ENOMEM;
        memcpy(ground->g, g, stride * sizeof(*g));
        for (unsigned i = 0; i < ground->n_views; i++)
            sum_view(ground, search, i);
    }
    split(ground, template, stride);
    return 1;
}

uint64_t ttf_rank_ground_error(const struct ttf_rank_ground *ground,
                               const struct ttf_rank_search *search,
                               const struct ttf_rank_position *at, uint64_t limit)
{
    const struct ttf_view *view = &search->views->list[at->view];
    const uint64_t *sums = ground->sums[at->view];
    size_t stride = search->matching->stride, width = view->width;
    uint64_t sum = 0;

    for (size_t i = 0; i < ground->n_runs; i++) {
        const struct ttf_rank_run *run = &ground->runs[i];
        const uint64_t *row = sums + (at->y + run->dy) * (width + 1) + at->x + run->dx;

        sum += row[run->length] - row[0];
    }
    for (size_t i = 0; i < ground->n_others && sum <= limit; i++) {
        const struct ttf_rank_run *run = &ground->others[i];
        size_t pixel = (at->y + run->dy) * width + at->x + run->dx;

        sum += search->kernels->ssd_i16(view->coefs + pixel * stride,
                                        ground->coefs + run->first * stride, run->length * stride);
    }
    return sum;
}
