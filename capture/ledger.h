/* SPDX-License-Identifier: Apache-2.0 */
/*
 * ledger.h: every slot ends as exactly one record. The ledger knows which index
 * is next, refuses a second record or a hole, judges what became of a slot, and
 * counts. Pure.
 */
#ifndef TTF_CAPTURE_PRIVATE_LEDGER_H
#define TTF_CAPTURE_PRIVATE_LEDGER_H

#include "quantile.h"
#include "ttf/base/attr.h"
#include "ttf/dataset/record.h"

/* Reasons, as they stand in records. README.md says what brings each about. */
#define TTF_REASON_STORAGE_SLOW "storage too slow"
#define TTF_REASON_DISK_FULL    "disk full"
#define TTF_REASON_READ_ONLY    "storage can only be read"
#define TTF_REASON_IO_ERROR     "storage error"
#define TTF_REASON_LATE         "previous slot took too long"
#define TTF_REASON_RECOVERING   "camera recovering"
#define TTF_REASON_NO_CAMERA    "camera does not deliver"
#define TTF_REASON_NO_TIME      "no time left in the slot"
#define TTF_REASON_NO_POWER     "the box was without power"
#define TTF_REASON_NOT_RUNNING  "the program was not running"
#define TTF_REASON_STOPPED      "stopped by a person"
#define TTF_REASON_TRYING       "the run could not go on"
#define TTF_REASON_NOT_READY    "the box was getting ready"
#define TTF_REASON_HAD_ENDED    "the run had come to its end"
#define TTF_REASON_BEFORE_START "the capture began after this slot"
#define TTF_REASON_PAUSED       "paused by a person"
#define TTF_REASON_NO_MEMORY    "out of memory"

struct ttf_ledger {
    int64_t next_index; /* the slot whose record comes next */
    int64_t counts[TTF_RESULT_COUNT];
    struct ttf_quantile error;  /* abs(middle - due) of captured slots */
    struct ttf_quantile wakeup; /* how late the loop woke */
};

/*
 * What became of a slot, from its images: captured if all were taken, failed if
 * none, else partial; fills result and, with the first thing lacking, reason.
 * A record that says missed, paused or power already is left alone.
 */
void ttf_ledger_judge(struct ttf_slot_record *record);

/* Counts a record. -EEXIST for an index that has its record, -ERANGE for one that leaves a hole. */
TTF_MUST_USE int ttf_ledger_add(struct ttf_ledger *ledger, const struct ttf_slot_record *record);

#endif
