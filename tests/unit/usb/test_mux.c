/* SPDX-License-Identifier: Apache-2.0 */
/* test_mux.c: streams between a host and a box: whole, in turns, ended, reset. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include <errno.h>

#include "pair.h"

#define MORE (3u * TTF_MUX_WINDOW)

static unsigned open_one(struct pair *p)
{
    int id = ttf_mux_open(p->host);

    if (id < 1)
        fail_msg("no stream: %d", id);
    pair_settle(p);
    return (unsigned)id;
}

/* n bytes from one side to the other, as fast as there is room. Whether they came as they went. */
static int carries(struct pair *p, struct ttf_mux *from, struct ttf_mux *to, unsigned id, size_t n)
{
    uint8_t *sent = malloc(n + 1), *came = malloc(n + 1);
    size_t out = 0, in = 0;
    int same;

    if (!sent || !came) {
        free(sent);
        free(came);
        return 0;
    }
    for (size_t i = 0; i < n; i++)
        sent[i] = (uint8_t)(i * 31 + (i >> 8) + n);
    for (unsigned idle = 0; in < n && idle < 4; idle++) {
        int took = ttf_mux_write(from, id, sent + out, n - out);

        out += took > 0 ? (size_t)took : 0;
        (void)pair_move(p, from, to);
        size_t got = pair_read(to, id, came + in, n - in);

        (void)pair_move(p, to, from);
        in += got;
        if (got > 0 || took > 0)
            idle = 0;
    }
    same = in == n && memcmp(sent, came, n) == 0;
    free(sent);
    free(came);
    return same;
}

/* Each multiple of 64 in a campaign (TTFBOX_USB_SIZES=all, a minute), else fewer of the larger ones. */
static size_t step(size_t n)
{
    const char *asked = getenv("TTFBOX_USB_SIZES"); /* NOLINT(concurrency-mt-unsafe) */

    if (asked && strcmp(asked, "all") == 0)
        return 64;
    return n < 16384 ? 64 : n < 65536 ? 512 : 32768;
}

static void every_size_arrives_in_both_directions(void **state)
{
    struct pair p;
    unsigned id;

    (void)state;
    pair_begin(&p);
    id = open_one(&p);
    for (size_t n = 0; n <= 4096; n++)
        if (!carries(&p, p.host, p.box, id, n) || !carries(&p, p.box, p.host, id, n))
            fail_msg("%zu bytes do not arrive", n);
    for (size_t n = 4096; n <= 1u << 20; n += step(n))
        for (size_t near = n - 1; near <= n + 1; near++)
            if (!carries(&p, p.box, p.host, id, near))
                fail_msg("%zu bytes do not arrive", near);
    pair_end(&p);
}

static void a_stream_that_nobody_reads_stops_alone_and_holds_no_more_than_its_windows(void **state)
{
    struct pair p;
    unsigned stuck, other;
    static uint8_t data[MORE];
    size_t written = 0;

    (void)state;
    pair_begin(&p);
    stuck = open_one(&p);
    other = open_one(&p);
    for (int i = 0; i < 100; i++) {
        int n = ttf_mux_write(p.box, stuck, data, sizeof data);

        written += n > 0 ? (size_t)n : 0;
        pair_settle(&p);
    }
    assert_int_equal(written, 2 * TTF_MUX_WINDOW);
    assert_int_equal(ttf_mux_held(p.box), TTF_MUX_WINDOW);
    assert_int_equal(ttf_mux_held(p.host), TTF_MUX_WINDOW);
    assert_true(carries(&p, p.box, p.host, other, MORE));
    /* ... and when it is read at last, all of it comes. */
    written = 0;
    for (size_t n; (n = pair_read(p.host, stuck, data, sizeof data)) > 0; written += n)
        pair_settle(&p);
    assert_int_equal(written, 2 * TTF_MUX_WINDOW);
    pair_end(&p);
}

static void streams_take_turns(void **state)
{
    struct pair p;
    unsigned large, small;
    static uint8_t data[TTF_MUX_WINDOW];

    (void)state;
    pair_begin(&p);
    large = open_one(&p);
    small = open_one(&p);
    assert_int_equal(ttf_mux_write(p.box, large, data, sizeof data), sizeof data);
    assert_int_equal(ttf_mux_write(p.box, small, "ok", 2), 2);
    assert_int_equal(pair_move(&p, p.box, p.host), 1);
    assert_int_equal(ttf_mux_look(p.host, small).readable, 2);
    assert_true(ttf_mux_look(p.host, large).readable < sizeof data);
    pair_end(&p);
}

static void an_end_comes_behind_the_last_byte_and_leaves_the_other_direction(void **state)
{
    struct pair p;
    unsigned id;
    uint8_t got[16];
    static uint8_t data[TTF_MUX_WINDOW];

    (void)state;
    pair_begin(&p);
    id = open_one(&p);
    assert_int_equal(ttf_mux_write(p.host, id, data, sizeof data), sizeof data);
    ttf_mux_end(p.host, id, TTF_MUX_END);
    assert_int_equal(ttf_mux_write(p.host, id, "x", 1), -EPIPE);
    (void)pair_move(&p, p.host, p.box);
    assert_false(ttf_mux_look(p.box, id).peer_ended);
    pair_settle(&p);
    assert_true(ttf_mux_look(p.box, id).peer_ended);
    assert_int_equal(ttf_mux_look(p.box, id).readable, sizeof data);
    assert_int_equal(ttf_mux_write(p.box, id, "answer", 6), 6);
    pair_settle(&p);
    assert_int_equal(pair_read(p.host, id, got, sizeof got), 6);
    ttf_mux_end(p.box, id, TTF_MUX_END);
    pair_settle(&p);
    assert_true(ttf_mux_look(p.host, id).open); /* the box has not delivered it all */
    assert_int_equal(pair_read(p.box, id, data, sizeof data), sizeof data);
    pair_settle(&p);
    assert_false(ttf_mux_look(p.host, id).open);
    assert_false(ttf_mux_look(p.box, id).open);
    pair_end(&p);
}

static void whoever_is_gone_is_sent_nothing_more(void **state)
{
    struct pair p;
    unsigned id;
    static uint8_t data[TTF_MUX_WINDOW];

    (void)state;
    pair_begin(&p);
    id = open_one(&p);
    assert_int_equal(ttf_mux_write(p.box, id, data, sizeof data), sizeof data);
    (void)pair_move(&p, p.box, p.host);
    assert_int_equal(ttf_mux_write(p.host, id, "last words", 10), 10);
    (void)pair_move(&p, p.host, p.box);
    ttf_mux_end(p.host, id, TTF_MUX_GONE);
    pair_settle(&p);
    assert_int_equal(ttf_mux_look(p.box, id).room, 0);
    assert_true(ttf_mux_look(p.box, id).peer_gone);
    assert_int_equal(ttf_mux_held(p.box), 10); /* what came before is still to be delivered */
    assert_true(ttf_mux_look(p.host, id).open);
    assert_int_equal(pair_read(p.box, id, data, sizeof data), 10);
    pair_settle(&p);
    assert_false(ttf_mux_look(p.host, id).open);
    assert_false(ttf_mux_look(p.box, id).open);
    pair_end(&p);
}

static void a_server_that_is_not_there_is_told(void **state)
{
    struct pair p;
    unsigned id;

    (void)state;
    pair_begin(&p);
    id = open_one(&p);
    assert_int_equal(ttf_mux_write(p.host, id, "GET", 3), 3);
    ttf_mux_end(p.box, id, TTF_MUX_REFUSED);
    (void)pair_move(&p, p.box, p.host);
    assert_true(ttf_mux_look(p.host, id).peer_gone);
    assert_int_equal(ttf_mux_look(p.host, id).reason, TTF_MUX_REFUSED);
    pair_settle(&p);
    assert_false(ttf_mux_look(p.host, id).open);
    pair_end(&p);
}

static void an_end_of_both_that_crosses_does_not_touch_the_next_stream(void **state)
{
    struct pair p;
    unsigned id;

    (void)state;
    pair_begin(&p);
    id = open_one(&p);
    ttf_mux_end(p.box, id, TTF_MUX_END);
    (void)pair_move(&p, p.box, p.host);
    ttf_mux_end(p.host, id, TTF_MUX_END);
    (void)pair_move(&p, p.host, p.box);
    ttf_mux_end(p.box, id, TTF_MUX_GONE); /* too late: it is over */
    assert_int_equal(open_one(&p), id);
    assert_true(carries(&p, p.host, p.box, id, 1000));
    pair_end(&p);
}

static void the_box_ends_both_while_the_host_opens_the_id_again(void **state)
{
    struct pair p;
    unsigned id;
    uint8_t end[TTF_MUX_TRANSFER_MAX], again[TTF_MUX_TRANSFER_MAX];
    size_t n_end, n_again;

    (void)state;
    pair_begin(&p);
    id = open_one(&p);
    ttf_mux_end(p.box, id, TTF_MUX_END);
    (void)pair_move(&p, p.box, p.host);
    ttf_mux_end(p.host, id, TTF_MUX_END);
    n_end = ttf_mux_give(p.host, end); /* over for the host */
    assert_int_equal(ttf_mux_open(p.host), (int)id);
    n_again = ttf_mux_give(p.host, again);
    ttf_mux_end(p.box, id, TTF_MUX_GONE); /* before it hears of that */
    assert_int_equal(ttf_mux_take(p.box, end, n_end), 0);
    assert_int_equal(ttf_mux_take(p.box, again, n_again), 0);
    pair_settle(&p);
    assert_true(carries(&p, p.box, p.host, id, 1000));
    pair_end(&p);
}

static void a_second_end_of_the_box_never_reaches_the_next_stream(void **state)
{
    struct pair p;
    unsigned id;
    uint8_t end[TTF_MUX_TRANSFER_MAX], hosts[TTF_MUX_TRANSFER_MAX], late[TTF_MUX_TRANSFER_MAX];
    size_t n_end, n_hosts, n_late;

    (void)state;
    pair_begin(&p);
    id = open_one(&p);
    ttf_mux_end(p.box, id, TTF_MUX_END);
    n_end = ttf_mux_give(p.box, end);
    ttf_mux_end(p.host, id, TTF_MUX_END); /* the two cross */
    n_hosts = ttf_mux_give(p.host, hosts);
    ttf_mux_end(p.box, id, TTF_MUX_FAILED); /* before it hears of the host's */
    n_late = ttf_mux_has_transfer(p.box) ? ttf_mux_give(p.box, late) : 0;
    assert_int_equal(ttf_mux_take(p.host, end, n_end), 0);
    assert_int_equal(ttf_mux_open(p.host), (int)id); /* over for the host: another has it */
    if (n_late > 0)
        assert_int_equal(ttf_mux_take(p.host, late, n_late), 0);
    assert_false(ttf_mux_look(p.host, id).peer_ended);
    assert_int_equal(ttf_mux_take(p.box, hosts, n_hosts), 0);
    pair_settle(&p);
    assert_true(carries(&p, p.box, p.host, id, 1000));
    pair_end(&p);
}

static void a_second_end_of_the_box_is_told_while_bytes_are_outstanding(void **state)
{
    struct pair p;
    unsigned id;

    (void)state;
    pair_begin(&p);
    id = open_one(&p);
    ttf_mux_end(p.box, id, TTF_MUX_END);
    pair_settle(&p);
    ttf_mux_end(p.box, id, TTF_MUX_FAILED);
    assert_false(ttf_mux_has_transfer(p.box)); /* the host may be ending it, too */
    assert_int_equal(ttf_mux_write(p.host, id, "too late", 8), 8);
    assert_int_equal(pair_move(&p, p.host, p.box), 1);
    assert_int_equal(pair_move(&p, p.box, p.host), 1);
    assert_true(ttf_mux_look(p.host, id).peer_gone);
    assert_int_equal(ttf_mux_look(p.host, id).reason, TTF_MUX_FAILED);
    pair_settle(&p);
    assert_false(ttf_mux_look(p.host, id).open);
    assert_false(ttf_mux_look(p.box, id).open);
    assert_int_equal(open_one(&p), id);
    assert_true(carries(&p, p.host, p.box, id, 1000));
    pair_end(&p);
}

static void an_id_that_another_stream_has_is_known_by_its_life(void **state)
{
    struct pair p;
    unsigned id;
    uint32_t life;

    (void)state;
    pair_begin(&p);
    id = open_one(&p);
    life = ttf_mux_look(p.box, id).life;
    ttf_mux_end(p.box, id, TTF_MUX_GONE);
    pair_settle(&p);
    assert_int_equal(open_one(&p), id);
    assert_int_not_equal(ttf_mux_look(p.box, id).life, life);
    life = ttf_mux_look(p.box, id).life;
    ttf_mux_reset(p.box, 79);
    ttf_mux_reset(p.host, 79);
    pair_settle(&p);
    assert_int_equal(open_one(&p), id);
    assert_int_not_equal(ttf_mux_look(p.box, id).life, life);
    pair_end(&p);
}

static void there_are_so_many_streams_and_no_more(void **state)
{
    struct pair p;

    (void)state;
    pair_begin(&p);
    for (unsigned i = 0; i < TTF_MUX_STREAMS; i++)
        (void)open_one(&p);
    assert_int_equal(ttf_mux_open(p.host), -EAGAIN);
    ttf_mux_end(p.host, 7, TTF_MUX_GONE);
    pair_settle(&p);
    assert_int_equal(open_one(&p), 7);
    assert_int_equal(ttf_mux_open(p.box), -ENOTCONN);
    pair_end(&p);
}

static void a_reset_ends_all_and_what_was_under_way_is_passed_over(void **state)
{
    struct pair p;
    unsigned id;
    uint8_t old[TTF_MUX_TRANSFER_MAX];
    static uint8_t data[TTF_MUX_WINDOW];
    size_t n;

    (void)state;
    pair_begin(&p);
    id = open_one(&p);
    assert_int_equal(ttf_mux_write(p.box, id, data, sizeof data), sizeof data);
    n = ttf_mux_give(p.box, old);
    ttf_mux_reset(p.box, 78);
    ttf_mux_reset(p.host, 78);
    assert_false(ttf_mux_look(p.box, id).open);
    assert_int_equal(ttf_mux_held(p.box), 0);
    assert_int_equal(ttf_mux_changed(p.box), 1u << (id - 1));
    /* Whole, and each of its tails as it may lie in a buffer. */
    for (size_t from = 0; from < n; from += 512)
        assert_int_equal(ttf_mux_take(p.host, old + from, n - from), 0);
    assert_false(ttf_mux_is_ready(p.host));
    pair_settle(&p);
    assert_true(ttf_mux_is_ready(p.host));
    assert_true(carries(&p, p.box, p.host, open_one(&p), 5000));
    pair_end(&p);
}

static void the_hello_of_another_reset_is_none(void **state)
{
    struct pair p;

    (void)state;
    pair_begin(&p);
    ttf_mux_reset(p.host, 78);
    ttf_mux_reset(p.box, 79);
    pair_settle(&p);
    assert_false(ttf_mux_is_ready(p.host));
    assert_false(ttf_mux_is_ready(p.box));
    ttf_mux_reset(p.host, 80);
    ttf_mux_reset(p.box, 80);
    pair_settle(&p);
    assert_true(ttf_mux_is_ready(p.host));
    pair_end(&p);
}

static void a_box_that_was_started_anew_asks_for_a_reset(void **state)
{
    struct pair p;

    (void)state;
    pair_begin(&p);
    (void)open_one(&p);
    ttf_mux_reset(p.box, 0);
    assert_int_equal(pair_move(&p, p.box, p.host), 1); /* PAD */
    assert_int_equal(pair_move(&p, p.box, p.host), -ESTALE);
    assert_false(ttf_mux_look(p.host, 1).open);
    assert_int_equal(pair_move(&p, p.host, p.box), 0);
    pair_end(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_size_arrives_in_both_directions),
        cmocka_unit_test(a_stream_that_nobody_reads_stops_alone_and_holds_no_more_than_its_windows),
        cmocka_unit_test(streams_take_turns),
        cmocka_unit_test(an_end_comes_behind_the_last_byte_and_leaves_the_other_direction),
        cmocka_unit_test(whoever_is_gone_is_sent_nothing_more),
        cmocka_unit_test(a_server_that_is_not_there_is_told),
        cmocka_unit_test(an_end_of_both_that_crosses_does_not_touch_the_next_stream),
        cmocka_unit_test(the_box_ends_both_while_the_host_opens_the_id_again),
        cmocka_unit_test(a_second_end_of_the_box_never_reaches_the_next_stream),
        cmocka_unit_test(a_second_end_of_the_box_is_told_while_bytes_are_outstanding),
        cmocka_unit_test(an_id_that_another_stream_has_is_known_by_its_life),
        cmocka_unit_test(there_are_so_many_streams_and_no_more),
        cmocka_unit_test(a_reset_ends_all_and_what_was_under_way_is_passed_over),
        cmocka_unit_test(the_hello_of_another_reset_is_none),
        cmocka_unit_test(a_box_that_was_started_anew_asks_for_a_reset),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
