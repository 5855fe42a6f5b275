/* SPDX-License-Identifier: Apache-2.0 */
/* find.h: boxes among the devices of a bus. */
#ifndef USB_LIBUSB_FIND_H
#define USB_LIBUSB_FIND_H

#include <libusb.h>

#include "ttf/usb/libusb.h"

/* libusb's error as a negative errno. */
int usb_errno(int error);

/* Opens the box of that serial, or the only one. -ENODEV, -ENOTUNIQ (the error names all that it may be), -EACCES. */
int usb_find_open(libusb_context *context, const char *serial, libusb_device_handle **ret,
                  struct ttf_err *err);

/* Its vendor interface. */
struct usb_endpoints {
    uint8_t interface, in, out;
};

int usb_find_endpoints(libusb_device_handle *handle, struct usb_endpoints *ret);

#endif
