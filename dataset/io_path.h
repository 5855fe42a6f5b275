/* SPDX-License-Identifier: Apache-2.0 */
/* io_path.h: paths and small durable steps, for files of this room only. */
#ifndef TTF_DATASET_IO_PATH_H
#define TTF_DATASET_IO_PATH_H

#include <stdarg.h>

#include "ttf/base/attr.h"
#include "ttf/dataset/io.h"

#define TTF_PATH_MAX 4096 /* the kernel's own bound, terminator included */

/* A path into memory of the caller's; -ENAMETOOLONG. */
TTF_MUST_USE int ttf_path_put(char ret[TTF_PATH_MAX], const char *fmt, ...) TTF_PRINTF(2, 3);

/* A fresh string, to be freed; NULL: no memory. */
char *ttf_path_format(const char *fmt, ...) TTF_PRINTF(1, 2);

/* The folder a path lies in ("." if it has none), to be freed; NULL: no memory. */
char *ttf_path_parent(const char *path);

/* Syncs the folder that `path` lies in. Allocates nothing. */
TTF_MUST_USE int ttf_io_sync_parent(struct ttf_io *io, const char *path);

/* The first so many bytes of one file behind what is in the other. -EIO: the first has not so many. */
TTF_MUST_USE int ttf_io_copy_bytes(struct ttf_io *io, int from, int to, int64_t bytes);

/* Locks what the handle is of, for this handle alone; not waiting: -EAGAIN. 0 also where the file system knows no locks. */
TTF_MUST_USE int ttf_io_lock(struct ttf_io *io, int file);

#endif
