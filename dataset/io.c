/* SPDX-License-Identifier: Apache-2.0 */
/* Whole operations on top of an I/O table. */
#include "ttf/dataset/io.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"

#define TEMPORARY   ".tmp"
#define PIECE_BYTES ((size_t)64 * 1024)

int ttf_io_sync_all(struct ttf_io *io, int file)
{
    return io->ops->sync_all ? io->ops->sync_all(io, file) : -EOPNOTSUPP;
}

/* Only what writing would meet as well is an error: file systems that cannot say so in many ways (-EINVAL, -ENODEV, -EPERM). */
int ttf_io_reserve(struct ttf_io *io, int file, int64_t offset, int64_t n)
{
    int r = io->ops->reserve ? 0 : -EOPNOTSUPP;

    if (offset < 0 || n <= 0)
        return -EINVAL;
    if (r == 0)
        r = io->ops->reserve(io, file, offset, n);
    return r == 0 || r == -ENOSPC || r == -EDQUOT || r == -EFBIG || r == -EIO ? r : -EOPNOTSUPP;
}

int ttf_io_inherit(struct ttf_io *io, int file, const char *path)
{
    return io->ops->inherit ? io->ops->inherit(io, file, path) : 0;
}

int ttf_io_pwrite_all(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    const char *at = buf;
    int64_t put;

    while (n > 0) {
        put = io->ops->pwrite(io, file, at, n, offset);
        if (put == -EINTR)
            continue;
        if (put <= 0)
            return put < 0 ? (int)put : -EIO;
        at += put;
        n -= (size_t)put;
        offset += put;
    }
    return 0;
}

int ttf_io_append_all(struct ttf_io *io, int file, const void *buf, size_t n)
{
    const char *at = buf;
    int64_t put;

    while (n > 0) {
        put = io->ops->append(io, file, at, n);
        if (put == -EINTR)
            continue;
        if (put <= 0)
            return put < 0 ? (int)put : -EIO;
        at += put;
        n -= (size_t)put;
    }
    return 0;
}

int64_t ttf_io_pread_all(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    char *at = buf;
    size_t done = 0;
    int64_t got;

    while (done < n) {
        got = io->ops->pread(io, file, at + done, n - done, offset + (int64_t)done);
        if (got == -EINTR)
            continue;
        if (got < 0)
            return got;
        if (got == 0)
            break;
        done += (size_t)got;
    }
    return (int64_t)done;
}

int ttf_io_copy_bytes(struct ttf_io *io, int from, int to, int64_t bytes)
{
    void *piece = malloc(PIECE_BYTES);
    int64_t at = 0, got;
    size_t n;
    int r = 0;

    if (!piece)
        return -ENOMEM;
    while (r == 0 && at < bytes) {
        n = bytes - at < (int64_t)PIECE_BYTES ? (size_t)(bytes - at) : PIECE_BYTES;
        got = ttf_io_pread_all(io, from, piece, n, at);
        if (got != (int64_t)n)
            r = got < 0 ? (int)got : -EIO;
        else
            r = ttf_io_append_all(io, to, piece, n);
        at += (int64_t)n;
    }
    free(piece);
    return r;
}

int ttf_io_lock(struct ttf_io *io, int file)
{
    int r = io->ops->lock(io, file);

    /* Some network file systems know no locks: then nobody guards, and the work goes on. */
    return r == -EBADF || r == -ENOTSUP || r == -ENOLCK || r == -EINVAL || r == -ENOSYS ? 0 : r;
}

int ttf_io_slurp(struct ttf_io *io, const char *path, size_t max_bytes, char **ret_text,
                 size_t *ret_bytes, struct ttf_err *err)
{
    int64_t bytes, got;
    char *text = NULL;
    int file, r;

    file = io->ops->open(io, path, TTF_IO_READ);
    if (file < 0)
        return ttf_err_set(err, file, path, "cannot be opened: %s", strerrordesc_np(-file));
    r = io->ops->size(io, file, &bytes);
    if (r) {
        ttf_err_set(err, r, path, "cannot be read: %s", strerrordesc_np(-r));
        goto out;
    }
    if ((uint64_t)bytes > max_bytes) {
        r = ttf_err_set(err, -EFBIG, path, "is %lld bytes long, more than the %zu allowed",
                        (long long)bytes, max_bytes);
        goto out;
    }
    text = malloc((size_t)bytes + 1);
    if (!text) {
        r = ttf_err_set(err, -ENOMEM, path, "no memory for %lld bytes", (long long)bytes);
        goto out;
    }
    got = ttf_io_pread_all(io, file, text, (size_t)bytes, 0);
    if (got < 0) {
        r = ttf_err_set(err, (int)got, path, "cannot be read: %s", strerrordesc_np((int)-got));
        goto out;
    }
    text[got] = '\0';
    *ret_text = text;
    text = NULL;
    if (ret_bytes)
        *ret_bytes = (size_t)got;
out:
    free(text);
    io->ops->close(io, file);
    return r;
}

/* How many bytes of path its folder's name has: 0 if it lies in the current one. */
static size_t parent_bytes(const char *path)
{
    const char *slash;
    size_t n = strlen(path);

    while (n > 1 && path[n - 1] == '/') /* "a/b/" is "a/b" */
        n--;
    slash = memrchr(path, '/', n);
    if (!slash)
        return 0;
    while (slash > path && slash[-1] == '/')
        slash--;
    return slash == path ? 1 : (size_t)(slash - path);
}

int ttf_io_sync_parent(struct ttf_io *io, const char *path)
{
    size_t n = parent_bytes(path);
    char parent[TTF_PATH_MAX];
    int r = n ? ttf_path_put(parent, "%.*s", (int)n, path) : ttf_path_put(parent, ".");

    return r ? r : io->ops->sync_dir(io, parent);
}

int ttf_io_write_file(struct ttf_io *io, const char *path, const void *data, size_t n,
                      struct ttf_err *err)
{
    char temporary[TTF_PATH_MAX];
    int file = -1, r = ttf_path_put(temporary, "%s" TEMPORARY, path);
    bool made = false;

    if (r)
        goto out;
    r = io->ops->unlink(io, temporary); /* of a run that was cut off */
    if (r && r != -ENOENT)
        goto out;
    file = io->ops->open(io, temporary, TTF_IO_CREATE_NEW);
    r = file < 0 ? file : 0;
    if (r)
        goto out;
    made = true;
    r = ttf_io_append_all(io, file, data, n);
    if (r == 0)
        r = io->ops->sync(io, file, false);
    if (r)
        goto out;
    r = io->ops->close(io, file);
    file = -1;
    if (r == 0)
        r = io->ops->rename(io, temporary, path);
    if (r == 0) {
        made = false;
        r = ttf_io_sync_parent(io, path);
    }
out:
    if (file >= 0)
        io->ops->close(io, file);
    if (made)
        io->ops->unlink(io, temporary);
    return r ? ttf_err_set(err, r, path, "cannot be written: %s", strerrordesc_np(-r)) : 0;
}

static int make_one(struct ttf_io *io, const char *path)
{
    struct ttf_io_stat st;
    int r;

    /* Asked first: on a read-only mount mkdir of what is there may say EROFS. */
    r = io->ops->stat(io, path, &st);
    if (r == 0)
        return st.is_dir ? 0 : -ENOTDIR;
    r = io->ops->mkdir(io, path);
    if (r == -EEXIST)
        return 0; /* somebody else was faster */
    if (r)
        return r;
    r = ttf_io_sync_parent(io, path);
    if (r) /* left there, it would pass for durable the next time */
        (void)io->ops->unlink(io, path);
    return r;
}

int ttf_io_mkdirs(struct ttf_io *io, const char *path, struct ttf_err *err)
{
    char copy[TTF_PATH_MAX];
    int r = ttf_path_put(copy, "%s", path);
    size_t i;

    for (i = 1; r == 0 && copy[0] != '\0'; i++) {
        if (copy[i] != '/' && copy[i] != '\0')
            continue;
        if (copy[i] == '\0') {
            r = make_one(io, copy);
            break;
        }
        if (copy[i - 1] == '/')
            continue;
        copy[i] = '\0';
        r = make_one(io, copy);
        copy[i] = '/';
    }
    if (r)
        ttf_err_set(err, r, path, "this folder cannot be made: %s", strerrordesc_np(-r));
    return r;
}

int ttf_path_put(char ret[TTF_PATH_MAX], const char *fmt, ...)
{
    va_list args;
    int n;

    va_start(args, fmt);
    n = vsnprintf(ret, TTF_PATH_MAX, fmt, args);
    va_end(args);
    return n < 0 || n >= TTF_PATH_MAX ? -ENAMETOOLONG : 0;
}

char *ttf_path_format(const char *fmt, ...)
{
    char *text = NULL;
    va_list args;
    int n;

    va_start(args, fmt);
    n = vasprintf(&text, fmt, args);
    va_end(args);
    return n < 0 ? NULL : text;
}

char *ttf_path_parent(const char *path)
{
    size_t n = parent_bytes(path);

    return n ? strndup(path, n) : strdup(".");
}

/* ---- removing ---- */

struct first_entry {
    const char *folder;
    char path[TTF_PATH_MAX];
};

static int take_first(void *ctx, const char *name, bool is_dir)
{
    struct first_entry *first = ctx;
    int r = ttf_path_put(first->path, "%s/%s", first->folder, name);

    (void)is_dir;
    return r ? r : 1;
}

int ttf_io_remove_tree(struct ttf_io *io, const char *path)
{
    struct first_entry first = {.folder = path};
    int r = io->ops->unlink(io, path);

    if (r != -ENOTEMPTY && r != -EEXIST)
        return r;
    while ((r = io->ops->list(io, path, take_first, &first)) > 0) {
        r = ttf_io_remove_tree(io, first.path);
        if (r)
            return r;
    }
    return r ? r : io->ops->unlink(io, path);
}
