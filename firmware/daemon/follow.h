/* SPDX-License-Identifier: Apache-2.0 */
/* follow.h: the records of the run under way, read as they come: what the situation knows of slots stands on the disk. */
#ifndef DAEMON_FOLLOW_H
#define DAEMON_FOLLOW_H

#include "parts.h"
#include "ttf/dataset/growth.h"

struct follow {
    char dataset[65], second[512];
    struct ttf_growth
        growth[COURSE_PARTS]; /* where it began; where it went on when that storage failed */
    bool missing;             /* one of them could not be read: it may come late */
};

/* What is new, into the situation; the last slot's lamps and sensors as an event. */
void follow_read(struct follow *follow, struct daemon *d);

/* The situation has come to be about another dataset than the one that was read last, or about a second storage of it. */
bool follow_elsewhere(const struct follow *follow, struct daemon *d);

/* Lamps and sensors of a record, as the status has them; by malloc, NULL: no memory. */
char *follow_readings(const struct ttf_slot_record *record);

#endif
