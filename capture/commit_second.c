/* SPDX-License-Identifier: Apache-2.0 */
/* When the dataset's storage has failed for good: the run goes on in the second one. Committer thread only. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "commit_place.h"
#include "commit_storage.h"
#include "plan_change.h"
#include "schedule.h"
#include "second_left.h"
#include "second_storage.h"
#include "timeline.h"

/* ---- image files that lie in the first dataset, of slots that have no record yet ---- */

struct copying {
    struct ttf_io *io;
    const char *from;
};

static int copy(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    const struct copying *c = ctx;
    char chunk[16384];
    int64_t at = 0;
    int64_t n = 0;
    int r = 0;
    int from = c->io->ops->open(c->io, c->from, TTF_IO_READ);

    if (from < 0)
        return ttf_err_set(err, from, c->from, "cannot be opened");
    while (r == 0 && (n = ttf_io_pread_all(c->io, from, chunk, sizeof(chunk), at)) > 0) {
        r = ttf_io_pwrite_all(io, file, chunk, (size_t)n, at);
        at += n;
    }
    (void)c->io->ops->close(c->io, from);
    if (r == 0 && n < 0)
        r = (int)n;
    return r < 0 ? ttf_err_set(err, r, c->from, "cannot be copied") : 0;
}

/* Bytes that have changed on the failing disk are no copy: the file is then lacking. */
static void fetch_file(struct ttf_committer *c, const char *first, int64_t index,
                       const struct ttf_image *image, struct ttf_file_ref *file)
{
    char from[4096 + sizeof(file->path)];
    const char *extension = strrchr(file->path, '.');
    struct copying copying = {.io = c->io, .from = from};
    struct ttf_file_ref got;

    snprintf(from, sizeof(from), "%s/%s", first, file->path);
    if (extension &&
        ttf_writer_file(c->writer, file->role, image->stream, index, image->bracket, extension + 1,
                        copy, &copying, &got, NULL) == 0 &&
        strcmp(got.sha256, file->sha256) == 0)
        *file = got;
    else
        file->bytes = -1; /* matches nothing: dropped below */
}

static void fetch(struct ttf_committer *c, const char *first, struct ttf_slot_work *work)
{
    struct ttf_slot_record *record = &work->record;
    bool any = false;

    for (unsigned i = 0; i < record->n_images; i++) {
        struct ttf_image *image = &record->images[i];

        for (unsigned f = 0; f < image->n_files; f++)
            fetch_file(c, first, record->index, image, &image->files[f]);
        any |= image->n_files > 0;
        if (c->calibration_lost)
            image->calibration[0] = '\0';
    }
    if (any)
        ttf_committer_drop_lost_files(c, record);
}

/* ---- the second dataset ---- */

/* The segment in force, from the first slot on that has no record. */
static struct ttf_segment continued(const struct ttf_committer *c)
{
    struct ttf_segment segment = c->in_force->segment;
    struct ttf_grid grid = {segment.first_index, segment.origin_ns, segment.interval_ns};

    segment.segment = 0;
    segment.first_index = c->ledger.next_index;
    segment.origin_ns = ttf_grid_due_ns(&grid, segment.first_index);
    if (segment.origin_utc_ns != TTF_NS_UNKNOWN)
        segment.origin_utc_ns += segment.origin_ns - c->in_force->segment.origin_ns;
    segment.run_ns = ttf_timeline_run_ns(&segment, c->slot0_ns);
    ttf_timeline_run_utc(&segment, c->past, c->slot0_ns, &c->outage);
    segment.gap_ns = 0;
    segment.corrects = false;
    return segment;
}

/* Once the run goes on there for certain: what else fails leaves the first dataset's calibration as it is. */
static void bring_calibration(struct ttf_committer *c, struct ttf_writer *writer)
{
    struct ttf_err err = {0};

    if (c->calibration_id[0] == '\0' ||
        ttf_writer_calibration(writer, c->calibration_id, c->calibration_folder, &err) == 0)
        return;
    /* Images name no calibration that is not there; the raw ones can be developed with it later. */
    c->calibration_lost = true;
    for (unsigned i = 0; i < TTF_PLAN_SHOTS_MAX; i++)
        if (c->rooms[i])
            c->rooms[i]->calibration[0] = '\0';
    ttf_events_emit(c->events, "storage", "the calibration did not come along: %s", err.what);
}

/*
 * A segment that was refused may be on the disk all the same, and would be gone on with by the next run: so it is
 * looked at. 0: it is there.
 */
static int begun_after_all(struct ttf_committer *c, struct ttf_writer **writer, int code)
{
    struct ttf_writer *old = *writer;
    bool doubt = false;

    *writer = NULL;
    if (ttf_writer_open_anew(c->io, c->second_path, old, &doubt, writer, NULL) < 0)
        return code;
    return ttf_writer_state(*writer)->n_segments > 0 ? 0 : code;
}

/* With the plan given as well, if that is not the one in force: run again with it, the run goes on as it has become. */
static int open_second(struct ttf_committer *c, struct ttf_writer **ret, struct ttf_err *err)
{
    const struct ttf_plan_text in_force = {c->in_force->json, c->in_force->yaml};
    struct ttf_plan_text given = {NULL, c->given_yaml};
    struct ttf_manifest manifest;
    char *json = NULL;
    int r = ttf_second_manifest(&c->manifest, &manifest, err);

    if (r == 0 && !c->in_force->as_given)
        r = ttf_plan_json(c->given, &json, err);
    given.json = json;
    if (r == 0)
        r = ttf_second_open(c->io, c->second_path, &manifest, json ? &given : NULL, &in_force, ret,
                            err);
    free(json);
    return r;
}

static int make_second(struct ttf_committer *c, struct ttf_writer **ret, struct ttf_err *err)
{
    struct ttf_segment segment = continued(c);
    struct ttf_writer *writer = NULL;
    int r = open_second(c, &writer, err);

    if (r < 0)
        return r;
    segment.plan = r;
    r = ttf_writer_segment(writer, &segment, err);
    if (r < 0)
        r = begun_after_all(c, &writer, r);
    if (r < 0) {
        ttf_writer_abandon(writer);
        return r;
    }
    bring_calibration(c, writer);
    c->continued = segment;
    c->has_continued = true;
    *ret = writer;
    return 0;
}

/* ---- moving ---- */

/* Whoever looks for the run later knows that it is not to be gone on with here. */
static int say_left(struct ttf_committer *c, struct ttf_writer *writer, const char *text)
{
    char detail[TTF_SECOND_LEFT_SIZE];

    ttf_second_put_left(ttf_writer_state(writer)->n_segments, c->ledger.next_index, detail);
    return ttf_committer_say(c, writer, text, detail);
}

/* In the first dataset, where that can still be written, if need be opened anew. Its writer, or NULL; consumed. */
static void tell_first(struct ttf_committer *c, const char *first, struct ttf_writer *writer,
                       const char *why)
{
    char text[4096 + 256];
    bool doubt = c->doubt; /* of the first one's logs */

    c->doubt = false;
    snprintf(text, sizeof(text), "%s: the run goes on in the second storage, from slot %lld on: %s",
             why, (long long)c->ledger.next_index, c->second_path);
    if (writer && say_left(c, writer, text) == 0) {
        ttf_writer_close(writer);
        return;
    }
    if (ttf_writer_open_anew(c->io, first, writer, &doubt, &writer, NULL) < 0)
        return;
    (void)say_left(c, writer, text); /* or it takes nothing more */
    ttf_writer_close(writer);
}

static void tell_second(struct ttf_committer *c, const char *first, const char *why)
{
    char text[4096 + 256];

    snprintf(text, sizeof(text), "%s: the run goes on here, from slot %lld on; before it: %s", why,
             (long long)c->ledger.next_index, first);
    (void)ttf_committer_say(c, c->writer, text, NULL);
    ttf_committer_alarm(c, TTF_ALARM_UNTIL_NEW, text);
}

int ttf_committer_move(struct ttf_committer *c, const char *why, struct ttf_slot_work *under_way)
{
    const char *first = c->path;
    struct ttf_writer *before;
    struct ttf_writer *writer = NULL;
    struct ttf_err err = {0};
    int r;

    if (c->moved || c->second_path[0] == '\0' || !c->in_force || ttf_committer_power_lost(c))
        return -ENOENT;
    if (ttf_committer_place(c) == TTF_PLACE_OTHER)
        return -ENOENT; /* nothing has failed: the run goes on in what lies there, begun again */
    r = make_second(c, &writer, &err);
    if (r < 0) {
        if (!c->second_failed)
            ttf_events_emit(c->events, "storage", "the second storage cannot be used either: %s",
                            err.what);
        c->second_failed = true;
        return r == -ENOENT ? -ENODEV : r; /* -ENOENT: there is none to try */
    }
    before = c->writer;
    c->writer = writer;
    c->path = c->second_path;
    ttf_committer_note_place(c);
    c->segment_base = c->in_force->segment.segment;
    c->plan_base = c->n_plans - 1 - c->continued.plan; /* its newest plan is the one in force */
    c->moved = true;
    c->fs_errors = 0; /* were the first one's: any here is told; its alarm stays */
    /* Before the first dataset is opened anew, which would clear them away. */
    for (struct ttf_slot_work *work = c->pending; work; work = work->next)
        fetch(c, first, work);
    if (under_way)
        fetch(c, first, under_way);
    tell_second(c, first, why);
    tell_first(c, first, before, why);
    ttf_committer_note_disk(c, false);
    return 0;
}
