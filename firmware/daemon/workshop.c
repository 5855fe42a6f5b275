/* SPDX-License-Identifier: Apache-2.0 */
#include "workshop.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>

#define WAITING     4
#define PATIENCE_NS (30 * TTF_NS_PER_S)

enum place_state {
    PLACE_FREE = 0,
    PLACE_WAITS,
    PLACE_UNDER_WAY,
    PLACE_DONE
};

struct place {
    enum place_state state;
    struct workshop_job *job;
    struct ttf_gate *done; /* its own, made once */
    struct ttf_err err;
    int r;
};

struct workshop {
    struct ttf_clock *clock;
    struct ttf_gate *wake;
    pthread_mutex_t lock; /* over all below */
    bool open;
    struct place places[WAITING];
};

struct workshop *workshop_create(struct ttf_clock *clock, struct ttf_gate *wake)
{
    struct workshop *w = calloc(1, sizeof *w);
    bool whole = w != NULL;

    if (!w)
        return NULL;
    w->clock = clock;
    w->wake = wake;
    (void)pthread_mutex_init(&w->lock, NULL);
    for (unsigned i = 0; i < WAITING; i++) {
        w->places[i].done = ttf_gate_create(clock);
        whole = whole && w->places[i].done;
    }
    if (whole)
        return w;
    workshop_destroy(w);
    return NULL;
}

void workshop_destroy(struct workshop *w)
{
    if (!w)
        return;
    for (unsigned i = 0; i < WAITING; i++)
        ttf_gate_destroy(w->places[i].done);
    (void)pthread_mutex_destroy(&w->lock);
    free(w);
}

static struct place *find(struct workshop *w, enum place_state state)
{
    for (unsigned i = 0; i < WAITING; i++)
        if (w->places[i].state == state)
            return &w->places[i];
    return NULL;
}

/* Given up while it waits; false: it is under way, or done. */
static bool withdraw(struct workshop *w, struct place *place)
{
    bool waits;

    (void)pthread_mutex_lock(&w->lock);
    waits = place->state == PLACE_WAITS;
    if (waits)
        place->state = PLACE_FREE;
    (void)pthread_mutex_unlock(&w->lock);
    return waits;
}

static struct place *queue(struct workshop *w, struct workshop_job *job, int *ret_why)
{
    struct place *place = NULL;

    (void)pthread_mutex_lock(&w->lock);
    *ret_why = w->open ? -EAGAIN : -EBUSY;
    if (w->open)
        place = find(w, PLACE_FREE);
    if (place) {
        place->state = PLACE_WAITS;
        place->job = job;
        place->err = (struct ttf_err){0};
    }
    (void)pthread_mutex_unlock(&w->lock);
    return place;
}

int workshop_ask(struct workshop *w, struct workshop_job *job, struct ttf_err *err)
{
    struct place *place;
    int r;

    place = queue(w, job, &r);
    if (!place)
        return ttf_err_set(err, r, NULL, "%s",
                           r == -EBUSY ? "a run has the devices" : "too many wait for the devices");
    ttf_gate_open(w->wake);
    if (ttf_gate_wait(place->done, ttf_clock_now_ns(w->clock) + PATIENCE_NS) == -ETIMEDOUT) {
        if (withdraw(w, place))
            return ttf_err_set(err, -EAGAIN, NULL, "the devices are busy");
        (void)!ttf_gate_wait(place->done, TTF_NS_NEVER);
    }
    (void)pthread_mutex_lock(&w->lock);
    r = place->r;
    if (err)
        *err = place->err;
    place->state = PLACE_FREE;
    (void)pthread_mutex_unlock(&w->lock);
    return r;
}

bool workshop_work(struct workshop *w, workshop_fn *fn, void *ctx)
{
    struct place *place;
    int r;

    (void)pthread_mutex_lock(&w->lock);
    place = find(w, PLACE_WAITS);
    if (place)
        place->state = PLACE_UNDER_WAY;
    (void)pthread_mutex_unlock(&w->lock);
    if (!place)
        return false;
    r = fn(ctx, place->job, &place->err);
    (void)pthread_mutex_lock(&w->lock);
    place->r = r;
    place->state = PLACE_DONE;
    (void)pthread_mutex_unlock(&w->lock);
    ttf_gate_open(place->done);
    return true;
}

void workshop_open(struct workshop *w, bool open)
{
    (void)pthread_mutex_lock(&w->lock);
    w->open = open;
    for (unsigned i = 0; i < WAITING && !open; i++) {
        struct place *place = &w->places[i];

        if (place->state != PLACE_WAITS)
            continue;
        place->r = ttf_err_set(&place->err, -EBUSY, NULL, "a run has the devices");
        place->state = PLACE_DONE;
        ttf_gate_open(place->done);
    }
    (void)pthread_mutex_unlock(&w->lock);
}
