/* SPDX-License-Identifier: Apache-2.0 */
/*
 * A listener is a place in the ring and what is left of the piece that it is being sent. It sleeps as a suspended
 * connection, and is woken when there is something; what it does not take is not kept for it.
 */
#include "ttf/http/events.h"

#include <errno.h>
#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "listeners.h"
#include "ttf/http/token.h"

#define HELLO  "retry: 2000\n\n"
#define BEAT   ":\n\n"
#define MISSED "event: missed\ndata: {}\n\n"

struct event_listener {
    struct ttf_http_events *events;
    struct event_listener *next;
    struct MHD_Connection *connection;
    const int *leaving; /* atomically */
    uint64_t place;     /* the next event's number */
    size_t sent;        /* bytes of it that are sent already */
    const char *first;  /* a text to be sent before, constant */
    size_t first_sent;
    bool asleep; /* its connection is suspended */
    bool heard;  /* something since the last tick */
};

struct event {
    char *text; /* as it is sent; NULL: there was no memory for it */
    size_t bytes;
};

struct ttf_http_events {
    pthread_mutex_t lock; /* over all below */
    char start[17];
    uint64_t next; /* number of the next event; the first is 1 */
    struct event kept[TTF_HTTP_EVENTS_KEPT];
    struct event_listener *listeners;
    unsigned n_listeners;
    bool closed;
};

int ttf_http_events_create(struct ttf_http_events **ret, struct ttf_err *err)
{
    struct ttf_http_events *events;
    char token[TTF_HTTP_TOKEN_SIZE];
    int r = ttf_http_token_make(token, err);

    if (r < 0)
        return r;
    events = calloc(1, sizeof *events);
    if (!events)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    if (pthread_mutex_init(&events->lock, NULL) != 0) {
        free(events);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    }
    memcpy(events->start, token, 16);
    events->next = 1;
    *ret = events;
    return 0;
}

void ttf_http_events_destroy(struct ttf_http_events *events)
{
    if (!events)
        return;
    for (unsigned i = 0; i < TTF_HTTP_EVENTS_KEPT; i++)
        free(events->kept[i].text);
    (void)pthread_mutex_destroy(&events->lock);
    free(events);
}

static struct event *event_at(struct ttf_http_events *events, uint64_t number)
{
    return &events->kept[number % TTF_HTTP_EVENTS_KEPT];
}

static uint64_t oldest(const struct ttf_http_events *events)
{
    return events->next > TTF_HTTP_EVENTS_KEPT ? events->next - TTF_HTTP_EVENTS_KEPT : 1;
}

/* ---- waking ---- */

static void wake(struct event_listener *listener)
{
    if (listener->asleep)
        MHD_resume_connection(listener->connection);
    listener->asleep = false;
}

static void wake_all(struct ttf_http_events *events)
{
    for (struct event_listener *l = events->listeners; l; l = l->next)
        wake(l);
}

static struct event make(const struct ttf_http_events *events, uint64_t number, const char *kind,
                         const char *json)
{
    struct event event = {0};
    size_t room = strlen(kind) + strlen(json) + 80;

    event.text = malloc(room);
    if (event.text)
        event.bytes =
            (size_t)snprintf(event.text, room, "id: %s-%" PRIu64 "\nevent: %s\ndata: %s\n\n",
                             events->start, number, kind, json);
    return event;
}

void ttf_http_events_publish(struct ttf_http_events *events, const char *kind, const char *json)
{
    struct event *place;

    if (strlen(json) > TTF_HTTP_EVENT_MAX || strpbrk(json, "\r\n"))
        return; /* would be another event's beginning */
    (void)pthread_mutex_lock(&events->lock);
    place = event_at(events, events->next);
    free(place->text);
    *place = make(events, events->next, kind, json);
    events->next++;
    wake_all(events);
    (void)pthread_mutex_unlock(&events->lock);
}

void ttf_http_events_tick(struct ttf_http_events *events)
{
    (void)pthread_mutex_lock(&events->lock);
    for (struct event_listener *l = events->listeners; l; l = l->next) {
        if (!l->heard && !l->first) {
            l->first = BEAT;
            l->first_sent = 0;
            wake(l);
        }
        l->heard = false;
    }
    (void)pthread_mutex_unlock(&events->lock);
}

const char *ttf_http_events_last(struct ttf_http_events *events, char ret[TTF_HTTP_EVENT_ID_SIZE])
{
    (void)pthread_mutex_lock(&events->lock);
    (void)snprintf(ret, TTF_HTTP_EVENT_ID_SIZE, "%s-%" PRIu64, events->start, events->next - 1);
    (void)pthread_mutex_unlock(&events->lock);
    return ret;
}

void events_close(struct ttf_http_events *events)
{
    (void)pthread_mutex_lock(&events->lock);
    events->closed = true;
    wake_all(events);
    (void)pthread_mutex_unlock(&events->lock);
}

/* Each looks whether it is one of them: with the lock held, before it sleeps. */
void events_leave(struct ttf_http_events *events)
{
    (void)pthread_mutex_lock(&events->lock);
    wake_all(events);
    (void)pthread_mutex_unlock(&events->lock);
}

void events_open(struct ttf_http_events *events)
{
    (void)pthread_mutex_lock(&events->lock);
    events->closed = false;
    (void)pthread_mutex_unlock(&events->lock);
}

/* ---- a listener ---- */

/* Where one that last heard of `last_id` goes on. false: that is not remembered. */
static bool find_place(const struct ttf_http_events *events, const char *last_id, uint64_t *ret)
{
    size_t n = strlen(events->start);
    char *end = NULL;
    uint64_t number;

    *ret = events->next;
    if (!last_id || !*last_id)
        return true;
    if (strncmp(last_id, events->start, n) != 0 || last_id[n] != '-' || last_id[n + 1] < '0' ||
        last_id[n + 1] > '9')
        return false;
    number = strtoull(last_id + n + 1, &end, 10);
    if (*end || number >= events->next || number + 1 < oldest(events))
        return false;
    *ret = number + 1;
    return true;
}

int listener_create(struct ttf_http_events *events, const char *last_id, const int *leaving,
                    struct event_listener **ret, struct ttf_err *err)
{
    struct event_listener *listener = calloc(1, sizeof *listener);
    int r = 0;

    if (!listener)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    listener->events = events;
    listener->leaving = leaving;
    (void)pthread_mutex_lock(&events->lock);
    if (events->closed || events->n_listeners == TTF_HTTP_LISTENERS_MAX) {
        r = -EAGAIN;
    } else {
        listener->first = find_place(events, last_id, &listener->place) ? HELLO : HELLO MISSED;
        listener->next = events->listeners;
        events->listeners = listener;
        events->n_listeners++;
    }
    (void)pthread_mutex_unlock(&events->lock);
    if (r < 0) {
        free(listener);
        return ttf_err_set(err, r, NULL, "too many listen already: %d", TTF_HTTP_LISTENERS_MAX);
    }
    *ret = listener;
    return 0;
}

void listener_connect(struct event_listener *listener, struct MHD_Connection *connection)
{
    listener->connection = connection;
}

void listener_free(void *ctx)
{
    struct event_listener *listener = ctx;
    struct ttf_http_events *events;

    if (!listener)
        return;
    events = listener->events;
    (void)pthread_mutex_lock(&events->lock);
    for (struct event_listener **at = &events->listeners; *at; at = &(*at)->next) {
        if (*at != listener)
            continue;
        *at = listener->next;
        events->n_listeners--;
        break;
    }
    (void)pthread_mutex_unlock(&events->lock);
    free(listener);
}

/* What is to be sent next; 0: nothing yet. */
static size_t take(struct event_listener *l, char *buf, size_t room)
{
    const struct event *event;
    size_t n;

    if (l->first && l->sent == 0) {
        n = strlen(l->first) - l->first_sent;
        n = n < room ? n : room;
        memcpy(buf, l->first + l->first_sent, n);
        l->first_sent += n;
        if (!l->first[l->first_sent])
            l->first = NULL;
        return n;
    }
    if (l->place == l->events->next)
        return 0;
    event = event_at(l->events, l->place);
    n = event->bytes - l->sent;
    n = n < room ? n : room;
    if (n > 0)
        memcpy(buf, event->text + l->sent, n);
    l->sent += n;
    if (l->sent == event->bytes) {
        l->sent = 0;
        l->place++;
    }
    return n;
}

/* What it waits for is not remembered any more, or never was. false: in the middle of it. */
static bool catch_up(struct event_listener *l)
{
    bool behind = l->place < oldest(l->events);

    if (behind && l->sent > 0)
        return false;
    if (behind)
        l->place = oldest(l->events);
    while (l->place < l->events->next && !event_at(l->events, l->place)->text) {
        behind = true;
        l->place++;
    }
    if (behind) {
        l->first = MISSED;
        l->first_sent = 0;
    }
    return true;
}

ssize_t listener_read(void *ctx, uint64_t at, char *buf, size_t room)
{
    struct event_listener *l = ctx;
    struct ttf_http_events *events = l->events;
    ssize_t n;

    (void)at;
    (void)pthread_mutex_lock(&events->lock);
    if (events->closed || __atomic_load_n(l->leaving, __ATOMIC_SEQ_CST) || !catch_up(l)) {
        n = MHD_CONTENT_READER_END_OF_STREAM;
    } else {
        n = (ssize_t)take(l, buf, room);
        l->heard = l->heard || n > 0;
        if (n == 0) {
            l->asleep = true;
            MHD_suspend_connection(l->connection);
        }
    }
    (void)pthread_mutex_unlock(&events->lock);
    return n;
}

int events_answer(struct ttf_http_request *request, struct ttf_http_answer *ret)
{
    if (!request->events)
        return ttf_err_set(&request->err, -ENODEV, NULL, "this server has no box");
    return listener_create(request->events, request_header(request, "Last-Event-ID"),
                           request->leaving, &ret->listener, &request->err);
}
