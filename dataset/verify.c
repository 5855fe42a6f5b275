/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/verify.h"

#include <errno.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io_path.h"
#include "json_read.h"
#include "sums.h"
#include "ttf/dataset/hash.h"
#include "verify_private.h"

#define FINDINGS_MAX 1000u

const char *ttf_severity_name(enum ttf_severity severity)
{
    static const char *const names[] = {"leftover", "note", "damage"};

    return (unsigned)severity < TTF_FINDING_COUNT ? names[severity] : "unknown";
}

/* Room for one more finding; when full, damage takes the place of something milder. */
static struct ttf_verify_finding *place(struct ttf_verify_run *run, enum ttf_severity severity)
{
    struct ttf_verify_report *report = run->report;
    struct ttf_verify_finding *grown;
    unsigned i, room;

    if (report->n_findings == FINDINGS_MAX) {
        for (i = FINDINGS_MAX; severity == TTF_FINDING_DAMAGE && i-- > 0;)
            if (report->findings[i].severity != TTF_FINDING_DAMAGE)
                return &report->findings[i];
        return NULL;
    }
    if (report->n_findings == run->findings_room) {
        room = run->findings_room ? run->findings_room * 2 : 16;
        grown = reallocarray(report->findings, room, sizeof(*grown));
        if (!grown) {
            run->failed = -ENOMEM;
            return NULL;
        }
        report->findings = grown;
        run->findings_room = room;
    }
    return &report->findings[report->n_findings++];
}

void ttf_verify_find(struct ttf_verify_run *run, enum ttf_severity severity, int64_t slot,
                     const char *file, const char *fmt, ...)
{
    struct ttf_verify_finding *finding;
    va_list args;

    run->report->n_of[severity]++;
    if (severity == TTF_FINDING_DAMAGE)
        run->report->damaged = true;
    finding = place(run, severity);
    if (!finding)
        return;
    memset(finding, 0, sizeof(*finding)); /* equal findings are equal bytes */
    finding->severity = severity;
    finding->slot = finding->last_slot = slot;
    ttf_text_cut(finding->file, sizeof(finding->file), file);
    va_start(args, fmt);
    vsnprintf(finding->text, sizeof(finding->text), fmt, args);
    va_end(args);
}

bool ttf_verify_kept_from(struct ttf_verify_run *run, int r)
{
    if (r != -ENOMEM && r != -EMFILE && r != -ENFILE)
        return false;
    run->failed = r;
    return true;
}

static void look_at(void *ctx, unsigned tile, unsigned worker)
{
    struct ttf_verify_run *run = ctx;
    struct ttf_verify_job *job = &run->jobs[tile];
    struct ttf_io *io = run->io;
    char full[1024];
    int file;

    if (snprintf(full, sizeof(full), "%s/%s", run->path, job->path) >= (int)sizeof(full)) {
        job->result = -ENAMETOOLONG;
        return;
    }
    file = io->ops->open(io, full, TTF_IO_READ);
    job->result = file < 0 ? file : io->ops->size(io, file, &job->actual_bytes);
    if (job->result == 0 && run->options->deep &&
        (job->bytes < 0 || job->bytes == job->actual_bytes))
        job->result = ttf_sha256_handle(io, file, NULL, job->actual);
    if (file >= 0)
        io->ops->close(io, file);
}

static void judge(struct ttf_verify_run *run, const struct ttf_verify_job *job)
{
    if (ttf_verify_kept_from(run, job->result))
        return;
    if (job->result == -ENOENT || job->result == -ENOTDIR)
        ttf_verify_find(run, TTF_FINDING_DAMAGE, job->slot, job->path, "is missing%s",
                        job->by_sums ? ", but " TTF_SUMS_NAME " lists it" : "");
    else if (job->result)
        ttf_verify_find(run, TTF_FINDING_DAMAGE, job->slot, job->path, "cannot be read: %s",
                        strerrordesc_np(-job->result));
    else if (job->bytes >= 0 && job->bytes != job->actual_bytes)
        ttf_verify_find(run, TTF_FINDING_DAMAGE, job->slot, job->path,
                        "is %lld bytes long, but its record says %lld",
                        (long long)job->actual_bytes, (long long)job->bytes);
    else if (run->options->deep && strcmp(job->actual, job->sha256) != 0)
        ttf_verify_find(run, TTF_FINDING_DAMAGE, job->slot, job->path,
                        "has changed: its sha256 is not the one in %s",
                        job->by_sums ? TTF_SUMS_NAME " (or that one is wrong)" : "records.jsonl");
    if (job->actual[0])
        run->report->hashed_bytes += job->actual_bytes;
}

void ttf_verify_flush(struct ttf_verify_run *run)
{
    unsigned i;

    ttf_pool_run(run->options->pool, run->n_jobs, look_at, run);
    for (i = 0; i < run->n_jobs; i++)
        judge(run, &run->jobs[i]);
    run->report->files += run->n_jobs;
    run->n_jobs = 0;
    if (run->options->progress)
        run->options->progress(run->options->progress_ctx, run->report->files,
                               run->report->hashed_bytes);
}

void ttf_verify_queue(struct ttf_verify_run *run, const char *path, int64_t bytes,
                      const char *sha256, bool by_sums, int64_t slot)
{
    struct ttf_verify_job *job = &run->jobs[run->n_jobs++];

    memset(job, 0, sizeof(*job));
    ttf_text_cut(job->path, sizeof(job->path), path);
    memcpy(job->sha256, sha256, 64);
    job->bytes = bytes;
    job->by_sums = by_sums;
    job->slot = slot;
    if (bytes > 0)
        run->report->bytes += bytes;
    if (run->n_jobs == TTF_VERIFY_BATCH)
        ttf_verify_flush(run);
}

static int check_manifest(struct ttf_verify_run *run, struct ttf_err *err)
{
    struct ttf_err local = {0};
    int r;

    r = ttf_manifest_load(run->io, run->path, &run->manifest, &local);
    run->has_manifest = r == 0;
    if (r == -ENOTSUP) {
        run->refusal = local;
        return 0;
    }
    if (r == -EINVAL) {
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, "dataset.json", "%.200s", local.what);
        return 0;
    }
    if (r && err)
        *err = local;
    return r;
}

/*
 * A version that this one does not know may be true, or a flipped bit: if the records or
 * the seal say that dataset.json has changed, it is damage; else there is nothing to be said.
 */
static int check_refusal(const struct ttf_verify_run *run, struct ttf_err *err)
{
    const struct ttf_verify_report *report = run->report;
    unsigned i;

    if (!run->refusal.code)
        return 0;
    for (i = 0; i < report->n_findings; i++)
        if (report->findings[i].severity == TTF_FINDING_DAMAGE &&
            strcmp(report->findings[i].file, "dataset.json") == 0)
            return 0;
    if (err)
        *err = run->refusal;
    return run->refusal.code;
}

static int check_all(struct ttf_verify_run *run, struct ttf_err *err)
{
    char sums[TTF_PATH_MAX];
    int r;

    r = check_manifest(run, err);
    if (r)
        return r;
    r = ttf_sums_sealed(run->io, run->path, &run->report->sealed, err);
    if (r)
        return r;
    if (run->report->sealed && run->has_manifest && run->manifest.rehearsal)
        ttf_verify_find(run, TTF_FINDING_DAMAGE, -1, "dataset.json",
                        "says that it is a rehearsal, which is not to be sealed");
    ttf_verify_records(run);
    ttf_verify_events(run);
    ttf_verify_flush(run);
    ttf_named_files_sort(&run->named);
    ttf_verify_sums(run);
    ttf_verify_flush(run);
    ttf_verify_people(run);
    ttf_verify_name_slots(run);
    if (run->failed)
        return ttf_err_set(err, run->failed, run->path, "cannot be verified: %s",
                           strerrordesc_np(-run->failed));
    r = check_refusal(run, err);
    if (r || !run->report->sealed)
        return r;
    r = ttf_path_put(sums, "%s/" TTF_SUMS_NAME, run->path);
    return r ? ttf_err_set(err, r, run->path, "the path is too long")
             : ttf_sha256_file(run->io, sums, NULL, run->report->digest, err);
}

int ttf_verify(struct ttf_io *io, const char *path, const struct ttf_verify_options *options,
               struct ttf_verify_report *ret, struct ttf_err *err)
{
    struct ttf_verify_run *run = calloc(1, sizeof(*run));
    struct ttf_verify_report report = {0};
    int r;

    if (!run)
        return ttf_err_set(err, -ENOMEM, path, "no memory");
    run->io = io;
    run->path = path;
    run->options = options;
    run->report = &report;
    run->records_good = true;
    run->slot = -1;
    r = check_all(run, err);
    if (r == 0)
        *ret = report;
    else
        ttf_verify_report_free(&report);
    ttf_named_files_free(&run->named);
    ttf_paths_free(&run->calibrations);
    free(run->uses);
    free(run->plan_of);
    free(run);
    return r;
}

void ttf_verify_report_free(struct ttf_verify_report *report)
{
    if (!report)
        return;
    free(report->findings);
    *report = (struct ttf_verify_report){0};
}
