/* SPDX-License-Identifier: Apache-2.0 */
/* rig_usb.h: both ends of a cable that carries bytes and nothing else: how fast it goes. */
#ifndef RIG_USB_H
#define RIG_USB_H

#include "ttf/hal/clock.h"

#define RIG_USB_TRANSFER 65536u /* bytes, of which RIG_USB_DEPTH are queued at each end */
#define RIG_USB_DEPTH    8u

/* A box's end, of the FunctionFS that is mounted at folder: gives bytes as fast as they are taken, until it is killed or unbound. */
int rig_usb_source(const char *folder);

/* A PC's end: takes so many bytes of it. Bytes a second, or a negative errno. */
int64_t rig_usb_drain(struct ttf_clock *clock, int64_t bytes);

#endif
