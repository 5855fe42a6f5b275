/* SPDX-License-Identifier: Apache-2.0 */
/* listing.h: what lies in folders of plans and of boards. Any thread. */
#ifndef DAEMON_LISTING_H
#define DAEMON_LISTING_H

#include <stdbool.h>

#include "ttf/dataset/io.h"
#include "ttf/dataset/json_writer.h"

#define LISTING_SUFFIX    ".yaml"
#define LISTING_PLANS_MAX 256

/* Names in order. */
struct listing {
    char (*name)[65];
    unsigned n, max;
    bool folders; /* else files that end in LISTING_SUFFIX, without it */
};

/* Of a folder that is not there: none. ret->name is the caller's to free, also on failure. Beyond `max` nothing is listed. */
TTF_MUST_USE int listing_read(struct ttf_io *io, const char *folder, unsigned max, bool folders,
                              struct listing *ret);

/* A file's text, by malloc. -ENOENT: there is no `what` of this name; -EIO: it is longer than one that can be sent. */
TTF_MUST_USE int listing_text(struct ttf_io *io, const char *path, const char *what, char **ret,
                              struct ttf_err *err);

/* Takes a file away, for good: its folder is synced. -ENOENT: there is no `what` of this name. */
TTF_MUST_USE int listing_remove(struct ttf_io *io, const char *folder, const char *path,
                                const char *what, struct ttf_err *err);

/* What was written, if all went well (r); the writer is freed. */
TTF_MUST_USE int listing_give(struct ttf_json *json, int r, char **ret, struct ttf_err *err);

#endif
