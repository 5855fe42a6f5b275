/* SPDX-License-Identifier: Apache-2.0 */
#include "orders.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "orders_file.h"

struct orders {
    struct orders_file file;
    char configured[65];
    pthread_mutex_t lock; /* over what follows */
    struct order order;
    bool unsaved; /* the disk did not take it */
    bool unseen;  /* there was no file yet: its disk may come late */
    int unread;   /* there is one, and this error of the disk, for which it cannot be read */
    struct ttf_err why_unread;
    volatile int *flag;
    int flag_value;
};

void order_free(struct order *order)
{
    free(order->yaml);
    *order = (struct order){0};
}

/* ---- the file ---- */

static void copy(char *ret, size_t size, const char *text)
{
    (void)snprintf(ret, size, "%s", text ? text : "");
}

/* The lock is held; what is there is let go of. */
static void hold(struct orders *o, const struct order *order)
{
    int64_t generation = o->order.generation + 1;

    if (o->order.yaml != order->yaml)
        order_free(&o->order);
    o->order = *order;
    o->order.generation = generation;
}

static int save(struct orders *o, const struct order *order, struct ttf_err *err)
{
    int r = orders_file_write(&o->file, order, err);

    o->unsaved = r < 0 && !o->unread; /* what stands there unread is not overwritten */
    if (r == 0) {                     /* whatever stood there before is over */
        o->unseen = false;
        o->unread = 0;
        orders_file_reserve(&o->file);
    }
    return r;
}

static struct order configured_order(const struct orders *o)
{
    struct order order = {.state = *o->configured ? ORDER_RUN : ORDER_NONE};

    copy(order.dataset, sizeof order.dataset, o->configured);
    return order;
}

/* Nobody knows what was decided: nothing runs, so that nothing is done to a sample that nobody wants done. */
static struct order unknown_order(struct orders *o)
{
    struct order order = {.state = ORDER_STOPPED};
    bool aside = orders_file_put_aside(&o->file) == 0;

    copy(order.dataset, sizeof order.dataset, o->configured);
    (void)snprintf(order.why, sizeof order.why,
                   "what was to run could not be understood (%.300s%s): start it, or another one",
                   o->file.path, aside ? ".unreadable" : "");
    return order;
}

static bool is_same(const struct order *a, const struct order *b)
{
    return a->state == b->state && a->by_request == b->by_request &&
           strcmp(a->dataset, b->dataset) == 0 && strcmp(a->plan, b->plan) == 0 &&
           strcmp(a->yaml ? a->yaml : "", b->yaml ? b->yaml : "") == 0;
}

/* The lock is held. Of what was not read yet. */
static void read_file(struct orders *o)
{
    struct order order = {0};
    struct ttf_err err = {0};
    int r = orders_file_read(&o->file, &order, &err);

    /* What runs is known: a later look counts only if it says something else. What ended is not begun again by one. */
    if (o->order.generation > 0 && r <= 0) {
        o->unread = 0;
        o->unseen = r < 0;
        return;
    }
    o->unread = r < 0 && r != -ENOENT && r != -EINVAL ? r : 0;
    o->why_unread = err;
    if (o->unread)
        return; /* nothing is begun by guess, and nothing that goes on is ended by one */
    o->unseen = r == -ENOENT;
    if (r == -EINVAL)
        order = unknown_order(o);
    else if (r <= 0)
        order = configured_order(o);
    if (o->order.generation > 0 && is_same(&o->order, &order)) {
        order_free(&order);
        return;
    }
    hold(o, &order);
    if (r == -EINVAL)
        (void)!save(o, &order, NULL);
}

/* It may stand there all the same (a folder that could not be synced): what holds is written back, at once or by orders_save. */
static void write_back(struct orders *o)
{
    if (o->unsaved)
        (void)!save(o, &o->order, NULL);
}

int orders_create(struct ttf_io *io, const char *folder, const char *plan, const char *dataset,
                  struct orders **ret, struct ttf_err *err)
{
    struct orders *o = calloc(1, sizeof *o);
    const char *slash = strrchr(dataset, '/');

    if (!o)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    orders_file_name(&o->file, io, folder, plan, dataset);
    copy(o->configured, sizeof o->configured, slash ? slash + 1 : dataset);
    (void)pthread_mutex_init(&o->lock, NULL);
    read_file(o);
    *ret = o;
    return 0;
}

void orders_destroy(struct orders *o)
{
    if (!o)
        return;
    order_free(&o->order);
    (void)pthread_mutex_destroy(&o->lock);
    free(o);
}

/* ---- what is asked ---- */

/* The lock is held. */
static int copy_order(const struct orders *o, struct order *ret)
{
    *ret = o->order;
    return o->order.yaml && !(ret->yaml = strdup(o->order.yaml)) ? -ENOMEM : 0;
}

int orders_get(struct orders *o, struct order *ret)
{
    int r;

    (void)pthread_mutex_lock(&o->lock);
    r = copy_order(o, ret);
    (void)pthread_mutex_unlock(&o->lock);
    return r;
}

void orders_flag(struct orders *o, volatile int *flag, int value)
{
    o->flag = flag;
    o->flag_value = value;
}

static void swap_flag(struct orders *o, int from, int to)
{
    if (o->flag)
        (void)__atomic_compare_exchange_n(o->flag, &from, to, false, __ATOMIC_SEQ_CST,
                                          __ATOMIC_SEQ_CST);
}

/* The lock is held. What ran under another decision than the one that was read now is ended. */
static bool read_again(struct orders *o)
{
    int64_t generation = o->order.generation;
    bool ran = o->order.state == ORDER_RUN;

    if (!o->unread && !o->unseen)
        return false;
    if (o->unseen && o->unsaved)
        return false; /* what was decided since then holds, and is on its way there */
    read_file(o);
    if (o->order.generation == generation)
        return false;
    if (ran)
        swap_flag(o, 0, o->flag_value);
    return true;
}

bool orders_read_again(struct orders *o)
{
    bool other;

    (void)pthread_mutex_lock(&o->lock);
    other = read_again(o);
    (void)pthread_mutex_unlock(&o->lock);
    return other;
}

int orders_take(struct orders *o, struct order *ret, struct ttf_err *err)
{
    int r;

    (void)pthread_mutex_lock(&o->lock);
    (void)read_again(o);
    swap_flag(o, o->flag_value, 0);
    r = o->unread ? o->unread : copy_order(o, ret);
    if (r < 0 && err)
        *err = o->why_unread;
    if (r < 0) {
        *ret = (struct order){.generation = o->order.generation};
        if (!o->unread)
            ttf_err_set(err, r, NULL, "no memory");
    }
    (void)pthread_mutex_unlock(&o->lock);
    return r;
}

int64_t orders_generation(struct orders *o)
{
    int64_t generation;

    (void)pthread_mutex_lock(&o->lock);
    generation = o->order.generation;
    (void)pthread_mutex_unlock(&o->lock);
    return generation;
}

int orders_start(struct orders *o, const char *plan, const char *yaml, const char *dataset,
                 struct ttf_err *err)
{
    struct order order = {.state = ORDER_RUN, .by_request = true};
    int r;

    copy(order.plan, sizeof order.plan, plan);
    copy(order.dataset, sizeof order.dataset, dataset);
    order.yaml = strdup(yaml);
    if (!order.yaml)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    (void)pthread_mutex_lock(&o->lock);
    if (o->unread)
        r = ttf_err_set(err, -EAGAIN, o->file.path, "cannot be read yet, and says what runs");
    else if (o->order.state == ORDER_RUN)
        r = ttf_err_set(err, -EBUSY, NULL, "a run is under way, into %s", o->order.dataset);
    else
        r = save(o, &order, err);
    if (r == 0)
        hold(o, &order);
    else
        order_free(&order);
    write_back(o);
    (void)pthread_mutex_unlock(&o->lock);
    return r;
}

/* A decision of a person: what the disk does not take does not hold. */
static int change(struct orders *o, enum order_state from, enum order_state to,
                  const char *otherwise, struct ttf_err *err)
{
    struct order order;
    int r;

    (void)pthread_mutex_lock(&o->lock);
    order = o->order;
    order.state = to;
    order.why[0] = '\0';
    if (o->unread)
        r = ttf_err_set(err, -EAGAIN, o->file.path, "cannot be read yet, and says what runs");
    else if (o->order.state != from || !*order.dataset)
        r = ttf_err_set(err, -ENOENT, NULL, "%s", otherwise);
    else
        r = save(o, &order, err);
    if (r == 0)
        hold(o, &order);
    /* Under the same lock as the state: it is never a run of a later decision that it ends. */
    if (r == 0 && to == ORDER_STOPPED)
        swap_flag(o, 0, o->flag_value);
    write_back(o);
    (void)pthread_mutex_unlock(&o->lock);
    return r;
}

int orders_stop(struct orders *o, struct ttf_err *err)
{
    return change(o, ORDER_RUN, ORDER_STOPPED, "no run is under way", err);
}

int orders_go_on(struct orders *o, struct ttf_err *err)
{
    return change(o, ORDER_STOPPED, ORDER_RUN, "no run was stopped", err);
}

int orders_ended(struct orders *o, int64_t generation, enum order_state to, struct ttf_err *err)
{
    struct order order;
    int r = 0;

    (void)pthread_mutex_lock(&o->lock);
    if (o->order.generation == generation && o->order.state == ORDER_RUN) {
        order = o->order;
        order.state = to;
        hold(o, &order);
        if (to != ORDER_DONE || order.by_request)
            r = save(o, &order, err);
    }
    (void)pthread_mutex_unlock(&o->lock);
    return r;
}

int orders_save(struct orders *o, struct ttf_err *err)
{
    int r;

    (void)pthread_mutex_lock(&o->lock);
    r = o->unsaved ? save(o, &o->order, err) : 0;
    if (r == 0 && !o->unread)
        orders_file_reserve(&o->file);
    (void)pthread_mutex_unlock(&o->lock);
    return r;
}
