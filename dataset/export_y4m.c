/* SPDX-License-Identifier: Apache-2.0 */
/*
 * export_y4m.c: YUV4MPEG2. Its header says nothing of the matrix, and readers then
 * take BT.601 with limited range: so that is what is written (BT.601-7, 2.5), of
 * sRGB-encoded samples. 4:2:0 averages each 2 x 2 (chroma in their middle, "420jpeg").
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "export_job.h"

struct y4m_sink {
    struct export_sink base; /* first: downcast by address */
    struct export_file file;
    uint8_t *rgb;    /* a row */
    uint8_t *planes; /* Y, Cb, Cr, all of full size */
};

static uint8_t clip8(int value)
{
    return value < 0 ? 0 : value > 255 ? 255 : (uint8_t)value;
}

/* Fixed point with 16 fractional bits; the factors of Cb and Cr add up to 0. */
static void split_row(const uint8_t *rgb, uint32_t width, uint8_t *y, uint8_t *cb, uint8_t *cr)
{
    for (uint32_t x = 0; x < width; x++) {
        int r = rgb[3 * x], g = rgb[3 * x + 1], b = rgb[3 * x + 2];

        y[x] = clip8(((16 << 16) + 16829 * r + 33039 * g + 6416 * b + 32768) >> 16);
        cb[x] = clip8(((128 << 16) - 9714 * r - 19071 * g + 28785 * b + 32768) >> 16);
        cr[x] = clip8(((128 << 16) + 28785 * r - 24103 * g - 4682 * b + 32768) >> 16);
    }
}

/* Halves a plane in place; at odd edges the last column or row counts twice. */
static size_t halve(uint8_t *plane, uint32_t width, uint32_t height)
{
    uint32_t half_w = (width + 1) / 2, half_h = (height + 1) / 2;

    for (uint32_t y = 0; y < half_h; y++) {
        const uint8_t *upper = plane + (size_t)2 * y * width;
        const uint8_t *lower = 2 * y + 1 < height ? upper + width : upper;

        for (uint32_t x = 0; x < half_w; x++) {
            uint32_t left = 2 * x, right = 2 * x + 1 < width ? 2 * x + 1 : 2 * x;

            plane[(size_t)y * half_w + x] =
                (uint8_t)((upper[left] + upper[right] + lower[left] + lower[right] + 2) / 4);
        }
    }
    return (size_t)half_w * half_h;
}

static int y4m_frame(struct export_sink *base, uint32_t k, const struct ttf_pixbuf *rgb16,
                     struct ttf_err *err)
{
    struct y4m_sink *sink = (struct y4m_sink *)base;
    const struct export_job *job = base->job;
    size_t size = (size_t)rgb16->width * rgb16->height, chroma = size;
    uint8_t *cb = sink->planes + size, *cr = cb + size;
    int code;

    for (uint32_t y = 0; y < rgb16->height; y++) {
        size_t at = (size_t)y * rgb16->width;

        export_display_row(job, ttf_pixbuf_row(rgb16, y), rgb16->width, sink->rgb);
        split_row(sink->rgb, rgb16->width, sink->planes + at, cb + at, cr + at);
    }
    if (job->config->chroma == 420) {
        chroma = halve(cb, rgb16->width, rgb16->height);
        halve(cr, rgb16->width, rgb16->height);
    }
    code = export_file_put(&sink->file, "FRAME\n", 6, err);
    if (!code)
        code = export_file_put(&sink->file, sink->planes, size, err);
    if (!code)
        code = export_file_put(&sink->file, cb, chroma, err);
    if (!code)
        code = export_file_put(&sink->file, cr, chroma, err);
    return code;
}

static int y4m_finish(struct export_sink *base, struct ttf_err *err)
{
    return 0; /* synced with its renaming */
}

static void y4m_destroy(struct export_sink *base)
{
    struct y4m_sink *sink = (struct y4m_sink *)base;

    export_file_close(&sink->file);
    free(sink->rgb);
    free(sink->planes);
    free(sink);
}

static const struct export_sink_ops y4m_ops = {
    .frame = y4m_frame,
    .finish = y4m_finish,
    .destroy = y4m_destroy,
};

static int put_header(struct y4m_sink *sink, struct ttf_err *err)
{
    const struct export_job *job = sink->base.job;
    char header[160];
    int n = snprintf(header, sizeof(header),
                     "YUV4MPEG2 W%u H%u F%u:%u Ip A1:1 C%s XCOLORRANGE=LIMITED%s%s\n", job->width,
                     job->height, job->config->fps_num, job->config->fps_den,
                     job->config->chroma == 420 ? "420jpeg" : "444", export_mark(job) ? " X" : "",
                     export_mark(job) ? export_mark(job) : "");

    return export_file_put(&sink->file, header, (size_t)n, err);
}

int export_y4m_open(struct export_job *job, unsigned pass, struct export_sink **ret,
                    struct ttf_err *err)
{
    struct y4m_sink *sink = calloc(1, sizeof(*sink));
    int code = 0;

    if (!sink)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to write a video");
    sink->base = (struct export_sink){.ops = &y4m_ops, .job = job};
    sink->file.handle = -1;
    sink->rgb = malloc((size_t)job->width * 3);
    sink->planes = malloc((size_t)job->width * job->height * 3);
    if (!sink->rgb || !sink->planes)
        code = ttf_err_set(err, -ENOMEM, NULL, "no memory to write a video");
    if (!code)
        code = export_file_open(&sink->file, job, err);
    if (!code)
        code = put_header(sink, err);
    if (code) {
        y4m_destroy(&sink->base);
        return code;
    }
    *ret = &sink->base;
    return 0;
}
