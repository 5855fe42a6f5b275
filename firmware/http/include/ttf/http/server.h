/* SPDX-License-Identifier: Apache-2.0 */
/*
 * server.h: the HTTP interface over a folder of datasets (README.md). It answers from threads of its own; it never writes
 * into the folder.
 */
#ifndef TTF_HTTP_SERVER_H
#define TTF_HTTP_SERVER_H

#include <stdbool.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/clock.h"
#include "ttf/http/box.h"
#include "ttf/http/events.h"

#define TTF_HTTP_TOKEN_MIN 16 /* characters */

struct ttf_http_config {
    const char *folder; /* whose folders are datasets */
    struct ttf_io *io;
    const char *token; /* NULL: there is none, and what needs one is refused */
    const char *const *
        names; /* under which the box is known, NULL-ended; addresses and "localhost" always are. NULL allowed */
    struct ttf_clock
        *clock; /* how often a wrong token may be tried, when a request is to be whole; borrowed */
    struct ttf_http_box *box;       /* borrowed; NULL: there is none */
    struct ttf_http_events *events; /* borrowed; NULL: there are none. Of one server at a time */
};

struct ttf_http_server;

/* Copies the configuration's texts. -ENOENT, -ENOTDIR: folder; -EINVAL: a token that is too short; -ENOMEM. */
TTF_MUST_USE int ttf_http_server_create(const struct ttf_http_config *config,
                                        struct ttf_http_server **ret, struct ttf_err *err);

/*
 * Raises the process's limit of open files where it is too low for all connections; where that cannot be, there are fewer.
 * Answers on a listening socket, which is the server's from now on, also on failure. free_to_read: whoever reaches it may
 * read; else the token is asked for. At most 8 sockets: -ENOSPC.
 */
TTF_MUST_USE int ttf_http_server_listen(struct ttf_http_server *server, int fd, bool free_to_read,
                                        struct ttf_err *err);

/*
 * The listening socket of this number is to be listened on no more: nothing new is taken, event streams end, a request that waits
 * for its turn (a picture, a chart) is answered, and then its connections end and it is closed: here, if nothing waits, or when tidied up
 * later. A file, an archive or a live picture that is being sent is cut off where it is. Other sockets notice nothing. As listening: one thread.
 */
void ttf_http_server_leave(struct ttf_http_server *server, int fd);

/* To be called each second or so: ends what is being left, and connections whose request is not whole in time. As listening: one thread. */
void ttf_http_server_tidy(struct ttf_http_server *server);

/* Ends all connections and threads, closes the sockets. NULL allowed. */
void ttf_http_server_destroy(struct ttf_http_server *server);

#endif
