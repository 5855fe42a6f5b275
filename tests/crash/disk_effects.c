/* SPDX-License-Identifier: Apache-2.0 */
/* What was done and not yet synced; and the disk as a power cut leaves it. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "disk_private.h"

static struct disk_effect *add(struct disk *disk, enum disk_effect_kind kind, int node)
{
    struct disk_effect *effect;

    if (disk->n_effects == disk->effects_room) {
        disk->effects_room = disk->effects_room ? 2 * disk->effects_room : 16;
        disk->effects =
            disk_need(reallocarray(disk->effects, disk->effects_room, sizeof(*disk->effects)));
    }
    if (disk->n_effects == DISK_EFFECTS_MAX)
        disk_need(NULL);
    effect = &disk->effects[disk->n_effects++];
    effect->kind = kind;
    effect->node = node;
    effect->target = -1;
    effect->lost = effect->hole = false;
    effect->name[0] = effect->to[0] = '\0';
    effect->offset = effect->n = 0;
    effect->data = NULL;
    return effect;
}

void disk_effect_name(struct disk *disk, enum disk_effect_kind kind, int folder, const char *name,
                      const char *to, int target)
{
    struct disk_effect *effect = add(disk, kind, folder);

    snprintf(effect->name, sizeof(effect->name), "%s", name);
    snprintf(effect->to, sizeof(effect->to), "%s", to ? to : "");
    effect->target = target;
}

void disk_effect_length(struct disk *disk, int node, size_t bytes, bool longer)
{
    add(disk, longer ? DISK_LONGER : DISK_SHORTER, node)->offset = bytes;
}

void disk_effect_hole(struct disk *disk, int node, size_t bytes)
{
    struct disk_effect *effect = add(disk, DISK_LONGER, node);

    effect->offset = bytes;
    effect->hole = true;
}

void disk_effect_data(struct disk *disk, int node, size_t offset, const void *data, size_t n)
{
    const unsigned char *at = data;
    struct disk_effect *effect;
    size_t piece;

    for (; n > 0; n -= piece, offset += piece, at += piece) {
        piece = DISK_SECTOR_BYTES - offset % DISK_SECTOR_BYTES;
        piece = piece < n ? piece : n;
        effect = add(disk, DISK_DATA, node);
        effect->offset = offset;
        effect->n = piece;
        effect->data = disk_need(malloc(piece));
        memcpy(effect->data, at, piece);
    }
}

/* ---- applying them ---- */

static void apply_name(struct disk_names *names, const struct disk_effect *effect)
{
    if (effect->kind != DISK_RENAME) {
        disk_names_set(names, effect->name, effect->kind == DISK_LINK ? effect->target : -1);
        return;
    }
    /* Only the name of that file: another may have it by now. */
    if (disk_names_find(names, effect->name) == effect->target)
        disk_names_set(names, effect->name, -1);
    disk_names_set(names, effect->to, effect->target);
}

/* An old log: the end of a line, a whole one whose crc holds, the beginning of one. */
static const char old_log[] =
    "00,\"ok\":true}],\"crc\":\"4b825dc6\"}\n"
    "{\"type\":\"slot\",\"seq\":70000,\"index\":69990,\"crc\":\"03377955\"}\n"
    "{\"type\":\"slot\",\"seq\":70001,\"in";

/* What was in a block before it was this file's. README.md, "The disk", has what is left out. */
static void put_old(unsigned char *at, size_t from, size_t to, enum disk_fresh fresh, bool no_crc)
{
    for (size_t i = from; i < to; i++) {
        unsigned char noise = (unsigned char)(i * 2654435761u >> 13 ^ i * 97);

        if (no_crc)
            at[i] = (noise & 0x1f) == ('\n' & 0x1f) ? 0x80 : 0x80 | (noise & 0x1f);
        else if (fresh == DISK_LINES)
            at[i] = (unsigned char)old_log[i % (sizeof(old_log) - 1)];
        else
            at[i] = noise == '\n' ? 0xff : noise;
    }
    if (at[to - 1] == '\n')
        at[to - 1] = ' ';
    if (at[from] == '{')
        at[from] = ' ';
}

static void apply_length(struct disk_bytes **bytes, size_t length, bool longer,
                         enum disk_fresh fresh, bool no_crc)
{
    struct disk_bytes *own;
    size_t was = (*bytes)->n;

    if (longer && was >= length)
        return;
    own = disk_bytes_own(bytes, length > was ? length : was);
    if (fresh != DISK_ZEROS && length > was)
        put_old(own->at, was, length, fresh, no_crc);
    if (length < own->n) /* bytes that are written behind the end are seen if it is moved later */
        memset(own->at + length, 0, own->room - length);
    own->n = length;
}

static void apply_data(struct disk_bytes **bytes, const struct disk_effect *effect,
                       struct disk_kept kept)
{
    struct disk_bytes *own = disk_bytes_own(bytes, effect->offset + effect->n);

    memcpy(own->at + effect->offset + kept.from, effect->data + kept.from,
           (size_t)(kept.to - kept.from));
}

static void apply_hollow(struct disk_bytes **bytes, size_t length, bool longer)
{
    struct disk_bytes *own;

    if (longer && (*bytes)->n >= length)
        return;
    own = disk_need(calloc(1, sizeof(*own)));
    own->refs = 1;
    own->n = length;
    disk_bytes_release(*bytes);
    *bytes = own;
}

static void apply(struct disk_node *node, const struct disk_effect *effect, struct disk_kept kept,
                  enum disk_fresh fresh)
{
    if (kept.to <= kept.from)
        return;
    if (effect->kind <= DISK_RENAME)
        apply_name(&node->names[1], effect);
    else if (effect->kind == DISK_DATA && !effect->lost)
        apply_data(&node->bytes[1], effect, kept);
    else if (effect->kind != DISK_DATA && node->hollow)
        apply_hollow(&node->bytes[1], effect->offset, effect->kind == DISK_LONGER);
    else if (effect->kind != DISK_DATA)
        apply_length(&node->bytes[1], effect->offset, effect->kind == DISK_LONGER,
                     effect->hole ? DISK_ZEROS : fresh, node->no_crc);
}

static struct disk_kept all_of(const struct disk_effect *effect)
{
    return (struct disk_kept){0, effect->kind == DISK_DATA ? (uint16_t)effect->n : 1};
}

void disk_make_durable(struct disk *disk, int i, bool data_only)
{
    struct disk_node *node = disk->nodes[i];
    unsigned k, n = 0;

    for (k = 0; k < disk->n_effects; k++) {
        struct disk_effect *effect = &disk->effects[k];

        if (effect->node != i) {
            if (n != k)
                disk->effects[n] = *effect;
            n++;
            continue;
        }
        if (effect->kind != DISK_SHORTER || !data_only)
            apply(node, effect, all_of(effect), disk->fresh);
        free(effect->data);
    }
    disk->n_effects = n;
    if (!node->is_dir && node->bytes[0]->n < node->bytes[1]->n)
        disk_effect_length(disk, i, node->bytes[0]->n, false);
}

void disk_lose_dirty(struct disk *disk, const char *path)
{
    int node = disk_find(disk, path);
    unsigned k;

    for (k = 0; k < disk->n_effects; k++)
        if (disk->effects[k].node == node && disk->effects[k].kind == DISK_DATA)
            disk->effects[k].lost = true;
}

unsigned disk_effects(const struct disk *disk)
{
    return disk->n_effects;
}

size_t disk_effect_bytes(const struct disk *disk, unsigned i)
{
    return disk->effects[i].n;
}

/* Any name that the node has or had; for messages. */
static const char *name_of(const struct disk *disk, int node)
{
    unsigned state, k;
    int i;

    for (i = 0; i < disk->n_nodes; i++)
        for (state = 0; state < 2; state++)
            for (k = 0; k < disk->nodes[i]->names[state].n; k++)
                if (disk->nodes[i]->names[state].items[k].node == node)
                    return disk->nodes[i]->names[state].items[k].name;
    return node == 0 ? "/" : "(a file without a name)";
}

void disk_effect_text(const struct disk *disk, unsigned i, char *ret, size_t n)
{
    const struct disk_effect *e = &disk->effects[i];
    const char *name = name_of(disk, e->node);

    switch (e->kind) {
    case DISK_LINK:
        snprintf(ret, n, "new %s in %s", e->name, name);
        break;
    case DISK_UNLINK:
        snprintf(ret, n, "unlink %s in %s", e->name, name);
        break;
    case DISK_RENAME:
        snprintf(ret, n, "rename %s to %s in %s", e->name, e->to, name);
        break;
    case DISK_LONGER:
    case DISK_SHORTER:
        snprintf(ret, n, "length %zu of %s", e->offset, name);
        break;
    case DISK_DATA:
        snprintf(ret, n, "bytes %zu..%zu of %s%s", e->offset, e->offset + e->n, name,
                 e->lost ? " (dropped by a failed sync)" : "");
        break;
    }
}

/* ---- a power cut ---- */

/* Copies what can be reached from a node of `from`, in its state [1] with the effects kept. */
static int copy_reached(struct disk *to, const struct disk *from, struct disk_node *const *after,
                        int *map, int i)
{
    const struct disk_node *node = after[i];
    struct disk_node *copy;
    unsigned k;
    int made;

    if (map[i] >= 0)
        return map[i];
    map[i] = made = disk_node_add(to, node->is_dir, node->hollow);
    copy = to->nodes[made];
    copy->no_crc = node->no_crc;
    if (!node->is_dir) {
        disk_bytes_release(copy->bytes[0]);
        disk_bytes_release(copy->bytes[1]);
        copy->bytes[0] = disk_bytes_share(node->bytes[1]);
        copy->bytes[1] = disk_bytes_share(node->bytes[1]);
        return made;
    }
    disk_names_copy(&copy->names[1], &node->names[1]);
    for (k = 0; k < copy->names[1].n; k++)
        copy->names[1].items[k].node =
            copy_reached(to, from, after, map, copy->names[1].items[k].node);
    disk_names_copy(&copy->names[0], &copy->names[1]);
    return made;
}

struct disk *disk_cut(const struct disk *disk, const struct disk_kept *kept)
{
    struct disk *to = disk_alloc(disk->hollow);
    struct disk_node after[DISK_NODES_MAX], *nodes[DISK_NODES_MAX] = {0};
    int map[DISK_NODES_MAX] = {0}, i;
    unsigned k;

    for (i = 0; i < disk->n_nodes; i++) {
        map[i] = -1;
        nodes[i] = disk->nodes[i];
    }
    for (k = 0; k < disk->n_effects; k++) {
        i = disk->effects[k].node;
        if (kept[k].to <= kept[k].from)
            continue;
        if (nodes[i] != &after[i]) { /* the first that changes it */
            after[i] = *disk->nodes[i];
            nodes[i] = &after[i];
            if (after[i].is_dir)
                disk_names_copy(&after[i].names[1], &disk->nodes[i]->names[1]);
            else
                disk_bytes_share(after[i].bytes[1]);
        }
        apply(nodes[i], &disk->effects[k], kept[k], disk->fresh);
    }
    to->fresh = disk->fresh;
    copy_reached(to, disk, nodes, map, 0);
    for (i = 0; i < disk->n_nodes; i++)
        if (nodes[i] == &after[i]) {
            disk_bytes_release(after[i].is_dir ? NULL : after[i].bytes[1]);
            free(after[i].is_dir ? after[i].names[1].items : NULL);
        }
    return to;
}

static uint64_t mix(uint64_t hash, const void *data, size_t n)
{
    const unsigned char *at = data;

    for (; n > 0; n--)
        hash = (hash ^ *at++) * UINT64_C(0x100000001b3);
    return hash ^ hash >> 29;
}

static uint64_t hash_node(const struct disk *disk, int i)
{
    const struct disk_node *node = disk->nodes[i];
    struct disk_bytes *bytes = node->bytes[1];
    uint64_t hash = 0, one;
    unsigned k;

    if (!node->is_dir) {
        if (bytes->hash == 0)
            bytes->hash = mix(UINT64_C(0xcbf29ce484222325) + bytes->n, bytes->at,
                              bytes->room ? bytes->n : 0) |
                          1;
        return bytes->hash;
    }
    for (k = 0; k < node->names[1].n; k++) { /* in no order */
        one = hash_node(disk, node->names[1].items[k].node);
        one = mix(one, node->names[1].items[k].name, strlen(node->names[1].items[k].name));
        hash += one * UINT64_C(0x9e3779b97f4a7c15);
    }
    return hash + 7;
}

uint64_t disk_hash(const struct disk *disk)
{
    return hash_node(disk, 0);
}
