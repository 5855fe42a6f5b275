/* SPDX-License-Identifier: Apache-2.0 */
/*
 * course.h: how far a run has come, as its records and its letters tell it: slots by result, the grid, what comes next, the
 * newest readings. Its records lie in up to two parts: in the first storage, and, where that failed, in the second
 * one from some slot on. What is read in which order, and when, makes no difference. Locked by whoever has it.
 */
#ifndef DAEMON_COURSE_H
#define DAEMON_COURSE_H

#include <stdbool.h>
#include <stdint.h>

#include "mailbox.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/dataset/record.h"

#define COURSE_TAIL \
    16 /* slots that both parts may have: in truth the one under way when the storage failed */

enum course_part {
    COURSE_FIRST = 0,
    COURSE_SECOND,
    COURSE_PARTS
};

struct course_records {
    bool has_segment;
    struct ttf_segment segment; /* the newest */
    int64_t first_index;        /* of its first segment */
    int64_t last_index;         /* of a record that was counted; -1: none */
    int64_t counts[TTF_RESULT_COUNT];
    struct {
        int64_t index; /* -1: none */
        enum ttf_result result;
    } tail[COURSE_TAIL]; /* by index */
};

struct course {
    int64_t total;              /* slots; 0: not known */
    int64_t next_index;         /* -1: not known */
    int64_t lit_ns, settled_ns; /* from when until when lamps settle before slots begin; 0: never */
    struct course_records records[COURSE_PARTS];
    bool has_last;
    struct letter last; /* of a slot */
    char *readings;     /* JSON, of the slot readings_index; NULL */
    int64_t readings_index;
};

/* Nothing is known. What was is freed: a course that never was anything is zeroed first. */
void course_forget(struct course *course);

/* What a run says of itself. */
void course_letter(struct course *course, const struct letter *letter);

/* A line of the records, in the order of its part. A slot that both parts have is the second one's. readings: copied; NULL: none. */
void course_segment(struct course *course, enum course_part part,
                    const struct ttf_segment *segment);
void course_record(struct course *course, enum course_part part,
                   const struct ttf_slot_record *record, const char *readings);

/* Members of the status' run: slots, done, results, interval_ns, next, ends_in_ns, settled_in_ns, last. moving: slots come. */
void course_put(const struct course *course, bool moving, int64_t now_ns, struct ttf_json *json);
/* The member next, where slots come and another one does. */
void course_put_next(const struct course *course, bool moving, int64_t now_ns,
                     struct ttf_json *json);
/* Members of a slot's letter. */
void course_put_slot(const struct letter *letter, struct ttf_json *json);

#endif
