/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <string.h>

#include "fuzz.h"

static int open_file(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    return mode == TTF_IO_READ ? 3 : -EROFS;
}

static int64_t read_file(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    const struct fuzz_io *f = (const struct fuzz_io *)io;

    if (offset < 0)
        return -EINVAL;
    if ((uint64_t)offset >= f->size)
        return 0;
    if (n > f->size - (size_t)offset)
        n = f->size - (size_t)offset;
    memcpy(buf, f->data + offset, n);
    return (int64_t)n;
}

static int64_t refuse_write(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    return -EROFS;
}

static int64_t refuse_append(struct ttf_io *io, int file, const void *buf, size_t n)
{
    return -EROFS;
}

static int size_of(struct ttf_io *io, int file, int64_t *ret_bytes)
{
    *ret_bytes = (int64_t)((const struct fuzz_io *)io)->size;
    return 0;
}

static int refuse_truncate(struct ttf_io *io, int file, int64_t bytes)
{
    return -EROFS;
}

static int sync_nothing(struct ttf_io *io, int file, bool data_only)
{
    return 0;
}

static int close_nothing(struct ttf_io *io, int file)
{
    return 0;
}

static int refuse_rename(struct ttf_io *io, const char *from, const char *to)
{
    return -EROFS;
}

static int refuse_path(struct ttf_io *io, const char *path)
{
    return -EROFS;
}

static int stat_file(struct ttf_io *io, const char *path, struct ttf_io_stat *ret)
{
    *ret = (struct ttf_io_stat){.is_regular = true,
                                .bytes = (int64_t)((const struct fuzz_io *)io)->size};
    return 0;
}

static int no_folder(struct ttf_io *io, const char *path, ttf_io_entry_fn *fn, void *ctx)
{
    return -ENOTDIR;
}

static int no_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    *ret = (struct ttf_io_space){.read_only = true};
    return 0;
}

static int no_lock(struct ttf_io *io, int file)
{
    return 0;
}

static const struct ttf_io_ops OPS = {
    .name = "fuzz",
    .open = open_file,
    .pread = read_file,
    .pwrite = refuse_write,
    .append = refuse_append,
    .size = size_of,
    .truncate = refuse_truncate,
    .sync = sync_nothing,
    .close = close_nothing,
    .rename = refuse_rename,
    .unlink = refuse_path,
    .mkdir = refuse_path,
    .sync_dir = refuse_path,
    .stat = stat_file,
    .list = no_folder,
    .space = no_space,
    .lock = no_lock,
};

void fuzz_io_init(struct fuzz_io *io, const uint8_t *data, size_t size)
{
    *io = (struct fuzz_io){.base = {&OPS}, .data = data, .size = size};
}
