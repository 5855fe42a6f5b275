/* SPDX-License-Identifier: Apache-2.0 */
/*
 * pool.h: threads that share out tiles of work.
 *
 * Work is cut into tiles by the caller, never by the number of threads, and
 * reductions are done by the caller in tile order: so results are the same bits
 * for any number of threads. Not for work that waits for anything but another tile of the same run
 * that is being worked on: only for computing.
 */
#ifndef TTF_DATASET_POOL_H
#define TTF_DATASET_POOL_H

#include "ttf/base/attr.h"

struct ttf_pool;

/* Does tile `tile` of `ctx`; `worker` is 0..threads-1, for scratch space of one's own. */
typedef void ttf_tile_fn(void *ctx, unsigned tile, unsigned worker);

/* threads >= 1, or 0: one for each processor. NULL: no memory. The caller's thread is one of them. */
struct ttf_pool *ttf_pool_create(unsigned threads);

unsigned ttf_pool_threads(const struct ttf_pool *pool);

/* Runs tiles 0..tiles-1 and returns when all are done. pool NULL: in this thread. One run at a time. */
void ttf_pool_run(struct ttf_pool *pool, unsigned tiles, ttf_tile_fn *fn, void *ctx);

/* NULL allowed. */
void ttf_pool_destroy(struct ttf_pool *pool);

#endif
