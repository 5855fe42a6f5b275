/* SPDX-License-Identifier: Apache-2.0 */
/* cmd_usb.c: `ttfbox usb` and `usb list`: boxes at this machine's USB. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "commands.h"
#include "ttf/hal/clock.h"
#include "ttf/http/listen.h"
#include "ttf/usb/bridge.h"
#include "ttf/usb/libusb.h"
#include "usb_box.h"

#define BOXES_MAX 32

int cmd_usb_list(struct cli *cli)
{
    struct ttf_usb_box boxes[BOXES_MAX];
    int n = ttf_usb_libusb_list(boxes, BOXES_MAX, &cli->err);

    if (n < 0)
        return n;
    ttf_json_key(&cli->out, "boxes");
    ttf_json_array(&cli->out);
    for (int i = 0; i < n && i < BOXES_MAX; i++) {
        const struct ttf_usb_box *box = &boxes[i];

        ttf_json_object(&cli->out);
        ttf_json_kstring(&cli->out, "serial", box->serial);
        ttf_json_kint(&cli->out, "bus", box->bus);
        ttf_json_kint(&cli->out, "address", box->address);
        ttf_json_kbool(&cli->out, "usable", box->error == 0);
        ttf_json_object_end(&cli->out);
        cli_say(cli, "%-16s bus %u, device %u%s%s", box->error ? "?" : box->serial, box->bus,
                box->address, box->error ? ": " : "",
                box->error == -EACCES ? "you may not use it (udev's rule 70-ttfbox-usb.rules lets "
                                        "whoever sits at this machine)"
                : box->error          ? strerrordesc_np(-box->error)
                                      : "");
    }
    ttf_json_array_end(&cli->out);
    if (n == 0)
        cli_say(cli, "no box is plugged in");
    return 0;
}

static void on_state(void *ctx, enum ttf_usb_bridge_state state, int error)
{
    static const char *const TEXTS[] = {"the box is away", NULL, "the box is there"};
    static enum ttf_usb_bridge_state last = TTF_USB_BRIDGE_RESETTING;
    const struct cli *cli = ctx;

    if (state == last || !TEXTS[state])
        return;
    last = state;
    if (!cli->opt.quiet)
        cli_warn("ttfbox: %s%s%s", TEXTS[state], error && error != -ENODEV ? ": " : "",
                 error && error != -ENODEV ? strerrordesc_np(-error) : "");
}

/* Reading over the cable asks for no token; so nobody else is to come in here. */
static int check_listen(struct cli *cli, const struct ttf_http_socket *socket)
{
    if (socket->loopback)
        return 0;
    ttf_err_set(&cli->err, -EINVAL, socket->name, "others would reach the box there");
    ttf_err_hint(&cli->err, "write 127.0.0.1:PORT, [::1]:PORT or unix:PATH");
    return -EINVAL;
}

/* Where nobody but this user comes in: the folder of the session. */
static int default_listen(struct cli *cli, char *ret, size_t size)
{
    const char *session = getenv("XDG_RUNTIME_DIR"); /* NOLINT(concurrency-mt-unsafe) */

    if (session && *session && snprintf(ret, size, "unix:%s/ttfbox-usb", session) < (int)size)
        return 0;
    ttf_err_set(&cli->err, -EINVAL, "--listen", "is needed: this session has no XDG_RUNTIME_DIR");
    ttf_err_hint(&cli->err, "write unix:PATH, or 127.0.0.1:PORT for all users of this machine");
    return -EINVAL;
}

static void warn_of_others(const struct cli *cli, const char *listen)
{
    if (strncmp(listen, "unix:", 5) != 0 && !cli->opt.quiet)
        cli_warn("ttfbox: every user of this machine can read the box's datasets there");
}

int cmd_usb(struct cli *cli)
{
    struct ttf_usb_bridge_config config = {
        .role = TTF_MUX_HOST, .tell = on_state, .tell_ctx = cli, .stop = cli_stop_flag()};
    char own[120];
    const char *listen = cli->opt.listen ? cli->opt.listen : own;
    struct ttf_http_socket socket = {.fd = -1};
    int r = cli->opt.listen ? 0 : default_listen(cli, own, sizeof own);

    if (r == 0)
        r = usb_box_link(cli->opt.box ? cli->opt.box : "usb", &config.link, &cli->err);
    if (r == 0)
        r = ttf_http_listen(listen, false, &socket, &cli->err);
    if (r == 0)
        r = check_listen(cli, &socket);
    if (r == 0) {
        config.clock = ttf_clock_real_create();
        if (!config.clock)
            r = ttf_err_set(&cli->err, -errno, "clock", "the machine's clock cannot be had");
    }
    if (r == 0) {
        cli_stop_catch();
        config.listen_fd = socket.fd;
        warn_of_others(cli, listen);
        cli_say_listening(cli, socket.name, NULL);
        cli_say(cli, "the box's interface is at %s; Ctrl-C ends it", socket.name);
        (void)fflush(stdout);
        r = ttf_usb_bridge_run(&config, &cli->err);
    }
    ttf_usb_link_destroy(config.link);
    ttf_clock_destroy(config.clock);
    if (socket.fd >= 0)
        (void)close(socket.fd);
    if (socket.fd >= 0 && strncmp(listen, "unix:", 5) == 0)
        (void)unlink(listen + 5);
    return r;
}
