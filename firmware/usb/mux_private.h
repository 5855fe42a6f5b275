/* SPDX-License-Identifier: Apache-2.0 */
/* mux_private.h: what mux.c, mux_take.c and mux_give.c share. */
#ifndef USB_MUX_PRIVATE_H
#define USB_MUX_PRIVATE_H

#include "frames.h"
#include "queue.h"
#include "ttf/usb/mux.h"

struct usb_stream {
    bool open;
    bool open_due;          /* OPEN is still to be sent */
    bool ended, gone;       /* we: send no more; take no more */
    bool end_due, gone_due; /* that is still to be said; of both, the second alone */
    bool close_sent;        /* one of them has been */
    bool peer_ended, peer_gone;
    enum ttf_mux_reason gone_reason, peer_reason;
    uint32_t credit;    /* bytes that the peer still takes */
    uint32_t allowed;   /* bytes that the peer may still send */
    uint32_t to_return; /* bytes taken off and not given back yet */
    struct usb_queue in, out;
};

enum usb_mux_state {
    USB_MUX_IDLE = 0, /* passes over everything, sends nothing */
    USB_MUX_ASKING,   /* the same, but for a HELLO that asks for a reset */
    USB_MUX_WAITING,  /* for the peer's HELLO */
    USB_MUX_READY
};

struct ttf_mux {
    enum ttf_mux_role role;
    enum usb_mux_state state;
    uint64_t nonce;
    bool pad_due, hello_due;
    uint32_t peer_window;
    unsigned streams; /* ids of both sides */
    unsigned turn;    /* the stream whose DATA goes first next, 0-based */
    uint32_t changed;
    uint32_t lives[TTF_MUX_STREAMS]; /* how often each id was opened */
    struct usb_stream stream[TTF_MUX_STREAMS];
};

/* In order: what is to be sent of it before it may be forgotten; frees an id that is done. */
void usb_stream_settle(struct ttf_mux *mux, unsigned id);

/* n bytes that had come are delivered or thrown away. */
void usb_stream_return(struct usb_stream *s, size_t n);

/* A fresh one. */
void usb_stream_begin(struct ttf_mux *mux, unsigned id);

/* All streams over, all that is due forgotten. */
void usb_mux_stop(struct ttf_mux *mux);

static inline void usb_mux_mark(struct ttf_mux *mux, unsigned id)
{
    mux->changed |= UINT32_C(1) << (id - 1);
}

static inline struct usb_stream *usb_mux_stream(struct ttf_mux *mux, unsigned id)
{
    return id >= 1 && id <= TTF_MUX_STREAMS && mux->stream[id - 1].open ? &mux->stream[id - 1]
                                                                        : NULL;
}

#endif
