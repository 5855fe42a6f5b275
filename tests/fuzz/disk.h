/* SPDX-License-Identifier: Apache-2.0 */
/*
 * disk.h: a small file system in memory behind the I/O table, so that whole datasets can be opened
 * thousands of times a second. Nothing on it ever fails but what no such disk has room for.
 */
#ifndef FUZZ_DISK_H
#define FUZZ_DISK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/dataset/io.h"

#define FUZZ_DISK_FILES 64

struct fuzz_node; /* a file's bytes; stays while a handle has it open */

/* Embedded first. A folder is there while a file lies below it. Paths are relative, without "..". */
struct fuzz_disk {
    struct ttf_io base;
    unsigned n;
    struct fuzz_entry {
        char path[256];
        struct fuzz_node *node;
    } files[FUZZ_DISK_FILES];
    struct fuzz_node *handles[FUZZ_DISK_FILES];
};

void fuzz_disk_init(struct fuzz_disk *disk);
void fuzz_disk_free(struct fuzz_disk *disk);

/* Puts a file there as a whole, in place of what was there. */
void fuzz_disk_put(struct fuzz_disk *disk, const char *path, const void *data, size_t size);

/* A file's bytes, valid until it changes; NULL where there is none. */
const uint8_t *fuzz_disk_get(const struct fuzz_disk *disk, const char *path, size_t *ret_size);

/* Of all names and bytes, in whatever order: equal if nothing changed. */
uint64_t fuzz_disk_digest(const struct fuzz_disk *disk);

/* Handles that nobody closed. */
unsigned fuzz_disk_open_handles(const struct fuzz_disk *disk);

#endif
