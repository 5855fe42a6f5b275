/* SPDX-License-Identifier: Apache-2.0 */
#include "one.h"

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "anew.h"
#include "beside.h"
#include "grown.h"
#include "landing.h"
#include "lines.h"
#include "names.h"
#include "seal.h"
#include "settle.h"
#include "sure.h"
#include "ttf/dataset/copy.h"
#include "ttf/dataset/json_parse.h"

#define MANIFEST_MAX ((size_t)1 << 20)

struct one {
    const struct ttf_pull_config *config;
    struct wire *wire;
    const char *name;
    char folder[4300];
    int lock; /* handle of the folder, locked; -1 */
    struct landing landing;
    struct settling settling;
    struct grown records;
    struct lines lines;
    int64_t slots_there; /* as the box says */
    bool taken_back;     /* lines were */
    bool marked;         /* by this pull, or it has taken over the mark: anew.h */
    struct one_result *result;
};

static void tell(void *ctx, int64_t slots, const char *text)
{
    const struct one *one = ctx;
    const struct ttf_pull_progress p = {
        .dataset = one->name,
        .slots_done = slots,
        .slots = one->slots_there,
        .bytes = pull_wire_bytes(one->wire),
        .now_ns = ttf_clock_now_ns(one->config->clock),
        .text = text,
    };

    if (one->config->progress)
        one->config->progress(one->config->progress_ctx, &p);
}

/* ---- records ---- */

/* Of two errors the one that is told: what this machine's disk says, before a wire that may come back. *err is r's. */
static int graver(int r, int last, const struct ttf_err *why_last, struct ttf_err *err)
{
    if (last >= 0 || (r < 0 && !pull_wire_may_pass(r)))
        return r;
    if (err)
        *err = *why_last;
    return last;
}

/* What the box has beyond what is here. */
static int pull_records(struct one *one, struct ttf_err *err)
{
    struct ttf_err own = {0};
    const char *line;
    size_t n;
    int r, last;

    while ((r = grown_next(&one->records, one->records.bytes + (int64_t)lines_pending(&one->lines),
                           &line, &n, err)) > 0) {
        r = lines_take(&one->lines, line, n, true, err);
        if (r < 0)
            break;
    }
    last = lines_finish(&one->lines, &own); /* what came stays */
    return graver(r, last, &own, err);
}

/* grown_line_fn: what a line names that is here already. */
static int check_line(void *ctx, const char *line, size_t n, struct ttf_err *err)
{
    struct one *one = ctx;

    return lines_take(&one->lines, line, n, false, err);
}

/* grown_line_fn: a line that the box lost before its disk had it. */
static int note_line(void *ctx, const char *line, size_t n, struct ttf_err *err)
{
    const json_t *image, *file;
    json_t *json;
    size_t i, k;
    int r = 0;

    if (ttf_json_parse(line, n, &json, NULL) < 0)
        return 0;
    json_array_foreach(json_object_get(json, "images"), i, image)
        json_array_foreach(json_object_get(image, "files"), k, file)
    {
        const char *name = json_string_value(json_object_get(file, "path"));

        if (r == 0 && name && landing_is_image(name))
            r = names_add(ctx, name, strlen(name));
    }
    json_decref(json);
    return r < 0 ? ttf_err_set(err, r, NULL, "no memory") : 0;
}

static void remove_all(const struct one *one, const struct names *gone)
{
    char path[4600];

    for (const char *name = names_first(gone); name; name = names_next(gone, name)) {
        (void)snprintf(path, sizeof path, "%s/%s", one->folder, name);
        (void)one->config->io->ops->unlink(one->config->io, path);
    }
}

/* The lines go, on the disk too, and then their files: a file without a line is nobody's, a line without its file is damage. */
static int take_back(struct one *one, struct ttf_err *err)
{
    struct names gone = {0}; /* files that are no part of the dataset any more */
    int r = grown_each(&one->records, one->records.bytes, note_line, &gone, err);

    if (r == 0)
        r = grown_cut(&one->records, err);
    if (r == 0)
        remove_all(one, &gone);
    names_free(&gone);
    return r;
}

/* First it is compared, then the list of hashes goes, then the lines: cut off between any two, it is a dataset. */
static int come_to_terms(struct one *one, const struct seal_state *state, struct ttf_err *err)
{
    int r = grown_agree(&one->records, err);

    if (r == 0 && (state->other_here || grown_is_ahead(&one->records)))
        r = seal_drop(one->config->io, one->folder, err);
    if (r < 0 || !grown_is_ahead(&one->records))
        return r;
    one->taken_back = true;
    return take_back(one, err);
}

static int open_records(struct one *one, const struct seal_state *state, struct ttf_err *err)
{
    int r = grown_open(&one->records, err);

    if (r == 0 && !state->here)
        r = come_to_terms(one, state, err);
    if (r == 0) {
        struct ttf_err own = {0};
        int last;

        r = grown_each(&one->records, 0, check_line, one, err);
        last = lines_finish(&one->lines, &own);
        r = graver(r, last, &own, err);
    }
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

static int sync_above(struct one *one, struct ttf_err *err)
{
    int r = one->config->io->ops->sync_dir(one->config->io, one->config->dest);

    return r == 0 ? 0
                  : ttf_err_set(err, r, one->config->dest, "cannot be synced: %s",
                                strerrordesc_np(-r));
}

/* A folder that is there already may be one whose sync failed. */
static int make_folder(struct one *one, struct ttf_err *err)
{
    int r = ttf_io_mkdirs(one->config->io, one->folder, err);

    if (r == 0)
        r = sync_above(one, err);
    if (r == 0)
        r = anew_mark(one->config->io, one->folder, err);
    one->marked = r == 0;
    return r;
}

/* What an earlier pull left that did not end well. */
static int write_anew(struct one *one, struct ttf_err *err)
{
    static const char *const FILES[] = {"dataset.json", "records.jsonl", "events.jsonl"};
    char path[4600];
    int r = sync_above(one, err);

    for (unsigned i = 0; r == 0 && i < sizeof FILES / sizeof *FILES; i++) {
        (void)snprintf(path, sizeof path, "%s/%s", one->folder, FILES[i]);
        r = anew_write(one->config->io, path, true, NULL, err);
        if (r == -ENOENT)
            r = 0;
    }
    return r;
}

/* The folder is this pull's alone, from here on. */
static int take_over(struct one *one, struct ttf_err *err)
{
    int r = 0;

    if (one->marked)
        return 0;
    one->landing.doubtful = anew_is_marked(one->config->io, one->folder);
    if (one->landing.doubtful)
        r = write_anew(one, err);
    else
        r = anew_mark(one->config->io, one->folder, err);
    one->marked = r == 0;
    return r;
}

/* A folder that may become the dataset's, with its manifest. */
static int begin_here(struct one *one, const char *manifest, size_t n, struct ttf_err *err)
{
    struct ttf_io *io = one->config->io;
    bool any = false;
    int r = io->ops->list(io, one->folder, not_empty, &any);

    if (any) {
        r = ttf_err_set(err, -EEXIST, one->folder, "is there, and no dataset");
        ttf_err_hint(err, "move it away, or pull into another folder");
        return r;
    }
    if (r < 0 && r != -ENOENT)
        return ttf_err_set(err, r, one->folder, "cannot be listed: %s", strerrordesc_np(-r));
    one->lines.is_new = r == -ENOENT; /* of the folder itself */
    r = make_folder(one, err);
    return r < 0 ? r : landing_put(&one->landing, "dataset.json", manifest, n, err);
}

/* The dataset's own manifest here, or a folder that may become it. */
static int pull_manifest(struct one *one, struct ttf_err *err)
{
    char url[300], path[4600], *theirs = NULL;
    struct sure_known known = {0};
    char *ours = NULL;
    size_t n;
    int there, r;

    (void)snprintf(url, sizeof url, "/datasets/%s/files/dataset.json", one->name);
    (void)snprintf(path, sizeof path, "%s/dataset.json", one->folder);
    there = ttf_io_slurp(one->config->io, path, MANIFEST_MAX, &ours, &known.n, NULL);
    known.bytes = ours;
    r = sure_text(one->wire, url, 0, -1, MANIFEST_MAX, &known, &theirs, &n, err);
    if (r == 0 && there < 0 && there != -ENOENT)
        r = ttf_err_set(err, there, path, "cannot be read: %s", strerrordesc_np(-there));
    else if (r == 0 && there == -ENOENT)
        r = begin_here(one, theirs, n, err);
    else if (r == 0 && (known.n != n || memcmp(ours, theirs, n) != 0)) {
        r = ttf_err_set(err, -EEXIST, one->folder, "is another dataset than the box's");
        ttf_err_hint(err, "move it away, or pull into another folder");
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

/* How it stands there and here. A seal here that is another than the box's goes: not for a bit that turned over on the way. */
static int compare_seals(struct one *one, struct seal_state *ret, struct ttf_err *err)
{
    int r = 0;

    for (unsigned times = 0; r == 0 && times < 2; times++) {
        r = ask_seal(one, ret, err);
        if (r == 0)
            r = seal_look(one->config->io, one->folder, ret, err);
        if (r == 0 && !ret->other_here)
            break;
    }
    if (r == 0 && one->landing.doubtful && ret->here) { /* its name may be all that there is */
        ret->here = false;
        ret->other_here = true;
    }
    return r;
}

static int close_seal(struct one *one, struct seal_state *state, struct ttf_err *err)
{
    char text[160];
    int r = seal_close(&one->landing, &one->settling, &one->records, &one->lines.vouched, state,
                       &one->result->sealed, err);

    if (state->aside > 0) {
        (void)snprintf(text, sizeof text,
                       "files here that the box's seal does not list (%lld) are NAME.tmp now",
                       (long long)state->aside);
        tell(one, one->result->slots, text);
    }
    return r;
}

static int pull_all(struct one *one, struct ttf_err *err)
{
    struct beside beside = {.wire = one->wire,
                            .landing = &one->landing,
                            .tell = tell,
                            .tell_ctx = one,
                            .result = one->result};
    struct seal_state state;
    int r = pull_manifest(one, err);

    if (r == 0)
        r = lock(one, err);
    one->settling.handle = one->lock;
    if (r == 0)
        r = take_over(one, err);
    if (r == 0)
        r = compare_seals(one, &state, err);
    if (r == 0) {
        one->slots_there = state.slots;
        one->result->box_sealed = state.sealed;
    }
    if (r == 0)
        r = open_records(one, &state, err);
    if (r == 0 && !state.here)
        r = pull_records(one, err);
    if (r == 0 && !state.here)
        r = beside_events(&beside, err);
    if (r == 0)
        r = beside_people(&beside, err);
    if (r == 0 && one->result->damaged == 0)
        r = close_seal(one, &state, err);
    if (r == 0 && !one->result->sealed &&
        (one->lines.changed || one->taken_back || state.other_here))
        r = ttf_sums_rebuild(one->config->io, one->folder, err);
    return r;
}

/* Was it the box or the wire, if anything? Then all that is here is what it seems; of what was doubtful before, once all was gone through. */
static bool is_of_box(int r)
{
    return r == 0 || pull_wire_may_pass(r) || r == -ECANCELED || r == -TTF_EDAMAGED;
}

static bool leaves_no_doubt(const struct one *one, int r)
{
    if (one->landing.doubtful)
        return r == 0;
    return is_of_box(r) && is_of_box(one->lines.failed) && one->settling.failed == 0;
}

int one_pull(const struct ttf_pull_config *config, struct wire *wire, struct crew *crew,
             const char *name, const struct one_skips *skips, struct one_result *ret,
             struct ttf_err *err)
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
    (void)snprintf(one->folder, sizeof one->folder, "%s/%s", config->dest, name);
    one->landing =
        (struct landing){.io = config->io, .wire = wire, .name = name, .folder = one->folder};
    one->settling = (struct settling){
        .io = config->io, .clock = config->clock, .folder = one->folder, .handle = -1};
    one->records = (struct grown){.io = config->io, .wire = wire, .file = -1};
    (void)snprintf(one->records.url, sizeof one->records.url, "/datasets/%s/records", name);
    (void)snprintf(one->records.path, sizeof one->records.path, "%s/records.jsonl", one->folder);
    one->lines.name = name;
    one->lines.folder = one->folder;
    one->lines.crew = crew;
    one->lines.landing = &one->landing;
    one->lines.records = &one->records;
    one->lines.settling = &one->settling;
    one->lines.skips = skips;
    one->lines.stop = config->stop;
    one->lines.result = ret;
    one->lines.tell = tell;
    one->lines.tell_ctx = one;
    r = pull_all(one, err);
    if (one->marked && leaves_no_doubt(one, r))
        anew_unmark(config->io, one->folder);
    lines_free(&one->lines);
    grown_close(&one->records);
    if (one->lock >= 0)
        (void)config->io->ops->close(config->io, one->lock);
    free(one);
    return r;
}
