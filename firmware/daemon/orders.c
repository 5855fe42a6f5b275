/* SPDX-License-Identifier: Apache-2.0 */
#include "orders.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/dataset/json_parse.h"
#include "ttf/dataset/json_writer.h"

#define FILE_MAX ((size_t)1 << 20)

struct orders {
    struct ttf_io *io;
    char folder[512], path[528];
    char configured[65], configuration[1024];
    pthread_mutex_t lock; /* over what follows */
    struct order order;
    bool unsaved; /* the disk did not take it */
    volatile int *flag;
    int flag_value;
};

static const char *const STATES[] = {"none", "running", "stopped", "done"};

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

static void configured_order(struct orders *o)
{
    order_free(&o->order);
    copy(o->order.dataset, sizeof o->order.dataset, o->configured);
    o->order.state = *o->configured ? ORDER_RUN : ORDER_NONE;
}

static int read_order(struct orders *o, const json_t *object)
{
    const char *state = json_string_value(json_object_get(object, "state"));
    const char *yaml = json_string_value(json_object_get(object, "plan_yaml"));
    const char *under = json_string_value(json_object_get(object, "configuration"));
    bool same = under && strcmp(under, o->configuration) == 0;
    struct order order = {.by_request = yaml != NULL};

    for (unsigned i = ORDER_RUN; i <= ORDER_DONE; i++)
        if (state && strcmp(state, STATES[i]) == 0)
            order.state = (enum order_state)i;
    copy(order.dataset, sizeof order.dataset,
         json_string_value(json_object_get(object, "dataset")));
    copy(order.plan, sizeof order.plan, json_string_value(json_object_get(object, "plan")));
    if (state && strcmp(state, STATES[ORDER_NONE]) == 0)
        return 0; /* nobody had decided anything */
    if (order.state == ORDER_NONE || !*order.dataset)
        return -EINVAL;
    /* What the configuration names now, and did not then, nobody has stopped. */
    if (!same && (!order.by_request || order.state != ORDER_RUN))
        return 0;
    if (yaml && !(order.yaml = strdup(yaml)))
        return -ENOMEM;
    order_free(&o->order);
    o->order = order;
    return 0;
}

static int load(struct orders *o, struct ttf_err *err)
{
    char *text = NULL;
    json_t *object;
    size_t bytes;
    int r = ttf_io_slurp(o->io, o->path, FILE_MAX, &text, &bytes, err);

    configured_order(o);
    if (r == -ENOENT)
        return 0;
    if (r < 0)
        return r;
    r = ttf_json_parse(text, bytes, &object, NULL);
    free(text);
    if (r == 0) {
        r = read_order(o, object);
        json_decref(object);
    }
    if (r == -EINVAL) {
        ttf_err_set(err, r, o->path, "does not say what was to run");
        ttf_err_hint(err,
                     "remove it: the configuration holds then, or a run is to be asked for anew");
    }
    return r;
}

static int save(struct orders *o, const struct order *order, struct ttf_err *err)
{
    /* The configuration's run is looked at anew at each boot: a longer plan goes on. */
    bool anew = order->state == ORDER_DONE && !order->by_request;
    struct ttf_json json;
    const char *text;
    size_t bytes;
    int r;

    ttf_json_init(&json, true);
    ttf_json_object(&json);
    ttf_json_kstring(&json, "state", STATES[anew ? ORDER_RUN : order->state]);
    ttf_json_kstring(&json, "dataset", order->dataset);
    ttf_json_kstring(&json, "configuration", o->configuration);
    if (order->by_request) {
        ttf_json_kstring(&json, "plan", order->plan);
        ttf_json_kstring(&json, "plan_yaml", order->yaml);
    }
    ttf_json_object_end(&json);
    r = ttf_json_finish(&json, &text, &bytes);
    if (r < 0)
        ttf_err_set(err, r, o->path, "no memory");
    else
        r = ttf_io_mkdirs(o->io, o->folder, err);
    if (r == 0)
        r = ttf_io_write_file(o->io, o->path, text, bytes, err);
    ttf_json_free(&json);
    o->unsaved = r < 0;
    return r;
}

/* It may stand there all the same (a folder that could not be synced): what holds is written back, at once or by orders_save. */
static void write_back(struct orders *o)
{
    if (o->unsaved)
        (void)!save(o, &o->order, NULL);
}

int orders_create(struct ttf_io *io, const char *folder, const char *configured,
                  const char *configuration, struct orders **ret, struct ttf_err *err)
{
    struct orders *o = calloc(1, sizeof *o);
    int r;

    if (!o)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    o->io = io;
    copy(o->folder, sizeof o->folder, folder);
    (void)snprintf(o->path, sizeof o->path, "%s/run.json", o->folder);
    copy(o->configured, sizeof o->configured, configured);
    copy(o->configuration, sizeof o->configuration, configuration);
    (void)pthread_mutex_init(&o->lock, NULL);
    r = load(o, err);
    if (r < 0) {
        orders_destroy(o);
        return r;
    }
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

/* The lock is held; what is there is let go of. */
static void hold(struct orders *o, const struct order *order)
{
    int64_t generation = o->order.generation + 1;

    if (o->order.yaml != order->yaml)
        order_free(&o->order);
    o->order = *order;
    o->order.generation = generation;
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

int orders_take(struct orders *o, struct order *ret)
{
    int r;

    (void)pthread_mutex_lock(&o->lock);
    swap_flag(o, o->flag_value, 0);
    r = copy_order(o, ret);
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
    r = o->order.state == ORDER_RUN
            ? ttf_err_set(err, -EBUSY, NULL, "a run is under way, into %s", o->order.dataset)
            : save(o, &order, err);
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
    r = o->order.state == from ? save(o, &order, err)
                               : ttf_err_set(err, -ENOENT, NULL, "%s", otherwise);
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
    (void)pthread_mutex_unlock(&o->lock);
    return r;
}
