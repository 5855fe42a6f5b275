/* SPDX-License-Identifier: Apache-2.0 */
/* export_video.c: mp4 and gif, through ffmpeg. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "export_job.h"
#include "io_path.h"
#include "video_child.h"

#define PALETTE_FRAMES 32 /* frames that a gif's colours are chosen from */
#define ARGUMENTS_MAX  48
#define SIMULATED      "SIMULATED"
#define TO_YUV420P \
    "scale=out_color_matrix=bt709:out_range=tv:flags=accurate_rnd+full_chroma_inp,format=yuv420p"

struct video_sink {
    struct export_sink base; /* first: downcast by address */
    struct video_child child;
    uint32_t width, height; /* as handed over */
    uint32_t step;          /* only each step-th frame goes in */
    uint8_t *row;
    bool gif_whole; /* this pass writes the gif itself */
};

/* ffmpeg writes no comments into a gif: one goes before its last byte, the trailer (GIF89a, 24, 27). */
static int mark_gif(struct export_job *job, struct ttf_err *err)
{
    static const char comment[] = "\x21\xfe\x09" SIMULATED "\0\x3b";
    struct ttf_io *io = job->io;
    const char *path = job->staging.temp;
    int file = io->ops->open(io, path, TTF_IO_APPEND);
    int64_t size = 0;
    char last = 0;
    int code = file < 0 ? file : io->ops->size(io, file, &size);

    if (!code && (size < 1 || io->ops->pread(io, file, &last, 1, size - 1) != 1 || last != '\x3b'))
        code = -EPROTO;
    if (!code)
        code = io->ops->truncate(io, file, size - 1);
    if (!code)
        code = ttf_io_append_all(io, file, comment, sizeof(comment) - 1);
    if (file >= 0)
        io->ops->close(io, file);
    if (code)
        return ttf_err_set(err, code, path, "cannot be marked as simulated: %s",
                           strerrordesc_np(-code));
    return 0;
}

static int video_frame(struct export_sink *base, uint32_t k, const struct ttf_pixbuf *rgb16,
                       struct ttf_err *err)
{
    struct video_sink *sink = (struct video_sink *)base;
    int code = 0;

    if (k % sink->step != 0)
        return 0;
    for (uint32_t y = 0; y < sink->height && !code; y++) {
        uint8_t *last = sink->row + (size_t)(rgb16->width - 1) * 3;

        export_display_row(base->job,
                           ttf_pixbuf_row(rgb16, y < rgb16->height ? y : rgb16->height - 1),
                           rgb16->width, sink->row);
        if (sink->width > rgb16->width)
            memcpy(last + 3, last, 3);
        code = video_child_write(&sink->child, sink->row, (size_t)sink->width * 3, err);
    }
    return code;
}

static int video_finish(struct export_sink *base, struct ttf_err *err)
{
    struct video_sink *sink = (struct video_sink *)base;

    int code = video_child_finish(&sink->child, err);

    if (!code && sink->gif_whole && export_mark(base->job))
        code = mark_gif(base->job, err);
    return code;
}

static void video_destroy(struct export_sink *base)
{
    struct video_sink *sink = (struct video_sink *)base;

    video_child_stop(&sink->child);
    free(sink->row);
    free(sink);
}

static const struct export_sink_ops video_ops = {
    .frame = video_frame,
    .finish = video_finish,
    .destroy = video_destroy,
};

struct arguments {
    const char *arg[ARGUMENTS_MAX];
    unsigned n;
};

static void put_all(struct arguments *arguments, const char *const list[])
{
    for (unsigned i = 0; list[i] && arguments->n < ARGUMENTS_MAX - 1; i++)
        arguments->arg[arguments->n++] = list[i];
    arguments->arg[arguments->n] = NULL;
}

static void put_output(struct arguments *arguments, const struct export_job *job, unsigned pass,
                       const char *palette, const char *output)
{
    if (job->config->kind == TTF_EXPORT_MP4 && export_mark(job))
        put_all(arguments, (const char *const[]){"-metadata", "comment=" SIMULATED, "-metadata",
                                                 "title=" SIMULATED, NULL});
    if (job->config->kind == TTF_EXPORT_MP4)
        put_all(arguments, (const char *const[]){"-vf",
                                                 TO_YUV420P,
                                                 "-c:v",
                                                 "libx264",
                                                 "-preset",
                                                 "medium",
                                                 "-crf",
                                                 "18",
                                                 "-colorspace",
                                                 "bt709",
                                                 "-color_primaries",
                                                 "bt709",
                                                 "-color_trc",
                                                 "bt709",
                                                 "-color_range",
                                                 "tv",
                                                 "-movflags",
                                                 "+faststart",
                                                 "-f",
                                                 "mp4",
                                                 output,
                                                 NULL});
    else if (pass == 0)
        put_all(arguments,
                (const char *const[]){"-vf", "palettegen", "-frames:v", "1", "-f", "image2", "-c:v",
                                      "png", "-update", "1", palette, NULL});
    else
        put_all(arguments,
                (const char *const[]){"-i", palette, "-lavfi",
                                      "paletteuse=dither=bayer:bayer_scale=3:diff_mode=rectangle",
                                      "-f", "gif", output, NULL});
}

/*
 * Raw frames at its stdin; "file:" so that no name is taken for an option or a protocol. Without -xerror ffmpeg says
 * that the disk did not take the end of its file, and ends as if it had.
 */
static int start(struct video_sink *sink, unsigned pass, struct ttf_err *err)
{
    struct export_job *job = sink->base.job;
    const char *program = job->config->ffmpeg ? job->config->ffmpeg : "ffmpeg";
    struct arguments arguments = {.n = 0};
    char size[32], rate[32];
    char *output = ttf_path_format("file:%s", job->staging.temp);
    char *palette = job->side_file ? ttf_path_format("file:%s", job->side_file) : NULL;
    int code;

    if (!output || (job->side_file && !palette)) {
        free(output);
        free(palette);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a path");
    }
    snprintf(size, sizeof(size), "%ux%u", sink->width, sink->height);
    snprintf(rate, sizeof(rate), "%u/%u", job->config->fps_num, job->config->fps_den);
    put_all(&arguments, (const char *const[]){program, "-nostdin", "-v", "error", "-xerror", "-y",
                                              "-f", "rawvideo", "-pix_fmt", "rgb24", "-video_size",
                                              size, "-framerate", rate, "-i", "pipe:0", NULL});
    put_output(&arguments, job, pass, palette, output);
    code = video_child_start(&sink->child, arguments.arg, VIDEO_WRITE, err);
    free(output);
    free(palette);
    return code;
}

int export_video_open(struct export_job *job, unsigned pass, struct export_sink **ret,
                      struct ttf_err *err)
{
    struct video_sink *sink = calloc(1, sizeof(*sink));
    bool gif = job->config->kind == TTF_EXPORT_GIF;
    int code = 0;

    if (!sink)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to write a video");
    sink->base = (struct export_sink){.ops = &video_ops, .job = job};
    sink->child.pid = sink->child.in = sink->child.out = sink->child.messages = -1;
    /* Chroma of half the size needs even sides: an odd edge is doubled. */
    sink->width = gif ? job->width : (job->width + 1) / 2 * 2;
    sink->height = gif ? job->height : (job->height + 1) / 2 * 2;
    sink->step = gif && pass == 0 ? (job->n + PALETTE_FRAMES - 1) / PALETTE_FRAMES : 1;
    sink->row = malloc((size_t)sink->width * 3);
    sink->gif_whole = gif && pass == 1;
    if (gif && !job->side_file)
        job->side_file = ttf_path_format("%s.palette", job->staging.temp);
    if (!sink->row || (gif && !job->side_file))
        code = ttf_err_set(err, -ENOMEM, NULL, "no memory to write a video");
    if (!code)
        code = start(sink, pass, err);
    if (code) {
        video_destroy(&sink->base);
        return code;
    }
    *ret = &sink->base;
    return 0;
}
