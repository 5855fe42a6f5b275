/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/notes.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

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

/* Of one note that is being added. */
struct adding {
    struct ttf_io *io;
    const char *path, *line;
    char *notes, *fresh;
    int guard, old, file; /* -1: none */
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

/*
 * As a new file that takes the old one's place, for each note: after a sync that failed, of this note or of anybody's before it, nobody knows
 * which bytes and names that are seen are on the disk, and what stands behind a hole is lost with it (DESIGN.md, "Notes").
 */
static int write_fresh(struct adding *a)
{
    struct ttf_io *io = a->io;
    int64_t bytes, now = 0;
    int r = io->ops->unlink(io, a->fresh); /* of one that was cut off */

    if (r && r != -ENOENT)
        return r;
    a->file = io->ops->open(io, a->fresh, TTF_IO_CREATE_NEW);
    if (a->file < 0)
        return a->file;
    bytes = fill(a);
    r = bytes < 0 ? (int)bytes : io->ops->sync(io, a->file, false);
    if (r == 0 && a->old >= 0)
        r = io->ops->size(io, a->old, &now);
    if (r == 0 && a->old >= 0 && now != bytes) /* somebody's own tool, which knows of no lock */
        r = -EAGAIN;
    if (r == 0)
        r = io->ops->rename(io, a->fresh, a->notes);
    if (r)
        (void)io->ops->unlink(io, a->fresh);
    return r ? r : io->ops->sync_dir(io, a->path);
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

static int add(struct adding *a, struct ttf_err *err)
{
    int r = lock(a, err);

    if (r)
        return r;
    a->notes = ttf_path_format("%s/notes.jsonl", a->path);
    a->fresh = ttf_path_format("%s/.notes-new", a->path);
    if (!a->notes || !a->fresh)
        return ttf_err_set(err, -ENOMEM, a->path, "no memory");
    a->old = a->io->ops->open(a->io, a->notes, TTF_IO_READ);
    r = a->old < 0 && a->old != -ENOENT ? a->old : write_fresh(a);
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
