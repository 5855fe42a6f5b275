/* SPDX-License-Identifier: Apache-2.0 */
/* notes_read.c: notes.jsonl as people and their tools left it: read for what can be understood. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "json_read.h"
#include "lines.h"
#include "ttf/base/time.h"
#include "ttf/dataset/json_parse.h"
#include "ttf/dataset/notes.h"

bool ttf_note_is_of(const struct ttf_note *note, int64_t index)
{
    for (unsigned i = 0; i < note->n_slots; i++)
        if (index >= note->slots[i][0] && index <= note->slots[i][1])
            return true;
    return note->n_slots == 0;
}

bool ttf_note_has_tag(const struct ttf_note *note, const char *tag)
{
    for (unsigned i = 0; i < note->n_tags; i++)
        if (strcmp(note->tags[i], tag) == 0)
            return true;
    return false;
}

static void read_ranges(struct ttf_json_in *in, const json_t *root, struct ttf_note *note)
{
    const json_t *ranges = ttf_in_array(in, root, "slots", TTF_JSON_OPTIONAL);

    if (json_array_size(ranges) > TTF_NOTE_SLOTS_MAX) {
        ttf_in_wrong(in, "slots", "has more than %d ranges", TTF_NOTE_SLOTS_MAX);
        return;
    }
    for (size_t i = 0; i < json_array_size(ranges); i++) {
        const json_t *range = json_array_get(ranges, i);
        const json_t *first = json_array_get(range, 0), *last = json_array_get(range, 1);

        if (json_array_size(range) != 2 || !json_is_integer(first) || !json_is_integer(last)) {
            ttf_in_wrong(in, "slots", "must be of pairs: first, last");
            return;
        }
        note->slots[i][0] = json_integer_value(first);
        note->slots[i][1] = json_integer_value(last);
        /* Nobody means no slot at all: what was to be left out would be used. */
        if (note->slots[i][0] < 0 || note->slots[i][1] < note->slots[i][0]) {
            ttf_in_wrong(in, "slots", "has %lld to %lld, which is no slot at all",
                         (long long)note->slots[i][0], (long long)note->slots[i][1]);
            return;
        }
        note->n_slots++;
    }
}

static void read_tags(struct ttf_json_in *in, const json_t *root, struct ttf_note *note)
{
    const json_t *tags = ttf_in_array(in, root, "tags", TTF_JSON_OPTIONAL);

    if (json_array_size(tags) > TTF_NOTE_TAGS_MAX) {
        ttf_in_wrong(in, "tags", "has more than %d", TTF_NOTE_TAGS_MAX);
        return;
    }
    for (size_t i = 0; i < json_array_size(tags); i++) {
        const char *tag = json_string_value(json_array_get(tags, i));

        if (!tag) {
            ttf_in_wrong(in, "tags", "must be of texts");
            return;
        }
        ttf_text_cut(note->tags[note->n_tags++], sizeof(note->tags[0]), tag);
    }
}

/* 0, or -EINVAL with what is wrong in err, or -ENOMEM. */
static int parse_note(const char *text, size_t n, struct ttf_note *note, struct ttf_err *err)
{
    struct ttf_json_in in = {.where = "notes.jsonl", .wrong = -EINVAL, .err = err};
    json_error_t parse;
    json_t *root;
    int r = ttf_json_parse(text, n, &root, &parse);

    if (r == -ENOMEM) /* and nothing stands in parse */
        return r;
    if (r)
        return ttf_err_set(err, r, NULL, "it is not JSON: %s", parse.text);
    *note = (struct ttf_note){.utc_ns = TTF_NS_UNKNOWN};
    if (!json_is_object(root))
        ttf_in_wrong(&in, "it", "is no object");
    note->utc_ns =
        ttf_in_int(&in, root, "utc_ns", INT64_MIN, INT64_MAX, TTF_NS_UNKNOWN, TTF_JSON_OPTIONAL);
    ttf_in_text(&in, root, "author", note->author, sizeof(note->author), TTF_JSON_CUT);
    ttf_in_text(&in, root, "text", note->text, sizeof(note->text), TTF_JSON_CUT);
    read_ranges(&in, root, note);
    read_tags(&in, root, note);
    json_decref(root);
    return in.code;
}

/* Only -ENOMEM: whoever took that for a line that nobody understands would use what is to be left out. */
static int one_line(const struct ttf_note_visitor *visitor, const struct ttf_lines *lines,
                    const char *text, size_t n, bool terminated)
{
    struct ttf_note note;
    struct ttf_err why = {0};
    int code = parse_note(text, n, &note, &why);

    if (code == 0 && visitor->note)
        visitor->note(visitor->ctx, &note);
    else if (code == -EINVAL && terminated && visitor->wrong)
        visitor->wrong(visitor->ctx, lines->number, why.what);
    return code == -ENOMEM ? code : 0;
}

int ttf_notes_read(struct ttf_io *io, const char *path, const struct ttf_note_visitor *visitor,
                   struct ttf_err *err)
{
    char *notes = ttf_path_format("%s/notes.jsonl", path);
    struct ttf_lines lines;
    const char *text;
    int64_t offset;
    bool terminated;
    size_t n;
    int file = notes ? io->ops->open(io, notes, TTF_IO_READ) : -ENOMEM;
    int r = file == -ENOENT ? 0 : file;

    if (file >= 0) {
        ttf_lines_init(&lines, io, file);
        while ((r = ttf_lines_next(&lines, &text, &n, &offset, &terminated)) > 0)
            if (one_line(visitor, &lines, text, n, terminated) < 0) {
                r = -ENOMEM;
                break;
            }
        ttf_lines_free(&lines);
        (void)io->ops->close(io, file);
    }
    if (r < 0)
        ttf_err_set(err, r, notes ? notes : path, "cannot be read: %s", strerrordesc_np(-r));
    free(notes);
    return r;
}
