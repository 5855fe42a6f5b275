/* SPDX-License-Identifier: Apache-2.0 */
/* What a writer does between opening and closing. Files: writer_file.c; the seal: seal.c. */
#include "ttf/dataset/writer.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "record_line.h"
#include "sums.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/json_parse.h"
#include "writer_private.h"

/* Of an event without detail: a text of 255 bytes, each written as six at the most, and its frame. */
#define EVENT_LINE_BYTES 4096

struct ttf_writer *ttf_writer_alloc(struct ttf_io *io, const char *path)
{
    struct ttf_writer *writer = calloc(1, sizeof(*writer));
    size_t n = strlen(path);

    if (!writer)
        return NULL;
    while (n > 1 && path[n - 1] == '/')
        n--;
    writer->io = io;
    writer->lock = writer->sums = writer->records.file = writer->events.file = -1;
    writer->path = strndup(path, n);
    writer->piece = malloc(TTF_SHA256_PIECE);
    if (!writer->path || !writer->piece) {
        free(writer->path);
        free(writer->piece);
        free(writer);
        return NULL;
    }
    return writer;
}

int ttf_writer_reserve(struct ttf_writer *writer, size_t line_bytes, struct ttf_err *err)
{
    int r = ttf_jsonl_reserve(&writer->records, line_bytes);

    if (r == 0)
        r = ttf_jsonl_reserve(&writer->events, EVENT_LINE_BYTES);
    return r ? ttf_err_set(err, r, writer->path, "no memory for lines of %zu bytes", line_bytes)
             : 0;
}

int ttf_writer_lock(struct ttf_writer *writer, struct ttf_err *err)
{
    struct ttf_io *io = writer->io;
    int r;

    writer->lock = io->ops->open(io, writer->path, TTF_IO_READ);
    if (writer->lock < 0)
        return ttf_err_set(err, writer->lock, writer->path, "cannot be opened: %s",
                           strerrordesc_np(-writer->lock));
    r = ttf_io_lock(io, writer->lock);
    if (r == -EAGAIN) {
        ttf_err_set(err, -EBUSY, writer->path, "another program is writing this dataset");
        ttf_err_hint(err, "wait until it is done, or stop it");
        return -EBUSY;
    }
    return r ? ttf_err_set(err, r, writer->path, "cannot be locked: %s", strerrordesc_np(-r)) : 0;
}

const struct ttf_manifest *ttf_writer_manifest(const struct ttf_writer *writer)
{
    return &writer->manifest;
}

const struct ttf_writer_state *ttf_writer_state(const struct ttf_writer *writer)
{
    return &writer->state;
}

const char *ttf_writer_path(const struct ttf_writer *writer)
{
    return writer->path;
}

int ttf_writer_space(struct ttf_writer *writer, struct ttf_io_space *ret)
{
    return writer->io->ops->space(writer->io, writer->path, ret);
}

/*
 * What sealing once more may have left beside the seal: a log that was being written anew when the power went. Opening
 * only looks at what is sealed. The folder is synced when the seal goes.
 */
static int remove_temporary(struct ttf_writer *writer, const char *log, struct ttf_err *err)
{
    char *path = ttf_path_format("%s.tmp", log);
    struct ttf_io_stat st;
    int r = 0;

    if (!path)
        return ttf_err_set(err, -ENOMEM, log, "no memory");
    if (writer->io->ops->stat(writer->io, path, &st) == 0)
        r = ttf_remove(writer->io, path, err);
    free(path);
    return r < 0 ? r : 0;
}

int ttf_writer_unseal(struct ttf_writer *writer, struct ttf_err *err)
{
    int r;

    if (!writer->sealed)
        return 0;
    r = remove_temporary(writer, writer->records.path, err);
    if (r == 0)
        r = remove_temporary(writer, writer->events.path, err);
    if (r)
        return r;
    r = ttf_sums_rebuild(writer->io, writer->path, err);
    if (r)
        return r;
    writer->sealed = false;
    writer->state.sealed = false;
    writer->sums_behind = false;
    ttf_reserve_make(writer);
    return 0;
}

int ttf_writer_learn_segment(struct ttf_writer *writer, const struct ttf_segment *segment)
{
    struct ttf_writer_state *state = &writer->state;

    if (segment->segment > state->n_segments)
        return -EINVAL;
    if (segment->segment == state->n_segments)
        state->n_segments++;
    if (segment->segment == state->n_segments - 1)
        state->last_segment = *segment;
    /* A run gone on with in another dataset begins here: what was before has its records there. */
    if (segment->segment == 0 && state->next_index == 0)
        state->next_index = segment->first_index;
    return 0;
}

int ttf_writer_segment(struct ttf_writer *writer, const struct ttf_segment *segment,
                       struct ttf_err *err)
{
    const struct ttf_writer_state *state = &writer->state;
    struct ttf_segment s = *segment;
    int r;

    r = ttf_segment_check(&s, err);
    if (r)
        return r;
    if (s.segment > state->n_segments || (s.segment < state->n_segments) != s.corrects)
        return ttf_err_set(err, -EINVAL, "segment", "segment is %d%s, but %d is the next new one",
                           s.segment, s.corrects ? " (a correction)" : "", state->n_segments);
    if (s.plan == 0 && state->n_plans == 0)
        s.plan = -1;
    if (s.plan >= state->n_plans)
        return ttf_err_set(err, -EINVAL, "segment", "plan is %d, but there are %d plans", s.plan,
                           state->n_plans);
    memcpy(s.dataset_sha256, writer->manifest_sha256, sizeof(s.dataset_sha256));
    r = ttf_writer_unseal(writer, err);
    if (r)
        return r;
    ttf_segment_put(ttf_jsonl_begin(&writer->records, "segment"), &s);
    r = ttf_jsonl_append(&writer->records, err);
    if (r == 0) {
        writer->ended = false;
        r = ttf_writer_learn_segment(writer, &s);
    }
    return r;
}

int ttf_writer_plan(struct ttf_writer *writer, const char *yaml, const char *text,
                    struct ttf_err *err)
{
    int n = writer->state.n_plans, r;

    if (!yaml && !text)
        return ttf_err_set(err, -EINVAL, "plan", "there is neither YAML nor JSON of it");
    r = ttf_writer_unseal(writer, err);
    if (r)
        return r;
    r = ttf_writer_plan_files(writer, n, yaml, text, ttf_jsonl_begin(&writer->records, "plan"),
                              err);
    if (r == 0)
        r = ttf_jsonl_append(&writer->records, err);
    if (r)
        return r;
    writer->ended = false;
    writer->state.n_plans++;
    return n;
}

static int open_sums(struct ttf_writer *writer)
{
    char path[TTF_PATH_MAX];
    int r = ttf_path_put(path, "%s/" TTF_SUMS_NAME, writer->path);

    return r ? r : writer->io->ops->open(writer->io, path, TTF_IO_APPEND);
}

/* Lines of SHA256SUMS for a slot's files. Not synced: opening repairs it from the records. */
static void list_files(struct ttf_writer *writer, const struct ttf_slot_record *record)
{
    const struct ttf_file_ref *file;
    char line[sizeof(file->sha256) + sizeof(file->path) + 4];
    unsigned i, k;

    for (i = 0; i < record->n_images; i++)
        for (k = 0; k < record->images[i].n_files && !writer->sums_behind; k++) {
            file = &record->images[i].files[k];
            if (writer->sums < 0)
                writer->sums = open_sums(writer);
            snprintf(line, sizeof(line), "%s  %s\n", file->sha256, file->path);
            writer->sums_behind = writer->sums < 0 || ttf_io_append_all(writer->io, writer->sums,
                                                                        line, strlen(line)) != 0;
        }
}

int ttf_writer_commit(struct ttf_writer *writer, const struct ttf_slot_record *record,
                      struct ttf_err *err)
{
    struct ttf_writer_state *state = &writer->state;
    int r;

    r = ttf_slot_check(record, err);
    if (r)
        return r;
    if (record->index < state->next_index || record->index == INT64_MAX)
        return ttf_err_set(err, -EINVAL, "slot", "index is %lld, but %lld is the next one",
                           (long long)record->index, (long long)state->next_index);
    if (record->segment >= state->n_segments)
        return ttf_err_set(err, -EINVAL, "slot", "segment %d has no line yet", record->segment);
    r = ttf_writer_unseal(writer, err);
    if (r)
        return r;
    ttf_slot_put(ttf_jsonl_begin(&writer->records, "slot"), record);
    r = ttf_jsonl_append(&writer->records, err);
    if (r)
        return r;
    writer->ended = false;
    ttf_writer_count_slot(state, record->index, record->result);
    list_files(writer, record);
    return 0;
}

/* JSON has no line ends inside texts, so those in a detail can only be blanks. */
static int put_detail(struct ttf_json *json, const char *detail, struct ttf_err *err)
{
    json_t *parsed = NULL;
    char *line, *c;
    bool object;
    int r;

    r = ttf_json_parse(detail, strlen(detail), &parsed, NULL);
    if (r == -ENOMEM)
        return ttf_err_set(err, r, "event", "no memory");
    object = json_is_object(parsed);
    json_decref(parsed);
    if (!object)
        return ttf_err_set(err, -EINVAL, "event", "detail is no JSON object");
    line = strdup(detail);
    if (!line)
        return ttf_err_set(err, -ENOMEM, "event", "no memory");
    for (c = line; *c; c++)
        if (*c == '\n' || *c == '\r')
            *c = ' ';
    ttf_json_key(json, "detail");
    ttf_json_raw(json, line);
    free(line);
    return 0;
}

static int append_event(struct ttf_writer *writer, const char *kind, int64_t at_ns,
                        int64_t at_utc_ns, const char *text, const char *detail,
                        struct ttf_err *err)
{
    struct ttf_json *json = ttf_jsonl_begin(&writer->events, "event");
    int r;

    ttf_json_kstring(json, "kind", kind);
    if (at_ns != TTF_NS_UNKNOWN)
        ttf_json_kint(json, "at_ns", at_ns);
    if (at_utc_ns != TTF_NS_UNKNOWN)
        ttf_json_kint(json, "at_utc_ns", at_utc_ns);
    if (text && text[0])
        ttf_json_kstring(json, "text", text);
    if (detail) {
        r = put_detail(json, detail, err);
        if (r)
            return r;
    }
    return ttf_jsonl_append(&writer->events, err);
}

int ttf_writer_event(struct ttf_writer *writer, const char *kind, int64_t at_ns, int64_t at_utc_ns,
                     const char *text, const char *detail_json, struct ttf_err *err)
{
    int r;

    r = ttf_writer_unseal(writer, err);
    if (r)
        return r;
    do
        r = append_event(writer, kind, at_ns, at_utc_ns, text, detail_json, err);
    while (r == -ENOSPC && writer->events.broken == 0 && ttf_reserve_use(writer));
    return r;
}

/* Newlines that are owed, and SHA256SUMS. What fails here, opening puts right. */
static void settle(struct ttf_writer *writer)
{
    struct ttf_io *io = writer->io;
    int r;

    if (writer->sealed || writer->records.file < 0 || writer->events.file < 0)
        return;
    r = ttf_jsonl_settle(&writer->records, NULL);
    if (r == 0)
        r = ttf_jsonl_settle(&writer->events, NULL);
    if (r == 0 && writer->sums_behind)
        r = ttf_sums_rebuild(io, writer->path, NULL);
    else if (r == 0 && writer->sums >= 0)
        r = io->ops->sync(io, writer->sums, false);
    if (r == 0)
        (void)io->ops->sync_dir(io, writer->path);
}

bool ttf_writer_broken(const struct ttf_writer *writer)
{
    return writer->records.broken != 0 || writer->events.broken != 0;
}

void ttf_writer_close(struct ttf_writer *writer)
{
    if (!writer)
        return;
    settle(writer);
    ttf_writer_abandon(writer);
}

void ttf_writer_abandon(struct ttf_writer *writer)
{
    struct ttf_io *io;

    if (!writer)
        return;
    io = writer->io;
    ttf_jsonl_close(&writer->records);
    ttf_jsonl_close(&writer->events);
    if (writer->sums >= 0)
        io->ops->close(io, writer->sums);
    if (writer->lock >= 0)
        io->ops->close(io, writer->lock);
    free(writer->calibrations);
    free(writer->piece);
    free(writer->path);
    free(writer);
}
