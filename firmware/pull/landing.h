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

/* Of one thread. */
struct landing {
    struct ttf_io *io;
    struct wire *wire;
    const char *name;   /* the dataset's */
    const char *folder; /* where it is laid, DEST/NAME */
    bool doubtful; /* what is here may be seen and not be on the disk, whatever is synced: anew.h */
    char made[4600];      /* the folder that was made last */
    unsigned char *small; /* LANDING_SMALL bytes, for a file at a time; NULL: there are none yet */
};

/* What came of a file. */
struct landed {
    bool came;      /* over the wire */
    bool unsettled; /* it may not be on the disk yet: settle.h */
    bool ours;      /* what failed is this machine's, and says nothing about the box */
};

/* What it holds; not the struct. */
void landing_free(struct landing *landing);

/* May a record or a seal name it? A file of the format's folders, none of whose names is hidden or temporary. */
bool landing_is_image(const char *path);

/* The same of what a seal lists, which may lie beside those folders. */
bool landing_is_listed(const char *path);

#define LANDING_SMALL \
    ((int64_t)256 << 10) /* files up to this size can be hashed before they are written */

/* How a file that is there already is looked at. */
enum landing_trust {
    LANDING_SIZE, /* its size will do: it was durable before a line named it */
    LANDING_HASH, /* it may be what a crash left */
    LANDING_NEW   /* there is none: this pull has made the dataset's folder */
};

/*
 * Sees to it that folder/path is there, so long (-1: not known) and with this SHA-256 (hex). *ret: also on failure. -TTF_EDAMAGED: what the box
 * gives is not that, twice; nothing is left under the file's name. Errors of the wire; of this machine's disk, with ret->ours.
 */
TTF_MUST_USE int landing_ensure(struct landing *landing, const char *path, int64_t bytes,
                                const char *sha256, enum landing_trust trust, struct landed *ret,
                                struct ttf_err *err);

/* Is it there, in this size? 1, 0, or an error of this machine's disk. */
TTF_MUST_USE int landing_has(const struct landing *landing, const char *path, int64_t bytes,
                             struct ttf_err *err);

/* A file in memory put in place, replacing what was there. */
TTF_MUST_USE int landing_put(struct landing *landing, const char *path, const void *data, size_t n,
                             struct ttf_err *err);

#endif
