/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/notes.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "people_file.h"
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

/* What was noted so far, each line of it ended, and the line. */
static int fill(void *ctx, struct ttf_io *io, int old, int64_t bytes, int file, struct ttf_err *err)
{
    const char *line = ctx;
    char last = '\n';
    int64_t n;
    int r = 0;

    (void)err;
    if (bytes > 0) {
        r = ttf_io_copy_bytes(io, old, file, bytes);
        n = r ? 1 : ttf_io_pread_all(io, old, &last, 1, bytes - 1);
        if (n != 1)
            r = n < 0 ? (int)n : -EIO;
    }
    if (r == 0 && last != '\n') /* a crash of somebody who appends left a piece */
        r = ttf_io_append_all(io, file, "\n", 1);
    if (r == 0)
        r = ttf_io_append_all(io, file, line, strlen(line));
    if (r == 0)
        r = ttf_io_append_all(io, file, "\n", 1);
    return r;
}

int ttf_note_append(struct ttf_io *io, const char *path, const struct ttf_note *note,
                    struct ttf_err *err)
{
    static const struct ttf_people_file notes = {
        .name = "notes.jsonl", .fresh = ".notes-new", .addition = "the note", .fill = fill};
    struct ttf_json json;
    char *line = NULL;
    int r = ttf_note_check(note, err);

    if (r < 0)
        return r;
    ttf_json_init(&json, false);
    put_note(&json, note);
    r = ttf_json_take(&json, &line, NULL);
    r = r ? ttf_err_set(err, r, path, "a note cannot be put into words: %s", strerrordesc_np(-r))
          : ttf_people_file_replace(io, path, &notes, line, err);
    free(line);
    return r;
}
