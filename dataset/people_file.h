/* SPDX-License-Identifier: Apache-2.0 */
/*
 * people_file.h: a file that people add to (notes.jsonl, samples.json), written anew as a whole in the place of the old
 * one. Why so, and what others must not do meanwhile: DESIGN.md, "Notes and samples".
 */
#ifndef TTF_DATASET_PEOPLE_FILE_H
#define TTF_DATASET_PEOPLE_FILE_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

struct ttf_people_file {
    const char *name;     /* "notes.jsonl" */
    const char *fresh;    /* how the new file's name begins: ".notes-new" */
    const char *addition; /* what is said of a failure: "the note" */
    /*
     * Puts into `file`, which is new and empty, what it is to hold; `old` is what it takes the place of, of so many
     * bytes (-1: there is none, 0 bytes). 0 or a negative errno, in *err too where it is no error of the disk.
     */
    int (*fill)(void *ctx, struct ttf_io *io, int old, int64_t bytes, int file,
                struct ttf_err *err);
};

/*
 * 0: it is on the disk and stays there. Else what was there before is as it was, or, if the last sync failed, the new
 * one may be seen and is not promised. -EAGAIN, at once, while somebody else writes; -ENOENT: there is no dataset at
 * path; -ELOOP: the file is a link. What fill returns.
 */
TTF_MUST_USE int ttf_people_file_replace(struct ttf_io *io, const char *path,
                                         const struct ttf_people_file *what, void *ctx,
                                         struct ttf_err *err);

#endif
