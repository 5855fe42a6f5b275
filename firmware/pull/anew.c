/* SPDX-License-Identifier: Apache-2.0 */
#include "anew.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "ttf/dataset/hash.h"

#define PATH_SIZE 4600
#define MARK      "%s/pull.tmp" /* belongs to no dataset */

bool anew_is_marked(struct ttf_io *io, const char *folder)
{
    char path[PATH_SIZE];
    struct ttf_io_stat st;

    (void)snprintf(path, sizeof path, MARK, folder);
    return io->ops->stat(io, path, &st) != -ENOENT;
}

/* Seen is enough: whoever looks for it after a power cut sees what is on the disk. */
int anew_mark(struct ttf_io *io, const char *folder, struct ttf_err *err)
{
    char path[PATH_SIZE];
    int file;

    (void)snprintf(path, sizeof path, MARK, folder);
    file = io->ops->open(io, path, TTF_IO_CREATE_NEW);
    if (file >= 0)
        (void)io->ops->close(io, file);
    if (file >= 0 || file == -EEXIST)
        return 0;
    return ttf_err_set(err, file, path, "cannot be made: %s", strerrordesc_np(-file));
}

void anew_unmark(struct ttf_io *io, const char *folder)
{
    char path[PATH_SIZE];

    (void)snprintf(path, sizeof path, MARK, folder);
    (void)io->ops->unlink(io, path);
}

static int copy(struct ttf_io *io, int from, int to, struct ttf_sha256 *hash)
{
    unsigned char piece[65536];
    int64_t at = 0, got;
    int r = 0;

    while (r == 0 && (got = ttf_io_pread_all(io, from, piece, sizeof piece, at)) != 0) {
        if (got < 0)
            return (int)got;
        ttf_sha256_add(hash, piece, (size_t)got);
        r = ttf_io_pwrite_all(io, to, piece, (size_t)got, at);
        at += got;
    }
    return r;
}

static int sync_folder_of(struct ttf_io *io, const char *path)
{
    char folder[PATH_SIZE];
    char *slash;

    (void)snprintf(folder, sizeof folder, "%s", path);
    slash = strrchr(folder, '/');
    if (!slash)
        return 0;
    *slash = '\0';
    return io->ops->sync_dir(io, folder);
}

/* Into place. The handle is closed in any case. */
static int put(struct ttf_io *io, int file, int r, const char *temporary, const char *path,
               bool synced)
{
    int closed;

    if (r == 0 && synced)
        r = io->ops->sync(io, file, false);
    closed = io->ops->close(io, file);
    if (r == 0)
        r = closed;
    if (r == 0)
        r = io->ops->rename(io, temporary, path);
    if (r == 0 && synced)
        r = sync_folder_of(io, path);
    return r;
}

int anew_write(struct ttf_io *io, const char *path, bool synced, char ret_sha256[65],
               struct ttf_err *err)
{
    char temporary[PATH_SIZE], hex[65];
    struct ttf_sha256 hash;
    int from = io->ops->open(io, path, TTF_IO_READ), to, r;

    if (from == -ENOENT)
        return from;
    if (from < 0)
        return ttf_err_set(err, from, path, "cannot be opened: %s", strerrordesc_np(-from));
    (void)snprintf(temporary, sizeof temporary, "%s.tmp", path);
    ttf_sha256_init(&hash);
    r = io->ops->unlink(io, temporary);
    to = r == 0 || r == -ENOENT ? io->ops->open(io, temporary, TTF_IO_CREATE_NEW) : r;
    r = to < 0 ? to : put(io, to, copy(io, from, to, &hash), temporary, path, synced);
    (void)io->ops->close(io, from);
    ttf_sha256_hex(&hash, hex);
    if (r < 0)
        return ttf_err_set(err, r, path, "cannot be written anew: %s", strerrordesc_np(-r));
    if (ret_sha256)
        memcpy(ret_sha256, hex, sizeof hex);
    return 0;
}
