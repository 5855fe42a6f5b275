/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Is the output made of whole trajectories? Two passes over both sequences: the
 * first hashes each pixel's trajectory and so finds a source pixel for each output
 * pixel (or takes the map's word); the second compares bit for bit.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "quilt/map_of_sources.h"
#include "search/hash.h"
#include "search/sources.h"
#include "ttf/synth/cancel.h"
#include "ttf/synth/run.h"

#define NOBODY UINT32_MAX

struct entry {
    uint64_t hash;
    uint32_t pixel;
};

struct verify {
    const volatile int *cancel;
    struct ttf_sources sources;
    struct ttf_sequence *output;
    size_t source_pixels, output_pixels;
    uint16_t *source_frame, *output_frame;
    struct entry *entries; /* of source pixels, then sorted */
    uint64_t *hashes;      /* of output pixels */
    uint32_t *found;       /* source pixel of each output pixel, or NOBODY */
};

static int read_frames(struct verify *v, uint32_t t, struct ttf_err *err)
{
    int r;

    if (ttf_cancelled(v->cancel)) {
        ttf_err_set(err, -ECANCELED, NULL, "cancelled");
        return -ECANCELED;
    }
    r = ttf_sources_read(&v->sources, t, v->source_frame, err);
    if (r < 0)
        return r;
    return ttf_sequence_read_rows(v->output, t, 0, v->output->height, v->output_frame, err);
}

static uint64_t add_pixel(uint64_t hash, const uint16_t *codes)
{
    return ttf_mix64(hash + ((uint64_t)codes[0] << 32 | (uint64_t)codes[1] << 16 | codes[2]));
}

static int hash_all(struct verify *v, struct ttf_err *err)
{
    for (size_t i = 0; i < v->source_pixels; i++)
        v->entries[i] = (struct entry){1, (uint32_t)i};
    for (size_t i = 0; i < v->output_pixels; i++)
        v->hashes[i] = 1;
    for (uint32_t t = 0; t < v->sources.frames; t++) {
        int r = read_frames(v, t, err);

        if (r < 0)
            return r;
        for (size_t i = 0; i < v->source_pixels; i++)
            v->entries[i].hash = add_pixel(v->entries[i].hash, v->source_frame + 3 * i);
        for (size_t i = 0; i < v->output_pixels; i++)
            v->hashes[i] = add_pixel(v->hashes[i], v->output_frame + 3 * i);
    }
    return 0;
}

static int by_hash(const void *a, const void *b)
{
    uint64_t x = ((const struct entry *)a)->hash, y = ((const struct entry *)b)->hash;

    return (x > y) - (x < y);
}

/* Any pixel of an equal hash will do: trajectories are compared in full afterwards. */
static void look_up(struct verify *v)
{
    qsort(v->entries, v->source_pixels, sizeof(*v->entries), by_hash);
    for (size_t i = 0; i < v->output_pixels; i++) {
        const struct entry key = {v->hashes[i], 0};
        const struct entry *entry =
            bsearch(&key, v->entries, v->source_pixels, sizeof(key), by_hash);

        v->found[i] = entry ? entry->pixel : NOBODY;
    }
}

static int compare_all(struct verify *v, struct ttf_err *err)
{
    for (uint32_t t = 0; t < v->sources.frames; t++) {
        int r = read_frames(v, t, err);

        if (r < 0)
            return r;
        for (size_t i = 0; i < v->output_pixels; i++) {
            if (v->found[i] != NOBODY &&
                memcmp(v->output_frame + 3 * i, v->source_frame + 3 * (size_t)v->found[i],
                       3 * sizeof(uint16_t)) != 0)
                v->found[i] = NOBODY;
        }
    }
    return 0;
}

static void sum_up(const struct verify *v, struct ttf_quilt_check *ret)
{
    *ret = (struct ttf_quilt_check){.pixels = v->output_pixels};
    for (size_t i = 0; i < v->output_pixels; i++) {
        if (v->found[i] != NOBODY)
            continue;
        if (ret->unmatched++ == 0) {
            ret->first_x = (uint32_t)(i % v->output->width);
            ret->first_y = (uint32_t)(i / v->output->width);
        }
    }
}

static int check_sizes(const struct verify *v, const struct ttf_quilt_map *map, struct ttf_err *err)
{
    struct ttf_quilt_map own = {0};

    ttf_quilt_map_of_sources(&v->sources, &own);
    if (v->sources.frames != v->output->n)
        return ttf_err_set(err, -EINVAL, NULL, "the output has %u frames, the source %u",
                           v->output->n, v->sources.frames);
    if (map && (map->width != v->output->width || map->height != v->output->height ||
                map->n_inputs != own.n_inputs ||
                memcmp(map->inputs, own.inputs, own.n_inputs * sizeof(own.inputs[0])) != 0))
        return ttf_err_set(err, -EINVAL, NULL,
                           "a map of %u x %u from %u pixels does not suit %u x %u from %u",
                           map->width, map->height, map->source_pixels, v->output->width,
                           v->output->height, own.source_pixels);
    return 0;
}

int ttf_quilt_verify(const struct ttf_quilt_config *config, struct ttf_sequence *source,
                     struct ttf_sequence *output, const struct ttf_quilt_map *map,
                     struct ttf_quilt_check *ret, struct ttf_err *err)
{
    struct verify v = {.cancel = config->cancel,
                       .output = output,
                       .output_pixels = (size_t)output->width * output->height};
    int r = ttf_sources_of(config, source, &v.sources, err);

    if (r == 0)
        r = check_sizes(&v, map, err);
    if (r < 0)
        return r;
    v.source_pixels = v.sources.pixels;
    v.source_frame = malloc(v.source_pixels * 3 * sizeof(uint16_t));
    v.output_frame = malloc(v.output_pixels * 3 * sizeof(uint16_t));
    v.entries = malloc((map ? 1 : v.source_pixels) * sizeof(*v.entries));
    v.hashes = malloc((map ? 1 : v.output_pixels) * sizeof(*v.hashes));
    v.found = malloc(v.output_pixels * sizeof(*v.found));
    if (!v.source_frame || !v.output_frame || !v.entries || !v.hashes || !v.found) {
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory to compare %u x %u pixels", output->width,
                        output->height);
        goto out;
    }
    if (map) {
        memcpy(v.found, map->source, v.output_pixels * sizeof(*v.found));
    } else {
        r = hash_all(&v, err);
        if (r < 0)
            goto out;
        look_up(&v);
    }
    r = compare_all(&v, err);
    if (r == 0)
        sum_up(&v, ret);
out:
    free(v.source_frame);
    free(v.output_frame);
    free(v.entries);
    free(v.hashes);
    free(v.found);
    return r;
}
