/* SPDX-License-Identifier: Apache-2.0 */
#include "slow.h"

#include <errno.h>
#include <pthread.h>
#include <stdbool.h>
#include <stdlib.h>

#include "call.h"

#define WAITING 32

struct slow {
    pthread_mutex_t lock; /* over all below */
    pthread_cond_t changed;
    struct call *waiting[WAITING];
    unsigned first, n;
    bool stopped;
    unsigned n_threads;
    pthread_t threads[SLOW_THREADS_MAX];
};

static struct call *take(struct slow *slow)
{
    struct call *call = slow->waiting[slow->first];

    slow->first = (slow->first + 1) % WAITING;
    slow->n--;
    return call;
}

static void *work(void *ctx)
{
    struct slow *slow = ctx;

    (void)pthread_mutex_lock(&slow->lock);
    while (!slow->stopped) {
        struct call *call;

        if (slow->n == 0) {
            (void)pthread_cond_wait(&slow->changed, &slow->lock);
            continue;
        }
        call = take(slow);
        (void)pthread_mutex_unlock(&slow->lock);
        call_run(call);
        (void)pthread_mutex_lock(&slow->lock);
    }
    (void)pthread_mutex_unlock(&slow->lock);
    return NULL;
}

int slow_create(unsigned threads, struct slow **ret, struct ttf_err *err)
{
    struct slow *slow = calloc(1, sizeof *slow);

    if (!slow)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    (void)pthread_mutex_init(&slow->lock, NULL);
    (void)pthread_cond_init(&slow->changed, NULL);
    for (; slow->n_threads < threads; slow->n_threads++) {
        int r = -pthread_create(&slow->threads[slow->n_threads], NULL, work, slow);

        if (r < 0) {
            slow_destroy(slow);
            return ttf_err_set(err, r, NULL, "no thread for what takes its time");
        }
    }
    *ret = slow;
    return 0;
}

int slow_put(struct slow *slow, struct call *call)
{
    int r = -EAGAIN;

    (void)pthread_mutex_lock(&slow->lock);
    if (!slow->stopped && slow->n < WAITING) {
        slow->waiting[(slow->first + slow->n++) % WAITING] = call;
        (void)pthread_cond_signal(&slow->changed);
        r = 0;
    }
    (void)pthread_mutex_unlock(&slow->lock);
    return r;
}

void slow_stop(struct slow *slow)
{
    if (!slow)
        return;
    (void)pthread_mutex_lock(&slow->lock);
    slow->stopped = true;
    (void)pthread_cond_broadcast(&slow->changed);
    (void)pthread_mutex_unlock(&slow->lock);
    for (; slow->n_threads > 0; slow->n_threads--)
        (void)pthread_join(slow->threads[slow->n_threads - 1], NULL);
    while (slow->n > 0)
        call_cancel(take(slow), "this server is about to end");
}

void slow_destroy(struct slow *slow)
{
    if (!slow)
        return;
    slow_stop(slow);
    (void)pthread_cond_destroy(&slow->changed);
    (void)pthread_mutex_destroy(&slow->lock);
    free(slow);
}
