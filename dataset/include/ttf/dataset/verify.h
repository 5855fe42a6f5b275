/* SPDX-License-Identifier: Apache-2.0 */
/*
 * verify.h: is a dataset whole? Every line, every file, the checksums and the
 * seal; repairs nothing, holds no frame in memory.
 *
 * What a crash leaves (and opening for writing repairs) is no damage: it is
 * reported as leftover. FORMAT.md says what each is.
 */
#ifndef TTF_DATASET_VERIFY_H
#define TTF_DATASET_VERIFY_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/dataset/pool.h"

enum ttf_severity {
    TTF_FINDING_LEFTOVER = 0, /* of a crash or of a running capture; harmless */
    TTF_FINDING_NOTE,         /* worth knowing, harmless */
    TTF_FINDING_DAMAGE,       /* data are lost or wrong */
    TTF_FINDING_COUNT
};

const char *ttf_severity_name(enum ttf_severity severity); /* "leftover", "note", "damage" */

struct ttf_verify_finding {
    enum ttf_severity severity;
    int64_t slot;      /* index of the (first) slot that is concerned, or -1: of no slot */
    int64_t last_slot; /* of several: the last; else the same */
    char file[200];    /* relative to the dataset, records.jsonl:LINE for a line */
    char text[256];    /* what is wrong, a sentence without a full stop */
};

/* Told now and then; from the calling thread. */
typedef void ttf_verify_progress_fn(void *ctx, int64_t files_done, int64_t bytes_done);

struct ttf_verify_options {
    bool deep;             /* hash every file; else only look whether it is there, in its size */
    struct ttf_pool *pool; /* for hashing; NULL: in this thread */
    ttf_verify_progress_fn *progress; /* NULL allowed */
    void *progress_ctx;
};

struct ttf_verify_report {
    bool damaged; /* programs exit 3 */
    bool sealed;
    char digest[65];                 /* the dataset's, empty while unsealed */
    int64_t lines;                   /* of records.jsonl and events.jsonl */
    int64_t slots, files;            /* slot lines; files named by records */
    int64_t bytes;                   /* of those files, as recorded */
    int64_t hashed_bytes;            /* read and hashed */
    int64_t n_of[TTF_FINDING_COUNT]; /* how many of each severity, those not kept too */
    unsigned n_findings;             /* kept: the first 1,000, damage before others once full */
    struct ttf_verify_finding *findings;
};

/*
 * 0 when it could be looked at, damaged or not. -ENOENT: no dataset there.
 * -ENOTSUP: of a version this one does not know. -ENOMEM. Free the report with
 * the function below, after success only.
 */
TTF_MUST_USE int ttf_verify(struct ttf_io *io, const char *path,
                            const struct ttf_verify_options *options, struct ttf_verify_report *ret,
                            struct ttf_err *err);
void ttf_verify_report_free(struct ttf_verify_report *report);

#endif
