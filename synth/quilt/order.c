/* SPDX-License-Identifier: Apache-2.0 */
#include "quilt/order.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>

#include "quilt/avoid.h"
#include "ttf/synth/cancel.h"

struct row {
    uint32_t placed; /* blocks, from the left */
    bool taken;      /* a thread is at the next one */
};

struct order {
    struct ttf_plan *plan;
    struct ttf_ahead *ahead; /* NULL: none */
    uint32_t lag;            /* blocks that a row stays behind the one above */
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    /* under the mutex */
    struct row *rows;
    uint32_t first; /* row that is not whole */
    unsigned placed, waiting;
    int code;
    struct ttf_err err;
};

/* ---- what there is to do: under the mutex ---- */

static bool is_ready(const struct order *order, uint32_t r)
{
    uint32_t columns = order->plan->placement.columns;
    const struct row *row = &order->rows[r];
    uint32_t needed = row->placed + order->lag < columns ? row->placed + order->lag : columns;

    return !row->taken && row->placed < columns && (r == 0 || order->rows[r - 1].placed >= needed);
}

/* The uppermost row whose next block can be placed; -1: none now. */
static int64_t find_row(const struct order *order)
{
    uint32_t rows = order->plan->placement.rows;

    for (uint32_t r = order->first; r < rows; r++) {
        if (is_ready(order, r))
            return r;
        if (order->rows[r].placed == 0)
            break; /* and so none below it */
    }
    return -1;
}

/* Rows of pixels that no block to come will change. */
static uint32_t final_rows(const struct order *order)
{
    const struct ttf_plan *plan = order->plan;

    return order->first < plan->placement.rows
               ? plan->map.blocks[order->first * plan->placement.columns].out_y
               : plan->config->height;
}

static bool is_over(const struct order *order)
{
    return order->code < 0 || (order->placed == order->plan->map.n_blocks &&
                               (!order->ahead || ttf_ahead_finished(order->ahead)));
}

static void fail(struct order *order, int code, const struct ttf_err *err)
{
    if (order->code < 0)
        return;
    order->code = code;
    if (err)
        order->err = *err;
}

static void check_cancel(struct order *order)
{
    const struct ttf_quilt_config *config = order->plan->config;

    if (ttf_cancelled(config->cancel) && order->code == 0)
        order->code = ttf_err_set(&order->err, -ECANCELED, NULL, "cancelled");
}

static void wake_others(struct order *order)
{
    if (order->waiting > 0)
        pthread_cond_broadcast(&order->changed);
}

/* ---- doing it: the mutex is let go of meanwhile ---- */

static void place_next(struct order *order, uint32_t r, unsigned worker)
{
    struct ttf_plan *plan = order->plan;
    const struct ttf_quilt_config *config = plan->config;
    struct row *row = &order->rows[r];
    unsigned i = r * plan->placement.columns + row->placed;
    struct ttf_err err;
    int code;

    row->taken = true;
    pthread_mutex_unlock(&order->mutex);
    code = ttf_place_block(plan, &plan->rooms[worker], i);
    pthread_mutex_lock(&order->mutex);
    row->taken = false;
    row->placed++;
    order->placed++;
    while (order->first < plan->placement.rows &&
           order->rows[order->first].placed == plan->placement.columns)
        order->first++;
    if (code < 0)
        fail(order,
             ttf_err_set(&err, code, NULL, "no memory to place block %u of %u", i,
                         plan->map.n_blocks),
             &err);
    if (config->progress)
        config->progress(config->progress_ctx, (double)order->placed / plan->map.n_blocks);
}

static void hand_on(struct order *order, const struct ttf_ahead_piece *piece, unsigned worker)
{
    struct ttf_err err = {0};
    int code;

    if (piece->kind != TTF_AHEAD_ROOM)
        wake_others(order); /* there may be further pieces */
    pthread_mutex_unlock(&order->mutex);
    code = ttf_ahead_run(order->ahead, piece, worker, &err);
    pthread_mutex_lock(&order->mutex);
    ttf_ahead_done(order->ahead, piece);
    if (code < 0)
        fail(order, code, &err);
}

/* One thing, if there is any. The whole map goes first, when it is, then rows that are final, but by one thread while others can search; then room for it, by one thread, too. */
static bool do_something(struct order *order, unsigned worker)
{
    struct ttf_ahead_piece piece;
    int64_t row = find_row(order);
    int code = order->ahead ? ttf_ahead_take(order->ahead, &order->plan->map, final_rows(order),
                                             row >= 0, &piece)
                            : 0;
    struct ttf_err err;

    if (code < 0)
        fail(order, ttf_err_set(&err, code, NULL, "no memory to hand rows on"), &err);
    else if (code > 0)
        hand_on(order, &piece, worker);
    else if (row >= 0)
        place_next(order, (uint32_t)row, worker);
    return code != 0 || row >= 0;
}

static void work(void *ctx, unsigned tile, unsigned worker)
{
    struct order *order = ctx;

    (void)tile;
    pthread_mutex_lock(&order->mutex);
    for (check_cancel(order); !is_over(order); check_cancel(order)) {
        if (do_something(order, worker)) {
            wake_others(order);
            continue;
        }
        /* Others are at what this thread needs: none waits while nobody works. */
        order->waiting++;
        pthread_cond_wait(&order->changed, &order->mutex);
        order->waiting--;
    }
    wake_others(order);
    pthread_mutex_unlock(&order->mutex);
}

int ttf_order_rows(struct ttf_plan *plan, struct ttf_ahead *ahead, struct ttf_err *err)
{
    struct order order = {.plan = plan,
                          .ahead = ahead,
                          .lag = plan->config->avoid_px > 0 ? TTF_AVOID_BLOCKS + 1 : 2,
                          .mutex = PTHREAD_MUTEX_INITIALIZER,
                          .changed = PTHREAD_COND_INITIALIZER,
                          .rows = calloc(plan->placement.rows, sizeof(*order.rows))};

    if (!order.rows)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory to place %u blocks", plan->map.n_blocks);
    ttf_pool_run(plan->pool, ttf_pool_threads(plan->pool), work, &order);
    free(order.rows);
    pthread_cond_destroy(&order.changed);
    pthread_mutex_destroy(&order.mutex);
    if (order.code < 0 && err)
        *err = order.err;
    return order.code;
}

int ttf_order_raster(struct ttf_plan *plan, struct ttf_err *err)
{
    const struct ttf_quilt_config *config = plan->config;

    for (unsigned i = 0; i < plan->map.n_blocks; i++) {
        int r;

        if (ttf_cancelled(config->cancel))
            return ttf_err_set(err, -ECANCELED, NULL, "cancelled");
        r = ttf_place_block(plan, &plan->rooms[0], i);
        if (r < 0)
            return ttf_err_set(err, r, NULL, "no memory to place block %u of %u", i,
                               plan->map.n_blocks);
        if (config->progress)
            config->progress(config->progress_ctx, (i + 1.0) / plan->map.n_blocks);
    }
    return 0;
}
