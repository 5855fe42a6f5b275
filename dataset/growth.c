/* SPDX-License-Identifier: Apache-2.0 */
/* growth.c: the lines that are new. */
#include "ttf/dataset/growth.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "lines.h"
#include "record_line.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/json_parse.h"

struct reading {
    const char *path;
    struct ttf_growth *growth;
    ttf_growth_fn *fn;
    void *ctx;
    struct ttf_err *err;
};

/* Is it the file that was read so far, with all that was read still in it? */
static int look(struct ttf_io *io, const char *path, int file, struct ttf_growth *growth)
{
    char mark[TTF_GROWTH_MARK];
    struct ttf_io_stat st;
    int64_t bytes = 0;
    int r = io->ops->stat(io, path, &st);

    if (r == 0)
        r = io->ops->size(io, file, &bytes);
    if (r < 0)
        return r;
    if (growth->bytes == 0) {
        growth->inode = st.inode;
        return 0;
    }
    if (st.inode != growth->inode || bytes < growth->bytes)
        return -ESTALE;
    bytes = ttf_io_pread_all(io, file, mark, growth->n_mark, growth->bytes - growth->n_mark);
    if (bytes < 0)
        return (int)bytes;
    return bytes == growth->n_mark && memcmp(mark, growth->mark, growth->n_mark) == 0 ? 0 : -ESTALE;
}

/* The line was given: so far, with its newline. */
static void passed(struct ttf_growth *growth, const char *text, size_t n)
{
    size_t kept = n < TTF_GROWTH_MARK - 1 ? n : TTF_GROWTH_MARK - 1;

    memcpy(growth->mark, text + n - kept, kept);
    growth->mark[kept] = '\n';
    growth->n_mark = (unsigned)kept + 1;
    growth->bytes += (int64_t)n + 1;
}

static int give(struct reading *s, const char *text, size_t n)
{
    struct ttf_growth_line line;
    char where[300];
    int r;

    line.json = NULL;
    r = ttf_line_holds(text, n) ? ttf_json_parse(text, n, &line.json, NULL) : -EINVAL;
    if (r == -ENOMEM)
        return ttf_err_set(s->err, r, s->path, "no memory");
    line.type = r == 0 ? json_string_value(json_object_get(line.json, "type")) : NULL;
    if (!line.type) {
        json_decref(line.json);
        s->growth->damaged++;
        return 0;
    }
    (void)snprintf(where, sizeof where, "%s: byte %lld", s->path, (long long)s->growth->bytes);
    line.where = where;
    r = s->fn(s->ctx, &line, s->err);
    json_decref(line.json);
    s->growth->lines += r == 0;
    return r;
}

static int read_lines(struct reading *s, struct ttf_lines *lines, int64_t end)
{
    const char *text;
    bool terminated;
    int64_t offset;
    size_t n;
    int r;

    while ((r = ttf_lines_next(lines, &text, &n, &offset, &terminated)) > 0 && terminated) {
        r = give(s, text, n);
        if (r)
            return r;
        passed(s->growth, text, n);
        if (s->growth->bytes >= end)
            return 1;
    }
    return r < 0 ? ttf_err_set(s->err, r, s->path, "cannot be read: %s", strerrordesc_np(-r)) : 0;
}

int ttf_growth_read(struct ttf_io *io, const char *path, struct ttf_growth *growth,
                    int64_t max_bytes, ttf_growth_fn *fn, void *ctx, struct ttf_err *err)
{
    struct reading s = {path, growth, fn, ctx, err};
    struct ttf_lines lines;
    int file = io->ops->open(io, path, TTF_IO_READ);
    int r;

    if (file < 0)
        return ttf_err_set(err, file, path, "cannot be opened: %s", strerrordesc_np(-file));
    r = look(io, path, file, growth);
    if (r == -ESTALE)
        ttf_err_set(err, r, path, "is not what it was when it was read last");
    else if (r < 0)
        ttf_err_set(err, r, path, "cannot be read: %s", strerrordesc_np(-r));
    if (r == 0) {
        ttf_lines_init(&lines, io, file);
        lines.base = growth->bytes;
        r = read_lines(&s, &lines, max_bytes > 0 ? growth->bytes + max_bytes : INT64_MAX);
        ttf_lines_free(&lines);
    }
    io->ops->close(io, file);
    return r;
}

static struct ttf_line as_line(const struct ttf_growth_line *line)
{
    return (struct ttf_line){.where = line->where, .type = line->type, .json = line->json};
}

int ttf_growth_slot(const struct ttf_growth_line *line, struct ttf_slot_record *ret,
                    struct ttf_err *err)
{
    const struct ttf_line l = as_line(line);

    return ttf_slot_get(&l, ret, err);
}

int ttf_growth_segment(const struct ttf_growth_line *line, struct ttf_segment *ret,
                       struct ttf_err *err)
{
    const struct ttf_line l = as_line(line);

    return ttf_segment_get(&l, ret, err);
}

/* ---- which dataset ---- */

struct newest {
    struct ttf_io *io;
    const char *folder;
    int64_t mtime_ns; /* of records.jsonl; 0: none yet */
    char name[65];
    int64_t before_ns; /* older than this one, or as old and of a later name: an order of all */
    char before[65];
};

static int look_at(void *ctx, const char *name, bool is_dir)
{
    struct newest *newest = ctx;
    struct ttf_io_stat st;
    char path[4300];

    if (!is_dir || name[0] == '.' || !ttf_name_ok(name))
        return 0;
    (void)snprintf(path, sizeof path, "%s/%s/records.jsonl", newest->folder, name);
    if (newest->io->ops->stat(newest->io, path, &st) < 0 || !st.is_regular)
        return 0;
    if (st.mtime_ns > newest->before_ns ||
        (st.mtime_ns == newest->before_ns && strcmp(name, newest->before) <= 0))
        return 0;
    if (st.mtime_ns > newest->mtime_ns ||
        (st.mtime_ns == newest->mtime_ns && strcmp(name, newest->name) < 0)) {
        newest->mtime_ns = st.mtime_ns;
        (void)snprintf(newest->name, sizeof newest->name, "%s", name);
    }
    return 0;
}

int ttf_growth_nth_newest(struct ttf_io *io, const char *folder, unsigned n, char ret_name[65])
{
    struct newest newest = {.io = io, .folder = folder, .before_ns = INT64_MAX};
    int r;

    for (unsigned i = 0;; i++) {
        r = io->ops->list(io, folder, look_at, &newest);
        if (r == 0 && newest.mtime_ns == 0)
            r = -ENOENT;
        if (r < 0 || i == n)
            break;
        newest.before_ns = newest.mtime_ns;
        memcpy(newest.before, newest.name, sizeof newest.before);
        newest.mtime_ns = 0;
    }
    if (r == 0)
        memcpy(ret_name, newest.name, sizeof newest.name);
    return r;
}

int ttf_growth_newest(struct ttf_io *io, const char *folder, char ret_name[65])
{
    return ttf_growth_nth_newest(io, folder, 0, ret_name);
}
