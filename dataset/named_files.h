/* SPDX-License-Identifier: Apache-2.0 */
/* named_files.h: all files that the records name, to look up by path. For the store's files only. */
#ifndef TTF_DATASET_NAMED_FILES_H
#define TTF_DATASET_NAMED_FILES_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

struct ttf_named {
    char *path;
    char sha256[65];
};

struct ttf_named_files {
    struct ttf_named *items; /* sorted by the bytes of path, each path once */
    size_t n, room;
};

TTF_MUST_USE int ttf_named_files_add(struct ttf_named_files *files, const char *path,
                                     const char *sha256);
void ttf_named_files_sort(struct ttf_named_files *files);

/* From a records.jsonl. */
TTF_MUST_USE int ttf_named_files_load(struct ttf_io *io, const char *records,
                                      struct ttf_named_files *ret, struct ttf_err *err);

/* NULL: no such path. */
const struct ttf_named *ttf_named_files_find(const struct ttf_named_files *files, const char *path);
void ttf_named_files_free(struct ttf_named_files *files);

#endif
