/* SPDX-License-Identifier: Apache-2.0 */
/* test_session.c: cookies, whose request may change the box, and how often a wrong token may be tried. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <stdio.h>
#include <string.h>

#include "access.h"
#include "session.h"
#include "token_limits.h"
#include "ttf/hal/clock_backend.h"

#define TOKEN "0123456789abcdef"
#define HOST  "127.0.0.1:8417"

static const char *cookie_of(const char *token, char ret[160])
{
    char value[SESSION_SIZE];

    assert_int_equal(session_make(token, value, NULL), 0);
    (void)snprintf(ret, 160, "other=1; ttfbox-8417=%s; more=2", value);
    return ret;
}

static enum access_verdict decide(enum ttf_http_access needs, const struct access_said *said)
{
    return access_decide(needs, false, said, TOKEN);
}

static void a_cookie_is_worth_what_its_token_is(void **state)
{
    char cookie[160], value[SESSION_SIZE], name[SESSION_NAME_SIZE];

    (void)state;
    (void)cookie_of(TOKEN, cookie);
    assert_true(session_find(cookie, session_name(HOST, name), value));
    assert_true(session_valid(value, TOKEN));
    assert_false(session_valid(value, "0123456789abcdeg"));
    assert_false(session_valid(value, NULL));
    for (unsigned i = 0; i < SESSION_SIZE - 1; i++) {
        value[i] ^= 1;
        if (session_valid(value, TOKEN))
            fail_msg("changed at %u it is still taken", i);
        value[i] ^= 1;
    }
}

static void a_cookie_of_another_port_or_length_is_none_of_ours(void **state)
{
    static const char *const HEADERS[] = {
        "", "ttfbox-8417", "ttfbox-8417=", "ttfbox-8417=short", "; ;;", "ttfbox-84170=x", NULL};
    char cookie[160], value[SESSION_SIZE], name[SESSION_NAME_SIZE];

    (void)state;
    (void)cookie_of(TOKEN, cookie);
    assert_false(session_find(cookie, session_name("127.0.0.1:8418", name), value));
    assert_false(session_find(cookie, session_name("box.local", name), value));
    assert_string_equal(session_name("box.local", name), "ttfbox");
    assert_string_equal(session_name("[::1]:80", name), "ttfbox-80");
    assert_string_equal(session_name("[::1]", name), "ttfbox");
    assert_false(session_find(NULL, "ttfbox", value));
    for (unsigned i = 0; HEADERS[i]; i++)
        if (session_find(HEADERS[i], "ttfbox-8417", value))
            fail_msg("'%s' is taken", HEADERS[i]);
}

static void another_page_cannot_change_the_box(void **state)
{
    char cookie[160];
    const struct access_said mine = {.host = HOST,
                                     .cookie = cookie_of(TOKEN, cookie),
                                     .origin = "http://" HOST,
                                     .site = "same-origin",
                                     .marker = "1"};
    struct access_said said = mine;

    (void)state;
    assert_int_equal(decide(TTF_HTTP_CHANGE, &said), ACCESS_YES);
    said.site = NULL; /* an older browser */
    assert_int_equal(decide(TTF_HTTP_CHANGE, &said), ACCESS_YES);
    said.marker = NULL;
    assert_int_equal(decide(TTF_HTTP_CHANGE, &said), ACCESS_OTHER_PAGE);
    said = mine;
    said.origin = NULL;
    assert_int_equal(decide(TTF_HTTP_CHANGE, &said), ACCESS_OTHER_PAGE);
    said.origin = "http://127.0.0.1:8418";
    assert_int_equal(decide(TTF_HTTP_CHANGE, &said), ACCESS_OTHER_PAGE);
    said.origin = "null";
    assert_int_equal(decide(TTF_HTTP_CHANGE, &said), ACCESS_OTHER_PAGE);
    said = mine;
    said.site = "same-site";
    assert_int_equal(decide(TTF_HTTP_CHANGE, &said), ACCESS_OTHER_PAGE);
    assert_int_equal(decide(TTF_HTTP_TOKEN, &said), ACCESS_OTHER_PAGE); /* would light a lamp */
    said.site = "none";
    assert_int_equal(decide(TTF_HTTP_TOKEN, &said), ACCESS_YES);
}

static void a_socket_that_lets_all_read_lets_none_change(void **state)
{
    const struct access_said nobody = {.host = HOST};
    const struct access_said token = {.host = HOST, .authorization = "Bearer " TOKEN};

    (void)state;
    assert_int_equal(access_decide(TTF_HTTP_READ, true, &nobody, TOKEN), ACCESS_YES);
    assert_int_equal(access_decide(TTF_HTTP_READ, false, &nobody, TOKEN), ACCESS_NEEDS_TOKEN);
    assert_int_equal(access_decide(TTF_HTTP_TOKEN, true, &nobody, TOKEN), ACCESS_NEEDS_TOKEN);
    assert_int_equal(access_decide(TTF_HTTP_CHANGE, true, &nobody, TOKEN), ACCESS_NEEDS_TOKEN);
    assert_int_equal(access_decide(TTF_HTTP_OPEN, false, &nobody, TOKEN), ACCESS_YES);
    assert_int_equal(access_decide(TTF_HTTP_CHANGE, false, &token, TOKEN), ACCESS_YES);
    assert_int_equal(access_decide(TTF_HTTP_CHANGE, true, &token, NULL), ACCESS_NEEDS_TOKEN);
}

/* ---- how often ---- */

struct hand_clock {
    struct ttf_clock base; /* first */
    int64_t now_ns;
};

static int64_t hand_now_ns(struct ttf_clock *clock)
{
    return ((struct hand_clock *)clock)->now_ns;
}

static const struct sockaddr *address(const char *text, struct sockaddr_in6 *ret)
{
    struct sockaddr_in v4 = {.sin_family = AF_INET};

    memset(ret, 0, sizeof *ret);
    ret->sin6_family = AF_INET6;
    if (inet_pton(AF_INET6, text, &ret->sin6_addr) == 1)
        return (const struct sockaddr *)ret;
    assert_int_equal(inet_pton(AF_INET, text, &v4.sin_addr), 1);
    memcpy(ret, &v4, sizeof v4);
    return (const struct sockaddr *)ret;
}

static void more_wrong_tokens_of_an_address_than_are_allowed_are_told_so(void **state)
{
    static const struct ttf_clock_ops OPS = {.now_ns = hand_now_ns};
    struct hand_clock clock = {.base = {.ops = &OPS}, .now_ns = 1000 * TTF_NS_PER_S};
    struct limits *limits = limits_create(&clock.base);
    struct sockaddr_in6 a, b, c;

    (void)state;
    if (!limits) {
        fail();
        return;
    }
    (void)address("2001:db8::1", &a);
    (void)address("2001:db8::ffff", &b); /* of the same /64 */
    (void)address("192.168.7.9", &c);
    for (unsigned i = 0; i < LIMITS_AT_ONCE; i++) {
        assert_true(limits_wrong(limits, (struct sockaddr *)&a));
    }
    assert_false(limits_wrong(limits, (struct sockaddr *)&a));
    assert_false(limits_wrong(limits, (struct sockaddr *)&b));
    assert_true(limits_wrong(limits, (struct sockaddr *)&c));
    assert_true(limits_wrong(limits, NULL)); /* the cable */
    clock.now_ns += LIMITS_ONE_NS;
    assert_true(limits_wrong(limits, (struct sockaddr *)&a));
    assert_false(limits_wrong(limits, (struct sockaddr *)&a));
    clock.now_ns += 100 * LIMITS_ONE_NS;
    for (unsigned i = 0; i < LIMITS_AT_ONCE; i++) {
        assert_true(limits_wrong(limits, (struct sockaddr *)&a));
    }
    assert_false(limits_wrong(limits, (struct sockaddr *)&a));
    limits_destroy(limits);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_cookie_is_worth_what_its_token_is),
        cmocka_unit_test(a_cookie_of_another_port_or_length_is_none_of_ours),
        cmocka_unit_test(another_page_cannot_change_the_box),
        cmocka_unit_test(a_socket_that_lets_all_read_lets_none_change),
        cmocka_unit_test(more_wrong_tokens_of_an_address_than_are_allowed_are_told_so),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
