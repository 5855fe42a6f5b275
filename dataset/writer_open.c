/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "sums.h"
#include "ttf/dataset/hash.h"
#include "writer_private.h"

/* One pass over the records: what they say, and whether SHA256SUMS says the same. */
struct opening {
    struct ttf_writer *writer;
    struct ttf_sums_compare sums;
};

static int learn_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    struct opening *opening = ctx;
    int r;

    r = ttf_writer_learn(opening->writer, line, err);
    /* Also of a sealed one, whose list is not compared: each file entry is looked at before anything is touched. */
    return r ? r : ttf_sums_compare_line(&opening->sums, line, err);
}

/* Whatever SHA256SUMS lists and no record names was committed and is lost. */
static int end_compare(struct ttf_writer *writer, struct ttf_sums_compare *compare,
                       enum ttf_sums_state *ret, struct ttf_err *err)
{
    struct ttf_sums_verdict verdict;
    int r;

    r = ttf_sums_compare_end(compare, ret ? &verdict : NULL, err);
    if (r || !ret)
        return r;
    *ret = verdict.state;
    if (verdict.state == TTF_SUMS_AHEAD)
        ttf_err_set(err, -TTF_EDAMAGED, writer->path,
                    "records.jsonl has lost lines: " TTF_SUMS_NAME
                    " lists %s, which no record names",
                    verdict.path);
    else if (verdict.state == TTF_SUMS_SEAL)
        ttf_err_set(err, -TTF_EDAMAGED, writer->path,
                    TTF_SUMS_NAME " is of a seal, as it lists %s, but its line of records.jsonl "
                                  "has changed or is gone",
                    verdict.path);
    else
        return 0;
    ttf_err_hint(err, "keep a copy of the folder; go on in a new dataset");
    return -TTF_EDAMAGED;
}

static int open_records(struct ttf_writer *writer, struct ttf_lines_tail *tail,
                        enum ttf_sums_state *sums, struct ttf_err *err)
{
    struct opening opening = {.writer = writer};
    char *path = ttf_path_format("%s/records.jsonl", writer->path);
    int r, compared;

    if (!path)
        return ttf_err_set(err, -ENOMEM, writer->path, "no memory");
    r = ttf_sums_compare_begin(&opening.sums, writer->io, writer->path, err);
    opening.sums.differs = writer->sealed;
    if (r == 0)
        r = ttf_lines_scan(writer->io, path, learn_line, NULL, &opening, tail, err);
    if (r == -ENOENT)
        r = ttf_err_set(err, -TTF_EDAMAGED, path, "is missing");
    compared = end_compare(writer, &opening.sums, r || writer->sealed ? NULL : sums, err);
    r = r ? r : compared;
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

/* What the segments say of dataset.json is compared with this. */
static int hash_manifest(struct ttf_writer *writer, struct ttf_err *err)
{
    char *path = ttf_path_format("%s/dataset.json", writer->path);
    int r;

    if (!path)
        return ttf_err_set(err, -ENOMEM, writer->path, "no memory");
    r = ttf_sha256_file(writer->io, path, NULL, writer->manifest_sha256, err);
    free(path);
    return r;
}

static int open_all(struct ttf_writer *writer, bool doubt, struct ttf_err *err)
{
    struct ttf_lines_tail records = {0}, events = {0};
    enum ttf_sums_state sums = TTF_SUMS_SAME;
    int r;

    r = ttf_manifest_load(writer->io, writer->path, &writer->manifest, err);
    if (r == 0)
        r = hash_manifest(writer, err);
    if (r)
        return r;
    r = ttf_writer_lock(writer, err);
    if (r)
        return r;
    r = ttf_sums_sealed(writer->io, writer->path, &writer->sealed, err);
    if (r)
        return r;
    r = open_records(writer, &records, &sums, err);
    if (r)
        return r;
    r = open_events(writer, &events, err);
    if (r)
        return r;
    writer->state.sealed = writer->sealed;
    if (writer->sealed) {
        if (records.fragment_bytes > 0 || events.fragment_bytes > 0)
            return ttf_err_set(err, -TTF_EDAMAGED, writer->path,
                               "records.jsonl or events.jsonl changed after the seal");
        return 0; /* nothing is touched before the first write */
    }
    r = ttf_writer_sync_names(writer, err);
    if (r)
        return r;
    r = ttf_writer_repair(writer, &records, &events, sums, doubt, err);
    if (r == 0)
        ttf_reserve_make(writer);
    return r;
}

static bool in_doubt(const struct ttf_writer *writer)
{
    return writer && (writer->records.doubt || writer->events.doubt);
}

int ttf_writer_open_anew(struct ttf_io *io, const char *path, struct ttf_writer *old, bool *doubt,
                         struct ttf_writer **ret, struct ttf_err *err)
{
    struct ttf_writer *writer;
    int r;

    *doubt = *doubt || in_doubt(old);
    ttf_writer_abandon(old);
    writer = ttf_writer_alloc(io, path);
    if (!writer)
        return ttf_err_set(err, -ENOMEM, path, "no memory");
    r = open_all(writer, *doubt, err);
    if (r) {
        *doubt = *doubt || in_doubt(writer);
        ttf_writer_abandon(writer);
        return r;
    }
    *doubt = false;
    *ret = writer;
    return 0;
}

int ttf_writer_open(struct ttf_io *io, const char *path, struct ttf_writer **ret,
                    struct ttf_err *err)
{
    bool doubt = false;

    return ttf_writer_open_anew(io, path, NULL, &doubt, ret, err);
}
