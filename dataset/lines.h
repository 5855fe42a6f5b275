/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lines.h: lines of records.jsonl and events.jsonl, framed and checked. FORMAT.md,
 * "Lines". For the store's files only.
 *
 * A line is one JSON object: type first, seq second, crc last. The crc is over all
 * bytes before the comma that precedes it, so the last 18 bytes of a line are
 * always  ,"crc":"01234567"}
 */
#ifndef TTF_DATASET_LINES_H
#define TTF_DATASET_LINES_H

#include <jansson.h>
#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/json_writer.h"

#define TTF_LINE_TAIL 18u
#define TTF_LINE_MAX  ((size_t)16 << 20)

/* Begins an object with its type and seq. */
void ttf_line_begin(struct ttf_json *json, const char *type, int64_t seq);

/* The same in the memory of the line that was in json before. */
void ttf_line_again(struct ttf_json *json, const char *type, int64_t seq);

/* Adds the crc and closes. The text (without newline) belongs to json. */
TTF_MUST_USE int ttf_line_finish(struct ttf_json *json, const char **ret_text, size_t *ret_bytes);

/* ---- reading a file line by line, with one line in memory ---- */

struct ttf_lines {
    struct ttf_io *io;
    int file;
    char *buf;
    size_t room, have; /* of buf */
    size_t at;         /* where the next line begins in buf */
    int64_t base;      /* file offset of buf[0] */
    int64_t number;    /* of the line last given, from 1 */
    bool at_end;       /* the file's end is in buf */
};

/* file stays the caller's. */
void ttf_lines_init(struct ttf_lines *lines, struct ttf_io *io, int file);
/* 1: a line (valid until the next call, without its newline); 0: none left; -EFBIG, -EIO, -ENOMEM. */
TTF_MUST_USE int ttf_lines_next(struct ttf_lines *lines, const char **ret_line, size_t *ret_bytes,
                                int64_t *ret_offset, bool *ret_terminated);
void ttf_lines_free(struct ttf_lines *lines);

/* ---- a whole file of checked lines ---- */

struct ttf_line {
    const char *where; /* path:number */
    const char *text;
    size_t bytes;
    int64_t offset;
    int64_t number;
    const char *type;
    json_t *json; /* borrowed; NULL: known by its text */
};

/* Non-zero stops the scan and is returned. */
typedef int ttf_line_fn(void *ctx, const struct ttf_line *line, struct ttf_err *err);
/*
 * Knows a line whose crc holds by its text alone, so that it need not be parsed, and keeps in ctx what the ttf_line_fn that gets it next
 * goes by. false: parse it.
 */
typedef bool ttf_known_line_fn(void *ctx, const char *text, size_t bytes, int64_t *ret_seq,
                               const char **ret_type);
/* A damaged line (its bytes: line, n), where a scan is to go on behind it. line may be NULL. */
typedef void ttf_bad_line_fn(void *ctx, const char *where, const char *text, const char *line,
                             size_t n);

struct ttf_lines_tail {
    int64_t lines, next_seq;
    int64_t good_bytes; /* up to the end of the last good line, its newline included if there */
    bool no_newline;    /* the last good line has none: a crash between crc and newline */
    int64_t fragment_offset; /* bytes behind that are no line */
    int64_t fragment_bytes;
};

/*
 * Gives every good line. A terminated line whose crc or seq is wrong, or that is
 * no such object: -TTF_EDAMAGED naming it, or, with `bad`, told and passed over.
 */
TTF_MUST_USE int ttf_lines_scan(struct ttf_io *io, const char *path, ttf_line_fn *fn,
                                ttf_bad_line_fn *bad, void *ctx, struct ttf_lines_tail *ret,
                                struct ttf_err *err);

/*
 * The same without `bad`; known: NULL, or for who looks again at each line that it knows before what stands there counts, as
 * their JSON is not looked at.
 */
TTF_MUST_USE int ttf_lines_scan_known(struct ttf_io *io, const char *path, ttf_known_line_fn *known,
                                      ttf_line_fn *fn, void *ctx, struct ttf_lines_tail *ret,
                                      struct ttf_err *err);

#endif
