/* SPDX-License-Identifier: Apache-2.0 */
/*
 * tar_layout.h: a dataset as an uncompressed tar, byte by byte, before any of it is read: ustar (POSIX.1-1988), files
 * in the order of their paths, below a folder of the dataset's name.
 */
#ifndef HTTP_TAR_LAYOUT_H
#define HTTP_TAR_LAYOUT_H

#include <stdint.h>

#include "folder.h"

#define TAR_BLOCK 512

struct tar_file {
    char *path;    /* in the dataset */
    int64_t bytes; /* taken; of a growing file up to its last line end */
    int64_t mtime_s;
    uint64_t stamp[2]; /* inode and nanoseconds of the time: what else changes if the file does */
    int64_t offset;    /* of its header in the archive */
};

struct tar_layout {
    char dataset[65];
    struct tar_file *files;
    size_t n, room;
    int64_t bytes; /* of the whole archive */
    bool sealed;   /* made of a sealed dataset: the same layout next time */
    char etag[65]; /* hex, of all headers and, of a sealed dataset, its list of hashes */
};

/*
 * Lists and measures all files of a dataset but preview/, *.tmp and names that belong to no dataset. -ENOENT: no such
 * dataset; -ENAMETOOLONG: a path that no ustar can have. Free it with tar_layout_free.
 */
TTF_MUST_USE int tar_layout_make(const struct folder *folder, const char *dataset,
                                 struct tar_layout *ret);
void tar_layout_free(struct tar_layout *layout);

/* The header of a file: 512 bytes. false: no ustar has so long a path (-ENAMETOOLONG of tar_layout_make). */
bool tar_header(const struct tar_layout *layout, const struct tar_file *file,
                unsigned char ret[TAR_BLOCK]);

#endif
