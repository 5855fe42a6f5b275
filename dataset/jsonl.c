/* SPDX-License-Identifier: Apache-2.0 */
#include "jsonl.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"

int ttf_jsonl_open(struct ttf_jsonl *f, struct ttf_io *io, const char *path,
                   const struct ttf_lines_tail *tail, struct ttf_err *err)
{
    *f = (struct ttf_jsonl){.io = io, .file = -1};
    ttf_json_init(&f->json, false);
    f->path = strdup(path);
    if (!f->path)
        return ttf_err_set(err, -ENOMEM, path, "no memory");
    f->bytes = tail->good_bytes;
    f->next_seq = tail->next_seq;
    f->no_newline = tail->no_newline;
    f->file = io->ops->open(io, path, TTF_IO_APPEND);
    if (f->file < 0)
        return ttf_err_set(err, f->file, path, "cannot be opened: %s", strerrordesc_np(-f->file));
    return 0;
}

/*
 * After a failed write or sync nobody knows which bytes of the file are on the
 * disk, and a second sync of it may wrongly succeed. So all of it is written
 * again as a new file under a temporary name, which then takes its place.
 */
static int write_anew(struct ttf_jsonl *f, const char *text, size_t n)
{
    char *temporary = ttf_path_format("%s.tmp", f->path);
    int file = -1, r = -ENOMEM;

    if (!temporary)
        return r;
    r = f->io->ops->unlink(f->io, temporary);
    if (r == -ENOENT || r == 0)
        r = file = f->io->ops->open(f->io, temporary, TTF_IO_CREATE_NEW);
    if (r < 0)
        goto out;
    r = ttf_io_copy_bytes(f->io, f->file, file, f->bytes);
    if (r == 0)
        r = ttf_io_append_all(f->io, file, text, n);
    if (r == 0)
        r = f->io->ops->sync(f->io, file, false);
    if (r == 0)
        r = f->io->ops->rename(f->io, temporary, f->path);
    if (r) {
        f->io->ops->close(f->io, file);
        f->io->ops->unlink(f->io, temporary);
        goto out;
    }
    f->io->ops->close(f->io, f->file);
    f->file = file;
    r = ttf_io_sync_parent(f->io, f->path);
out:
    free(temporary);
    return r;
}

/* Appends text behind the good lines and syncs, or leaves them as they were. */
static int put(struct ttf_jsonl *f, const char *text, size_t n)
{
    int r, back;

    r = ttf_io_append_all(f->io, f->file, text, n);
    if (r == -ENOSPC || r == -EDQUOT || r == -EROFS) {
        back = f->io->ops->truncate(f->io, f->file, f->bytes);
        if (back) /* a piece of a line stays at the end: only opening anew can repair it */
            f->broken = r;
        return r;
    }
    if (r == 0)
        r = f->io->ops->sync(f->io, f->file, true);
    if (r == 0)
        return 0;
    back = write_anew(f, text, n);
    if (back == 0)
        return 0;
    f->broken = r;
    f->doubt = true;
    /* Not acknowledged: better it is not there either. */
    if (f->io->ops->truncate(f->io, f->file, f->bytes) == 0)
        (void)f->io->ops->sync(f->io, f->file, true);
    return r;
}

int ttf_jsonl_renew(struct ttf_jsonl *f, struct ttf_err *err)
{
    int r = write_anew(f, "", 0);

    return r ? ttf_err_set(err, r, f->path, "cannot be written anew: %s", strerrordesc_np(-r)) : 0;
}

/* Whatever was written of one that failed goes again: the next line brings its own. */
static int append_newline(struct ttf_jsonl *f)
{
    int r = ttf_io_append_all(f->io, f->file, "\n", 1);

    if (r == 0)
        f->bytes++;
    else if (f->io->ops->truncate(f->io, f->file, f->bytes) != 0)
        f->broken = r;
    return r;
}

int ttf_jsonl_reserve(struct ttf_jsonl *f, size_t bytes)
{
    return ttf_json_reserve(&f->json, bytes + 1); /* and a newline that may be owed */
}

struct ttf_json *ttf_jsonl_begin(struct ttf_jsonl *f, const char *type)
{
    ttf_line_again(&f->json, type, f->next_seq);
    return &f->json;
}

/* The newline that the last line is owed, before this one. */
static int put_newline_first(struct ttf_json *json, const char **text, size_t *n)
{
    int r = ttf_json_reserve(json, *n + 1);

    if (r)
        return r;
    memmove(json->text + 1, json->text, *n + 1);
    json->text[0] = '\n';
    *text = json->text;
    (*n)++;
    return 0;
}

/*
 * What is appended to a file that nobody finds any more (its folder was removed, or its disk taken away from under it) is
 * synced like any other, and lost. Asked after the sync: a line that is acknowledged was to be found then.
 */
static bool is_gone(const struct ttf_jsonl *f)
{
    struct ttf_io_stat st;
    int r = f->io->ops->stat(f->io, f->path, &st);

    return r == -ENOENT || r == -ENOTDIR;
}

/* Images of the line's slot lie elsewhere by now, if anywhere: where the disk comes back, the line is not on it. */
static int refuse_gone(struct ttf_jsonl *f, struct ttf_err *err)
{
    f->broken = -EIO;
    if (f->io->ops->truncate(f->io, f->file, f->bytes) == 0)
        (void)f->io->ops->sync(f->io, f->file, true);
    ttf_err_set(err, f->broken, f->path, "is not there any more");
    ttf_err_hint(err, "its folder was removed, or its disk was taken away");
    return f->broken;
}

int ttf_jsonl_append(struct ttf_jsonl *f, struct ttf_err *err)
{
    const char *text;
    size_t n;
    int r;

    r = ttf_line_finish(&f->json, &text, &n);
    if (r)
        return ttf_err_set(err, r, f->path, "a line cannot be put into words: %s",
                           strerrordesc_np(-r));
    if (f->broken)
        return ttf_err_set(err, f->broken, f->path,
                           "an earlier write failed; nothing more is written");
    if (f->no_newline) {
        r = put_newline_first(&f->json, &text, &n);
        if (r)
            return ttf_err_set(err, r, f->path, "no memory");
    }
    r = put(f, text, n);
    if (r == 0 && is_gone(f))
        return refuse_gone(f, err);
    if (r)
        return ttf_err_set(err, r, f->path, "a line cannot be written: %s", strerrordesc_np(-r));
    f->bytes += (int64_t)n;
    f->next_seq++;
    /*
     * The line is on the disk. Only now its newline, which the next sync takes
     * along: so a line that has one is whole, whatever order blocks reach the disk in.
     */
    f->no_newline = append_newline(f) != 0;
    return 0;
}

int ttf_jsonl_sync_last(struct ttf_jsonl *f, struct ttf_err *err)
{
    int r = f->no_newline ? f->io->ops->sync(f->io, f->file, true) : 0;

    if (r == 0)
        return 0;
    f->doubt = true;
    return ttf_err_set(err, r, f->path, "cannot be synced to the disk: %s", strerrordesc_np(-r));
}

int ttf_jsonl_settle(struct ttf_jsonl *f, struct ttf_err *err)
{
    int r = f->broken;

    if (r == 0 && f->no_newline) {
        r = append_newline(f); /* where that fails, the next line brings it */
        f->no_newline = r != 0;
    }
    if (r == 0) {
        r = f->io->ops->sync(f->io, f->file, true);
        /* Its newline may be gone while it is still seen: whoever opens next would build on it. */
        if (r && write_anew(f, "", 0) == 0)
            return 0;
        if (r) {
            f->doubt = true;
            f->broken = r;
        }
    }
    return r ? ttf_err_set(err, r, f->path, "cannot be written: %s", strerrordesc_np(-r)) : 0;
}

void ttf_jsonl_close(struct ttf_jsonl *f)
{
    if (f->file >= 0)
        f->io->ops->close(f->io, f->file);
    f->file = -1;
    ttf_json_free(&f->json);
    free(f->path);
    f->path = NULL;
}
