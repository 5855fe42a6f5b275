/* SPDX-License-Identifier: Apache-2.0 */
/*
 * export_staging.h: output under a temporary name beside the final one, which takes
 * that name only when it is whole. For import and export. Private to them.
 */
#ifndef TTF_DATASET_EXPORT_STAGING_H
#define TTF_DATASET_EXPORT_STAGING_H

#include <stdbool.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

struct staging {
    struct ttf_io *io;
    char *final; /* without slashes at the end; where a link of that name leads to */
    char *temp;  /* in the same folder */
    bool folder;
    char *beside,
        *beside_temp; /* a small file that belongs to it, in that folder too; NULL: none */
};

/*
 * Makes the folder that `final` lies in and, if folder, the temporary folder. A final
 * folder must not exist or be empty (-EEXIST); a final file must not be a folder (-EISDIR);
 * a link must lead somewhere (-ENOENT).
 */
TTF_MUST_USE int staging_begin(struct staging *staging, struct ttf_io *io, const char *final,
                               bool folder, struct ttf_err *err);

/*
 * A file whose name is the final one's and `ending` belongs to the output, which is a file: whoever writes it to
 * beside_temp, and syncs it, has it put in its place with the output, or not at all. -EISDIR: a folder has its name.
 */
TTF_MUST_USE int staging_beside(struct staging *staging, const char *ending, struct ttf_err *err);

/* Syncs and renames; a file that was there is replaced. On failure the temporary ones are gone. Frees. */
TTF_MUST_USE int staging_commit(struct staging *staging, struct ttf_err *err);

/* An error at a path below the temporary one is told of the one that was named, also in what a child said. */
void staging_name_final(const struct staging *staging, struct ttf_err *err);

/* Removes what there is and frees. A zeroed struct is fine. */
void staging_discard(struct staging *staging);

/* Creates `path`, has it written by `produce` (as ttf_produce_fn), syncs and closes; on failure it is removed. */
TTF_MUST_USE int staging_write(struct ttf_io *io, const char *path,
                               int (*produce)(void *ctx, struct ttf_io *io, int file,
                                              struct ttf_err *err),
                               void *ctx, struct ttf_err *err);

/* The last part of a path. */
const char *staging_base(const char *path);

#endif
