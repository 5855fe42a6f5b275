/* SPDX-License-Identifier: Apache-2.0 */
/* test_mdns.c: the box's name in multicast DNS, byte by byte (RFC 6762; of names and records RFC 1035, section 4). */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "mdns.h"

#define NAME   "\x0bttfbox-0007\x05local\x00"
#define NAME_N 19
#define A      "\x00\x01"
#define AAAA   "\x00\x1c"
#define ANY    "\x00\xff"
#define PTR    "\x00\x0c"
#define IN     "\x00\x01"
#define QU     "\x80\x01"

static const struct mdns_host HOST = {.name = "ttfbox-0007", .address = {10, 60, 7, 1}};

/* A datagram, grown piece by piece. */
struct datagram {
    uint8_t data[600];
    size_t n;
};

static void add(struct datagram *d, const void *data, size_t n)
{
    assert_true(d->n + n <= sizeof d->data);
    memcpy(d->data + d->n, data, n);
    d->n += n;
}
#define ADD(d, text) add(d, text, sizeof(text) - 1)

/* A question of one name; further counts are 0. */
static struct datagram asks(const char *name, size_t n, const char *type, const char *class_)
{
    struct datagram d = {.n = 0};

    ADD(&d, "\x12\x34\x00\x00\x00\x01\x00\x00\x00\x00\x00\x00");
    add(&d, name, n);
    add(&d, type, 2);
    add(&d, class_, 2);
    return d;
}

static void is_answered(const struct datagram *d, bool legacy, enum mdns_to to, const void *wanted,
                        size_t n)
{
    uint8_t got[MDNS_SIZE], copy[600];
    size_t bytes = 0;

    memcpy(copy, d->data, d->n);
    assert_int_equal(mdns_answer(&HOST, copy, d->n, legacy, got, &bytes), to);
    assert_int_equal(bytes, n);
    if (n > 0)
        assert_memory_equal(got, wanted, n);
}

#define HEAD_OF_ANSWER  "\x00\x00\x84\x00\x00\x00\x00\x01\x00\x00\x00\x01"
#define ADDRESS         "\x00\x01\x80\x01\x00\x00\x00\x78\x00\x04\x0a\x3c\x07\x01"
#define NOTHING_ELSE    "\x00\x2f\x80\x01\x00\x00\x00\x78\x00\x05\xc0\x0c\x00\x01\x40"
#define WHOLE           HEAD_OF_ANSWER NAME ADDRESS "\xc0\x0c" NOTHING_ELSE
#define HEAD_OF_NOTHING "\x00\x00\x84\x00\x00\x00\x00\x01\x00\x00\x00\x00"

static void who_asks_for_the_address_is_told_it_and_that_there_is_no_other(void **state)
{
    struct datagram d = asks(NAME, NAME_N, A, IN);

    (void)state;
    is_answered(&d, false, MDNS_ALL, WHOLE, sizeof WHOLE - 1);
    d = asks(NAME, NAME_N, ANY, IN);
    is_answered(&d, false, MDNS_ALL, WHOLE, sizeof WHOLE - 1);
    d = asks("\x0bTTFBOX-0007\x05Local\x00", NAME_N, A, IN);
    is_answered(&d, false, MDNS_ALL, WHOLE, sizeof WHOLE - 1);
    d = asks(NAME, NAME_N, A, QU); /* an answer for itself alone */
    is_answered(&d, false, MDNS_ASKER, WHOLE, sizeof WHOLE - 1);
}

/* 6.2: with the address, for which it, or somebody else, asks in the next datagram; but for one that knows it. */
static void who_asks_for_another_kind_hears_that_there_is_none_and_the_address(void **state)
{
    static const char NOTHING[] = HEAD_OF_NOTHING NAME NOTHING_ELSE;
    struct datagram d = asks(NAME, NAME_N, AAAA, IN);

    (void)state;
    is_answered(&d, false, MDNS_ALL, WHOLE, sizeof WHOLE - 1);
    d = asks(NAME, NAME_N, AAAA, QU);
    is_answered(&d, false, MDNS_ASKER, WHOLE, sizeof WHOLE - 1);
    d = asks(NAME, NAME_N, AAAA, IN);
    d.data[7] = 1; /* an answer that who asks has */
    ADD(&d, "\xc0\x0c" A IN "\x00\x00\x00\x3c\x00\x04\x0a\x3c\x07\x01");
    is_answered(&d, false, MDNS_ALL_ELSE, NOTHING, sizeof NOTHING - 1);
}

static void other_names_are_none_of_its_business(void **state)
{
    static const struct {
        const char *name;
        size_t n;
    } OTHERS[] = {{"\x0bttfbox-0008\x05local\x00", 19},
                  {"\x0attfbox-000\x05local\x00", 18},
                  {"\x0bttfbox-0007\x00", 13},
                  {"\x0bttfbox-0007\x05local\x03lan\x00", 23},
                  {"\x01x\x0bttfbox-0007\x05local\x00", 21},
                  {"\x00", 1}};

    (void)state;
    for (size_t i = 0; i < sizeof OTHERS / sizeof *OTHERS; i++) {
        struct datagram d = asks(OTHERS[i].name, OTHERS[i].n, A, IN);

        is_answered(&d, false, MDNS_NOBODY, NULL, 0);
    }
}

static void a_name_may_stand_elsewhere(void **state)
{
    /* Two questions: the second is a label and a pointer to the first's "local". */
    struct datagram d = asks("\x05other\x05local\x00", 13, PTR, IN);

    (void)state;
    d.data[5] = 2;
    ADD(&d, "\x0bttfbox-0007\xc0\x12" A QU);
    is_answered(&d, false, MDNS_ASKER, WHOLE, sizeof WHOLE - 1);
}

static void what_is_known_is_not_told_again(void **state)
{
    struct datagram d = asks(NAME, NAME_N, A, IN);

    (void)state;
    d.data[7] = 1; /* an answer that who asks has */
    ADD(&d, "\xc0\x0c" A IN "\x00\x00\x00\x3c\x00\x04\x0a\x3c\x07\x01");
    is_answered(&d, false, MDNS_NOBODY, NULL, 0);
    d.data[d.n - 7] = 0x3b; /* of which less than half of its time is left */
    is_answered(&d, false, MDNS_ALL, WHOLE, sizeof WHOLE - 1);
    d.data[d.n - 7] = 0x3c;
    d.data[d.n - 1] = 2; /* another address */
    is_answered(&d, false, MDNS_ALL, WHOLE, sizeof WHOLE - 1);
}

/* nslookup and the like, which send from any port: number and question as they were, a short time, no top bit. */
static void who_knows_plain_dns_alone_is_answered_as_by_a_server(void **state)
{
    static const char WANTED[] = "\x12\x34\x84\x00\x00\x01\x00\x01\x00\x00\x00\x00" NAME A IN
                                 "\xc0\x0c" A IN "\x00\x00\x00\x0a\x00\x04\x0a\x3c\x07\x01";
    struct datagram d = asks(NAME, NAME_N, A, IN);

    (void)state;
    is_answered(&d, true, MDNS_ASKER, WANTED, sizeof WANTED - 1);
    d = asks(NAME, NAME_N, AAAA, IN);
    is_answered(&d, true, MDNS_NOBODY, NULL, 0);
}

static void what_is_no_question_is_passed_over(void **state)
{
    struct datagram d = asks(NAME, NAME_N, A, IN), cut;

    (void)state;
    for (size_t n = 0; n < d.n; n++) {
        cut = d;
        cut.n = n;
        is_answered(&cut, false, MDNS_NOBODY, NULL, 0);
    }
    cut = d;
    cut.data[2] = 0x80; /* an answer */
    is_answered(&cut, false, MDNS_NOBODY, NULL, 0);
    cut = d;
    cut.data[2] = 0x28; /* an update */
    is_answered(&cut, false, MDNS_NOBODY, NULL, 0);
    cut = d;
    cut.data[5] = 9; /* more questions than there are */
    is_answered(&cut, false, MDNS_NOBODY, NULL, 0);
    cut = asks("\xc0\x0c", 2, A, IN); /* a name that is itself */
    is_answered(&cut, false, MDNS_NOBODY, NULL, 0);
    cut = asks(NAME, NAME_N, A, "\x00\x03"); /* of another class */
    is_answered(&cut, false, MDNS_NOBODY, NULL, 0);
}

static void it_is_told_unasked_and_taken_back(void **state)
{
    static const char TOLD[] = HEAD_OF_NOTHING NAME ADDRESS;
    uint8_t got[MDNS_SIZE];

    (void)state;
    assert_int_equal(mdns_tell(&HOST, MDNS_TTL_S, got), sizeof TOLD - 1);
    assert_memory_equal(got, TOLD, sizeof TOLD - 1);
    assert_int_equal(mdns_tell(&HOST, 0, got), sizeof TOLD - 1);
    assert_memory_equal(got + 12 + NAME_N + 4, "\0\0\0\0", 4);
}

static void a_name_has_letters_digits_and_hyphens(void **state)
{
    char longest[65];

    (void)state;
    memset(longest, 'a', sizeof longest - 1);
    longest[64] = '\0';
    assert_false(mdns_is_name(longest));
    longest[63] = '\0';
    assert_true(mdns_is_name(longest));
    assert_true(mdns_is_name("ttfbox-10000000abcdef01"));
    assert_false(mdns_is_name(""));
    assert_false(mdns_is_name("ttfbox-a b"));
    assert_false(mdns_is_name("ttfbox-a.b"));
}

/* The longest name there may be fits into what is sent, in each way. */
static void the_longest_name_fits(void **state)
{
    char name[64], label[66];
    const struct mdns_host host = {.name = name, .address = {10, 0, 0, 1}};
    uint8_t got[MDNS_SIZE];
    struct datagram d;
    size_t n = 0;

    (void)state;
    memset(name, 'x', 63);
    name[63] = '\0';
    label[0] = 63;
    memcpy(label + 1, name, 63);
    d = asks(label, 64, A, IN);
    d.n = 12 + 64;
    ADD(&d, "\x05local\x00" A IN);
    assert_int_equal(mdns_answer(&host, d.data, d.n, false, got, &n), MDNS_ALL);
    assert_true(n <= sizeof got);
    assert_int_equal(mdns_answer(&host, d.data, d.n, true, got, &n), MDNS_ASKER);
    assert_true(n <= sizeof got);
}

/* As many questions of one long name as fit, each but the first by a pointer, and then ours: they are not read for a hostile host's sake. */
static void what_takes_too_long_to_read_is_not_read(void **state)
{
    static const uint8_t LABEL[] = {1, 'x'}, END[] = {0, 0, 1, 0, 1},
                         AGAIN[] = {0xc0, 12, 0, 1, 0, 1};
    static uint8_t data[9000];
    struct datagram first = asks("", 0, A, IN), ours = asks(NAME, NAME_N, A, IN);
    uint8_t got[MDNS_SIZE];
    size_t bytes = 0, n = 12, labels = 126;
    unsigned questions = 1;

    (void)state;
    memcpy(data, first.data, n);
    for (size_t i = 0; i < labels; i++, n += 2)
        memcpy(data + n, LABEL, sizeof LABEL);
    memcpy(data + n, END, sizeof END);
    n += sizeof END;
    for (; questions < 4500 / labels; questions++, n += 6)
        memcpy(data + n, AGAIN, sizeof AGAIN);
    memcpy(data + n, ours.data + 12, ours.n - 12); /* two labels */
    data[5] = (uint8_t)(questions + 1);
    assert_int_equal(mdns_answer(&HOST, data, n + ours.n - 12, false, got, &bytes), MDNS_ALL);
    memcpy(data + n, AGAIN, sizeof AGAIN);
    n += sizeof AGAIN;
    memcpy(data + n, ours.data + 12, ours.n - 12);
    data[5]++;
    assert_int_equal(mdns_answer(&HOST, data, n + ours.n - 12, false, got, &bytes), MDNS_NOBODY);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_takes_too_long_to_read_is_not_read),
        cmocka_unit_test(who_asks_for_the_address_is_told_it_and_that_there_is_no_other),
        cmocka_unit_test(who_asks_for_another_kind_hears_that_there_is_none_and_the_address),
        cmocka_unit_test(other_names_are_none_of_its_business),
        cmocka_unit_test(a_name_may_stand_elsewhere),
        cmocka_unit_test(what_is_known_is_not_told_again),
        cmocka_unit_test(who_knows_plain_dns_alone_is_answered_as_by_a_server),
        cmocka_unit_test(what_is_no_question_is_passed_over),
        cmocka_unit_test(it_is_told_unasked_and_taken_back),
        cmocka_unit_test(a_name_has_letters_digits_and_hyphens),
        cmocka_unit_test(the_longest_name_fits),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
