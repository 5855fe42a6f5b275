/* SPDX-License-Identifier: Apache-2.0 */
/* export_sheet.c: a grid of frames evenly spread over time, as one PNG. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "export_job.h"
#include "ttf/dataset/image_file.h"

#define GAP         4  /* pixels between cells and around them */
#define BACKGROUND  24 /* display code: dark, so that edges of bright and of dark frames show */
#define CELLS_MAX   4096
#define SHEET_LEVEL 9

struct sheet_sink {
    struct export_sink base; /* first: downcast by address */
    struct ttf_pixbuf sheet;
    uint32_t columns;
};

int export_sheet_choose(struct export_job *job, struct ttf_err *err)
{
    uint32_t cells = job->config->sheet_frames;

    if (cells > CELLS_MAX)
        return ttf_err_set(err, -EINVAL, NULL, "a sheet of %u frames: at most %d", cells,
                           CELLS_MAX);
    if (cells > job->n)
        cells = job->n;
    for (uint32_t i = 0; i < cells && cells > 1; i++) {
        uint64_t k = ((uint64_t)i * (job->n - 1) + (cells - 1) / 2) / (cells - 1);

        job->frame[i] = job->frame[k]; /* k >= i: nothing needed is overwritten */
    }
    job->n = cells;
    return 0;
}

/* How far from 4:3, times as much where cells stay empty. */
static double ugliness(const struct export_job *job, uint32_t columns)
{
    uint32_t rows = (job->n + columns - 1) / columns;
    double ratio = (double)columns * job->width / ((double)rows * job->height) * 3.0 / 4.0;
    uint32_t empty = rows * columns - job->n;

    return (ratio > 1.0 ? ratio : 1.0 / ratio) * (1.0 + (double)empty / job->n);
}

static uint32_t choose_columns(const struct export_job *job)
{
    uint32_t best = 1;

    if (job->config->sheet_columns)
        return job->config->sheet_columns < job->n ? job->config->sheet_columns : job->n;
    for (uint32_t columns = 2; columns <= job->n; columns++) {
        if (ugliness(job, columns) < ugliness(job, best))
            best = columns;
    }
    return best;
}

static int sheet_frame(struct export_sink *base, uint32_t k, const struct ttf_pixbuf *rgb16,
                       struct ttf_err *err)
{
    struct sheet_sink *sink = (struct sheet_sink *)base;
    size_t x = GAP + (size_t)(k % sink->columns) * (rgb16->width + GAP);
    uint32_t y0 = GAP + k / sink->columns * (rgb16->height + GAP);

    for (uint32_t y = 0; y < rgb16->height; y++)
        export_display_row(base->job, ttf_pixbuf_row(rgb16, y), rgb16->width,
                           (uint8_t *)ttf_pixbuf_row(&sink->sheet, y0 + y) + x * 3);
    return 0;
}

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    const struct sheet_sink *sink = ctx;

    return ttf_png_write(io, file, &sink->sheet, TTF_TRANSFER_SRGB, SHEET_LEVEL,
                         export_mark(sink->base.job), err);
}

static int sheet_finish(struct export_sink *base, struct ttf_err *err)
{
    return staging_write(base->job->io, base->job->staging.temp, produce, base, err);
}

static void sheet_destroy(struct export_sink *base)
{
    struct sheet_sink *sink = (struct sheet_sink *)base;

    ttf_pixbuf_free(&sink->sheet);
    free(sink);
}

static const struct export_sink_ops sheet_ops = {
    .frame = sheet_frame,
    .finish = sheet_finish,
    .destroy = sheet_destroy,
};

int export_sheet_open(struct export_job *job, unsigned pass, struct export_sink **ret,
                      struct ttf_err *err)
{
    struct sheet_sink *sink = calloc(1, sizeof(*sink));
    uint32_t rows;
    int code;

    if (!sink)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a contact sheet");
    sink->base = (struct export_sink){.ops = &sheet_ops, .job = job};
    sink->columns = choose_columns(job);
    rows = (job->n + sink->columns - 1) / sink->columns;
    code = ttf_pixbuf_alloc(&sink->sheet, GAP + sink->columns * (job->width + GAP),
                            GAP + rows * (job->height + GAP), 3, TTF_SAMPLE_U8);
    if (code) {
        free(sink);
        return ttf_err_set(err, code, NULL, "no memory for a contact sheet");
    }
    memset(sink->sheet.data, BACKGROUND, sink->sheet.stride * sink->sheet.height);
    *ret = &sink->base;
    return 0;
}
