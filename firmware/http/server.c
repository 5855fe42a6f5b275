/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/http/server.h"

#include <errno.h>
#include <microhttpd.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "access.h"
#include "answer.h"
#include "derived.h"
#include "folder.h"
#include "request.h"
#include "summaries.h"
#include "ttf/http/routes.h"

#define SOCKETS_MAX    4
#define NAMES_MAX      8
#define THREADS        2u
#define CONNECTIONS    512u /* of a socket */
#define OF_ONE_ADDRESS 128u
#define SILENCE_S      30u
#define HEADERS_BYTES  ((size_t)32 * 1024) /* what libmicrohttpd may hold for one connection */
#define BODY_MAX       0                   /* nothing that is read today has one */

struct socket {
    struct ttf_http_server *server;
    struct MHD_Daemon *daemon;
    bool free_to_read;
};

struct ttf_http_server {
    struct folder folder;
    struct ttf_io *io;
    struct summaries *summaries;
    struct derived *derived;
    char *token;
    char *names[NAMES_MAX + 1];
    struct socket sockets[SOCKETS_MAX];
    unsigned n_sockets;
};

/* ---- a request ---- */

static bool may(const struct socket *socket, const struct ttf_http_match *match,
                struct MHD_Connection *connection)
{
    const char *said;

    if (match->route->access == TTF_HTTP_OPEN ||
        (match->route->access == TTF_HTTP_READ && socket->free_to_read))
        return true;
    said = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Authorization");
    return access_token(said, socket->server->token);
}

/* 0: go on with the match, whose route is set; else queued, *ret being what libmicrohttpd is told. */
static int refuse(const struct socket *socket, struct MHD_Connection *connection,
                  const char *method, const char *url, struct ttf_http_match *match,
                  enum MHD_Result *ret)
{
    const struct ttf_http_server *server = socket->server;
    const char *host = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Host");
    struct ttf_err err = {0};
    unsigned status = 0;
    int r;

    if (!access_host(host, (const char *const *)server->names)) {
        status = MHD_HTTP_MISDIRECTED_REQUEST;
        r = ttf_err_set(&err, -EPERM, "Host", "this is not a name of this box");
        ttf_err_hint(&err, "ask by its address or by its own name");
    } else if ((r = ttf_http_route_find(method, url, match)) < 0) {
        ttf_err_set(&err, r, NULL,
                    r == -ENOENT ? "there is nothing of this name here"
                                 : "this cannot be done with it");
    } else if (!may(socket, match, connection)) {
        r = ttf_err_set(&err, -EACCES, NULL, "this needs the box's token");
        ttf_err_hint(&err, "send it as Authorization: Bearer TOKEN");
    }
    if (r < 0)
        *ret = answer_error(connection, status, &err);
    return r;
}

static enum MHD_Result answer(const struct socket *socket, struct MHD_Connection *connection,
                              const char *method, const char *url)
{
    struct ttf_http_server *server = socket->server;
    struct ttf_http_match match = {0};
    struct ttf_http_answer whole;
    struct ttf_http_request request = {.folder = &server->folder,
                                       .io = server->io,
                                       .summaries = server->summaries,
                                       .derived = server->derived,
                                       .match = &match};
    enum MHD_Result ret = MHD_NO;
    int r = refuse(socket, connection, method, url, &match, &ret);

    if (r < 0 || !match.route)
        return ret;
    answer_init(&whole);
    r = match.route->answer(&request, &whole);
    if (r < 0) {
        if (request.err.code == 0)
            ttf_err_set(&request.err, r, NULL, "%s", strerrordesc_np(-r));
        ret = answer_error(connection, 0, &request.err);
    } else {
        ret = answer_send(connection, strcmp(method, "GET") == 0, &whole);
    }
    answer_free(&whole);
    return ret;
}

/* Does a request bring a body? Nothing that can be asked for has one. */
static bool has_body(struct MHD_Connection *connection)
{
    const char *length = MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Content-Length");

    return MHD_lookup_connection_value(connection, MHD_HEADER_KIND, "Transfer-Encoding") ||
           (length && strcmp(length, "0") != 0);
}

/* Called once when the headers are there, and again when the whole request is. */
static enum MHD_Result
on_request(void *ctx, struct MHD_Connection *connection, const char *url, const char *method,
           const char *version, const char *data,
           /* NOLINTNEXTLINE(readability-non-const-parameter): libmicrohttpd's */
           size_t *data_bytes, void **of_request)
{
    static char seen; /* only its address is used */

    (void)version;
    (void)data;
    (void)data_bytes;
    if (*of_request)
        return answer(ctx, connection, method, url);
    *of_request = &seen;
    if (has_body(connection)) {
        struct ttf_err err = {0};

        /* An answer before the body is read ends the connection: none of it is taken in. */
        ttf_err_set(&err, -EFBIG, NULL, "no body is expected here");
        return answer_error(connection, 0, &err);
    }
    return MHD_YES;
}

static void on_log(void *ctx, const char *fmt, va_list args)
{
    /* libmicrohttpd tells of every client that goes away; nothing of it is of use to a person. */
    (void)ctx;
    (void)fmt;
    (void)args;
}

/* ---- its life ---- */

static int copy_texts(struct ttf_http_server *server, const struct ttf_http_config *config)
{
    if (config->token && !(server->token = strdup(config->token)))
        return -ENOMEM;
    for (unsigned i = 0; config->names && config->names[i] && i < NAMES_MAX; i++)
        if (!(server->names[i] = strdup(config->names[i])))
            return -ENOMEM;
    return 0;
}

int ttf_http_server_create(const struct ttf_http_config *config, struct ttf_http_server **ret,
                           struct ttf_err *err)
{
    struct ttf_http_server *server;
    int r;

    if (config->token && strlen(config->token) < TTF_HTTP_TOKEN_MIN)
        return ttf_err_set(err, -EINVAL, "token", "has fewer than %d characters",
                           TTF_HTTP_TOKEN_MIN);
    server = calloc(1, sizeof *server);
    if (!server)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    server->folder.fd = -1;
    server->io = config->io;
    r = folder_open(config->folder, &server->folder, err);
    server->summaries = summaries_create();
    server->derived = derived_create();
    if (r == 0 && (copy_texts(server, config) < 0 || !server->summaries || !server->derived))
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory");
    if (r < 0) {
        ttf_http_server_destroy(server);
        return r;
    }
    *ret = server;
    return 0;
}

int ttf_http_server_listen(struct ttf_http_server *server, int fd, bool free_to_read,
                           struct ttf_err *err)
{
    struct socket *socket = &server->sockets[server->n_sockets];

    if (server->n_sockets == SOCKETS_MAX) {
        (void)close(fd);
        return ttf_err_set(err, -ENOSPC, NULL, "more than %d sockets", SOCKETS_MAX);
    }
    socket->server = server;
    socket->free_to_read = free_to_read;
    socket->daemon = MHD_start_daemon(
        MHD_USE_EPOLL_INTERNAL_THREAD | MHD_USE_ERROR_LOG, 0, NULL, NULL, on_request, socket,
        MHD_OPTION_EXTERNAL_LOGGER, on_log, server, MHD_OPTION_LISTEN_SOCKET, fd,
        MHD_OPTION_THREAD_POOL_SIZE, THREADS, MHD_OPTION_CONNECTION_LIMIT, CONNECTIONS,
        MHD_OPTION_PER_IP_CONNECTION_LIMIT, OF_ONE_ADDRESS, MHD_OPTION_CONNECTION_TIMEOUT,
        SILENCE_S, MHD_OPTION_CONNECTION_MEMORY_LIMIT, HEADERS_BYTES, MHD_OPTION_STRICT_FOR_CLIENT,
        1, MHD_OPTION_SIGPIPE_HANDLED_BY_APP, 1, MHD_OPTION_END);
    if (!socket->daemon) {
        (void)close(fd);
        return ttf_err_set(err, -EIO, NULL, "the server cannot be started");
    }
    server->n_sockets++;
    return 0;
}

void ttf_http_server_destroy(struct ttf_http_server *server)
{
    if (!server)
        return;
    for (unsigned i = 0; i < server->n_sockets; i++)
        MHD_stop_daemon(server->sockets[i].daemon);
    folder_close(&server->folder);
    summaries_destroy(server->summaries);
    derived_destroy(server->derived);
    for (unsigned i = 0; i < NAMES_MAX; i++)
        free(server->names[i]);
    free(server->token);
    free(server);
}
