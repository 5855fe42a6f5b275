/* SPDX-License-Identifier: Apache-2.0 */
/*
 * queue.h: between exposing and committing. Jobs pass in order from the loop to
 * the committer; raw sums, the only large thing, exist twice, and more often only
 * where they are small.
 *
 * Threads: one loop, one committer; each function says whose it is.
 */
#ifndef TTF_CAPTURE_PRIVATE_QUEUE_H
#define TTF_CAPTURE_PRIVATE_QUEUE_H

#include <pthread.h>
#include <stdbool.h>

#include "stock.h"
#include "ttf/base/err.h"
#include "ttf/dataset/calibration.h"
#include "ttf/hal/clock.h"

#define TTF_QUEUE_RAW 2 /* raw sums at the least: one being exposed, one being committed */

/*
 * Small frames have more, so that a disk that stands still for some intervals (a card that tidies up, a host that
 * writes much) costs no slot: as many as there is room for in so many bytes.
 */
#define TTF_QUEUE_RAW_MOST  16
#define TTF_QUEUE_RAW_BYTES (16u << 20)

/* Events beyond this many unwritten jobs are lost (a disk that hangs), and counted; records never are. */
#define TTF_QUEUE_EVENTS_MAX 1024

struct ttf_queue {
    pthread_mutex_t mutex;
    struct ttf_gate *work; /* the committer waits on it */
    struct ttf_gate *room; /* the loop waits on it */
    struct ttf_gate *done; /* the committer has ended */
    struct ttf_job *head, *tail;
    unsigned length;
    struct ttf_lost lost;   /* events, since the last one that found a place */
    struct ttf_stock stock; /* the memory of all that passes, and of what waits beyond */
    struct ttf_raw_sum raw[TTF_QUEUE_RAW_MOST];
    bool raw_taken[TTF_QUEUE_RAW_MOST];
    unsigned n_raw;
    /* told by the committer, read by the loop */
    bool disk_full;
    int fatal; /* 0, or the errno that ends the run */
    struct ttf_err fatal_err;
};

/* With memory for so much as may pass at a time. -ENOMEM. */
TTF_MUST_USE int ttf_queue_init(struct ttf_queue *queue, struct ttf_clock *clock,
                                const struct ttf_stock_size *size);

/* How many raw sums there are, each of so many samples (ttf_raw_sum_samples). */
unsigned ttf_queue_raws(size_t samples);

/*
 * Makes the raw sums, of frames of that format and of the larger of those told before; none is taken meanwhile. As
 * ttf_raw_sum_init, of which -ENOMEM is told only of the least that there must be.
 */
TTF_MUST_USE int ttf_queue_reserve_raw(struct ttf_queue *queue,
                                       const struct ttf_frame_format *format);

/* Frees what is left in it. Both threads have ended. */
void ttf_queue_finish(struct ttf_queue *queue);

/* A zeroed job, or NULL: of its kind as many are out as there may be (events; of others there are enough). */
struct ttf_job *ttf_job_new(struct ttf_queue *queue, enum ttf_job_kind kind);
void ttf_job_free(struct ttf_queue *queue, struct ttf_job *job);

/* Passes ownership of the job. An event into a crowded queue is lost; the next that is not says how many. Never allocates. Any thread. */
void ttf_queue_push(struct ttf_queue *queue, struct ttf_job *job);

/* Counts an event for which there was no job. Any thread. */
void ttf_queue_lose_event(struct ttf_queue *queue, int64_t at_ns, int64_t at_utc_ns);

/* Those lost since the last one that found a place; they count as told then. Committer. */
struct ttf_lost ttf_queue_take_lost(struct ttf_queue *queue);

/* How many jobs wait. Any thread. */
unsigned ttf_queue_length(struct ttf_queue *queue);

/* The oldest job; waits for it. Committer. */
struct ttf_job *ttf_queue_pop(struct ttf_queue *queue);

/* A free raw sum for frames of that format, emptied: 1 and *ret; 0 if none is free; -ENOSPC for a format beyond what was reserved. Loop. */
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
