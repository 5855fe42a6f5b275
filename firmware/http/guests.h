/* SPDX-License-Identifier: Apache-2.0 */
/*
 * guests.h: the connections of a socket, and which of them has to go when there are too many, so that whoever comes next is
 * served, however many hold on. A connection that has to go is shut down; whoever owns it notices, and closes it. Private to
 * this room. Any thread.
 *
 * First go those that have asked for nothing whole, then those that are being answered: of the client that has most of these
 * the one that has been at it for longest. One that sleeps is left alone: it would not notice.
 */
#ifndef HTTP_GUESTS_H
#define HTTP_GUESTS_H

#include <stdbool.h>
#include <sys/socket.h>

#include "ttf/base/attr.h"
#include "ttf/hal/clock.h"

#define GUESTS_OF_CLIENT 128u /* at most, and no more than half of all; of a UNIX socket all */

/* For a request line and its headers, from the connection's beginning or its last answer, which is 30 s of silence at most and then
 * the request itself, however it dribbles in. For a body: one of 256 KiB over the slowest of networks takes some seconds. */
#define GUEST_HEADERS_NS (40 * TTF_NS_PER_S)
#define GUEST_BODY_NS    (60 * TTF_NS_PER_S)

struct guests;
struct guest;

/* places: connections that can be there; those that stay are an eighth fewer, as one that is shut down is there until that is noticed.
 * NULL: no memory. clock: borrowed. */
struct guests *guests_create(struct ttf_clock *clock, unsigned places);
void guests_destroy(struct guests *guests); /* NULL allowed; nobody is there any more */

/* One has come, of that address (NULL allowed); its file descriptor is open until it leaves. NULL: it was shut down at once. */
struct guest *guests_enter(struct guests *guests, const struct sockaddr *address, int fd);

/* What it does now. NULL allowed. */
void guest_reads_body(struct guest *guest);
void guest_is_answered(struct guest *guest);
void guest_sleeps(struct guest *guest); /* is not to be shut down, until it is answered again */
void guest_waits(struct guest *guest);  /* for its next request */
void guest_leaves(struct guest *guest);

/* Shuts down those whose request is not whole in time. */
void guests_tidy(struct guests *guests);

#endif
