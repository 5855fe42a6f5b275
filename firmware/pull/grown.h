/* SPDX-License-Identifier: Apache-2.0 */
/* grown.h: a file of lines that grows on the box (records.jsonl, events.jsonl), and what of it is here. One thread. */
#ifndef PULL_GROWN_H
#define PULL_GROWN_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "wire.h"

#define GROWN_BACK \
    16 /* lines that a power cut may have taken from the box after they were served */

struct grown {
    struct ttf_io *io;
    struct wire *wire;
    char url[200];   /* below /api/v1 */
    char path[4600]; /* here */
    int file;        /* -1: not open */
    int64_t bytes;   /* of good lines here */
    int64_t ends
        [GROWN_BACK +
         1]; /* where the last lines ended when it was opened, the last one first; 0: there is none */
    char *piece; /* of the box's, what is being gone through */
    size_t piece_bytes, piece_at;
};

/* A line without its end. Non-zero stops and is returned. */
typedef int grown_line_fn(void *ctx, const char *line, size_t n, struct ttf_err *err);

/*
 * Opens the file here, made if it is missing, and cuts off half a line at its end. -TTF_EDAMAGED: a whole line here is wrong;
 * nothing is changed.
 */
TTF_MUST_USE int grown_open(struct grown *grown, struct ttf_err *err);
void grown_close(struct grown *grown);

/*
 * Finds the last line here that the box has too: bytes counts up to its end, and nothing is changed yet. -EEXIST: none of the last
 * GROWN_BACK is, and there are more. -TTF_EDAMAGED: the box's line is wrong there; ours stays. Errors of the wire.
 */
TTF_MUST_USE int grown_agree(struct grown *grown, struct ttf_err *err);

/* Are there lines here behind those that the box has too? */
bool grown_is_ahead(const struct grown *grown);

/* Every line that is here from this byte on. */
TTF_MUST_USE int grown_each(struct grown *grown, int64_t from, grown_line_fn *fn, void *ctx,
                            struct ttf_err *err);

/* Cuts the file at bytes, and syncs. */
TTF_MUST_USE int grown_cut(struct grown *grown, struct ttf_err *err);

/*
 * The next line that the box has and that was not given yet, in *ret of *ret_n bytes, valid until the next call. 1; 0: there is
 * none now. It is not appended: that is the caller's, when it is time. -TTF_EDAMAGED: it is no whole line.
 */
TTF_MUST_USE int grown_next(struct grown *grown, int64_t at, const char **ret, size_t *ret_n,
                            struct ttf_err *err);

/* Appends whole lines, their ends included, and syncs. */
TTF_MUST_USE int grown_append(struct grown *grown, const char *lines, size_t n,
                              struct ttf_err *err);

#endif
