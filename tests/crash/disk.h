/* SPDX-License-Identifier: Apache-2.0 */
/*
 * disk.h: a file system in memory that forgets what was not synced.
 *
 * An I/O table (ttf/dataset/io.h) over a tree of which two states are kept: what
 * programs see, and what would be found after a power cut if the disk had written
 * nothing that it was not made to. Between the two lie effects, in the order they
 * came: names, lengths, bytes by sectors. disk_cut makes the disk that is found
 * after a power cut, with any choice of them. README.md has the rules.
 *
 * One thread per disk. What runs out of memory ends the program.
 */
#ifndef TTF_TESTS_CRASH_DISK_H
#define TTF_TESTS_CRASH_DISK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/dataset/io.h"

#define DISK_SECTOR_BYTES 512u
#define DISK_EFFECTS_MAX  768u

struct disk;

/* Before each operation that may change something. Non-zero: it fails with this errno (negative). */
typedef int disk_step_fn(void *ctx, struct disk *disk, const char *op, const char *path);

/* With the folders of `path`, on the disk. */
struct disk *disk_create(const char *path);
void disk_destroy(struct disk *disk); /* NULL allowed */
struct ttf_io *disk_io(struct disk *disk);
void disk_on_step(struct disk *disk, disk_step_fn *fn, void *ctx); /* fn NULL: none */

/* The program is killed: every operation fails from now on; the kernel and what it holds stay. */
void disk_kill(struct disk *disk);
/* The next program: handles of the last one are gone. */
void disk_revive(struct disk *disk);

/* A file that is on the disk already; its folder must be there. */
void disk_put(struct disk *disk, const char *path, const void *bytes, size_t n);

/* Files whose last name component is this hold no bytes, only a length: they read as zeros. */
void disk_hollow(struct disk *disk, const char *name);

/* What bytes read as whose length reached the disk, and they did not: the block was another file's before. */
enum disk_fresh {
    DISK_ZEROS,
    DISK_NOISE, /* any bytes but the end of a line */
    DISK_LINES, /* ends of lines, too: an old log */
    DISK_FRESH_COUNT
};
void disk_fresh_blocks(struct disk *disk, enum disk_fresh fresh); /* and of those that cuts leave */

/* What a power cut may take or leave. Numbered from 0, in the order it was done. */
unsigned disk_effects(const struct disk *disk);
/* Bytes that effect i consists of: 0 of names and lengths, which cannot be torn. */
size_t disk_effect_bytes(const struct disk *disk, unsigned i);
/* In words, at most n bytes with the zero. */
void disk_effect_text(const struct disk *disk, unsigned i, char *ret, size_t n);

/* Of one effect: its bytes from `from` up to `to` reached the disk; of names and lengths: to > 0. */
struct disk_kept {
    uint16_t from, to;
};

/* The disk after a power cut: kept[i] for each effect. To be destroyed. */
struct disk *disk_cut(const struct disk *disk, const struct disk_kept *kept);

/* Equal trees have equal hashes; of a disk without effects. */
uint64_t disk_hash(const struct disk *disk);

/* When a step function lets "sync" of this path fail: what was dirty counts as written and never will be. */
void disk_lose_dirty(struct disk *disk, const char *path);

#endif
