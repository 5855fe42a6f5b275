/* SPDX-License-Identifier: Apache-2.0 */
/* mux_give.c: the next transfer to be sent. */
#include "mux_private.h"

#define RETURN_FROM (TTF_MUX_WINDOW / 4) /* what a reader has taken is given back by so much */

struct transfer {
    uint8_t *data;
    size_t n;
};

static size_t left(const struct transfer *t)
{
    return TTF_MUX_TRANSFER_MAX - t->n;
}

static uint8_t *add(struct transfer *t, unsigned stream, enum usb_frame_type type, size_t length)
{
    uint8_t *at = t->data + t->n;

    usb_frame_write(at, stream, type, length);
    t->n += USB_HEADER + length;
    return at + USB_HEADER;
}

static void add_hello(struct ttf_mux *mux, struct transfer *t)
{
    uint8_t *at = add(t, 0, USB_FRAME_HELLO, USB_HELLO_SIZE);

    usb_put16(at, USB_VERSION);
    usb_put16(at + 2, TTF_MUX_STREAMS);
    usb_put32(at + 4, TTF_MUX_WINDOW);
    usb_put64(at + 8, mux->nonce);
    mux->hello_due = false;
}

static bool credit_is_due(const struct usb_stream *s)
{
    return s->to_return >= RETURN_FROM || (s->to_return > 0 && s->peer_ended);
}

static bool may_send(const struct usb_stream *s)
{
    return s->out.n > 0 && s->credit > 0;
}

/*
 * A box's second CLOSE waits until bytes are there that it has not given back. Without any, the host may have ended it too and
 * hold the id for free, and the CLOSE would end the next stream of it; with them it cannot, before it has their CREDIT.
 */
static bool end_is_due(const struct ttf_mux *mux, const struct usb_stream *s)
{
    bool may_be_late = mux->role == TTF_MUX_BOX && s->close_sent && s->allowed >= TTF_MUX_WINDOW;

    return (s->gone_due || s->end_due) && s->out.n == 0 && !may_be_late;
}

static bool has_something(const struct ttf_mux *mux, const struct usb_stream *s)
{
    return s->open && (s->open_due || credit_is_due(s) || may_send(s) || end_is_due(mux, s));
}

static void add_number(struct transfer *t, unsigned id, enum usb_frame_type type, uint32_t number)
{
    usb_put32(add(t, id, type, USB_NUMBER_SIZE), number);
}

/* All but DATA. Of all streams together it is under 2 KiB: it always fits. */
static void add_control(struct ttf_mux *mux, unsigned id, struct transfer *t)
{
    struct usb_stream *s = &mux->stream[id - 1];

    if (s->open_due)
        (void)add(t, id, USB_FRAME_OPEN, 0);
    s->open_due = false;
    if (end_is_due(mux, s)) { /* before CREDIT, behind which the id may be another stream's */
        add_number(t, id, USB_FRAME_CLOSE, s->gone_due ? s->gone_reason : TTF_MUX_END);
        s->gone_due = s->end_due = false;
        s->close_sent = true;
    }
    if (credit_is_due(s)) {
        add_number(t, id, USB_FRAME_CREDIT, s->to_return);
        s->allowed += s->to_return;
        s->to_return = 0;
    }
}

static void add_data(struct ttf_mux *mux, unsigned id, struct transfer *t)
{
    struct usb_stream *s = &mux->stream[id - 1];
    size_t n = s->out.n < s->credit ? s->out.n : s->credit;

    if (n > USB_DATA_MAX)
        n = USB_DATA_MAX;
    if (n > left(t) - USB_HEADER)
        n = left(t) - USB_HEADER;
    usb_queue_get(&s->out, add(t, id, USB_FRAME_DATA, n), n);
    s->credit -= (uint32_t)n;
    usb_mux_mark(mux, id);
}

/* One DATA of each stream that has something, round and round, until the transfer is full. */
static void add_turns(struct ttf_mux *mux, struct transfer *t)
{
    unsigned without = 0;

    while (without < TTF_MUX_STREAMS && left(t) > USB_HEADER) {
        unsigned id = mux->turn + 1;

        mux->turn = (mux->turn + 1) % TTF_MUX_STREAMS;
        without++;
        if (mux->stream[id - 1].open && may_send(&mux->stream[id - 1])) {
            add_data(mux, id, t);
            without = 0;
        }
    }
}

static void add_streams(struct ttf_mux *mux, struct transfer *t)
{
    for (unsigned id = 1; id <= TTF_MUX_STREAMS; id++)
        if (mux->stream[id - 1].open)
            add_control(mux, id, t);
    add_turns(mux, t);
    /* Ends behind the last data; where there is no room, the next transfer has them. */
    for (unsigned id = 1; id <= TTF_MUX_STREAMS; id++) {
        if (!mux->stream[id - 1].open)
            continue;
        if (left(t) >= USB_HEADER + USB_NUMBER_SIZE && end_is_due(mux, &mux->stream[id - 1]))
            add_control(mux, id, t);
        usb_stream_settle(mux, id);
    }
}

bool ttf_mux_has_transfer(const struct ttf_mux *mux)
{
    if (mux->pad_due || mux->hello_due)
        return true;
    if (mux->state != USB_MUX_READY)
        return false;
    for (unsigned i = 0; i < TTF_MUX_STREAMS; i++)
        if (has_something(mux, &mux->stream[i]))
            return true;
    return false;
}

size_t ttf_mux_give(struct ttf_mux *mux, void *ret)
{
    struct transfer t = {.data = ret};

    if (mux->pad_due) {
        mux->pad_due = false;
        (void)add(&t, 0, USB_FRAME_PAD, 0);
        return t.n;
    }
    if (mux->hello_due)
        add_hello(mux, &t);
    else if (mux->state == USB_MUX_READY)
        add_streams(mux, &t);
    if (t.n > 0 && t.n % USB_SHORTEST == 0)
        (void)add(&t, 0, USB_FRAME_PAD, 0);
    return t.n;
}
