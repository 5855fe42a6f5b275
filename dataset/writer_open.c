/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "sums.h"
#include "writer_private.h"

static int learn_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    return ttf_writer_learn(ctx, line, err);
}

static int open_records(struct ttf_writer *writer, struct ttf_lines_tail *tail, struct ttf_err *err)
{
    char *path = ttf_path_format("%s/records.jsonl", writer->path);
    int r;

    if (!path)
        return ttf_err_set(err, -ENOMEM, writer->path, "no memory");
    r = ttf_lines_scan(writer->io, path, learn_line, NULL, writer, tail, err);
    if (r == -ENOENT)
        r = ttf_err_set(err, -TTF_EDAMAGED, path, "is missing");
    if (r == 0)
        r = ttf_jsonl_open(&writer->records, writer->io, path, tail, err);
    free(path);
    return r;
}

static int open_events(struct ttf_writer *writer, struct ttf_lines_tail *tail, struct ttf_err *err)
{
    char *path = ttf_path_format("%s/events.jsonl", writer->path);
    struct ttf_err missing = {0};
    int r;

    *tail = (struct ttf_lines_tail){0};
    if (!path)
        return ttf_err_set(err, -ENOMEM, writer->path, "no memory");
    r = ttf_lines_scan(writer->io, path, NULL, NULL, NULL, tail, &missing);
    if (r == -ENOENT)
        r = 0; /* a dataset that somebody else made: nothing happened yet */
    else if (r && err)
        *err = missing;
    if (r == 0)
        r = ttf_jsonl_open(&writer->events, writer->io, path, tail, err);
    free(path);
    return r;
}

static int open_all(struct ttf_writer *writer, struct ttf_err *err)
{
    struct ttf_lines_tail records = {0}, events = {0};
    int r;

    r = ttf_manifest_load(writer->io, writer->path, &writer->manifest, err);
    if (r)
        return r;
    r = ttf_writer_lock(writer, err);
    if (r)
        return r;
    r = open_records(writer, &records, err);
    if (r)
        return r;
    r = open_events(writer, &events, err);
    if (r)
        return r;
    r = ttf_sums_sealed(writer->io, writer->path, &writer->sealed, err);
    if (r)
        return r;
    writer->state.sealed = writer->sealed;
    if (writer->sealed) {
        if (records.fragment_bytes > 0 || events.fragment_bytes > 0)
            return ttf_err_set(err, -TTF_EDAMAGED, writer->path,
                               "records.jsonl or events.jsonl changed after the seal");
        return 0; /* nothing is touched before the first write */
    }
    r = ttf_writer_repair(writer, &records, &events, err);
    if (r == 0)
        ttf_reserve_make(writer);
    return r;
}

int ttf_writer_open(struct ttf_io *io, const char *path, struct ttf_writer **ret,
                    struct ttf_err *err)
{
    struct ttf_writer *writer = ttf_writer_alloc(io, path);
    int r;

    if (!writer)
        return ttf_err_set(err, -ENOMEM, path, "no memory");
    r = open_all(writer, err);
    if (r) {
        ttf_writer_abandon(writer);
        return r;
    }
    *ret = writer;
    return 0;
}
