/* SPDX-License-Identifier: Apache-2.0 */
/* functionfs.h: a box's end of its cable: the kernel's FunctionFS. */
#ifndef TTF_USB_FUNCTIONFS_H
#define TTF_USB_FUNCTIONFS_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/usb/link.h"

/*
 * Opens ep0 of a FunctionFS that is mounted at folder, and writes the interface's descriptors. The descriptor: as long as
 * somebody holds it, the gadget stays what it is. Errors of open and write.
 */
TTF_MUST_USE int ttf_usb_functionfs_prepare(const char *folder, struct ttf_err *err);

/*
 * A link over it. ep0: of ttf_usb_functionfs_prepare, in this process or one before; the link's from now on, also on failure. It may have been
 * bound long since. -ENOMEM; -ENAMETOOLONG; errors of eventfd and fcntl.
 */
TTF_MUST_USE int ttf_usb_functionfs_create(const char *folder, int ep0, struct ttf_usb_link **ret,
                                           struct ttf_err *err);

/*
 * The bytes that are written: descriptors (of full, high and super speed, and Microsoft's OS 1.0 ones with that bcdVersion:
 * 0x0100, or 1 for kernels up to 6.1) and strings. Their length; ret has room for TTF_USB_DESCRIPTORS_MAX bytes.
 */
#define TTF_USB_DESCRIPTORS_MAX 512
size_t ttf_usb_functionfs_descriptors(uint8_t *ret, unsigned bcd_version);
size_t ttf_usb_functionfs_strings(uint8_t *ret);

#endif
