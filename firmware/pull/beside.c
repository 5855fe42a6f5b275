/* SPDX-License-Identifier: Apache-2.0 */
#include "beside.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "grown.h"
#include "sure.h"

#define PEOPLE_MAX ((size_t)64 << 20)
#define TEXT_BYTES ((size_t)1 << 20) /* of events, appended together */

static void tell(const struct beside *b, const char *text)
{
    b->tell(b->tell_ctx, b->result->slots, text);
}

/* ---- events ---- */

struct text {
    char *bytes;
    size_t n, room;
};

static int keep(struct text *text, const char *line, size_t n, struct ttf_err *err)
{
    if (!text->bytes || text->n + n + 1 > text->room) {
        size_t room = 2 * (text->room + n + 1);
        char *more = realloc(text->bytes, room);

        if (!more)
            return ttf_err_set(err, -ENOMEM, NULL, "no memory");
        text->bytes = more;
        text->room = room;
    }
    memcpy(text->bytes + text->n, line, n);
    text->bytes[text->n + n] = '\n';
    text->n += n + 1;
    return 0;
}

static int append(struct grown *events, struct text *text, size_t from, struct ttf_err *err)
{
    int r = 0;

    if (text->n > 0 && text->n >= from) {
        r = grown_append(events, text->bytes, text->n, err);
        text->n = 0;
    }
    return r;
}

/* What the box has beyond what is here. */
static int copy_events(struct grown *events, struct ttf_err *err)
{
    struct text text = {0};
    const char *line;
    size_t n;
    int r;

    while ((r = grown_next(events, events->bytes + (int64_t)text.n, &line, &n, err)) > 0) {
        r = keep(&text, line, n, err);
        if (r == 0)
            r = append(events, &text, TEXT_BYTES, err);
        if (r < 0)
            break;
    }
    if (r == 0)
        r = append(events, &text, 1, err);
    free(text.bytes);
    return r;
}

int beside_events(struct beside *b, struct ttf_err *err)
{
    struct ttf_io *io = b->landing->io;
    struct grown events = {.io = io, .wire = b->wire, .file = -1};
    struct ttf_io_stat st;
    bool there;
    int r;

    (void)snprintf(events.url, sizeof events.url, "/datasets/%s/files/events.jsonl",
                   b->landing->name);
    (void)snprintf(events.path, sizeof events.path, "%s/events.jsonl", b->landing->folder);
    there = io->ops->stat(io, events.path, &st) == 0;
    r = grown_open(&events, err);
    if (r == 0)
        r = grown_agree(&events, err);
    if (r == -EEXIST) { /* what happened is the box's to tell: from its beginning */
        r = 0;
        events.bytes = 0;
    }
    if (r == 0 && grown_is_ahead(&events))
        r = grown_cut(&events, err);
    if (r == 0)
        r = copy_events(&events, err);
    grown_close(&events);
    if (r == -ENOENT) { /* the box has none */
        if (!there)
            (void)io->ops->unlink(io, events.path);
        else
            tell(b, "events.jsonl is missing on the box; what is here stays");
        r = 0;
    }
    return r;
}

/* ---- people ---- */

static int pull_people(struct beside *b, const char *file, struct ttf_err *err)
{
    char url[300], path[4600], *theirs = NULL, *ours = NULL;
    struct sure_known known = {0};
    size_t n;
    int there, r;

    (void)snprintf(url, sizeof url, "/datasets/%s/files/%s", b->landing->name, file);
    (void)snprintf(path, sizeof path, "%s/%s", b->landing->folder, file);
    there = ttf_io_slurp(b->landing->io, path, PEOPLE_MAX, &ours, &known.n, NULL);
    known.bytes = ours;
    r = sure_text(b->wire, url, 0, -1, PEOPLE_MAX, &known, &theirs, &n, err);
    if (r == -ENOENT) {
        r = 0;
    } else if (r == 0 && there < 0 && there != -ENOENT) {
        r = ttf_err_set(err, there, path, "cannot be read: %s", strerrordesc_np(-there));
    } else if (r == 0 && there == 0 && (known.n > n || memcmp(ours, theirs, known.n) != 0)) {
        char text[160];

        (void)snprintf(text, sizeof text, "%s here is not the box's, and stays as it is", file);
        tell(b, text);
    } else if (r == 0 && (there == -ENOENT || known.n < n || b->landing->doubtful)) {
        r = landing_put(b->landing, file, theirs, n, err);
    }
    free(ours);
    free(theirs);
    return r;
}

int beside_people(struct beside *b, struct ttf_err *err)
{
    static const char *const FILES[] = {"notes.jsonl", "samples.json", "report.json"};
    int r = 0;

    for (unsigned i = 0; r == 0 && i < sizeof FILES / sizeof *FILES; i++)
        r = pull_people(b, FILES[i], err);
    return r;
}
