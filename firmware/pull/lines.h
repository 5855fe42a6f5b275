/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lines.h: records' lines and the files that they name. Files are brought by the crew, several at once, lines are appended in order, each
 * behind its files. Two batches are under way: while one is settled, the other comes. One thread.
 */
#ifndef PULL_LINES_H
#define PULL_LINES_H

#include <jansson.h>

#include "crew.h"
#include "grown.h"
#include "one.h"
#include "settle.h"
#include "vouched.h"

#define LINES_FILES SETTLE_MOST /* of a batch, at most */

struct lines_batch {
    unsigned n, slots_at[LINES_FILES]; /* slots before the line that errands[i] is for */
    size_t line_at[LINES_FILES];       /* where that begins in text */
    uint32_t folded[LINES_FILES];      /* of its path, whatever its case */
    int64_t bytes;
    char *
        text; /* whole lines, to be appended; those whose files are in this batch or were in one before */
    size_t text_bytes, text_room;
    struct errand errands[LINES_FILES];
};

struct lines {
    const char *name, *folder;
    struct crew *crew;
    struct landing *landing; /* looks at what is there; brings nothing */
    struct grown *records;
    struct settling *settling;
    const struct one_skips *skips;
    const volatile int *stop;
    struct one_result *result;
    void (*tell)(void *ctx, int64_t slots,
                 const char *text); /* how it stands; text: NULL allowed */
    void *tell_ctx;
    bool is_new;  /* the dataset's folder was made by this pull: none of its files is here */
    bool changed; /* lines were appended */
    /* its own */
    int failed; /* the first error behind which nothing is appended */
    struct ttf_err why;
    struct vouched
        vouched;  /* what the lines taken name: of all that are here, when all went well */
    unsigned now; /* the batch that is filled */
    struct lines_batch batch[2];
};

/*
 * One more line, of those that the box has (keep: to be appended) or that are here already, and whose files need only be there. What it names
 * is asked for. -TTF_EDAMAGED: it names files as no dataset does; -ECANCELED; what has gone wrong with an earlier one.
 */
TTF_MUST_USE int lines_take(struct lines *lines, const char *line, size_t n, bool keep,
                            struct ttf_err *err);

/* Bytes of lines that were taken and are not appended yet. */
size_t lines_pending(const struct lines *lines);

/* All that was taken is here, its lines appended, up to the first that failed. Its error. */
TTF_MUST_USE int lines_finish(struct lines *lines, struct ttf_err *err);

void lines_free(struct lines *lines);

#endif
