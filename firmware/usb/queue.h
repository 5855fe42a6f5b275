/* SPDX-License-Identifier: Apache-2.0 */
/* queue.h: bytes of one direction of a stream: a ring that takes memory when it is first written to. */
#ifndef USB_QUEUE_H
#define USB_QUEUE_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"

struct usb_queue {
    uint8_t *data; /* of TTF_MUX_WINDOW bytes; NULL: nothing was written yet */
    size_t first, n;
};

size_t usb_queue_room(const struct usb_queue *queue);

/* All of n bytes, which have room. -ENOMEM. */
TTF_MUST_USE int usb_queue_put(struct usb_queue *queue, const void *data, size_t n);

/* Its first bytes, as far as they lie in one piece. */
size_t usb_queue_peek(const struct usb_queue *queue, const uint8_t **ret);

/* n: not more than there are. */
void usb_queue_drop(struct usb_queue *queue, size_t n);
void usb_queue_get(struct usb_queue *queue, uint8_t *ret, size_t n);

/* Empty, without memory. */
void usb_queue_free(struct usb_queue *queue);

#endif
