/* SPDX-License-Identifier: Apache-2.0 */
/* export_pictures.c: a folder of numbered PNG or TIFF files. */
#include <errno.h>
#include <stdlib.h>

#include "export_job.h"
#include "io_path.h"
#include "ttf/dataset/image_file.h"
#include "ttf/dataset/tiff.h"

#define PNG_LEVEL 6

struct picture_sink {
    struct export_sink base; /* first: downcast by address */
    struct ttf_pixbuf coded; /* of PNG: display-encoded */
    uint16_t *display16;     /* of 16-bit PNG, 65536 entries */
};

struct produce_ctx {
    const struct export_job *job;
    const struct ttf_pixbuf *pixels;
};

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    const struct produce_ctx *p = ctx;
    bool colours = !p->job->config->camera_colours && !p->job->values;
    struct ttf_tiff_spec spec = {.icc = colours ? TTF_ICC_LINEAR : TTF_ICC_NONE,
                                 .times = {.start_utc_ns = TTF_NS_UNKNOWN},
                                 .description = export_mark(p->job)};

    if (p->job->config->kind == TTF_EXPORT_PNG)
        return ttf_png_write(io, file, p->pixels, TTF_TRANSFER_SRGB, PNG_LEVEL, export_mark(p->job),
                             err);
    return ttf_tiff_write(io, file, p->pixels, &spec, err);
}

static void encode(struct picture_sink *sink, const struct ttf_pixbuf *rgb16)
{
    for (uint32_t y = 0; y < rgb16->height; y++) {
        const uint16_t *light = ttf_pixbuf_row(rgb16, y);
        uint16_t *row = ttf_pixbuf_row(&sink->coded, y);

        if (!sink->display16) {
            export_display_row(sink->base.job, light, rgb16->width, (uint8_t *)row);
            continue;
        }
        for (size_t i = 0; i < (size_t)rgb16->width * 3; i++)
            row[i] = sink->display16[light[i]];
    }
}

static int picture_frame(struct export_sink *base, uint32_t k, const struct ttf_pixbuf *rgb16,
                         struct ttf_err *err)
{
    struct picture_sink *sink = (struct picture_sink *)base;
    const struct export_job *job = base->job;
    bool png = job->config->kind == TTF_EXPORT_PNG;
    struct produce_ctx ctx = {.job = job, .pixels = png ? &sink->coded : rgb16};
    char *path = ttf_path_format("%s/%s.%04lld.%s", job->staging.temp, job->config->name,
                                 (long long)job->config->start + k, png ? "png" : "tif");
    int code;

    if (!path)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a path");
    if (png)
        encode(sink, rgb16);
    code = staging_write(job->io, path, produce, &ctx, err);
    free(path);
    return code;
}

static int picture_finish(struct export_sink *base, struct ttf_err *err)
{
    return 0;
}

static void picture_destroy(struct export_sink *base)
{
    struct picture_sink *sink = (struct picture_sink *)base;

    ttf_pixbuf_free(&sink->coded);
    free(sink->display16);
    free(sink);
}

static const struct export_sink_ops picture_ops = {
    .frame = picture_frame,
    .finish = picture_finish,
    .destroy = picture_destroy,
};

int export_pictures_open(struct export_job *job, unsigned pass, struct export_sink **ret,
                         struct ttf_err *err)
{
    struct picture_sink *sink = calloc(1, sizeof(*sink));
    bool deep = job->config->png_bits == 16;
    int code = 0;

    if (!sink)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to write pictures");
    sink->base = (struct export_sink){.ops = &picture_ops, .job = job};
    if (job->config->kind == TTF_EXPORT_PNG) {
        code = ttf_pixbuf_alloc(&sink->coded, job->width, job->height, 3,
                                deep ? TTF_SAMPLE_U16 : TTF_SAMPLE_U8);
        if (!code && deep && !(sink->display16 = malloc(65536 * sizeof(*sink->display16))))
            code = -ENOMEM;
    }
    if (code) {
        picture_destroy(&sink->base);
        return ttf_err_set(err, code, NULL, "no memory to write pictures");
    }
    for (unsigned i = 0; sink->display16 && i < 65536; i++)
        sink->display16[i] = (uint16_t)(ttf_srgb_encode((float)i / 65535.0f) * 65535.0f + 0.5f);
    *ret = &sink->base;
    return 0;
}
