/* SPDX-License-Identifier: Apache-2.0 */
/* disk_private.h: what the files of the disk share. */
#ifndef TTF_TESTS_CRASH_DISK_PRIVATE_H
#define TTF_TESTS_CRASH_DISK_PRIVATE_H

#include "disk.h"

#define DISK_NAME_BYTES  64
#define DISK_NODES_MAX   768
#define DISK_HANDLES_MAX 16

/* A file's bytes: shared by the two states and by disks, copied before a change. */
struct disk_bytes {
    unsigned refs;
    size_t n, room; /* room 0 with n > 0: hollow */
    uint64_t hash;  /* 0: not taken yet */
    unsigned char at[];
};

struct disk_entry {
    char name[DISK_NAME_BYTES];
    int node;
};

struct disk_names {
    unsigned n, room;
    struct disk_entry *items;
};

/* [0] as seen, [1] as it would be found after a cut. */
struct disk_node {
    bool is_dir, hollow;
    bool no_crc; /* its old blocks hold nothing that its lines hold */
    struct disk_bytes *bytes[2];
    struct disk_names names[2];
};

enum disk_effect_kind {
    DISK_LINK,
    DISK_UNLINK,
    DISK_RENAME,
    DISK_LONGER,
    DISK_SHORTER,
    DISK_DATA
};

struct disk_effect {
    enum disk_effect_kind kind;
    int node;   /* the folder or file it is done to */
    int target; /* of names: the node that gets the name */
    bool lost;  /* data: a sync failed, they will not be written */
    bool hole;  /* a length: nobody writes there, so it reads as zeros whatever was there */
    char name[DISK_NAME_BYTES], to[DISK_NAME_BYTES];
    size_t offset, n; /* of data; offset: the new length */
    unsigned char *data;
};

struct disk {
    struct ttf_io io; /* first */
    struct disk_node *nodes[DISK_NODES_MAX];
    int n_nodes;                   /* 0 is the root */
    int handles[DISK_HANDLES_MAX]; /* node + 1; 0: free */
    struct disk_effect *effects;
    unsigned n_effects, effects_room;
    char hollow[DISK_NAME_BYTES];
    bool dead;
    enum disk_fresh fresh;
    disk_step_fn *step;
    void *step_ctx;
};

extern const struct ttf_io_ops disk_ops;

/* ---- nodes: disk_nodes.c ---- */

/* NULL ends the program. */
void *disk_need(void *memory);

struct disk *disk_alloc(const char *hollow);
int disk_node_add(struct disk *disk, bool is_dir, bool hollow);
void disk_node_drop(struct disk *disk, int i);

int disk_names_find(const struct disk_names *names, const char *name);     /* node or -ENOENT */
void disk_names_set(struct disk_names *names, const char *name, int node); /* node -1: removes it */
void disk_names_copy(struct disk_names *to, const struct disk_names *from);

struct disk_bytes *disk_bytes_share(struct disk_bytes *bytes);
void disk_bytes_release(struct disk_bytes *bytes);
/* One that nobody else has, with room for n; *bytes is replaced. */
struct disk_bytes *disk_bytes_own(struct disk_bytes **bytes, size_t n);

/* The node of a path as seen; *ret_name (may be NULL) is then its last component, in its folder's node. */
int disk_find(const struct disk *disk, const char *path);
int disk_find_folder(const struct disk *disk, const char *path, const char **ret_name);

/* ---- effects: disk_effects.c ---- */

void disk_effect_name(struct disk *disk, enum disk_effect_kind kind, int folder, const char *name,
                      const char *to, int target);
void disk_effect_length(struct disk *disk, int node, size_t bytes, bool longer);
void disk_effect_hole(struct disk *disk, int node, size_t bytes);
void disk_effect_data(struct disk *disk, int node, size_t offset, const void *data, size_t n);

/* Does to state [1] what effects of node i say; data_only leaves a shorter length out. */
void disk_make_durable(struct disk *disk, int i, bool data_only);

#endif
