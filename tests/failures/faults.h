/* SPDX-License-Identifier: Apache-2.0 */
/* faults.h: the ways in which each operation of a run is made to fail, one after another. */
#ifndef TTF_TESTS_FAULTS_H
#define TTF_TESTS_FAULTS_H

#include "model_disk.h"

struct fault_kind {
    const char *name;
    struct model_fault fault; /* without its number */
    bool changes_only;        /* only operations that change something meet it */
    bool transfers_only;      /* only pread, pwrite and append of more than one byte */
    bool interruptible_only;  /* only those and syncs */
    bool quick;               /* worth all operations also where time is short */
};

extern const struct fault_kind fault_kinds[];
extern const unsigned n_fault_kinds;

/* Whether an operation can meet it. */
bool fault_fits(const struct fault_kind *kind, const struct model_call *call);

/* "EIO once at operation 17, sync of /m/d/records.jsonl" */
void fault_text(const struct fault_kind *kind, long at, const struct model_call *call,
                char ret[300]);

#endif
