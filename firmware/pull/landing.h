/* SPDX-License-Identifier: Apache-2.0 */
/* landing.h: one file of a dataset, brought here. One thread. */
#ifndef PULL_LANDING_H
#define PULL_LANDING_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "wire.h"

#define LANDING_BATCH 256 /* files that came and are not yet on the disk, at most */

struct landing {
    struct ttf_io *io;
    struct wire *wire;
    const char *name;   /* the dataset's */
    const char *folder; /* where it is laid, DEST/NAME */
    char made[256];     /* the folder inside it that was made last */
    bool ours; /* of the last file: what failed is this machine's, and says nothing about the box */
    int failed; /* of settling, once and for all: a second sync may well say that all is well */
    unsigned n_batch;
    char batch[LANDING_BATCH][192]; /* paths of those that came since they were settled last */
};

/* May a record or a seal name it? A file of the format's folders, none of whose names is hidden or temporary. */
bool landing_is_image(const char *path);

/* The same of what a seal lists, which may lie beside those folders. */
bool landing_is_listed(const char *path);

/* How a file that is there already is looked at. */
enum landing_trust {
    LANDING_SIZE, /* its size will do: it was durable before a line named it */
    LANDING_HASH  /* it may be what a crash left */
};

/*
 * Sees to it that folder/path is there, so long (-1: not known) and with this SHA-256 (hex). *ret_came: whether it came over the wire. -TTF_EDAMAGED: what the box gives is not that, twice; nothing is left under the file's name. Errors of
 * the wire; of this machine's disk, with landing->ours.
 */
TTF_MUST_USE int landing_ensure(struct landing *landing, const char *path, int64_t bytes,
                                const char *sha256, enum landing_trust trust, bool *ret_came,
                                struct ttf_err *err);

/* A file in memory put in place, replacing what was there. */
TTF_MUST_USE int landing_put(struct landing *landing, const char *path, const void *data, size_t n,
                             struct ttf_err *err);

/*
 * All that came so far is on the disk, under its names. By itself after LANDING_BATCH files. Together, because the first sync of
 * many writes what the others need too; not by syncing the whole file system, on which somebody else may be writing gigabytes.
 */
TTF_MUST_USE int landing_settle(struct landing *landing, struct ttf_err *err);

#endif
