/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/capture/control.h"

#include <errno.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "asks.h"

/* Answers kept for whoever asks by number. */
#define ANSWERS_KEPT 64

enum ask_state {
    ASK_FREE = 0,
    ASK_WAITS,
    ASK_TAKEN
};

struct asked {
    enum ask_state state;
    int64_t number;
    char *yaml;
    struct ttf_ask ask;
};

struct answer {
    int64_t number; /* 0: none yet */
    int code;
    struct ttf_err err;
};

struct ttf_control {
    pthread_mutex_t mutex;
    int64_t last_number;
    struct asked asks[TTF_ASKS_MAX];
    struct answer answers[ANSWERS_KEPT]; /* of number n: at n % ANSWERS_KEPT */
};

struct ttf_control *ttf_control_create(void)
{
    struct ttf_control *control = calloc(1, sizeof(*control));

    if (control && pthread_mutex_init(&control->mutex, NULL)) {
        free(control);
        return NULL;
    }
    return control;
}

void ttf_control_destroy(struct ttf_control *control)
{
    if (!control)
        return;
    for (unsigned i = 0; i < TTF_ASKS_MAX; i++)
        free(control->asks[i].yaml);
    pthread_mutex_destroy(&control->mutex);
    free(control);
}

/* The one with this number that waits or is taken; NULL. Under the mutex. */
static struct asked *find(struct ttf_control *control, int64_t number)
{
    for (unsigned i = 0; i < TTF_ASKS_MAX; i++)
        if (control->asks[i].state != ASK_FREE && control->asks[i].number == number)
            return &control->asks[i];
    return NULL;
}

static struct asked *find_free(struct ttf_control *control)
{
    for (unsigned i = 0; i < TTF_ASKS_MAX; i++)
        if (control->asks[i].state == ASK_FREE)
            return &control->asks[i];
    return NULL;
}

int64_t ttf_control_ask(struct ttf_control *control, const struct ttf_ask *ask)
{
    char *yaml = NULL;
    struct asked *a;
    int64_t number = -EAGAIN;

    if ((unsigned)ask->kind >= TTF_ASK_KIND_COUNT)
        return -EINVAL;
    if (ask->kind == TTF_ASK_PLAN && ask->plan_yaml) {
        yaml = strdup(ask->plan_yaml);
        if (!yaml)
            return -ENOMEM;
    }
    pthread_mutex_lock(&control->mutex);
    a = find_free(control);
    if (a) {
        number = ++control->last_number;
        a->state = ASK_WAITS;
        a->number = number;
        a->ask = *ask;
        a->ask.plan_yaml = a->yaml = yaml;
        yaml = NULL;
    }
    pthread_mutex_unlock(&control->mutex);
    free(yaml);
    return number;
}

int ttf_control_answer(struct ttf_control *control, int64_t number, struct ttf_err *err)
{
    const struct answer *answer = &control->answers[number > 0 ? number % ANSWERS_KEPT : 0];
    int code = -ENOENT;

    pthread_mutex_lock(&control->mutex);
    if (number > 0 && find(control, number)) {
        code = -EAGAIN;
    } else if (number > 0 && answer->number == number) {
        code = answer->code;
        if (code < 0 && err)
            *err = answer->err;
    }
    pthread_mutex_unlock(&control->mutex);
    return code;
}

unsigned ttf_control_waiting(struct ttf_control *control)
{
    unsigned n = 0;

    pthread_mutex_lock(&control->mutex);
    for (unsigned i = 0; i < TTF_ASKS_MAX; i++)
        n += control->asks[i].state != ASK_FREE;
    pthread_mutex_unlock(&control->mutex);
    return n;
}

/* The oldest that waits and is due; NULL. Under the mutex. */
static struct asked *oldest_due(struct ttf_control *control, int64_t index)
{
    struct asked *oldest = NULL;

    for (unsigned i = 0; i < TTF_ASKS_MAX; i++) {
        struct asked *a = &control->asks[i];

        if (a->state == ASK_WAITS && a->ask.from_index <= index &&
            (!oldest || a->number < oldest->number))
            oldest = a;
    }
    return oldest;
}

bool ttf_asks_due(struct ttf_control *control, int64_t index)
{
    bool due;

    if (!control)
        return false;
    pthread_mutex_lock(&control->mutex);
    due = oldest_due(control, index) != NULL;
    pthread_mutex_unlock(&control->mutex);
    return due;
}

struct ttf_ask *ttf_asks_take(struct ttf_control *control, int64_t index, int64_t *ret_number)
{
    struct asked *a;

    if (!control)
        return NULL;
    pthread_mutex_lock(&control->mutex);
    a = oldest_due(control, index);
    if (a) {
        a->state = ASK_TAKEN;
        *ret_number = a->number;
    }
    pthread_mutex_unlock(&control->mutex);
    return a ? &a->ask : NULL;
}

/* Under the mutex. */
static void answer(struct ttf_control *control, struct asked *a, int code,
                   const struct ttf_err *err)
{
    struct answer *kept = &control->answers[a->number % ANSWERS_KEPT];

    memset(kept, 0, sizeof(*kept));
    kept->number = a->number;
    kept->code = code;
    if (err)
        kept->err = *err;
    free(a->yaml);
    memset(a, 0, sizeof(*a));
}

void ttf_asks_answer(struct ttf_control *control, int64_t number, int code,
                     const struct ttf_err *err)
{
    struct asked *a;

    if (!control || number <= 0)
        return;
    pthread_mutex_lock(&control->mutex);
    a = find(control, number);
    if (a)
        answer(control, a, code, err);
    pthread_mutex_unlock(&control->mutex);
}

void ttf_asks_end(struct ttf_control *control)
{
    struct ttf_err err = {0};

    if (!control)
        return;
    ttf_err_set(&err, -ECANCELED, NULL, "the run ended before this was done");
    pthread_mutex_lock(&control->mutex);
    for (unsigned i = 0; i < TTF_ASKS_MAX; i++)
        if (control->asks[i].state == ASK_TAKEN)
            answer(control, &control->asks[i], -ECANCELED, &err);
    pthread_mutex_unlock(&control->mutex);
}
