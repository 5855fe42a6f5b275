/* SPDX-License-Identifier: Apache-2.0 */
/*
 * link.h: one bulk endpoint in each direction, as either end sees it, behind a table of operations: FunctionFS on a box, libusb
 * on a PC, a simulated cable for both. Nothing here blocks: fds() says what to wait for, next() does what can be done and
 * says what came of it. One thread.
 */
#ifndef TTF_USB_LINK_H
#define TTF_USB_LINK_H

#include <poll.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

#define TTF_USB_TRANSFER 65536u /* bytes of a buffer that one transfer is read into */
#define TTF_USB_DEPTH    8u     /* transfers queued in each direction */
#define TTF_USB_FDS      16u    /* descriptors of a link, at most */

enum ttf_usb_event_kind {
    TTF_USB_NOTHING = 0,
    TTF_USB_UP, /* transfers can go both ways; whatever went before is over. May come while it is up */
    TTF_USB_DOWN,    /* they cannot any more. Of a box it may get lost before the next UP */
    TTF_USB_SUSPEND, /* of a box: the bus sleeps, or the cable was pulled */
    TTF_USB_RESUME,
    TTF_USB_RESET, /* of a box: the host asks for one, with this nonce. Of a host: the box has it, or error */
    TTF_USB_CAME /* a transfer */
};

struct ttf_usb_event {
    enum ttf_usb_event_kind kind;
    uint64_t nonce;      /* of RESET at a box */
    int error;           /* of RESET at a host; of DOWN: why */
    const uint8_t *data; /* of CAME: valid until the next call of next() */
    size_t n;
};

struct ttf_usb_link;

struct ttf_usb_link_ops {
    const char *name;

    /*
     * Of a host: finds the box and takes it; it is up then. -ENODEV: there is none; -EBUSY: another program has it; -EACCES.
     * Of a box: 0; what happens comes by itself. It may be called again after DOWN.
     */
    int (*open)(struct ttf_usb_link *link, struct ttf_err *err);

    /* What to wait for, into ret of TTF_USB_FDS; how many. */
    unsigned (*fds)(struct ttf_usb_link *link, struct pollfd *ret);

    /* What happened next: always fills *ret, NOTHING if nothing did. */
    void (*next)(struct ttf_usb_link *link, struct ttf_usb_event *ret);

    /* Room for a transfer, of TTF_USB_TRANSFER bytes; NULL: as many are queued as may be, or it is not up. */
    uint8_t *(*buffer)(struct ttf_usb_link *link);

    /* The buffer got n bytes, which are to be sent. */
    void (*send)(struct ttf_usb_link *link, size_t n);

    /* What is queued to be sent and not sent yet will not be, as far as that is possible. */
    void (*drop)(struct ttf_usb_link *link);

    /* Of a host: asks the box for a reset; RESET follows, within 2 s. 0; -ENODEV; -EALREADY: one is under way. */
    int (*reset)(struct ttf_usb_link *link, uint64_t nonce);

    /* Lets go of the device. */
    void (*close)(struct ttf_usb_link *link);

    void (*destroy)(struct ttf_usb_link *link);
};

/* A back-end's own struct begins with it. */
struct ttf_usb_link {
    const struct ttf_usb_link_ops *ops;
};

/* NULL allowed. */
static inline void ttf_usb_link_destroy(struct ttf_usb_link *link)
{
    if (link)
        link->ops->destroy(link);
}

/*
 * A simulated cable, for tests: the program that is listening at path (PIPE.md). box: which end. fd >= 0: a connection of the
 * box's end that another process made (ttf_usb_pipe_connect); the link's from now on. -ENOMEM.
 */
TTF_MUST_USE int ttf_usb_pipe_create(const char *path, bool box, int fd, struct ttf_usb_link **ret,
                                     struct ttf_err *err);

/* Plugs the box's end in; the connection, which stays plugged in as long as somebody has it open. */
TTF_MUST_USE int ttf_usb_pipe_connect(const char *path, struct ttf_err *err);

#endif
