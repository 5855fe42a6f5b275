/* SPDX-License-Identifier: Apache-2.0 */
/* One image file on its way to the disk (DESIGN.md, "Commit of a slot"). */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "io_hashing.h"
#include "io_path.h"
#include "manifest_rules.h"
#include "writer_private.h"

#define UNANSWERED_MAX 8 /* names that cannot even be asked for */

/* What one attempt at a file needs. */
struct attempt {
    struct ttf_writer *writer;
    ttf_produce_fn *produce;
    void *ctx;
    const char *path; /* relative */
    char full[TTF_PATH_MAX], temporary[TTF_PATH_MAX];
};

/* A failure that another name, and so other blocks of the disk, may not meet again. */
static bool worth_another_name(int r)
{
    return r == -EIO || r == -EUCLEAN || r == -ENXIO || r == -EREMOTEIO;
}

/* Whole, but of no record, and its name is not for sure: the seal must not promise that it is there. */
static void remember_leftover(struct ttf_writer *writer, const char *path)
{
    if (writer->n_leftovers < TTF_COUNT_OF(writer->leftovers))
        snprintf(writer->leftovers[writer->n_leftovers++], sizeof(writer->leftovers[0]), "%s",
                 path);
}

void ttf_writer_remove_leftovers(struct ttf_writer *writer)
{
    char full[TTF_PATH_MAX];
    unsigned i;

    for (i = 0; i < writer->n_leftovers; i++)
        if (ttf_path_put(full, "%s/%s", writer->path, writer->leftovers[i]) == 0)
            (void)writer->io->ops->unlink(writer->io, full);
    writer->n_leftovers = 0;
}

/* Writes, syncs, renames, syncs the folder. What it leaves on failure is removed as well as can be. */
static int attempt(struct attempt *a, struct ttf_file_ref *ret, struct ttf_err *err)
{
    struct ttf_io *io = a->writer->io;
    struct ttf_io_hashing hashing;
    const char *step = "cannot be made";
    int file, r, closed;

    file = io->ops->open(io, a->temporary, TTF_IO_CREATE_NEW);
    if (file < 0)
        return ttf_err_set(err, file, a->path, "%s: %s", step, strerrordesc_np(-file));
    ttf_io_hashing_init(&hashing, io, file);
    r = a->produce(a->ctx, &hashing.io, file, err);
    if (r < 0) {
        io->ops->close(io, file);
        io->ops->unlink(io, a->temporary);
        if (err && err->code != r) /* not told yet */
            ttf_err_set(err, r, a->path, "cannot be written: %s", strerrordesc_np(-r));
        return r;
    }
    step = "cannot be synced to the disk";
    r = io->ops->sync(io, file, false);
    if (r == 0) {
        step = "cannot be read back";
        r = ttf_io_hashing_result(&hashing, a->writer->piece, &ret->bytes, ret->sha256);
    }
    closed = io->ops->close(io, file);
    if (r == 0 && closed) {
        step = "cannot be closed";
        r = closed;
    }
    if (r == 0) {
        step = "cannot be renamed";
        r = io->ops->rename(io, a->temporary, a->full);
    }
    if (r) {
        io->ops->unlink(io, a->temporary);
        return ttf_err_set(err, r, a->path, "%s: %s", step, strerrordesc_np(-r));
    }
    r = ttf_io_sync_parent(io, a->full);
    if (r) {
        if (io->ops->unlink(io, a->full) != 0)
            remember_leftover(a->writer, a->path);
        return ttf_err_set(err, r, a->path, "its folder cannot be synced to the disk: %s",
                           strerrordesc_np(-r));
    }
    return 0;
}

/* frames/main/000012.b1.mask.r1.tif: the parts that apply. */
static int make_path(struct ttf_file_ref *ref, const char *stream, int64_t index, int bracket,
                     const char *extension, int retry)
{
    bool raw = strcmp(ref->role, "raw") == 0;
    char b[24] = "", role[24] = "", again[24] = "";
    int n;

    if (bracket >= 0)
        snprintf(b, sizeof(b), ".b%d", bracket);
    if (!raw && strcmp(ref->role, "developed") != 0)
        snprintf(role, sizeof(role), ".%s", ref->role);
    if (retry > 0)
        snprintf(again, sizeof(again), ".r%d", retry);
    n = snprintf(ref->path, sizeof(ref->path), "%s/%s/%06lld%s%s%s.%s", raw ? "raw" : "frames",
                 stream, (long long)index, b, role, again, extension);
    return n < (int)sizeof(ref->path) && ttf_path_ok(ref->path) ? 0 : -EINVAL;
}

/* The first name from `retry` on that nothing on the disk has. */
static int free_name(struct ttf_writer *writer, struct ttf_file_ref *ref, const char *stream,
                     int64_t index, int bracket, const char *extension, int *retry,
                     char full[TTF_PATH_MAX])
{
    struct ttf_io_stat st;
    int r, unanswered = 0;

    for (;; (*retry)++) {
        r = make_path(ref, stream, index, bracket, extension, *retry);
        if (r)
            return r;
        r = ttf_path_put(full, "%s/%s", writer->path, ref->path);
        if (r)
            return r;
        r = writer->io->ops->stat(writer->io, full, &st);
        if (r == -ENOENT)
            return 0;
        /* One name may lie on bad blocks; a disk that is gone answers none. */
        if (r && (r != -EIO || ++unanswered == UNANSWERED_MAX))
            return r;
    }
}

static int one_try(struct attempt *a, struct ttf_file_ref *ref, const char *stream, int64_t index,
                   int bracket, const char *extension, int *retry, struct ttf_err *err)
{
    struct ttf_io *io = a->writer->io;
    int r;

    r = free_name(a->writer, ref, stream, index, bracket, extension, retry, a->full);
    if (r == 0)
        r = ttf_path_put(a->temporary, "%s.tmp", a->full);
    if (r)
        return ttf_err_set(err, r, ref->path, "no name can be had for this file: %s",
                           strerrordesc_np(-r));
    a->path = ref->path;
    (void)io->ops->unlink(io, a->temporary);
    return attempt(a, ref, err);
}

/* frames/STREAM or raw/STREAM. Its name is made durable once; later it is only made sure that it is there. */
static int make_folder(struct ttf_writer *writer, bool raw, const char *stream, struct ttf_err *err)
{
    const struct ttf_stream *at = ttf_manifest_stream(&writer->manifest, stream);
    uint32_t *durable = raw ? &writer->raw_durable : &writer->frames_durable;
    uint32_t bit = UINT32_C(1) << (at - writer->manifest.streams);
    char folder[TTF_PATH_MAX];
    int r;

    if (*durable & bit)
        r = ttf_path_put(folder, "%s/%s/%s", writer->path, raw ? "raw" : "frames", stream);
    else
        r = ttf_path_put(folder, "%s/%s", raw ? "raw" : "frames", stream);
    if (r)
        return ttf_err_set(err, r, stream, "its folder's name is too long");
    if (*durable & bit)
        return ttf_io_mkdirs(writer->io, folder, err);
    r = ttf_writer_folder(writer, folder, err);
    if (r == 0)
        *durable |= bit;
    return r;
}

int ttf_writer_file(struct ttf_writer *writer, const char *role, const char *stream, int64_t index,
                    int bracket, const char *extension, ttf_produce_fn *produce, void *ctx,
                    struct ttf_file_ref *ret, struct ttf_err *err)
{
    struct attempt a = {.writer = writer, .produce = produce, .ctx = ctx};
    struct ttf_file_ref ref = {0};
    int r, retry = 0;

    if (!ttf_name_ok(role) || strlen(role) >= sizeof(ref.role) ||
        !ttf_manifest_stream(&writer->manifest, stream) || index < 0 || !ttf_name_ok(extension))
        return ttf_err_set(err, -EINVAL, stream,
                           "no file of role \"%s\", stream \"%s\", extension \"%s\" can be named",
                           role, stream, extension);
    r = ttf_writer_unseal(writer, err);
    if (r)
        return r;
    snprintf(ref.role, sizeof(ref.role), "%s", role);
    r = make_folder(writer, strcmp(role, "raw") == 0, stream, err);
    if (r)
        return r;
    r = one_try(&a, &ref, stream, index, bracket, extension, &retry, err);
    if (worth_another_name(r)) {
        retry++;
        if (err)
            *err = (struct ttf_err){0};
        r = one_try(&a, &ref, stream, index, bracket, extension, &retry, err);
    }
    if (r < 0)
        return r;
    *ret = ref;
    return 0;
}
