/* SPDX-License-Identifier: Apache-2.0 */
/*
 * growth.h: what came to a file of lines (records.jsonl, events.jsonl) since one looked last: no line is read twice,
 * however long the file is. It repairs nothing and is no judge: a damaged line is counted and passed over.
 *
 * Threads: one at a time per struct ttf_growth.
 */
#ifndef TTF_DATASET_GROWTH_H
#define TTF_DATASET_GROWTH_H

#include <jansson.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/record.h"

#define TTF_GROWTH_MARK 64

/* How far one has read. Zeroed: not at all. */
struct ttf_growth {
    int64_t bytes;              /* of whole lines that were given */
    int64_t lines, damaged;     /* given; passed over */
    uint64_t inode;             /* of the file that was read; 0: none yet, or not known */
    char mark[TTF_GROWTH_MARK]; /* the last bytes that were read, to know the file again */
    unsigned n_mark;
};

/* A line whose crc holds. All of it is valid during the call only. */
struct ttf_growth_line {
    const char *where; /* path: byte at which it begins */
    const char *type;  /* "slot", "segment", "end", "event", ... */
    json_t *json;      /* borrowed */
};

/* Non-zero stops and is returned; the line counts as not given. */
typedef int ttf_growth_fn(void *ctx, const struct ttf_growth_line *line, struct ttf_err *err);

/* The dataset of a folder whose records came last: the one under way, or the last. -ENOENT: there is none; errors of listing. */
TTF_MUST_USE int ttf_growth_newest(struct ttf_io *io, const char *folder, char ret_name[65]);

/* The n-th of them from the newest on, 0 being that. -ENOENT: there are not so many. */
TTF_MUST_USE int ttf_growth_nth_newest(struct ttf_io *io, const char *folder, unsigned n,
                                       char ret_name[65]);

/*
 * Gives the lines that are new, up to the last line end, at most about max_bytes of them (0: all). 0: there is no more;
 * 1: there is. -ESTALE: the file is another than the one read so far, or lost lines (a power cut): zero *growth, forget
 * what came of it, and begin anew. -ENOENT: there is no such file.
 */
TTF_MUST_USE int ttf_growth_read(struct ttf_io *io, const char *path, struct ttf_growth *growth,
                                 int64_t max_bytes, ttf_growth_fn *fn, void *ctx,
                                 struct ttf_err *err);

/* A line of that type as a struct; -TTF_EDAMAGED. Free the record with ttf_slot_record_free. */
TTF_MUST_USE int ttf_growth_slot(const struct ttf_growth_line *line, struct ttf_slot_record *ret,
                                 struct ttf_err *err);
TTF_MUST_USE int ttf_growth_segment(const struct ttf_growth_line *line, struct ttf_segment *ret,
                                    struct ttf_err *err);

#endif
