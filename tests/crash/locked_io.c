/* SPDX-License-Identifier: Apache-2.0 */
#include "locked_io.h"

#include <stdlib.h>

static struct ttf_io *enter(struct ttf_io *io)
{
    struct locked_io *locked = (struct locked_io *)io;

    pthread_mutex_lock(&locked->mutex);
    return locked->base;
}

static int leave(struct ttf_io *io, int result)
{
    pthread_mutex_unlock(&((struct locked_io *)io)->mutex);
    return result;
}

static int64_t leave_count(struct ttf_io *io, int64_t result)
{
    pthread_mutex_unlock(&((struct locked_io *)io)->mutex);
    return result;
}

static int op_open(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->open(base, path, mode));
}

static int64_t op_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    struct ttf_io *base = enter(io);

    return leave_count(io, base->ops->pread(base, file, buf, n, offset));
}

static int64_t op_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    struct ttf_io *base = enter(io);

    return leave_count(io, base->ops->pwrite(base, file, buf, n, offset));
}

static int64_t op_append(struct ttf_io *io, int file, const void *buf, size_t n)
{
    struct ttf_io *base = enter(io);

    return leave_count(io, base->ops->append(base, file, buf, n));
}

static int op_size(struct ttf_io *io, int file, int64_t *ret_bytes)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->size(base, file, ret_bytes));
}

static int op_truncate(struct ttf_io *io, int file, int64_t bytes)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->truncate(base, file, bytes));
}

static int op_sync(struct ttf_io *io, int file, bool data_only)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->sync(base, file, data_only));
}

static int op_close(struct ttf_io *io, int file)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->close(base, file));
}

static int op_rename(struct ttf_io *io, const char *from, const char *to)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->rename(base, from, to));
}

static int op_unlink(struct ttf_io *io, const char *path)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->unlink(base, path));
}

static int op_mkdir(struct ttf_io *io, const char *path)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->mkdir(base, path));
}

static int op_sync_dir(struct ttf_io *io, const char *path)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->sync_dir(base, path));
}

static int op_stat(struct ttf_io *io, const char *path, struct ttf_io_stat *ret)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->stat(base, path, ret));
}

static int op_list(struct ttf_io *io, const char *path, ttf_io_entry_fn *fn, void *ctx)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->list(base, path, fn, ctx));
}

static int op_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->space(base, path, ret));
}

static int op_lock(struct ttf_io *io, int file)
{
    struct ttf_io *base = enter(io);

    return leave(io, base->ops->lock(base, file));
}

static const struct ttf_io_ops ops = {
    .name = "locked",
    .open = op_open,
    .pread = op_pread,
    .pwrite = op_pwrite,
    .append = op_append,
    .size = op_size,
    .truncate = op_truncate,
    .sync = op_sync,
    .close = op_close,
    .rename = op_rename,
    .unlink = op_unlink,
    .mkdir = op_mkdir,
    .sync_dir = op_sync_dir,
    .stat = op_stat,
    .list = op_list,
    .space = op_space,
    .lock = op_lock,
};

void locked_io_init(struct locked_io *locked, struct ttf_io *base)
{
    pthread_mutexattr_t recursive;

    locked->io.ops = &ops;
    locked->base = base;
    if (pthread_mutexattr_init(&recursive) != 0 ||
        pthread_mutexattr_settype(&recursive, PTHREAD_MUTEX_RECURSIVE) != 0 ||
        pthread_mutex_init(&locked->mutex, &recursive) != 0)
        abort();
    pthread_mutexattr_destroy(&recursive);
}

void locked_io_free(struct locked_io *locked)
{
    pthread_mutex_destroy(&locked->mutex);
}
