/* SPDX-License-Identifier: Apache-2.0 */
#include "sums.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "lines.h"
#include "manifest_rules.h"
#include "named_files.h"
#include "record_line.h"

bool ttf_sums_parse(const char *line, size_t n, const char **ret_path)
{
    size_t i;

    if (n <= TTF_SUMS_PREFIX || line[64] != ' ' || line[65] != ' ' || memchr(line, '\0', n))
        return false;
    for (i = 0; i < 64; i++)
        if (!strchr("0123456789abcdef", line[i]))
            return false;
    *ret_path = line + TTF_SUMS_PREFIX;
    return true;
}

int ttf_remove(struct ttf_io *io, const char *path, struct ttf_err *err)
{
    int r = io->ops->unlink(io, path);

    if (r == 0)
        return 1;
    if (r == -ENOENT)
        return 0;
    return ttf_err_set(err, r, path, "cannot be removed: %s", strerrordesc_np(-r));
}

/* A line reader on the dataset's SHA256SUMS; *file is -1 where there is none. */
static int open_sums(struct ttf_io *io, const char *dataset, struct ttf_lines *lines, int *file,
                     struct ttf_err *err)
{
    char *path = ttf_path_format("%s/" TTF_SUMS_NAME, dataset);
    int r = 0;

    *file = -1;
    ttf_lines_init(lines, io, -1);
    if (!path)
        return ttf_err_set(err, -ENOMEM, dataset, "no memory");
    *file = io->ops->open(io, path, TTF_IO_READ);
    if (*file < 0 && *file != -ENOENT)
        r = ttf_err_set(err, *file, path, "cannot be opened: %s", strerrordesc_np(-*file));
    lines->file = *file;
    free(path);
    return r;
}

static void close_sums(struct ttf_io *io, struct ttf_lines *lines, int file)
{
    ttf_lines_free(lines);
    if (file >= 0)
        io->ops->close(io, file);
}

int ttf_sums_sealed(struct ttf_io *io, const char *dataset, bool *ret, struct ttf_err *err)
{
    static const char records[] = "records.jsonl";
    struct ttf_lines lines;
    const char *line, *path;
    bool terminated;
    int64_t offset;
    size_t n;
    int file, r;

    *ret = false;
    r = open_sums(io, dataset, &lines, &file, err);
    if (r || file < 0)
        return r;
    while (!*ret && (r = ttf_lines_next(&lines, &line, &n, &offset, &terminated)) > 0)
        *ret = ttf_sums_parse(line, n, &path) && n - TTF_SUMS_PREFIX == sizeof(records) - 1 &&
               memcmp(path, records, sizeof(records) - 1) == 0;
    close_sums(io, &lines, file);
    return r < 0 ? ttf_err_set(err, r, dataset, TTF_SUMS_NAME " cannot be read: %s",
                               strerrordesc_np(-r))
                 : 0;
}

/* ---- the running list against the records ---- */

static int compare_file(void *ctx, const struct ttf_named_file *file, struct ttf_err *err)
{
    struct ttf_sums_compare *c = ctx;
    const char *line, *path;
    bool terminated;
    int64_t offset;
    size_t n;
    int r;

    if (!file->of_image || c->differs)
        return 0;
    r = ttf_lines_next(&c->lines, &line, &n, &offset, &terminated);
    if (r < 0)
        return ttf_err_set(err, r, TTF_SUMS_NAME, "cannot be read: %s", strerrordesc_np(-r));
    c->differs = r == 0 || !terminated || !ttf_sums_parse(line, n, &path) ||
                 strlen(file->path) != n - TTF_SUMS_PREFIX ||
                 memcmp(path, file->path, n - TTF_SUMS_PREFIX) != 0 ||
                 memcmp(line, file->sha256, 64) != 0;
    return 0;
}

int ttf_sums_compare_line(struct ttf_sums_compare *c, const struct ttf_line *line,
                          struct ttf_err *err)
{
    return ttf_line_files(line, compare_file, c, err); /* also where nothing is to be compared */
}

/*
 * Bytes that did not reach the disk read as zeros. One zero in the place of a blank is a
 * flipped bit instead, unless a block of the disk ends or begins there.
 */
static bool is_hole(const char *line, size_t n, int64_t offset)
{
    const char *first = memchr(line, '\0', n);
    ptrdiff_t at = first ? first - line : -1;

    return first && (memrchr(line, '\0', n) != first || (at != 64 && at != 65) ||
                     (offset + at) % 512 == 0 || (offset + at + 1) % 512 == 0);
}

static bool some_file_has(const struct ttf_named_files *named, const char *sha256)
{
    size_t i;

    for (i = 0; i < named->n; i++)
        if (memcmp(named->items[i].sha256, sha256, 64) == 0)
            return true;
    return false;
}

/* The list's line of this file, as far as its end: the one at `line` but for one bit? */
static bool is_but_for_a_bit(const struct ttf_named *file, const char *line, size_t n)
{
    size_t bytes = TTF_SUMS_PREFIX + strlen(file->path), i;
    unsigned bits = 0;

    for (i = 0; i < bytes && i < n && bits < 2; i++)
        bits += (unsigned)__builtin_popcount(
            (unsigned char)(line[i] ^ (i < 64   ? file->sha256[i]
                                       : i < 66 ? ' '
                                                : file->path[i - 66])));
    if (n == bytes)
        return bits == 1;
    /* or, where another line follows, but for its newline */
    return n > bytes + TTF_SUMS_PREFIX && bits == 0 &&
           __builtin_popcount((unsigned char)(line[bytes] ^ '\n')) == 1;
}

/* Of a line that is none: a bit of it has changed. Bytes that did not reach the disk are more. */
static bool has_wrong_bit(const struct ttf_named_files *named, const char *line, size_t n)
{
    size_t i;

    for (i = 0; i < named->n; i++)
        if (is_but_for_a_bit(&named->items[i], line, n))
            return true;
    return false;
}

/* What one whole line of the list says that the records do not. */
static enum ttf_sums_state judge_line(const struct ttf_named_files *named, const char *line,
                                      size_t n, int64_t offset, char *path, size_t path_size)
{
    const struct ttf_named *known;
    const char *at;

    if (ttf_sums_parse(line, n, &at))
        snprintf(path, path_size, "%.*s", (int)(n - TTF_SUMS_PREFIX), at);
    if (n - TTF_SUMS_PREFIX >= path_size || !ttf_path_ok(path))
        return !is_hole(line, n, offset) && has_wrong_bit(named, line, n) ? TTF_SUMS_WRONG
                                                                          : TTF_SUMS_BEHIND;
    known = ttf_named_files_find(named, path);
    if (known && memcmp(known->sha256, line, 64) != 0)
        return TTF_SUMS_WRONG;
    if (strncmp(path, "frames/", 7) != 0 && strncmp(path, "raw/", 4) != 0)
        return some_file_has(named, line) && !known ? TTF_SUMS_WRONG : TTF_SUMS_SEAL;
    if (known)
        return TTF_SUMS_BEHIND; /* what differs is elsewhere */
    /* A path that changed, or a record that is lost: the hash tells them apart. */
    return some_file_has(named, line) ? TTF_SUMS_WRONG : TTF_SUMS_AHEAD;
}

/*
 * Where the lists differ: a whole line that no record accounts for is no work of a crash.
 * It is written behind the record, so the record was lost, or the line has changed, or it
 * is of a seal.
 */
static int find_difference(struct ttf_io *io, const char *dataset, const char *records,
                           struct ttf_sums_verdict *ret, struct ttf_err *err)
{
    struct ttf_named_files named = {0};
    enum ttf_sums_state state;
    struct ttf_lines lines;
    const char *line;
    char path[sizeof(ret->path)];
    bool terminated;
    int64_t offset;
    size_t n;
    int file = -1, r;

    *ret = (struct ttf_sums_verdict){.state = TTF_SUMS_BEHIND};
    r = ttf_named_files_load(io, records, &named, err);
    if (r)
        return r;
    r = open_sums(io, dataset, &lines, &file, err);
    lines.at_end = file < 0;
    while (r == 0 && (r = ttf_lines_next(&lines, &line, &n, &offset, &terminated)) > 0) {
        r = 0;
        path[0] = '\0';
        state =
            terminated ? judge_line(&named, line, n, offset, path, sizeof(path)) : TTF_SUMS_BEHIND;
        if (state <= ret->state)
            continue; /* the worst counts, of equals the first */
        ret->state = state;
        ret->line = lines.number;
        memcpy(ret->path, path, sizeof(path));
    }
    if (r < 0)
        ttf_err_set(err, r, TTF_SUMS_NAME, "cannot be read: %s", strerrordesc_np(-r));
    close_sums(io, &lines, file);
    ttf_named_files_free(&named);
    return r;
}

int ttf_sums_compare_begin(struct ttf_sums_compare *c, struct ttf_io *io, const char *dataset,
                           struct ttf_err *err)
{
    int r;

    *c = (struct ttf_sums_compare){.io = io, .dataset = dataset, .file = -1};
    r = open_sums(io, dataset, &c->lines, &c->file, err);
    c->lines.at_end = c->file < 0; /* none: behind if any image is named */
    return r;
}

int ttf_sums_compare_end(struct ttf_sums_compare *c, struct ttf_sums_verdict *ret,
                         struct ttf_err *err)
{
    char *records = ret ? ttf_path_format("%s/records.jsonl", c->dataset) : NULL;
    const char *line;
    bool terminated;
    int64_t offset;
    size_t n;
    int r = 0;

    if (ret && !records)
        r = ttf_err_set(err, -ENOMEM, c->dataset, "no memory");
    if (ret && r == 0) {
        *ret = (struct ttf_sums_verdict){.state = TTF_SUMS_SAME};
        if (!c->differs) { /* is there more behind? */
            r = ttf_lines_next(&c->lines, &line, &n, &offset, &terminated);
            c->differs = r > 0;
            r = r > 0 ? 0 : r;
        }
        if (r == 0 && c->differs)
            r = find_difference(c->io, c->dataset, records, ret, err);
    }
    close_sums(c->io, &c->lines, c->file);
    c->file = -1;
    free(records);
    return r;
}

static int scan_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    return ttf_sums_compare_line(ctx, line, err);
}

int ttf_sums_compare(struct ttf_io *io, const char *dataset, struct ttf_sums_verdict *ret,
                     struct ttf_err *err)
{
    struct ttf_sums_compare c;
    char *records = ttf_path_format("%s/records.jsonl", dataset);
    int r, ended;

    if (!records)
        return ttf_err_set(err, -ENOMEM, dataset, "no memory");
    r = ttf_sums_compare_begin(&c, io, dataset, err);
    if (r == 0)
        r = ttf_lines_scan(io, records, scan_line, NULL, &c, NULL, err);
    ended = ttf_sums_compare_end(&c, r == 0 ? ret : NULL, err);
    free(records);
    return r ? r : ended;
}

struct rebuild {
    struct ttf_io *io;
    int file;
    char text[16384];
    size_t used;
    int64_t n;
};

static int flush(struct rebuild *b)
{
    int r = ttf_io_append_all(b->io, b->file, b->text, b->used);

    b->used = 0;
    return r;
}

static int rebuild_file(void *ctx, const struct ttf_named_file *file, struct ttf_err *err)
{
    struct rebuild *b = ctx;
    int r;

    if (!file->of_image)
        return 0;
    if (sizeof(b->text) - b->used < 512) {
        r = flush(b);
        if (r)
            return ttf_err_set(err, r, TTF_SUMS_NAME, "cannot be written: %s", strerrordesc_np(-r));
    }
    b->used += (size_t)snprintf(b->text + b->used, sizeof(b->text) - b->used, "%s  %s\n",
                                file->sha256, file->path);
    b->n++;
    return 0;
}

static int rebuild_line(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    return ttf_line_files(line, rebuild_file, ctx, err);
}

/* Syncs what was written under the temporary name and gives it its own. */
static int put_in_place(struct rebuild *b, const char *temporary, const char *path,
                        struct ttf_err *err)
{
    int r, closed;

    r = flush(b);
    if (r == 0)
        r = b->io->ops->sync(b->io, b->file, false);
    closed = b->io->ops->close(b->io, b->file);
    b->file = -1;
    r = r ? r : closed;
    if (r == 0)
        r = b->io->ops->rename(b->io, temporary, path);
    if (r == 0)
        r = ttf_io_sync_parent(b->io, path);
    return r ? ttf_err_set(err, r, path, "cannot be written: %s", strerrordesc_np(-r)) : 0;
}

int ttf_sums_rebuild(struct ttf_io *io, const char *dataset, struct ttf_err *err)
{
    struct rebuild b = {.io = io, .file = -1};
    char *records = ttf_path_format("%s/records.jsonl", dataset);
    char *path = ttf_path_format("%s/" TTF_SUMS_NAME, dataset);
    char *temporary = ttf_path_format("%s/" TTF_SUMS_NAME ".tmp", dataset);
    int r;

    if (!records || !path || !temporary) {
        r = ttf_err_set(err, -ENOMEM, dataset, "no memory");
        goto out;
    }
    r = ttf_remove(io, temporary, err);
    if (r < 0)
        goto out;
    b.file = io->ops->open(io, temporary, TTF_IO_CREATE_NEW);
    if (b.file < 0) {
        r = ttf_err_set(err, b.file, temporary, "cannot be made: %s", strerrordesc_np(-b.file));
        goto out;
    }
    r = ttf_lines_scan(io, records, rebuild_line, NULL, &b, NULL, err);
    if (r == 0 && b.n > 0)
        r = put_in_place(&b, temporary, path, err);
    if (r == 0 && b.n == 0) { /* sha256sum would complain of an empty list */
        r = ttf_remove(io, path, err);
        if (r >= 0) { /* also if an earlier attempt removed it: was that synced? */
            r = io->ops->sync_dir(io, dataset);
            if (r)
                ttf_err_set(err, r, path, "cannot be removed for good: %s", strerrordesc_np(-r));
        }
    }
    if (b.file >= 0)
        io->ops->close(io, b.file);
    if (r || b.n == 0)
        io->ops->unlink(io, temporary);
out:
    free(temporary);
    free(path);
    free(records);
    return r < 0 ? r : 0;
}
