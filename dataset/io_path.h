/* SPDX-License-Identifier: Apache-2.0 */
/* io_path.h: paths and small durable steps, for files of this room only. */
#ifndef TTF_DATASET_IO_PATH_H
#define TTF_DATASET_IO_PATH_H

#include <stdarg.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/io.h"

/* A fresh string, to be freed; NULL: no memory. */
char *ttf_path_format(const char *fmt, ...) TTF_PRINTF(1, 2);

/* The folder a path lies in ("." if it has none), to be freed; NULL: no memory. */
char *ttf_path_parent(const char *path);

/* Syncs the folder that `path` lies in. */
TTF_MUST_USE int ttf_io_sync_parent(struct ttf_io *io, const char *path);

#endif
