/* SPDX-License-Identifier: Apache-2.0 */
/* A twin of another I/O table that fails when it is told to. */
#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/io.h"

/* Which path a handle was opened under, so that a fault can be asked for by path. */
struct open_file {
    int file;
    char *path;
    struct open_file *next;
};

struct faulty {
    struct ttf_io io; /* first: the table's functions get a pointer to it */
    struct ttf_io *base;
    ttf_io_fault_fn *fault;
    ttf_io_space_fn *space; /* NULL: as it is */
    void *ctx;
    pthread_mutex_t lock; /* of files */
    struct open_file *files;
};

static struct faulty *self(struct ttf_io *io)
{
    return (struct faulty *)io;
}

static int ask(struct faulty *f, const char *op, const char *path)
{
    int error = f->fault ? f->fault(f->ctx, op, path) : 0;

    return error > 0 ? -error : error;
}

/* The path must outlive the handle's use: its owner closes it only after the operation. */
static const char *path_of(struct faulty *f, int file)
{
    const struct open_file *o;
    const char *path = "";

    pthread_mutex_lock(&f->lock);
    for (o = f->files; o; o = o->next)
        if (o->file == file) {
            path = o->path;
            break;
        }
    pthread_mutex_unlock(&f->lock);
    return path;
}

static int remember(struct faulty *f, int file, const char *path)
{
    struct open_file *o = malloc(sizeof(*o));

    if (!o)
        return -ENOMEM;
    o->file = file;
    o->path = strdup(path);
    if (!o->path) {
        free(o);
        return -ENOMEM;
    }
    pthread_mutex_lock(&f->lock);
    o->next = f->files;
    f->files = o;
    pthread_mutex_unlock(&f->lock);
    return 0;
}

static void forget(struct faulty *f, int file)
{
    struct open_file **at, *o;

    pthread_mutex_lock(&f->lock);
    for (at = &f->files; *at; at = &(*at)->next)
        if ((*at)->file == file) {
            o = *at;
            *at = o->next;
            free(o->path);
            free(o);
            break;
        }
    pthread_mutex_unlock(&f->lock);
}

static int fa_open(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    struct faulty *f = self(io);
    int file, r;

    r = mode == TTF_IO_READ ? 0 : ask(f, "open", path);
    if (r)
        return r;
    file = f->base->ops->open(f->base, path, mode);
    if (file < 0)
        return file;
    r = remember(f, file, path);
    if (r) {
        f->base->ops->close(f->base, file);
        return r;
    }
    return file;
}

static int64_t fa_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    return self(io)->base->ops->pread(self(io)->base, file, buf, n, offset);
}

static int64_t fa_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    struct faulty *f = self(io);
    int r = ask(f, "pwrite", path_of(f, file));

    return r ? r : f->base->ops->pwrite(f->base, file, buf, n, offset);
}

static int64_t fa_append(struct ttf_io *io, int file, const void *buf, size_t n)
{
    struct faulty *f = self(io);
    int r = ask(f, "append", path_of(f, file));

    return r ? r : f->base->ops->append(f->base, file, buf, n);
}

static int fa_size(struct ttf_io *io, int file, int64_t *ret_bytes)
{
    return self(io)->base->ops->size(self(io)->base, file, ret_bytes);
}

static int fa_truncate(struct ttf_io *io, int file, int64_t bytes)
{
    struct faulty *f = self(io);
    int r = ask(f, "truncate", path_of(f, file));

    return r ? r : f->base->ops->truncate(f->base, file, bytes);
}

static int fa_sync(struct ttf_io *io, int file, bool data_only)
{
    struct faulty *f = self(io);
    int r = ask(f, "sync", path_of(f, file));

    return r ? r : f->base->ops->sync(f->base, file, data_only);
}

static int fa_close(struct ttf_io *io, int file)
{
    struct faulty *f = self(io);

    forget(f, file); /* before the number can be given out again */
    return f->base->ops->close(f->base, file);
}

static int fa_rename(struct ttf_io *io, const char *from, const char *to)
{
    struct faulty *f = self(io);
    int r = ask(f, "rename", to);

    return r ? r : f->base->ops->rename(f->base, from, to);
}

static int fa_unlink(struct ttf_io *io, const char *path)
{
    struct faulty *f = self(io);
    int r = ask(f, "unlink", path);

    return r ? r : f->base->ops->unlink(f->base, path);
}

static int fa_mkdir(struct ttf_io *io, const char *path)
{
    struct faulty *f = self(io);
    int r = ask(f, "mkdir", path);

    return r ? r : f->base->ops->mkdir(f->base, path);
}

static int fa_sync_dir(struct ttf_io *io, const char *path)
{
    struct faulty *f = self(io);
    int r = ask(f, "sync_dir", path);

    return r ? r : f->base->ops->sync_dir(f->base, path);
}

static int fa_stat(struct ttf_io *io, const char *path, struct ttf_io_stat *ret)
{
    return self(io)->base->ops->stat(self(io)->base, path, ret);
}

static int fa_list(struct ttf_io *io, const char *path, ttf_io_entry_fn *fn, void *ctx)
{
    return self(io)->base->ops->list(self(io)->base, path, fn, ctx);
}

static int fa_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    struct faulty *f = self(io);
    int r = f->base->ops->space(f->base, path, ret);

    if (r == 0 && f->space)
        f->space(f->ctx, path, ret);
    return r;
}

static int fa_lock(struct ttf_io *io, int file)
{
    return self(io)->base->ops->lock(self(io)->base, file);
}

static int fa_sync_all(struct ttf_io *io, int file)
{
    struct faulty *f = self(io);
    int r = ask(f, "sync_all", path_of(f, file));

    return r ? r : ttf_io_sync_all(f->base, file);
}

static int fa_inherit(struct ttf_io *io, int file, const char *path)
{
    return ttf_io_inherit(self(io)->base, file, path);
}

static const struct ttf_io_ops faulty_ops = {
    .name = "faulty",
    .open = fa_open,
    .pread = fa_pread,
    .pwrite = fa_pwrite,
    .append = fa_append,
    .size = fa_size,
    .truncate = fa_truncate,
    .sync = fa_sync,
    .close = fa_close,
    .rename = fa_rename,
    .unlink = fa_unlink,
    .mkdir = fa_mkdir,
    .sync_dir = fa_sync_dir,
    .stat = fa_stat,
    .list = fa_list,
    .space = fa_space,
    .lock = fa_lock,
    .sync_all = fa_sync_all,
    .inherit = fa_inherit,
};

struct ttf_io *ttf_io_faulty_create(struct ttf_io *base, ttf_io_fault_fn *fault, void *ctx)
{
    struct faulty *f = calloc(1, sizeof(*f));

    if (!f)
        return NULL;
    f->io.ops = &faulty_ops;
    f->base = base;
    f->fault = fault;
    f->ctx = ctx;
    if (pthread_mutex_init(&f->lock, NULL) != 0) {
        free(f);
        return NULL;
    }
    return &f->io;
}

void ttf_io_faulty_space(struct ttf_io *io, ttf_io_space_fn *space)
{
    self(io)->space = space;
}

void ttf_io_faulty_destroy(struct ttf_io *io)
{
    struct faulty *f = io ? self(io) : NULL;

    if (!f)
        return;
    while (f->files)
        fa_close(io, f->files->file);
    pthread_mutex_destroy(&f->lock);
    free(f);
}
