/* SPDX-License-Identifier: Apache-2.0 */
/* settle.h: files that came, made durable together. One thread. */
#ifndef PULL_SETTLE_H
#define PULL_SETTLE_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

#define SETTLE_MOST 256 /* files that came and are not yet on the disk, at most */

struct settling {
    struct ttf_io *io;
    const char *folder; /* DEST/NAME */
    int failed;         /* once and for all: a second sync may well say that all is well */
    unsigned n;
    char paths[SETTLE_MOST][192]; /* those that came since the last time */
};

/* One more; the last one that there is room for settles all. */
TTF_MUST_USE int settle_add(struct settling *settling, const char *path, struct ttf_err *err);

/*
 * All that came so far is on the disk, under its names. Together, because the first sync of many writes what the others
 * need too; not by syncing the whole file system, on which somebody else may be writing gigabytes.
 */
TTF_MUST_USE int settle_all(struct settling *settling, struct ttf_err *err);

#endif
