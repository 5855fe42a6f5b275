/* SPDX-License-Identifier: Apache-2.0 */
#include "judge.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "slot_hash.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/reader.h"
#include "ttf/dataset/samples.h"
#include "ttf/dataset/verify.h"

static bool starts(const char *text, const char *with)
{
    return strncmp(text, with, strlen(with)) == 0;
}

static void look_verify(struct run *run, bool clean)
{
    const struct ttf_verify_options options = {.deep = true};
    const struct ttf_verify_finding *f;
    struct ttf_verify_report report;
    struct ttf_err err = {0};
    unsigned i;
    int r;

    r = ttf_verify(disk_io(run->disk), RUN_PATH, &options, &report, &err);
    if (r) {
        run_break(run, RUN_OTHER, "verify cannot look: %s: %s", err.where, err.what);
        return;
    }
    for (i = 0; i < report.n_findings; i++) {
        f = &report.findings[i];
        if (f->severity == TTF_FINDING_DAMAGE ||
            (clean && !starts(f->file, "plans/") && !starts(f->file, "calibration/") &&
             (f->severity == TTF_FINDING_LEFTOVER || !run->promise.troubled)))
            run_break(run, RUN_OTHER, "verify%s finds %s: %s %s", clean ? " after the repair" : "",
                      ttf_severity_name(f->severity), f->file, f->text);
    }
    if (run->promise.sealed && !report.sealed)
        run_break(run, RUN_LOST, "the seal that was promised is not there");
    if (report.sealed && !run->promise.sealed && !run->promise.maybe_sealed)
        run_break(run, RUN_SHOWN, "it is sealed, and nobody asked for that");
    ttf_verify_report_free(&report);
}

/* A slot line is one that was begun; the next one that was promised is not passed over. */
static void look_slot(struct run *run, const struct ttf_slot_record *record, unsigned *next)
{
    const struct run_promise *promise = &run->promise;
    uint64_t hash = slot_hash(record);
    unsigned i;

    for (i = *next; i < promise->n_slots; i++) {
        if (promise->slots[i].index == record->index && promise->slots[i].hash == hash) {
            *next = i + 1;
            return;
        }
        if (promise->slots[i].kept) {
            run_break(run, RUN_LOST,
                      "slot %lld was promised; in its place is another record of slot %lld",
                      (long long)promise->slots[i].index, (long long)record->index);
            return;
        }
    }
    run_break(run, RUN_SHOWN, "a record of slot %lld that nobody wrote", (long long)record->index);
}

static void look_slots(struct run *run, struct ttf_reader *reader)
{
    const struct run_promise *promise = &run->promise;
    int64_t i, n = ttf_reader_summary(reader)->slots;
    struct ttf_slot_record record;
    struct ttf_err err = {0};
    unsigned next = 0;

    for (i = 0; i < n && !run->broken[0]; i++) {
        if (ttf_reader_slot(reader, i, &record, &err) != 0) {
            run_break(run, RUN_OTHER, "slot line %lld cannot be read: %s", (long long)i, err.what);
            return;
        }
        look_slot(run, &record, &next);
        ttf_slot_record_free(&record);
    }
    for (; next < promise->n_slots; next++)
        if (promise->slots[next].kept)
            run_break(run, RUN_LOST, "slot %lld was acknowledged and is lost",
                      (long long)promise->slots[next].index);
}

static void look_lines(struct run *run, struct ttf_reader *reader)
{
    const struct ttf_reader_summary *summary = ttf_reader_summary(reader);
    const struct run_promise *promise = &run->promise;
    struct ttf_segment segment;

    if (summary->n_segments < promise->segments || summary->n_plans < promise->plans)
        run_break(run, RUN_LOST, "%d segments and %d plans were acknowledged, there are %d and %d",
                  promise->segments, promise->plans, summary->n_segments, summary->n_plans);
    if (summary->n_segments > promise->segments_most || summary->n_plans > promise->plans_most)
        run_break(run, RUN_SHOWN, "there are %d segments and %d plans, more than were begun",
                  summary->n_segments, summary->n_plans);
    if (promise->calibrated && summary->n_calibrations != 1)
        run_break(run, RUN_LOST, "the calibration is lost");
    if (promise->segments > 0 && summary->n_segments == promise->segments && !promise->gap_open &&
        (ttf_reader_segment(reader, promise->segments - 1, &segment) != 0 ||
         segment.gap_ns != promise->gap_ns))
        run_break(run, RUN_OTHER, "the last segment is not as it was corrected");
}

static void look_events(struct run *run)
{
    const struct run_promise *promise = &run->promise;
    char wanted[40], *text = NULL;
    unsigned i;

    if (ttf_io_slurp(disk_io(run->disk), RUN_PATH "/events.jsonl", 1 << 24, &text, NULL, NULL)) {
        run_break(run, RUN_OTHER, "events.jsonl cannot be read");
        return;
    }
    for (i = 0; i < promise->n_events; i++) {
        snprintf(wanted, sizeof(wanted), "\"event %u.\"", i);
        if (promise->events[i] && !strstr(text, wanted))
            run_break(run, RUN_LOST, "event %u was acknowledged and is lost", i);
    }
    free(text);
}

static void tick_note(void *ctx, const struct ttf_note *note)
{
    bool *there = ctx;
    char text[32];

    for (unsigned n = 0; n < RUN_NOTES_MAX; n++) {
        snprintf(text, sizeof(text), "note %u.", n);
        there[n] = there[n] || strcmp(note->text, text) == 0;
    }
}

static void look_notes(struct run *run)
{
    const struct run_promise *promise = &run->promise;
    bool there[RUN_NOTES_MAX] = {false};
    const struct ttf_note_visitor visitor = {.note = tick_note, .ctx = there};

    if (ttf_notes_read(disk_io(run->disk), RUN_PATH, &visitor, NULL) != 0) {
        run_break(run, RUN_OTHER, "notes.jsonl cannot be read");
        return;
    }
    for (unsigned i = 0; i < RUN_NOTES_MAX; i++) {
        if (i < promise->n_notes && promise->notes[i] && !there[i])
            run_break(run, RUN_LOST, "note %u was acknowledged and is lost", i);
        if (i >= promise->n_notes && there[i])
            run_break(run, RUN_SHOWN, "there is a note %u, and nobody made it", i);
    }
}

static void look_samples(struct run *run)
{
    const struct run_promise *promise = &run->promise;
    struct ttf_sample_region *samples;
    const struct ttf_sample_region *all;
    unsigned n;

    if (ttf_samples_read(disk_io(run->disk), RUN_PATH, &samples, &n, NULL) != 0) {
        run_break(run, RUN_OTHER, "samples.json cannot be read");
        return;
    }
    all = ttf_samples_find(samples, n, "all");
    for (unsigned i = 0; i < promise->n_samples; i++) {
        char id[16];

        snprintf(id, sizeof(id), "s%u", i);
        if (promise->samples[i] &&
            (!ttf_samples_find(samples, n, id) || !all || strtoul(all->title, NULL, 10) < i))
            run_break(run, RUN_LOST, "sample %u was acknowledged and is lost", i);
    }
    if (n > promise->n_samples + 1)
        run_break(run, RUN_SHOWN, "there are %u samples, more than anybody named", n);
    free(samples);
}

void judge_look(struct run *run, bool clean)
{
    struct ttf_io *io = disk_io(run->disk);
    struct ttf_reader *reader;
    struct ttf_err err = {0};
    struct ttf_io_stat st;
    int r;

    r = io->ops->stat(io, RUN_PATH "/dataset.json", &st);
    if (r) {
        if (run->promise.created)
            run_break(run, RUN_LOST, "the dataset was there and is not any more");
        return;
    }
    look_verify(run, clean);
    r = ttf_reader_open(io, RUN_PATH, &reader, &err);
    if (r) {
        run_break(run, RUN_UNOPENABLE, "cannot be read: %s: %s", err.where, err.what);
        return;
    }
    if (run->promise.plans == 0) /* it came to be, though nobody was told */
        run->promise.plans_most = 1;
    look_slots(run, reader);
    look_lines(run, reader);
    ttf_reader_close(reader);
    look_events(run);
    look_notes(run);
    look_samples(run);
}

void judge_go_on(struct run *run, unsigned looks)
{
    bool sealed = run->promise.sealed;

    if (looks & JUDGE_BEFORE)
        judge_look(run, false);
    if (run->broken[0] || !run_do(run, RUN_CREATE))
        return;
    if ((looks & JUDGE_BETWEEN) && !sealed && !ttf_writer_state(run->writer)->sealed)
        judge_look(run, true);
    (void)(!run->broken[0] && run_do(run, RUN_SLOT_PAIR) && run_do(run, RUN_EVENT) &&
           run_do(run, RUN_SEAL));
    if (!run->broken[0])
        judge_look(run, true);
    run_end(run);
}
