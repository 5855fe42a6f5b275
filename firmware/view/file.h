/* SPDX-License-Identifier: Apache-2.0 */
/* file.h: the file as it is written: texts and base64, from its start to its end. */
#ifndef VIEW_FILE_H
#define VIEW_FILE_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"

#define VIEW_PIECE_BYTES 65536

struct view_file {
    struct ttf_io *io;
    const char *path; /* of the temporary name */
    int handle;
    int64_t offset; /* bytes on disk */
    size_t used;    /* and in the piece */
    int code;       /* the first failure: it sticks */
    char piece[VIEW_PIECE_BYTES];
};

void view_file_put(struct view_file *file, const char *text, size_t n);
void view_file_text(struct view_file *file, const char *text);
/* With &, <, > and " as entities. */
void view_file_escaped(struct view_file *file, const char *text);
/* JSON inside of a script element: no '<' ends it. */
void view_file_json(struct view_file *file, const char *text);
void view_file_base64(struct view_file *file, const uint8_t *data, size_t n);

/* Writes what is left; 0 or what went wrong first. */
TTF_MUST_USE int view_file_flush(struct view_file *file, struct ttf_err *err);

/* Bytes so far. */
static inline int64_t view_file_bytes(const struct view_file *file)
{
    return file->offset + (int64_t)file->used;
}

#endif
