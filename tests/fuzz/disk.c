/* SPDX-License-Identifier: Apache-2.0 */
#include "disk.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct fuzz_node {
    uint8_t *data;
    size_t size, room;
    unsigned refs; /* its name, and handles */
    bool is_dir;   /* of a folder's handle only */
};

static struct fuzz_disk *self(struct ttf_io *io)
{
    return (struct fuzz_disk *)io;
}

static void drop(struct fuzz_node *node)
{
    if (--node->refs > 0)
        return;
    free(node->data);
    free(node);
}

static struct fuzz_node *new_node(void)
{
    struct fuzz_node *node = calloc(1, sizeof *node);

    if (!node)
        abort();
    node->refs = 1;
    return node;
}

static int find(const struct fuzz_disk *disk, const char *path)
{
    for (unsigned i = 0; i < disk->n; i++)
        if (strcmp(disk->files[i].path, path) == 0)
            return (int)i;
    return -1;
}

static bool is_below(const char *path, const char *folder)
{
    size_t n = strlen(folder);

    return strncmp(path, folder, n) == 0 && path[n] == '/';
}

static bool is_dir(const struct fuzz_disk *disk, const char *path)
{
    for (unsigned i = 0; i < disk->n; i++)
        if (is_below(disk->files[i].path, path))
            return true;
    return false;
}

static void remove_entry(struct fuzz_disk *disk, int i)
{
    drop(disk->files[i].node);
    disk->files[i] = disk->files[--disk->n];
}

static struct fuzz_node *add_entry(struct fuzz_disk *disk, const char *path)
{
    struct fuzz_entry *e = &disk->files[disk->n];

    if (disk->n == FUZZ_DISK_FILES || strlen(path) >= sizeof e->path)
        return NULL;
    strcpy(e->path, path);
    e->node = new_node();
    disk->n++;
    return e->node;
}

static int64_t write_at(struct fuzz_node *node, const void *buf, size_t n, size_t offset)
{
    size_t end = offset + n, room = node->room ? node->room : 256;

    while (room < end)
        room *= 2;
    if (room != node->room) {
        node->data = realloc(node->data, room);
        if (!node->data)
            abort();
        node->room = room;
    }
    if (offset > node->size)
        memset(node->data + node->size, 0, offset - node->size);
    if (n > 0)
        memcpy(node->data + offset, buf, n);
    node->size = end > node->size ? end : node->size;
    return (int64_t)n;
}

/* ---- the table ---- */

static int disk_open(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    struct fuzz_disk *disk = self(io);
    struct fuzz_node *node;
    int at = find(disk, path), handle = 0;

    while (handle < FUZZ_DISK_FILES && disk->handles[handle])
        handle++;
    /* Noise by the 256 KiB at each opening would be all that is ever fuzzed. */
    if (handle == FUZZ_DISK_FILES || strstr(path, "/.events-reserve"))
        return handle == FUZZ_DISK_FILES ? -EMFILE : -ENOSPC;
    if (at >= 0 && mode == TTF_IO_CREATE_NEW)
        return -EEXIST;
    if (at < 0 && mode == TTF_IO_READ) {
        if (!is_dir(disk, path))
            return -ENOENT;
        node = new_node();
        node->is_dir = true;
    } else {
        node = at >= 0 ? disk->files[at].node : add_entry(disk, path);
        if (!node)
            return -ENOSPC;
        node->refs++;
    }
    disk->handles[handle] = node;
    return handle;
}

static int64_t disk_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    const struct fuzz_node *node = self(io)->handles[file];

    if (offset < 0 || node->is_dir)
        return offset < 0 ? -EINVAL : -EISDIR;
    if ((uint64_t)offset >= node->size)
        return 0;
    if (n > node->size - (size_t)offset)
        n = node->size - (size_t)offset;
    memcpy(buf, node->data + offset, n);
    return (int64_t)n;
}

static int64_t disk_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    return write_at(self(io)->handles[file], buf, n, (size_t)offset);
}

static int64_t disk_append(struct ttf_io *io, int file, const void *buf, size_t n)
{
    struct fuzz_node *node = self(io)->handles[file];

    return write_at(node, buf, n, node->size);
}

static int disk_size(struct ttf_io *io, int file, int64_t *ret_bytes)
{
    *ret_bytes = (int64_t)self(io)->handles[file]->size;
    return 0;
}

static int disk_truncate(struct ttf_io *io, int file, int64_t bytes)
{
    struct fuzz_node *node = self(io)->handles[file];

    if ((size_t)bytes > node->size)
        (void)write_at(node, NULL, 0, (size_t)bytes);
    node->size = (size_t)bytes;
    return 0;
}

static int disk_sync(struct ttf_io *io, int file, bool data_only)
{
    return 0;
}

static int disk_close(struct ttf_io *io, int file)
{
    drop(self(io)->handles[file]);
    self(io)->handles[file] = NULL;
    return 0;
}

static int disk_rename(struct ttf_io *io, const char *from, const char *to)
{
    struct fuzz_disk *disk = self(io);
    int at = find(disk, to);

    if (find(disk, from) < 0 || is_dir(disk, to))
        return find(disk, from) < 0 ? -ENOENT : -EISDIR;
    if (at >= 0)
        remove_entry(disk, at);
    strcpy(disk->files[find(disk, from)].path, to);
    return 0;
}

static int disk_unlink(struct ttf_io *io, const char *path)
{
    int at = find(self(io), path);

    if (at < 0)
        return is_dir(self(io), path) ? -EISDIR : -ENOENT;
    remove_entry(self(io), at);
    return 0;
}

static int disk_mkdir(struct ttf_io *io, const char *path)
{
    return find(self(io), path) >= 0 || is_dir(self(io), path) ? -EEXIST : 0;
}

static int disk_sync_dir(struct ttf_io *io, const char *path)
{
    return 0;
}

static int disk_stat(struct ttf_io *io, const char *path, struct ttf_io_stat *ret)
{
    int at = find(self(io), path);

    if (at < 0 && !is_dir(self(io), path))
        return -ENOENT;
    *ret = (struct ttf_io_stat){.is_dir = at < 0, .is_regular = at >= 0};
    if (at >= 0)
        ret->bytes = (int64_t)self(io)->files[at].node->size;
    return 0;
}

/* The name of entry i within the folder; false if an entry before it gave that name. */
static bool name_in(const struct fuzz_disk *disk, unsigned i, size_t at, char ret[256])
{
    size_t n = strcspn(disk->files[i].path + at, "/");

    (void)snprintf(ret, 256, "%.*s", (int)n, disk->files[i].path + at);
    for (unsigned j = 0; j < i; j++)
        if (strncmp(disk->files[j].path, disk->files[i].path, at + n) == 0 &&
            (disk->files[j].path[at + n] == '/' || disk->files[j].path[at + n] == '\0'))
            return false;
    return true;
}

static int disk_list(struct ttf_io *io, const char *path, ttf_io_entry_fn *fn, void *ctx)
{
    const struct fuzz_disk *disk = self(io);
    size_t at = strlen(path);
    char folder[256], name[256];
    int r = 0;

    at -= at > 0 && path[at - 1] == '/'; /* "dataset/" is "dataset" */
    (void)snprintf(folder, sizeof folder, "%.*s", (int)at++, path);
    if (!is_dir(disk, folder))
        return find(disk, folder) >= 0 ? -ENOTDIR : -ENOENT;
    for (unsigned i = 0; r == 0 && i < disk->n; i++)
        if (is_below(disk->files[i].path, folder) && name_in(disk, i, at, name))
            r = fn(ctx, name, disk->files[i].path[at + strlen(name)] == '/');
    return r;
}

static int disk_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    *ret = (struct ttf_io_space){.free_bytes = INT64_C(1) << 40, .total_bytes = INT64_C(1) << 41};
    return 0;
}

static int disk_lock(struct ttf_io *io, int file)
{
    return 0;
}

static const struct ttf_io_ops OPS = {
    .name = "memory",
    .open = disk_open,
    .pread = disk_pread,
    .pwrite = disk_pwrite,
    .append = disk_append,
    .size = disk_size,
    .truncate = disk_truncate,
    .sync = disk_sync,
    .close = disk_close,
    .rename = disk_rename,
    .unlink = disk_unlink,
    .mkdir = disk_mkdir,
    .sync_dir = disk_sync_dir,
    .stat = disk_stat,
    .list = disk_list,
    .space = disk_space,
    .lock = disk_lock,
};

/* ---- for the targets ---- */

void fuzz_disk_init(struct fuzz_disk *disk)
{
    disk->base.ops = &OPS;
    disk->n = 0;
    memset(disk->handles, 0, sizeof disk->handles);
}

void fuzz_disk_free(struct fuzz_disk *disk)
{
    while (disk->n > 0)
        remove_entry(disk, (int)disk->n - 1);
}

void fuzz_disk_put(struct fuzz_disk *disk, const char *path, const void *data, size_t size)
{
    struct fuzz_node *node;
    int at = find(disk, path);

    if (at >= 0)
        remove_entry(disk, at);
    node = add_entry(disk, path);
    if (!node)
        abort();
    (void)write_at(node, data, size, 0);
}

const uint8_t *fuzz_disk_get(const struct fuzz_disk *disk, const char *path, size_t *ret_size)
{
    int at = find(disk, path);

    *ret_size = at < 0 ? 0 : disk->files[at].node->size;
    return at < 0 ? NULL : disk->files[at].node->data;
}

/* FNV-1a, 64 bits. */
static uint64_t hash(uint64_t h, const void *data, size_t n)
{
    const uint8_t *bytes = data;

    for (size_t i = 0; i < n; i++)
        h = (h ^ bytes[i]) * UINT64_C(0x100000001b3);
    return h;
}

uint64_t fuzz_disk_digest(const struct fuzz_disk *disk)
{
    uint64_t sum = disk->n;

    for (unsigned i = 0; i < disk->n; i++) {
        const struct fuzz_entry *e = &disk->files[i];
        uint64_t h = hash(UINT64_C(0xcbf29ce484222325), e->path, strlen(e->path) + 1);

        sum += hash(h, e->node->data, e->node->size);
    }
    return sum;
}

unsigned fuzz_disk_open_handles(const struct fuzz_disk *disk)
{
    unsigned n = 0;

    for (unsigned i = 0; i < FUZZ_DISK_FILES; i++)
        n += disk->handles[i] != NULL;
    return n;
}
