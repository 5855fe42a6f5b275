/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sums.h: SHA256SUMS, as `sha256sum --strict -c` reads it. FORMAT.md, "SHA256SUMS".
 * For the store's files only.
 */
#ifndef TTF_DATASET_SUMS_H
#define TTF_DATASET_SUMS_H

#include <stdbool.h>
#include <stdint.h>

#include "lines.h"
#include "ttf/base/err.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/io.h"

#define TTF_SUMS_NAME   "SHA256SUMS"
#define TTF_SUMS_PREFIX 66u /* 64 digits and two blanks, before the path */

/* Is it "hash  path"? line without newline. *ret_path then points into it, n - 66 bytes long. */
bool ttf_sums_parse(const char *line, size_t n, const char **ret_path);

/* Does the dataset's SHA256SUMS list records.jsonl, that is: is it sealed? -errno other than -ENOENT. */
TTF_MUST_USE int ttf_sums_sealed(struct ttf_io *io, const char *dataset, bool *ret,
                                 struct ttf_err *err);

/* How the running SHA256SUMS stands to the image files that the records name. */
enum ttf_sums_state {
    TTF_SUMS_SAME = 0,
    TTF_SUMS_BEHIND, /* lines are lacking or not whole: what a crash leaves */
    TTF_SUMS_WRONG,  /* a line of it has changed, which no crash does; the records have it right */
    TTF_SUMS_AHEAD,  /* it lists an image that no record names: the records have lost lines */
    TTF_SUMS_SEAL /* it lists what only a seal does, but not records.jsonl: that line has changed */
};

/* What a comparison found. */
struct ttf_sums_verdict {
    enum ttf_sums_state state;
    char path[200]; /* of AHEAD and SEAL: what it lists */
    int64_t line;   /* of WRONG, AHEAD and SEAL: which of its lines */
};

/* Compares while somebody scans the records: begin, each line, end (always; it frees). */
struct ttf_sums_compare {
    struct ttf_io *io;
    const char *dataset;    /* borrowed */
    struct ttf_lines lines; /* of SHA256SUMS */
    int file;
    bool differs;
};

TTF_MUST_USE int ttf_sums_compare_begin(struct ttf_sums_compare *c, struct ttf_io *io,
                                        const char *dataset, struct ttf_err *err);
TTF_MUST_USE int ttf_sums_compare_line(struct ttf_sums_compare *c, const struct ttf_line *line,
                                       struct ttf_err *err);

/* ret NULL: only frees. */
TTF_MUST_USE int ttf_sums_compare_end(struct ttf_sums_compare *c, struct ttf_sums_verdict *ret,
                                      struct ttf_err *err);

/* All of it. */
TTF_MUST_USE int ttf_sums_compare(struct ttf_io *io, const char *dataset,
                                  struct ttf_sums_verdict *ret, struct ttf_err *err);

/* Removes a file that may not be there: 1 if it was, 0 if not. */
TTF_MUST_USE int ttf_remove(struct ttf_io *io, const char *path, struct ttf_err *err);

#endif
