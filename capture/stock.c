/* SPDX-License-Identifier: Apache-2.0 */
#include "stock.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "commit.h"
#include "exposure.h"
#include "plan_change.h"
#include "shoot.h"
#include "ttf/base/time.h"

/* Records that may wait for a disk that hangs, or for one that takes lost slots one by one. */
#define SLOTS 2048u

/* Corrections of UTC on their way, of all segments, twice: after these the next step or trust tries again. */
#define SEGMENTS (2u * (TTF_PULSE_EARLIER + 1))

/* Notes on their way: more than people write at a time. */
#define NOTES 8u

/*
 * Slots with images that wait for a storage that is away: as many as come in the time that it is
 * given, and the strikes that the run is ended by; one is exposed and the others that have a raw
 * sum are committed.
 */
static unsigned rooms_of(const struct ttf_plan *plan)
{
    int64_t waiting = TTF_COMMIT_PATIENCE_NS / plan->interval_ns + TTF_COMMIT_STRIKES + 1;

    if (waiting > TTF_COMMIT_PENDING)
        waiting = TTF_COMMIT_PENDING;
    return (unsigned)waiting + 1 + TTF_QUEUE_RAW_MOST;
}

struct ttf_stock_size ttf_stock_size_of(const struct ttf_plan *plan)
{
    struct ttf_stock_size size = {.rooms = rooms_of(plan), .slots = SLOTS};

    for (unsigned i = 0; i < plan->n_shots; i++) {
        size.n_images += ttf_shot_images(&plan->shots[i]);
        size.n_shots += ttf_shot_images(&plan->shots[i]) * plan->shots[i].average * TTF_SHOOT_TRIES;
    }
    /* What a job passes on is free again before the job itself is: one more of each. */
    size.jobs[TTF_JOB_IMAGE] = TTF_QUEUE_RAW_MOST + 1;
    size.jobs[TTF_JOB_SLOT] = size.slots + 1;
    size.jobs[TTF_JOB_EVENT] = TTF_QUEUE_EVENTS_MAX;
    size.jobs[TTF_JOB_SEGMENT] = SEGMENTS;
    size.jobs[TTF_JOB_NOTE] = NOTES;
    size.jobs[TTF_JOB_QUIT] = 1;
    return size;
}

static unsigned jobs_of(const struct ttf_stock_size *size)
{
    unsigned jobs = 0;

    for (int kind = 0; kind < TTF_JOB_KINDS; kind++)
        jobs += size->jobs[kind];
    return jobs;
}

int64_t ttf_stock_bytes(const struct ttf_stock_size *size)
{
    size_t room = sizeof(struct ttf_slot_room) + size->n_images * sizeof(struct ttf_image) +
                  size->n_shots * sizeof(struct ttf_shot);

    return (int64_t)(size->rooms * room + size->slots * sizeof(struct ttf_slot_work) +
                     jobs_of(size) * sizeof(struct ttf_job));
}

/* Written to, so that it is there: the kernel only promises what nobody has touched. */
static void *some(size_t n, size_t each)
{
    void *p = calloc(n + 1, each);

    if (p)
        memset(p, 0xff, (n + 1) * each);
    return p;
}

static int allocate(struct ttf_stock *stock)
{
    const struct ttf_stock_size *size = &stock->size;
    unsigned jobs = jobs_of(size);

    stock->slots = some(size->slots, sizeof(*stock->slots));
    stock->rooms = some(size->rooms, sizeof(*stock->rooms));
    stock->images = some((size_t)size->rooms * size->n_images, sizeof(*stock->images));
    stock->shots = some((size_t)size->rooms * size->n_shots, sizeof(*stock->shots));
    stock->jobs = some(jobs, sizeof(*stock->jobs));
    if (!stock->slots || !stock->rooms || !stock->images || !stock->shots || !stock->jobs)
        return -ENOMEM;
    for (unsigned i = size->slots; i-- > 0;) {
        stock->slots[i].change = NULL;
        stock->slots[i].next = stock->free_slots;
        stock->free_slots = &stock->slots[i];
    }
    for (unsigned i = size->rooms; i-- > 0;) {
        stock->rooms[i] =
            (struct ttf_slot_room){.next = stock->free_rooms,
                                   .images = stock->images + (size_t)i * size->n_images,
                                   .shots = stock->shots + (size_t)i * size->n_shots};
        stock->free_rooms = &stock->rooms[i];
    }
    for (unsigned i = jobs; i-- > 0;) {
        stock->jobs[i].next = stock->free_jobs;
        stock->free_jobs = &stock->jobs[i];
    }
    memcpy(stock->jobs_left, size->jobs, sizeof(stock->jobs_left));
    return 0;
}

static void release(struct ttf_stock *stock)
{
    free(stock->slots);
    free(stock->rooms);
    free(stock->images);
    free(stock->shots);
    free(stock->jobs);
}

int ttf_stock_init(struct ttf_stock *stock, const struct ttf_stock_size *size)
{
    memset(stock, 0, sizeof(*stock));
    stock->size = *size;
    if (allocate(stock) < 0 || pthread_mutex_init(&stock->mutex, NULL)) {
        release(stock);
        return -ENOMEM;
    }
    return 0;
}

void ttf_stock_finish(struct ttf_stock *stock)
{
    /* Of those that are free it is NULL. */
    for (unsigned i = 0; i < stock->size.slots; i++)
        ttf_plan_change_free(stock->slots[i].change);
    release(stock);
    pthread_mutex_destroy(&stock->mutex);
}

struct ttf_slot_work *ttf_stock_slot(struct ttf_stock *stock)
{
    struct ttf_slot_work *work;

    pthread_mutex_lock(&stock->mutex);
    work = stock->free_slots;
    if (work)
        stock->free_slots = work->next;
    pthread_mutex_unlock(&stock->mutex);
    if (!work)
        return NULL;
    memset(work, 0, sizeof(*work));
    ttf_slot_record_init(&work->record);
    work->wakeup_ns = TTF_NS_UNKNOWN;
    return work;
}

bool ttf_stock_images(struct ttf_stock *stock, struct ttf_slot_work *work)
{
    struct ttf_slot_room *room;

    pthread_mutex_lock(&stock->mutex);
    room = stock->free_rooms;
    if (room)
        stock->free_rooms = room->next;
    pthread_mutex_unlock(&stock->mutex);
    if (!room)
        return false;
    work->room = room;
    work->record.images = room->images;
    work->record.n_images = stock->size.n_images;
    for (unsigned i = 0; i < stock->size.n_images; i++)
        ttf_image_init(&room->images[i]);
    return true;
}

void ttf_stock_give_slot(struct ttf_stock *stock, struct ttf_slot_work *work)
{
    if (!work)
        return;
    ttf_plan_change_free(work->change);
    work->change = NULL;
    pthread_mutex_lock(&stock->mutex);
    if (work->room) {
        work->room->next = stock->free_rooms;
        stock->free_rooms = work->room;
    }
    work->next = stock->free_slots;
    stock->free_slots = work;
    pthread_mutex_unlock(&stock->mutex);
}

struct ttf_job *ttf_stock_job(struct ttf_stock *stock, enum ttf_job_kind kind)
{
    struct ttf_job *job = NULL;

    pthread_mutex_lock(&stock->mutex);
    if (stock->jobs_left[kind] > 0) {
        stock->jobs_left[kind]--;
        job = stock->free_jobs;
        stock->free_jobs = job->next;
    }
    pthread_mutex_unlock(&stock->mutex);
    if (!job)
        return NULL;
    memset(job, 0, sizeof(*job));
    job->kind = kind;
    return job;
}

void ttf_stock_give_job(struct ttf_stock *stock, struct ttf_job *job)
{
    pthread_mutex_lock(&stock->mutex);
    stock->jobs_left[job->kind]++;
    job->next = stock->free_jobs;
    stock->free_jobs = job;
    pthread_mutex_unlock(&stock->mutex);
}
