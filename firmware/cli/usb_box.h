/* SPDX-License-Identifier: Apache-2.0 */
/* usb_box.h: which box at USB is meant, and its interface at a socket of one's own. */
#ifndef CLI_USB_BOX_H
#define CLI_USB_BOX_H

#include <stdbool.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/clock.h"
#include "ttf/usb/link.h"

/* "usb", "usb:SERIAL"; "cable:PATH", a simulated one (firmware/usb/PIPE.md). */
bool usb_box_is(const char *box);

/* Its link, not open yet. */
TTF_MUST_USE int usb_box_link(const char *box, struct ttf_usb_link **ret, struct ttf_err *err);

/*
 * The box, which has to be there (or wait: may come later), at a UNIX socket that only this user reaches; a thread of its own keeps it up, also when the
 * box is unplugged and comes back. -ENODEV, -ENOTUNIQ, -EACCES, -EBUSY: see ttf/usb/link.h.
 */
struct usb_bridge;
TTF_MUST_USE int usb_bridge_begin(const char *box, bool wait, struct ttf_clock *clock,
                                  struct usb_bridge **ret, struct ttf_err *err);
const char *
usb_bridge_where(const struct usb_bridge *bridge); /* "unix:PATH", as long as it lives */

/* 0, or why it will never serve again (-EPROTONOSUPPORT: the box speaks another version): of ttf_pull_config.ended. Any thread. */
TTF_MUST_USE int usb_bridge_ended(void *bridge, struct ttf_err *err);

void usb_bridge_end(struct usb_bridge *bridge); /* NULL allowed */

#endif
