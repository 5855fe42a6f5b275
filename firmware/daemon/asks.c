/* SPDX-License-Identifier: Apache-2.0 */
#include "asks.h"

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define KEPT       64
#define FIRST_MASK ((UINT64_C(1) << 48) - 1) /* a double, as clients have it, counts on to 2^53 */

struct asked {
    int64_t number; /* 0: free */
    int64_t letter; /* in the run's letter box; 0: a stop */
    enum ttf_http_ask_kind kind;
    bool answered, told;
    int r;
    char error[400];
};

struct asks {
    pthread_mutex_t lock; /* over all below */
    struct ttf_control *control;
    int64_t last;
    struct asked kept[KEPT];
};

static const char *kind_name(enum ttf_http_ask_kind kind)
{
    static const char *const NAMES[] = {"stop", "pause", "resume", "count", "until", "interval"};

    return NAMES[kind];
}

struct asks *asks_create(uint64_t random)
{
    struct asks *asks = calloc(1, sizeof *asks);

    if (!asks)
        return NULL;
    (void)pthread_mutex_init(&asks->lock, NULL);
    asks->last = (int64_t)(random & FIRST_MASK);
    return asks;
}

void asks_destroy(struct asks *asks)
{
    if (!asks)
        return;
    ttf_control_destroy(asks->control);
    (void)pthread_mutex_destroy(&asks->lock);
    free(asks);
}

struct ttf_control *asks_begin(struct asks *asks)
{
    struct ttf_control *control = ttf_control_create();

    (void)pthread_mutex_lock(&asks->lock);
    ttf_control_destroy(asks->control);
    asks->control = control;
    (void)pthread_mutex_unlock(&asks->lock);
    return control;
}

static void answer(struct asked *asked, int r, const struct ttf_err *err)
{
    asked->answered = true;
    asked->r = r;
    if (r < 0)
        (void)snprintf(asked->error, sizeof asked->error, "%s",
                       *err->what ? err->what : strerrordesc_np(-r));
}

static void look(struct asks *asks)
{
    for (unsigned i = 0; i < KEPT; i++) {
        struct asked *asked = &asks->kept[i];
        struct ttf_err err = {0};
        int r;

        if (!asked->number || asked->answered || !asked->letter || !asks->control)
            continue;
        r = ttf_control_answer(asks->control, asked->letter, &err);
        if (r != -EAGAIN)
            answer(asked, r, &err);
    }
}

void asks_end(struct asks *asks)
{
    const struct ttf_err ended = {.what = "the run ended before it was done"};

    (void)pthread_mutex_lock(&asks->lock);
    look(asks);
    for (unsigned i = 0; i < KEPT; i++)
        if (asks->kept[i].number && !asks->kept[i].answered)
            answer(&asks->kept[i], asks->kept[i].letter ? -ECANCELED : 0, &ended);
    ttf_control_destroy(asks->control);
    asks->control = NULL;
    (void)pthread_mutex_unlock(&asks->lock);
}

/* The oldest makes room. */
static struct asked *add(struct asks *asks, enum ttf_http_ask_kind kind)
{
    struct asked *asked = &asks->kept[++asks->last % KEPT];

    *asked = (struct asked){.number = asks->last, .kind = kind};
    return asked;
}

static struct ttf_ask ask_of(const struct ttf_http_ask *ask)
{
    struct ttf_ask ret = {.note.utc_ns = TTF_NS_UNKNOWN};

    switch (ask->kind) {
    case TTF_HTTP_ASK_PAUSE:
        ret.kind = TTF_ASK_PAUSE;
        (void)snprintf(ret.reason, sizeof ret.reason, "%s", ask->reason);
        break;
    case TTF_HTTP_ASK_RESUME:
        ret.kind = TTF_ASK_CONTINUE;
        break;
    case TTF_HTTP_ASK_COUNT:
        ret.kind = TTF_ASK_COUNT;
        ret.count = ask->value;
        break;
    case TTF_HTTP_ASK_UNTIL:
        ret.kind = TTF_ASK_UNTIL;
        ret.until_utc_ns = ask->value;
        break;
    case TTF_HTTP_ASK_INTERVAL:
        ret.kind = TTF_ASK_INTERVAL;
        ret.interval_ns = ask->value;
        break;
    case TTF_HTTP_ASK_STOP:
    case TTF_HTTP_ASK_KIND_COUNT:
        ret.kind = TTF_ASK_STOP;
        break;
    }
    return ret;
}

int64_t asks_put(struct asks *asks, const struct ttf_http_ask *ask, struct ttf_err *err)
{
    const struct ttf_ask letter = ask_of(ask);
    int64_t number;

    (void)pthread_mutex_lock(&asks->lock);
    number = asks->control ? ttf_control_ask(asks->control, &letter) : -ENOENT;
    if (number > 0) {
        struct asked *asked = add(asks, ask->kind);

        asked->letter = number;
        number = asked->number;
    }
    (void)pthread_mutex_unlock(&asks->lock);
    if (number == -ENOENT)
        ttf_err_set(err, -ENOENT, NULL, "no run is under way");
    else if (number < 0)
        ttf_err_set(err, (int)number, NULL, "too much is asked at once");
    return number;
}

int64_t asks_stop(struct asks *asks)
{
    int64_t number;

    (void)pthread_mutex_lock(&asks->lock);
    number = add(asks, TTF_HTTP_ASK_STOP)->number;
    (void)pthread_mutex_unlock(&asks->lock);
    return number;
}

void asks_take_back(struct asks *asks, int64_t number)
{
    (void)pthread_mutex_lock(&asks->lock);
    if (number > 0 && asks->kept[number % KEPT].number == number)
        asks->kept[number % KEPT] = (struct asked){0};
    (void)pthread_mutex_unlock(&asks->lock);
}

static void put(const struct asked *asked, struct ttf_json *json)
{
    ttf_json_object(json);
    ttf_json_kint(json, "number", asked->number);
    ttf_json_kstring(json, "ask", kind_name(asked->kind));
    ttf_json_kbool(json, "answered", asked->answered);
    if (asked->answered)
        ttf_json_kbool(json, "done", asked->r == 0);
    if (asked->r < 0)
        ttf_json_kstring(json, "error", asked->error);
    ttf_json_object_end(json);
}

bool asks_answered(struct asks *asks, struct ttf_json *json)
{
    bool found = false;

    (void)pthread_mutex_lock(&asks->lock);
    look(asks);
    for (unsigned i = 0; i < KEPT && !found; i++) {
        struct asked *asked = &asks->kept[i];

        if (!asked->number || !asked->answered || asked->told)
            continue;
        asked->told = found = true;
        put(asked, json);
    }
    (void)pthread_mutex_unlock(&asks->lock);
    return found;
}

int asks_show(struct asks *asks, int64_t number, struct ttf_json *json)
{
    int r = -ENOENT;

    (void)pthread_mutex_lock(&asks->lock);
    look(asks);
    if (number > 0 && asks->kept[number % KEPT].number == number) {
        put(&asks->kept[number % KEPT], json);
        r = 0;
    }
    (void)pthread_mutex_unlock(&asks->lock);
    return r;
}
