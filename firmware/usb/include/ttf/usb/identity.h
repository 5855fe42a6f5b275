/* SPDX-License-Identifier: Apache-2.0 */
/* identity.h: what a box is known by on the bus; the gadget's descriptors, the PC's side and udev's rule agree on it. */
#ifndef TTF_USB_IDENTITY_H
#define TTF_USB_IDENTITY_H

#define TTF_USB_VENDOR       0x1209 /* pid.codes; a placeholder until a number is given */
#define TTF_USB_PRODUCT      0x0001
#define TTF_USB_PRODUCT_NAME "ttfbox capture box"
#define TTF_USB_CLASS        0xff /* of the interface: it is found by that, never by its number */

/* The interface's GUID on Windows. */
#define TTF_USB_GUID "{8FE6D4D7-49DD-41E7-9486-49AFC6BFE475}"

/* The control request of PROTOCOL.md, "Reset". */
#define TTF_USB_RESET_TYPE    0x41
#define TTF_USB_RESET_REQUEST 1
#define TTF_USB_RESET_VERSION 1
#define TTF_USB_RESET_SIZE    8 /* bytes of data: the nonce, little-endian */

#endif
