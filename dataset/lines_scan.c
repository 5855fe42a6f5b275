/* SPDX-License-Identifier: Apache-2.0 */
/* A whole file of lines: each checked, parsed and given on; what a crash left at its end found. */
#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "lines.h"
#include "lines_cut.h"
#include "ttf/dataset/json_parse.h"

struct scan {
    struct ttf_io *io;
    int file;
    const char *path;
    ttf_line_fn *fn;
    ttf_bad_line_fn *bad;
    void *ctx;
    struct ttf_lines_tail tail;
    bool wrong;  /* there was a line that was none */
    bool at_end; /* what comes is no line any more */
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

/* A line whose crc holds. */
static int good_line(struct scan *s, struct ttf_line *line)
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
    if (!line->type || !json_is_integer(seq)) {
        r = damage(s, line->where, line, "it has no type or no seq");
        goto out;
    }
    if (json_integer_value(seq) != s->tail.next_seq) {
        r = damage(s, line->where, NULL,
                   "its seq is %lld where %lld is due: lines are lost or doubled",
                   (long long)json_integer_value(seq), (long long)s->tail.next_seq);
        if (r)
            goto out;
    }
    s->tail.next_seq = json_integer_value(seq) + 1;
    s->tail.lines++;
    if (s->fn)
        r = s->fn(s->ctx, line, s->err);
out:
    json_decref(json);
    return r;
}

/* Something with a newline that is no line: the first of a file may be where a cut's leftovers begin. */
static int wrong_line(struct scan *s, struct ttf_line *line, size_t *whole)
{
    int64_t bytes = 0;
    int r = 0;

    if (!s->wrong) {
        *whole = ttf_line_whole_in(line->text, line->bytes);
        r = ttf_lines_cut_off(s->io, s->file, line->offset + (int64_t)*whole,
                              s->tail.next_seq + (*whole > 0), &bytes);
    }
    s->wrong = true;
    if (r)
        return ttf_err_set(s->err, r, s->path, "cannot be read: %s", strerrordesc_np(-r));
    s->at_end = bytes > 0;
    if (s->at_end) {
        s->tail.fragment_offset = line->offset + (int64_t)*whole;
        s->tail.fragment_bytes = bytes;
        return 0;
    }
    s->tail.good_bytes = line->offset + (int64_t)line->bytes + 1;
    s->tail.next_seq++; /* so that only this line is blamed */
    *whole = 0;
    return damage(s, line->where, line, "its crc does not hold");
}

static int one_line(struct scan *s, const char *text, size_t n, int64_t offset, int64_t number,
                    bool terminated)
{
    struct ttf_line line = {.text = text, .bytes = n, .offset = offset, .number = number};
    char where[300];
    size_t whole = 0;
    int r;

    snprintf(where, sizeof(where), "%s:%lld", s->path, (long long)number);
    line.where = where;
    if (terminated && ttf_line_holds(text, n)) {
        s->tail.good_bytes = offset + (int64_t)n + 1;
        return good_line(s, &line);
    }
    if (terminated) {
        r = wrong_line(s, &line, &whole);
        if (r)
            return r;
    } else {
        whole = ttf_line_whole_in(text, n);
        s->tail.fragment_offset = offset + (int64_t)whole;
        s->tail.fragment_bytes = (int64_t)(n - whole);
    }
    if (whole == 0)
        return 0;
    /* Its newline did not reach the disk, and what lies behind it is the next line's, as far as that came. */
    s->tail.no_newline = true;
    line.bytes = whole;
    s->tail.good_bytes = offset + (int64_t)whole;
    return good_line(s, &line);
}

int ttf_lines_scan(struct ttf_io *io, const char *path, ttf_line_fn *fn, ttf_bad_line_fn *bad,
                   void *ctx, struct ttf_lines_tail *ret, struct ttf_err *err)
{
    struct scan s = {.io = io, .path = path, .fn = fn, .bad = bad, .ctx = ctx, .err = err};
    struct ttf_lines lines;
    const char *text;
    bool terminated;
    int64_t offset;
    size_t n;
    int file, r = 0;

    file = io->ops->open(io, path, TTF_IO_READ);
    if (file < 0)
        return ttf_err_set(err, file, path, "cannot be opened: %s", strerrordesc_np(-file));
    s.file = file;
    ttf_lines_init(&lines, io, file);
    while (!s.at_end && (r = ttf_lines_next(&lines, &text, &n, &offset, &terminated)) > 0) {
        r = one_line(&s, text, n, offset, lines.number, terminated);
        if (r)
            break;
    }
    if (r == -EFBIG)
        r = damage(&s, path, NULL, "a line is longer than any line may be");
    else if (r < 0 && (!err || err->code != r)) /* not told yet: err may be of a call before */
        ttf_err_set(err, r, path, "cannot be read: %s", strerrordesc_np(-r));
    ttf_lines_free(&lines);
    io->ops->close(io, file);
    if (r == 0 && ret)
        *ret = s.tail;
    return r;
}
