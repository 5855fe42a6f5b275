/* SPDX-License-Identifier: Apache-2.0 */
#include "grown.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "sure.h"
#include "ttf/dataset/copy.h"

#define PIECE          ((size_t)1 << 20)
#define LINE_MAX_BYTES ((size_t)17 << 20) /* the format's 16 MiB and its end */

static void remember_end(struct grown *grown, int64_t end)
{
    memmove(&grown->ends[1], &grown->ends[0], GROWN_BACK * sizeof grown->ends[0]);
    grown->ends[0] = end;
}

static int complain(const struct grown *grown, int r, const char *what, struct ttf_err *err)
{
    return ttf_err_set(err, r, grown->path, "%s: %s", what, strerrordesc_np(-r));
}

/* Gives each whole line here from a byte on, up to half a line at the end. *ret_good: where that begins. -TTF_EDAMAGED. */
static int walk(struct grown *grown, int64_t from, grown_line_fn *fn, void *ctx, int64_t *ret_good,
                struct ttf_err *err)
{
    size_t room = PIECE, n = 0;
    char *buf = malloc(room);
    int64_t at = from; /* of buf's first byte */
    int r = buf ? 0 : -ENOMEM;

    while (r == 0) {
        int64_t got = ttf_io_pread_all(grown->io, grown->file, buf + n, room - n, at + (int64_t)n);
        char *line = buf, *end;

        if (got < 0)
            r = complain(grown, (int)got, "cannot be read", err);
        if (got <= 0)
            break;
        n += (size_t)got;
        while (r == 0 && (end = memchr(line, '\n', n - (size_t)(line - buf)))) {
            if (!ttf_line_holds(line, (size_t)(end - line))) {
                r = ttf_err_set(err, -TTF_EDAMAGED, grown->path, "a line here is damaged");
                ttf_err_hint(err, "move the dataset away and pull it again");
                break;
            }
            r = fn(ctx, line, (size_t)(end - line), err);
            line = end + 1;
            *ret_good = at + (line - buf);
        }
        at += line - buf;
        n -= (size_t)(line - buf);
        memmove(buf, line, n);
        if (n == room) {
            char *more = room < LINE_MAX_BYTES ? realloc(buf, 2 * room) : NULL;

            if (!more)
                break; /* no line of the format is as long */
            buf = more;
            room *= 2;
        }
    }
    free(buf);
    if (r == -ENOMEM)
        ttf_err_set(err, r, NULL, "no memory");
    return r;
}

static int note_end(void *ctx, const char *line, size_t n, struct ttf_err *err)
{
    struct grown *grown = ctx;

    (void)line;
    (void)err;
    remember_end(grown, grown->ends[0] + (int64_t)n + 1);
    return 0;
}

int grown_open(struct grown *grown, struct ttf_err *err)
{
    int64_t good = 0, size;
    int r;

    grown->file = grown->io->ops->open(grown->io, grown->path, TTF_IO_APPEND);
    if (grown->file < 0)
        return complain(grown, grown->file, "cannot be opened", err);
    memset(grown->ends, 0, sizeof grown->ends);
    r = walk(grown, 0, note_end, grown, &good, err);
    if (r < 0)
        return r;
    grown->bytes = good;
    r = grown->io->ops->size(grown->io, grown->file, &size);
    if (r == 0 && size > good)
        r = grown->io->ops->truncate(grown->io, grown->file, good);
    return r == 0 ? 0 : complain(grown, r, "cannot be cut", err);
}

void grown_close(struct grown *grown)
{
    if (grown->file >= 0)
        (void)grown->io->ops->close(grown->io, grown->file);
    grown->file = -1;
    free(grown->piece);
    grown->piece = NULL;
    grown->piece_bytes = grown->piece_at = 0;
}

/* One line, its end included, that does not hold? */
static bool is_wrong_line(const char *text, size_t n)
{
    return n > 1 && text[n - 1] == '\n' && !memchr(text, '\n', n - 1) &&
           !ttf_line_holds(text, n - 1);
}

/* 1: the box has the same bytes there; 0: others, or none. */
static int same(struct grown *grown, int64_t first, int64_t end, struct ttf_err *err)
{
    /* The end of the line before, too: where the box has none, it is no line of its that the range holds. */
    int64_t before = first > 0 ? 1 : 0;
    size_t n = (size_t)(end - first + before), n_theirs = 0;
    char *ours = malloc(n), *theirs = NULL;
    const struct sure_known known = {ours, n};
    int r = 0;

    if (!ours)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    if (ttf_io_pread_all(grown->io, grown->file, ours, n, first - before) != (int64_t)n)
        r = ttf_err_set(err, -EIO, grown->path, "cannot be read");
    if (r == 0)
        r = sure_text(grown->wire, grown->url, first - before, end - 1, n, &known, &theirs,
                      &n_theirs, err);
    if (r == 0 && n_theirs == n && memcmp(ours, theirs, n) == 0)
        r = 1;
    else if (r == 0 && n_theirs > (size_t)before && (before == 0 || theirs[0] == '\n') &&
             is_wrong_line(theirs + before, n_theirs - (size_t)before))
        /* What a power cut takes is gone; what is there and wrong is rot, and ours is the better one. */
        r = ttf_err_set(err, -TTF_EDAMAGED, grown->url, "a line of the box's is damaged");
    else if (r == -ERANGE)
        r = 0;
    free(theirs);
    free(ours);
    return r;
}

int grown_agree(struct grown *grown, struct ttf_err *err)
{
    unsigned back = 0;
    int r = 0;

    for (; back < GROWN_BACK && grown->ends[back] > 0; back++) {
        r = same(grown, grown->ends[back + 1], grown->ends[back], err);
        if (r != 0)
            break;
    }
    if (r < 0)
        return r;
    if (r == 0 && grown->ends[back] > 0)
        return ttf_err_set(err, -EEXIST, grown->path, "is not the beginning of what the box has");
    grown->bytes = grown->ends[back];
    return 0;
}

bool grown_is_ahead(const struct grown *grown)
{
    return grown->ends[0] > grown->bytes;
}

int grown_cut(struct grown *grown, struct ttf_err *err)
{
    int r = grown->io->ops->truncate(grown->io, grown->file, grown->bytes);

    if (r == 0)
        r = grown->io->ops->sync(grown->io, grown->file, true);
    if (r < 0)
        return complain(grown, r, "cannot be cut", err);
    grown->ends[0] = grown->bytes;
    return 0;
}

int grown_each(struct grown *grown, int64_t from, grown_line_fn *fn, void *ctx, struct ttf_err *err)
{
    int64_t good = 0;

    return walk(grown, from, fn, ctx, &good, err);
}

/* More of the box's bytes behind those that are in the piece. 1; 0: there is no more; a negative errno. */
static int fill(struct grown *grown, int64_t at, size_t wanted, struct ttf_err *err)
{
    char *piece = NULL;
    size_t n = 0;
    int r = pull_wire_get_text(grown->wire, grown->url, at, at + (int64_t)wanted - 1, wanted,
                               &piece, &n, err);

    if (r == -ERANGE)
        return 0;
    if (r < 0)
        return r;
    free(grown->piece);
    grown->piece = piece;
    grown->piece_bytes = n;
    grown->piece_at = 0;
    return n > 0;
}

int grown_next(struct grown *grown, int64_t at, const char **ret, size_t *ret_n,
               struct ttf_err *err)
{
    size_t wanted = PIECE;
    bool again = false;

    for (;;) {
        const char *line = grown->piece ? grown->piece + grown->piece_at : NULL;
        size_t left = grown->piece_bytes - grown->piece_at;
        const char *end = line ? memchr(line, '\n', left) : NULL;
        int r;

        if (end && !ttf_line_holds(line, (size_t)(end - line))) {
            if (again)
                return ttf_err_set(err, -TTF_EDAMAGED, grown->url,
                                   "a line of the box's is damaged, %lld bytes in", (long long)at);
            again = true; /* it may have been the wire: asked for once more */
        } else if (end) {
            *ret = line;
            *ret_n = (size_t)(end - line);
            grown->piece_at += *ret_n + 1;
            return 1;
        }
        if (line && left >= wanted)
            wanted *= 2; /* a line longer than the piece */
        if (wanted > 2 * LINE_MAX_BYTES)
            return ttf_err_set(err, -TTF_EDAMAGED, grown->url, "a line of the box's is too long");
        r = fill(grown, at, wanted, err);
        if (r <= 0)
            return r;
        if (!memchr(grown->piece, '\n', grown->piece_bytes) && grown->piece_bytes < wanted)
            return 0; /* the end of a line is still to come */
    }
}

int grown_append(struct grown *grown, const char *lines, size_t n, struct ttf_err *err)
{
    int r = ttf_io_append_all(grown->io, grown->file, lines, n);

    if (r == 0)
        r = grown->io->ops->sync(grown->io, grown->file, true);
    if (r <
        0) { /* lines that may not be on the disk are not to pass for durable: they come again */
        (void)grown->io->ops->truncate(grown->io, grown->file, grown->bytes);
        return complain(grown, r, "cannot be written", err);
    }
    grown->bytes += (int64_t)n;
    return 0;
}
