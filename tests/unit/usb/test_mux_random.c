/* SPDX-License-Identifier: Apache-2.0 */
/*
 * test_mux_random.c: many streams opened, written, read and ended at random by both sides, with transfers under way in both
 * directions: what is read is what was written, each stream ends, no stream is told the end of another that had its id before, and
 * every id can be used again. The same on each run.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "pair.h"

#define FLYING 24 /* transfers under way in one direction, at most */
#define STEPS  60000
#define SEEDS  6

/* Transfers that one side has given and the other not taken yet, in order. */
struct cable {
    uint8_t *data[FLYING];
    size_t n[FLYING];
    unsigned first, count;
};

/* One direction of one stream: its bytes are a function of its number and the place. */
struct flow {
    uint32_t number;
    size_t written, read;
    unsigned ends; /* bit: a reason by which its writer has ended it */
};

struct world {
    struct ttf_mux *mux[2]; /* host, box */
    struct cable cable[2];  /* from that side */
    struct flow flow[2][TTF_MUX_STREAMS];
    bool known[2][TTF_MUX_STREAMS]; /* open when it was looked at last */
    uint32_t opened, told;
    uint64_t random;
    bool quiet; /* streams are opened and ended more than they are written to */
    size_t most_held;
};

static uint32_t draw(struct world *w, uint32_t below)
{
    w->random ^= w->random << 13;
    w->random ^= w->random >> 7;
    w->random ^= w->random << 17;
    return (uint32_t)(w->random >> 20) % below;
}

static uint8_t byte_of(const struct flow *f, size_t at)
{
    return (uint8_t)((f->number * 2654435761u >> 8) + at * 7 + (at >> 9));
}

static void give(struct world *w, unsigned side)
{
    struct cable *c = &w->cable[side];
    unsigned at = (c->first + c->count) % FLYING;

    if (c->count == FLYING)
        return;
    c->n[at] = ttf_mux_give(w->mux[side], c->data[at]);
    if (c->n[at] > 0 && (c->n[at] % 64 == 0 || c->n[at] > TTF_MUX_TRANSFER_MAX))
        fail_msg("a transfer of %zu bytes", c->n[at]);
    c->count += c->n[at] > 0;
}

/* What a stream is told of the other side's end is what that side has said of this very stream. */
static void check_end(struct world *w, unsigned side, unsigned i)
{
    struct ttf_mux_view view = ttf_mux_look(w->mux[side], i + 1);
    const struct flow *own = &w->flow[side][i], *others = &w->flow[!side][i];
    unsigned said = others->number == own->number ? others->ends : 0;

    /* GONE is also the answer to an end of ours that ends both directions. */
    if (own->ends & ~(1u << TTF_MUX_END))
        said |= 1u << TTF_MUX_GONE;
    if (view.open && view.peer_ended && !(said & 1u << view.reason))
        fail_msg("stream %u of side %u, the %u. opened, is told an end %d that is not its own",
                 i + 1, side, own->number, (int)view.reason);
    w->told += view.open && view.peer_ended;
}

static void end(struct world *w, unsigned side, unsigned i, enum ttf_mux_reason reason)
{
    if (ttf_mux_look(w->mux[side], i + 1).open)
        w->flow[side][i].ends |= 1u << reason;
    ttf_mux_end(w->mux[side], i + 1, reason);
}

/* A new life of an id, as the box learns of it: in the order in which the host began them, so that both number alike. */
static void learn(struct world *w, unsigned side)
{
    uint32_t changed = ttf_mux_changed(w->mux[side]);

    for (unsigned i = 0; i < TTF_MUX_STREAMS; i++) {
        bool open = ttf_mux_look(w->mux[side], i + 1).open;

        if (!(changed & 1u << i) && open != w->known[side][i])
            fail_msg("a stream changed, and nobody was told");
        if (side == 1 && open && !w->known[1][i]) {
            /* What the host writes is in this flow's number since it opened it. */
            w->flow[1][i] = (struct flow){.number = w->flow[0][i].number};
        }
        w->known[side][i] = open;
        check_end(w, side, i);
    }
}

static void take(struct world *w, unsigned side)
{
    struct cable *c = &w->cable[!side];
    uint8_t copy[TTF_MUX_TRANSFER_MAX];
    size_t n;
    int r;

    if (c->count == 0)
        return;
    n = c->n[c->first];
    memcpy(copy, c->data[c->first], n);
    c->first = (c->first + 1) % FLYING;
    c->count--;
    r = ttf_mux_take(w->mux[side], copy, n);
    if (r < 0)
        fail_msg("side %u does not understand: %d", side, r);
}

static void write_some(struct world *w, unsigned side, unsigned i)
{
    struct flow *f = &w->flow[side][i];
    uint8_t data[20000];
    size_t n = draw(w, draw(w, 4) ? 300 : sizeof data) + 1;
    int r;

    for (size_t k = 0; k < n; k++)
        data[k] = byte_of(f, f->written + k);
    r = ttf_mux_write(w->mux[side], i + 1, data, n);
    f->written += r > 0 ? (size_t)r : 0;
}

static void read_some(struct world *w, unsigned side, unsigned i)
{
    struct flow *f = &w->flow[side][i];
    const uint8_t *at = NULL;
    size_t n = ttf_mux_peek(w->mux[side], i + 1, &at);

    if (n > 0)
        n = draw(w, (uint32_t)n) + 1;
    for (size_t k = 0; k < n; k++)
        if (at[k] != byte_of(f, f->read + k))
            fail_msg("byte %zu of stream %u is another", f->read + k, i + 1);
    f->read += n;
    ttf_mux_taken(w->mux[side], i + 1, n);
}

static void act(struct world *w, unsigned side)
{
    unsigned i = draw(w, w->quiet ? 3 : TTF_MUX_STREAMS), what = draw(w, 100);
    int id;

    if (what < (w->quiet ? 20 : 3) && side == 0 && (id = ttf_mux_open(w->mux[0])) > 0) {
        w->flow[0][id - 1] = (struct flow){.number = ++w->opened};
    } else if (what < (w->quiet ? 22 : 40)) {
        write_some(w, side, i);
    } else if (what < (w->quiet ? 35 : 75)) {
        read_some(w, side, i);
    } else if (what < (w->quiet ? 65 : 78)) {
        end(w, side, i, draw(w, 2) ? TTF_MUX_END : (enum ttf_mux_reason)draw(w, 4));
    } else if (what < 89) {
        give(w, side);
    } else {
        take(w, side);
    }
    learn(w, side);
    size_t held = ttf_mux_held(w->mux[side]);

    if (held > w->most_held)
        w->most_held = held;
}

/* All that is under way arrives, both read all they get and end. */
static void wind_up(struct world *w)
{
    for (unsigned round = 0; round < 3000; round++) {
        for (unsigned side = 0; side < 2; side++) {
            for (unsigned i = 0; i < TTF_MUX_STREAMS; i++) {
                read_some(w, side, i);
                end(w, side, i, TTF_MUX_END);
            }
            give(w, side);
            learn(w, side);
            take(w, side);
            learn(w, side);
        }
    }
    for (unsigned side = 0; side < 2; side++)
        for (unsigned i = 0; i < TTF_MUX_STREAMS; i++)
            if (ttf_mux_look(w->mux[side], i + 1).open)
                fail_msg("stream %u of side %u does not end", i + 1, side);
}

static void run(uint64_t seed, bool quiet)
{
    static struct world w;

    memset(&w, 0, sizeof w);
    w.quiet = quiet;
    w.random = seed * UINT64_C(0x9e3779b97f4a7c15);
    for (unsigned side = 0; side < 2; side++) {
        assert_int_equal(ttf_mux_create(side ? TTF_MUX_BOX : TTF_MUX_HOST, &w.mux[side]), 0);
        ttf_mux_reset(w.mux[side], seed);
        for (unsigned i = 0; i < FLYING; i++) {
            w.cable[side].data[i] = malloc(TTF_MUX_TRANSFER_MAX);
            assert_true(w.cable[side].data[i] != NULL);
        }
    }
    for (unsigned step = 0; step < (quiet ? STEPS / 3 : STEPS); step++)
        act(&w, draw(&w, 2));
    if (w.opened < 100)
        fail_msg("only %u streams were opened", w.opened);
    if (w.told == 0)
        fail_msg("no stream was told an end");
    if (w.most_held > 2 * (size_t)TTF_MUX_STREAMS * TTF_MUX_WINDOW)
        fail_msg("%zu bytes were held", w.most_held);
    wind_up(&w);
    for (unsigned side = 0; side < 2; side++) {
        ttf_mux_destroy(w.mux[side]);
        for (unsigned i = 0; i < FLYING; i++)
            free(w.cable[side].data[i]);
    }
}

static void streams_at_random_carry_what_was_written(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= SEEDS; seed++)
        run(seed, false);
}

static void no_stream_is_told_the_end_of_another(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= SEEDS; seed++)
        run(seed, true);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(streams_at_random_carry_what_was_written),
        cmocka_unit_test(no_stream_is_told_the_end_of_another),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
