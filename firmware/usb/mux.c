/* SPDX-License-Identifier: Apache-2.0 */
/* mux.c: streams as their users see them. What comes: mux_take.c; what goes: mux_give.c. */
#include <errno.h>
#include <stdlib.h>

#include "mux_private.h"

int ttf_mux_create(enum ttf_mux_role role, struct ttf_mux **ret)
{
    struct ttf_mux *mux = calloc(1, sizeof *mux);

    if (!mux)
        return -ENOMEM;
    mux->role = role;
    *ret = mux;
    return 0;
}

void ttf_mux_destroy(struct ttf_mux *mux)
{
    if (!mux)
        return;
    usb_mux_stop(mux);
    free(mux);
}

static void forget(struct ttf_mux *mux, unsigned id)
{
    struct usb_stream *s = &mux->stream[id - 1];

    usb_queue_free(&s->in);
    usb_queue_free(&s->out);
    *s = (struct usb_stream){0};
    usb_mux_mark(mux, id);
}

void usb_mux_stop(struct ttf_mux *mux)
{
    for (unsigned id = 1; id <= TTF_MUX_STREAMS; id++)
        if (mux->stream[id - 1].open)
            forget(mux, id);
    mux->state = USB_MUX_IDLE;
    mux->pad_due = mux->hello_due = false;
}

void ttf_mux_reset(struct ttf_mux *mux, uint64_t nonce)
{
    usb_mux_stop(mux);
    mux->state = nonce ? USB_MUX_WAITING : USB_MUX_ASKING;
    mux->nonce = nonce;
    mux->pad_due = mux->hello_due = true;
}

bool ttf_mux_is_ready(const struct ttf_mux *mux)
{
    return mux->state == USB_MUX_READY;
}

void usb_stream_begin(struct ttf_mux *mux, unsigned id)
{
    mux->stream[id - 1] =
        (struct usb_stream){.open = true, .credit = mux->peer_window, .allowed = TTF_MUX_WINDOW};
    mux->lives[id - 1]++;
    usb_mux_mark(mux, id);
}

void usb_stream_return(struct usb_stream *s, size_t n)
{
    s->to_return += (uint32_t)n;
}

void usb_stream_settle(struct ttf_mux *mux, unsigned id)
{
    const struct usb_stream *s = &mux->stream[id - 1];

    if (!s->ended || !s->peer_ended || s->open_due || s->end_due || s->gone_due || s->out.n > 0 ||
        s->in.n > 0)
        return;
    /* The box has given back all that it took; the host has got it, so that it knows the id free there too. */
    if (mux->role == TTF_MUX_BOX ? s->to_return == 0 : s->credit >= mux->peer_window)
        forget(mux, id);
}

struct ttf_mux_view ttf_mux_look(const struct ttf_mux *mux, unsigned id)
{
    const struct usb_stream *s = id >= 1 && id <= TTF_MUX_STREAMS ? &mux->stream[id - 1] : NULL;

    if (!s || !s->open)
        return (struct ttf_mux_view){0};
    return (struct ttf_mux_view){.open = true,
                                 .life = mux->lives[id - 1],
                                 .readable = s->in.n,
                                 .room = s->ended ? 0 : usb_queue_room(&s->out),
                                 .peer_ended = s->peer_ended,
                                 .peer_gone = s->peer_gone,
                                 .ended = s->ended,
                                 .reason = s->peer_reason};
}

uint32_t ttf_mux_changed(struct ttf_mux *mux)
{
    uint32_t changed = mux->changed;

    mux->changed = 0;
    return changed;
}

int ttf_mux_open(struct ttf_mux *mux)
{
    if (mux->role != TTF_MUX_HOST || mux->state != USB_MUX_READY)
        return -ENOTCONN;
    for (unsigned id = 1; id <= mux->streams; id++) {
        if (mux->stream[id - 1].open)
            continue;
        usb_stream_begin(mux, id);
        mux->stream[id - 1].open_due = true;
        return (int)id;
    }
    return -EAGAIN;
}

int ttf_mux_write(struct ttf_mux *mux, unsigned id, const void *data, size_t n)
{
    struct usb_stream *s = usb_mux_stream(mux, id);
    size_t room;
    int r;

    if (!s || s->ended)
        return -EPIPE;
    room = usb_queue_room(&s->out);
    if (n > room)
        n = room;
    if (n == 0)
        return 0;
    r = usb_queue_put(&s->out, data, n);
    return r < 0 ? r : (int)n;
}

size_t ttf_mux_peek(const struct ttf_mux *mux, unsigned id, const uint8_t **ret)
{
    if (id < 1 || id > TTF_MUX_STREAMS || !mux->stream[id - 1].open)
        return 0;
    return usb_queue_peek(&mux->stream[id - 1].in, ret);
}

void ttf_mux_taken(struct ttf_mux *mux, unsigned id, size_t n)
{
    struct usb_stream *s = usb_mux_stream(mux, id);

    if (!s || n > s->in.n)
        return;
    usb_queue_drop(&s->in, n);
    usb_stream_return(s, n);
    usb_stream_settle(mux, id);
}

void ttf_mux_end(struct ttf_mux *mux, unsigned id, enum ttf_mux_reason reason)
{
    struct usb_stream *s = usb_mux_stream(mux, id);

    if (!s || s->gone || (s->ended && reason == TTF_MUX_END))
        return;
    if (reason == TTF_MUX_END) {
        s->end_due = true;
    } else {
        /* With a CLOSE from each side it is over, and the host may be about to open the id again. */
        s->gone_due = !(s->close_sent && s->peer_ended);
        s->end_due = false;
        s->gone = true;
        s->gone_reason = reason;
        usb_stream_return(s, s->in.n);
        usb_queue_drop(&s->in, s->in.n);
    }
    s->ended = true;
    usb_stream_settle(mux, id);
}

size_t ttf_mux_held(const struct ttf_mux *mux)
{
    size_t n = 0;

    for (unsigned i = 0; i < TTF_MUX_STREAMS; i++)
        n += mux->stream[i].in.n + mux->stream[i].out.n;
    return n;
}
