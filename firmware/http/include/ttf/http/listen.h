/* SPDX-License-Identifier: Apache-2.0 */
/* listen.h: a listening socket from a text. */
#ifndef TTF_HTTP_LISTEN_H
#define TTF_HTTP_LISTEN_H

#include <stdbool.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

#define TTF_HTTP_ADDRESS_SIZE 16  /* of an IPv4 address in numbers, with its end */
#define TTF_HTTP_WHERE_SIZE   128 /* of a text that says where, with its end */

struct ttf_http_socket {
    int fd;        /* listening, not blocking, closed on exec. The caller's */
    bool loopback; /* only this machine reaches it */
    char name
        [128]; /* where it listens, as a person would type it: "127.0.0.1:8080", "unix:/run/x" */
};

/*
 * "ADDRESS:PORT" with a numeric address ("127.0.0.1:8080", "[::1]:8080", port 0: any free one), "INTERFACE:PORT" (the IPv4 address
 * that the interface has at this moment: "usb0:8417" is a box's cable; -ENODEV, -EADDRNOTAVAIL while there is none; whoever follows
 * it asks ttf_http_listen_where again and again), or "unix:PATH"
 * (mode 0600; of a group, in a folder with setgid, 0660; a socket that nobody listens on any more is replaced). -EINVAL: no such text. -EADDRINUSE and the errors of
 * socket, bind, listen.
 */
TTF_MUST_USE int ttf_http_listen(const char *text, bool group, struct ttf_http_socket *ret,
                                 struct ttf_err *err);

/* The IPv4 address that an interface has. -ENODEV: there is no such interface; -EADDRNOTAVAIL: it has none. */
typedef int ttf_http_address_fn(void *ctx, const char *interface, char ret[TTF_HTTP_ADDRESS_SIZE]);

/* As the kernel has it at this moment; ctx is not used. Also errors of socket. */
int ttf_http_address_of(void *ctx, const char *interface, char ret[TTF_HTTP_ADDRESS_SIZE]);

/* "INTERFACE:PORT" as "ADDRESS:PORT", with the address that it has now; of any other text the text. -EINVAL, errors of address_of. */
TTF_MUST_USE int ttf_http_listen_where(const char *text, ttf_http_address_fn *address_of, void *ctx,
                                       char ret[TTF_HTTP_WHERE_SIZE], struct ttf_err *err);

#endif
