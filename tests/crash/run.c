/* SPDX-License-Identifier: Apache-2.0 */
#include "run.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "datasets/plain_stream.h"
#include "slot_hash.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/samples.h"

#define BIG_BYTES   700 /* over a sector's end */
#define SMALL_BYTES 90

void run_init(struct run *run, struct disk *disk)
{
    memset(run, 0, sizeof(*run));
    run->disk = disk;
    run->promise.gap_ns = TTF_NS_UNKNOWN;
}

void run_break(struct run *run, enum run_fault fault, const char *format, ...)
{
    va_list args;

    if (run->broken[0])
        return;
    run->fault = fault;
    va_start(args, format);
    vsnprintf(run->broken, sizeof(run->broken), format, args);
    va_end(args);
}

void run_end(struct run *run)
{
    ttf_writer_abandon(run->writer);
    run->writer = NULL;
}

struct disk *run_fresh_disk(void)
{
    static const char text[] = "{\"of\":\"a test\"}\n";
    struct disk *disk = disk_create("/data");
    struct ttf_io *io = disk_io(disk);

    disk_hollow(disk, ".events-reserve");
    if (io->ops->mkdir(io, RUN_CALIBRATION) != 0 || io->ops->sync_dir(io, "/") != 0)
        abort();
    disk_put(disk, RUN_CALIBRATION "/calibration.json", text, sizeof(text) - 1);
    disk_put(disk, RUN_CALIBRATION "/dark.bin", text, 7);
    return disk;
}

static void fill_manifest(struct ttf_manifest *manifest)
{
    memset(manifest, 0, sizeof(*manifest));
    strcpy(manifest->uuid, "f00dcafe-0000-4000-8000-00006eec9b9f"); /* the same disk in each run */
    strcpy(manifest->software, "crash");
    plain_stream(manifest, "none");
}

static int fill_segment(struct run *run, bool corrects)
{
    const struct ttf_writer_state *state = ttf_writer_state(run->writer);
    struct ttf_segment s;
    int r;

    memset(&s, 0, sizeof(s));
    s.segment = corrects ? state->n_segments - 1 : state->n_segments;
    s.corrects = corrects;
    s.first_index = corrects ? state->last_segment.first_index : state->next_index;
    strcpy(s.trust, "none");
    strcpy(s.zone, "UTC");
    s.origin_ns = 5 * TTF_NS_PER_S;
    s.origin_utc_ns = s.uncertainty_ns = TTF_NS_UNKNOWN;
    s.interval_ns = 10 * TTF_NS_PER_S;
    s.plan = state->n_plans - 1;
    s.gap_ns =
        corrects ? (state->last_segment.gap_ns > 0 ? state->last_segment.gap_ns : 0) + 1000 : 0;
    if (corrects)
        run->promise.gap_open = true;
    else
        run->promise.segments_most = state->n_segments + 1;
    r = ttf_writer_segment(run->writer, &s, NULL);
    if (r)
        return r;
    run->promise.segments = ttf_writer_state(run->writer)->n_segments;
    run->promise.gap_ns = s.gap_ns;
    run->promise.gap_open = false;
    return 0;
}

/* ---- slots ---- */

struct file_bytes {
    char at[BIG_BYTES];
    size_t n;
};

static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    const struct file_bytes *bytes = ctx;
    int r;

    r = ttf_io_append_all(io, file, bytes->at, bytes->n / 2);
    return r ? r : ttf_io_append_all(io, file, bytes->at + bytes->n / 2, bytes->n - bytes->n / 2);
}

static int one_file(struct run *run, const struct ttf_slot_record *record, const char *role,
                    int bracket, size_t n, struct ttf_file_ref *ret)
{
    unsigned salt = run->promise.n_slots;
    struct file_bytes bytes;
    struct ttf_sha256 hash;
    char hex[65];
    size_t i;
    int r;

    bytes.n = n;
    for (i = 0; i < n; i++)
        bytes.at[i] = (char)('!' + (i * 7 + (size_t)record->index * 5 + salt * 11 + role[0]) % 90);
    r = ttf_writer_file(run->writer, role, "main", record->index, bracket, "tif", produce, &bytes,
                        ret, NULL);
    if (r)
        return r;
    ttf_sha256_init(&hash);
    ttf_sha256_add(&hash, bytes.at, bytes.n);
    ttf_sha256_hex(&hash, hex);
    if (strcmp(hex, ret->sha256) != 0 || ret->bytes != (int64_t)n)
        run_break(run, RUN_OTHER, "%s: not the sha256 or the length of what was written",
                  ret->path);
    return 0;
}

static int fill_images(struct run *run, struct ttf_slot_record *record, enum run_step step)
{
    bool bracket = step == RUN_SLOT_TWO;
    unsigned i, n = bracket ? 2 : 1;
    size_t bytes = bracket ? BIG_BYTES : SMALL_BYTES;
    struct ttf_image *image;
    int r = ttf_slot_record_images(record, n);

    for (i = 0; r == 0 && i < n; i++) {
        image = &record->images[i];
        strcpy(image->stream, "main");
        image->bracket = bracket ? (int)i : -1;
        image->n_averaged = 1;
        if (run->promise.calibrated)
            strcpy(image->calibration, "cal1");
        r = one_file(run, record, "developed", image->bracket, bytes, &image->files[0]);
        image->n_files = 1;
        if (r == 0 && step == RUN_SLOT_PAIR) {
            r = one_file(run, record, "raw", image->bracket, SMALL_BYTES, &image->files[1]);
            image->n_files = 2;
        }
    }
    return r;
}

static int do_slot(struct run *run, enum run_step step)
{
    struct run_promise *promise = &run->promise;
    struct ttf_slot_record record;
    struct run_slot *slot;
    int r = 0;

    if (promise->n_slots == RUN_SLOTS_MAX)
        return 0;
    if (ttf_writer_state(run->writer)->n_segments == 0) {
        r = fill_segment(run, false);
        if (r)
            return r;
    }
    ttf_slot_record_init(&record);
    record.index = ttf_writer_state(run->writer)->next_index;
    record.segment = ttf_writer_state(run->writer)->n_segments - 1;
    record.due_ns = (5 + 10 * record.index) * TTF_NS_PER_S + promise->n_slots;
    if (step == RUN_SLOT_NONE) {
        record.result = TTF_RESULT_MISSED;
        strcpy(record.reason, "not begun in time");
    } else {
        r = fill_images(run, &record, step);
    }
    if (r == 0) {
        slot = &promise->slots[promise->n_slots++];
        slot->index = record.index;
        slot->hash = slot_hash(&record);
        slot->kept = false;
        r = ttf_writer_commit(run->writer, &record, NULL);
        slot->kept = r == 0;
    }
    ttf_slot_record_free(&record);
    return r;
}

/* ---- the other steps ---- */

static int do_event(struct run *run)
{
    struct run_promise *promise = &run->promise;
    unsigned n = promise->n_events;
    char text[32];
    int r;

    if (n == RUN_EVENTS_MAX)
        return 0;
    promise->n_events++;
    snprintf(text, sizeof(text), "event %u.", n);
    r = ttf_writer_event(run->writer, "door", 1, TTF_NS_UNKNOWN, text, NULL, NULL);
    promise->events[n] = r == 0;
    return r;
}

static int do_note(struct run *run)
{
    struct run_promise *promise = &run->promise;
    struct ttf_note note = {.utc_ns = TTF_NS_UNKNOWN};
    unsigned n = promise->n_notes;
    int r;

    if (n == RUN_NOTES_MAX)
        return 0;
    promise->n_notes++;
    snprintf(note.text, sizeof(note.text), "note %u.", n);
    r = ttf_note_append(disk_io(run->disk), RUN_PATH, &note, NULL);
    promise->notes[n] = r == 0;
    return r;
}

static int do_sample(struct run *run)
{
    static const struct ttf_sample_rect dot = {.width = 1, .height = 1};
    struct run_promise *promise = &run->promise;
    unsigned n = promise->n_samples;
    char id[16], title[16];
    const struct ttf_sample_change changes[] = {{.id = "all", .title = title, .region = &dot},
                                                {.id = id, .region = &dot}};
    int r;

    if (n == RUN_SAMPLES_MAX)
        return 0;
    promise->n_samples++;
    snprintf(id, sizeof(id), "s%u", n);
    snprintf(title, sizeof(title), "%u", n);
    r = ttf_samples_change(disk_io(run->disk), RUN_PATH, changes, 2, NULL);
    promise->samples[n] = r == 0;
    return r;
}

static int do_plan(struct run *run)
{
    int r;

    run->promise.plans_most = ttf_writer_state(run->writer)->n_plans + 1;
    r = ttf_writer_plan(run->writer, "interval: 20s\n", "{\"interval\":20}\n", NULL);
    if (r < 0)
        return r;
    run->promise.plans = ttf_writer_state(run->writer)->n_plans;
    return 0;
}

static int do_open(struct run *run)
{
    struct ttf_manifest manifest;
    struct ttf_err err = {0};
    int r;

    r = ttf_writer_open(disk_io(run->disk), RUN_PATH, &run->writer, &err);
    if (r == -ENOENT && !run->promise.created) {
        fill_manifest(&manifest);
        memset(&err, 0, sizeof(err));
        r = ttf_writer_create(disk_io(run->disk), RUN_PATH, &manifest, "interval: 10s\n", "{}\n",
                              &run->writer, &err);
    }
    if (r) {
        if (!run->may_fail)
            run_break(run, RUN_UNOPENABLE, "cannot be opened: %s: %s", err.where, err.what);
        return r;
    }
    run->promise.created = true;
    if (run->promise.plans == 0)
        run->promise.plans = run->promise.plans_most = 1;
    return 0;
}

static int do_step(struct run *run, enum run_step step)
{
    int r = 0;

    switch (step) {
    case RUN_CREATE:
        return do_open(run);
    case RUN_SEGMENT:
        return fill_segment(run, false);
    case RUN_CORRECT:
        return ttf_writer_state(run->writer)->n_segments ? fill_segment(run, true) : 0;
    case RUN_PLAN:
        return do_plan(run);
    case RUN_CALIBRATE:
        r = ttf_writer_calibration(run->writer, "cal1", RUN_CALIBRATION, NULL);
        run->promise.calibrated = run->promise.calibrated || r == 0;
        return r;
    case RUN_SLOT_ONE:
    case RUN_SLOT_TWO:
    case RUN_SLOT_PAIR:
    case RUN_SLOT_NONE:
        return do_slot(run, step);
    case RUN_EVENT:
        return do_event(run);
    case RUN_NOTE:
        return do_note(run);
    case RUN_SAMPLE:
        return do_sample(run);
    case RUN_SEAL:
        run->promise.maybe_sealed = true;
        r = ttf_writer_seal(run->writer, "count", NULL, NULL);
        run->promise.sealed = r == 0;
        return r;
    case RUN_REOPEN:
        ttf_writer_close(run->writer);
        run->writer = NULL;
        return do_open(run);
    case RUN_ABANDON:
        run_end(run);
        return do_open(run);
    default:
        return -EINVAL;
    }
}

bool run_do(struct run *run, enum run_step step)
{
    static const char *const names[RUN_STEP_COUNT] = {
        "create", "segment", "correct", "plan",   "calibrate", "slot",   "slot",   "slot",
        "slot",   "event",   "note",    "sample", "seal",      "reopen", "abandon"};
    int r;

    if (step != RUN_NOTE && step != RUN_SAMPLE && step != RUN_SEAL && step != RUN_REOPEN &&
        step != RUN_ABANDON && step != RUN_CREATE)
        run->promise.sealed = false;
    r = do_step(run, step);
    if (r && !run->may_fail)
        run_break(run, RUN_OTHER, "%s fails: %s", names[step], strerrordesc_np(-r));
    return r == 0 && !run->broken[0];
}
