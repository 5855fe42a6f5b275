/* SPDX-License-Identifier: Apache-2.0 */
#include "queue.h"

#include <errno.h>
#include <string.h>

int ttf_queue_init(struct ttf_queue *queue, struct ttf_clock *clock,
                   const struct ttf_stock_size *size)
{
    int r;

    memset(queue, 0, sizeof(*queue));
    r = ttf_stock_init(&queue->stock, size);
    if (r < 0)
        return r;
    queue->work = ttf_gate_create(clock);
    queue->room = ttf_gate_create(clock);
    queue->done = ttf_gate_create(clock);
    if (!queue->work || !queue->room || !queue->done || pthread_mutex_init(&queue->mutex, NULL)) {
        ttf_gate_destroy(queue->work);
        ttf_gate_destroy(queue->room);
        ttf_gate_destroy(queue->done);
        ttf_stock_finish(&queue->stock);
        return -ENOMEM;
    }
    return 0;
}

/* Memory for frames of that format, if it has less. */
static int enlarge(struct ttf_raw_sum *raw, const struct ttf_frame_format *format)
{
    struct ttf_raw_sum larger;
    int r;

    if (raw->sum && ttf_raw_sum_refit(raw, format) == 0)
        return 0;
    r = ttf_raw_sum_init(&larger, format);
    if (r < 0)
        return r;
    /* Written to, so that it is there: the kernel only promises what nobody has touched. */
    memset(larger.sum, 0xff, larger.room * sizeof(*larger.sum));
    ttf_raw_sum_free(raw);
    *raw = larger;
    return 0;
}

unsigned ttf_queue_raws(size_t samples)
{
    size_t n = samples ? TTF_QUEUE_RAW_BYTES / TTF_RAW_SUM_BYTES / samples : TTF_QUEUE_RAW_MOST;

    if (n < TTF_QUEUE_RAW)
        return TTF_QUEUE_RAW;
    return n < TTF_QUEUE_RAW_MOST ? (unsigned)n : TTF_QUEUE_RAW_MOST;
}

int ttf_queue_reserve_raw(struct ttf_queue *queue, const struct ttf_frame_format *format)
{
    unsigned n = 0, wanted = TTF_QUEUE_RAW;
    int r = 0;

    while (n < wanted && r == 0) {
        r = enlarge(&queue->raw[n], format);
        wanted = r == 0 && n == 0 ? ttf_queue_raws(queue->raw[0].room) : wanted;
        n += r == 0;
    }
    for (queue->n_raw = n; n < TTF_QUEUE_RAW_MOST; n++)
        ttf_raw_sum_free(&queue->raw[n]);
    return queue->n_raw < TTF_QUEUE_RAW ? r : 0;
}

void ttf_queue_finish(struct ttf_queue *queue)
{
    for (unsigned i = 0; i < queue->n_raw; i++)
        ttf_raw_sum_free(&queue->raw[i]);
    ttf_gate_destroy(queue->work);
    ttf_gate_destroy(queue->room);
    ttf_gate_destroy(queue->done);
    pthread_mutex_destroy(&queue->mutex);
    ttf_stock_finish(&queue->stock);
}

struct ttf_job *ttf_job_new(struct ttf_queue *queue, enum ttf_job_kind kind)
{
    return ttf_stock_job(&queue->stock, kind);
}

void ttf_job_free(struct ttf_queue *queue, struct ttf_job *job)
{
    ttf_stock_give_job(&queue->stock, job);
}

/* Both with the mutex held. */
static void lose(struct ttf_queue *queue, int64_t at_ns, int64_t at_utc_ns)
{
    if (queue->lost.n++ == 0) {
        queue->lost.first_ns = at_ns;
        queue->lost.first_utc_ns = at_utc_ns;
    }
    queue->lost.last_ns = at_ns;
}

static struct ttf_lost take_lost(struct ttf_queue *queue)
{
    struct ttf_lost lost = queue->lost;

    queue->lost = (struct ttf_lost){0};
    return lost;
}

void ttf_queue_push(struct ttf_queue *queue, struct ttf_job *job)
{
    pthread_mutex_lock(&queue->mutex);
    if (job->kind == TTF_JOB_EVENT && queue->length >= TTF_QUEUE_EVENTS_MAX) {
        lose(queue, job->at_ns, job->at_utc_ns);
        pthread_mutex_unlock(&queue->mutex);
        ttf_job_free(queue, job);
        return;
    }
    if (job->kind == TTF_JOB_EVENT)
        job->lost_before = take_lost(queue);
    if (queue->tail)
        queue->tail->next = job;
    else
        queue->head = job;
    queue->tail = job;
    queue->length++;
    pthread_mutex_unlock(&queue->mutex);
    ttf_gate_open(queue->work);
}

void ttf_queue_lose_event(struct ttf_queue *queue, int64_t at_ns, int64_t at_utc_ns)
{
    pthread_mutex_lock(&queue->mutex);
    lose(queue, at_ns, at_utc_ns);
    pthread_mutex_unlock(&queue->mutex);
}

struct ttf_lost ttf_queue_take_lost(struct ttf_queue *queue)
{
    struct ttf_lost lost;

    pthread_mutex_lock(&queue->mutex);
    lost = take_lost(queue);
    pthread_mutex_unlock(&queue->mutex);
    return lost;
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

int ttf_queue_take_raw(struct ttf_queue *queue, const struct ttf_frame_format *format,
                       struct ttf_raw_sum **ret)
{
    struct ttf_raw_sum *raw = NULL;
    int r;

    pthread_mutex_lock(&queue->mutex);
    for (unsigned i = 0; i < queue->n_raw && !raw; i++) {
        if (!queue->raw_taken[i]) {
            queue->raw_taken[i] = true;
            raw = &queue->raw[i];
        }
    }
    pthread_mutex_unlock(&queue->mutex);
    if (!raw)
        return 0;
    r = ttf_raw_sum_refit(raw, format);
    if (r < 0) {
        ttf_queue_give_raw(queue, raw);
        return r;
    }
    *ret = raw;
    return 1;
}

void ttf_queue_give_raw(struct ttf_queue *queue, struct ttf_raw_sum *raw)
{
    if (!raw)
        return;
    pthread_mutex_lock(&queue->mutex);
    for (unsigned i = 0; i < queue->n_raw; i++) {
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
