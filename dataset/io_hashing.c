/* SPDX-License-Identifier: Apache-2.0 */
#include "io_hashing.h"

static struct ttf_io_hashing *self(struct ttf_io *io)
{
    return (struct ttf_io_hashing *)io;
}

static void written(struct ttf_io_hashing *h, int file, const void *buf, int64_t n, int64_t offset)
{
    if (file != h->file || n <= 0 || !h->sequential)
        return;
    h->sequential = offset == h->at;
    if (!h->sequential)
        return;
    ttf_sha256_add(&h->hash, buf, (size_t)n);
    h->at += n;
}

static int ha_open(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    return self(io)->base->ops->open(self(io)->base, path, mode);
}

static int64_t ha_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    return self(io)->base->ops->pread(self(io)->base, file, buf, n, offset);
}

static int64_t ha_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    int64_t put = self(io)->base->ops->pwrite(self(io)->base, file, buf, n, offset);

    written(self(io), file, buf, put, offset);
    return put;
}

static int64_t ha_append(struct ttf_io *io, int file, const void *buf, size_t n)
{
    int64_t put = self(io)->base->ops->append(self(io)->base, file, buf, n);

    /* Behind the end; that this is where hashing stands, the size will tell. */
    written(self(io), file, buf, put, self(io)->at);
    return put;
}

static int ha_size(struct ttf_io *io, int file, int64_t *ret_bytes)
{
    return self(io)->base->ops->size(self(io)->base, file, ret_bytes);
}

static int ha_truncate(struct ttf_io *io, int file, int64_t bytes)
{
    if (file == self(io)->file)
        self(io)->sequential = false;
    return self(io)->base->ops->truncate(self(io)->base, file, bytes);
}

static int ha_sync(struct ttf_io *io, int file, bool data_only)
{
    return self(io)->base->ops->sync(self(io)->base, file, data_only);
}

static int ha_close(struct ttf_io *io, int file)
{
    return self(io)->base->ops->close(self(io)->base, file);
}

static int ha_rename(struct ttf_io *io, const char *from, const char *to)
{
    return self(io)->base->ops->rename(self(io)->base, from, to);
}

static int ha_unlink(struct ttf_io *io, const char *path)
{
    return self(io)->base->ops->unlink(self(io)->base, path);
}

static int ha_mkdir(struct ttf_io *io, const char *path)
{
    return self(io)->base->ops->mkdir(self(io)->base, path);
}

static int ha_sync_dir(struct ttf_io *io, const char *path)
{
    return self(io)->base->ops->sync_dir(self(io)->base, path);
}

static int ha_stat(struct ttf_io *io, const char *path, struct ttf_io_stat *ret)
{
    return self(io)->base->ops->stat(self(io)->base, path, ret);
}

static int ha_list(struct ttf_io *io, const char *path, ttf_io_entry_fn *fn, void *ctx)
{
    return self(io)->base->ops->list(self(io)->base, path, fn, ctx);
}

static int ha_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    return self(io)->base->ops->space(self(io)->base, path, ret);
}

static int ha_lock(struct ttf_io *io, int file)
{
    return self(io)->base->ops->lock(self(io)->base, file);
}

static const struct ttf_io_ops hashing_ops = {
    .name = "hashing",
    .open = ha_open,
    .pread = ha_pread,
    .pwrite = ha_pwrite,
    .append = ha_append,
    .size = ha_size,
    .truncate = ha_truncate,
    .sync = ha_sync,
    .close = ha_close,
    .rename = ha_rename,
    .unlink = ha_unlink,
    .mkdir = ha_mkdir,
    .sync_dir = ha_sync_dir,
    .stat = ha_stat,
    .list = ha_list,
    .space = ha_space,
    .lock = ha_lock,
};

void ttf_io_hashing_init(struct ttf_io_hashing *hashing, struct ttf_io *base, int file)
{
    *hashing = (struct ttf_io_hashing){
        .io = {.ops = &hashing_ops}, .base = base, .file = file, .sequential = true};
    ttf_sha256_init(&hashing->hash);
}

int ttf_io_hashing_result(struct ttf_io_hashing *hashing, void *piece, int64_t *ret_bytes,
                          char ret_hex[65])
{
    int64_t bytes;
    int r;

    r = hashing->base->ops->size(hashing->base, hashing->file, &bytes);
    if (r)
        return r;
    if (!hashing->sequential || bytes != hashing->at)
        return ttf_sha256_handle_in(hashing->base, hashing->file, piece, ret_bytes, ret_hex);
    ttf_sha256_hex(&hashing->hash, ret_hex);
    *ret_bytes = bytes;
    return 0;
}
