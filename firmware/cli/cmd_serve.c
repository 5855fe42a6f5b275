/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_serve.c: `ttfbox serve`: the HTTP interface over a folder of datasets. */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "ttf/hal/clock.h"
#include "ttf/http/places.h"
#include "ttf/http/server.h"
#include "ttf/http/token.h"

#define DEFAULT_LISTEN "127.0.0.1:8417"
#define LOOK_NS        (100 * TTF_NS_PER_MS) /* how soon Ctrl-C is seen */
#define FOLLOW_NS      TTF_NS_PER_S          /* and that an interface has another address */

/* What is said of the place, and to whom. */
struct teller {
    struct cli *cli;
    const char *token;
    bool begun; /* it has listened once: what is wrong before ends the program, which says why */
};

static void tell_listening(const struct teller *teller, const struct ttf_http_place *place)
{
    struct cli *cli = teller->cli;

    cli_say_listening(cli, place->name, &place->free_to_read);
    cli_say(cli, "serving %s at %s%s", cli->opt.args[0],
            strncmp(place->name, "unix:", 5) == 0 ? "" : "http://", place->name);
    if (!place->free_to_read)
        cli_say(cli, "readers need the token: %s",
                cli->opt.token_file ? cli->opt.token_file : teller->token);
    if (!teller->begun)
        cli_say(cli, "Ctrl-C ends it");
    (void)fflush(stdout); /* whoever started it waits for the port */
}

static void tell(void *ctx, enum ttf_http_place_news news, const struct ttf_http_place *place,
                 const struct ttf_err *err)
{
    struct teller *teller = ctx;
    char text[900];

    switch (news) {
    case TTF_HTTP_PLACE_LISTENING:
        tell_listening(teller, place);
        teller->begun = true;
        break;
    case TTF_HTTP_PLACE_LEFT:
        cli_warn("%s is the address of %s no more", place->name, place->text);
        break;
    case TTF_HTTP_PLACE_UNREACHABLE:
        if (teller->begun)
            cli_warn("waiting: %s", ttf_err_text(err, text, sizeof text));
        break;
    }
}

/* Until Ctrl-C. */
static void stay(struct ttf_clock *clock, struct ttf_http_places *places,
                 struct ttf_http_server *server)
{
    int64_t look_ns = ttf_clock_now_ns(clock) + FOLLOW_NS;

    while (*cli_stop_flag() == 0) {
        if (ttf_clock_now_ns(clock) >= look_ns) {
            (void)ttf_http_places_look(places, server, NULL);
            look_ns = ttf_clock_now_ns(clock) + FOLLOW_NS;
        }
        (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + LOOK_NS);
    }
}

int cmd_serve(struct cli *cli)
{
    struct ttf_http_config config = {.folder = cli->opt.args[0], .io = cli->io};
    char token[TTF_HTTP_TOKEN_SIZE] = "", host[256] = "", local[264];
    const char *names[] = {host, local,
                           NULL}; /* as the system calls it, and as multicast DNS does */
    struct ttf_http_server *server = NULL;
    struct teller teller = {.cli = cli, .token = token};
    struct ttf_http_places places = {.address_of = ttf_http_address_of,
                                     .sys = "/sys",
                                     .free_loopback = true,
                                     .tell = tell,
                                     .tell_ctx = &teller};
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
        r = ttf_http_places_add(&places, cli->opt.listen ? cli->opt.listen : DEFAULT_LISTEN);
    if (r == 0) {
        cli_stop_catch();
        r = ttf_http_places_look(&places, server, &cli->err);
    }
    if (r == 0)
        stay(config.clock, &places, server);
    ttf_http_server_destroy(server);
    ttf_clock_destroy(config.clock);
    return r;
}
