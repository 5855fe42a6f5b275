/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sockets.h: where the interface listens: each place of the configuration is opened, tried again while it cannot be had, and, where
 * it is a network interface's, followed to the address that the interface has now. One thread.
 */
#ifndef DAEMON_SOCKETS_H
#define DAEMON_SOCKETS_H

#include <stdbool.h>

#include "ttf/config/daemon_file.h"
#include "ttf/http/listen.h"
#include "ttf/http/server.h"

struct socket_place {
    const char *text;             /* of the configuration */
    char at[TTF_HTTP_WHERE_SIZE]; /* what it stood for when it was opened */
    char name[128];               /* as it was bound */
    int fd;                       /* the server's; -1: not open */
    bool complained;              /* that it cannot be had: once, until it can */
};

struct sockets {
    ttf_http_address_fn *address_of;
    void *ctx;
    const char *sys;
    bool as_ever; /* nobody asked for an interface that is not there, or that is no cable's */
    unsigned n;
    struct socket_place places[TTF_DAEMON_LISTEN_MAX];
};

/* config, sys: borrowed. address_of: ttf_http_address_of, but for tests; sys: "/sys", or a folder laid out like it. */
void sockets_init(struct sockets *sockets, const struct ttf_daemon_config *config,
                  ttf_http_address_fn *address_of, void *ctx, const char *sys);

/* Opens what is not open, leaves what an interface has no more. Each change has its line in the log. */
void sockets_look(struct sockets *sockets, struct ttf_http_server *server);

#endif
