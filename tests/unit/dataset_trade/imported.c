/* SPDX-License-Identifier: Apache-2.0 */
#include "imported.h"

#include <stdlib.h>

struct ttf_import_result import_ok(struct ttf_io *io, const struct ttf_import_config *config)
{
    struct ttf_import_result result = {0};
    struct ttf_err err = {0};

    if (ttf_import(io, config, &result, &err))
        fail_msg("%s: %s; %s", err.where, err.what, err.hint);
    return result;
}

struct opened open_dataset(const char *path)
{
    struct opened opened = {0};
    struct ttf_err err = {0};

    if (ttf_reader_open(ttf_io_posix(), path, &opened.reader, &err) ||
        ttf_sequence_of_dataset(opened.reader, NULL, &opened.sequence, &err))
        fail_msg("%s: %s", err.where, err.what);
    return opened;
}

void close_dataset(struct opened *opened)
{
    ttf_sequence_destroy(opened->sequence);
    ttf_reader_close(opened->reader);
}

uint16_t *read_frame(struct ttf_sequence *s, uint32_t t)
{
    uint16_t *frame = malloc((size_t)s->width * s->height * 3 * sizeof(*frame));
    struct ttf_err err = {0};

    if (ttf_sequence_read_rows(s, t, 0, s->height, frame, &err))
        fail_msg("%s: %s", err.where, err.what);
    return frame;
}
