/* SPDX-License-Identifier: Apache-2.0 */
/* libusb.h: a PC's end of a box's cable, by libusb. */
#ifndef TTF_USB_LIBUSB_H
#define TTF_USB_LIBUSB_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/usb/link.h"

#define TTF_USB_SERIAL_SIZE 64 /* bytes with the terminator */

struct ttf_usb_box {
    char serial[TTF_USB_SERIAL_SIZE]; /* empty: it cannot be read */
    unsigned bus, address;
    int error; /* 0; -EACCES: this user may not use it; -EBUSY and others */
};

/* The boxes that are plugged in: at most max into ret, how many there are; a negative errno of libusb. */
TTF_MUST_USE int ttf_usb_libusb_list(struct ttf_usb_box *ret, unsigned max, struct ttf_err *err);

/* A link to the box of that serial; NULL: to the only one (-ENOTUNIQ by open() if there are several). -ENOMEM, -EIO. */
TTF_MUST_USE int ttf_usb_libusb_create(const char *serial, struct ttf_usb_link **ret,
                                       struct ttf_err *err);

#endif
