/* SPDX-License-Identifier: Apache-2.0 */
#include "one.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "grown.h"
#include "landing.h"
#include "seal.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/json_parse.h"

#define BATCH_BYTES    ((int64_t)64 << 20)
#define BATCH_FILES    LANDING_BATCH
#define BATCH_LINES    ((size_t)4 << 20) /* bytes of lines that name no files, too */
#define MANIFEST_MAX   ((size_t)1 << 20)
#define PEOPLE_MAX     ((size_t)64 << 20)
#define PROGRESS_FILES 8 /* how often it is told within a slot of many */

struct one {
    const struct ttf_pull_config *config;
    struct wire *wire;
    const char *name;
    char folder[4300];
    struct landing landing;
    struct grown records, events;
    int64_t slots_there; /* as the box says */
    enum landing_trust trust;
    const struct one_skips *skips;
    bool changed; /* lines were added or taken back */
    struct one_result *result;
    int lock; /* handle of the folder, locked; -1 */
    /* lines whose files are here, but perhaps not on the disk yet */
    char *lines;
    size_t lines_bytes, lines_room;
    int64_t batch_bytes;
    unsigned batch_files;
};

static void tell(const struct one *one, const char *text)
{
    const struct ttf_pull_progress p = {
        .dataset = one->name,
        .slots_done = one->result->slots,
        .slots = one->slots_there,
        .bytes = pull_wire_bytes(one->wire),
        .now_ns = ttf_clock_now_ns(one->config->clock),
        .text = text,
    };

    if (one->config->progress)
        one->config->progress(one->config->progress_ctx, &p);
}

/* ---- files of a line ---- */

static void count_damage(struct one *one, const char *path)
{
    if (one->result->damaged++ == 0)
        (void)snprintf(one->result->first_damaged, sizeof one->result->first_damaged, "%s/%s",
                       one->name, path);
}

static bool is_skipped(const struct one *one, const char *path)
{
    for (unsigned i = 0; i < one->skips->n; i++)
        if (strcmp(one->skips->paths[i], path) == 0)
            return true;
    return false;
}

static int bring(struct one *one, const char *path, int64_t bytes, const char *sha256,
                 struct ttf_err *err)
{
    struct ttf_err why = {0};
    bool came = false;
    int r = -EIO;

    one->landing.ours = false;
    if (!is_skipped(one, path))
        r = landing_ensure(&one->landing, path, bytes, sha256, one->trust, &came, &why);
    if (!one->landing.ours && (r == -TTF_EDAMAGED || r == -ENOENT || r == -EIO)) {
        char text[400];
        const char *what = r == -ENOENT ? "is missing on the box" : "cannot be read on the box";

        (void)snprintf(text, sizeof text, "%s %s", path, r == -TTF_EDAMAGED ? why.what : what);
        count_damage(one, path);
        tell(one, text);
        return 0;
    }
    if (r < 0) {
        *err = why;
        if (pull_wire_may_pass(r))
            (void)snprintf(one->result->stuck, sizeof one->result->stuck, "%s", path);
        return r;
    }
    one->result->files += came;
    one->batch_files += came;
    one->batch_bytes += came && bytes > 0 ? bytes : 0;
    if (came && one->batch_files % PROGRESS_FILES == 0)
        tell(one, NULL);
    return 0;
}

static int bring_files(struct one *one, const json_t *owner, struct ttf_err *err)
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
            return ttf_err_set(err, -TTF_EDAMAGED, one->records.url,
                               "a line names a file in a way that no dataset does");
        r = bring(one, path, json_integer_value(bytes), sha256, err);
        if (r < 0)
            return r;
    }
    return 0;
}

/* grown_line_fn: brings what a record names. */
static int take_record(void *ctx, const char *line, size_t n, struct ttf_err *err)
{
    struct one *one = ctx;
    const json_t *image;
    json_t *json;
    size_t i;
    const char *type;
    int r = ttf_json_parse(line, n, &json, NULL);

    if (r < 0)
        return ttf_err_set(err, r == -EINVAL ? -TTF_EDAMAGED : r, one->records.url,
                           "a line is no JSON");
    if (one->config->stop && *one->config->stop != 0) {
        json_decref(json);
        return ttf_err_set(err, -ECANCELED, NULL, "told to stop");
    }
    type = json_string_value(json_object_get(json, "type"));
    r = bring_files(one, json, err);
    json_array_foreach(json_object_get(json, "images"), i, image) if (r == 0) r =
        bring_files(one, image, err);
    if (r == 0 && type && strcmp(type, "slot") == 0) {
        one->result->slots++;
        tell(one, NULL);
    }
    json_decref(json);
    return r;
}

/* ---- records ---- */

static int flush(struct one *one, struct ttf_err *err)
{
    int r = 0;

    if (one->lines_bytes == 0)
        return 0;
    r = landing_settle(&one->landing, err);
    if (r == 0)
        r = grown_append(&one->records, one->lines, one->lines_bytes, err);
    if (r < 0)
        return r;
    one->changed = true;
    one->lines_bytes = 0;
    one->batch_bytes = 0;
    one->batch_files = 0;
    return 0;
}

static int keep_line(struct one *one, const char *line, size_t n)
{
    if (one->lines_bytes + n + 1 > one->lines_room) {
        size_t room = 2 * (one->lines_room + n + 1);
        char *more = realloc(one->lines, room);

        if (!more)
            return -ENOMEM;
        one->lines = more;
        one->lines_room = room;
    }
    memcpy(one->lines + one->lines_bytes, line, n);
    one->lines[one->lines_bytes + n] = '\n';
    one->lines_bytes += n + 1;
    return 0;
}

/* What the box has beyond what is here. */
static int pull_records(struct one *one, struct ttf_err *err)
{
    struct ttf_err ignored = {0};
    const char *line;
    size_t n;
    int r, last;

    while ((r = grown_next(&one->records, one->records.bytes + (int64_t)one->lines_bytes, &line, &n,
                           err)) > 0) {
        r = take_record(one, line, n, err);
        if (r == 0 && keep_line(one, line, n) < 0)
            r = ttf_err_set(err, -ENOMEM, NULL, "no memory");
        if (r == 0 && (one->batch_bytes >= BATCH_BYTES || one->batch_files >= BATCH_FILES ||
                       one->lines_bytes >= BATCH_LINES))
            r = flush(one, err);
        if (r < 0)
            break;
    }
    last = flush(one, r < 0 ? &ignored : err); /* what came stays, whatever ended it */
    return r < 0 ? r : last;
}

/* grown_line_fn: a line that the box lost before its disk had it; what it named is no part of the dataset. */
static int take_back(void *ctx, const char *line, size_t n, struct ttf_err *err)
{
    struct one *one = ctx;
    const json_t *image, *file;
    char path[4600];
    json_t *json;
    size_t i, k;

    (void)err;
    if (ttf_json_parse(line, n, &json, NULL) < 0)
        return 0;
    json_array_foreach(json_object_get(json, "images"), i, image)
        json_array_foreach(json_object_get(image, "files"), k, file)
    {
        const char *name = json_string_value(json_object_get(file, "path"));

        if (!name || !landing_is_image(name))
            continue;
        (void)snprintf(path, sizeof path, "%s/%s", one->folder, name);
        (void)one->config->io->ops->unlink(one->config->io, path);
    }
    json_decref(json);
    return 0;
}

/* First it is compared, then the list of hashes goes, then the lines: cut off between any two, it is a dataset. */
static int come_to_terms(struct one *one, const struct seal_state *state, struct ttf_err *err)
{
    int r = grown_agree(&one->records, err);

    if (r == 0 && (state->other_here || grown_is_ahead(&one->records)))
        r = seal_drop(one->config->io, one->folder, err);
    if (r < 0 || !grown_is_ahead(&one->records))
        return r;
    one->changed = true;
    r = grown_each(&one->records, one->records.bytes, take_back, one, err);
    return r < 0 ? r : grown_cut(&one->records, err);
}

static int open_records(struct one *one, const struct seal_state *state, struct ttf_err *err)
{
    int r = grown_open(&one->records, err);

    if (r == 0 && !state->here)
        r = come_to_terms(one, state, err);
    one->trust = LANDING_SIZE;
    if (r == 0)
        r = grown_each(&one->records, 0, take_record, one, err);
    one->trust = LANDING_HASH;
    return r;
}

/* ---- events, and what people add ---- */

static int pull_events(struct one *one, struct ttf_err *err)
{
    const char *line;
    size_t n;
    struct ttf_io_stat st;
    bool there = one->config->io->ops->stat(one->config->io, one->events.path, &st) == 0;
    int r = grown_open(&one->events, err);

    if (r == 0)
        r = grown_agree(&one->events, err);
    if (r == -EEXIST) { /* what happened is the box's to tell: from its beginning */
        r = 0;
        one->events.bytes = 0;
    }
    if (r == 0 && grown_is_ahead(&one->events))
        r = grown_cut(&one->events, err);
    while (r == 0) {
        r = grown_next(&one->events, one->events.bytes + (int64_t)one->lines_bytes, &line, &n, err);
        if (r <= 0)
            break;
        r = keep_line(one, line, n);
        if (r == 0 && one->lines_bytes > (size_t)BATCH_BYTES / 64) {
            r = grown_append(&one->events, one->lines, one->lines_bytes, err);
            one->lines_bytes = 0;
        }
    }
    if (r == 0 && one->lines_bytes > 0)
        r = grown_append(&one->events, one->lines, one->lines_bytes, err);
    one->lines_bytes = 0;
    grown_close(&one->events);
    if (r == -ENOENT) { /* the box has none */
        if (!there)
            (void)one->config->io->ops->unlink(one->config->io, one->events.path);
        else
            tell(one, "events.jsonl is missing on the box; what is here stays");
        r = 0;
    }
    return r;
}

/* Outside the seal: brought if there is none here, or what is here is its beginning. */
static int pull_people(struct one *one, const char *file, struct ttf_err *err)
{
    char url[300], path[4600], *theirs = NULL, *ours = NULL;
    size_t n_theirs, n_ours = 0;
    int r;

    (void)snprintf(url, sizeof url, "/datasets/%s/files/%s", one->name, file);
    (void)snprintf(path, sizeof path, "%s/%s", one->folder, file);
    r = pull_wire_get_text(one->wire, url, 0, -1, PEOPLE_MAX, &theirs, &n_theirs, err);
    if (r == -ENOENT)
        return 0;
    if (r < 0)
        return r;
    r = ttf_io_slurp(one->config->io, path, PEOPLE_MAX, &ours, &n_ours, NULL);
    if (r < 0 && r != -ENOENT) {
        ttf_err_set(err, r, path, "cannot be read: %s", strerrordesc_np(-r));
    } else if (r == 0 && (n_ours > n_theirs || memcmp(ours, theirs, n_ours) != 0)) {
        char text[160];

        (void)snprintf(text, sizeof text, "%s here is not the box's, and stays as it is", file);
        tell(one, text);
    } else if (r == -ENOENT || (r == 0 && n_ours < n_theirs)) {
        r = landing_put(&one->landing, file, theirs, n_theirs, err);
    }
    free(ours);
    free(theirs);
    return r;
}

/* ---- whole ---- */

static int not_empty(void *ctx, const char *name, bool is_dir)
{
    size_t n = strlen(name);

    (void)is_dir;
    if (n >= 4 && strcmp(name + n - 4, ".tmp") == 0)
        return 0; /* what a pull left that was cut off at its very beginning */
    *(bool *)ctx = true;
    return 1;
}

/* The dataset's own manifest here, or a folder that may become it. */
static int pull_manifest(struct one *one, struct ttf_err *err)
{
    struct ttf_io *io = one->config->io;
    char url[300], path[4600], *theirs = NULL, *ours = NULL;
    size_t n_theirs, n_ours;
    bool any = false;
    int r;

    (void)snprintf(url, sizeof url, "/datasets/%s/files/dataset.json", one->name);
    (void)snprintf(path, sizeof path, "%s/dataset.json", one->folder);
    r = pull_wire_get_text(one->wire, url, 0, -1, MANIFEST_MAX, &theirs, &n_theirs, err);
    if (r < 0)
        return r;
    r = ttf_io_slurp(io, path, MANIFEST_MAX, &ours, &n_ours, NULL);
    if (r < 0 && r != -ENOENT)
        ttf_err_set(err, r, path, "cannot be read: %s", strerrordesc_np(-r));
    if (r == 0 && (n_ours != n_theirs || memcmp(ours, theirs, n_ours) != 0))
        r = ttf_err_set(err, -EEXIST, one->folder, "is another dataset than the box's");
    if (r == -EEXIST)
        ttf_err_hint(err, "move it away, or pull into another folder");
    if (r == -ENOENT) {
        r = io->ops->list(io, one->folder, not_empty, &any);
        if (any) {
            r = ttf_err_set(err, -EEXIST, one->folder, "is there, and no dataset");
            ttf_err_hint(err, "move it away, or pull into another folder");
        } else if (r < 0 && r != -ENOENT) {
            ttf_err_set(err, r, one->folder, "cannot be listed: %s", strerrordesc_np(-r));
        } else {
            r = ttf_io_mkdirs(io, one->folder, err);
            if (r == 0)
                r = landing_put(&one->landing, "dataset.json", theirs, n_theirs, err);
        }
    }
    free(ours);
    free(theirs);
    return r;
}

/* Two programs that appended to the same records would spoil them for both. */
static int lock(struct one *one, struct ttf_err *err)
{
    struct ttf_io *io = one->config->io;
    int r;

    one->lock = io->ops->open(io, one->folder, TTF_IO_READ);
    if (one->lock < 0)
        return ttf_err_set(err, one->lock, one->folder, "cannot be opened: %s",
                           strerrordesc_np(-one->lock));
    r = io->ops->lock(io, one->lock);
    if (r !=
        -EAGAIN) /* some file systems know no locks: then nobody guards, and the work goes on */
        return 0;
    ttf_err_set(err, -EBUSY, one->folder, "another program is writing this dataset");
    ttf_err_hint(err, "wait until it is done, or stop it");
    return -EBUSY;
}

static int ask_seal(struct one *one, struct seal_state *ret, struct ttf_err *err)
{
    int r = seal_ask(one->wire, one->name, ret, err);

    if (r != -EIO)
        return r;
    *ret =
        (struct seal_state){0}; /* the box cannot read all of it itself; what it gives is taken */
    memset(err, 0, sizeof *err);
    return 0;
}

static int pull_all(struct one *one, struct ttf_err *err)
{
    static const char *const PEOPLE[] = {"notes.jsonl", "samples.json", "report.json"};
    struct seal_state state;
    int r = pull_manifest(one, err);

    if (r == 0)
        r = lock(one, err);
    if (r == 0)
        r = ask_seal(one, &state, err);
    if (r == 0) {
        one->slots_there = state.slots;
        one->result->box_sealed = state.sealed;
        r = seal_look(one->config->io, one->folder, &state, err);
    }
    if (r == 0)
        r = open_records(one, &state, err);
    if (r == 0 && !state.here)
        r = pull_records(one, err);
    if (r == 0 && !state.here)
        r = pull_events(one, err);
    for (unsigned i = 0; r == 0 && i < sizeof PEOPLE / sizeof *PEOPLE; i++)
        r = pull_people(one, PEOPLE[i], err);
    if (r == 0 && one->result->damaged == 0)
        r = seal_close(&one->landing, one->wire, &state, &one->result->sealed, err);
    if (r == 0 && !one->result->sealed && (one->changed || state.other_here))
        r = ttf_sums_rebuild(one->config->io, one->folder, err);
    return r;
}

int one_pull(const struct ttf_pull_config *config, struct wire *wire, const char *name,
             const struct one_skips *skips, struct one_result *ret, struct ttf_err *err)
{
    struct one *one = calloc(1, sizeof *one);
    int r;

    *ret = (struct one_result){0};
    if (!one)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    one->config = config;
    one->wire = wire;
    one->name = name;
    one->result = ret;
    one->lock = -1;
    one->skips = skips;
    one->trust = LANDING_HASH;
    (void)snprintf(one->folder, sizeof one->folder, "%s/%s", config->dest, name);
    one->landing =
        (struct landing){.io = config->io, .wire = wire, .name = name, .folder = one->folder};
    one->records = (struct grown){.io = config->io, .wire = wire, .file = -1};
    one->events = one->records;
    (void)snprintf(one->records.url, sizeof one->records.url, "/datasets/%s/records", name);
    (void)snprintf(one->records.path, sizeof one->records.path, "%s/records.jsonl", one->folder);
    (void)snprintf(one->events.url, sizeof one->events.url, "/datasets/%s/files/events.jsonl",
                   name);
    (void)snprintf(one->events.path, sizeof one->events.path, "%s/events.jsonl", one->folder);
    r = pull_all(one, err);
    grown_close(&one->records);
    grown_close(&one->events);
    if (one->lock >= 0)
        (void)config->io->ops->close(config->io, one->lock);
    free(one->lines);
    free(one);
    return r;
}
