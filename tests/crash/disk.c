/* SPDX-License-Identifier: Apache-2.0 */
/* The disk as an I/O table. */
#include "disk.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "disk_private.h"

/* Whose lines hold no crc: README.md, "The disk". */
#define NO_CRC "SHA256SUMS"

static struct disk *of(struct ttf_io *io)
{
    return (struct disk *)io;
}

static int step(struct disk *disk, const char *op, const char *path)
{
    int r;

    if (disk->dead)
        return -EIO;
    r = disk->step ? disk->step(disk->step_ctx, disk, op, path) : 0;
    return disk->dead ? -EIO : r;
}

/* For handles, of which only the node is known. */
static int step_node(struct disk *disk, const char *op, int node)
{
    char path[1024] = "";
    int folder, at = node;
    unsigned k;
    size_t n;

    if (disk->dead)
        return -EIO;
    if (!disk->step)
        return 0;
    while (at != 0) { /* upwards: a path is only wanted here */
        int found = -1;

        for (folder = 0; found < 0 && folder < disk->n_nodes; folder++)
            for (k = 0; k < disk->nodes[folder]->names[0].n; k++)
                if (disk->nodes[folder]->names[0].items[k].node == at) {
                    const char *name = disk->nodes[folder]->names[0].items[k].name;

                    n = strlen(name);
                    memmove(path + n + 1, path, sizeof(path) - n - 1);
                    path[sizeof(path) - 1] = '\0';
                    path[0] = '/';
                    memcpy(path + 1, name, n);
                    found = folder;
                    break;
                }
        if (found < 0)
            break; /* it has no name any more */
        at = found;
    }
    return step(disk, op, path);
}

/* The node of a handle. */
static int node_of(const struct disk *disk, int file)
{
    if (disk->dead)
        return -EIO;
    if (file < 0 || file >= DISK_HANDLES_MAX || disk->handles[file] == 0)
        return -EBADF;
    return disk->handles[file] - 1;
}

static int op_open(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    struct disk *disk = of(io);
    const char *name = NULL;
    int folder, node, file, r;

    if (disk->dead)
        return -EIO;
    for (file = 0; file < DISK_HANDLES_MAX && disk->handles[file]; file++)
        ;
    if (file == DISK_HANDLES_MAX)
        return -EMFILE;
    node = disk_find(disk, path);
    if (node < 0 && node != -ENOENT)
        return node;
    if (node >= 0 && mode == TTF_IO_CREATE_NEW)
        return -EEXIST;
    if (node >= 0 && mode == TTF_IO_APPEND && disk->nodes[node]->is_dir)
        return -EISDIR;
    if (node == -ENOENT) {
        if (mode == TTF_IO_READ)
            return node;
        folder = disk_find_folder(disk, path, &name);
        if (folder < 0)
            return folder;
        r = step(disk, "open", path);
        if (r)
            return r;
        node = disk_node_add(disk, false, strcmp(name, disk->hollow) == 0);
        disk->nodes[node]->no_crc = strncmp(name, NO_CRC, strlen(NO_CRC)) == 0;
        disk_names_set(&disk->nodes[folder]->names[0], name, node);
        disk_effect_name(disk, DISK_LINK, folder, name, NULL, node);
    }
    disk->handles[file] = node + 1;
    return file;
}

static int64_t op_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    struct disk *disk = of(io);
    int node = node_of(disk, file);
    const struct disk_bytes *bytes;

    if (node < 0)
        return node;
    if (disk->nodes[node]->is_dir)
        return -EISDIR;
    bytes = disk->nodes[node]->bytes[0];
    if (offset < 0 || (size_t)offset >= bytes->n)
        return offset < 0 ? -EINVAL : 0;
    n = n < bytes->n - (size_t)offset ? n : bytes->n - (size_t)offset;
    if (bytes->room == 0)
        memset(buf, 0, n);
    else
        memcpy(buf, bytes->at + offset, n);
    return (int64_t)n;
}

static void set_length(struct disk_node *node, size_t n)
{
    struct disk_bytes *own;

    if (node->hollow) {
        own = disk_need(calloc(1, sizeof(*own)));
        own->refs = 1;
        disk_bytes_release(node->bytes[0]);
        node->bytes[0] = own;
    } else {
        own = disk_bytes_own(&node->bytes[0], n > node->bytes[0]->n ? n : node->bytes[0]->n);
        if (n < own->n)
            memset(own->at + n, 0, own->room - n);
    }
    own->n = n;
}

static int64_t write_at(struct disk *disk, int i, const void *buf, size_t n, size_t offset)
{
    struct disk_node *node = disk->nodes[i];

    if (n == 0)
        return 0;
    if (offset > node->bytes[0]->n)
        disk_effect_hole(disk, i, offset);
    if (offset + n > node->bytes[0]->n) {
        set_length(node, offset + n);
        disk_effect_length(disk, i, offset + n, true);
    }
    if (!node->hollow) {
        memcpy(disk_bytes_own(&node->bytes[0], offset + n)->at + offset, buf, n);
        disk_effect_data(disk, i, offset, buf, n);
    }
    return (int64_t)n;
}

static int64_t op_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    struct disk *disk = of(io);
    int node = node_of(disk, file), r;

    if (node < 0)
        return node;
    r = step_node(disk, "pwrite", node);
    return r ? r : write_at(disk, node, buf, n, (size_t)offset);
}

static int64_t op_append(struct ttf_io *io, int file, const void *buf, size_t n)
{
    struct disk *disk = of(io);
    int node = node_of(disk, file), r;

    if (node < 0)
        return node;
    r = step_node(disk, "append", node);
    return r ? r : write_at(disk, node, buf, n, disk->nodes[node]->bytes[0]->n);
}

static int op_size(struct ttf_io *io, int file, int64_t *ret_bytes)
{
    struct disk *disk = of(io);
    int node = node_of(disk, file);

    if (node < 0)
        return node;
    *ret_bytes = disk->nodes[node]->is_dir ? 0 : (int64_t)disk->nodes[node]->bytes[0]->n;
    return 0;
}

static int op_truncate(struct ttf_io *io, int file, int64_t bytes)
{
    struct disk *disk = of(io);
    int node = node_of(disk, file), r;
    size_t now;

    if (node < 0)
        return node;
    r = step_node(disk, "truncate", node);
    if (r)
        return r;
    now = disk->nodes[node]->bytes[0]->n;
    if ((size_t)bytes == now)
        return 0;
    set_length(disk->nodes[node], (size_t)bytes);
    if ((size_t)bytes > now)
        disk_effect_hole(disk, node, (size_t)bytes);
    else
        disk_effect_length(disk, node, (size_t)bytes, false);
    return 0;
}

static int op_sync(struct ttf_io *io, int file, bool data_only)
{
    struct disk *disk = of(io);
    int node = node_of(disk, file), r;

    if (node < 0)
        return node;
    r = step_node(disk, "sync", node);
    if (r == 0)
        disk_make_durable(disk, node, data_only);
    return r;
}

static int op_close(struct ttf_io *io, int file)
{
    struct disk *disk = of(io);
    int node = node_of(disk, file);

    if (node < 0)
        return node;
    disk->handles[file] = 0;
    return 0;
}

static int op_rename(struct ttf_io *io, const char *from, const char *to)
{
    struct disk *disk = of(io);
    const char *name, *name_to;
    int folder, node, r;

    if (disk->dead)
        return -EIO;
    folder = disk_find_folder(disk, from, &name);
    if (folder < 0)
        return folder;
    if (disk_find_folder(disk, to, &name_to) != folder)
        return -EXDEV; /* the store never does */
    node = disk_names_find(&disk->nodes[folder]->names[0], name);
    if (node < 0)
        return node;
    r = step(disk, "rename", to);
    if (r)
        return r;
    disk_names_set(&disk->nodes[folder]->names[0], name, -1);
    disk_names_set(&disk->nodes[folder]->names[0], name_to, node);
    disk_effect_name(disk, DISK_RENAME, folder, name, name_to, node);
    return 0;
}

static int op_unlink(struct ttf_io *io, const char *path)
{
    struct disk *disk = of(io);
    const char *name;
    int folder, node, r;

    if (disk->dead)
        return -EIO;
    folder = disk_find_folder(disk, path, &name);
    if (folder < 0)
        return folder;
    node = disk_names_find(&disk->nodes[folder]->names[0], name);
    if (node < 0)
        return node;
    if (disk->nodes[node]->is_dir && disk->nodes[node]->names[0].n > 0)
        return -ENOTEMPTY;
    r = step(disk, "unlink", path);
    if (r)
        return r;
    disk_names_set(&disk->nodes[folder]->names[0], name, -1);
    disk_effect_name(disk, DISK_UNLINK, folder, name, NULL, -1);
    return 0;
}

static int op_mkdir(struct ttf_io *io, const char *path)
{
    struct disk *disk = of(io);
    const char *name;
    int folder, node, r;

    if (disk->dead)
        return -EIO;
    folder = disk_find_folder(disk, path, &name);
    if (folder < 0)
        return folder;
    if (disk_names_find(&disk->nodes[folder]->names[0], name) >= 0)
        return -EEXIST;
    r = step(disk, "mkdir", path);
    if (r)
        return r;
    node = disk_node_add(disk, true, false);
    disk_names_set(&disk->nodes[folder]->names[0], name, node);
    disk_effect_name(disk, DISK_LINK, folder, name, NULL, node);
    return 0;
}

static int op_sync_dir(struct ttf_io *io, const char *path)
{
    struct disk *disk = of(io);
    int node, r;

    if (disk->dead)
        return -EIO;
    node = disk_find(disk, path);
    if (node < 0)
        return node;
    r = step(disk, "sync_dir", path);
    if (r == 0)
        disk_make_durable(disk, node, false);
    return r;
}

static int op_stat(struct ttf_io *io, const char *path, struct ttf_io_stat *ret)
{
    struct disk *disk = of(io);
    int node = disk->dead ? -EIO : disk_find(disk, path);

    if (node < 0)
        return node;
    ret->is_dir = disk->nodes[node]->is_dir;
    ret->is_regular = !ret->is_dir;
    ret->mtime_ns = 0;
    ret->bytes = ret->is_dir ? 0 : (int64_t)disk->nodes[node]->bytes[0]->n;
    return 0;
}

static int op_list(struct ttf_io *io, const char *path, ttf_io_entry_fn *fn, void *ctx)
{
    struct disk *disk = of(io);
    int node = disk->dead ? -EIO : disk_find(disk, path), r = 0;
    const struct disk_names *names;
    unsigned i;

    if (node < 0)
        return node;
    if (!disk->nodes[node]->is_dir)
        return -ENOTDIR;
    names = &disk->nodes[node]->names[0];
    for (i = 0; r == 0 && i < names->n; i++)
        r = fn(ctx, names->items[i].name, disk->nodes[names->items[i].node]->is_dir);
    return r;
}

static int op_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    *ret = (struct ttf_io_space){.free_bytes = (int64_t)1 << 40, .total_bytes = (int64_t)1 << 41};
    return of(io)->dead ? -EIO : 0;
}

static int op_lock(struct ttf_io *io, int file)
{
    return of(io)->dead ? -EIO : 0;
}

const struct ttf_io_ops disk_ops = {
    .name = "crash",
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

struct ttf_io *disk_io(struct disk *disk)
{
    return &disk->io;
}

void disk_fresh_blocks(struct disk *disk, enum disk_fresh fresh)
{
    disk->fresh = fresh;
}

void disk_on_step(struct disk *disk, disk_step_fn *fn, void *ctx)
{
    disk->step = fn;
    disk->step_ctx = ctx;
}

void disk_kill(struct disk *disk)
{
    disk->dead = true;
}

void disk_revive(struct disk *disk)
{
    disk->dead = false;
    memset(disk->handles, 0, sizeof(disk->handles));
}

void disk_hollow(struct disk *disk, const char *name)
{
    snprintf(disk->hollow, sizeof(disk->hollow), "%s", name);
}

struct disk *disk_create(const char *path)
{
    char none[DISK_NAME_BYTES] = "";
    struct disk *disk = disk_alloc(none);
    char copy[256];
    size_t i;

    disk_node_add(disk, true, false);
    snprintf(copy, sizeof(copy), "%s/", path);
    for (i = 1; copy[i]; i++)
        if (copy[i] == '/') {
            copy[i] = '\0';
            (void)op_mkdir(&disk->io, copy);
            copy[i] = '/';
        }
    for (i = 0; i < (size_t)disk->n_nodes; i++)
        disk_make_durable(disk, (int)i, false);
    return disk;
}

void disk_put(struct disk *disk, const char *path, const void *bytes, size_t n)
{
    int file = op_open(&disk->io, path, TTF_IO_CREATE_NEW);
    char folder[256];

    if (file < 0 || op_append(&disk->io, file, bytes, n) != (int64_t)n)
        disk_need(NULL);
    (void)op_sync(&disk->io, file, false);
    (void)op_close(&disk->io, file);
    snprintf(folder, sizeof(folder), "%.*s", (int)(strrchr(path, '/') - path), path);
    (void)op_sync_dir(&disk->io, folder);
}

void disk_destroy(struct disk *disk)
{
    unsigned k;
    int i;

    if (!disk)
        return;
    for (i = 0; i < disk->n_nodes; i++)
        disk_node_drop(disk, i);
    for (k = 0; k < disk->n_effects; k++)
        free(disk->effects[k].data);
    free(disk->effects);
    free(disk);
}
