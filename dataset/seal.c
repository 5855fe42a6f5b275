/* SPDX-License-Identifier: Apache-2.0 */
/* The end of a run: the "end" line, then SHA256SUMS over everything (FORMAT.md, "The seal"). */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "json_read.h"
#include "named_files.h"
#include "record_line.h"
#include "sums.h"
#include "ttf/dataset/hash.h"
#include "walk.h"
#include "writer_private.h"

static int append_end(struct ttf_writer *writer, const char *reason, struct ttf_err *err)
{
    const int64_t *counts = writer->state.counts;
    struct ttf_end_record end = {
        .captured = counts[TTF_RESULT_CAPTURED],
        .partial = counts[TTF_RESULT_PARTIAL],
        .missed = counts[TTF_RESULT_MISSED],
        .failed = counts[TTF_RESULT_FAILED],
        .paused = counts[TTF_RESULT_PAUSED],
        .power = counts[TTF_RESULT_POWER],
    };
    int i, r;

    for (i = 0; i < TTF_RESULT_COUNT; i++)
        end.slots += counts[i];
    ttf_text_cut(end.reason, sizeof(end.reason), reason);
    ttf_end_put(ttf_jsonl_begin(&writer->records, "end"), &end);
    r = ttf_jsonl_append(&writer->records, err);
    if (r == 0)
        writer->ended = true;
    return r;
}

/* Text that grows. */
struct text {
    char *at;
    size_t used, room;
};

static int add_line(struct text *text, const char *hex, const char *path)
{
    size_t n = TTF_SUMS_PREFIX + strlen(path) + 1, room = text->room;
    char *grown;

    while (room - text->used <= n)
        room = room ? room * 2 : 65536;
    if (room != text->room) {
        grown = realloc(text->at, room);
        if (!grown)
            return -ENOMEM;
        text->at = grown;
        text->room = room;
    }
    text->used += (size_t)snprintf(text->at + text->used, room - text->used, "%s  %s\n", hex, path);
    return 0;
}

/*
 * A file that no record names: of a call that failed half-way, or somebody else's.
 * The seal vouches for it, so its bytes and its name are to be on the disk before.
 */
static int hash_durably(struct ttf_writer *writer, const char *path, char ret_hex[65],
                        struct ttf_err *err)
{
    struct ttf_io *io = writer->io;
    char full[TTF_PATH_MAX], folder[TTF_PATH_MAX], *slash;
    int file, r;

    r = ttf_path_put(full, "%s/%s", writer->path, path);
    if (r == 0)
        r = ttf_path_put(folder, "%s", path);
    if (r)
        return ttf_err_set(err, r, path, "this file's name is too long");
    r = file = io->ops->open(io, full, TTF_IO_READ);
    if (file >= 0) {
        r = io->ops->sync(io, file, false);
        if (r == 0)
            r = ttf_sha256_handle_in(io, file, writer->piece, NULL, ret_hex);
        io->ops->close(io, file);
    }
    slash = strrchr(folder, '/');
    if (r == 0 && slash) {
        *slash = '\0';
        r = ttf_writer_folder(writer, folder, err);
        if (r == 0)
            r = ttf_io_sync_parent(io, full);
    }
    if (r && (!err || err->code != r)) /* not told yet */
        ttf_err_set(err, r, path, "cannot be sealed: %s", strerrordesc_np(-r));
    return r;
}

/* The hash that a record gives a file, else that of the file itself. */
static int list_one(struct ttf_writer *writer, const char *path,
                    const struct ttf_named_files *named, struct text *text, struct ttf_err *err)
{
    const struct ttf_named *known = ttf_named_files_find(named, path);
    char hex[65];
    int r;

    if (known)
        return add_line(text, known->sha256, path);
    r = hash_durably(writer, path, hex, err);
    return r ? r : add_line(text, hex, path);
}

/*
 * Every file of the folder, and every file that a record names even if it is gone:
 * then sha256sum and verify say so. Both lists are sorted; they are merged.
 */
static int list_all(struct ttf_writer *writer, const struct ttf_paths *files,
                    const struct ttf_named_files *named, struct text *text, struct ttf_err *err)
{
    size_t i = 0, k = 0;
    int order, r = 0;

    while (r == 0 && (i < files->n || k < named->n)) {
        if (i < files->n && !ttf_is_sealed_file(files->items[i])) {
            i++;
            continue;
        }
        order = i == files->n   ? 1
                : k == named->n ? -1
                                : strcmp(files->items[i], named->items[k].path);
        if (order > 0)
            r = add_line(text, named->items[k].sha256, named->items[k].path);
        else
            r = list_one(writer, files->items[i], named, text, err);
        i += order <= 0;
        k += order >= 0;
    }
    if (r == -ENOMEM)
        ttf_err_set(err, r, writer->path, "no memory for its list of files");
    return r;
}

/* Files that were given up and removed do not come back behind the seal: verify would call them damage. */
static int sync_streams(struct ttf_writer *writer, struct ttf_err *err)
{
    const struct ttf_manifest *m = &writer->manifest;
    struct ttf_io *io = writer->io;
    char path[TTF_PATH_MAX];
    struct ttf_io_stat st;
    unsigned i;
    int r = 0;

    for (i = 0; r == 0 && i < 2 * m->n_streams; i++) {
        r = ttf_path_put(path, "%s/%s/%s", writer->path, i % 2 ? "raw" : "frames",
                         m->streams[i / 2].id);
        if (r == 0 && io->ops->stat(io, path, &st) == 0)
            r = io->ops->sync_dir(io, path);
    }
    return r ? ttf_err_set(err, r, path, "cannot be synced to the disk: %s", strerrordesc_np(-r))
             : 0;
}

static int write_sums(struct ttf_writer *writer, char ret_digest[65], struct ttf_err *err)
{
    struct ttf_named_files named = {0};
    struct ttf_paths files = {0};
    struct text text = {0};
    struct ttf_sha256 hash;
    char *path = ttf_path_format("%s/" TTF_SUMS_NAME, writer->path);
    int r;

    if (!path)
        return ttf_err_set(err, -ENOMEM, writer->path, "no memory");
    r = ttf_named_files_load(writer->io, writer->records.path, &named, err);
    if (r == 0)
        r = ttf_walk(writer->io, writer->path, &files, err);
    if (r == 0)
        r = list_all(writer, &files, &named, &text, err);
    if (r == 0)
        r = sync_streams(writer, err);
    if (r == 0)
        r = ttf_io_write_file(writer->io, path, text.at, text.used, err);
    if (r == 0) {
        ttf_sha256_init(&hash);
        ttf_sha256_add(&hash, text.at, text.used);
        ttf_sha256_hex(&hash, ret_digest);
    }
    free(text.at);
    ttf_paths_free(&files);
    ttf_named_files_free(&named);
    free(path);
    return r;
}

int ttf_writer_seal(struct ttf_writer *writer, const char *reason, char ret_digest[65],
                    struct ttf_err *err)
{
    struct ttf_io *io = writer->io;
    char digest[65], *reserve;
    int r = 0;

    if (writer->manifest.rehearsal)
        return ttf_err_set(err, -EINVAL, writer->path, "is a rehearsal, which is not sealed");
    if (!writer->ended) {
        r = ttf_writer_unseal(writer, err);
        if (r == 0)
            r = append_end(writer, reason, err);
    }
    if (r == 0)
        r = ttf_jsonl_settle(&writer->records, err);
    if (r == 0)
        r = ttf_jsonl_settle(&writer->events, err);
    if (r)
        return r;
    if (writer->sums >= 0)
        io->ops->close(io, writer->sums); /* it will be another file */
    writer->sums = -1;
    ttf_writer_remove_leftovers(writer);
    r = write_sums(writer, digest, err);
    /* Also if that failed: it may have got there, and then it must go before anything else is written. */
    writer->sealed = true;
    if (r)
        return r;
    writer->state.sealed = true;
    writer->sums_behind = false;
    reserve = ttf_path_format("%s/" TTF_RESERVE_NAME, writer->path);
    if (reserve && io->ops->unlink(io, reserve) == 0)
        (void)io->ops->sync_dir(io, writer->path);
    free(reserve);
    if (ret_digest)
        memcpy(ret_digest, digest, sizeof(digest));
    return 0;
}
