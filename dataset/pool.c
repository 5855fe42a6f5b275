/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/dataset/pool.h"

#include <pthread.h>
#include <sched.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdlib.h>

#define THREADS_MAX 256

struct worker {
    struct ttf_pool *pool;
    unsigned index; /* 1..threads-1; 0 is whoever calls run */
    pthread_t thread;
};

struct ttf_pool {
    unsigned threads;
    pthread_mutex_t mutex;
    pthread_cond_t work; /* a new run, or the end */
    pthread_cond_t idle; /* the last worker is through */
    /* under the mutex */
    unsigned long run; /* counts runs */
    unsigned busy;     /* workers still in this run */
    bool ending;
    unsigned tiles;
    ttf_tile_fn *fn;
    void *ctx;
    /* taken by all */
    atomic_uint next;
    struct worker workers[];
};

static void do_tiles(struct ttf_pool *pool, ttf_tile_fn *fn, void *ctx, unsigned tiles,
                     unsigned worker)
{
    for (;;) {
        unsigned tile = atomic_fetch_add_explicit(&pool->next, 1, memory_order_relaxed);

        if (tile >= tiles)
            return;
        fn(ctx, tile, worker);
    }
}

static void *worker_main(void *arg)
{
    struct worker *worker = arg;
    struct ttf_pool *pool = worker->pool;
    unsigned long seen = 0;

    pthread_mutex_lock(&pool->mutex);
    for (;;) {
        ttf_tile_fn *fn;
        void *ctx;
        unsigned tiles;

        while (!pool->ending && pool->run == seen)
            pthread_cond_wait(&pool->work, &pool->mutex);
        if (pool->ending)
            break;
        seen = pool->run;
        fn = pool->fn;
        ctx = pool->ctx;
        tiles = pool->tiles;
        pthread_mutex_unlock(&pool->mutex);
        do_tiles(pool, fn, ctx, tiles, worker->index);
        pthread_mutex_lock(&pool->mutex);
        if (--pool->busy == 0)
            pthread_cond_signal(&pool->idle);
    }
    pthread_mutex_unlock(&pool->mutex);
    return NULL;
}

/* Those this process may run on, not those the machine has. */
static unsigned processors(void)
{
    cpu_set_t set;
    int n = 0;

    CPU_ZERO(&set);
    if (sched_getaffinity(0, sizeof(set), &set) == 0)
        n = CPU_COUNT(&set);
    return n > 0 ? (unsigned)n : 1;
}

/* Signals are left to the program's own threads: a worker inherits a mask that blocks them all. */
static int start_workers(struct ttf_pool *pool, unsigned threads)
{
    sigset_t all, before;
    int r = 0;

    sigfillset(&all);
    if (pthread_sigmask(SIG_SETMASK, &all, &before) != 0)
        return -1;
    /* pool->threads counts those that run, so that destroy joins no others. */
    for (unsigned i = 1; r == 0 && i < threads; i++) {
        pool->workers[i].pool = pool;
        pool->workers[i].index = i;
        r = pthread_create(&pool->workers[i].thread, NULL, worker_main, &pool->workers[i]);
        if (r == 0)
            pool->threads = i + 1;
    }
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return r == 0 ? 0 : -1;
}

struct ttf_pool *ttf_pool_create(unsigned threads)
{
    struct ttf_pool *pool;

    if (threads == 0)
        threads = processors();
    if (threads > THREADS_MAX)
        threads = THREADS_MAX;
    pool = calloc(1, sizeof(*pool) + threads * sizeof(pool->workers[0]));
    if (!pool)
        return NULL;
    pool->threads = 1;
    if (pthread_mutex_init(&pool->mutex, NULL) != 0)
        goto err_free;
    if (pthread_cond_init(&pool->work, NULL) != 0)
        goto err_mutex;
    if (pthread_cond_init(&pool->idle, NULL) != 0)
        goto err_work;
    if (start_workers(pool, threads) < 0) {
        ttf_pool_destroy(pool);
        return NULL;
    }
    return pool;

err_work:
    pthread_cond_destroy(&pool->work);
err_mutex:
    pthread_mutex_destroy(&pool->mutex);
err_free:
    free(pool);
    return NULL;
}

unsigned ttf_pool_threads(const struct ttf_pool *pool)
{
    return pool ? pool->threads : 1;
}

void ttf_pool_run(struct ttf_pool *pool, unsigned tiles, ttf_tile_fn *fn, void *ctx)
{
    if (!pool || pool->threads == 1 || tiles <= 1) {
        for (unsigned tile = 0; tile < tiles; tile++)
            fn(ctx, tile, 0);
        return;
    }
    pthread_mutex_lock(&pool->mutex);
    atomic_store_explicit(&pool->next, 0, memory_order_relaxed);
    pool->fn = fn;
    pool->ctx = ctx;
    pool->tiles = tiles;
    pool->busy = pool->threads - 1;
    pool->run++;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->mutex);

    do_tiles(pool, fn, ctx, tiles, 0);

    pthread_mutex_lock(&pool->mutex);
    while (pool->busy > 0)
        pthread_cond_wait(&pool->idle, &pool->mutex);
    pthread_mutex_unlock(&pool->mutex);
}

void ttf_pool_destroy(struct ttf_pool *pool)
{
    if (!pool)
        return;
    pthread_mutex_lock(&pool->mutex);
    pool->ending = true;
    pthread_cond_broadcast(&pool->work);
    pthread_mutex_unlock(&pool->mutex);
    for (unsigned i = 1; i < pool->threads; i++)
        pthread_join(pool->workers[i].thread, NULL);
    pthread_cond_destroy(&pool->idle);
    pthread_cond_destroy(&pool->work);
    pthread_mutex_destroy(&pool->mutex);
    free(pool);
}
