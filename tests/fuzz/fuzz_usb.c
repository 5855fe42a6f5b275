/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Transfers of a side that means harm, and the other side's use of its streams meanwhile. The first byte's lowest bit: which
 * side is ours, 0 the host, 1 the box. Then, one after another: 0 LENGTH(2) BYTES a transfer comes; 1 one is given; 2 a stream
 * is opened; 3 ID N writes; 4 ID N reads; 5 ID REASON ends; 6 resets. Whatever comes, no more is held than the windows, what is
 * given keeps the rules of transfers, and streams that are over hold nothing.
 */
#include <stdlib.h>
#include <string.h>

#include "frames.h"
#include "fuzz.h"
#include "ttf/usb/mux.h"

#define NONCE 77

struct script {
    const uint8_t *at;
    size_t n;
};

static uint8_t take_byte(struct script *s)
{
    uint8_t byte = s->n > 0 ? *s->at : 0;

    s->at += s->n > 0;
    s->n -= s->n > 0;
    return byte;
}

/* On a copy of exactly that size, so that a read beyond its end is seen. */
static void come(struct ttf_mux *mux, struct script *s)
{
    size_t n = take_byte(s);
    uint8_t *copy;

    n |= (size_t)take_byte(s) << 8;
    if (n > s->n)
        n = s->n;
    copy = malloc(n ? n : 1);
    if (!copy)
        abort();
    memcpy(copy, s->at, n);
    s->at += n;
    s->n -= n;
    if (ttf_mux_take(mux, copy, n) < 0 && (ttf_mux_is_ready(mux) || ttf_mux_held(mux) > 0))
        abort();
    free(copy);
}

static void check_frames(const uint8_t *at, size_t n)
{
    while (n > 0) {
        struct usb_frame f;

        if (n < USB_HEADER)
            abort();
        f = usb_frame_read(at);
        if (f.length > n - USB_HEADER || f.type < USB_FRAME_HELLO || f.type > USB_FRAME_PAD)
            abort();
        at += USB_HEADER + f.length;
        n -= USB_HEADER + f.length;
    }
}

static void give(struct ttf_mux *mux)
{
    static uint8_t transfer[TTF_MUX_TRANSFER_MAX];
    bool has = ttf_mux_has_transfer(mux);
    size_t n = ttf_mux_give(mux, transfer);

    if (has != (n > 0) || n > sizeof transfer || (n > 0 && n % 64 == 0))
        abort();
    check_frames(transfer, n);
}

static void write_some(struct ttf_mux *mux, unsigned id, size_t n)
{
    static const uint8_t DATA[255 * 256];
    size_t room = ttf_mux_look(mux, id).room;
    int r = ttf_mux_write(mux, id, DATA, n * 256);

    if (r > 0 && (size_t)r > room)
        abort();
}

static void read_some(struct ttf_mux *mux, unsigned id, size_t n)
{
    const uint8_t *at = NULL;
    size_t there = ttf_mux_peek(mux, id, &at);
    volatile uint8_t seen = 0;

    if (there > ttf_mux_look(mux, id).readable)
        abort();
    if (there > n)
        there = n;
    for (size_t i = 0; i < there; i++)
        seen ^= at[i];
    ttf_mux_taken(mux, id, there);
}

static void act(struct ttf_mux *mux, struct script *s)
{
    unsigned id;

    switch (take_byte(s) % 7) {
    case 0:
        come(mux, s);
        break;
    case 1:
        give(mux);
        break;
    case 2:
        (void)ttf_mux_open(mux);
        break;
    case 3:
        id = take_byte(s);
        write_some(mux, id, take_byte(s));
        break;
    case 4:
        id = take_byte(s);
        read_some(mux, id, take_byte(s));
        break;
    case 5:
        id = take_byte(s);
        ttf_mux_end(mux, id, (enum ttf_mux_reason)(take_byte(s) % 4));
        break;
    default:
        ttf_mux_reset(mux, NONCE);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct script s = {data, size};
    struct ttf_mux *mux;

    if (ttf_mux_create(take_byte(&s) & 1 ? TTF_MUX_BOX : TTF_MUX_HOST, &mux) < 0)
        return 0;
    ttf_mux_reset(mux, NONCE);
    while (s.n > 0) {
        act(mux, &s);
        if (ttf_mux_held(mux) > 2 * (size_t)TTF_MUX_STREAMS * TTF_MUX_WINDOW)
            abort();
    }
    ttf_mux_destroy(mux);
    return 0;
}
