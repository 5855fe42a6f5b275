/* SPDX-License-Identifier: Apache-2.0 */
/* settle.h: files that came, made durable together. One thread. */
#ifndef PULL_SETTLE_H
#define PULL_SETTLE_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/clock.h"

#define SETTLE_MOST 1024 /* files that came and are not yet on the disk, at most */

struct settling {
    struct ttf_io *io;
    struct ttf_clock *clock;
    const char *folder; /* DEST/NAME */
    int handle;     /* of it, open since before the first of the files came; -1: there is none */
    int failed;     /* once and for all: a second sync may well say that all is well */
    unsigned apart; /* so many batches yet are synced file by file */
    unsigned n;
    char paths[SETTLE_MOST][192]; /* those that came since the last time */
};

/* One more; the last one that there is room for settles all. */
TTF_MUST_USE int settle_add(struct settling *settling, const char *path, struct ttf_err *err);

/*
 * All that came so far is on the disk, under its names: many by one sync of the whole file system, few, and where there is no such sync or
 * somebody else keeps that disk busy, each by its own.
 */
TTF_MUST_USE int settle_all(struct settling *settling, struct ttf_err *err);

/* A sync has failed: a file of this pull that came, or began to, is to come anew. Nothing after settle_all without an error. */
void settle_forget(const struct settling *settling, const char *path);

#endif
