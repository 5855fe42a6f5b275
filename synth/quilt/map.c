/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/map_of_sources.h"
#include "search/hash.h"
#include "ttf/synth/quilt.h"

void ttf_quilt_map_free(struct ttf_quilt_map *map)
{
    free(map->source);
    free(map->owner);
    free(map->blocks);
    free(map->cuts);
    free(map->layers);
    free(map->times);
    ttf_rate_map_free(&map->rate);
    free(map->runs);
    free(map->row_runs);
    memset(map, 0, sizeof(*map));
}

void ttf_quilt_map_of_sources(const struct ttf_sources *sources, struct ttf_quilt_map *map)
{
    map->n_inputs = sources->n;
    map->source_pixels = sources->pixels;
    for (unsigned i = 0; i < sources->n; i++)
        map->inputs[i] = (struct ttf_quilt_input){sources->list[i]->width, sources->list[i]->height,
                                                  sources->first[i]};
}

/* In four chains: one would wait for itself at each pixel. */
static uint64_t mix_sources(uint64_t h, const uint32_t *source, size_t n)
{
    uint64_t chains[4] = {h, h + 1, h + 2, h + 3};
    size_t i = 0;

    for (; i + 4 <= n; i += 4) {
        for (int k = 0; k < 4; k++)
            chains[k] = ttf_mix64(chains[k] + source[i + (size_t)k]);
    }
    for (; i < n; i++)
        chains[0] = ttf_mix64(chains[0] + source[i]);
    for (int k = 0; k < 4; k++)
        h = ttf_mix64(h ^ chains[k]);
    return h;
}

uint64_t ttf_quilt_map_digest(const struct ttf_quilt_map *map)
{
    size_t pixels = (size_t)map->width * map->height;
    uint64_t h = ttf_mix64(((uint64_t)map->width << 32) + map->height);

    for (unsigned i = 0; i < map->n_inputs; i++)
        h = ttf_mix64(h ^ (((uint64_t)map->inputs[i].width << 32) + map->inputs[i].height));
    h = mix_sources(h, map->source, pixels);
    for (size_t i = 0; i < map->n_layers; i++) {
        h = ttf_mix64(h + map->layers[i].pixel);
        h = ttf_mix64(h + map->layers[i].source);
        h = ttf_mix64(h + map->layers[i].weight);
    }
    for (size_t i = 0; map->times && i < (size_t)map->n_blocks * map->n_times; i++)
        h = ttf_mix64(h + map->times[i]);
    if (map->rounded)
        h = ttf_mix64(h ^ 1);
    for (size_t i = 0; map->rate.m && i < pixels; i++) {
        uint32_t bits;

        memcpy(&bits, &map->rate.m[i], sizeof(bits));
        h = ttf_mix64(h + bits);
    }
    return h;
}

bool ttf_quilt_neighbour(const struct ttf_quilt_map *map, uint32_t id, unsigned turn, int dx,
                         int dy, uint32_t *ret)
{
    const struct ttf_quilt_input *input = map->inputs;
    int64_t x, y;

    while (input + 1 < map->inputs + map->n_inputs && id >= input[1].first)
        input++;
    /* the output's step as one over the input (quilt.h, turns) */
    if (turn & 1)
        dx = -dx;
    if (turn & 2)
        dy = -dy;
    x = (int64_t)((id - input->first) % input->width) + (turn & 4 ? dy : dx);
    y = (int64_t)((id - input->first) / input->width) + (turn & 4 ? dx : dy);
    if (x < 0 || y < 0 || x >= input->width || y >= input->height)
        return false;
    *ret = input->first + (uint32_t)y * input->width + (uint32_t)x;
    return true;
}

/* Pixels that follow one another: where the run that begins at x ends. */
static uint32_t run_end(const uint32_t *row, uint32_t x, uint32_t width)
{
    uint32_t end = x + 1;

    while (end < width && row[end] == row[end - 1] + 1)
        end++;
    return end;
}

int ttf_quilt_map_index(struct ttf_quilt_map *map)
{
    uint32_t n = 0;

    free(map->runs);
    free(map->row_runs);
    map->runs = NULL;
    map->row_runs = malloc(((size_t)map->height + 1) * sizeof(*map->row_runs));
    if (!map->row_runs)
        return -ENOMEM;
    for (uint32_t y = 0; y < map->height; y++) {
        const uint32_t *row = map->source + (size_t)y * map->width;

        map->row_runs[y] = n;
        for (uint32_t x = 0; x < map->width; x = run_end(row, x, map->width))
            n++;
    }
    map->row_runs[map->height] = n;
    map->runs = malloc((n + 1) * sizeof(*map->runs));
    if (!map->runs)
        return -ENOMEM;
    n = 0;
    for (uint32_t y = 0; y < map->height; y++) {
        const uint32_t *row = map->source + (size_t)y * map->width;

        for (uint32_t x = 0, end; x < map->width; x = end) {
            end = run_end(row, x, map->width);
            map->runs[n++] = (struct ttf_quilt_run){row[x], end - x};
        }
    }
    return 0;
}

/* n elements of `size` bytes, copied; NULL of nothing. */
static void *copy_of(const void *from, size_t n, size_t size, bool *failed)
{
    void *copy = from && n > 0 ? malloc(n * size) : NULL;

    if (copy)
        memcpy(copy, from, n * size);
    else if (from && n > 0)
        *failed = true;
    return copy;
}

int ttf_quilt_map_copy(const struct ttf_quilt_map *map, struct ttf_quilt_map *ret)
{
    size_t pixels = (size_t)map->width * map->height;
    struct ttf_quilt_map out = *map;
    bool failed = false;

    out.source = copy_of(map->source, pixels, sizeof(*map->source), &failed);
    out.owner = copy_of(map->owner, pixels, sizeof(*map->owner), &failed);
    out.blocks = copy_of(map->blocks, map->n_blocks, sizeof(*map->blocks), &failed);
    out.cuts = copy_of(map->cuts, map->n_cuts, sizeof(*map->cuts), &failed);
    out.layers = copy_of(map->layers, map->n_layers, sizeof(*map->layers), &failed);
    out.times =
        copy_of(map->times, (size_t)map->n_blocks * map->n_times, sizeof(*map->times), &failed);
    out.rate.m = copy_of(map->rate.m, pixels, sizeof(*map->rate.m), &failed);
    out.runs = NULL;
    out.row_runs = NULL;
    if (failed || ttf_quilt_map_index(&out) < 0) {
        ttf_quilt_map_free(&out);
        return -ENOMEM;
    }
    *ret = out;
    return 0;
}
