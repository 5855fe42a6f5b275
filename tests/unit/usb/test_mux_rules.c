/* SPDX-License-Identifier: Apache-2.0 */
/* test_mux_rules.c: transfers that break a rule of PROTOCOL.md, each by itself; bytes as the document has them. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include <errno.h>

#include "frames.h"
#include "pair.h"

struct made {
    uint8_t data[2 * 65536];
    size_t n;
};

static void frame(struct made *m, unsigned stream, unsigned type, const void *payload, size_t n)
{
    usb_frame_write(m->data + m->n, stream, (enum usb_frame_type)type, n);
    if (payload)
        memcpy(m->data + m->n + USB_HEADER, payload, n);
    else
        memset(m->data + m->n + USB_HEADER, 0, n);
    m->n += USB_HEADER + n;
}

static void number(struct made *m, unsigned stream, unsigned type, uint32_t value)
{
    uint8_t four[4];

    usb_put32(four, value);
    frame(m, stream, type, four, 4);
}

/* A box with stream 1 open. */
static void box_begin(struct pair *p)
{
    pair_begin(p);
    assert_int_equal(ttf_mux_open(p->host), 1);
    pair_settle(p);
}

/* The box refuses it, is left without streams, and is itself again after a reset. */
static void breaks(const char *what, const struct made *m)
{
    struct pair p;
    int r;

    box_begin(&p);
    r = ttf_mux_take(p.box, m->data, m->n);
    if (r != -EPROTO)
        fail_msg("%s: %d", what, r);
    if (ttf_mux_look(p.box, 1).open || ttf_mux_is_ready(p.box) || ttf_mux_has_transfer(p.box))
        fail_msg("%s: it goes on", what);
    ttf_mux_reset(p.box, 5);
    ttf_mux_reset(p.host, 5);
    pair_settle(&p);
    if (!ttf_mux_is_ready(p.box))
        fail_msg("%s: no reset helps", what);
    pair_end(&p);
}

static void shapes(void **state)
{
    static struct made m;

    (void)state;
    m.n = 0;
    breaks("no byte", &m);
    m.n = 4;
    breaks("half a header", &m);
    m.n = 0;
    frame(&m, 0, USB_FRAME_PAD, NULL, 120);
    breaks("a multiple of 64", &m);
    m.n = 0;
    frame(&m, 0, USB_FRAME_PAD, NULL, 65600);
    breaks("too long", &m);
    m.n = 0;
    frame(&m, 0, USB_FRAME_PAD, NULL, 10);
    m.n -= 1;
    breaks("a frame that is cut off", &m);
    m.n += 5;
    breaks("bytes that are no frame", &m);
}

static void frames_of_no_sense(void **state)
{
    static struct made m;

    (void)state;
    for (unsigned type = 0; type < 256; type++) {
        if (type >= USB_FRAME_HELLO && type <= USB_FRAME_PAD)
            continue;
        m.n = 0;
        frame(&m, 1, type, NULL, 4);
        breaks("an unknown type", &m);
    }
    m.n = 0;
    frame(&m, 0, USB_FRAME_PAD, NULL, 4);
    m.data[3] = 1;
    breaks("flags", &m);
    m.n = 0;
    frame(&m, 1, USB_FRAME_PAD, NULL, 4);
    breaks("a pad of a stream", &m);
    m.n = 0;
    frame(&m, 0, USB_FRAME_DATA, NULL, 4);
    breaks("data of stream 0", &m);
    m.n = 0;
    frame(&m, 1, USB_FRAME_DATA, NULL, 0);
    breaks("data without a byte", &m);
    m.n = 0;
    frame(&m, 1, USB_FRAME_DATA, NULL, 16385);
    breaks("too much data in a frame", &m);
    m.n = 0;
    frame(&m, 2, USB_FRAME_DATA, NULL, 4);
    breaks("data of a stream that is not open", &m);
    m.n = 0;
    frame(&m, 1, USB_FRAME_OPEN, NULL, 0);
    breaks("an id that is open", &m);
    m.n = 0;
    frame(&m, 33, USB_FRAME_OPEN, NULL, 0);
    breaks("an id that there is not", &m);
    m.n = 0;
    frame(&m, 2, USB_FRAME_OPEN, NULL, 1);
    breaks("an open with something in it", &m);
    m.n = 0;
    frame(&m, 1, USB_FRAME_CREDIT, NULL, 8);
    breaks("a credit of another length", &m);
    m.n = 0;
    number(&m, 1, USB_FRAME_CREDIT, 0x7fffffff);
    number(&m, 1, USB_FRAME_CREDIT, 0x7fffffff);
    breaks("credit without end", &m);
    m.n = 0;
    number(&m, 1, USB_FRAME_CLOSE, 4);
    breaks("an unknown reason", &m);
}

static void what_comes_behind_an_end(void **state)
{
    static struct made m;

    (void)state;
    m.n = 0;
    number(&m, 1, USB_FRAME_CLOSE, TTF_MUX_END);
    frame(&m, 1, USB_FRAME_DATA, "x", 1);
    breaks("data behind an end", &m);
    m.n = 0;
    number(&m, 1, USB_FRAME_CLOSE, TTF_MUX_END);
    number(&m, 1, USB_FRAME_CLOSE, TTF_MUX_END);
    breaks("an end twice", &m);
    m.n = 0;
    number(&m, 1, USB_FRAME_CLOSE, TTF_MUX_GONE);
    number(&m, 1, USB_FRAME_CLOSE, TTF_MUX_GONE);
    breaks("gone twice", &m);
}

static void a_hello_in_the_middle(void **state)
{
    static struct made m;
    uint8_t hello[16] = {1, 0, 32, 0, 0, 0, 4, 0, 77};

    (void)state;
    m.n = 0;
    frame(&m, 0, USB_FRAME_HELLO, hello, 16);
    breaks("hello once more", &m);
    memset(hello + 8, 0, 8);
    m.n = 0;
    frame(&m, 0, USB_FRAME_HELLO, hello, 16);
    breaks("a host that asks for a reset as a box would", &m);
}

static void more_than_the_window_is_not_taken(void **state)
{
    static struct made m;
    struct pair p;

    (void)state;
    box_begin(&p);
    m.n = 0;
    frame(&m, 1, USB_FRAME_DATA, NULL, 16384);
    for (unsigned i = 0; i < TTF_MUX_WINDOW / 16384; i++)
        assert_int_equal(ttf_mux_take(p.box, m.data, m.n), 0);
    assert_int_equal(ttf_mux_held(p.box), TTF_MUX_WINDOW);
    m.n = 0;
    frame(&m, 1, USB_FRAME_DATA, NULL, 1);
    assert_int_equal(ttf_mux_take(p.box, m.data, m.n), -EPROTO);
    pair_end(&p);
}

static void ends_and_credits_that_crossed_are_passed_over(void **state)
{
    static struct made m;
    struct pair p;

    (void)state;
    box_begin(&p);
    m.n = 0;
    number(&m, 9, USB_FRAME_CLOSE, TTF_MUX_GONE);
    number(&m, 9, USB_FRAME_CREDIT, 9);
    assert_int_equal(ttf_mux_take(p.box, m.data, m.n), 0);
    assert_true(ttf_mux_look(p.box, 1).open);
    pair_end(&p);
}

static void a_window_is_kept_also_if_it_is_tiny(void **state)
{
    static struct made m;
    uint8_t hello[16] = {1, 0, 1, 0, 5, 0, 0, 0, 9}, out[TTF_MUX_TRANSFER_MAX];
    struct ttf_mux *box;

    (void)state;
    if (ttf_mux_create(TTF_MUX_BOX, &box) < 0)
        return;
    ttf_mux_reset(box, 9);
    assert_int_equal(ttf_mux_give(box, out), 8);
    assert_int_equal(ttf_mux_give(box, out), 24);
    m.n = 0;
    frame(&m, 0, USB_FRAME_HELLO, hello, 16);
    frame(&m, 1, USB_FRAME_OPEN, NULL, 0);
    assert_int_equal(ttf_mux_take(box, m.data, m.n), 0);
    assert_true(ttf_mux_is_ready(box));
    assert_int_equal(ttf_mux_write(box, 1, "123456789", 9), 9);
    assert_int_equal(ttf_mux_give(box, out), 8 + 5);
    assert_int_equal(ttf_mux_give(box, out), 0);
    m.n = 0;
    number(&m, 1, USB_FRAME_CREDIT, 3);
    assert_int_equal(ttf_mux_take(box, m.data, m.n), 0);
    assert_int_equal(ttf_mux_give(box, out), 8 + 3);
    ttf_mux_destroy(box);
}

static void another_version_is_told_ours(void **state)
{
    static struct made m;
    uint8_t hello[16] = {2, 0, 1, 0, 5, 0, 0, 0, 9}, out[TTF_MUX_TRANSFER_MAX];
    struct ttf_mux *box;

    (void)state;
    if (ttf_mux_create(TTF_MUX_BOX, &box) < 0)
        return;
    ttf_mux_reset(box, 9);
    m.n = 0;
    frame(&m, 0, USB_FRAME_HELLO, hello, 16);
    assert_int_equal(ttf_mux_take(box, m.data, m.n), -EPROTONOSUPPORT);
    assert_int_equal(ttf_mux_give(box, out), 8);
    assert_int_equal(ttf_mux_give(box, out), 24);
    assert_int_equal(ttf_mux_give(box, out), 0);
    assert_int_equal(usb_hello_read(out + 8).version, 1);
    assert_int_equal(usb_hello_read(out + 8).nonce, 9);
    ttf_mux_destroy(box);
}

/* The bytes themselves: whoever writes the other side from the document gets on with this one. */
static void frames_are_the_bytes_of_the_document(void **state)
{
    struct pair p;
    uint8_t out[TTF_MUX_TRANSFER_MAX];
    const uint8_t expected[] = {1,   0,   2,   0, 0, 0, 0, 0, 1, 0, 3, 0, 3, 0, 0, 0,
                                'a', 'b', 'c', 1, 0, 5, 0, 4, 0, 0, 0, 0, 0, 0, 0};

    (void)state;
    pair_begin(&p);
    assert_int_equal(ttf_mux_open(p.host), 1);
    assert_int_equal(ttf_mux_write(p.host, 1, "abc", 3), 3);
    ttf_mux_end(p.host, 1, TTF_MUX_END);
    assert_int_equal(ttf_mux_give(p.host, out), sizeof expected);
    assert_memory_equal(out, expected, sizeof expected);
    pair_end(&p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shapes),
        cmocka_unit_test(frames_of_no_sense),
        cmocka_unit_test(what_comes_behind_an_end),
        cmocka_unit_test(a_hello_in_the_middle),
        cmocka_unit_test(more_than_the_window_is_not_taken),
        cmocka_unit_test(ends_and_credits_that_crossed_are_passed_over),
        cmocka_unit_test(a_window_is_kept_also_if_it_is_tiny),
        cmocka_unit_test(another_version_is_told_ours),
        cmocka_unit_test(frames_are_the_bytes_of_the_document),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
