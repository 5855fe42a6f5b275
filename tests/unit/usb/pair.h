/* SPDX-License-Identifier: Apache-2.0 */
/* pair.h: a host's and a box's multiplexer with a cable between that keeps transfers in order. */
#ifndef TEST_USB_PAIR_H
#define TEST_USB_PAIR_H

#include "ttf/usb/mux.h"

struct pair {
    struct ttf_mux *host, *box;
    uint8_t transfer[TTF_MUX_TRANSFER_MAX];
    unsigned long n_transfers;
};

/* Both reset by the same nonce, and ready. Ends the test if they are not. */
void pair_begin(struct pair *pair);
void pair_end(struct pair *pair);

/* One transfer from one to the other, checked for its shape. 1; 0: it had none; what take says. */
int pair_move(struct pair *pair, struct ttf_mux *from, struct ttf_mux *to);

/* Until neither has anything to send. */
void pair_settle(struct pair *pair);

/* All that is readable of a stream, into up to max bytes: how much. */
size_t pair_read(struct ttf_mux *mux, unsigned id, uint8_t *ret, size_t max);

#endif
