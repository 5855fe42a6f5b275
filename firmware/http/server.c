/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/http/server.h"

#include <errno.h>
#include <microhttpd.h>
#include <sched.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "call.h"
#include "files_limit.h"
#include "listeners.h"

#define SOCKETS_MAX   8
#define PLACES        (2 * SOCKETS_MAX) /* of sockets; some may be on their way out */
#define NAMES_MAX     16
#define THREADS       2u
#define CONNECTIONS   512u /* of a socket */
#define SILENCE_S     30u
#define HEADERS_BYTES ((size_t)32 * 1024) /* what libmicrohttpd may hold for one connection */

struct socket {
    struct call_socket call;
    struct MHD_Daemon *daemon; /* NULL: the place is free */
    int fd;
};

struct ttf_http_server {
    struct calls calls;
    char *token;
    char *names[NAMES_MAX + 1];
    struct socket sockets[PLACES];
};

static void on_log(void *ctx, const char *fmt, va_list args)
{
    /* libmicrohttpd tells of every client that goes away; nothing of it is of use to a person. */
    (void)ctx;
    (void)fmt;
    (void)args;
}

static int copy_texts(struct ttf_http_server *server, const struct ttf_http_config *config)
{
    if (config->token && !(server->token = strdup(config->token)))
        return -ENOMEM;
    for (unsigned i = 0; config->names && config->names[i]; i++)
        if (!(server->names[i] = strdup(config->names[i])))
            return -ENOMEM;
    return 0;
}

static int make_lanes(struct calls *calls, struct ttf_err *err)
{
    static const unsigned N_THREADS[TTF_HTTP_LANES] = {
        [TTF_HTTP_STOPS] = 1, [TTF_HTTP_ORDERS] = 4, [TTF_HTTP_WORK] = 2, [TTF_HTTP_PICTURES] = 2};
    int r = 0;

    for (int i = TTF_HTTP_AT_ONCE + 1; i < TTF_HTTP_LANES && r == 0; i++)
        r = slow_create(N_THREADS[i], &calls->lanes[i], err);
    return r;
}

static int make_parts(struct ttf_http_server *server, const struct ttf_http_config *config,
                      struct ttf_err *err)
{
    struct calls *calls = &server->calls;
    int r = shelves_create(config->folder, &calls->shelves, err);

    if (r < 0)
        return r;
    calls->limits = limits_create(config->clock);
    if (copy_texts(server, config) < 0 || !calls->limits)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    calls->io = config->io;
    calls->clock = config->clock;
    calls->box = config->box;
    calls->events = config->events;
    calls->token = server->token;
    calls->names = (const char *const *)server->names;
    if (calls->events)
        events_open(calls->events);
    return make_lanes(calls, err);
}

int ttf_http_server_create(const struct ttf_http_config *config, struct ttf_http_server **ret,
                           struct ttf_err *err)
{
    struct ttf_http_server *server;
    unsigned n_names = 0;
    int r;

    if (config->token && strlen(config->token) < TTF_HTTP_TOKEN_MIN)
        return ttf_err_set(err, -EINVAL, "token", "has fewer than %d characters",
                           TTF_HTTP_TOKEN_MIN);
    while (config->names && config->names[n_names])
        if (++n_names > NAMES_MAX)
            return ttf_err_set(err, -EINVAL, "names", "there are more than %d", NAMES_MAX);
    server = calloc(1, sizeof *server);
    if (!server)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    r = make_parts(server, config, err);
    if (r < 0) {
        ttf_http_server_destroy(server);
        return r;
    }
    *ret = server;
    return 0;
}

/* ---- sockets ---- */

static bool is_leaving(const struct socket *socket)
{
    return __atomic_load_n(&socket->call.leaving, __ATOMIC_SEQ_CST) != 0;
}

static struct socket *free_place(struct ttf_http_server *server)
{
    struct socket *place = NULL;
    unsigned n = 0;

    for (unsigned i = 0; i < PLACES; i++) {
        if (!server->sockets[i].daemon)
            place = &server->sockets[i];
        else
            n += !is_leaving(&server->sockets[i]);
    }
    return n < SOCKETS_MAX ? place : NULL;
}

static bool make_socket(struct ttf_http_server *server, struct socket *socket, int fd,
                        bool free_to_read)
{
    unsigned n = files_limit_connections(CONNECTIONS, SOCKETS_MAX);

    *socket = (struct socket){.call = {.calls = &server->calls,
                                       .guests = guests_create(server->calls.clock, n),
                                       .free_to_read = free_to_read},
                              .fd = fd};
    if (!socket->call.guests)
        return false;
    socket->daemon = MHD_start_daemon(
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_ERROR_LOG | MHD_ALLOW_SUSPEND_RESUME, 0, call_admit,
        &socket->call, call_on, &socket->call, MHD_OPTION_EXTERNAL_LOGGER, on_log, server,
        MHD_OPTION_NOTIFY_COMPLETED, call_done, NULL, MHD_OPTION_NOTIFY_CONNECTION,
        call_comes_and_goes, &socket->call, MHD_OPTION_LISTEN_SOCKET, fd,
        MHD_OPTION_THREAD_POOL_SIZE, THREADS, MHD_OPTION_CONNECTION_LIMIT, n,
        MHD_OPTION_CONNECTION_TIMEOUT, SILENCE_S, MHD_OPTION_CONNECTION_MEMORY_LIMIT, HEADERS_BYTES,
        MHD_OPTION_STRICT_FOR_CLIENT, 1, MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1, MHD_OPTION_END);
    return socket->daemon != NULL;
}

int ttf_http_server_listen(struct ttf_http_server *server, int fd, bool free_to_read,
                           struct ttf_err *err)
{
    struct socket *socket = free_place(server);

    if (!socket) {
        (void)close(fd);
        return ttf_err_set(err, -ENOSPC, NULL, "more than %d sockets", SOCKETS_MAX);
    }
    if (!make_socket(server, socket, fd, free_to_read)) {
        (void)close(fd);
        guests_destroy(socket->call.guests);
        return ttf_err_set(err, -EIO, NULL, "the server cannot be started");
    }
    return 0;
}

static void begin_leaving(struct socket *socket)
{
    __atomic_store_n(&socket->call.leaving, 1, __ATOMIC_SEQ_CST);
}

/*
 * Nothing of it sleeps. MHD_quiesce_daemon is not for this: of 0.9.75 it races with its own threads for the listening
 * socket's place in epoll, and the loser calls abort(). Stopping closes the socket without that.
 */
static void stop(struct socket *socket)
{
    MHD_stop_daemon(socket->daemon);
    guests_destroy(socket->call.guests);
    socket->daemon = NULL;
}

void ttf_http_server_tidy(struct ttf_http_server *server)
{
    for (unsigned i = 0; i < PLACES; i++) {
        struct socket *socket = &server->sockets[i];

        if (!socket->daemon)
            continue;
        if (is_leaving(socket) && __atomic_load_n(&socket->call.asleep, __ATOMIC_SEQ_CST) == 0)
            stop(socket);
        else
            guests_tidy(socket->call.guests);
    }
}

void ttf_http_server_leave(struct ttf_http_server *server, int fd)
{
    for (unsigned i = 0; i < PLACES; i++)
        if (server->sockets[i].daemon && server->sockets[i].fd == fd)
            begin_leaving(&server->sockets[i]);
    if (server->calls.events)
        events_leave(server->calls.events);
    ttf_http_server_tidy(server);
}

/* No connection may sleep when its thread ends. */
static void stop_all(struct ttf_http_server *server)
{
    for (unsigned i = 0; i < PLACES; i++)
        begin_leaving(&server->sockets[i]);
    if (server->calls.events)
        events_close(server->calls.events);
    for (int i = 0; i < TTF_HTTP_LANES; i++)
        slow_stop(server->calls.lanes[i]);
    for (unsigned i = 0; i < PLACES; i++) {
        struct socket *socket = &server->sockets[i];

        if (!socket->daemon)
            continue;
        /* One that fell asleep just before is told by its own thread that nobody takes it any more. */
        while (__atomic_load_n(&socket->call.asleep, __ATOMIC_SEQ_CST) > 0)
            (void)sched_yield();
        stop(socket);
    }
}

void ttf_http_server_destroy(struct ttf_http_server *server)
{
    if (!server)
        return;
    stop_all(server);
    for (int i = 0; i < TTF_HTTP_LANES; i++)
        slow_destroy(server->calls.lanes[i]);
    shelves_destroy(server->calls.shelves);
    limits_destroy(server->calls.limits);
    for (unsigned i = 0; i < NAMES_MAX; i++)
        free(server->names[i]);
    free(server->token);
    free(server);
}
