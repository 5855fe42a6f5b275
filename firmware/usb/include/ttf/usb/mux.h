/* SPDX-License-Identifier: Apache-2.0 */
/*
 * mux.h: streams over two bulk endpoints (PROTOCOL.md): transfers that came in are given to it, and it gives transfers to be
 * sent. It does no I/O, knows no time, and holds no more than its windows. One thread.
 */
#ifndef TTF_USB_MUX_H
#define TTF_USB_MUX_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "ttf/base/attr.h"

#define TTF_MUX_STREAMS      32u          /* ids are 1..32 */
#define TTF_MUX_TRANSFER_MAX 65528u       /* bytes */
#define TTF_MUX_WINDOW       (256u << 10) /* bytes of a stream, in each direction */

enum ttf_mux_role {
    TTF_MUX_HOST, /* opens streams */
    TTF_MUX_BOX
};

/* Why a stream ended, as CLOSE says it. */
enum ttf_mux_reason {
    TTF_MUX_END = 0, /* an end of file: the other direction goes on */
    TTF_MUX_GONE,    /* both directions */
    TTF_MUX_REFUSED, /* the server was not to be reached */
    TTF_MUX_FAILED   /* bytes may be missing */
};

struct ttf_mux;

/* -ENOMEM. It is idle: everything that comes is passed over, and nothing is sent, before it is reset. */
TTF_MUST_USE int ttf_mux_create(enum ttf_mux_role role, struct ttf_mux **ret);
void ttf_mux_destroy(struct ttf_mux *mux); /* NULL allowed */

/* All streams are over; begins with HELLO of this nonce. 0, of a box alone: asks the host for a reset. */
void ttf_mux_reset(struct ttf_mux *mux, uint64_t nonce);

/* Both sides have seen each other's HELLO: streams may be opened. */
bool ttf_mux_is_ready(const struct ttf_mux *mux);

/*
 * A transfer that came. 0; -EPROTO: it breaks a rule; -ESTALE: the box asks for a reset; -EPROTONOSUPPORT: the other side
 * speaks another version; -ENOMEM. On an error all streams are over, and it is idle until it is reset.
 */
TTF_MUST_USE int ttf_mux_take(struct ttf_mux *mux, const void *data, size_t n);

/* The next transfer to be sent, into TTF_MUX_TRANSFER_MAX bytes. Its length; 0: there is none now. */
TTF_MUST_USE size_t ttf_mux_give(struct ttf_mux *mux, void *ret);

/* Would give have one? */
bool ttf_mux_has_transfer(const struct ttf_mux *mux);

/* How a stream stands. */
struct ttf_mux_view {
    bool open;                  /* the id is in use */
    uint32_t life;              /* another one for each stream that has the id, one after another */
    size_t readable;            /* bytes that came and were not taken */
    size_t room;                /* bytes that ttf_mux_write takes; 0 after an end of ours */
    bool peer_ended;            /* behind what is readable there is no more */
    bool peer_gone;             /* and it takes no more */
    bool ended;                 /* we have ended */
    enum ttf_mux_reason reason; /* of the peer's last CLOSE, if it has ended */
};

/* id: 1..TTF_MUX_STREAMS. */
struct ttf_mux_view ttf_mux_look(const struct ttf_mux *mux, unsigned id);

/* Bit id - 1 of each stream that may look otherwise than when this was asked last. Within one transfer an id may be over and
 * opened again: by its life it is known to be another stream. */
uint32_t ttf_mux_changed(struct ttf_mux *mux);

/* Of the host: a new stream's id; -EAGAIN: all are in use; -ENOTCONN: not ready. */
int ttf_mux_open(struct ttf_mux *mux);

/* Takes as much as there is room for: how much, may be 0; -ENOMEM; -EPIPE: ended, or no such stream. */
TTF_MUST_USE int ttf_mux_write(struct ttf_mux *mux, unsigned id, const void *data, size_t n);

/* What is readable, as far as it lies in one piece; valid until the next call. */
size_t ttf_mux_peek(const struct ttf_mux *mux, unsigned id, const uint8_t **ret);

/* That much of it was taken, and may be sent again by the peer. */
void ttf_mux_taken(struct ttf_mux *mux, unsigned id, size_t n);

/*
 * We send no more; what is written still goes, unless the peer is gone. With another reason than END what came, and comes, is
 * thrown away.
 * Nothing happens to a stream that is not open or has ended so already.
 */
void ttf_mux_end(struct ttf_mux *mux, unsigned id, enum ttf_mux_reason reason);

/* Bytes held in all streams, both directions: at most 2 * TTF_MUX_STREAMS * TTF_MUX_WINDOW. */
size_t ttf_mux_held(const struct ttf_mux *mux);

#endif
