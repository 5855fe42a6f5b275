/* SPDX-License-Identifier: Apache-2.0 */
/* store_ios.h: I/O tables for tests: one that does not wait for the disk, one that fails on cue. */
#ifndef STORE_IOS_H
#define STORE_IOS_H

#include "ttf/dataset/io.h"

/* The machine's, but syncing costs nothing: for tests that cannot lose power. */
struct ttf_io *quick_io(void);

/* Counts operations that change something, and fails as told. Zero it first. */
struct cue {
    long n;         /* so far */
    long at;        /* fail the at-th (from 1); 0: none */
    int error;      /* with this */
    bool for_ever;  /* and all after it: a power cut */
    const char *op; /* only count this op; NULL: all */
    const char *in; /* only paths that contain this; NULL: all */
    char *log;      /* "op path\n" of each, where not NULL */
    size_t log_used, log_room;
};

int cue_fault(void *ctx, const char *op, const char *path);

#endif
