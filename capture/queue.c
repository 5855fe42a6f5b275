/* SPDX-License-Identifier: Apache-2.0 */
#include "queue.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "frame_check.h"
#include "plan_change.h"

int ttf_queue_init(struct ttf_queue *queue, struct ttf_clock *clock)
{
    memset(queue, 0, sizeof(*queue));
    queue->work = ttf_gate_create(clock);
    queue->room = ttf_gate_create(clock);
    queue->done = ttf_gate_create(clock);
    if (!queue->work || !queue->room || !queue->done || pthread_mutex_init(&queue->mutex, NULL)) {
        ttf_gate_destroy(queue->work);
        ttf_gate_destroy(queue->room);
        ttf_gate_destroy(queue->done);
        return -ENOMEM;
    }
    return 0;
}

void ttf_queue_finish(struct ttf_queue *queue)
{
    while (queue->head) {
        struct ttf_job *job = queue->head;

        queue->head = job->next;
        if (job->kind == TTF_JOB_SLOT)
            ttf_slot_work_free(job->slot);
        ttf_job_free(job);
    }
    for (unsigned i = 0; i < TTF_QUEUE_RAW; i++)
        ttf_raw_sum_free(&queue->raw[i]);
    ttf_gate_destroy(queue->work);
    ttf_gate_destroy(queue->room);
    ttf_gate_destroy(queue->done);
    pthread_mutex_destroy(&queue->mutex);
}

struct ttf_job *ttf_job_new(enum ttf_job_kind kind)
{
    struct ttf_job *job = calloc(1, sizeof(*job));

    if (job)
        job->kind = kind;
    return job;
}

void ttf_job_free(struct ttf_job *job)
{
    free(job);
}

void ttf_slot_work_free(struct ttf_slot_work *work)
{
    if (!work)
        return;
    ttf_slot_record_free(&work->record);
    ttf_plan_change_free(work->change);
    free(work);
}

void ttf_queue_push(struct ttf_queue *queue, struct ttf_job *job)
{
    pthread_mutex_lock(&queue->mutex);
    if (job->kind == TTF_JOB_EVENT && queue->length >= TTF_QUEUE_EVENTS_MAX) {
        pthread_mutex_unlock(&queue->mutex);
        ttf_job_free(job);
        return;
    }
    if (queue->tail)
        queue->tail->next = job;
    else
        queue->head = job;
    queue->tail = job;
    queue->length++;
    pthread_mutex_unlock(&queue->mutex);
    ttf_gate_open(queue->work);
}

unsigned ttf_queue_length(struct ttf_queue *queue)
{
    unsigned length;

    pthread_mutex_lock(&queue->mutex);
    length = queue->length;
    pthread_mutex_unlock(&queue->mutex);
    return length;
}

struct ttf_job *ttf_queue_pop(struct ttf_queue *queue)
{
    for (;;) {
        struct ttf_job *job;

        pthread_mutex_lock(&queue->mutex);
        job = queue->head;
        if (job) {
            queue->head = job->next;
            if (!queue->head)
                queue->tail = NULL;
            queue->length--;
            job->next = NULL;
        }
        pthread_mutex_unlock(&queue->mutex);
        if (job)
            return job;
        /* The gate may have been opened for a job already taken: look again either way. */
        if (ttf_gate_wait(queue->work, TTF_NS_NEVER) < 0)
            continue;
    }
}

static bool fits(const struct ttf_raw_sum *raw, const struct ttf_frame_format *format)
{
    return raw->sum && ttf_frame_format_equal(&raw->format, format);
}

int ttf_queue_take_raw(struct ttf_queue *queue, const struct ttf_frame_format *format,
                       struct ttf_raw_sum **ret)
{
    struct ttf_raw_sum *raw = NULL;
    int r;

    pthread_mutex_lock(&queue->mutex);
    for (unsigned i = 0; i < TTF_QUEUE_RAW && !raw; i++) {
        if (!queue->raw_taken[i]) {
            queue->raw_taken[i] = true;
            raw = &queue->raw[i];
        }
    }
    pthread_mutex_unlock(&queue->mutex);
    if (!raw)
        return 0;
    if (fits(raw, format)) {
        ttf_raw_sum_reset(raw);
    } else {
        ttf_raw_sum_free(raw);
        memset(raw, 0, sizeof(*raw));
        r = ttf_raw_sum_init(raw, format);
        if (r < 0) {
            ttf_queue_give_raw(queue, raw);
            return r;
        }
    }
    *ret = raw;
    return 1;
}

void ttf_queue_give_raw(struct ttf_queue *queue, struct ttf_raw_sum *raw)
{
    if (!raw)
        return;
    pthread_mutex_lock(&queue->mutex);
    for (unsigned i = 0; i < TTF_QUEUE_RAW; i++) {
        if (raw == &queue->raw[i])
            queue->raw_taken[i] = false;
    }
    pthread_mutex_unlock(&queue->mutex);
    ttf_gate_open(queue->room);
}

void ttf_queue_tell_disk(struct ttf_queue *queue, bool full)
{
    pthread_mutex_lock(&queue->mutex);
    queue->disk_full = full;
    pthread_mutex_unlock(&queue->mutex);
}

void ttf_queue_tell_fatal(struct ttf_queue *queue, int code, const struct ttf_err *err)
{
    pthread_mutex_lock(&queue->mutex);
    if (queue->fatal == 0) {
        queue->fatal = code;
        if (err)
            queue->fatal_err = *err;
    }
    pthread_mutex_unlock(&queue->mutex);
    ttf_gate_open(queue->room);
}

bool ttf_queue_disk_full(struct ttf_queue *queue)
{
    bool full;

    pthread_mutex_lock(&queue->mutex);
    full = queue->disk_full;
    pthread_mutex_unlock(&queue->mutex);
    return full;
}

int ttf_queue_fatal(struct ttf_queue *queue)
{
    int code;

    pthread_mutex_lock(&queue->mutex);
    code = queue->fatal;
    pthread_mutex_unlock(&queue->mutex);
    return code;
}
