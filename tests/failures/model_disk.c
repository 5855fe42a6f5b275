/* SPDX-License-Identifier: Apache-2.0 */
/* What is seen and what is kept. The operations: model_disk_io.c. */
#include "model_disk.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alloc_hook.h"
#include "model_disk_private.h"

static void *must(void *p)
{
    if (!p)
        abort();
    return p;
}

int model_inode_make(struct model_disk *disk, bool is_dir)
{
    disk->inodes =
        must(realloc(disk->inodes, ((size_t)disk->n_inodes + 1) * sizeof(*disk->inodes)));
    disk->inodes[disk->n_inodes] = (struct model_inode){.is_dir = is_dir};
    return disk->n_inodes++;
}

int model_find(const struct model_disk *disk, const char *path)
{
    for (int i = 0; i < disk->n_names; i++)
        if (strcmp(disk->names[i].path, path) == 0)
            return i;
    return -1;
}

int model_name_make(struct model_disk *disk, const char *path)
{
    int i = model_find(disk, path);

    if (i >= 0)
        return i;
    if (strlen(path) >= sizeof(disk->names[0].path))
        abort();
    disk->names = must(realloc(disk->names, ((size_t)disk->n_names + 1) * sizeof(*disk->names)));
    disk->names[disk->n_names] = (struct model_name){.seen = -1, .kept = -1};
    memcpy(disk->names[disk->n_names].path, path, strlen(path) + 1);
    return disk->n_names++;
}

bool model_is_in(const char *path, const char *folder)
{
    size_t n = strlen(folder);

    return strncmp(path, folder, n) == 0 && path[n] == '/' && !strchr(path + n + 1, '/');
}

void model_disk_init(struct model_disk *disk)
{
    int name;

    alloc_hook_pause();
    *disk = (struct model_disk){.io = {.ops = &model_disk_ops}};
    pthread_mutex_init(&disk->mutex, NULL);
    name = model_name_make(disk, "/m");
    disk->names[name].seen = disk->names[name].kept = model_inode_make(disk, true);
    alloc_hook_resume();
}

void model_disk_free(struct model_disk *disk)
{
    for (int i = 0; i < disk->n_inodes; i++) {
        free(disk->inodes[i].seen);
        free(disk->inodes[i].kept);
        free(disk->inodes[i].dirty);
    }
    free(disk->inodes);
    free(disk->names);
    pthread_mutex_destroy(&disk->mutex);
    *disk = (struct model_disk){0};
}

static unsigned char *copy_of(const unsigned char *bytes, size_t n)
{
    return n ? memcpy(must(malloc(n)), bytes, n) : NULL;
}

static bool has_name(const struct model_disk *disk, int inode)
{
    for (int i = 0; i < disk->n_names; i++)
        if (disk->names[i].seen == inode || disk->names[i].kept == inode)
            return true;
    return false;
}

void model_disk_copy(struct model_disk *to, struct model_disk *from)
{
    alloc_hook_pause();
    *to = (struct model_disk){.io = {.ops = &model_disk_ops},
                              .n_inodes = from->n_inodes,
                              .n_names = from->n_names,
                              .capacity_bytes = from->capacity_bytes,
                              .device = from->device};
    pthread_mutex_init(&to->mutex, NULL);
    to->inodes = must(calloc((size_t)from->n_inodes, sizeof(*to->inodes)));
    to->names = must(calloc((size_t)from->n_names, sizeof(*to->names)));
    memcpy(to->names, from->names, (size_t)from->n_names * sizeof(*to->names));
    for (int i = 0; i < from->n_inodes; i++) {
        const struct model_inode *source = &from->inodes[i];

        if (!has_name(from, i)) /* nobody can get at it any more */
            continue;
        to->inodes[i] = *source;
        to->inodes[i].locked = false;
        to->inodes[i].seen = copy_of(source->seen, source->room);
        to->inodes[i].kept = copy_of(source->kept, source->room);
        to->inodes[i].dirty = copy_of(source->dirty, source->room);
    }
    alloc_hook_resume();
}

/* ---- files ---- */

static void make_room(struct model_inode *inode, size_t bytes)
{
    size_t room = inode->room ? inode->room : 64;

    while (room < bytes)
        room *= 2;
    if (room == inode->room)
        return;
    inode->seen = must(realloc(inode->seen, room));
    inode->kept = must(realloc(inode->kept, room));
    inode->dirty = must(realloc(inode->dirty, room));
    memset(inode->seen + inode->room, 0, room - inode->room);
    memset(inode->kept + inode->room, 0, room - inode->room);
    memset(inode->dirty + inode->room, 0, room - inode->room);
    inode->room = room;
}

void model_write(struct model_inode *inode, const void *buf, size_t n, size_t at)
{
    if (n == 0)
        return;
    if (inode->hollow) {
        inode->seen_bytes = at + n > inode->seen_bytes ? at + n : inode->seen_bytes;
        return;
    }
    make_room(inode, at + n);
    memcpy(inode->seen + at, buf, n);
    memset(inode->dirty + at, 1, n);
    if (at + n > inode->seen_bytes) {
        inode->seen_bytes = at + n;
        inode->size_dirty = true;
    }
}

void model_truncate(struct model_inode *inode, size_t bytes)
{
    if (inode->hollow) {
        inode->seen_bytes = bytes;
        return;
    }
    make_room(inode, bytes);
    if (bytes < inode->seen_bytes) {
        memset(inode->seen + bytes, 0, inode->room - bytes);
        memset(inode->dirty + bytes, 0, inode->room - bytes);
    }
    inode->size_dirty = inode->size_dirty || bytes != inode->seen_bytes;
    inode->seen_bytes = bytes;
}

void model_sync(struct model_inode *inode, bool keep)
{
    if (inode->hollow) {
        inode->kept_bytes = keep ? inode->seen_bytes : inode->kept_bytes;
        return;
    }
    if (keep && inode->size_dirty) {
        if (inode->seen_bytes < inode->kept_bytes)
            memset(inode->kept + inode->seen_bytes, 0, inode->kept_bytes - inode->seen_bytes);
        inode->kept_bytes = inode->seen_bytes;
    }
    for (size_t i = 0; keep && i < inode->seen_bytes; i++)
        if (inode->dirty[i])
            inode->kept[i] = inode->seen[i];
    if (inode->room)
        memset(inode->dirty, 0, inode->room);
    inode->size_dirty = false;
}

static void sync_name(const struct model_disk *disk, struct model_name *name, bool keep)
{
    if (!name->dirty)
        return;
    if (keep)
        name->kept = name->seen;
    /* A failed sync: see model_disk.h of folders. */
    name->dirty = !keep && name->seen >= 0 && disk->inodes[name->seen].is_dir;
}

void model_sync_dir(struct model_disk *disk, const char *folder, bool keep)
{
    for (int i = 0; i < disk->n_names; i++)
        if (model_is_in(disk->names[i].path, folder))
            sync_name(disk, &disk->names[i], keep);
}

void model_sync_all(struct model_disk *disk, bool keep)
{
    for (int i = 0; i < disk->n_inodes; i++)
        model_sync(&disk->inodes[i], keep);
    for (int i = 0; i < disk->n_names; i++)
        sync_name(disk, &disk->names[i], keep);
}

/* ---- the whole ---- */

void model_disk_kill(struct model_disk *disk)
{
    memset(disk->handles, 0, sizeof(disk->handles));
    for (int i = 0; i < disk->n_inodes; i++)
        disk->inodes[i].locked = false;
}

/* A name whose folder was not kept is out of reach. */
static void lose_if_out_of_reach(struct model_disk *disk, struct model_name *name)
{
    char folder[sizeof(name->path)];
    char *slash;
    int parent;

    memcpy(folder, name->path, sizeof(folder));
    for (slash = strrchr(folder, '/'); slash && slash > folder; slash = strrchr(folder, '/')) {
        *slash = '\0';
        parent = model_find(disk, folder);
        if (parent < 0 || disk->names[parent].kept < 0)
            name->kept = -1;
    }
}

void model_disk_lose_power(struct model_disk *disk)
{
    model_disk_kill(disk);
    for (int i = 0; i < disk->n_names; i++)
        lose_if_out_of_reach(disk, &disk->names[i]);
    for (int i = 0; i < disk->n_names; i++) {
        disk->names[i].seen = disk->names[i].kept;
        disk->names[i].dirty = false;
    }
    for (int i = 0; i < disk->n_inodes; i++) {
        struct model_inode *inode = &disk->inodes[i];

        if (inode->room) {
            memcpy(inode->seen, inode->kept, inode->room);
            memset(inode->dirty, 0, inode->room);
        }
        inode->seen_bytes = inode->kept_bytes;
        inode->size_dirty = false;
    }
}

void model_disk_fail(struct model_disk *disk, struct model_fault fault)
{
    pthread_mutex_lock(&disk->mutex);
    disk->fault = fault;
    disk->n = disk->n_failed = disk->n_of_op = disk->from = 0;
    disk->short_left = 0;
    pthread_mutex_unlock(&disk->mutex);
}

unsigned model_disk_open_handles(struct model_disk *disk)
{
    unsigned n = 0;

    for (unsigned i = 0; i < sizeof(disk->handles) / sizeof(disk->handles[0]); i++)
        n += disk->handles[i].used;
    return n;
}

int64_t model_disk_used(const struct model_disk *disk)
{
    int64_t used = 0;

    for (int i = 0; i < disk->n_names; i++)
        if (disk->names[i].seen >= 0)
            used += (int64_t)disk->inodes[disk->names[i].seen].seen_bytes;
    return used;
}

bool model_disk_has(struct model_disk *disk, const char *path)
{
    int i = model_find(disk, path);

    return i >= 0 && disk->names[i].seen >= 0;
}
