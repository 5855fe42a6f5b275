/* SPDX-License-Identifier: Apache-2.0 */
/* A whole file of lines: each checked, parsed and given on; what a crash left at its end found. */
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "lines.h"
#include "ttf/dataset/json_parse.h"

struct scan {
    const char *path;
    ttf_known_line_fn *known; /* NULL: none is */
    ttf_line_fn *fn;
    ttf_bad_line_fn *bad;
    void *ctx;
    struct ttf_lines_tail tail;
    struct ttf_err *err;
};

static int damage(struct scan *s, const char *where, const struct ttf_line *line, const char *fmt,
                  ...) TTF_PRINTF(4, 5);

static int damage(struct scan *s, const char *where, const struct ttf_line *line, const char *fmt,
                  ...)
{
    char text[200];
    va_list args;

    va_start(args, fmt);
    vsnprintf(text, sizeof(text), fmt, args);
    va_end(args);
    if (s->bad) {
        s->bad(s->ctx, where, text, line ? line->text : NULL, line ? line->bytes : 0);
        return 0;
    }
    return ttf_err_set(s->err, -TTF_EDAMAGED, where, "damaged line: %s", text);
}

/* A line of which type and seq are known. */
static int take_line(struct scan *s, const struct ttf_line *line, int64_t seq)
{
    int r;

    if (seq != s->tail.next_seq) {
        r = damage(s, line->where, NULL,
                   "its seq is %lld where %lld is due: lines are lost or doubled", (long long)seq,
                   (long long)s->tail.next_seq);
        if (r)
            return r;
    }
    s->tail.next_seq = seq + 1;
    s->tail.lines++;
    return s->fn ? s->fn(s->ctx, line, s->err) : 0;
}

static int parse_line(struct scan *s, struct ttf_line *line)
{
    json_error_t parse;
    const json_t *seq;
    json_t *json;
    int r;

    r = ttf_json_parse(line->text, line->bytes, &json, &parse);
    if (r == -ENOMEM)
        return ttf_err_set(s->err, r, line->where, "no memory");
    if (r)
        return damage(s, line->where, line, "it is not JSON: %s", parse.text);
    line->json = json;
    line->type = json_string_value(json_object_get(json, "type"));
    seq = json_object_get(json, "seq");
    if (!line->type || !json_is_integer(seq))
        r = damage(s, line->where, line, "it has no type or no seq");
    else
        r = take_line(s, line, json_integer_value(seq));
    json_decref(json);
    return r;
}

/* A line whose crc holds. */
static int good_line(struct scan *s, struct ttf_line *line)
{
    int64_t seq;

    if (s->known && s->known(s->ctx, line->text, line->bytes, &seq, &line->type))
        return take_line(s, line, seq);
    return parse_line(s, line);
}

/*
 * Where the whole line at the start of an unterminated end ends, 0 if there is
 * none: when its newline did not reach the disk, the next line may lie behind it.
 */
static size_t whole_line_in(const char *text, size_t n)
{
    static const char mark[] = ",\"crc\":\"";
    const char *at = text, *hit;
    size_t end;

    while ((hit = memmem(at, n - (size_t)(at - text), mark, sizeof(mark) - 1)) != NULL) {
        end = (size_t)(hit - text) + TTF_LINE_TAIL;
        if (end <= n && ttf_line_holds(text, end))
            return end;
        at = hit + 1;
    }
    return 0;
}

static int one_line(struct scan *s, const char *text, size_t n, int64_t offset, int64_t number,
                    bool terminated)
{
    struct ttf_line line = {.text = text, .bytes = n, .offset = offset, .number = number};
    char where[300];
    size_t whole = n;

    snprintf(where, sizeof(where), "%s:%lld", s->path, (long long)number);
    line.where = where;
    if (terminated && !ttf_line_holds(text, n)) {
        s->tail.good_bytes = offset + (int64_t)n + 1;
        s->tail.next_seq++; /* so that only this line is blamed */
        return damage(s, where, &line, "its crc does not hold");
    }
    if (!terminated) {
        whole = whole_line_in(text, n);
        s->tail.fragment_offset = offset + (int64_t)whole;
        s->tail.fragment_bytes = (int64_t)(n - whole);
        if (whole == 0)
            return 0;
        s->tail.no_newline = true;
        line.bytes = whole;
    }
    s->tail.good_bytes = offset + (int64_t)whole + (terminated ? 1 : 0);
    return good_line(s, &line);
}

static int scan_file(struct scan *s, struct ttf_io *io, struct ttf_lines_tail *ret)
{
    const char *path = s->path;
    struct ttf_err *err = s->err;
    struct ttf_lines lines;
    const char *text;
    bool terminated;
    int64_t offset;
    size_t n;
    int file, r;

    file = io->ops->open(io, path, TTF_IO_READ);
    if (file < 0)
        return ttf_err_set(err, file, path, "cannot be opened: %s", strerrordesc_np(-file));
    ttf_lines_init(&lines, io, file);
    while ((r = ttf_lines_next(&lines, &text, &n, &offset, &terminated)) > 0) {
        r = one_line(s, text, n, offset, lines.number, terminated);
        if (r)
            break;
    }
    if (r == -EFBIG)
        r = damage(s, path, NULL, "a line is longer than any line may be");
    else if (r < 0 && (!err || err->code != r)) /* not told yet: err may be of a call before */
        ttf_err_set(err, r, path, "cannot be read: %s", strerrordesc_np(-r));
    ttf_lines_free(&lines);
    io->ops->close(io, file);
    if (r == 0 && ret)
        *ret = s->tail;
    return r;
}

int ttf_lines_scan(struct ttf_io *io, const char *path, ttf_line_fn *fn, ttf_bad_line_fn *bad,
                   void *ctx, struct ttf_lines_tail *ret, struct ttf_err *err)
{
    struct scan s = {.path = path, .fn = fn, .bad = bad, .ctx = ctx, .err = err};

    return scan_file(&s, io, ret);
}

int ttf_lines_scan_known(struct ttf_io *io, const char *path, ttf_known_line_fn *known,
                         ttf_line_fn *fn, void *ctx, struct ttf_lines_tail *ret,
                         struct ttf_err *err)
{
    struct scan s = {.path = path, .known = known, .fn = fn, .ctx = ctx, .err = err};

    return scan_file(&s, io, ret);
}
