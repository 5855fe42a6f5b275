/* SPDX-License-Identifier: Apache-2.0 */
#include "queue.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/usb/mux.h"

size_t usb_queue_room(const struct usb_queue *queue)
{
    return TTF_MUX_WINDOW - queue->n;
}

int usb_queue_put(struct usb_queue *queue, const void *data, size_t n)
{
    size_t at, piece;

    if (!queue->data)
        queue->data = malloc(TTF_MUX_WINDOW);
    if (!queue->data)
        return -ENOMEM;
    at = (queue->first + queue->n) % TTF_MUX_WINDOW;
    piece = n < TTF_MUX_WINDOW - at ? n : TTF_MUX_WINDOW - at;
    memcpy(queue->data + at, data, piece);
    memcpy(queue->data, (const uint8_t *)data + piece, n - piece);
    queue->n += n;
    return 0;
}

size_t usb_queue_peek(const struct usb_queue *queue, const uint8_t **ret)
{
    size_t piece = TTF_MUX_WINDOW - queue->first;

    if (!queue->data)
        return 0;
    *ret = queue->data + queue->first;
    return queue->n < piece ? queue->n : piece;
}

void usb_queue_drop(struct usb_queue *queue, size_t n)
{
    queue->n -= n;
    /* From the start again when it is empty: a stream whose reader keeps up touches few pages. */
    queue->first = queue->n ? (queue->first + n) % TTF_MUX_WINDOW : 0;
}

void usb_queue_get(struct usb_queue *queue, uint8_t *ret, size_t n)
{
    const uint8_t *at = NULL;

    while (n > 0) {
        size_t piece = usb_queue_peek(queue, &at);

        if (piece > n)
            piece = n;
        if (piece == 0)
            return;
        memcpy(ret, at, piece);
        usb_queue_drop(queue, piece);
        ret += piece;
        n -= piece;
    }
}

void usb_queue_free(struct usb_queue *queue)
{
    free(queue->data);
    *queue = (struct usb_queue){0};
}
