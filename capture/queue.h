/* SPDX-License-Identifier: Apache-2.0 */
/*
 * queue.h: between exposing and committing. Jobs pass in order from the loop to
 * the committer; raw sums, the only large thing, exist twice and no more.
 *
 * Threads: one loop, one committer; each function says whose it is.
 */
#ifndef TTF_CAPTURE_PRIVATE_QUEUE_H
#define TTF_CAPTURE_PRIVATE_QUEUE_H

#include <pthread.h>
#include <stdbool.h>

#include "ttf/base/err.h"
#include "ttf/dataset/calibration.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/record.h"
#include "ttf/hal/clock.h"

#define TTF_QUEUE_RAW 2 /* raw sums: one being exposed, one being committed */

/* Events beyond this many unwritten jobs are dropped (a disk that hangs); records never are. */
#define TTF_QUEUE_EVENTS_MAX 1024

enum ttf_job_kind {
    TTF_JOB_IMAGE = 0, /* develop and write one image of a slot */
    TTF_JOB_SLOT,      /* commit the slot's record, or the change of plan */
    TTF_JOB_EVENT,
    TTF_JOB_SEGMENT, /* append a correcting segment line */
    TTF_JOB_NOTE,    /* append to notes.jsonl */
    TTF_JOB_QUIT
};

struct ttf_plan_change;

/*
 * One slot under way. The loop fills an image, then pushes it, and touches it no more. Or a change of
 * plan, which goes to the disk in its turn among the records.
 */
struct ttf_slot_work {
    struct ttf_slot_work *next; /* the committer's: among those that wait for their storage */
    struct ttf_slot_record record;
    int64_t begun_ns;               /* boot clock: the first lamp command */
    int64_t wakeup_ns;              /* how late the loop woke; TTF_NS_UNKNOWN */
    struct ttf_plan_change *change; /* NULL: a slot; owned */
};

struct ttf_job {
    enum ttf_job_kind kind;
    struct ttf_job *next;
    struct ttf_slot_work *slot;  /* IMAGE, SLOT; the SLOT job passes ownership on */
    unsigned image;              /* IMAGE: which of the record's */
    unsigned shot;               /* IMAGE: which of the plan's shots */
    struct ttf_raw_sum *raw;     /* IMAGE: given back by the committer */
    int64_t start_utc_ns;        /* IMAGE: exposure start; TTF_NS_UNKNOWN */
    struct ttf_segment segment;  /* SEGMENT */
    int64_t at_ns, at_utc_ns;    /* EVENT */
    char event[32];              /* EVENT: kind */
    char text[256];              /* EVENT */
    const struct ttf_note *note; /* NOTE: lent until it is answered */
    int64_t ask;                 /* NOTE: to be answered */
};

struct ttf_queue {
    pthread_mutex_t mutex;
    struct ttf_gate *work; /* the committer waits on it */
    struct ttf_gate *room; /* the loop waits on it */
    struct ttf_gate *done; /* the committer has ended */
    struct ttf_job *head, *tail;
    unsigned length;
    struct ttf_raw_sum raw[TTF_QUEUE_RAW];
    bool raw_taken[TTF_QUEUE_RAW];
    /* told by the committer, read by the loop */
    bool disk_full;
    int fatal; /* 0, or the errno that ends the run */
    struct ttf_err fatal_err;
};

/* -ENOMEM. */
TTF_MUST_USE int ttf_queue_init(struct ttf_queue *queue, struct ttf_clock *clock);

/* Frees what is left in it. Both threads have ended. */
void ttf_queue_finish(struct ttf_queue *queue);

/* A zeroed job, or NULL: no memory. */
struct ttf_job *ttf_job_new(enum ttf_job_kind kind);
void ttf_job_free(struct ttf_job *job);
void ttf_slot_work_free(struct ttf_slot_work *work);

/* Passes ownership of the job. An event into a crowded queue is dropped. Any thread. */
void ttf_queue_push(struct ttf_queue *queue, struct ttf_job *job);

/* How many jobs wait. Any thread. */
unsigned ttf_queue_length(struct ttf_queue *queue);

/* The oldest job; waits for it. Committer. */
struct ttf_job *ttf_queue_pop(struct ttf_queue *queue);

/* A free raw sum for frames of that format, emptied: 1 and *ret; 0 if none is free; -ENOMEM. Loop. */
TTF_MUST_USE int ttf_queue_take_raw(struct ttf_queue *queue, const struct ttf_frame_format *format,
                                    struct ttf_raw_sum **ret);

/* Gives it back. NULL allowed. Any thread. */
void ttf_queue_give_raw(struct ttf_queue *queue, struct ttf_raw_sum *raw);

/* What the committer tells the loop. */
void ttf_queue_tell_disk(struct ttf_queue *queue, bool full);
void ttf_queue_tell_fatal(struct ttf_queue *queue, int code, const struct ttf_err *err);
bool ttf_queue_disk_full(struct ttf_queue *queue);
int ttf_queue_fatal(struct ttf_queue *queue);

#endif
