/* SPDX-License-Identifier: Apache-2.0 */
#include "search/trajectories.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/checked.h"
#include "ttf/synth/cancel.h"

/* Frames of one tile: 63 bytes per pixel, about a cache line, written together. */
#define TILE_FRAMES 21

/* Bytes of one piece of a frame read at a time. */
#define PIECE_BYTES ((size_t)4 << 20)

struct load {
    struct ttf_sequence *input;
    struct ttf_trajectories *out;
    uint32_t first;
    uint32_t piece_rows;
    const uint8_t *table;
    const volatile int *cancel;
    uint16_t **scratch; /* one per worker */
    struct result {
        int code;
        struct ttf_err err;
    } * results; /* one per tile */
};

static void scatter(const struct load *load, const uint16_t *rows, uint32_t y0, uint32_t n_rows,
                    uint32_t t)
{
    const struct ttf_trajectories *out = load->out;
    uint8_t *dst = out->codes + (size_t)y0 * out->width * out->dims + (size_t)3 * t;
    size_t pixels = (size_t)n_rows * out->width;

    for (size_t i = 0; i < pixels; i++, rows += 3, dst += out->dims) {
        dst[0] = load->table[rows[0]];
        dst[1] = load->table[rows[1]];
        dst[2] = load->table[rows[2]];
    }
}

static void load_tile(void *ctx, unsigned tile, unsigned worker)
{
    const struct load *load = ctx;
    struct result *result = &load->results[tile];
    uint32_t t0 = tile * TILE_FRAMES;
    uint32_t t1 = t0 + TILE_FRAMES < load->out->frames ? t0 + TILE_FRAMES : load->out->frames;
    uint32_t height = load->out->height;

    for (uint32_t y = 0; y < height; y += load->piece_rows) {
        uint32_t rows = height - y < load->piece_rows ? height - y : load->piece_rows;

        for (uint32_t t = t0; t < t1; t++) {
            if (ttf_cancelled(load->cancel)) {
                result->code = -ECANCELED;
                return;
            }
            result->code = ttf_sequence_read_rows(load->input, load->first + t, y, rows,
                                                  load->scratch[worker], &result->err);
            if (result->code < 0)
                return;
            scatter(load, load->scratch[worker], y, rows, t);
        }
    }
}

void ttf_metric_table(enum ttf_metric metric, const struct ttf_encoding *encoding,
                      uint8_t table[65536])
{
    if (metric == TTF_METRIC_DISPLAY) {
        ttf_display8_table(encoding, table);
        return;
    }
    for (unsigned code = 0; code < 65536; code++) {
        double value = ((double)code - encoding->pedestal) / encoding->scale;

        value = value < 0.0 ? 0.0 : value > 1.0 ? 1.0 : value;
        table[code] = (uint8_t)(value * 255.0 + 0.5);
    }
}

static int load_all(struct load *load, struct ttf_pool *pool, struct ttf_err *err)
{
    unsigned tiles = (load->out->frames + TILE_FRAMES - 1) / TILE_FRAMES;
    unsigned threads = ttf_pool_threads(pool);
    size_t row_bytes = (size_t)load->out->width * 3 * sizeof(uint16_t);
    int r = -ENOMEM;

    load->piece_rows = row_bytes < PIECE_BYTES ? (uint32_t)(PIECE_BYTES / row_bytes) : 1;
    if (load->piece_rows == 0 || load->piece_rows > load->out->height)
        load->piece_rows = load->out->height;
    load->results = calloc(tiles, sizeof(*load->results));
    load->scratch = calloc(threads, sizeof(*load->scratch));
    if (!load->results || !load->scratch)
        goto out;
    for (unsigned i = 0; i < threads; i++) {
        load->scratch[i] = malloc(load->piece_rows * row_bytes);
        if (!load->scratch[i])
            goto out;
    }
    ttf_pool_run(pool, tiles, load_tile, load);
    r = 0;
    for (unsigned i = 0; i < tiles && r == 0; i++) {
        r = load->results[i].code < 0 ? load->results[i].code : 0;
        if (r < 0 && err)
            *err = load->results[i].err;
    }
out:
    for (unsigned i = 0; load->scratch && i < threads; i++)
        free(load->scratch[i]);
    free(load->scratch);
    free(load->results);
    return r;
}

int ttf_trajectories_load(struct ttf_sequence *input, uint32_t first, uint32_t frames,
                          enum ttf_metric metric, struct ttf_pool *pool, const volatile int *cancel,
                          struct ttf_trajectories *ret, struct ttf_err *err)
{
    struct ttf_trajectories out = {.width = input->width,
                                   .height = input->height,
                                   .frames = frames,
                                   .dims = (size_t)3 * frames};
    struct load load = {.input = input, .out = &out, .first = first, .cancel = cancel};
    uint8_t *table;
    size_t bytes;
    int r = -ENOMEM;

    if (out.width == 0 || out.height == 0 || frames == 0)
        return ttf_err_set(err, -EINVAL, NULL, "an input without pixels");
    table = malloc(65536);
    if (!ttf_mul_size((size_t)out.width * out.height, out.dims, &bytes))
        goto out_of_memory;
    out.codes = malloc(bytes);
    if (!table || !out.codes)
        goto out_of_memory;
    ttf_metric_table(metric, &input->encoding, table);
    load.table = table;
    r = load_all(&load, pool, err);
    if (r == -ENOMEM)
        goto out_of_memory;
    free(table);
    if (r < 0) {
        ttf_trajectories_free(&out);
        return r == -ECANCELED ? ttf_err_set(err, r, NULL, "cancelled") : r;
    }
    *ret = out;
    return 0;

out_of_memory:
    free(table);
    ttf_trajectories_free(&out);
    ttf_err_set(err, -ENOMEM, NULL, "no memory for the matching data of %u frames of %u x %u",
                frames, input->width, input->height);
    ttf_err_hint(err, "use fewer frames or a smaller crop");
    return -ENOMEM;
}

void ttf_trajectories_free(struct ttf_trajectories *trajectories)
{
    free(trajectories->codes);
    memset(trajectories, 0, sizeof(*trajectories));
}
