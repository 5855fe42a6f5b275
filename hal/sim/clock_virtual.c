/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Virtual time. It stands still while any joined thread runs. When all of them
 * wait, the clock goes to the earliest deadline and lets exactly one thread
 * through: the one that asked first among equals. So threads that only wait on
 * the clock run one after another, in the same order every time.
 */
#include "clock.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>

#include "ttf/base/time.h"

/* One waiting thread; lives on its stack, in a list by (deadline, arrival). */
struct waiter {
    int64_t deadline_ns;
    struct waiter *next;
    pthread_cond_t woken;
    bool done;
    int result;
};

struct virtual_clock {
    struct ttf_clock base;
    pthread_mutex_t lock;
    int64_t now_ns;
    int joined;
    int waiting;
    struct waiter *first;
    int64_t cost_ns[TTF_WORK_COUNT];
    struct sim_utc *utc;
    char boot_id[37];
};

struct virtual_gate {
    struct ttf_gate base;
    bool open;
    struct waiter *waiter;
};

static struct virtual_clock *of(struct ttf_clock *base)
{
    return (struct virtual_clock *)base;
}

static int64_t virtual_now_ns(struct ttf_clock *base)
{
    struct virtual_clock *clock = of(base);
    int64_t now;

    pthread_mutex_lock(&clock->lock);
    now = clock->now_ns;
    pthread_mutex_unlock(&clock->lock);
    return now;
}

static void virtual_utc(struct ttf_clock *base, struct ttf_utc *ret)
{
    int64_t now = virtual_now_ns(base);

    if (of(base)->utc) {
        sim_utc_at(of(base)->utc, now, ret);
        return;
    }
    *ret = (struct ttf_utc){
        .boot_ns = now, .utc_ns = now, .uncertainty_ns = TTF_NS_UNKNOWN, .trust = TTF_TRUST_NONE};
}

static const char *virtual_boot_id(struct ttf_clock *base)
{
    return of(base)->boot_id;
}

static void let_through(struct virtual_clock *clock, struct waiter *w, int result)
{
    struct waiter **at = &clock->first;

    while (*at != w)
        at = &(*at)->next;
    *at = w->next;
    w->done = true;
    w->result = result;
    clock->waiting--; /* it runs from this moment on, whenever the system schedules it */
    pthread_cond_signal(&w->woken);
}

/* With everybody waiting, the next deadline comes. */
static void turn(struct virtual_clock *clock)
{
    struct waiter *w = clock->first;

    if (clock->waiting < clock->joined || !w || w->deadline_ns == TTF_NS_NEVER)
        return;
    if (w->deadline_ns > clock->now_ns)
        clock->now_ns = w->deadline_ns;
    let_through(clock, w, -ETIMEDOUT);
}

/* Called and returns with the lock held. */
static int wait_here(struct virtual_clock *clock, struct waiter *w)
{
    struct waiter **at = &clock->first;

    if (pthread_cond_init(&w->woken, NULL) != 0)
        return -ENOMEM;
    while (*at && (*at)->deadline_ns <= w->deadline_ns)
        at = &(*at)->next;
    w->next = *at;
    *at = w;
    clock->waiting++;
    turn(clock);
    while (!w->done)
        pthread_cond_wait(&w->woken, &clock->lock);
    pthread_cond_destroy(&w->woken);
    return w->result;
}

static int virtual_wait_until(struct ttf_clock *base, int64_t deadline_ns)
{
    struct virtual_clock *clock = of(base);
    struct waiter w = {.deadline_ns = deadline_ns};

    pthread_mutex_lock(&clock->lock);
    if (deadline_ns > clock->now_ns)
        wait_here(clock, &w);
    pthread_mutex_unlock(&clock->lock);
    return 0;
}

static void virtual_charge(struct ttf_clock *base, enum ttf_work work, unsigned times)
{
    struct virtual_clock *clock = of(base);

    virtual_wait_until(base, virtual_now_ns(base) + clock->cost_ns[work] * (int64_t)times);
}

static void virtual_join(struct ttf_clock *base)
{
    struct virtual_clock *clock = of(base);

    pthread_mutex_lock(&clock->lock);
    clock->joined++;
    pthread_mutex_unlock(&clock->lock);
}

static void virtual_leave(struct ttf_clock *base)
{
    struct virtual_clock *clock = of(base);

    pthread_mutex_lock(&clock->lock);
    clock->joined--;
    turn(clock);
    pthread_mutex_unlock(&clock->lock);
}

static struct ttf_gate *virtual_gate_create(struct ttf_clock *base)
{
    struct virtual_gate *gate = calloc(1, sizeof(*gate));

    if (!gate)
        return NULL;
    gate->base.clock = base;
    return &gate->base;
}

static void virtual_gate_destroy(struct ttf_gate *base)
{
    free(base);
}

static void virtual_gate_open(struct ttf_gate *base)
{
    struct virtual_gate *gate = (struct virtual_gate *)base;
    struct virtual_clock *clock = of(base->clock);

    pthread_mutex_lock(&clock->lock);
    if (gate->waiter && !gate->waiter->done) {
        let_through(clock, gate->waiter, 0);
        gate->waiter = NULL;
    } else {
        gate->open = true; /* nobody waits, or its deadline came first: kept for the next wait */
    }
    pthread_mutex_unlock(&clock->lock);
}

static int virtual_gate_wait(struct ttf_gate *base, int64_t deadline_ns)
{
    struct virtual_gate *gate = (struct virtual_gate *)base;
    struct virtual_clock *clock = of(base->clock);
    struct waiter w = {.deadline_ns = deadline_ns};
    int r = 0;

    pthread_mutex_lock(&clock->lock);
    if (gate->open) {
        gate->open = false;
    } else if (deadline_ns <= clock->now_ns) {
        r = -ETIMEDOUT;
    } else {
        gate->waiter = &w;
        r = wait_here(clock, &w);
        if (r < 0)
            gate->waiter = NULL;
    }
    pthread_mutex_unlock(&clock->lock);
    return r;
}

static void virtual_destroy(struct ttf_clock *base)
{
    struct virtual_clock *clock = of(base);

    pthread_mutex_destroy(&clock->lock);
    free(clock);
}

static const struct ttf_clock_ops virtual_clock_ops = {
    .name = "virtual",
    .is_virtual = true,
    .now_ns = virtual_now_ns,
    .utc = virtual_utc,
    .boot_id = virtual_boot_id,
    .join = virtual_join,
    .leave = virtual_leave,
    .wait_until = virtual_wait_until,
    .charge = virtual_charge,
    .gate_create = virtual_gate_create,
    .gate_destroy = virtual_gate_destroy,
    .gate_open = virtual_gate_open,
    .gate_wait = virtual_gate_wait,
    .destroy = virtual_destroy,
};

struct ttf_clock *sim_clock_virtual_create(int64_t start_ns, const char *boot_id,
                                           const int64_t cost_ns[TTF_WORK_COUNT],
                                           struct sim_utc *utc)
{
    struct virtual_clock *clock = calloc(1, sizeof(*clock));

    if (!clock)
        return NULL;
    if (pthread_mutex_init(&clock->lock, NULL) != 0) {
        free(clock);
        return NULL;
    }
    clock->base.ops = &virtual_clock_ops;
    clock->now_ns = start_ns;
    clock->utc = utc;
    for (int i = 0; i < TTF_WORK_COUNT; i++)
        clock->cost_ns[i] = cost_ns ? cost_ns[i] : 0;
    snprintf(clock->boot_id, sizeof(clock->boot_id), "%s", boot_id);
    return &clock->base;
}
