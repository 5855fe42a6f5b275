/* SPDX-License-Identifier: Apache-2.0 */
/*
 * stock.h: the memory of what passes from the loop to the committer: slots' records, their
 * images and shots, and jobs. All of it is made, and touched, before a run begins; what is
 * taken comes back. So a run of weeks can neither grow nor meet a lack of memory (README.md,
 * "Memory").
 *
 * Any thread.
 */
#ifndef TTF_CAPTURE_PRIVATE_STOCK_H
#define TTF_CAPTURE_PRIVATE_STOCK_H

#include <pthread.h>
#include <stddef.h>

#include "ttf/capture/plan.h"
#include "ttf/dataset/notes.h"
#include "ttf/dataset/record.h"

enum ttf_job_kind {
    TTF_JOB_IMAGE = 0, /* develop and write one image of a slot */
    TTF_JOB_SLOT,      /* commit the slot's record, or the change of plan */
    TTF_JOB_EVENT,
    TTF_JOB_SEGMENT, /* append a correcting segment line */
    TTF_JOB_NOTE,    /* append to notes.jsonl */
    TTF_JOB_QUIT
};

#define TTF_JOB_KINDS (TTF_JOB_QUIT + 1)

/* Room for the images of one slot. */
struct ttf_slot_room {
    struct ttf_slot_room *next;
    struct ttf_image *images; /* the plan's number of them */
    struct ttf_shot *shots;   /* of all images together */
};

struct ttf_plan_change;

/*
 * One slot under way. The loop fills an image, then pushes it, and touches it no more. Or a change of
 * plan, which goes to the disk in its turn among the records.
 */
struct ttf_slot_work {
    struct ttf_slot_work *next; /* the committer's: among those that wait for their storage */
    struct ttf_slot_record
        record;                 /* its images and shots lie in room: never ttf_slot_record_free */
    struct ttf_slot_room *room; /* NULL: a slot without images */
    int64_t total;              /* slots of the plan, as known when it came to this one */
    int64_t begun_ns;           /* boot clock: the first lamp command */
    int64_t wakeup_ns;          /* how late the loop woke; TTF_NS_UNKNOWN */
    struct ttf_plan_change *change; /* NULL: a slot; owned, with memory of its own */
};

/* Events that are lost, because nothing could take them for too long. */
struct ttf_lost {
    unsigned n; /* 0: none, and no times */
    int64_t first_ns, first_utc_ns, last_ns;
};

struct ttf_job {
    enum ttf_job_kind kind;
    struct ttf_job *next;
    struct ttf_slot_work *slot; /* IMAGE, SLOT; the SLOT job passes ownership on */
    unsigned image;             /* IMAGE: which of the record's */
    unsigned shot;              /* IMAGE: which of the plan's shots */
    struct ttf_raw_sum *raw;    /* IMAGE: given back by the committer */
    int64_t start_utc_ns;       /* IMAGE: exposure start; TTF_NS_UNKNOWN */
    struct ttf_segment segment; /* SEGMENT */
    int64_t at_ns, at_utc_ns;   /* EVENT */
    int64_t total;  /* EVENT: slots that the run comes to by it; 0: it changes nothing */
    char event[32]; /* EVENT: kind */
    char text[256]; /* EVENT */
    struct ttf_lost lost_before; /* EVENT: those before it that found no place in the queue */
    struct ttf_lost lost;        /* EVENT of kind "lost": those it tells of; n is 0 of others */
    const struct ttf_note *note; /* NOTE: lent until it is answered */
    int64_t ask;                 /* NOTE: to be answered */
};

/* How much there is to be. */
struct ttf_stock_size {
    unsigned n_images, n_shots;   /* a slot's, at the most */
    unsigned rooms;               /* slots with images at a time */
    unsigned slots;               /* slots at a time, those with images among them */
    unsigned jobs[TTF_JOB_KINDS]; /* of each kind at a time */
};

struct ttf_stock {
    pthread_mutex_t mutex;
    struct ttf_stock_size size;
    struct ttf_slot_work *slots, *free_slots;
    struct ttf_slot_room *rooms, *free_rooms;
    struct ttf_image *images;
    struct ttf_shot *shots;
    struct ttf_job *jobs, *free_jobs;
    unsigned jobs_left[TTF_JOB_KINDS];
};

/* For a run of a plan that has been checked. */
struct ttf_stock_size ttf_stock_size_of(const struct ttf_plan *plan);

/* Bytes that it comes to. */
int64_t ttf_stock_bytes(const struct ttf_stock_size *size);

/* -ENOMEM. */
TTF_MUST_USE int ttf_stock_init(struct ttf_stock *stock, const struct ttf_stock_size *size);

/* Frees all, whatever is still out. */
void ttf_stock_finish(struct ttf_stock *stock);

/* A slot's empty record without images; NULL: all are out. */
struct ttf_slot_work *ttf_stock_slot(struct ttf_stock *stock);

/* The plan's number of empty images for it, as ttf_slot_record_images makes them. False: all rooms are out. */
bool ttf_stock_images(struct ttf_stock *stock, struct ttf_slot_work *work);

/* Takes it back, with its images. NULL allowed. */
void ttf_stock_give_slot(struct ttf_stock *stock, struct ttf_slot_work *work);

/* A zeroed job; NULL: all of its kind are out. */
struct ttf_job *ttf_stock_job(struct ttf_stock *stock, enum ttf_job_kind kind);
void ttf_stock_give_job(struct ttf_stock *stock, struct ttf_job *job);

#endif
