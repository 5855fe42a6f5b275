/* SPDX-License-Identifier: Apache-2.0 */
/*
 * announce.h: on each network that the page is offered on by its interface (`usb0:8417`), the box answers to its name,
 * ttfbox-SERIAL.local (multicast DNS, mdns.h), with the address that it has there. Nothing waits for it, and without it all is at its address.
 * The name has the serial in it, so nobody else is asked whether it is taken. Only who is in the interface's network is answered, and one alone
 * not often. One thread.
 */
#ifndef DAEMON_ANNOUNCE_H
#define DAEMON_ANNOUNCE_H

#include "mdns.h"
#include "ttf/config/daemon_file.h"
#include "ttf/http/places.h"

struct announce_place {
    char interface[16];
    char at[TTF_HTTP_WHERE_SIZE]; /* the page's place, when this was opened */
    unsigned number;              /* of the interface: another one may have come in its place */
    int fd;                       /* -1: not open */
    struct mdns_host host;
    uint32_t mask;    /* of its network, as it is on the wire; only who is in it is answered */
    int64_t told_ns;  /* to all, last */
    int64_t else_ns;  /* the same of what has no address in it */
    int64_t alone_ns; /* since then ... */
    unsigned alone;   /* ... so many answers to one alone */
    unsigned left;    /* times that it is to be told unasked */
    bool complained;  /* that it cannot be had: once */
};

struct announce {
    char name[64]; /* empty: the serial makes no name */
    unsigned n;
    struct announce_place places[TTF_DAEMON_LISTEN_MAX];
};

void announce_init(struct announce *announce, const char *serial);

/* Sockets of interfaces that the page is at now, and of no others. */
void announce_follow(struct announce *announce, const struct ttf_http_places *sockets,
                     int64_t now_ns);

/* Answers what was asked. Never blocks. */
void announce_hear(struct announce *announce, int64_t now_ns);

/* Takes the name back from whoever knows it. */
void announce_end(struct announce *announce);

#endif
