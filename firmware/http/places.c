/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/http/places.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

int ttf_http_places_add(struct ttf_http_places *s, const char *text)
{
    if (s->n == TTF_HTTP_PLACES_MAX)
        return -ENOSPC;
    s->places[s->n++] = (struct ttf_http_place){.text = text, .fd = -1};
    return 0;
}

static bool is_unix(const char *text)
{
    return strncmp(text, "unix:", 5) == 0;
}

static void leave(struct ttf_http_places *s, struct ttf_http_place *place,
                  struct ttf_http_server *server)
{
    if (place->fd < 0)
        return;
    ttf_http_server_leave(server, place->fd);
    place->fd = -1;
    s->tell(s->tell_ctx, TTF_HTTP_PLACE_LEFT, place, NULL);
}

static int open_place(struct ttf_http_places *s, struct ttf_http_place *place, const char *at,
                      struct ttf_http_server *server, struct ttf_err *err)
{
    struct ttf_http_socket socket;
    int r = ttf_http_listen(at, true, &socket, err);
    bool free_to_read = is_unix(at) || (r == 0 && s->free_loopback && socket.loopback);

    if (r == 0)
        r = ttf_http_server_listen(server, socket.fd, free_to_read, err);
    if (r < 0)
        return r;
    place->fd = socket.fd;
    place->free_to_read = free_to_read;
    memcpy(place->at, at, sizeof place->at);
    memcpy(place->name, socket.name, sizeof place->name);
    place->complained = false;
    s->tell(s->tell_ctx, TTF_HTTP_PLACE_LISTENING, place, NULL);
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
static bool is_of_a_device(const struct ttf_http_places *s, const char *text)
{
    const char *colon = strrchr(text, ':');
    char path[200];

    if (is_unix(text) || !colon)
        return false;
    (void)snprintf(path, sizeof path, "%s/class/net/%.*s/device/bInterfaceNumber", s->sys,
                   (int)(colon - text), text);
    return access(path, F_OK) == 0;
}

static int look(struct ttf_http_places *s, struct ttf_http_place *place,
                struct ttf_http_server *server, struct ttf_err *err)
{
    char at[TTF_HTTP_WHERE_SIZE];
    int r = ttf_http_listen_where(place->text, s->address_of, s->ctx, at, err);

    /* Nobody asked for that one. */
    if (r == 0 && s->as_ever && is_of_a_device(s, place->text))
        r = -ENODEV;
    if (r == 0 && place->fd >= 0 && strcmp(at, place->at) == 0)
        return 0;
    /* What nobody could be asked about stays as it is. */
    if (r == 0 || is_away(r))
        leave(s, place, server);
    if (is_away(r) && s->as_ever)
        return 0;
    if (r == 0)
        r = open_place(s, place, at, server, err);
    if (r == 0 || place->fd >= 0)
        return 0;
    if (!place->complained)
        s->tell(s->tell_ctx, TTF_HTTP_PLACE_UNREACHABLE, place, err);
    place->complained = true;
    return r;
}

int ttf_http_places_look(struct ttf_http_places *s, struct ttf_http_server *server,
                         struct ttf_err *err)
{
    int r = 0;

    ttf_http_server_tidy(server);
    for (unsigned i = 0; i < s->n; i++) {
        struct ttf_err why = {0};
        int one = look(s, &s->places[i], server, &why);

        if (one < 0 && r == 0) {
            r = one;
            if (err)
                *err = why;
        }
    }
    return r;
}
