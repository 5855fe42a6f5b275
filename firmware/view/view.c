/* SPDX-License-Identifier: Apache-2.0 */
/* view.c: see ttf/view/view.h. */
#include "ttf/view/view.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "file.h"
#include "page.h"
#include "panel.h"

#define TRIES_MAX 6
#define OVERHEAD  INT64_C(200000) /* the page itself, and a line around each picture */

struct job {
    struct ttf_io *io;
    const struct ttf_view_config *config;
    struct view_panel panel[TTF_VIEW_PANELS_MAX];
    unsigned n;
    int64_t bytes_max;
    struct ttf_pool *pool;
    char temp[PATH_MAX];
    struct view_file file;
};

static int check(const struct ttf_view_config *config, unsigned n, struct ttf_err *err)
{
    if (n < 1 || n > TTF_VIEW_PANELS_MAX)
        return ttf_err_set(err, -EINVAL, NULL, "one texture or two are shown");
    if (config->bytes_max < 0 || config->bytes_max > TTF_VIEW_BYTES_MAX ||
        (config->bytes_max && config->bytes_max < 2 * OVERHEAD))
        return ttf_err_set(err, -EINVAL, NULL, "a file of %lld bytes is none that can be made",
                           (long long)config->bytes_max);
    if (config->frames_max > TTF_VIEW_FRAMES_MAX)
        return ttf_err_set(err, -EINVAL, NULL, "at most %d frames", TTF_VIEW_FRAMES_MAX);
    if (config->side_max > TTF_VIEW_SIDE_MAX)
        return ttf_err_set(err, -EINVAL, NULL, "sides of at most %d pixels", TTF_VIEW_SIDE_MAX);
    return 0;
}

static int put_frames(struct job *job, unsigned p, int64_t done, int64_t total, struct ttf_err *err)
{
    struct view_panel *panel = &job->panel[p];

    for (uint32_t at = 0; at < panel->n;) {
        uint32_t n = panel->n - at < panel->n_slots ? panel->n - at : panel->n_slots;
        int code = 0;

        if (job->config->progress &&
            job->config->progress(job->config->progress_ctx, done + at, total))
            return ttf_err_set(err, -ECANCELED, NULL, "stopped");
        code = view_panel_pictures(panel, panel->frame + at, n, err);
        if (code)
            return code;
        for (uint32_t i = 0; i < n; i++)
            page_picture(&job->file, p, panel->slot[i].picture.data, panel->slot[i].picture.bytes);
        if (job->file.code || view_file_bytes(&job->file) > job->bytes_max)
            return 0; /* whoever called sees either */
        at += n;
    }
    return 0;
}

static int put_all(struct job *job, struct ttf_err *err)
{
    int64_t total = 0, done = 0;
    int code = job->io->ops->truncate(job->io, job->file.handle, 0);

    if (code)
        return ttf_err_set(err, code, job->temp, "cannot be written: %s", strerrordesc_np(-code));
    job->file.offset = 0;
    job->file.used = 0;
    for (unsigned p = 0; p < job->n; p++)
        total += job->panel[p].n;
    code = page_head(&job->file, job->panel, job->n, err);
    for (unsigned p = 0; p < job->n && !code; p++) {
        code = put_frames(job, p, done, total, err);
        done += job->panel[p].n;
    }
    if (code)
        return code;
    page_tail(&job->file);
    return view_file_flush(&job->file, err);
}

/* Again and smaller, should the trial's frames have been the easy ones. */
static int write_small_enough(struct job *job, struct ttf_err *err)
{
    for (int tries = 0; tries < TRIES_MAX; tries++) {
        bool smaller = false;
        int code = put_all(job, err);

        if (code || job->file.offset <= job->bytes_max)
            return code;
        for (unsigned p = 0; p < job->n; p++) {
            if (job->panel[p].exact) {
                job->panel[p].exact = false;
                smaller = true;
            } else {
                smaller |= view_panel_shrink(&job->panel[p], 0.88);
            }
        }
        if (!smaller)
            break;
    }
    ttf_err_set(err, -EFBIG, job->config->output, "the frames do not fit into %lld bytes",
                (long long)job->bytes_max);
    ttf_err_hint(err, "take fewer frames");
    return -EFBIG;
}

/* Hidden, in the same folder, of this process: nobody else's file is in its way. */
static bool name_temp(const char *output, char *ret, size_t size)
{
    const char *slash = strrchr(output, '/'), *base = slash ? slash + 1 : output;

    return snprintf(ret, size, "%.*s.%.40s.part-%ld", (int)(base - output), output, base,
                    (long)getpid()) < (int)size;
}

static int begin(struct job *job, struct ttf_err *err)
{
    const char *output = job->config->output;
    struct ttf_io_stat st;
    int code = job->io->ops->stat(job->io, output, &st);

    if (code == 0 && st.is_dir)
        return ttf_err_set(err, -EISDIR, output, "is a folder");
    if (!name_temp(output, job->temp, sizeof job->temp))
        return ttf_err_set(err, -ENAMETOOLONG, output, "the path is too long");
    (void)job->io->ops->unlink(job->io, job->temp); /* of a process of the same number, long ago */
    job->file.io = job->io;
    job->file.path = job->temp;
    job->file.handle = job->io->ops->open(job->io, job->temp, TTF_IO_CREATE_NEW);
    if (job->file.handle < 0)
        return ttf_err_set(err, job->file.handle, job->temp, "cannot be created: %s",
                           strerrordesc_np(-job->file.handle));
    return 0;
}

/* Synced and under its name, or gone. */
static int finish(struct job *job, int code, struct ttf_err *err)
{
    struct ttf_io *io = job->io;
    char folder[PATH_MAX];
    char *slash;

    if (job->file.handle < 0)
        return code;
    if (!code) {
        code = io->ops->sync(io, job->file.handle, false);
        if (code)
            ttf_err_set(err, code, job->temp, "cannot be synced: %s", strerrordesc_np(-code));
    }
    io->ops->close(io, job->file.handle);
    if (!code) {
        code = io->ops->rename(io, job->temp, job->config->output);
        if (code)
            ttf_err_set(err, code, job->config->output, "cannot be named: %s",
                        strerrordesc_np(-code));
    }
    if (code) {
        (void)io->ops->unlink(io, job->temp);
        return code;
    }
    (void)snprintf(folder, sizeof folder, "%s", job->config->output);
    slash = strrchr(folder, '/');
    if (slash)
        slash[slash == folder] = '\0';
    code = io->ops->sync_dir(io, slash ? folder : ".");
    return code ? ttf_err_set(err, code, job->config->output, "its folder cannot be synced: %s",
                              strerrordesc_np(-code))
                : 0;
}

static int prepare(struct job *job, const struct ttf_view_texture *textures, struct ttf_err *err)
{
    int code = 0;

    job->pool = ttf_pool_create(job->config->threads);
    if (!job->pool)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for threads");
    for (unsigned p = 0; p < job->n && !code; p++) {
        code = view_panel_init(&job->panel[p], &textures[p], job->config, job->pool, err);
        if (!code)
            code = view_panel_fit(&job->panel[p], job->config,
                                  (job->bytes_max - OVERHEAD) / (int64_t)job->n, err);
    }
    return code;
}

static void say(const struct job *job, struct ttf_view_result *ret)
{
    ret->bytes = job->file.offset;
    for (unsigned p = 0; p < job->n; p++) {
        ret->panel[p].frames = job->panel[p].n;
        ret->panel[p].width = job->panel[p].width;
        ret->panel[p].height = job->panel[p].height;
        ret->panel[p].exact = job->panel[p].exact;
    }
}

int ttf_view_write(const struct ttf_view_texture *textures, unsigned n, struct ttf_io *io,
                   const struct ttf_view_config *config, struct ttf_view_result *ret,
                   struct ttf_err *err)
{
    struct job *job;
    int code = check(config, n, err);

    if (code)
        return code;
    job = calloc(1, sizeof(*job));
    if (!job)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory for a view");
    job->io = io;
    job->config = config;
    job->n = n;
    job->bytes_max = config->bytes_max ? config->bytes_max : TTF_VIEW_BYTES_MAX;
    job->file.handle = -1;
    code = begin(job, err);
    if (!code)
        code = prepare(job, textures, err);
    if (!code)
        code = write_small_enough(job, err);
    code = finish(job, code, err);
    if (!code && ret)
        say(job, ret);
    for (unsigned p = 0; p < n; p++)
        view_panel_free(&job->panel[p]);
    ttf_pool_destroy(job->pool);
    free(job);
    return code;
}
