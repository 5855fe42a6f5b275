/* SPDX-License-Identifier: Apache-2.0 */
/* rehearsal.h: what a rehearsal measures. One thread at a time, but for expose (loop). */
#ifndef TTF_CAPTURE_PRIVATE_REHEARSAL_H
#define TTF_CAPTURE_PRIVATE_REHEARSAL_H

#include <stdint.h>

#include "ttf/dataset/calibration.h"
#include "ttf/dataset/record.h"

struct ttf_rehearsal {
    double headroom_stops;          /* the least seen; INFINITY before the first */
    double sharpness;               /* of the last image that has one; NAN */
    double first_level, last_level; /* of the first shot, raw, above black; NAN */
    int64_t busy_ns;                /* the longest, from first lamp command to commit */
    int64_t expose_ns;  /* the longest, from first lamp command to the last frame: loop's */
    int64_t commit_ns;  /* the longest, of the committer's work on a slot */
    int64_t slot_bytes; /* the largest */
};

void ttf_rehearsal_init(struct ttf_rehearsal *rehearsal);

/* Looks at one image's raw sum before it is given back. shot: which of the plan's. */
void ttf_rehearsal_image(struct ttf_rehearsal *rehearsal, unsigned shot,
                         const struct ttf_raw_sum *raw, const struct ttf_image *image);

/* After a slot's commit. */
void ttf_rehearsal_slot(struct ttf_rehearsal *rehearsal, const struct ttf_slot_record *record,
                        int64_t busy_ns, int64_t commit_ns);

/*
 * Stops between the level that all but one in a thousand samples stay under and
 * saturation; 0 if they do saturate.
 */
double ttf_raw_headroom_stops(const struct ttf_raw_sum *raw);

#endif
