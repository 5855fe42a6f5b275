/* SPDX-License-Identifier: Apache-2.0 */
/*
 * jsonl.h: a file of lines that only grows, each line durable when append returns.
 * DESIGN.md, "A line". For the store's files only.
 *
 * Lines are put into words in memory that is kept from line to line: appending
 * allocates only for a line longer than any before and than what was reserved.
 */
#ifndef TTF_DATASET_JSONL_H
#define TTF_DATASET_JSONL_H

#include <stdbool.h>
#include <stdint.h>

#include "lines.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

struct ttf_jsonl {
    struct ttf_io *io;
    char *path;
    struct ttf_json json; /* the line being made; its memory is kept */
    int file;             /* -1: not open */
    int64_t bytes;        /* of good lines */
    int64_t next_seq;
    bool no_newline; /* the last line's newline is still to be written */
    bool doubt;      /* a sync failed: what is seen of the file may not be on the disk */
    int broken;      /* 0, or what every later append returns: what is on the disk is not known */
};

/* Opens for going on where a scan ended; the tail's fragment must be gone. */
TTF_MUST_USE int ttf_jsonl_open(struct ttf_jsonl *f, struct ttf_io *io, const char *path,
                                const struct ttf_lines_tail *tail, struct ttf_err *err);

/* Memory for lines of so many bytes. -ENOMEM. */
TTF_MUST_USE int ttf_jsonl_reserve(struct ttf_jsonl *f, size_t bytes);

/* Begins a line; what is returned belongs to f. A line begun before and not appended is dropped. */
struct ttf_json *ttf_jsonl_begin(struct ttf_jsonl *f, const char *type);

/* Finishes the line that was begun, appends and syncs it. */
TTF_MUST_USE int ttf_jsonl_append(struct ttf_jsonl *f, struct ttf_err *err);

/*
 * Before anything is put behind a last line that is owed its newline: whoever wrote it may
 * have died before syncing it, and what is seen of it is not yet on the disk.
 */
TTF_MUST_USE int ttf_jsonl_sync_last(struct ttf_jsonl *f, struct ttf_err *err);

/* Writes a newline that is still owed, and syncs. */
TTF_MUST_USE int ttf_jsonl_settle(struct ttf_jsonl *f, struct ttf_err *err);

/* Writes all good lines as a new file, durable whatever became of the old one's. */
TTF_MUST_USE int ttf_jsonl_renew(struct ttf_jsonl *f, struct ttf_err *err);

void ttf_jsonl_close(struct ttf_jsonl *f);

#endif
