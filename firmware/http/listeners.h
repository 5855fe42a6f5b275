/* SPDX-License-Identifier: Apache-2.0 */
/* listeners.h: who listens to events (ttf/http/events.h), as the server sees it. Private to this room. */
#ifndef HTTP_LISTENERS_H
#define HTTP_LISTENERS_H

#include <microhttpd.h>

#include "request.h"
#include "ttf/http/events.h"

/* What has fallen silent is woken by the events, through its connection. Reads as libmicrohttpd asks. */
ssize_t listener_read(void *ctx, uint64_t at, char *buf, size_t room);
void listener_free(void *ctx); /* NULL allowed */

/* Before its first reading. */
void listener_connect(struct event_listener *listener, struct MHD_Connection *connection);

/*
 * A listener that begins behind the event of that id: "START-N", NULL or empty: with what is to come. leaving: of the socket that it
 * came by; borrowed. -EAGAIN: too many listen, or the events are closed; -ENOMEM.
 */
TTF_MUST_USE int listener_create(struct ttf_http_events *events, const char *last_id,
                                 const int *leaving, struct event_listener **ret,
                                 struct ttf_err *err);

/* All streams end, and none begins, until they are opened again; both wait for nobody. */
void events_close(struct ttf_http_events *events);
void events_open(struct ttf_http_events *events);
/* Streams of a socket that is being left end; when this returns none of them sleeps, or will. */
void events_leave(struct ttf_http_events *events);

/* The route. */
int events_answer(struct ttf_http_request *request, struct ttf_http_answer *ret);

#endif
