/* SPDX-License-Identifier: Apache-2.0 */
/* test_guests.c: which connection has to go when there are too many, and when a request that is never whole is given up. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <stdio.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "guests.h"
#include "ttf/hal/clock_backend.h"

#define PLACES 64u
#define MOST   56u
#define HALF   28u /* of one client */

struct hand_clock {
    struct ttf_clock base; /* first */
    int64_t now_ns;
};

static int64_t hand_now_ns(struct ttf_clock *clock)
{
    return ((struct hand_clock *)clock)->now_ns++;
}

static const struct ttf_clock_ops CLOCK_OPS = {.now_ns = hand_now_ns};
static struct hand_clock clock_of_hand;

struct pair {
    int ours, theirs; /* theirs sees whether it was shut down */
    struct guest *guest;
};

static struct guests *make(unsigned places)
{
    struct guests *guests;

    clock_of_hand = (struct hand_clock){.base.ops = &CLOCK_OPS, .now_ns = TTF_NS_PER_S};
    guests = guests_create(&clock_of_hand.base, places);
    assert_non_null(guests);
    return guests;
}

static void come(struct guests *guests, const char *from, struct pair *ret)
{
    struct sockaddr_in6 v6 = {.sin6_family = AF_INET6};
    struct sockaddr_in v4 = {.sin_family = AF_INET};
    const struct sockaddr *address = NULL;
    int fds[2];

    assert_int_equal(socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, fds), 0);
    ret->ours = fds[0];
    ret->theirs = fds[1];
    if (inet_pton(AF_INET, from, &v4.sin_addr) == 1)
        address = (const struct sockaddr *)&v4;
    else if (inet_pton(AF_INET6, from, &v6.sin6_addr) == 1)
        address = (const struct sockaddr *)&v6;
    ret->guest = guests_enter(guests, address, ret->ours);
}

static void come_all(struct guests *guests, const char *from, struct pair *pairs, unsigned n)
{
    for (unsigned i = 0; i < n; i++)
        come(guests, from, &pairs[i]);
}

static bool is_shut(const struct pair *pair)
{
    struct pollfd p = {.fd = pair->theirs, .events = POLLIN};

    return poll(&p, 1, 0) == 1;
}

static unsigned n_shut(const struct pair *pairs, unsigned n)
{
    unsigned shut = 0;

    for (unsigned i = 0; i < n; i++)
        shut += is_shut(&pairs[i]);
    return shut;
}

static void leave(struct pair *pairs, unsigned n)
{
    for (unsigned i = 0; i < n; i++) {
        guest_leaves(pairs[i].guest);
        (void)close(pairs[i].ours);
        (void)close(pairs[i].theirs);
    }
}

static void whoever_holds_most_makes_room_the_oldest_first(void **state)
{
    struct guests *guests = make(PLACES);
    struct pair many[HALF], some[HALF - 4], decent[4], next[2];

    (void)state;
    come_all(guests, "192.168.7.1", decent, 4);
    come_all(guests, "192.168.7.2", many, HALF);
    come_all(guests, "192.168.7.3", some, HALF - 4);
    assert_int_equal(n_shut(many, HALF) + n_shut(some, HALF - 4) + n_shut(decent, 4), 0);
    come_all(guests, "192.168.7.4", next, 2);
    assert_true(is_shut(&many[0]) && is_shut(&many[1]));
    assert_int_equal(n_shut(many, HALF), 2);
    assert_int_equal(n_shut(some, HALF - 4) + n_shut(decent, 4) + n_shut(next, 2), 0);
    leave(many, HALF);
    leave(some, HALF - 4);
    leave(decent, 4);
    leave(next, 2);
    guests_destroy(guests);
}

static void one_client_has_half_and_its_own_oldest_makes_room(void **state)
{
    struct guests *guests = make(PLACES);
    struct pair own[HALF + 1], other;

    (void)state;
    come(guests, "2001:db8:0:1::1", &other);
    come_all(guests, "2001:db8::1", own, HALF);
    come(guests, "2001:db8::ffff:1", &own[HALF]); /* the same /64 */
    assert_true(is_shut(&own[0]));
    assert_int_equal(n_shut(own, HALF + 1), 1);
    assert_false(is_shut(&other));
    for (unsigned i = 0; i <= HALF; i++)
        guest_is_answered(own[i].guest);
    leave(&own[0], 1);
    come(guests, "2001:db8::2", &own[0]); /* all of its are being answered */
    assert_null(own[0].guest);
    assert_true(is_shut(&own[0]));
    leave(own, HALF + 1);
    leave(&other, 1);
    guests_destroy(guests);
}

static void what_is_answered_goes_last_and_what_sleeps_never(void **state)
{
    struct guests *guests = make(PLACES);
    struct pair all[MOST + 2];
    char from[32];

    (void)state;
    for (unsigned i = 0; i < MOST; i++) {
        (void)snprintf(from, sizeof from, "10.0.0.%u", i);
        come(guests, from, &all[i]);
        if (i == 0)
            guest_sleeps(all[i].guest);
        else if (i != 20)
            guest_is_answered(all[i].guest);
    }
    come(guests, "10.0.1.1", &all[MOST]);
    assert_true(is_shut(&all[20]));
    assert_int_equal(n_shut(all, MOST + 1), 1);
    guest_is_answered(all[MOST].guest);
    come(guests, "10.0.1.2", &all[MOST + 1]);
    assert_true(is_shut(&all[1]));
    assert_int_equal(n_shut(all, MOST + 2), 2);
    leave(all, MOST + 2);
    guests_destroy(guests);
}

static void those_of_a_unix_socket_may_have_all(void **state)
{
    struct guests *guests = make(PLACES);
    struct pair all[MOST + 1];

    (void)state;
    come_all(guests, "", all, MOST);
    assert_int_equal(n_shut(all, MOST), 0);
    come(guests, "", &all[MOST]);
    assert_true(is_shut(&all[0]));
    assert_int_equal(n_shut(all, MOST + 1), 1);
    leave(all, MOST + 1);
    guests_destroy(guests);
}

static void places_of_those_who_left_are_free_again(void **state)
{
    struct guests *guests = make(PLACES);
    struct pair all[MOST];

    (void)state;
    for (unsigned round = 0; round < 10; round++) {
        come_all(guests, round % 2 ? "127.0.0.1" : "", all, HALF);
        come_all(guests, "127.0.0.2", all + HALF, MOST - HALF);
        assert_int_equal(n_shut(all, MOST), 0);
        leave(all, MOST);
    }
    guests_destroy(guests);
}

static void a_request_that_is_never_whole_is_given_up(void **state)
{
    struct guests *guests = make(PLACES);
    struct pair waits, body, answered;

    (void)state;
    come(guests, "127.0.0.1", &waits);
    come(guests, "127.0.0.1", &body);
    come(guests, "127.0.0.1", &answered);
    guest_reads_body(body.guest);
    guest_is_answered(answered.guest);
    clock_of_hand.now_ns += GUEST_HEADERS_NS - TTF_NS_PER_S;
    guests_tidy(guests);
    assert_false(is_shut(&waits));
    clock_of_hand.now_ns += TTF_NS_PER_S;
    guests_tidy(guests);
    assert_true(is_shut(&waits));
    assert_false(is_shut(&body));
    clock_of_hand.now_ns += GUEST_BODY_NS - GUEST_HEADERS_NS;
    guests_tidy(guests);
    assert_true(is_shut(&body));
    assert_false(is_shut(&answered));
    guest_waits(answered.guest); /* its time begins now */
    guests_tidy(guests);
    assert_false(is_shut(&answered));
    leave(&waits, 1);
    leave(&body, 1);
    leave(&answered, 1);
    guests_destroy(guests);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(whoever_holds_most_makes_room_the_oldest_first),
        cmocka_unit_test(one_client_has_half_and_its_own_oldest_makes_room),
        cmocka_unit_test(what_is_answered_goes_last_and_what_sleeps_never),
        cmocka_unit_test(those_of_a_unix_socket_may_have_all),
        cmocka_unit_test(places_of_those_who_left_are_free_again),
        cmocka_unit_test(a_request_that_is_never_whole_is_given_up),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
