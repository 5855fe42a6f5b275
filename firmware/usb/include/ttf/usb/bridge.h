/* SPDX-License-Identifier: Apache-2.0 */
/*
 * bridge.h: joins the streams of a link to sockets: on a PC to connections that somebody makes to a listening socket, on a
 * box to connections that it makes to the server's UNIX socket. It reads nothing of what they carry.
 */
#ifndef TTF_USB_BRIDGE_H
#define TTF_USB_BRIDGE_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/clock.h"
#include "ttf/usb/link.h"
#include "ttf/usb/mux.h"

enum ttf_usb_bridge_state {
    TTF_USB_BRIDGE_AWAY = 0, /* no box, or no host */
    TTF_USB_BRIDGE_RESETTING,
    TTF_USB_BRIDGE_READY
};

struct ttf_usb_bridge_config {
    enum ttf_mux_role role;
    struct ttf_usb_link *link; /* borrowed */
    struct ttf_clock *clock;   /* borrowed; a real one */
    int listen_fd;             /* of a host: not blocking; borrowed */
    const char *server;        /* of a box: the path of the server's UNIX socket; borrowed */
    /* Says how it stands, when that changes, and about once a second otherwise. error: why it is away. NULL allowed. */
    void (*tell)(void *ctx, enum ttf_usb_bridge_state state, int error);
    void *tell_ctx;
    const volatile int *stop; /* becomes non-zero: end within 0.3 s */
};

/*
 * Until it is told to stop: 0. Whatever happens to the link, it goes on with it when it is back; connections of that time are
 * closed. -EPROTONOSUPPORT: the box speaks another version; -ENOMEM; errors of poll.
 */
TTF_MUST_USE int ttf_usb_bridge_run(const struct ttf_usb_bridge_config *config,
                                    struct ttf_err *err);

#endif
