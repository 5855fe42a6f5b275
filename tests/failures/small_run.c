/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "datasets/plain_stream.h"
#include "small_run.h"
#include "ttf/dataset/hash.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/samples.h"
#include "ttf/dataset/verify.h"

#define FILE_BYTES 300

void small_disk_init(struct model_disk *disk)
{
    struct ttf_io *io = &disk->io;

    model_disk_init(disk);
    assert_int_equal(ttf_io_mkdirs(io, "/m/cal", NULL), 0);
    assert_int_equal(ttf_io_write_file(io, "/m/cal/calibration.json", "{}\n", 3, NULL), 0);
    assert_int_equal(ttf_io_write_file(io, "/m/cal/flat.npy", "not read here", 13, NULL), 0);
}

static void manifest_of(struct ttf_manifest *manifest)
{
    assert_int_equal(ttf_manifest_init(manifest, NULL), 0);
    plain_stream(manifest, "linear-srgb");
}

static void segment_of(struct ttf_segment *s)
{
    *s = (struct ttf_segment){.origin_ns = 5 * TTF_NS_PER_S,
                              .origin_utc_ns = INT64_C(1790000000000000000),
                              .uncertainty_ns = TTF_NS_PER_S,
                              .interval_ns = 10 * TTF_NS_PER_S};
    strcpy(s->boot_id, "0a0b0c0d-0000-4000-8000-000000000001");
    strcpy(s->trust, "rtc");
    strcpy(s->zone, "UTC");
}

/* ---- the steps ---- */

typedef int step_fn(struct small_run *run, int64_t arg, struct ttf_err *err);

static int do_create(struct small_run *run, int64_t arg, struct ttf_err *err)
{
    struct ttf_manifest manifest;

    manifest_of(&manifest);
    return ttf_writer_create(run->io, SMALL_PATH, &manifest, "interval: 10s\n", "{}\n",
                             &run->writer, err);
}

static int do_segment(struct small_run *run, int64_t corrects, struct ttf_err *err)
{
    struct ttf_segment segment;

    segment_of(&segment);
    segment.corrects = corrects != 0;
    segment.origin_utc_ns += corrects;
    return ttf_writer_segment(run->writer, &segment, err);
}

static void bytes_of(int64_t index, char ret[FILE_BYTES])
{
    for (int i = 0; i < FILE_BYTES; i++)
        ret[i] = (char)('a' + (i * 7 + index) % 26);
}

/* Even slots from front to back; odd ones with their beginning last, as a TIFF's. */
static int produce(void *ctx, struct ttf_io *io, int file, struct ttf_err *err)
{
    int64_t index = *(int64_t *)ctx;
    char bytes[FILE_BYTES];
    int r;

    bytes_of(index, bytes);
    if (index % 2 == 0) {
        r = ttf_io_append_all(io, file, bytes, 100);
        return r ? r : ttf_io_append_all(io, file, bytes + 100, FILE_BYTES - 100);
    }
    r = ttf_io_pwrite_all(io, file, bytes + 8, FILE_BYTES - 8, 8);
    return r ? r : ttf_io_pwrite_all(io, file, bytes, 8, 0);
}

static int add_file(struct small_run *run, struct ttf_image *image, int64_t index, const char *role,
                    struct ttf_err *err)
{
    int r = ttf_writer_file(run->writer, role, "main", index, -1, "tif", produce, &index,
                            &image->files[image->n_files], err);

    image->n_files += r == 0;
    return r;
}

static int fill_slot(struct small_run *run, struct ttf_slot_record *record, int64_t index,
                     struct ttf_err *err)
{
    struct ttf_image *image;
    int r;

    record->index = index;
    record->due_ns = (5 + 10 * index) * TTF_NS_PER_S;
    if (index == SMALL_SLOTS - 1) {
        record->result = TTF_RESULT_MISSED;
        strcpy(record->reason, "storage too slow");
        return 0;
    }
    if (ttf_slot_record_images(record, 1) != 0)
        return ttf_err_set(err, -ENOMEM, "slot", "no memory");
    image = &record->images[0];
    strcpy(image->stream, "main");
    image->n_averaged = 1;
    r = index % 2 ? add_file(run, image, index, "raw", err) : 0;
    return r ? r : add_file(run, image, index, "developed", err);
}

static int do_slot(struct small_run *run, int64_t index, struct ttf_err *err)
{
    struct ttf_slot_record record;
    int r;

    if (ttf_writer_state(run->writer)->next_index > index)
        return 0; /* it had got there after all */
    ttf_slot_record_init(&record);
    r = fill_slot(run, &record, index, err);
    if (r == 0) {
        run->tried[index] = true;
        r = ttf_writer_commit(run->writer, &record, err);
    }
    ttf_slot_record_free(&record);
    return r;
}

static int do_event(struct small_run *run, int64_t arg, struct ttf_err *err)
{
    int r = ttf_writer_event(run->writer, "door", 1, 2, "opened", "{\"n\": 1}", err);

    run->events += r == 0;
    return r;
}

static int do_calibration(struct small_run *run, int64_t arg, struct ttf_err *err)
{
    return ttf_writer_calibration(run->writer, "lens-1", "/m/cal", err);
}

static int do_plan(struct small_run *run, int64_t arg, struct ttf_err *err)
{
    int r = ttf_writer_plan(run->writer, "interval: 20s\n", "{\"n\": 2}\n", err);

    return r > 0 ? 0 : r;
}

static int do_note(struct small_run *run, int64_t n, struct ttf_err *err)
{
    struct ttf_note note = {.utc_ns = 1};

    snprintf(note.text, sizeof(note.text), "note %d", (int)n);
    return ttf_note_append(run->io, SMALL_PATH, &note, err);
}

static int do_sample(struct small_run *run, int64_t n, struct ttf_err *err)
{
    static const struct ttf_sample_rect dot = {.width = 1, .height = 1};
    const char id[] = {(char)('0' + n), '\0'};
    const struct ttf_sample_change change = {.id = id, .title = "grass", .region = &dot};

    return ttf_samples_change(run->io, SMALL_PATH, &change, 1, err);
}

static int do_seal(struct small_run *run, int64_t arg, struct ttf_err *err)
{
    char digest[65];

    return ttf_writer_seal(run->writer, "count", digest, err);
}

static int do_open(struct small_run *run, int64_t arg, struct ttf_err *err)
{
    return run->writer ? 0 : ttf_writer_open(run->io, SMALL_PATH, &run->writer, err);
}

/* ---- the caller ---- */

/* An error must say what it is, by the number that was returned. */
static int told(struct small_run *run, const char *name, int r, const struct ttf_err *err)
{
    if (r == 0)
        return r;
    if (run->refusals++ == 0)
        run->first_code = r;
    snprintf(run->refused, sizeof(run->refused), "%s: %s: %s (%d)", name, err->where, err->what, r);
    if (run->silent == 0 && (err->code != r || err->what[0] == '\0')) {
        run->silent = r;
        run->silent_in = name;
    }
    return r;
}

static int open_anew(struct small_run *run)
{
    int r = -EIO;

    for (int i = 0; i < 3 && r; i++) {
        struct ttf_writer *old = run->writer;
        struct ttf_err err = {0};

        run->writer = NULL;
        r = ttf_writer_open_anew(run->io, SMALL_PATH, old, &run->doubt, &run->writer, &err);
        (void)told(run, "open anew", r, &err);
    }
    return r;
}

/* 0: done, acknowledged. */
static int step(struct small_run *run, const char *name, step_fn *fn, int64_t arg)
{
    struct ttf_err err = {0};
    int r = -EIO;

    if (run->over)
        return r;
    r = told(run, name, fn(run, arg, &err), &err);
    if (r && run->temper == SMALL_GIVES_UP) {
        run->over = true;
    } else if (r && fn != do_create && run->temper == SMALL_PERSISTS) {
        run->over = open_anew(run) != 0;
        if (run->over)
            return r;
        err = (struct ttf_err){0};
        r = told(run, name, fn(run, arg, &err), &err);
    } else if (r) {
        err = (struct ttf_err){0};
        r = told(run, name, fn(run, arg, &err), &err);
        run->over = r != 0;
    }
    return r;
}

static void slot(struct small_run *run, int64_t index)
{
    int r = step(run, "slot", do_slot, index);

    if (r == 0)
        run->committed[index] = true;
}

static void note(struct small_run *run, int64_t n)
{
    if (step(run, "note", do_note, n) == 0)
        run->noted[n] = true;
}

static void sample(struct small_run *run, int64_t n)
{
    if (step(run, "sample", do_sample, n) == 0)
        run->named[n] = true;
}

/* What is added takes the seal away, if only for as long as it takes to fail. */
static void seal(struct small_run *run)
{
    run->sealed = step(run, "seal", do_seal, 0) == 0;
}

static void unseal(struct small_run *run)
{
    run->sealed = run->sealed && run->over;
}

void small_run(struct small_run *run)
{
    run->created = step(run, "create", do_create, 0) == 0;
    (void)step(run, "segment", do_segment, 0);
    slot(run, 0);
    slot(run, 1);
    (void)step(run, "event", do_event, 0);
    note(run, 0);
    note(run, 1);
    sample(run, 0);
    sample(run, 1);
    (void)step(run, "calibration", do_calibration, 0);
    (void)step(run, "plan", do_plan, 0);
    (void)step(run, "correction", do_segment, 1000);
    slot(run, 2);
    seal(run);
    if (!run->over) {
        ttf_writer_close(run->writer);
        run->writer = NULL;
    }
    (void)step(run, "open", do_open, 0);
    unseal(run);
    slot(run, 3);
    (void)step(run, "event", do_event, 0);
    slot(run, 4);
    seal(run);
    note(run, 2);
    sample(run, 2);
    ttf_writer_close(run->writer);
    run->writer = NULL;
}

/* ---- what must hold ---- */

/* The first thing that is wrong ends the check. */
#define WRONG(...) return (void)snprintf(ret, SMALL_TEXT, __VA_ARGS__), false

static bool whole(struct ttf_io *io, bool sealed, char ret[SMALL_TEXT])
{
    struct ttf_verify_options options = {.deep = true};
    struct ttf_verify_report report;
    struct ttf_err err = {0};
    bool ok;

    if (ttf_verify(io, SMALL_PATH, &options, &report, &err) != 0)
        WRONG("verify: %s: %s", err.where, err.what);
    ok = !report.damaged && (report.sealed || !sealed);
    if (!ok)
        snprintf(ret, SMALL_TEXT, "the seal is gone");
    for (unsigned i = 0; i < report.n_findings; i++)
        if (report.findings[i].severity == TTF_FINDING_DAMAGE)
            snprintf(ret, SMALL_TEXT, "damage: %s: %s", report.findings[i].file,
                     report.findings[i].text);
    ttf_verify_report_free(&report);
    return ok;
}

static bool file_holds(struct ttf_io *io, const struct ttf_file_ref *file, int64_t index,
                       char ret[SMALL_TEXT])
{
    char path[300], want[FILE_BYTES], *text = NULL;
    struct ttf_err err = {0};
    size_t n = 0;
    bool same;

    snprintf(path, sizeof(path), SMALL_PATH "/%s", file->path);
    bytes_of(index, want);
    if (ttf_io_slurp(io, path, 1000, &text, &n, &err) != 0)
        WRONG("%s: %s", path, err.what);
    same = n == FILE_BYTES && memcmp(text, want, FILE_BYTES) == 0;
    free(text);
    if (!same)
        WRONG("%s has not the bytes that were written", path);
    return true;
}

static bool slot_holds(const struct small_run *run, struct ttf_io *io,
                       const struct ttf_slot_record *record, bool ghosts, char ret[SMALL_TEXT])
{
    int64_t index = record->index;

    if (index < 0 || index >= SMALL_SLOTS || !run->tried[index] ||
        (!run->committed[index] && !ghosts))
        WRONG("slot %d was not committed and is shown", (int)index);
    for (unsigned k = 0; record->n_images && k < record->images[0].n_files; k++)
        if (!file_holds(io, &record->images[0].files[k], index, ret))
            return false;
    return true;
}

static bool slots_hold(const struct small_run *run, struct ttf_io *io, bool ghosts,
                       char ret[SMALL_TEXT])
{
    struct ttf_slot_record record;
    struct ttf_reader *reader;
    struct ttf_err err = {0};
    bool ok = true;
    int64_t i;

    if (ttf_reader_open(io, SMALL_PATH, &reader, &err) != 0)
        WRONG("%s: %s", err.where, err.what);
    for (i = 0; ok && i < SMALL_SLOTS; i++) {
        ok = !run->committed[i] || ttf_reader_find(reader, i) >= 0;
        if (!ok)
            snprintf(ret, SMALL_TEXT, "slot %d was committed and is lost", (int)i);
    }
    for (i = 0; ok && i < ttf_reader_summary(reader)->slots; i++) {
        ok = ttf_reader_slot(reader, i, &record, &err) == 0;
        if (!ok) {
            snprintf(ret, SMALL_TEXT, "%s: %s", err.where, err.what);
            break;
        }
        ok = slot_holds(run, io, &record, ghosts, ret);
        ttf_slot_record_free(&record);
    }
    ttf_reader_close(reader);
    return ok;
}

struct notes_seen {
    bool there[SMALL_NOTES];
    unsigned wrong;
};

static void see_note(void *ctx, const struct ttf_note *note)
{
    struct notes_seen *seen = ctx;
    int n = note->text[5] - '0';

    if (strncmp(note->text, "note ", 5) == 0 && n >= 0 && n < SMALL_NOTES)
        seen->there[n] = true;
    else
        seen->wrong++;
}

static void see_wrong(void *ctx, int64_t line, const char *what)
{
    ((struct notes_seen *)ctx)->wrong++;
}

static bool notes_hold(const struct small_run *run, struct ttf_io *io, char ret[SMALL_TEXT])
{
    struct notes_seen seen = {0};
    const struct ttf_note_visitor visitor = {see_note, see_wrong, &seen};
    struct ttf_err err = {0};

    if (ttf_notes_read(io, SMALL_PATH, &visitor, &err) != 0)
        WRONG("%s: %s", err.where, err.what);
    if (seen.wrong)
        WRONG("%u lines of notes.jsonl are none", seen.wrong);
    for (int i = 0; i < SMALL_NOTES; i++)
        if (run->noted[i] && !seen.there[i])
            WRONG("note %d was acknowledged and is lost", i);
    return true;
}

static bool samples_hold(const struct small_run *run, struct ttf_io *io, char ret[SMALL_TEXT])
{
    struct ttf_sample_region *samples;
    struct ttf_err err = {0};
    bool there[SMALL_SAMPLES];
    unsigned n;

    if (ttf_samples_read(io, SMALL_PATH, &samples, &n, &err) != 0)
        WRONG("%s: %s", err.where, err.what);
    for (int i = 0; i < SMALL_SAMPLES; i++) {
        const char id[] = {(char)('0' + i), '\0'};
        const struct ttf_sample_region *sample = ttf_samples_find(samples, n, id);

        there[i] = sample && strcmp(sample->title, "grass") == 0;
    }
    free(samples);
    for (int i = 0; i < SMALL_SAMPLES; i++)
        if (run->named[i] && !there[i])
            WRONG("sample %d was acknowledged and is lost", i);
    return true;
}

/* Another caller comes, on a disk that works. */
static bool goes_on(struct small_run *after, struct model_disk *disk, char ret[SMALL_TEXT])
{
    *after = (struct small_run){.io = &disk->io, .temper = SMALL_GIVES_UP};
    if (model_disk_has(disk, SMALL_PATH "/dataset.json"))
        (void)step(after, "open", do_open, 0);
    else
        (void)step(after, "create", do_create, 0);
    if (!after->over && ttf_writer_state(after->writer)->n_segments == 0)
        (void)step(after, "segment", do_segment, 0);
    (void)step(after, "slot", do_slot, SMALL_SLOTS - 1);
    (void)step(after, "event", do_event, 0);
    note(after, SMALL_NOTES - 1);
    sample(after, SMALL_SAMPLES - 1);
    (void)step(after, "calibration", do_calibration, 0);
    (void)step(after, "seal", do_seal, 0);
    ttf_writer_close(after->writer);
    if (after->over)
        WRONG("going on: %s", after->refused);
    return whole(&disk->io, true, ret);
}

bool small_check(const struct small_run *run, struct model_disk *disk, bool ghosts,
                 char ret[SMALL_TEXT])
{
    bool there = model_disk_has(disk, SMALL_PATH "/dataset.json");
    struct small_run after;

    model_disk_fail(disk, (struct model_fault){0});
    if (run->created && !there)
        WRONG("the dataset was created and is gone");
    if (there && (!whole(&disk->io, run->sealed, ret) || !slots_hold(run, &disk->io, ghosts, ret) ||
                  !notes_hold(run, &disk->io, ret) || !samples_hold(run, &disk->io, ret)))
        return false;
    if (!goes_on(&after, disk, ret))
        return false;
    memcpy(after.committed, run->committed, sizeof(after.committed));
    memcpy(after.tried, run->tried, sizeof(after.tried));
    for (int i = 0; i < SMALL_NOTES; i++)
        after.noted[i] = after.noted[i] || run->noted[i];
    for (int i = 0; i < SMALL_SAMPLES; i++)
        after.named[i] = after.named[i] || run->named[i];
    after.tried[SMALL_SLOTS - 1] = true;
    if (!slots_hold(&after, &disk->io, true, ret) || !notes_hold(&after, &disk->io, ret) ||
        !samples_hold(&after, &disk->io, ret))
        return false;
    if (model_disk_open_handles(disk) != 0)
        WRONG("a handle was left open");
    return true;
}
