/* SPDX-License-Identifier: Apache-2.0 */
#include "flip_io.h"

#include <errno.h>
#include <string.h>

#define HANDLES 63

static struct flip_io *of(struct ttf_io *io)
{
    return (struct flip_io *)io;
}

static int flip_open(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    struct flip_io *flip = of(io);
    int file = flip->base->ops->open(flip->base, path, mode);

    if (file < 0 || !flip->path || strcmp(path, flip->path) != 0)
        return file;
    if (file >= HANDLES) {
        flip->base->ops->close(flip->base, file);
        return -EMFILE;
    }
    flip->open |= INT64_C(1) << file;
    return file;
}

static int flip_close(struct ttf_io *io, int file)
{
    struct flip_io *flip = of(io);

    if (file < HANDLES)
        flip->open &= ~(INT64_C(1) << file);
    return flip->base->ops->close(flip->base, file);
}

static int64_t flip_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    struct flip_io *flip = of(io);
    int64_t got = flip->base->ops->pread(flip->base, file, buf, n, offset);
    int64_t at = flip->bit / 8 - offset;

    if (file < HANDLES && flip->open >> file & 1 && at >= 0 && at < got)
        ((unsigned char *)buf)[at] ^= (unsigned char)(1u << flip->bit % 8);
    return got;
}

static int64_t flip_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    return of(io)->base->ops->pwrite(of(io)->base, file, buf, n, offset);
}

static int64_t flip_append(struct ttf_io *io, int file, const void *buf, size_t n)
{
    return of(io)->base->ops->append(of(io)->base, file, buf, n);
}

static int flip_size(struct ttf_io *io, int file, int64_t *ret_bytes)
{
    return of(io)->base->ops->size(of(io)->base, file, ret_bytes);
}

static int flip_truncate(struct ttf_io *io, int file, int64_t bytes)
{
    return of(io)->base->ops->truncate(of(io)->base, file, bytes);
}

static int flip_sync(struct ttf_io *io, int file, bool data_only)
{
    return of(io)->base->ops->sync(of(io)->base, file, data_only);
}

static int flip_rename(struct ttf_io *io, const char *from, const char *to)
{
    return of(io)->base->ops->rename(of(io)->base, from, to);
}

static int flip_unlink(struct ttf_io *io, const char *path)
{
    return of(io)->base->ops->unlink(of(io)->base, path);
}

static int flip_mkdir(struct ttf_io *io, const char *path)
{
    return of(io)->base->ops->mkdir(of(io)->base, path);
}

static int flip_sync_dir(struct ttf_io *io, const char *path)
{
    return of(io)->base->ops->sync_dir(of(io)->base, path);
}

static int flip_stat(struct ttf_io *io, const char *path, struct ttf_io_stat *ret)
{
    return of(io)->base->ops->stat(of(io)->base, path, ret);
}

static int flip_list(struct ttf_io *io, const char *path, ttf_io_entry_fn *fn, void *ctx)
{
    return of(io)->base->ops->list(of(io)->base, path, fn, ctx);
}

static int flip_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    return of(io)->base->ops->space(of(io)->base, path, ret);
}

static int flip_lock(struct ttf_io *io, int file)
{
    return of(io)->base->ops->lock(of(io)->base, file);
}

static const struct ttf_io_ops flip_ops = {
    .name = "flip",
    .open = flip_open,
    .pread = flip_pread,
    .pwrite = flip_pwrite,
    .append = flip_append,
    .size = flip_size,
    .truncate = flip_truncate,
    .sync = flip_sync,
    .close = flip_close,
    .rename = flip_rename,
    .unlink = flip_unlink,
    .mkdir = flip_mkdir,
    .sync_dir = flip_sync_dir,
    .stat = flip_stat,
    .list = flip_list,
    .space = flip_space,
    .lock = flip_lock,
};

void flip_io_init(struct flip_io *flip, struct ttf_io *base)
{
    *flip = (struct flip_io){.io = {.ops = &flip_ops}, .base = base};
}
