/* SPDX-License-Identifier: Apache-2.0 */
#include "lines.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "ttf/dataset/hash.h"
#include "ttf/dataset/json_parse.h"

#define BATCH_BYTES ((int64_t)64 << 20) /* of files */
#define BATCH_TEXT  ((size_t)4 << 20)   /* of lines, which may name no files */
#define GROUP       8u                  /* small files for which it is woken, and tells, once */
#define LARGE_BYTES ((int64_t)1 << 20)

static struct lines_batch *current(struct lines *l)
{
    return &l->batch[l->now];
}

/* ---- what came of a batch ---- */

static void count_damage(struct lines *l, const struct errand *e)
{
    const char *what = e->r == -ENOENT ? "is missing on the box" : "cannot be read on the box";
    char text[600];

    if (l->result->damaged++ == 0)
        (void)snprintf(l->result->first_damaged, sizeof l->result->first_damaged, "%s/%s", l->name,
                       e->path);
    (void)snprintf(text, sizeof text, "%s %s", e->path, e->r == -TTF_EDAMAGED ? e->why.what : what);
    l->tell(l->tell_ctx, l->result->slots, text);
}

/* From here on nothing is appended. What else was asked for is dropped, as far as nobody has begun it. */
static void fail_at(struct lines *l, const struct lines_batch *b, unsigned i)
{
    const struct errand *e = &b->errands[i];

    l->failed = e->r;
    l->why = e->why;
    l->result->slots = b->slots_at[i];
    if (pull_wire_may_pass(e->r) && e->r != -EAGAIN) /* a box that is busy says nothing of a file */
        (void)snprintf(l->result->stuck, sizeof l->result->stuck, "%s", e->path);
    crew_drop(l->crew);
}

/* What this machine's disk says is not hidden behind a wire that broke before: that one is tried again, as if nothing were. */
static void set_failed(struct lines *l, int r, const struct ttf_err *why)
{
    if (r < 0 && (l->failed == 0 || pull_wire_may_pass(l->failed))) {
        l->failed = r;
        l->why = *why;
        crew_drop(l->crew);
    }
}

/* Waits for its files. How many bytes of its lines may be appended. */
static size_t gather(struct lines *l, struct lines_batch *b)
{
    size_t good = l->failed == 0 ? b->text_bytes : 0;
    unsigned group = b->bytes / LARGE_BYTES < b->n ? GROUP : 1;
    struct ttf_err err = {0};

    for (unsigned i = 0; i < b->n; i++) {
        struct errand *e = &b->errands[i];

        if (i % group == 0) /* woken once for all of it */
            crew_wait(l->crew, &b->errands[i + group < b->n ? i + group - 1 : b->n - 1]);
        crew_wait(l->crew, e);
        l->result->files += e->landed.came;
        if (e->r < 0 || e->landed.unsettled)
            settle_forget(l->settling, e->path); /* a failed sync may have been of this one, too */
        if (l->failed < 0)
            continue;
        if (e->r == 0 && e->landed.unsettled) {
            set_failed(l, settle_add(l->settling, e->path, &err), &err);
        } else if (!e->landed.ours && (e->r == -TTF_EDAMAGED || e->r == -ENOENT || e->r == -EIO)) {
            count_damage(l, e);
        } else if (e->r < 0) {
            fail_at(l, b, i);
            good = b->line_at[i];
        }
        if (l->failed == 0 && i % group == 0)
            l->tell(l->tell_ctx, b->slots_at[i], NULL);
    }
    return good;
}

/* The batch is over: its files on the disk, then its lines. */
static void close_batch(struct lines *l, struct lines_batch *b)
{
    size_t good = gather(l, b);
    struct ttf_err err = {0};
    int r = settle_all(l->settling, &err);

    if (r == 0 && good > 0) {
        r = grown_append(l->records, b->text, good, &err);
        l->changed |= r == 0;
    }
    set_failed(l, r, &err);
    b->n = 0;
    b->bytes = 0;
    b->text_bytes = 0;
}

static int say_failed(const struct lines *l, struct ttf_err *err)
{
    if (l->failed < 0 && err)
        *err = l->why;
    return l->failed;
}

/* Room in the current batch: the other, which comes first, is closed, and is the current one then. */
static int turn(struct lines *l, struct ttf_err *err)
{
    struct lines_batch *b = current(l);

    if (b->n < LINES_FILES && b->bytes < BATCH_BYTES && b->text_bytes < BATCH_TEXT)
        return 0;
    l->now = !l->now;
    close_batch(l, current(l));
    return say_failed(l, err);
}

/* ---- a line ---- */

static bool is_skipped(const struct lines *l, const char *path)
{
    for (unsigned i = 0; i < l->skips->n; i++)
        if (strcmp(l->skips->paths[i], path) == 0)
            return true;
    return false;
}

/* A number that is the same for names that differ by case alone (FNV-1a). */
static uint32_t fold(const char *path)
{
    uint32_t n = 2166136261u;

    for (; *path; path++)
        n = (n ^ ((unsigned char)*path & 0xdfu)) * 16777619u;
    return n;
}

/* Two at one file at once would spoil it; on some file systems names that differ by case alone are one. */
static void wait_for_same(struct lines *l, const char *path, uint32_t folded)
{
    for (unsigned k = 0; k < 2; k++)
        for (unsigned i = 0; i < l->batch[k].n; i++)
            if (l->batch[k].folded[i] == folded &&
                strcasecmp(l->batch[k].errands[i].path, path) == 0)
                crew_wait(l->crew, &l->batch[k].errands[i]);
}

static int ask(struct lines *l, const char *path, int64_t bytes, const char *sha256, bool keep,
               struct ttf_err *err)
{
    const uint32_t folded = fold(path);
    struct lines_batch *b;
    struct errand *e;
    int r = keep ? 0 : landing_has(l->landing, path, bytes, err);

    if (r != 0)
        return r < 0 ? r : 0; /* it was durable before its line was here */
    r = turn(l, err);
    if (r < 0)
        return r;
    wait_for_same(l, path, folded);
    b = current(l);
    b->slots_at[b->n] = (unsigned)l->result->slots;
    b->line_at[b->n] = b->text_bytes;
    b->folded[b->n] = folded;
    b->bytes += bytes < BATCH_BYTES ? bytes : BATCH_BYTES;
    e = &b->errands[b->n++];
    *e = (struct errand){.name = l->name,
                         .folder = l->folder,
                         .bytes = bytes,
                         .trust = !keep       ? LANDING_SIZE
                                  : l->is_new ? LANDING_NEW
                                              : LANDING_HASH,
                         .doubtful = l->landing->doubtful,
                         .r = -EIO,
                         .done = true};
    (void)snprintf(e->path, sizeof e->path, "%s", path);
    (void)snprintf(e->sha256, sizeof e->sha256, "%s", sha256);
    if (!is_skipped(l, path))
        crew_do(l->crew, e);
    return 0;
}

static int ask_files(struct lines *l, const json_t *owner, bool keep, struct ttf_err *err)
{
    const json_t *file;
    size_t i;

    json_array_foreach(json_object_get(owner, "files"), i, file)
    {
        const char *path = json_string_value(json_object_get(file, "path"));
        const char *sha256 = json_string_value(json_object_get(file, "sha256"));
        const json_t *bytes = json_object_get(file, "bytes");
        int r;

        if (!path || !landing_is_image(path) || !sha256 || !ttf_sha256_is_hex(sha256) ||
            !json_is_integer(bytes) || json_integer_value(bytes) < 0)
            return ttf_err_set(err, -TTF_EDAMAGED, l->records->url,
                               "a line names a file in a way that no dataset does");
        r = ask(l, path, json_integer_value(bytes), sha256, keep, err);
        if (r < 0)
            return r;
    }
    return 0;
}

/* Into the batch that has the last of its files, and so is the last to be closed of those that have any. */
static int keep_text(struct lines *l, const char *line, size_t n, struct ttf_err *err)
{
    struct lines_batch *b = current(l);

    if (b->text_bytes + n + 1 > b->text_room) {
        size_t room = 2 * (b->text_room + n + 1);
        char *more = realloc(b->text, room);

        if (!more)
            return ttf_err_set(err, -ENOMEM, NULL, "no memory");
        b->text = more;
        b->text_room = room;
    }
    memcpy(b->text + b->text_bytes, line, n);
    b->text[b->text_bytes + n] = '\n';
    b->text_bytes += n + 1;
    return 0;
}

int lines_take(struct lines *l, const char *line, size_t n, bool keep, struct ttf_err *err)
{
    const json_t *image;
    const char *type;
    json_t *json;
    size_t i;
    int r = turn(l, err);

    if (r < 0)
        return r;
    if (l->stop && *l->stop != 0)
        return ttf_err_set(err, -ECANCELED, NULL, "told to stop");
    r = ttf_json_parse(line, n, &json, NULL);
    if (r < 0)
        return ttf_err_set(err, r == -EINVAL ? -TTF_EDAMAGED : r, l->records->url,
                           "a line is no JSON");
    type = json_string_value(json_object_get(json, "type"));
    r = ask_files(l, json, keep, err);
    json_array_foreach(json_object_get(json, "images"), i, image) if (r == 0) r =
        ask_files(l, image, keep, err);
    if (r == 0 && keep)
        r = keep_text(l, line, n, err);
    if (r == 0 && vouched_add(&l->vouched, json) < 0)
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory");
    l->result->slots += r == 0 && type && strcmp(type, "slot") == 0;
    json_decref(json);
    return r;
}

size_t lines_pending(const struct lines *l)
{
    return l->batch[0].text_bytes + l->batch[1].text_bytes;
}

int lines_finish(struct lines *l, struct ttf_err *err)
{
    close_batch(l, &l->batch[!l->now]);
    close_batch(l, &l->batch[l->now]);
    l->tell(l->tell_ctx, l->result->slots, NULL);
    return say_failed(l, err);
}

void lines_free(struct lines *l)
{
    free(l->batch[0].text);
    free(l->batch[1].text);
    vouched_free(&l->vouched);
}
