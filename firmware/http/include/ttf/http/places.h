/* SPDX-License-Identifier: Apache-2.0 */
/*
 * places.h: where a server is to listen: each place is opened, tried again while it cannot be had, and, where it is a network
 * interface's, followed to the address that the interface has now. One thread.
 */
#ifndef TTF_HTTP_PLACES_H
#define TTF_HTTP_PLACES_H

#include <stdbool.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/http/listen.h"
#include "ttf/http/server.h"

#define TTF_HTTP_PLACES_MAX 8 /* as many sockets as a server has */

struct ttf_http_place {
    const char *text;             /* as it was asked for */
    char at[TTF_HTTP_WHERE_SIZE]; /* what it stood for when it was opened */
    char name[128];               /* as it was bound */
    bool free_to_read;            /* whoever reaches it may read */
    int fd;                       /* the server's; -1: not open */
    bool complained;              /* that it cannot be had: once, until it can */
};

enum ttf_http_place_news {
    TTF_HTTP_PLACE_LISTENING,  /* open: name, at */
    TTF_HTTP_PLACE_LEFT,       /* its interface has that address no more */
    TTF_HTTP_PLACE_UNREACHABLE /* it cannot be had; told once, until it can */
};

struct ttf_http_places {
    ttf_http_address_fn *address_of; /* ttf_http_address_of, but for tests */
    void *ctx;
    const char *sys;    /* "/sys", or a folder laid out like it */
    bool as_ever;       /* nobody asked for an interface that is not there, or that is no cable's */
    bool free_loopback; /* loopback is free to read; else a UNIX socket alone */
    void (*tell)(void *tell_ctx, enum ttf_http_place_news news, const struct ttf_http_place *place,
                 const struct ttf_err *err); /* err: why it is unreachable, else NULL */
    void *tell_ctx;
    unsigned n;
    struct ttf_http_place places[TTF_HTTP_PLACES_MAX];
};

/* One more place, not open yet; text is borrowed. -ENOSPC. */
TTF_MUST_USE int ttf_http_places_add(struct ttf_http_places *places, const char *text);

/*
 * To be called each second or so. Opens what is not open, leaves what an interface has no more; tells of each change. 0, or
 * why a place is not open after it, the first of them (of one that nobody asked for: 0).
 */
int ttf_http_places_look(struct ttf_http_places *places, struct ttf_http_server *server,
                         struct ttf_err *err);

#endif
