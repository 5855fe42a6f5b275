/* SPDX-License-Identifier: Apache-2.0 */
/* The disk's table of operations: each counts, may be made to fail, and is then done. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "alloc_hook.h"
#include "model_disk_private.h"

const char *model_op_name(enum model_op op)
{
    static const char *const names[OP_COUNT] = {
        "open",   "pread", "pwrite",   "append", "size", "truncate", "sync", "close",   "rename",
        "unlink", "mkdir", "sync_dir", "stat",   "list", "space",    "lock", "sync_all"};

    return names[op];
}

static struct model_disk *enter(struct ttf_io *io)
{
    struct model_disk *disk = (struct model_disk *)io;

    pthread_mutex_lock(&disk->mutex);
    alloc_hook_pause();
    return disk;
}

static void leave(struct model_disk *disk)
{
    alloc_hook_resume();
    pthread_mutex_unlock(&disk->mutex);
}

static bool is_short(const struct model_fault *fault)
{
    return fault->how == SHORT_ONCE || fault->how == SHORT_TWICE || fault->how == SHORT_THEN_ERROR;
}

/* What is to become of this operation: 0, or its error. *n may shrink. */
static int meets(struct model_disk *disk, enum model_op op, const char *path, bool changes,
                 size_t *n)
{
    const struct model_fault *fault = &disk->fault;
    struct model_call call = {.op = op, .changes = changes, .n = n ? *n : 0};
    long k = ++disk->n, at;
    bool hit;

    snprintf(call.path, sizeof(call.path), "%s", path);
    if (disk->log && k <= disk->log_room)
        disk->log[k - 1] = call;
    if (fault->of_op && op == fault->op && ++disk->n_of_op == fault->at)
        disk->from = k;
    at = fault->of_op ? disk->from : fault->at;
    hit = at > 0 && k >= at && k - at < fault->lasts;
    if (at > 0 && is_short(fault)) {
        hit = k == at;
        if (hit)
            disk->short_left = fault->how == SHORT_ONCE ? 0 : 1;
        else if (disk->short_left > 0 && k > at && op == disk->after_short) {
            disk->short_left = 0;
            if (fault->how == SHORT_THEN_ERROR)
                return -fault->error;
            hit = true;
        }
    }
    if (!hit)
        return 0;
    if (disk->n_failed++ == 0)
        disk->failed = call;
    if (!is_short(fault))
        return -fault->error;
    disk->after_short = op;
    if (n && *n > 1)
        *n /= 2;
    return 0;
}

/* Whether an operation that fails is done all the same. */
static bool done_anyway(const struct model_disk *disk)
{
    return disk->fault.how == FAIL_AFTER;
}

static struct model_handle *handle_of(struct model_disk *disk, int file)
{
    return file >= 0 && file < 64 && disk->handles[file].used ? &disk->handles[file] : NULL;
}

static const char *path_of(struct model_disk *disk, int file)
{
    struct model_handle *handle = handle_of(disk, file);

    return handle ? disk->names[handle->name].path : "";
}

static struct model_inode *inode_of(struct model_disk *disk, int file)
{
    struct model_handle *handle = handle_of(disk, file);

    return handle ? &disk->inodes[handle->inode] : NULL;
}

static bool has_parent(struct model_disk *disk, const char *path)
{
    char folder[200];
    char *slash;
    int i;

    snprintf(folder, sizeof(folder), "%s", path);
    slash = strrchr(folder, '/');
    if (!slash || slash == folder)
        return true;
    *slash = '\0';
    i = model_find(disk, folder);
    return i >= 0 && disk->names[i].seen >= 0;
}

static int do_open(struct model_disk *disk, const char *path, enum ttf_io_mode mode)
{
    int name = model_find(disk, path), file;
    bool there = name >= 0 && disk->names[name].seen >= 0;

    if (!there && (mode == TTF_IO_READ || !has_parent(disk, path)))
        return -ENOENT;
    if (there && mode == TTF_IO_CREATE_NEW)
        return -EEXIST;
    for (file = 0; file < 64 && disk->handles[file].used; file++)
        ;
    if (file == 64)
        return -EMFILE;
    if (!there) {
        name = model_name_make(disk, path);
        disk->names[name].seen = model_inode_make(disk, false);
        disk->names[name].dirty = true;
        disk->inodes[disk->names[name].seen].hollow = strstr(path, "/.events-reserve") != NULL;
    }
    disk->handles[file] =
        (struct model_handle){.used = true, .inode = disk->names[name].seen, .name = name};
    return file;
}

static int md_open(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_OPEN, path, mode != TTF_IO_READ, NULL);

    if (r == 0)
        r = do_open(disk, path, mode);
    else if (done_anyway(disk) && mode != TTF_IO_READ) { /* made, but nobody has it */
        int file = do_open(disk, path, mode);

        if (file >= 0)
            disk->handles[file].used = false;
    }
    leave(disk);
    return r;
}

static int64_t md_pread(struct ttf_io *io, int file, void *buf, size_t n, int64_t offset)
{
    struct model_disk *disk = enter(io);
    int64_t r = meets(disk, OP_PREAD, path_of(disk, file), false, &n);
    const struct model_inode *inode = inode_of(disk, file);

    if (r == 0 && !inode)
        r = -EBADF;
    if (r == 0 && (size_t)offset < inode->seen_bytes) {
        r = (int64_t)(inode->seen_bytes - (size_t)offset);
        r = r < (int64_t)n ? r : (int64_t)n;
        if (inode->hollow)
            memset(buf, 0, (size_t)r);
        else
            memcpy(buf, inode->seen + offset, (size_t)r);
    }
    leave(disk);
    return r;
}

/* For this file to be so long. */
static bool has_room(const struct model_disk *disk, const struct model_inode *inode, size_t bytes)
{
    return disk->capacity_bytes == 0 || bytes <= inode->seen_bytes ||
           model_disk_used(disk) + (int64_t)(bytes - inode->seen_bytes) <= disk->capacity_bytes;
}

static int64_t do_write(struct model_disk *disk, enum model_op op, int file, const void *buf,
                        size_t n, int64_t offset)
{
    int64_t r = meets(disk, op, path_of(disk, file), true, &n);
    struct model_inode *inode = inode_of(disk, file);

    size_t at;

    if (!inode)
        return -EBADF;
    at = op == OP_APPEND ? inode->seen_bytes : (size_t)offset;
    if (r == 0 && !has_room(disk, inode, at + n))
        return -ENOSPC;
    if (r == 0 || done_anyway(disk))
        model_write(inode, buf, n, at);
    return r ? r : (int64_t)n;
}

static int64_t md_pwrite(struct ttf_io *io, int file, const void *buf, size_t n, int64_t offset)
{
    struct model_disk *disk = enter(io);
    int64_t r = do_write(disk, OP_PWRITE, file, buf, n, offset);

    leave(disk);
    return r;
}

static int64_t md_append(struct ttf_io *io, int file, const void *buf, size_t n)
{
    struct model_disk *disk = enter(io);
    int64_t r = do_write(disk, OP_APPEND, file, buf, n, 0);

    leave(disk);
    return r;
}

static int md_size(struct ttf_io *io, int file, int64_t *ret_bytes)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_SIZE, path_of(disk, file), false, NULL);
    const struct model_inode *inode = inode_of(disk, file);

    if (r == 0 && inode)
        *ret_bytes = (int64_t)inode->seen_bytes;
    leave(disk);
    return r || inode ? r : -EBADF;
}

static int md_truncate(struct ttf_io *io, int file, int64_t bytes)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_TRUNCATE, path_of(disk, file), true, NULL);
    struct model_inode *inode = inode_of(disk, file);

    if (inode && (r == 0 || done_anyway(disk)))
        model_truncate(inode, (size_t)bytes);
    leave(disk);
    return r || inode ? r : -EBADF;
}

static int md_sync(struct ttf_io *io, int file, bool data_only)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_SYNC, path_of(disk, file), true, NULL);
    struct model_inode *inode = inode_of(disk, file);

    if (inode)
        model_sync(inode, r == 0 || done_anyway(disk));
    leave(disk);
    return r || inode ? r : -EBADF;
}

static int md_close(struct ttf_io *io, int file)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_CLOSE, path_of(disk, file), true, NULL);
    struct model_handle *handle = handle_of(disk, file);

    if (!handle) {
        r = -EBADF;
    } else { /* gone, whatever it says */
        if (handle->locks)
            disk->inodes[handle->inode].locked = false;
        handle->used = false;
    }
    leave(disk);
    return r;
}

static int do_rename(struct model_disk *disk, const char *from, const char *to)
{
    int a = model_find(disk, from), b;

    if (a < 0 || disk->names[a].seen < 0 || !has_parent(disk, to))
        return -ENOENT;
    b = model_name_make(disk, to);
    disk->names[b].seen = disk->names[a].seen;
    disk->names[a].seen = -1;
    disk->names[a].dirty = disk->names[b].dirty = true;
    return 0;
}

static int md_rename(struct ttf_io *io, const char *from, const char *to)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_RENAME, to, true, NULL);

    if (r == 0)
        r = do_rename(disk, from, to);
    else if (done_anyway(disk))
        (void)do_rename(disk, from, to);
    leave(disk);
    return r;
}

static int do_unlink(struct model_disk *disk, const char *path)
{
    int a = model_find(disk, path);

    if (a < 0 || disk->names[a].seen < 0)
        return -ENOENT;
    for (int i = 0; i < disk->n_names; i++)
        if (disk->names[i].seen >= 0 && model_is_in(disk->names[i].path, path))
            return -ENOTEMPTY;
    disk->names[a].seen = -1;
    disk->names[a].dirty = true;
    return 0;
}

static int md_unlink(struct ttf_io *io, const char *path)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_UNLINK, path, true, NULL);

    if (r == 0)
        r = do_unlink(disk, path);
    else if (done_anyway(disk))
        (void)do_unlink(disk, path);
    leave(disk);
    return r;
}

static int do_mkdir(struct model_disk *disk, const char *path)
{
    int a;

    if (!has_parent(disk, path))
        return -ENOENT;
    a = model_name_make(disk, path);
    if (disk->names[a].seen >= 0)
        return -EEXIST;
    disk->names[a].seen = model_inode_make(disk, true);
    disk->names[a].dirty = true;
    return 0;
}

static int md_mkdir(struct ttf_io *io, const char *path)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_MKDIR, path, true, NULL);

    if (r == 0)
        r = do_mkdir(disk, path);
    else if (done_anyway(disk))
        (void)do_mkdir(disk, path);
    leave(disk);
    return r;
}

static int md_sync_dir(struct ttf_io *io, const char *path)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_SYNC_DIR, path, true, NULL);

    if (r == 0 && !model_disk_has(disk, path))
        r = -ENOENT;
    else
        model_sync_dir(disk, path, r == 0 || done_anyway(disk));
    leave(disk);
    return r;
}

static int md_stat(struct ttf_io *io, const char *path, struct ttf_io_stat *ret)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_STAT, path, false, NULL);
    int i = model_find(disk, path);

    if (r == 0 && (i < 0 || disk->names[i].seen < 0))
        r = -ENOENT;
    if (r == 0) {
        const struct model_inode *inode = &disk->inodes[disk->names[i].seen];

        *ret = (struct ttf_io_stat){.device = disk->device,
                                    .is_dir = inode->is_dir,
                                    .is_regular = !inode->is_dir,
                                    .bytes = (int64_t)inode->seen_bytes};
    }
    leave(disk);
    return r;
}

/* Told outside of the lock: who is told may come back with operations. */
static int md_list(struct ttf_io *io, const char *path, ttf_io_entry_fn *fn, void *ctx)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_LIST, path, false, NULL);
    size_t n = strlen(path);
    char folder[200], name[200];

    snprintf(folder, sizeof(folder), "%s", path);
    while (n > 1 && folder[n - 1] == '/')
        folder[--n] = '\0';
    if (r == 0 && !model_disk_has(disk, folder))
        r = -ENOENT;
    for (int i = 0; r == 0 && i < disk->n_names; i++) {
        bool is_dir;

        if (disk->names[i].seen < 0 || !model_is_in(disk->names[i].path, folder))
            continue;
        is_dir = disk->inodes[disk->names[i].seen].is_dir;
        snprintf(name, sizeof(name), "%s", disk->names[i].path + n + 1);
        leave(disk);
        r = fn(ctx, name, is_dir);
        (void)enter(io);
    }
    leave(disk);
    return r;
}

static int md_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_SPACE, path, false, NULL);

    if (r == 0)
        *ret =
            (struct ttf_io_space){.free_bytes = INT64_C(1) << 40, .total_bytes = INT64_C(1) << 41};
    if (r == 0 && disk->capacity_bytes > 0)
        *ret =
            (struct ttf_io_space){.free_bytes = disk->capacity_bytes > model_disk_used(disk)
                                                    ? disk->capacity_bytes - model_disk_used(disk)
                                                    : 0,
                                  .total_bytes = disk->capacity_bytes};
    leave(disk);
    return r;
}

static int md_lock(struct ttf_io *io, int file)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_LOCK, path_of(disk, file), false, NULL);
    struct model_inode *inode = inode_of(disk, file);

    if (r == 0 && !inode)
        r = -EBADF;
    else if (r == 0 && inode->locked)
        r = -EAGAIN;
    else if (r == 0)
        inode->locked = disk->handles[file].locks = true;
    leave(disk);
    return r;
}

static int md_sync_all(struct ttf_io *io, int file)
{
    struct model_disk *disk = enter(io);
    int r = meets(disk, OP_SYNC_ALL, path_of(disk, file), true, NULL);

    if (r == 0 && !inode_of(disk, file))
        r = -EBADF;
    else
        model_sync_all(disk, r == 0 || done_anyway(disk));
    leave(disk);
    return r;
}

const struct ttf_io_ops model_disk_ops = {
    .name = "model",
    .open = md_open,
    .pread = md_pread,
    .pwrite = md_pwrite,
    .append = md_append,
    .size = md_size,
    .truncate = md_truncate,
    .sync = md_sync,
    .close = md_close,
    .rename = md_rename,
    .unlink = md_unlink,
    .mkdir = md_mkdir,
    .sync_dir = md_sync_dir,
    .stat = md_stat,
    .list = md_list,
    .space = md_space,
    .lock = md_lock,
    .sync_all = md_sync_all,
};
