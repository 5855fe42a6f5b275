/* SPDX-License-Identifier: Apache-2.0 */
#include "sockets.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "log.h"

void sockets_init(struct sockets *s, const struct ttf_daemon_config *config,
                  ttf_http_address_fn *address_of, void *ctx, const char *sys)
{
    *s = (struct sockets){.address_of = address_of,
                          .ctx = ctx,
                          .sys = sys,
                          .as_ever = config->listen_as_ever,
                          .n = config->n_listen};
    for (unsigned i = 0; i < s->n; i++)
        s->places[i] = (struct socket_place){.text = config->listen[i], .fd = -1};
}

static bool is_unix(const char *text)
{
    return strncmp(text, "unix:", 5) == 0;
}

static void leave(struct socket_place *place, struct ttf_http_server *server)
{
    if (place->fd < 0)
        return;
    log_line(LOG_LEVEL_NOTICE, "left", "at=\"%s\"", place->name);
    ttf_http_server_leave(server, place->fd);
    place->fd = -1;
}

static int open_place(struct socket_place *place, const char *at, struct ttf_http_server *server,
                      struct ttf_err *err)
{
    struct ttf_http_socket socket;
    int r = ttf_http_listen(at, true, &socket, err);

    if (r == 0) /* the cable alone needs no token */
        r = ttf_http_server_listen(server, socket.fd, is_unix(at), err);
    if (r < 0)
        return r;
    /* The folder that it lies in says who reaches it: /run/ttfbox is the group's. */
    if (is_unix(at))
        (void)chmod(at + 5, 0660);
    place->fd = socket.fd;
    memcpy(place->at, at, sizeof place->at);
    memcpy(place->name, socket.name, sizeof place->name);
    place->complained = false;
    if (strcmp(place->text, at) == 0)
        log_line(LOG_LEVEL_NOTICE, "listening", "at=\"%s\"", socket.name);
    else
        log_line(LOG_LEVEL_NOTICE, "listening", "at=\"%s\" for=\"%s\"", socket.name, place->text);
    return 0;
}

/* There is no such interface, or it has no address yet. */
static bool is_away(int r)
{
    return r == -ENODEV || r == -EADDRNOTAVAIL;
}

/*
 * Is this the network of a USB device that is plugged in here (a tethered phone, a modem), not the cable to a PC? The kernel calls both usb0;
 * the first alone hangs on an interface of a device on the bus (Documentation/ABI/testing/sysfs-bus-usb: bInterfaceNumber).
 */
static bool is_of_a_device(const struct sockets *s, const char *text)
{
    const char *colon = strrchr(text, ':');
    char path[200];

    if (is_unix(text) || !colon)
        return false;
    (void)snprintf(path, sizeof path, "%s/class/net/%.*s/device/bInterfaceNumber", s->sys,
                   (int)(colon - text), text);
    return access(path, F_OK) == 0;
}

static void look(struct sockets *s, struct socket_place *place, struct ttf_http_server *server)
{
    char at[TTF_HTTP_WHERE_SIZE], text[900], quoted[1000];
    struct ttf_err err = {0};
    int r = ttf_http_listen_where(place->text, s->address_of, s->ctx, at, &err);

    /* Nobody asked for that one. */
    if (r == 0 && s->as_ever && is_of_a_device(s, place->text))
        r = -ENODEV;
    if (r == 0 && place->fd >= 0 && strcmp(at, place->at) == 0)
        return;
    /* What nobody could be asked about stays as it is. */
    if (r == 0 || is_away(r))
        leave(place, server);
    if (is_away(r) && s->as_ever)
        return;
    if (r == 0)
        r = open_place(place, at, server, &err);
    if (r < 0 && place->fd < 0 && !place->complained) {
        log_line(LOG_LEVEL_WARNING, "unreachable", "at=\"%s\" why=%s", place->text,
                 log_text(ttf_err_text(&err, text, sizeof text), quoted, sizeof quoted));
        place->complained = true;
    }
}

void sockets_look(struct sockets *s, struct ttf_http_server *server)
{
    ttf_http_server_tidy(server);
    for (unsigned i = 0; i < s->n; i++)
        look(s, &s->places[i], server);
}
