/* SPDX-License-Identifier: Apache-2.0 */
/* walk.h: the files of a dataset's folder. For the store's files only. */
#ifndef TTF_DATASET_WALK_H
#define TTF_DATASET_WALK_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/io.h"

struct ttf_paths {
    char **items;
    size_t n, room;
};

TTF_MUST_USE int ttf_paths_add(struct ttf_paths *paths, const char *path);
void ttf_paths_sort(struct ttf_paths *paths); /* by bytes */
void ttf_paths_free(struct ttf_paths *paths);

/*
 * All files below `dataset`, relative to it, sorted by bytes. Left out: preview/,
 * and whatever name begins with a dot (not part of any dataset).
 */
TTF_MUST_USE int ttf_walk(struct ttf_io *io, const char *dataset, struct ttf_paths *ret,
                          struct ttf_err *err);

/* "x.tmp": written by us, not finished. */
bool ttf_is_temporary(const char *path);

/* The slot's index in frames/S/000012.tif or raw/S/000012.b1.dng; -1: not such a name. */
int64_t ttf_path_index(const char *path);

#endif
