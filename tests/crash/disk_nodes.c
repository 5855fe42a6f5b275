/* SPDX-License-Identifier: Apache-2.0 */
/* Nodes, names and bytes of the disk. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "disk_private.h"

void *disk_need(void *memory)
{
    if (!memory) {
        fputs("crash: no memory\n", stderr);
        abort();
    }
    return memory;
}

struct disk *disk_alloc(const char *hollow)
{
    struct disk *disk = disk_need(malloc(sizeof(*disk)));

    disk->io.ops = &disk_ops;
    disk->n_nodes = 0;
    memset(disk->handles, 0, sizeof(disk->handles));
    disk->effects = NULL;
    disk->n_effects = disk->effects_room = 0;
    memcpy(disk->hollow, hollow, sizeof(disk->hollow));
    disk->dead = false;
    disk->fresh = DISK_ZEROS;
    disk->step = NULL;
    disk->step_ctx = NULL;
    return disk;
}

int disk_node_add(struct disk *disk, bool is_dir, bool hollow)
{
    struct disk_node *node = disk_need(calloc(1, sizeof(*node)));

    if (disk->n_nodes == DISK_NODES_MAX)
        disk_need(NULL);
    node->is_dir = is_dir;
    node->hollow = hollow;
    if (!is_dir) {
        node->bytes[0] = disk_need(calloc(1, sizeof(*node->bytes[0])));
        node->bytes[0]->refs = 1;
        node->bytes[1] = disk_bytes_share(node->bytes[0]);
    }
    disk->nodes[disk->n_nodes] = node;
    return disk->n_nodes++;
}

void disk_node_drop(struct disk *disk, int i)
{
    struct disk_node *node = disk->nodes[i];
    int state;

    for (state = 0; state < 2; state++) {
        disk_bytes_release(node->bytes[state]);
        free(node->names[state].items);
    }
    free(node);
    disk->nodes[i] = NULL;
}

int disk_names_find(const struct disk_names *names, const char *name)
{
    unsigned i;

    for (i = 0; i < names->n; i++)
        if (strcmp(names->items[i].name, name) == 0)
            return names->items[i].node;
    return -ENOENT;
}

void disk_names_set(struct disk_names *names, const char *name, int node)
{
    unsigned i;

    for (i = 0; i < names->n && strcmp(names->items[i].name, name) != 0; i++)
        ;
    if (node < 0) {
        if (i < names->n)
            names->items[i] = names->items[--names->n];
        return;
    }
    if (i == names->room) {
        names->room = names->room ? 2 * names->room : 8;
        names->items = disk_need(reallocarray(names->items, names->room, sizeof(*names->items)));
    }
    if (i == names->n) {
        snprintf(names->items[i].name, DISK_NAME_BYTES, "%s", name);
        names->n++;
    }
    names->items[i].node = node;
}

void disk_names_copy(struct disk_names *to, const struct disk_names *from)
{
    to->n = to->room = from->n;
    to->items = NULL;
    if (from->n == 0)
        return;
    to->items = disk_need(malloc(from->n * sizeof(*to->items)));
    memcpy(to->items, from->items, from->n * sizeof(*to->items));
}

struct disk_bytes *disk_bytes_share(struct disk_bytes *bytes)
{
    bytes->refs++;
    return bytes;
}

void disk_bytes_release(struct disk_bytes *bytes)
{
    if (bytes && --bytes->refs == 0)
        free(bytes);
}

struct disk_bytes *disk_bytes_own(struct disk_bytes **bytes, size_t n)
{
    struct disk_bytes *old = *bytes, *own;
    size_t room;

    if (old->refs == 1 && old->room >= n) {
        old->hash = 0;
        return old;
    }
    n = n > old->room ? n : old->room;
    room = n < 256 ? 256 : n + n / 2;
    own = disk_need(malloc(sizeof(*own) + room));
    own->refs = 1;
    own->n = old->n;
    own->room = room;
    own->hash = 0;
    /* What lies behind the end too: it is zeros, or bytes whose length is still to come. */
    memcpy(own->at, old->at, old->room);
    memset(own->at + old->room, 0, room - old->room);
    disk_bytes_release(old);
    *bytes = own;
    return own;
}

/* The node of the first n bytes of path. */
static int find(const struct disk *disk, const char *path, const char *end)
{
    char name[DISK_NAME_BYTES];
    const char *slash;
    int node = 0;
    size_t n;

    while (node >= 0 && path < end) {
        if (*path == '/') {
            path++;
            continue;
        }
        slash = memchr(path, '/', (size_t)(end - path));
        n = (size_t)((slash ? slash : end) - path);
        if (n >= sizeof(name))
            return -ENAMETOOLONG;
        if (!disk->nodes[node]->is_dir)
            return -ENOTDIR;
        memcpy(name, path, n);
        name[n] = '\0';
        node = disk_names_find(&disk->nodes[node]->names[0], name);
        path += n;
    }
    return node;
}

int disk_find(const struct disk *disk, const char *path)
{
    return find(disk, path, path + strlen(path));
}

int disk_find_folder(const struct disk *disk, const char *path, const char **ret_name)
{
    const char *slash = strrchr(path, '/');
    int node;

    if (!slash || strlen(slash + 1) >= DISK_NAME_BYTES || slash[1] == '\0')
        return -EINVAL;
    *ret_name = slash + 1;
    node = find(disk, path, slash);
    return node >= 0 && !disk->nodes[node]->is_dir ? -ENOTDIR : node;
}
