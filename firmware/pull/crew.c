/* SPDX-License-Identifier: Apache-2.0 */
#include "crew.h"

#include <errno.h>
#include <pthread.h>
#include <signal.h>
#include <stdlib.h>
#include <string.h>

struct hand {
    struct crew *crew;
    struct landing landing;
    pthread_t thread;
};

struct crew {
    pthread_mutex_t mutex;
    pthread_cond_t work, done;
    /* under the mutex */
    struct errand *first, **last; /* not begun */
    const struct errand *awaited; /* by whoever asked for it */
    unsigned idle;                /* hands without work */
    bool ending;
    /* whoever waits is one thread */
    struct landing own; /* where there are no hands */
    unsigned n_hands;
    struct hand hands[CREW_HANDS];
};

static void run_errand(struct landing *landing, struct errand *e)
{
    landing->name = e->name;
    if (landing->folder != e->folder)
        landing->made[0] = '\0';
    landing->folder = e->folder;
    landing->doubtful = e->doubtful;
    e->r = landing_ensure(landing, e->path, e->bytes, e->sha256, e->trust, &e->landed, &e->why);
}

static void *work(void *ctx)
{
    struct hand *hand = ctx;
    struct crew *crew = hand->crew;

    pthread_mutex_lock(&crew->mutex);
    for (;;) {
        struct errand *e;

        while (!crew->first && !crew->ending) {
            crew->idle++;
            pthread_cond_wait(&crew->work, &crew->mutex);
            crew->idle--;
        }
        if (crew->ending)
            break;
        e = crew->first;
        crew->first = e->next;
        if (!crew->first)
            crew->last = &crew->first;
        pthread_mutex_unlock(&crew->mutex);
        run_errand(&hand->landing, e);
        pthread_mutex_lock(&crew->mutex);
        e->done = true;
        if (crew->awaited == e)
            pthread_cond_signal(&crew->done);
    }
    pthread_mutex_unlock(&crew->mutex);
    return NULL;
}

/* As many as can be had. Signals are the program's own threads'. */
static void hire(struct crew *crew, const struct ttf_pull_config *config, const struct wire *wire)
{
    sigset_t all, before;

    (void)sigfillset(&all);
    if (pthread_sigmask(SIG_SETMASK, &all, &before) != 0)
        return;
    while (crew->n_hands < CREW_HANDS) {
        struct hand *hand = &crew->hands[crew->n_hands];

        *hand = (struct hand){.crew = crew, .landing = {.io = config->io}};
        if (pull_wire_twin(wire, &hand->landing.wire) < 0)
            break;
        if (pthread_create(&hand->thread, NULL, work, hand) != 0) {
            pull_wire_destroy(hand->landing.wire);
            break;
        }
        crew->n_hands++;
    }
    (void)pthread_sigmask(SIG_SETMASK, &before, NULL);
}

int crew_create(const struct ttf_pull_config *config, struct wire *wire, struct crew **ret,
                struct ttf_err *err)
{
    struct crew *crew = calloc(1, sizeof *crew);

    if (!crew)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    (void)pthread_mutex_init(&crew->mutex, NULL); /* of the default kind: they do not fail */
    (void)pthread_cond_init(&crew->work, NULL);
    (void)pthread_cond_init(&crew->done, NULL);
    crew->last = &crew->first;
    crew->own = (struct landing){.io = config->io, .wire = wire};
    hire(crew, config, wire);
    *ret = crew;
    return 0;
}

void crew_destroy(struct crew *crew)
{
    if (!crew)
        return;
    pthread_mutex_lock(&crew->mutex);
    crew->ending = true;
    pthread_cond_broadcast(&crew->work);
    pthread_mutex_unlock(&crew->mutex);
    for (unsigned i = 0; i < crew->n_hands; i++) {
        (void)pthread_join(crew->hands[i].thread, NULL);
        pull_wire_destroy(crew->hands[i].landing.wire);
        landing_free(&crew->hands[i].landing);
    }
    landing_free(&crew->own);
    (void)pthread_cond_destroy(&crew->done);
    (void)pthread_cond_destroy(&crew->work);
    (void)pthread_mutex_destroy(&crew->mutex);
    free(crew);
}

void crew_do(struct crew *crew, struct errand *e)
{
    e->done = false;
    e->next = NULL;
    memset(&e->why, 0, sizeof e->why);
    if (crew->n_hands == 0) {
        run_errand(&crew->own, e);
        e->done = true;
        return;
    }
    pthread_mutex_lock(&crew->mutex);
    *crew->last = e;
    crew->last = &e->next;
    if (crew->idle > 0)
        pthread_cond_signal(&crew->work);
    pthread_mutex_unlock(&crew->mutex);
}

void crew_wait(struct crew *crew, const struct errand *e)
{
    pthread_mutex_lock(&crew->mutex);
    crew->awaited = e;
    while (!e->done)
        pthread_cond_wait(&crew->done, &crew->mutex);
    crew->awaited = NULL;
    pthread_mutex_unlock(&crew->mutex);
}

void crew_drop(struct crew *crew)
{
    pthread_mutex_lock(&crew->mutex);
    for (struct errand *e = crew->first; e; e = e->next) {
        e->r = -ECANCELED;
        e->landed = (struct landed){.ours = true};
        e->done = true;
    }
    crew->first = NULL;
    crew->last = &crew->first;
    pthread_mutex_unlock(&crew->mutex);
}
