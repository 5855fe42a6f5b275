/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_serve.c: `ttfbox serve`: the HTTP interface over a folder of datasets. */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "ttf/hal/clock.h"
#include "ttf/http/listen.h"
#include "ttf/http/server.h"
#include "ttf/http/token.h"

#define DEFAULT_LISTEN "127.0.0.1:8417"
#define LOOK_NS        (100 * TTF_NS_PER_MS) /* how soon Ctrl-C is seen */

/* Until Ctrl-C. */
static void stay(struct ttf_clock *clock, struct ttf_http_server *server)
{
    while (*cli_stop_flag() == 0) {
        ttf_http_server_tidy(server);
        (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + LOOK_NS);
    }
}

static void tell(struct cli *cli, const struct ttf_http_socket *socket, const char *token)
{
    cli_say_listening(cli, socket->name, &socket->loopback);
    cli_say(cli, "serving %s at %s%s", cli->opt.args[0],
            strncmp(socket->name, "unix:", 5) == 0 ? "" : "http://", socket->name);
    if (!socket->loopback)
        cli_say(cli, "readers need the token: %s",
                cli->opt.token_file ? cli->opt.token_file : token);
    cli_say(cli, "Ctrl-C ends it");
    (void)fflush(stdout); /* whoever started it waits for the port */
}

int cmd_serve(struct cli *cli)
{
    struct ttf_http_config config = {.folder = cli->opt.args[0], .io = cli->io};
    char token[TTF_HTTP_TOKEN_SIZE] = "", host[256] = "", local[264];
    const char *names[] = {host, local,
                           NULL}; /* as the system calls it, and as multicast DNS does */
    struct ttf_http_server *server = NULL;
    struct ttf_http_socket socket;
    int r;

    r = cli->opt.token_file ? ttf_http_token_load(cli->opt.token_file, token, &cli->err)
                            : ttf_http_token_make(token, &cli->err);
    if (r < 0)
        return r;
    config.token = token;
    config.clock = ttf_clock_real_create();
    if (!config.clock)
        return ttf_err_set(&cli->err, -errno, "clock", "the machine's clock cannot be had");
    if (gethostname(host, sizeof host - 1) == 0)
        config.names = names;
    (void)snprintf(local, sizeof local, "%s.local", host);
    r = ttf_http_server_create(&config, &server, &cli->err);
    if (r == 0)
        r = ttf_http_listen(cli->opt.listen ? cli->opt.listen : DEFAULT_LISTEN, true, &socket,
                            &cli->err);
    if (r == 0) {
        cli_stop_catch();
        r = ttf_http_server_listen(server, socket.fd, socket.loopback, &cli->err);
    }
    if (r == 0) {
        tell(cli, &socket, token);
        stay(config.clock, server);
    }
    ttf_http_server_destroy(server);
    ttf_clock_destroy(config.clock);
    return r;
}
