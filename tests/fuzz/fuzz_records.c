/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lines of records.jsonl: once as they are, and once with the seq and crc that each lacks, since
 * no mutation ever finds one that holds. What is read can be written, and reads as the same.
 */
#include <stdlib.h>
#include <string.h>

#include "framing.h"
#include "fuzz.h"
#include "lines.h"
#include "record_line.h"

static int take_file(void *ctx, const struct ttf_named_file *file, struct ttf_err *err)
{
    return 0;
}

/* The line of a record; *json keeps the text. */
static const char *line_of(struct ttf_json *json, const struct ttf_slot_record *slot,
                           const struct ttf_segment *segment, size_t *ret_bytes)
{
    const char *text;

    ttf_line_begin(json, slot ? "slot" : "segment", 0);
    if (slot)
        ttf_slot_put(json, slot);
    else
        ttf_segment_put(json, segment);
    if (ttf_line_finish(json, &text, ret_bytes) < 0)
        abort();
    return text;
}

/* Written, read and written again: the same bytes. */
static void again(const struct ttf_slot_record *slot, const struct ttf_segment *segment)
{
    struct ttf_json first, second;
    struct ttf_slot_record slot_again;
    struct ttf_segment segment_again;
    struct ttf_line line = {.where = "again", .type = slot ? "slot" : "segment"};
    struct ttf_err err = {0};
    size_t n;

    line.text = line_of(&first, slot, segment, &line.bytes);
    line.json = json_loadb(line.text, line.bytes, JSON_REJECT_DUPLICATES, NULL);
    ttf_slot_record_init(&slot_again);
    if (!line.json || (slot ? ttf_slot_get(&line, &slot_again, &err)
                            : ttf_segment_get(&line, &segment_again, &err)) < 0)
        abort();
    if (strcmp(line_of(&second, slot ? &slot_again : NULL, &segment_again, &n), line.text) != 0)
        abort();
    ttf_slot_record_free(&slot_again);
    json_decref(line.json);
    ttf_json_free(&second);
    ttf_json_free(&first);
}

/* What a slot's head says is what its JSON says. */
static void head_agrees(const struct ttf_line *line)
{
    struct ttf_slot_brief head, brief;
    struct ttf_err err = {0};
    int64_t seq;

    if (!ttf_slot_head(line->text, line->bytes, &seq, &head))
        return;
    if (strcmp(line->type, "slot") != 0 || ttf_slot_get_brief(line, &brief, &err) < 0 ||
        seq != json_integer_value(json_object_get(line->json, "seq")) ||
        head.index != brief.index || head.segment != brief.segment || head.due_ns != brief.due_ns ||
        head.result != brief.result)
        abort();
}

/* Each reader is given each line, also one of another type: none may trust it. */
static int take_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    struct ttf_slot_record slot;
    struct ttf_slot_brief brief;
    struct ttf_segment segment;
    struct ttf_end_record end;

    head_agrees(line);
    ttf_slot_record_init(&slot);
    if (ttf_slot_get(line, &slot, err) == 0 && ttf_slot_check(&slot, err) == 0)
        again(&slot, NULL);
    ttf_slot_record_free(&slot);
    (void)!ttf_slot_get_brief(line, &brief, err);
    if (ttf_segment_get(line, &segment, err) == 0 && ttf_segment_check(&segment, err) == 0)
        again(NULL, &segment);
    (void)!ttf_end_get(line, &end, err);
    (void)!ttf_line_files(line, take_file, NULL, err);
    return 0;
}

static void bad_line(void *ctx, const char *where, const char *text, const char *line, size_t n)
{
}

static void scan(const uint8_t *data, size_t size)
{
    struct ttf_lines_tail tail;
    struct ttf_err err = {0};
    struct fuzz_io io;

    fuzz_io_init(&io, data, size);
    (void)!ttf_lines_scan(&io.base, "records.jsonl", take_line, bad_line, NULL, &tail, &err);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *framed;
    size_t n;

    if (size > 1 << 16)
        return 0;
    scan(data, size);
    framed = fuzz_frame_lines(data, size, &n);
    scan((const uint8_t *)framed, n);
    free(framed);
    return 0;
}
