/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A calibration's folder, copied into the dataset: its files, calibration.json the last of them, then its line. Cut off before
 * that, it is no calibration, and opening the dataset clears it away.
 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "manifest_rules.h"
#include "ttf/dataset/hash.h"
#include "walk.h"
#include "writer_private.h"

#define PIECE_BYTES ((size_t)256 * 1024)

static int list_name(void *ctx, const char *name, bool is_dir)
{
    if (is_dir || name[0] == '.' || ttf_is_temporary(name))
        return 0;
    return ttf_name_ok(name) ? ttf_paths_add(ctx, name) : -EILSEQ;
}

/* In order, but for calibration.json: a folder without it holds no calibration, so it comes last, as calibrate writes it. */
static void put_in_order(struct ttf_paths *names)
{
    ttf_paths_sort(names);
    for (size_t i = 0; i + 1 < names->n; i++)
        if (strcmp(names->items[i], "calibration.json") == 0) {
            char *last = names->items[i];

            names->items[i] = names->items[i + 1];
            names->items[i + 1] = last;
        }
}

/* Copies all bytes and hashes them on the way. */
static int copy_bytes(struct ttf_io *io, int from, int to, int64_t *ret_bytes, char ret_hex[65])
{
    void *piece = malloc(PIECE_BYTES);
    struct ttf_sha256 hash;
    int64_t at = 0, got;
    int r = 0;

    if (!piece)
        return -ENOMEM;
    ttf_sha256_init(&hash);
    while (r == 0 && (got = ttf_io_pread_all(io, from, piece, PIECE_BYTES, at)) != 0) {
        if (got < 0) {
            r = (int)got;
            break;
        }
        ttf_sha256_add(&hash, piece, (size_t)got);
        r = ttf_io_append_all(io, to, piece, (size_t)got);
        at += got;
    }
    free(piece);
    *ret_bytes = at;
    ttf_sha256_hex(&hash, ret_hex);
    return r;
}

/* Temporary name, sync, rename; the folder is synced once, by the caller. */
static int copy_file(struct ttf_io *io, const char *from, const char *to, int64_t *ret_bytes,
                     char ret_hex[65], struct ttf_err *err)
{
    char *temporary = ttf_path_format("%s.tmp", to);
    int in = -1, out = -1, closed, r = -ENOMEM;

    if (!temporary)
        goto out;
    (void)io->ops->unlink(io, temporary);
    r = in = io->ops->open(io, from, TTF_IO_READ);
    if (in < 0)
        goto out;
    r = out = io->ops->open(io, temporary, TTF_IO_CREATE_NEW);
    if (out < 0)
        goto out;
    r = copy_bytes(io, in, out, ret_bytes, ret_hex);
    if (r == 0)
        r = io->ops->sync(io, out, false);
    closed = io->ops->close(io, out);
    r = r ? r : closed;
    if (r == 0)
        r = io->ops->rename(io, temporary, to);
    if (r)
        (void)io->ops->unlink(io, temporary);
out:
    if (in >= 0)
        io->ops->close(io, in);
    free(temporary);
    return r < 0
               ? ttf_err_set(err, r, to, "cannot be copied from %s: %s", from, strerrordesc_np(-r))
               : 0;
}

static int copy_named(struct ttf_writer *writer, const char *id, const char *folder,
                      const char *name, struct ttf_json *json, struct ttf_err *err)
{
    char *path = ttf_path_format("calibration/%s/%s", id, name);
    char *to = path ? ttf_path_format("%s/%s", writer->path, path) : NULL;
    char *from = ttf_path_format("%s/%s", folder, name);
    int64_t bytes = 0;
    char hex[65];
    int r;

    if (!to || !from)
        r = ttf_err_set(err, -ENOMEM, id, "no memory");
    else
        r = copy_file(writer->io, from, to, &bytes, hex, err);
    if (r == 0) {
        ttf_json_object(json);
        ttf_json_kstring(json, "path", path);
        ttf_json_kint(json, "bytes", bytes);
        ttf_json_kstring(json, "sha256", hex);
        ttf_json_object_end(json);
    }
    free(from);
    free(to);
    free(path);
    return r;
}

static int copy_folder(struct ttf_writer *writer, const char *id, const char *folder,
                       struct ttf_json *json, struct ttf_err *err)
{
    char *to = ttf_path_format("%s/calibration/%s", writer->path, id);
    struct ttf_io *io = writer->io;
    struct ttf_paths names = {0};
    size_t i;
    int r;

    r = to ? io->ops->list(io, folder, list_name, &names) : -ENOMEM;
    if (r == 0 && names.n == 0)
        r = -ENOENT;
    if (r) {
        ttf_err_set(err, r, folder, "is no calibration that can be copied: %s",
                    strerrordesc_np(-r));
        goto out;
    }
    put_in_order(&names);
    r = ttf_writer_folder(writer, to + strlen(writer->path) + 1, err);
    for (i = 0; r == 0 && i < names.n; i++)
        r = copy_named(writer, id, folder, names.items[i], json, err);
    if (r == 0) {
        r = io->ops->sync_dir(io, to);
        if (r)
            ttf_err_set(err, r, to, "cannot be synced to the disk: %s", strerrordesc_np(-r));
    }
out:
    ttf_paths_free(&names);
    free(to);
    return r;
}

int ttf_writer_calibration(struct ttf_writer *writer, const char *id, const char *folder,
                           struct ttf_err *err)
{
    struct ttf_json *json;
    unsigned i;
    int r;

    if (!ttf_name_ok(id) || strlen(id) > 63)
        return ttf_err_set(err, -EINVAL, id, "is no name for a calibration");
    for (i = 0; i < writer->n_calibrations; i++)
        if (strcmp(writer->calibrations[i], id) == 0)
            return 0;
    r = ttf_writer_room_for_calibration(writer);
    if (r)
        return ttf_err_set(err, r, id, "no memory");
    r = ttf_writer_unseal(writer, err);
    if (r)
        return r;
    json = ttf_jsonl_begin(&writer->records, "calibration");
    ttf_json_kstring(json, "id", id);
    ttf_json_key(json, "files");
    ttf_json_array(json);
    r = copy_folder(writer, id, folder, json, err);
    ttf_json_array_end(json);
    if (r == 0)
        r = ttf_jsonl_append(&writer->records, err);
    if (r)
        return r;
    writer->ended = false;
    r = ttf_writer_learn_calibration(writer, id);
    return r ? ttf_err_set(err, r, id, "no memory") : 0;
}
