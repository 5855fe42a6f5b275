/* SPDX-License-Identifier: Apache-2.0 */
/* verify: the lines of records.jsonl and events.jsonl, and what they say to each other. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "verify_private.h"

/* "records.jsonl:12" of a line's full name. */
static const char *short_name(const struct ttf_verify_run *run, const char *where)
{
    size_t n = strlen(run->path);

    return strncmp(where, run->path, n) == 0 && where[n] == '/' ? where + n + 1 : where;
}

static void bad_line(void *ctx, const char *where, const char *text, const char *line, size_t n)
{
    struct ttf_verify_run *run = ctx;
    unsigned before = run->report->n_findings;

    run->records_good = false;
    ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, short_name(run, where), "damaged line: %s", text);
    if (run->in_records && run->report->n_findings > before) /* there was room for it */
        ttf_verify_bad_line(run, line, n);
}

static void bad_field(struct ttf_verify_run *run, const struct ttf_line *line, int64_t slot,
                      const char *text)
{
    run->records_good = false;
    ttf_verify_find(run, TTF_FINDING_DAMAGE, slot, short_name(run, line->where), "%.200s", text);
}

static int take_file(void *ctx, const struct ttf_named_file *file, struct ttf_err *err)
{
    struct ttf_verify_run *run = ctx;
    int r;

    r = ttf_named_files_add(&run->named, file->path, file->sha256);
    if (r)
        run->failed = r;
    else
        ttf_verify_queue(run, file->path, file->bytes, file->sha256, false, run->slot);
    return r;
}

/* While records.jsonl is damaged the line may have been there: the folder says that the calibration was. */
static bool has_calibration(struct ttf_verify_run *run, const char *id)
{
    struct ttf_io_stat st;
    char folder[TTF_PATH_MAX];
    size_t i;

    for (i = 0; i < run->calibrations.n; i++)
        if (strcmp(run->calibrations.items[i], id) == 0)
            return true;
    return !run->records_good && ttf_path_put(folder, "%s/calibration/%s", run->path, id) == 0 &&
           run->io->ops->stat(run->io, folder, &st) == 0 && st.is_dir;
}

static void check_images(struct ttf_verify_run *run, const struct ttf_line *line,
                         const struct ttf_slot_record *record)
{
    const struct ttf_image *image;
    char text[200];
    unsigned i;

    for (i = 0; i < record->n_images; i++) {
        image = &record->images[i];
        if (image->n_files == 0 && image->lacking[0] == '\0' &&
            !json_object_get(json_array_get(json_object_get(line->json, "images"), i), "files")) {
            snprintf(text, sizeof(text), "image %u has no files and does not say why", i);
            bad_field(run, line, record->index, text);
        }
        if (image->calibration[0] && !has_calibration(run, image->calibration)) {
            snprintf(text, sizeof(text), "names calibration %s, which no line before it brought",
                     image->calibration);
            bad_field(run, line, record->index, text);
        }
        if (run->has_manifest && !ttf_manifest_stream(&run->manifest, image->stream))
            ttf_verify_find(run, TTF_FINDING_NOTE, record->index, short_name(run, line->where),
                            "has an image of stream %s, which dataset.json does not list, or not "
                            "in a way that this version knows",
                            image->stream);
    }
}

/* The files of a calibration and of a plan concern the slots that used them. */
static void note_uses(struct ttf_verify_run *run, const struct ttf_slot_record *record)
{
    char folder[sizeof(run->uses->folder)];
    unsigned i;

    for (i = 0; i < record->n_images; i++)
        if (record->images[i].calibration[0]) {
            snprintf(folder, sizeof(folder), "calibration/%s/", record->images[i].calibration);
            ttf_verify_use(run, folder, record->index);
        }
    if (record->segment < run->n_segments && run->plan_of[record->segment] >= 0) {
        snprintf(folder, sizeof(folder), "plans/%d.", run->plan_of[record->segment]);
        ttf_verify_use(run, folder, record->index);
    }
}

/* What a record must be, beyond what its reader asks for. */
static void check_slot(struct ttf_verify_run *run, const struct ttf_line *line,
                       const struct ttf_slot_record *record)
{
    unsigned i, k;

    if (record->result != TTF_RESULT_CAPTURED && record->reason[0] == '\0')
        bad_field(run, line, record->index, "it is not captured, and gives no reason");
    for (i = 0; i < record->n_images; i++) {
        if (record->images[i].lacking[0] && record->result == TTF_RESULT_CAPTURED)
            bad_field(run, line, record->index, "it is captured, but lacks an image");
        for (k = 0; k < i; k++)
            if (strcmp(record->images[k].stream, record->images[i].stream) == 0 &&
                record->images[k].bracket == record->images[i].bracket)
                bad_field(run, line, record->index,
                          "it has two images of the same stream and bracket");
    }
}

static void take_slot(struct ttf_verify_run *run, const struct ttf_line *line)
{
    struct ttf_slot_record record;
    struct ttf_err err = {0};
    const json_t *index;
    int r;

    run->report->slots++;
    run->slot = -1;
    r = ttf_slot_get(line, &record, &err);
    if (ttf_verify_kept_from(run, r))
        return;
    if (r) {
        index = json_object_get(line->json, "index");
        bad_field(run, line, json_is_integer(index) ? json_integer_value(index) : -1, err.what);
        return;
    }
    ttf_verify_next_slot(run, record.index);
    run->slot = record.index;
    if (record.index < run->next_index)
        bad_field(run, line, record.index, "its index does not rise");
    if (record.segment >= run->n_segments)
        bad_field(run, line, record.index, "its segment has no line before it");
    run->next_index = record.index + 1;
    run->counts[record.result]++;
    check_images(run, line, &record);
    check_slot(run, line, &record);
    note_uses(run, &record);
    r = ttf_line_files(line, take_file, run, &err);
    if (r == -TTF_EDAMAGED)
        bad_field(run, line, record.index, err.what);
    ttf_slot_record_free(&record);
}

/* The hash of dataset.json that segments bring is looked at once for each value of it. */
static void take_manifest(struct ttf_verify_run *run, const struct ttf_line *line,
                          const struct ttf_segment *segment)
{
    struct ttf_err err = {0};

    if (strcmp(run->manifest_sha256, segment->dataset_sha256) == 0)
        return;
    memcpy(run->manifest_sha256, segment->dataset_sha256, sizeof(run->manifest_sha256));
    if (ttf_line_files(line, take_file, run, &err) != 0 && !run->failed)
        run->failed = err.code;
}

static int learn_plan(struct ttf_verify_run *run, const struct ttf_segment *segment)
{
    int *grown;

    if (segment->segment == run->n_segments) {
        grown = reallocarray(run->plan_of, (size_t)run->n_segments + 1, sizeof(*grown));
        if (!grown)
            return -ENOMEM;
        run->plan_of = grown;
        run->n_segments++;
    }
    run->plan_of[segment->segment] = segment->plan;
    return 0;
}

static void take_segment(struct ttf_verify_run *run, const struct ttf_line *line)
{
    struct ttf_segment segment;
    struct ttf_err err = {0};

    if (ttf_segment_get(line, &segment, &err) != 0) {
        bad_field(run, line, -1, err.what);
        return;
    }
    if (segment.segment > run->n_segments)
        bad_field(run, line, -1, "its number leaves others out");
    else if (learn_plan(run, &segment) != 0)
        run->failed = -ENOMEM;
    take_manifest(run, line, &segment);
    if (segment.plan >= run->n_plans && segment.plan >= 0)
        bad_field(run, line, -1, "its plan has no line before it");
}

/* Behind a damaged line, which may have been a plan's, one may be left out. */
static int take_plan(struct ttf_verify_run *run, const struct ttf_line *line, struct ttf_err *err)
{
    bool may_lack = !run->records_good;
    int number, due = run->n_plans++, r = ttf_plan_get(line, &number, err);

    if (r == 0 && number > due && may_lack)
        run->n_plans = number + 1;
    else if (r == 0 && number != due)
        r = ttf_err_set(err, -TTF_EDAMAGED, line->where, "plan %d comes where plan %d is due",
                        number, due);
    return r;
}

static int take_calibration(struct ttf_verify_run *run, const struct ttf_line *line,
                            struct ttf_err *err)
{
    char id[64];
    int r = ttf_calibration_get(line, id, err);

    if (r == 0 && ttf_paths_add(&run->calibrations, id) != 0)
        run->failed = -ENOMEM;
    return r;
}

static int take_line(void *ctx, const struct ttf_line *line, struct ttf_err *unused)
{
    struct ttf_verify_run *run = ctx;
    struct ttf_err err = {0};
    int r;

    run->slot = -1;
    run->report->lines++;
    if (strcmp(line->type, "end") == 0) {
        run->ended = ttf_end_get(line, &run->end, &err) == 0;
        if (!run->ended)
            bad_field(run, line, -1, err.what);
        return run->failed;
    }
    if (strcmp(line->type, "slot") == 0) {
        take_slot(run, line);
    } else if (strcmp(line->type, "segment") == 0) {
        take_segment(run, line);
    } else if (strcmp(line->type, "plan") == 0 || strcmp(line->type, "calibration") == 0) {
        r = line->type[0] == 'p' ? take_plan(run, line, &err) : take_calibration(run, line, &err);
        if (r == 0)
            r = ttf_line_files(line, take_file, run, &err);
        if (r == -TTF_EDAMAGED)
            bad_field(run, line, -1, err.what);
    } else {
        return run->failed; /* of a later version */
    }
    run->ended = false;
    return run->failed;
}

/* What a crash leaves behind the last line; in a sealed dataset it has no business there. */
static void check_tail(struct ttf_verify_run *run, const char *name,
                       const struct ttf_lines_tail *tail)
{
    enum ttf_severity severity = run->report->sealed ? TTF_FINDING_DAMAGE : TTF_FINDING_LEFTOVER;

    if (tail->fragment_bytes > 0)
        ttf_verify_find(run, severity, -1, name, "ends in %lld bytes that are no whole line",
                        (long long)tail->fragment_bytes);
    else if (tail->no_newline)
        ttf_verify_find(run, severity, -1, name, "its last line lacks its newline");
}

static void scan(struct ttf_verify_run *run, const char *name, ttf_line_fn *fn,
                 enum ttf_severity if_missing)
{
    struct ttf_lines_tail tail = {0};
    char path[TTF_PATH_MAX];
    struct ttf_err err = {0};
    int r;

    r = ttf_path_put(path, "%s/%s", run->path, name);
    if (r == 0)
        r = ttf_lines_scan(run->io, path, fn, bad_line, run, &tail, &err);
    if (r == -ENOENT)
        ttf_verify_find(run, if_missing, -1, name, "is missing");
    else if (r && !ttf_verify_kept_from(run, r))
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, name, "%.200s", err.what);
    if (r)
        run->records_good = run->records_good && if_missing != TTF_FINDING_DAMAGE;
    check_tail(run, name, &tail);
}

void ttf_verify_records(struct ttf_verify_run *run)
{
    const int64_t *c = run->counts;
    const struct ttf_end_record *e = &run->end;

    run->in_records = true;
    scan(run, "records.jsonl", take_line, TTF_FINDING_DAMAGE);
    run->in_records = false;
    run->slot = -1;
    if (run->ended && run->records_good &&
        (e->slots != run->report->slots || e->captured != c[TTF_RESULT_CAPTURED] ||
         e->partial != c[TTF_RESULT_PARTIAL] || e->missed != c[TTF_RESULT_MISSED] ||
         e->failed != c[TTF_RESULT_FAILED] || e->paused != c[TTF_RESULT_PAUSED] ||
         e->power != c[TTF_RESULT_POWER]))
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, "records.jsonl",
                        "the \"end\" line counts %lld slots, but there are %lld, or its other "
                        "counts differ",
                        (long long)e->slots, (long long)run->report->slots);
    if (run->report->sealed && !run->ended)
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, "records.jsonl",
                        "is sealed, but does not close with an \"end\" line");
}

static int take_event(void *ctx, const struct ttf_line *line, struct ttf_err *err)
{
    struct ttf_verify_run *run = ctx;

    run->report->lines++;
    return 0;
}

void ttf_verify_events(struct ttf_verify_run *run)
{
    bool good = run->records_good;

    scan(run, "events.jsonl", take_event, TTF_FINDING_NOTE);
    run->records_good = good;
}
