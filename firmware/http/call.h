/* SPDX-License-Identifier: Apache-2.0 */
/* call.h: one request from its headers to its answer, and what all requests of a server share. Private to this room. */
#ifndef HTTP_CALL_H
#define HTTP_CALL_H

#include <microhttpd.h>
#include <stdbool.h>

#include "guests.h"
#include "request.h"
#include "shelf.h"
#include "slow.h"
#include "token_limits.h"
#include "ttf/http/events.h"

/* What requests share; nothing of it changes while a socket listens, but which folder is the newest of the shelves. */
struct calls {
    struct shelves *shelves;
    struct ttf_io *io;
    struct slow *lanes[TTF_HTTP_LANES]; /* none of TTF_HTTP_AT_ONCE */
    struct limits *limits;
    struct ttf_clock *clock;
    struct ttf_http_box *box;
    struct ttf_http_events *events;
    const char *token;
    const char *const *names;
};

struct call_socket {
    const struct calls *calls;
    struct guests *guests;
    bool free_to_read;
    int leaving; /* atomically: nothing new is taken here, and no connection falls asleep any more */
    int asleep;  /* atomically: connections that sleep until a lane has answered them */
};

struct call;

/* For libmicrohttpd; ctx is a struct call_socket. */
enum MHD_Result call_admit(void *ctx, const struct sockaddr *address, socklen_t size);
enum MHD_Result call_on(void *ctx, struct MHD_Connection *connection, const char *url,
                        const char *method, const char *version, const char *data,
                        size_t *data_bytes, void **of_request);
void call_done(void *ctx, struct MHD_Connection *connection, void **of_request,
               enum MHD_RequestTerminationCode how);
void call_comes_and_goes(void *ctx, struct MHD_Connection *connection, void **of_connection,
                         enum MHD_ConnectionNotificationCode what);

/* Runs a call's handler, and lets its connection go on; or, where it is not to be answered, only the latter, saying why. */
void call_run(struct call *call);
void call_cancel(struct call *call, const char *why);

#endif
