/* SPDX-License-Identifier: Apache-2.0 */
/* verify_private.h: what verify's files share. */
#ifndef TTF_DATASET_VERIFY_PRIVATE_H
#define TTF_DATASET_VERIFY_PRIVATE_H

#include "named_files.h"
#include "record_line.h"
#include "ttf/dataset/manifest.h"
#include "ttf/dataset/verify.h"
#include "walk.h"

#define TTF_VERIFY_BATCH 64

/* A file to be looked at. */
struct ttf_verify_job {
    char path[200];
    char sha256[65]; /* wanted */
    int64_t bytes;   /* wanted; -1: only the hash is known */
    bool by_sums;    /* the wanted hash is of SHA256SUMS, not of a record */
    int64_t slot;
    int result; /* 0 or what went wrong reading */
    int64_t actual_bytes;
    char actual[65];
};

/* Which slots a calibration's or plan's files belong to. */
struct ttf_verify_use {
    char folder[80]; /* how their paths begin: "calibration/ID/", "plans/N." */
    int64_t first, last;
};

struct ttf_verify_run {
    struct ttf_io *io;
    const char *path;
    const struct ttf_verify_options *options;
    struct ttf_verify_report *report;
    unsigned findings_room;
    int failed; /* what kept verify from looking, sticky */
    bool has_manifest;
    struct ttf_err refusal; /* of a dataset.json of an unknown version; code 0: none */
    struct ttf_manifest manifest;
    /* from the records */
    bool records_good; /* no damaged line */
    bool in_records;   /* they are being read */
    int64_t next_index, counts[TTF_RESULT_COUNT];
    int n_segments, n_plans;
    bool ended;
    struct ttf_end_record end;
    struct ttf_paths calibrations; /* ids with a line */
    struct ttf_named_files named;
    int64_t slot;             /* of the line being read */
    char manifest_sha256[65]; /* as the segments say; empty: none did */
    int *plan_of;             /* of each segment, n_segments; -1: none */
    unsigned n_uses;
    struct ttf_verify_use *uses;
    unsigned bad_from, bad_to; /* findings of damaged lines behind the last slot's line */
    /* files waiting to be looked at */
    unsigned n_jobs;
    struct ttf_verify_job jobs[TTF_VERIFY_BATCH];
};

void ttf_verify_find(struct ttf_verify_run *run, enum ttf_severity severity, int64_t slot,
                     const char *file, const char *fmt, ...) TTF_PRINTF(5, 6);

/* Whether r is this machine's trouble and says nothing of the dataset (no memory, too many open files): then the
 * run has failed, and there is no finding. */
bool ttf_verify_kept_from(struct ttf_verify_run *run, int r);

/* Queues a file; looks at all queued when the batch is full, and when flush is called. */
void ttf_verify_queue(struct ttf_verify_run *run, const char *path, int64_t bytes,
                      const char *sha256, bool by_sums, int64_t slot);
void ttf_verify_flush(struct ttf_verify_run *run);

/* records.jsonl and events.jsonl. */
void ttf_verify_records(struct ttf_verify_run *run);
void ttf_verify_events(struct ttf_verify_run *run);

/* verify_slots.c: which slots a damaged file or line costs. */
void ttf_verify_use(struct ttf_verify_run *run, const char *folder, int64_t slot);
/* A damaged line, whose bytes these are, has been found; a good line of slot `index` has come. */
void ttf_verify_bad_line(struct ttf_verify_run *run, const char *line, size_t n);
void ttf_verify_next_slot(struct ttf_verify_run *run, int64_t index);
/* When all is found: calibrations and plans get the slots that used them. */
void ttf_verify_name_slots(struct ttf_verify_run *run);

/* notes.jsonl and samples.json. */
void ttf_verify_people(struct ttf_verify_run *run);

/* SHA256SUMS and the files of the folder, after the records. */
void ttf_verify_sums(struct ttf_verify_run *run);

#endif
