/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/notes.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "io_path.h"
#include "ttf/base/time.h"
#include "ttf/dataset/json_writer.h"

int ttf_note_check(const struct ttf_note *note, struct ttf_err *err)
{
    if (note->text[0] == '\0' && note->n_tags == 0)
        return ttf_err_set(err, -EINVAL, "text", "a note needs a text or a tag");
    if (note->n_slots > TTF_NOTE_SLOTS_MAX)
        return ttf_err_set(err, -EINVAL, "slots", "more than %d ranges", TTF_NOTE_SLOTS_MAX);
    if (note->n_tags > TTF_NOTE_TAGS_MAX)
        return ttf_err_set(err, -EINVAL, "tags", "more than %d tags", TTF_NOTE_TAGS_MAX);
    for (unsigned i = 0; i < note->n_slots; i++)
        if (note->slots[i][0] < 0 || note->slots[i][1] < note->slots[i][0])
            return ttf_err_set(err, -EINVAL, "slots", "%lld-%lld is no range of slots",
                               (long long)note->slots[i][0], (long long)note->slots[i][1]);
    for (unsigned i = 0; i < note->n_tags; i++)
        if (note->tags[i][0] == '\0' || strpbrk(note->tags[i], " \t\r\n,\"\\"))
            return ttf_err_set(err, -EINVAL, "tags",
                               "'%s' is no word: neither empty nor with blanks, commas or quotes",
                               note->tags[i]);
    return 0;
}

static void put_note(struct ttf_json *j, const struct ttf_note *note)
{
    ttf_json_object(j);
    if (note->utc_ns != TTF_NS_UNKNOWN)
        ttf_json_kint(j, "utc_ns", note->utc_ns);
    if (note->author[0])
        ttf_json_kstring(j, "author", note->author);
    if (note->n_slots > 0) {
        ttf_json_key(j, "slots");
        ttf_json_array(j);
        for (unsigned i = 0; i < note->n_slots; i++) {
            ttf_json_array(j);
            ttf_json_int(j, note->slots[i][0]);
            ttf_json_int(j, note->slots[i][1]);
            ttf_json_array_end(j);
        }
        ttf_json_array_end(j);
    }
    if (note->text[0])
        ttf_json_kstring(j, "text", note->text);
    if (note->n_tags > 0) {
        ttf_json_key(j, "tags");
        ttf_json_array(j);
        for (unsigned i = 0; i < note->n_tags; i++)
            ttf_json_string(j, note->tags[i]);
        ttf_json_array_end(j);
    }
    ttf_json_object_end(j);
}

/* ---- writing ---- */

#define FRESH ".notes-new" /* and more: each adder's own */

/* Of one note that is being added. */
struct adding {
    struct ttf_io *io;
    const char *path, *line;
    char *notes, *fresh;
    int guard, old, file; /* -1: none */
    bool there;           /* notes.jsonl, and what its name stood for before it was opened */
    struct ttf_io_stat was;
};

/* What was noted so far, each line of it ended, and the line. Returns the size of what was noted, or a negative errno. */
static int64_t fill(struct adding *a)
{
    struct ttf_io *io = a->io;
    int64_t bytes = 0, n;
    char last = '\n';
    int r = a->old < 0 ? 0 : io->ops->size(io, a->old, &bytes);

    if (r == 0 && bytes > 0) {
        r = ttf_io_copy_bytes(io, a->old, a->file, bytes);
        n = r ? 1 : ttf_io_pread_all(io, a->old, &last, 1, bytes - 1);
        if (n != 1)
            r = n < 0 ? (int)n : -EIO;
    }
    if (r == 0 && last != '\n') /* a crash of somebody who appends left a piece */
        r = ttf_io_append_all(io, a->file, "\n", 1);
    if (r == 0)
        r = ttf_io_append_all(io, a->file, a->line, strlen(a->line));
    if (r == 0)
        r = ttf_io_append_all(io, a->file, "\n", 1);
    return r ? r : bytes;
}

/* By its name: a tool that takes no lock may have appended, made one, or put another in its place. */
static int still_as_it_was(const struct adding *a, int64_t bytes)
{
    struct ttf_io_stat now = {0}; /* not every table knows all of it */
    int r = a->io->ops->stat(a->io, a->notes, &now);

    if (r == -ENOENT)
        return a->there ? -EAGAIN : 0;
    if (r)
        return r;
    if (!a->there || now.device != a->was.device || now.inode != a->was.inode)
        return -EAGAIN;
    return now.bytes != bytes || now.mtime_ns != a->was.mtime_ns ? -EAGAIN : 0;
}

/*
 * As a new file that takes the old one's place, for each note: after a sync that failed, of this note or of anybody's before it, nobody knows
 * which bytes and names that are seen are on the disk, and what stands behind a hole is lost with it (DESIGN.md, "Notes").
 */
static int write_fresh(struct adding *a)
{
    struct ttf_io *io = a->io;
    int64_t bytes;
    int r;

    a->file = io->ops->open(io, a->fresh, TTF_IO_CREATE_NEW);
    if (a->file < 0)
        return a->file;
    r = ttf_io_inherit(io, a->file, a->notes);
    bytes = r ? r : fill(a);
    r = bytes < 0 ? (int)bytes : io->ops->sync(io, a->file, false);
    if (r == 0)
        r = still_as_it_was(a, bytes);
    if (r == 0)
        r = io->ops->rename(io, a->fresh, a->notes);
    if (r == -ENOENT) /* another one's remove_leftovers */
        r = -EAGAIN;
    if (r)
        (void)io->ops->unlink(io, a->fresh);
    return r ? r : io->ops->sync_dir(io, a->path);
}

static int take_leftover(void *ctx, const char *name, bool is_dir)
{
    int r;

    (void)is_dir;
    if (strncmp(name, FRESH, strlen(FRESH)) != 0)
        return 0;
    r = ttf_path_put(ctx, "%s", name);
    return r ? r : 1;
}

/*
 * Of those that were cut off. Where the lock guards nothing, one may be somebody's who is writing it: he finds it gone when he renames it, and
 * tries again, as its name is his alone.
 */
static int remove_leftovers(const struct adding *a)
{
    char name[TTF_PATH_MAX], path[TTF_PATH_MAX];
    int r;

    while ((r = a->io->ops->list(a->io, a->path, take_leftover, name)) > 0) {
        r = ttf_path_put(path, "%s/%s", a->path, name);
        if (r == 0)
            r = a->io->ops->unlink(a->io, path);
        if (r && r != -ENOENT)
            return r;
    }
    return r;
}

/* The lock is of dataset.json, which is there before any note and is never replaced; the folder's is the writer's. */
static int lock(struct adding *a, struct ttf_err *err)
{
    char *manifest = ttf_path_format("%s/dataset.json", a->path);
    int r = -ENOMEM;

    if (manifest)
        r = a->guard = a->io->ops->open(a->io, manifest, TTF_IO_READ);
    free(manifest);
    if (r == -ENOMEM)
        return ttf_err_set(err, r, a->path, "no memory");
    if (r == -ENOENT)
        return ttf_err_set(err, r, a->path, "is no dataset");
    if (r < 0)
        return ttf_err_set(err, r, a->path, "cannot be read: %s", strerrordesc_np(-r));
    r = ttf_io_lock(a->io, a->guard);
    if (r == -EAGAIN)
        ttf_err_set(err, r, a->path, "another note is being written: try again");
    else if (r)
        ttf_err_set(err, r, a->path, "cannot be locked: %s", strerrordesc_np(-r));
    return r;
}

/* No name that another adder has or had, on this machine or on another: what is renamed is whole, and his own. */
static int name_files(struct adding *a)
{
    unsigned long long random;

    if (getrandom(&random, sizeof(random), 0) != (ssize_t)sizeof(random))
        return -EIO;
    a->notes = ttf_path_format("%s/notes.jsonl", a->path);
    a->fresh = ttf_path_format("%s/" FRESH "-%016llx", a->path, random);
    return a->notes && a->fresh ? 0 : -ENOMEM;
}

static int open_old(struct adding *a)
{
    int r = a->io->ops->stat(a->io, a->notes, &a->was);

    a->there = r == 0;
    if (r)
        return r == -ENOENT ? 0 : r;
    a->old = a->io->ops->open(a->io, a->notes, TTF_IO_READ);
    if (a->old == -ENOENT)
        return -EAGAIN;
    return a->old < 0 ? a->old : 0;
}

static int add(struct adding *a, struct ttf_err *err)
{
    int r = lock(a, err);

    if (r)
        return r;
    r = name_files(a);
    if (r == -ENOMEM)
        return ttf_err_set(err, r, a->path, "no memory");
    if (r == 0)
        r = remove_leftovers(a);
    if (r == 0)
        r = open_old(a);
    if (r == 0)
        r = write_fresh(a);
    if (r == -EAGAIN)
        return ttf_err_set(err, r, a->notes, "something else has written it meanwhile: try again");
    if (r == -ELOOP)
        return ttf_err_set(err, r, a->notes, "is a link, whose place a note would take");
    return r ? ttf_err_set(err, r, a->notes, "the note cannot be written: %s", strerrordesc_np(-r))
             : 0;
}

static void done(struct adding *a)
{
    const int files[] = {a->file, a->old, a->guard}; /* the lock last */

    for (unsigned i = 0; i < 3; i++)
        if (files[i] >= 0)
            (void)a->io->ops->close(a->io, files[i]);
    free(a->notes);
    free(a->fresh);
}

int ttf_note_append(struct ttf_io *io, const char *path, const struct ttf_note *note,
                    struct ttf_err *err)
{
    struct adding a = {.io = io, .path = path, .guard = -1, .old = -1, .file = -1};
    struct ttf_json json;
    int r = ttf_note_check(note, err);

    if (r < 0)
        return r;
    ttf_json_init(&json, false);
    put_note(&json, note);
    r = ttf_json_finish(&json, &a.line, NULL);
    r = r ? ttf_err_set(err, r, path, "a note cannot be put into words: %s", strerrordesc_np(-r))
          : add(&a, err);
    done(&a);
    ttf_json_free(&json);
    return r;
}
