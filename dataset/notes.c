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

/* Whether the file's last line was ended: 1; 0; negative errno. */
static int ends_in_newline(struct ttf_io *io, int file)
{
    char last = '\n';
    int64_t bytes = 0;
    int r = io->ops->size(io, file, &bytes);

    if (r == 0 && bytes > 0) {
        int64_t n = ttf_io_pread_all(io, file, &last, 1, bytes - 1);

        r = n < 0 ? (int)n : (n == 1 ? 0 : -EIO);
    }
    return r < 0 ? r : last == '\n';
}

/* The line with its LF, and one before it if the last line never got its own. */
static int append_line(struct ttf_io *io, const char *path, const char *line)
{
    int file = io->ops->open(io, path, TTF_IO_APPEND);
    char *whole;
    int r, ended;

    if (file < 0)
        return file;
    ended = ends_in_newline(io, file);
    whole = ended < 0 ? NULL : ttf_path_format("%s%s\n", ended ? "" : "\n", line);
    r = ended < 0 ? ended : (whole ? ttf_io_append_all(io, file, whole, strlen(whole)) : -ENOMEM);
    if (r == 0)
        r = io->ops->sync(io, file, false);
    free(whole);
    (void)io->ops->close(io, file);
    return r;
}

int ttf_note_append(struct ttf_io *io, const char *path, const struct ttf_note *note,
                    struct ttf_err *err)
{
    char *manifest = ttf_path_format("%s/dataset.json", path);
    char *notes = ttf_path_format("%s/notes.jsonl", path);
    struct ttf_io_stat st;
    struct ttf_json json;
    const char *line;
    int r = ttf_note_check(note, err);

    ttf_json_init(&json, false);
    if (r < 0)
        goto out;
    if (!manifest || !notes) {
        r = ttf_err_set(err, -ENOMEM, path, "no memory");
        goto out;
    }
    r = io->ops->stat(io, manifest, &st);
    if (r < 0) {
        ttf_err_set(err, r, path, "is no dataset");
        goto out;
    }
    put_note(&json, note);
    r = ttf_json_finish(&json, &line, NULL);
    if (r == 0)
        r = append_line(io, notes, line);
    if (r == 0)
        r = io->ops->sync_dir(io, path);
    if (r < 0)
        ttf_err_set(err, r, notes, "the note cannot be written: %s", strerrordesc_np(-r));
out:
    ttf_json_free(&json);
    free(manifest);
    free(notes);
    return r;
}
