/* SPDX-License-Identifier: Apache-2.0 */
#include "info_people.h"

#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>

#include "ttf/base/time.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/samples.h"

/* "slots 3-5,9", "" of the whole. */
static const char *slots_text(const struct ttf_note *note, char *buf, size_t size)
{
    size_t n = 0;

    buf[0] = '\0';
    for (unsigned i = 0; i < note->n_slots && n < size; i++) {
        const int64_t *range = note->slots[i];

        n += (size_t)snprintf(buf + n, size - n, "%s%" PRId64, i ? "," : "slots ", range[0]);
        if (range[1] != range[0] && n < size)
            n += (size_t)snprintf(buf + n, size - n, "-%" PRId64, range[1]);
    }
    return buf;
}

static const char *tags_text(const struct ttf_note *note, char *buf, size_t size)
{
    size_t n = 0;

    buf[0] = '\0';
    for (unsigned i = 0; i < note->n_tags && n < size; i++)
        n += (size_t)snprintf(buf + n, size - n, "%s%s", i ? ", " : "[", note->tags[i]);
    if (note->n_tags && n < size)
        (void)snprintf(buf + n, size - n, "]");
    return buf;
}

static void put_note(struct ttf_json *j, const struct ttf_note *note)
{
    ttf_json_object(j);
    if (note->utc_ns != TTF_NS_UNKNOWN)
        ttf_json_kint(j, "utc_ns", note->utc_ns);
    if (*note->author)
        ttf_json_kstring(j, "author", note->author);
    ttf_json_key(j, "slots");
    ttf_json_array(j);
    for (unsigned i = 0; i < note->n_slots; i++) {
        ttf_json_array(j);
        ttf_json_int(j, note->slots[i][0]);
        ttf_json_int(j, note->slots[i][1]);
        ttf_json_array_end(j);
    }
    ttf_json_array_end(j);
    ttf_json_kstring(j, "text", note->text);
    ttf_json_key(j, "tags");
    ttf_json_array(j);
    for (unsigned i = 0; i < note->n_tags; i++)
        ttf_json_string(j, note->tags[i]);
    ttf_json_array_end(j);
    ttf_json_object_end(j);
}

static void on_note(void *ctx, const struct ttf_note *note)
{
    struct cli *cli = ctx;
    char slots[256], tags[320];

    cli_say(cli, "note              %s%s%s%s%s%s%s", slots_text(note, slots, sizeof slots),
            note->n_slots ? ": " : "", note->text, *note->text && note->n_tags ? " " : "",
            tags_text(note, tags, sizeof tags), *note->author ? " -- " : "", note->author);
    put_note(&cli->out, note);
}

static void on_wrong(void *ctx, int64_t line, const char *what)
{
    (void)ctx;
    cli_warn("notes.jsonl:%" PRId64 " is not understood: %s", line, what);
}

static void say_samples(struct cli *cli, const struct ttf_sample_region *regions, unsigned n)
{
    struct ttf_json *j = &cli->out;

    ttf_json_key(j, "samples");
    ttf_json_array(j);
    for (unsigned i = 0; i < n; i++) {
        const struct ttf_sample_region *s = &regions[i];

        cli_say(cli, "sample %-10s %" PRId64 " x %" PRId64 " at %" PRId64 ", %" PRId64 "%s%s%s%s",
                s->id, s->region.width, s->region.height, s->region.x, s->region.y,
                *s->title ? ", " : "", s->title, *s->treatment ? ", " : "", s->treatment);
        ttf_json_object(j);
        ttf_json_kstring(j, "id", s->id);
        ttf_json_kstring(j, "title", s->title);
        ttf_json_kstring(j, "treatment", s->treatment);
        ttf_json_kint(j, "x", s->region.x);
        ttf_json_kint(j, "y", s->region.y);
        ttf_json_kint(j, "width", s->region.width);
        ttf_json_kint(j, "height", s->region.height);
        ttf_json_object_end(j);
    }
    ttf_json_array_end(j);
}

int cli_say_people(struct cli *cli, const char *path)
{
    const struct ttf_note_visitor visitor = {on_note, on_wrong, cli};
    struct ttf_sample_region *regions = NULL;
    unsigned n = 0;
    int r;

    ttf_json_key(&cli->out, "notes");
    ttf_json_array(&cli->out);
    r = ttf_notes_read(cli->io, path, &visitor, &cli->err);
    ttf_json_array_end(&cli->out);
    if (r < 0)
        return r;
    r = ttf_samples_read(cli->io, path, &regions, &n, &cli->err);
    if (r == -EINVAL) { /* people's own affair; it stops nothing */
        cli_warn("samples.json is not understood: %s", cli->err.what);
        cli->err = (struct ttf_err){0};
        r = 0;
    }
    say_samples(cli, regions, n);
    free(regions);
    return r;
}
