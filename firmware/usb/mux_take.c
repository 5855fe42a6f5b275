/* SPDX-License-Identifier: Apache-2.0 */
/* mux_take.c: a transfer that came, frame by frame. Every rule of PROTOCOL.md, "Errors", is checked here. */
#include <errno.h>

#include "mux_private.h"

static int take_open(struct ttf_mux *mux, unsigned id)
{
    if (mux->role != TTF_MUX_BOX || id < 1 || id > TTF_MUX_STREAMS || mux->stream[id - 1].open)
        return -EPROTO;
    usb_stream_begin(mux, id);
    return 0;
}

static int take_data(struct ttf_mux *mux, unsigned id, const uint8_t *data, uint32_t n)
{
    struct usb_stream *s = usb_mux_stream(mux, id);

    if (!s || s->peer_ended || n == 0 || n > USB_DATA_MAX || n > s->allowed)
        return -EPROTO;
    s->allowed -= n;
    usb_mux_mark(mux, id);
    if (s->gone) { /* it crossed with our end */
        usb_stream_return(s, n);
        return 0;
    }
    return usb_queue_put(&s->in, data, n);
}

static int take_credit(struct ttf_mux *mux, unsigned id, uint32_t more)
{
    struct usb_stream *s = usb_mux_stream(mux, id);

    if (!s)
        return 0;
    if (more > INT32_MAX || s->credit + more > INT32_MAX)
        return -EPROTO;
    s->credit += more;
    usb_stream_settle(mux, id);
    return 0;
}

static int take_close(struct ttf_mux *mux, unsigned id, uint32_t reason)
{
    struct usb_stream *s = usb_mux_stream(mux, id);

    if (reason > TTF_MUX_FAILED)
        return -EPROTO;
    if (!s)
        return 0;
    if (s->peer_gone || (s->peer_ended && reason == TTF_MUX_END))
        return -EPROTO;
    s->peer_ended = true;
    s->peer_reason = (enum ttf_mux_reason)reason;
    usb_mux_mark(mux, id);
    if (s->close_sent) /* over: nothing more is said of it */
        s->gone_due = false;
    if (reason != TTF_MUX_END) {
        s->peer_gone = true;
        usb_queue_drop(&s->out, s->out.n);
        if (!s->close_sent && !s->gone_due) { /* answered; what came before is still delivered */
            s->ended = true;
            s->end_due = false;
            s->gone_due = true;
            s->gone_reason = TTF_MUX_GONE;
        }
    }
    usb_stream_settle(mux, id);
    return 0;
}

/* A HELLO among other frames of a conversation. */
static int take_late_hello(const struct ttf_mux *mux, const uint8_t *payload)
{
    return mux->role == TTF_MUX_HOST && usb_hello_read(payload).nonce == 0 ? -ESTALE : -EPROTO;
}

static int take_frame(struct ttf_mux *mux, const struct usb_frame *f, const uint8_t *payload)
{
    bool of_stream = f->type != USB_FRAME_HELLO && f->type != USB_FRAME_PAD;

    if (f->flags != 0 || (f->stream == 0) == of_stream || f->stream > TTF_MUX_STREAMS)
        return -EPROTO;
    switch (f->type) {
    case USB_FRAME_HELLO:
        return f->length == USB_HELLO_SIZE ? take_late_hello(mux, payload) : -EPROTO;
    case USB_FRAME_OPEN:
        return f->length == 0 ? take_open(mux, f->stream) : -EPROTO;
    case USB_FRAME_DATA:
        return take_data(mux, f->stream, payload, f->length);
    case USB_FRAME_CREDIT:
        return f->length == USB_NUMBER_SIZE ? take_credit(mux, f->stream, usb_get32(payload))
                                            : -EPROTO;
    case USB_FRAME_CLOSE:
        return f->length == USB_NUMBER_SIZE ? take_close(mux, f->stream, usb_get32(payload))
                                            : -EPROTO;
    case USB_FRAME_PAD:
        return 0;
    default:
        return -EPROTO;
    }
}

static int take_frames(struct ttf_mux *mux, const uint8_t *at, size_t n)
{
    while (n > 0) {
        struct usb_frame f;
        int r;

        if (n < USB_HEADER)
            return -EPROTO;
        f = usb_frame_read(at);
        at += USB_HEADER;
        n -= USB_HEADER;
        if (f.length > n)
            return -EPROTO;
        r = take_frame(mux, &f, at);
        if (r < 0)
            return r;
        at += f.length;
        n -= f.length;
    }
    return 0;
}

static bool is_shape(size_t n)
{
    return n >= USB_HEADER && n <= TTF_MUX_TRANSFER_MAX && n % USB_SHORTEST != 0;
}

/* Is it the HELLO that is waited for? 0: pass it over; 1: it is. */
static int take_first(struct ttf_mux *mux, const uint8_t *data, size_t n)
{
    struct usb_frame f;
    struct usb_hello hello;

    if (!is_shape(n) || n < USB_HEADER + USB_HELLO_SIZE)
        return 0;
    f = usb_frame_read(data);
    if (f.type != USB_FRAME_HELLO || f.stream != 0 || f.flags != 0 || f.length != USB_HELLO_SIZE)
        return 0;
    hello = usb_hello_read(data + USB_HEADER);
    if (hello.nonce != mux->nonce)
        return 0;
    if (hello.version != USB_VERSION)
        return -EPROTONOSUPPORT;
    if (hello.window == 0 || hello.window > USB_WINDOW_MAX || hello.streams == 0)
        return -EPROTO;
    mux->peer_window = hello.window;
    mux->streams = hello.streams < TTF_MUX_STREAMS ? hello.streams : TTF_MUX_STREAMS;
    mux->state = USB_MUX_READY;
    return 1;
}

int ttf_mux_take(struct ttf_mux *mux, const void *data, size_t n)
{
    const uint8_t *at = data;
    const size_t hello = USB_HEADER + USB_HELLO_SIZE;
    bool due = false;
    int r;

    if (mux->state == USB_MUX_READY) {
        r = is_shape(n) ? take_frames(mux, at, n) : -EPROTO;
    } else if (mux->state == USB_MUX_WAITING) {
        r = take_first(mux, at, n);
        due = r == -EPROTONOSUPPORT && mux->hello_due; /* the other side is to learn why */
        if (r == 1)
            r = take_frames(mux, at + hello, n - hello);
    } else {
        r = 0;
    }
    if (r < 0) {
        usb_mux_stop(mux);
        mux->pad_due = mux->hello_due = due;
    }
    return r;
}
