/* SPDX-License-Identifier: Apache-2.0 */
/* export.c: options, and the way of frames from a sequence to a sink. */
#include "ttf/dataset/export.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "export_job.h"
#include "io_path.h"

#define FIRST_NUMBER 1001 /* as compositors count: nothing is ever numbered below 0 */

static const struct {
    const char *name;
    export_open_fn *open;
    unsigned passes;
    bool folder;
} kinds[TTF_EXPORT_COUNT] = {
    [TTF_EXPORT_MP4] = {"mp4", export_video_open, 1, false},
    [TTF_EXPORT_GIF] = {"gif", export_video_open, 2, false},
    [TTF_EXPORT_Y4M] = {"y4m", export_y4m_open, 1, false},
    [TTF_EXPORT_PNG] = {"png", export_pictures_open, 1, true},
    [TTF_EXPORT_TIFF] = {"tiff", export_pictures_open, 1, true},
    [TTF_EXPORT_NPY] = {"npy", export_npy_open, 1, false},
    [TTF_EXPORT_SHEET] = {"sheet", export_sheet_open, 1, false},
};

static const char *const gap_names[] = {"hold", "fail", "interpolate"};

const char *ttf_export_kind_name(enum ttf_export_kind kind)
{
    return (unsigned)kind < TTF_EXPORT_COUNT ? kinds[kind].name : "?";
}

int ttf_export_kind_find(const char *name)
{
    for (int i = 0; i < TTF_EXPORT_COUNT; i++) {
        if (strcmp(kinds[i].name, name) == 0)
            return i;
    }
    return -ENOENT;
}

bool ttf_export_has_sidecar_beside(enum ttf_export_kind kind)
{
    return (unsigned)kind < TTF_EXPORT_COUNT && !kinds[kind].folder && kind != TTF_EXPORT_SHEET;
}

const char *ttf_gaps_name(enum ttf_gaps gaps)
{
    return (unsigned)gaps < TTF_COUNT_OF(gap_names) ? gap_names[gaps] : "?";
}

int ttf_gaps_find(const char *name)
{
    for (int i = 0; i < (int)TTF_COUNT_OF(gap_names); i++) {
        if (strcmp(gap_names[i], name) == 0)
            return i;
    }
    return -ENOENT;
}

/* Zeros become what they mean. */
static void set_defaults(struct ttf_export_config *config)
{
    if (!config->name)
        config->name = "frame";
    if (config->start == 0 && !config->from_zero)
        config->start = FIRST_NUMBER;
    if (config->every == 0)
        config->every = 1;
    if (config->fps_num == 0)
        config->fps_num = config->kind == TTF_EXPORT_GIF ? 12 : 24;
    if (config->fps_den == 0)
        config->fps_den = 1;
    if (config->png_bits == 0)
        config->png_bits = 8;
    if (config->chroma == 0)
        config->chroma = 444;
    if (config->sheet_frames == 0)
        config->sheet_frames = 12;
    if (config->sheet_cell == 0)
        config->sheet_cell = 256;
    if (config->kind == TTF_EXPORT_SHEET)
        config->width_max = config->height_max = config->sheet_cell;
}

static int check_config(const struct ttf_export_config *config, struct ttf_err *err)
{
    if ((unsigned)config->kind >= TTF_EXPORT_COUNT ||
        (unsigned)config->gaps >= TTF_COUNT_OF(gap_names))
        return ttf_err_set(err, -EINVAL, NULL, "no such kind of export or of gaps");
    if (config->start < 0)
        return ttf_err_set(err, -EINVAL, "start", "files are numbered from 0 up");
    if (config->png_bits != 8 && config->png_bits != 16)
        return ttf_err_set(err, -EINVAL, "png_bits", "a PNG has 8 or 16 bits, not %u",
                           config->png_bits);
    if (config->chroma != 420 && config->chroma != 444)
        return ttf_err_set(err, -EINVAL, "chroma", "chroma is 420 or 444, not %u", config->chroma);
    if (!(config->white >= 0.0) || config->white > 1e12)
        return ttf_err_set(err, -EINVAL, "white", "white must be above 0");
    if (strchr(config->name, '/') || !config->name[0] || config->name[0] == '.')
        return ttf_err_set(err, -EINVAL, "name", "'%s' is no name of a file", config->name);
    return 0;
}

static int run_pass(struct export_job *job, unsigned pass, struct ttf_err *err)
{
    const struct ttf_export_config *config = job->config;
    unsigned passes = kinds[config->kind].passes;
    struct export_sink *sink;
    int code = kinds[config->kind].open(job, pass, &sink, err);

    if (code)
        return code;
    for (uint32_t k = 0; k < job->n && !code; k++) {
        struct ttf_pixbuf *rgb16;

        code = export_frames_read(job, k, &rgb16, err);
        if (!code)
            code = sink->ops->frame(sink, k, rgb16, err);
        if (!code && config->progress &&
            config->progress(config->progress_ctx, (int64_t)pass * job->n + k + 1,
                             (int64_t)passes * job->n))
            code = ttf_err_set(err, -ECANCELED, NULL, "the export was stopped");
    }
    if (!code)
        code = sink->ops->finish(sink, err);
    sink->ops->destroy(sink);
    return code;
}

struct text {
    char *bytes;
    size_t n;
};

static int put_text(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    const struct text *text = ctx;
    int code = ttf_io_pwrite_all(io, file, text->bytes, text->n, 0);

    if (code)
        return ttf_err_set(err, code, NULL, "the sidecar cannot be written: %s",
                           strerrordesc_np(-code));
    return 0;
}

/* The sidecar of a folder lies inside of it, of a file beside it; a sheet has none. */
static int write_sidecar(struct export_job *job, struct ttf_err *err)
{
    bool folder = kinds[job->config->kind].folder;
    struct text text = {0};
    char *path;
    int code;

    if (!folder && !job->staging.beside)
        return 0;
    path = folder ? ttf_path_format("%s/%s.json", job->staging.temp, job->config->name)
                  : strdup(job->staging.beside_temp);
    code = path ? export_sidecar(job, &text.bytes, &text.n, err)
                : ttf_err_set(err, -ENOMEM, NULL, "no memory for a path");
    if (!code)
        code = staging_write(job->io, path, put_text, &text, err);
    free(text.bytes);
    free(path);
    return code;
}

static int begin(struct export_job *job, struct ttf_err *err)
{
    enum ttf_export_kind kind = job->config->kind;
    int code = staging_begin(&job->staging, job->io, job->config->output, kinds[kind].folder, err);

    if (!code && ttf_export_has_sidecar_beside(kind))
        code = staging_beside(&job->staging, ".json", err);
    return code;
}

static int run_job(struct export_job *job, struct ttf_err *err)
{
    enum ttf_export_kind kind = job->config->kind;
    int code = export_frames_make(job, err);

    if (!code && kind == TTF_EXPORT_SHEET)
        code = export_sheet_choose(job, err);
    if (!code)
        code = export_frames_buffers(job, err);
    if (!code)
        code = begin(job, err);
    for (unsigned pass = 0; pass < kinds[kind].passes && !code; pass++)
        code = run_pass(job, pass, err);
    if (job->side_file)
        job->io->ops->unlink(job->io, job->side_file);
    if (!code)
        code = write_sidecar(job, err);
    if (!code)
        return staging_commit(&job->staging, err);
    staging_name_final(&job->staging, err);
    staging_discard(&job->staging);
    return code;
}

int ttf_export(struct ttf_sequence *sequence, struct ttf_io *io,
               const struct ttf_export_config *given, struct ttf_export_result *ret,
               struct ttf_err *err)
{
    struct ttf_export_config config = *given;
    struct export_job job = {.sequence = sequence, .io = io, .config = &config};
    int code;

    set_defaults(&config);
    code = check_config(&config, err);
    if (!code)
        code = run_job(&job, err);
    if (!code && ret) {
        *ret =
            (struct ttf_export_result){.frames = job.n, .width = job.width, .height = job.height};
        for (uint32_t k = 0; k < job.n; k++)
            ret->invented += job.frame[k].invented;
    }
    free(job.side_file);
    export_frames_free(&job);
    return code;
}
