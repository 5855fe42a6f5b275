/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Lines of records.jsonl: once as they are, and once with the crc that each lacks, since no
 * mutation ever finds one that holds.
 */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <zlib.h>

#include "fuzz.h"
#include "lines.h"
#include "record_line.h"

static int take_file(void *ctx, const struct ttf_named_file *file, struct ttf_err *err)
{
    return 0;
}

/* Each reader is given each line, also one of another type: none may trust it. */
static int take_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    struct ttf_slot_record slot;
    struct ttf_slot_brief brief;
    struct ttf_segment segment;
    struct ttf_end_record end;

    ttf_slot_record_init(&slot);
    if (ttf_slot_get(line, &slot, err) == 0)
        (void)!ttf_slot_check(&slot, err);
    ttf_slot_record_free(&slot);
    (void)!ttf_slot_get_brief(line, &brief, err);
    (void)!ttf_segment_get(line, &segment, err);
    (void)!ttf_end_get(line, &end, err);
    (void)!ttf_line_files(line, take_file, NULL, err);
    return 0;
}

static void bad_line(void *ctx, const char *where, const char *text)
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

/* A line's crc and end behind it, where its body ends with no '}' or crc of its own. */
static size_t frame_line(const uint8_t *line, size_t n, char *ret)
{
    if (n >= TTF_LINE_TAIL && memcmp(line + n - TTF_LINE_TAIL, ",\"crc\":\"", 8) == 0)
        n -= TTF_LINE_TAIL;
    memcpy(ret, line, n);
    return n + (size_t)sprintf(ret + n, ",\"crc\":\"%08lx\"}\n", crc32(0, line, (uInt)n));
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    char *framed;
    size_t n = 0;

    if (size > 1 << 16)
        return 0;
    scan(data, size);
    framed = malloc(size * (TTF_LINE_TAIL + 2) + 2 * TTF_LINE_TAIL);
    for (size_t at = 0; framed && at < size;) {
        const uint8_t *end = memchr(data + at, '\n', size - at);
        size_t length = end ? (size_t)(end - data) - at : size - at;

        n += frame_line(data + at, length, framed + n);
        at += length + 1;
    }
    if (framed)
        scan((const uint8_t *)framed, n);
    free(framed);
    return 0;
}
