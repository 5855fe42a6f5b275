/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "pair.h"

void pair_begin(struct pair *pair)
{
    memset(pair, 0, sizeof *pair);
    assert_int_equal(ttf_mux_create(TTF_MUX_HOST, &pair->host), 0);
    assert_int_equal(ttf_mux_create(TTF_MUX_BOX, &pair->box), 0);
    ttf_mux_reset(pair->box, 77);
    ttf_mux_reset(pair->host, 77);
    pair_settle(pair);
    assert_true(ttf_mux_is_ready(pair->host));
    assert_true(ttf_mux_is_ready(pair->box));
}

void pair_end(struct pair *pair)
{
    ttf_mux_destroy(pair->host);
    ttf_mux_destroy(pair->box);
}

int pair_move(struct pair *pair, struct ttf_mux *from, struct ttf_mux *to)
{
    int has = ttf_mux_has_transfer(from);
    size_t n = ttf_mux_give(from, pair->transfer);

    if (has != (n > 0))
        fail_msg("it says that there is %s to send, and gives %zu bytes",
                 has ? "something" : "nothing", n);
    if (n == 0)
        return 0;
    pair->n_transfers++;
    if (n > TTF_MUX_TRANSFER_MAX || n % 64 == 0)
        fail_msg("a transfer of %zu bytes", n);
    int r = ttf_mux_take(to, pair->transfer, n);

    return r < 0 ? r : 1;
}

void pair_settle(struct pair *pair)
{
    int moved = 1;

    while (moved) {
        int there = pair_move(pair, pair->host, pair->box);
        int back = pair_move(pair, pair->box, pair->host);

        if (there < 0 || back < 0)
            fail_msg("a transfer was not understood: %d, %d", there, back);
        moved = there + back;
    }
}

size_t pair_read(struct ttf_mux *mux, unsigned id, uint8_t *ret, size_t max)
{
    size_t got = 0, n;
    const uint8_t *at = NULL;

    while (got < max && (n = ttf_mux_peek(mux, id, &at)) > 0) {
        if (n > max - got)
            n = max - got;
        memcpy(ret + got, at, n);
        ttf_mux_taken(mux, id, n);
        got += n;
    }
    return got;
}
