/* SPDX-License-Identifier: Apache-2.0 */
#include "tiff_order.h"

#include <string.h>

void tiff_order_begin(struct tiff_order *order)
{
    memset(order, 0, sizeof *order);
    order->state = TIFF_ORDER_HEAD;
}

static int hand_on(struct tiff_order *order, struct ttf_io *io, int file)
{
    int r = order->n > 0 ? ttf_io_pwrite_all(io, file, order->held, order->n, order->from) : 0;

    memset(order->held, 0, order->n);
    order->n = 0;
    return r;
}

int tiff_order_release(struct tiff_order *order, struct ttf_io *io, int file)
{
    order->state = TIFF_ORDER_NONE;
    return hand_on(order, io, file);
}

/* Puts the folder's place into the header, which is little-endian. */
static void tell_place(struct tiff_order *order, uint64_t place)
{
    size_t from = order->header == 8 ? 4 : 8;

    for (size_t i = from; i < order->header; i++, place >>= 8)
        order->held[i] = (unsigned char)place;
}

int tiff_order_pixels(struct tiff_order *order, struct ttf_io *io, int file, int64_t size,
                      int64_t bytes)
{
    int64_t end = size + bytes, place = end + end % 2; /* folders begin at even places */
    int r;

    if (order->state != TIFF_ORDER_HEAD || order->n != (size_t)size || size < TIFF_ORDER_HEADER / 2)
        return tiff_order_release(order, io, file);
    order->header = order->held[2] == 42 ? 8 : 16;
    if ((size_t)size < order->header || (order->header == 8 && place > UINT32_MAX))
        return tiff_order_release(order, io, file);
    tell_place(order, (uint64_t)place);
    memcpy(order->head, order->held, order->header);
    r = hand_on(order, io, file);
    order->state = r < 0 ? TIFF_ORDER_NONE : TIFF_ORDER_TAIL;
    order->from = end;
    return r;
}

/* Bytes of the header that are there already: it has been foreseen. */
static int is_foreseen(const struct tiff_order *order, int64_t at, const void *bytes, size_t n)
{
    return order->state == TIFF_ORDER_TAIL && at >= 0 && (uint64_t)at + n <= order->header &&
           memcmp(order->head + at, bytes, n) == 0;
}

int tiff_order_write(struct tiff_order *order, struct ttf_io *io, int file, int64_t at,
                     const void *bytes, size_t n)
{
    int64_t place = at - order->from;

    if (order->state == TIFF_ORDER_NONE)
        return 0;
    if (is_foreseen(order, at, bytes, n))
        return 1;
    if (order->state == TIFF_ORDER_TAIL && at >= (int64_t)order->header &&
        at + (int64_t)n <= order->from)
        return 0; /* pixels */
    if (place < 0 || (uint64_t)place > TIFF_ORDER_HELD || n > TIFF_ORDER_HELD - (size_t)place)
        return tiff_order_release(order, io, file);
    memcpy(order->held + place, bytes, n);
    if (order->n < (size_t)place + n)
        order->n = (size_t)place + n;
    return 1;
}
