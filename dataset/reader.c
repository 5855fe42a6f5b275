/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/reader.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "record_line.h"
#include "sums.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/json_parse.h"

/* dataset.json is small: sixteen streams take some kilobytes. */
#define MANIFEST_BYTES_MAX ((size_t)4 << 20)

/* Where a slot's line lies in records.jsonl. */
struct slot_at {
    int64_t index, offset;
    int64_t number; /* of the line, for messages */
    uint32_t bytes;
    enum ttf_result result;
};

struct ttf_reader {
    struct ttf_io *io;
    char *path, *records_path;
    int file; /* records.jsonl */
    struct ttf_manifest manifest;
    struct ttf_reader_summary summary;
    struct slot_at *slots;
    size_t slots_room;
    struct ttf_segment *segments;
    size_t segments_room;
    struct ttf_slot_brief head; /* while it opens: of the line that is known by it */
};

/* Makes room for one more element of an array that doubles. */
static int grow(void *array_at, size_t *room, size_t used, size_t element)
{
    void **array = array_at, *grown;
    size_t wanted = *room ? *room * 2 : 64;

    if (used < *room)
        return 0;
    grown = reallocarray(*array, wanted, element);
    if (!grown)
        return -ENOMEM;
    *array = grown;
    *room = wanted;
    return 0;
}

static int take_slot(struct ttf_reader *reader, const struct ttf_line *line, struct ttf_err *err)
{
    struct ttf_reader_summary *sum = &reader->summary;
    struct ttf_slot_brief brief = reader->head;
    int r = line->json ? ttf_slot_get_brief(line, &brief, err) : 0;

    if (r)
        return r;
    if (sum->slots > 0 && brief.index <= sum->last_index)
        return ttf_err_set(err, -TTF_EDAMAGED, line->where,
                           "slot %lld comes after slot %lld: slots are in rising order",
                           (long long)brief.index, (long long)sum->last_index);
    if (brief.segment >= sum->n_segments)
        return ttf_err_set(err, -TTF_EDAMAGED, line->where,
                           "slot %lld is of segment %d, which has no line before it",
                           (long long)brief.index, brief.segment);
    r = grow((void *)&reader->slots, &reader->slots_room, (size_t)sum->slots,
             sizeof(*reader->slots));
    if (r)
        return ttf_err_set(err, r, line->where, "no memory");
    reader->slots[sum->slots] = (struct slot_at){.index = brief.index,
                                                 .offset = line->offset,
                                                 .number = line->number,
                                                 .bytes = (uint32_t)line->bytes,
                                                 .result = brief.result};
    if (sum->slots == 0)
        sum->first_index = brief.index;
    sum->last_index = brief.index;
    sum->slots++;
    sum->counts[brief.result]++;
    return 0;
}

static int take_segment(struct ttf_reader *reader, const struct ttf_line *line, struct ttf_err *err)
{
    struct ttf_reader_summary *sum = &reader->summary;
    struct ttf_segment segment;
    int r;

    r = ttf_segment_get(line, &segment, err);
    if (r)
        return r;
    if (segment.segment > sum->n_segments)
        return ttf_err_set(err, -TTF_EDAMAGED, line->where,
                           "segment %d comes where segment %d is due", segment.segment,
                           sum->n_segments);
    if (segment.plan >= sum->n_plans)
        return ttf_err_set(err, -TTF_EDAMAGED, line->where,
                           "segment %d follows plan %d, which has no line before it",
                           segment.segment, segment.plan);
    r = grow((void *)&reader->segments, &reader->segments_room, (size_t)sum->n_segments,
             sizeof(*reader->segments));
    if (r)
        return ttf_err_set(err, r, line->where, "no memory");
    reader->segments[segment.segment] = segment;
    if (segment.segment == sum->n_segments)
        sum->n_segments++;
    return 0;
}

/* Its number, as segments name it; lines that lack what only verify and writers go by are read all the same. */
static int take_plan(struct ttf_reader *reader, const struct ttf_line *line, struct ttf_err *err)
{
    struct ttf_reader_summary *sum = &reader->summary;
    int number, r = ttf_plan_number(line, &number, err);

    if (r == 0 && number != sum->n_plans)
        return ttf_err_set(err, -TTF_EDAMAGED, line->where, "plan %d comes where plan %d is due",
                           number, sum->n_plans);
    sum->n_plans++;
    return r;
}

/* A slot that is known is parsed when it is asked for. */
static bool know_line(void *ctx, const char *text, size_t bytes, int64_t *ret_seq,
                      const char **ret_type)
{
    struct ttf_reader *reader = ctx;

    *ret_type = "slot";
    return ttf_slot_head(text, bytes, ret_seq, &reader->head);
}

static int take_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    struct ttf_reader *reader = ctx;
    struct ttf_reader_summary *sum = &reader->summary;
    int r = 0;

    if (strcmp(line->type, "end") == 0) {
        sum->ended = true;
        return 0;
    }
    if (strcmp(line->type, "slot") == 0)
        r = take_slot(reader, line, err);
    else if (strcmp(line->type, "segment") == 0)
        r = take_segment(reader, line, err);
    else if (strcmp(line->type, "plan") == 0)
        r = take_plan(reader, line, err);
    else if (strcmp(line->type, "calibration") == 0)
        sum->n_calibrations++;
    else
        return 0; /* of a later version */
    sum->ended = false;
    return r;
}

int ttf_manifest_load(struct ttf_io *io, const char *dataset, struct ttf_manifest *ret,
                      struct ttf_err *err)
{
    char *path = ttf_path_format("%s/dataset.json", dataset), *text = NULL;
    size_t bytes;
    int r;

    if (!path)
        return ttf_err_set(err, -ENOMEM, dataset, "no memory");
    r = ttf_io_slurp(io, path, MANIFEST_BYTES_MAX, &text, &bytes, err);
    if (r == -ENOENT || r == -ENOTDIR)
        r = ttf_err_set(err, -ENOENT, dataset, "is no dataset: it has no dataset.json");
    else if (r == 0)
        r = ttf_manifest_read(text, bytes, path, ret, err);
    free(text);
    free(path);
    return r;
}

static int load(struct ttf_reader *reader, ttf_known_line_fn *known, struct ttf_err *err)
{
    struct ttf_lines_tail tail;
    int r;

    r = ttf_manifest_load(reader->io, reader->path, &reader->manifest, err);
    if (r)
        return r;
    r = ttf_lines_scan_known(reader->io, reader->records_path, known, take_line, reader, &tail,
                             err);
    if (r == -ENOENT)
        return ttf_err_set(err, -TTF_EDAMAGED, reader->records_path, "is missing");
    if (r)
        return r;
    reader->summary.unterminated = tail.fragment_bytes > 0;
    r = ttf_sums_sealed(reader->io, reader->path, &reader->summary.sealed, err);
    if (r)
        return r;
    r = reader->io->ops->open(reader->io, reader->records_path, TTF_IO_READ);
    if (r < 0)
        return ttf_err_set(err, r, reader->records_path, "cannot be opened: %s",
                           strerrordesc_np(-r));
    reader->file = r;
    return 0;
}

static int open_by(struct ttf_io *io, const char *path, ttf_known_line_fn *known,
                   struct ttf_reader **ret, struct ttf_err *err)
{
    struct ttf_reader *reader = calloc(1, sizeof(*reader));
    int r;

    if (!reader)
        return ttf_err_set(err, -ENOMEM, path, "no memory");
    reader->io = io;
    reader->file = -1;
    reader->summary.first_index = reader->summary.last_index = -1;
    reader->path = strdup(path);
    reader->records_path = ttf_path_format("%s/records.jsonl", path);
    if (!reader->path || !reader->records_path)
        r = ttf_err_set(err, -ENOMEM, path, "no memory");
    else
        r = load(reader, known, err);
    if (r) {
        ttf_reader_close(reader);
        return r;
    }
    *ret = reader;
    return 0;
}

int ttf_reader_open(struct ttf_io *io, const char *path, struct ttf_reader **ret,
                    struct ttf_err *err)
{
    return open_by(io, path, NULL, ret, err);
}

int ttf_reader_open_by_heads(struct ttf_io *io, const char *path, struct ttf_reader **ret,
                             struct ttf_err *err)
{
    return open_by(io, path, know_line, ret, err);
}

void ttf_reader_close(struct ttf_reader *reader)
{
    if (!reader)
        return;
    if (reader->file >= 0)
        reader->io->ops->close(reader->io, reader->file);
    free(reader->segments);
    free(reader->slots);
    free(reader->records_path);
    free(reader->path);
    free(reader);
}

const struct ttf_manifest *ttf_reader_manifest(const struct ttf_reader *reader)
{
    return &reader->manifest;
}

const struct ttf_reader_summary *ttf_reader_summary(const struct ttf_reader *reader)
{
    return &reader->summary;
}

const char *ttf_reader_path(const struct ttf_reader *reader)
{
    return reader->path;
}

struct ttf_io *ttf_reader_io(const struct ttf_reader *reader)
{
    return reader->io;
}

int ttf_reader_segment(struct ttf_reader *reader, int i, struct ttf_segment *ret)
{
    if (i < 0 || i >= reader->summary.n_segments)
        return -ENOENT;
    *ret = reader->segments[i];
    return 0;
}

int ttf_reader_brief(const struct ttf_reader *reader, int64_t i, int64_t *ret_index,
                     enum ttf_result *ret_result)
{
    if (i < 0 || i >= reader->summary.slots)
        return -ENOENT;
    *ret_index = reader->slots[i].index;
    *ret_result = reader->slots[i].result;
    return 0;
}

int64_t ttf_reader_find(const struct ttf_reader *reader, int64_t index)
{
    int64_t low = 0, high = reader->summary.slots, middle;

    while (low < high) {
        middle = low + (high - low) / 2;
        if (reader->slots[middle].index < index)
            low = middle + 1;
        else
            high = middle;
    }
    return low < reader->summary.slots && reader->slots[low].index == index ? low : -ENOENT;
}

int ttf_reader_slot(struct ttf_reader *reader, int64_t i, struct ttf_slot_record *ret,
                    struct ttf_err *err)
{
    struct ttf_line line = {0};
    const struct slot_at *at;
    char where[300], *text;
    json_error_t parse;
    json_t *json = NULL;
    int64_t got;
    int r;

    if (i < 0 || i >= reader->summary.slots)
        return ttf_err_set(err, -ENOENT, reader->path, "there is no slot line %lld", (long long)i);
    at = &reader->slots[i];
    snprintf(where, sizeof(where), "%s:%lld", reader->records_path, (long long)at->number);
    text = malloc(at->bytes);
    if (!text)
        return ttf_err_set(err, -ENOMEM, where, "no memory");
    got = ttf_io_pread_all(reader->io, reader->file, text, at->bytes, at->offset);
    if (got < 0) {
        r = ttf_err_set(err, (int)got, where, "cannot be read: %s", strerrordesc_np((int)-got));
        goto out;
    }
    if (got != at->bytes || !ttf_line_holds(text, at->bytes)) {
        r = ttf_err_set(err, -TTF_EDAMAGED, where, "damaged line: it changed since it was opened");
        goto out;
    }
    r = ttf_json_parse(text, at->bytes, &json, &parse);
    if (r) {
        r = r == -ENOMEM ? ttf_err_set(err, r, where, "no memory")
                         : ttf_err_set(err, -TTF_EDAMAGED, where,
                                       "damaged line: it is not JSON: %s", parse.text);
        goto out;
    }
    line.where = where;
    line.type = "slot";
    line.json = json;
    r = ttf_slot_get(&line, ret, err);
out:
    json_decref(json);
    free(text);
    return r;
}

int64_t ttf_reader_due_utc_ns(struct ttf_reader *reader, const struct ttf_slot_record *record)
{
    const struct ttf_segment *s;
    int64_t since, utc;

    if (record->segment < 0 || record->segment >= reader->summary.n_segments)
        return TTF_NS_UNKNOWN;
    s = &reader->segments[record->segment];
    if (s->origin_utc_ns == TTF_NS_UNKNOWN ||
        __builtin_sub_overflow(record->due_ns, s->origin_ns, &since) ||
        __builtin_add_overflow(s->origin_utc_ns, since, &utc))
        return TTF_NS_UNKNOWN;
    return utc;
}

int ttf_reader_digest(struct ttf_reader *reader, char ret[65], struct ttf_err *err)
{
    char *path;
    int r;

    if (!reader->summary.sealed)
        return ttf_err_set(err, -ENODATA, reader->path, "is not sealed: it has no digest yet");
    path = ttf_path_format("%s/" TTF_SUMS_NAME, reader->path);
    if (!path)
        return ttf_err_set(err, -ENOMEM, reader->path, "no memory");
    r = ttf_sha256_file(reader->io, path, NULL, ret, err);
    free(path);
    return r;
}
