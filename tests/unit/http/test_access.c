/* SPDX-License-Identifier: Apache-2.0 */
/* test_access.c: which names and tokens are let in. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "access.h"

static const char *const NAMES[] = {"ttfbox-0042.local", "greenhouse", NULL};

static void addresses_and_the_box_s_own_names_are_let_in(void **state)
{
    static const char *const HOSTS[] = {
        "127.0.0.1",         "127.0.0.1:8417", "192.168.7.1:80",        "[::1]:8417",
        "[fe80::1]",         "localhost",      "LocalHost:8417",        "greenhouse:1",
        "TTFBOX-0042.local", "localhost.",     "ttfbox-0042.local.:80", NULL};

    (void)state;
    for (unsigned i = 0; HOSTS[i]; i++)
        if (!access_host(HOSTS[i], NAMES))
            fail_msg("'%s' is refused", HOSTS[i]);
    assert_true(access_host("localhost", NULL));
}

static void a_name_that_was_made_to_point_here_is_not(void **state)
{
    static const char *const HOSTS[] = {"evil.example",
                                        "evil.example:8417",
                                        "",
                                        ":80",
                                        "[::1",
                                        "[::1]x",
                                        "127.0.0.1.evil.example",
                                        "greenhouse.evil.example",
                                        "localhost@evil.example",
                                        "1",
                                        NULL};

    (void)state;
    for (unsigned i = 0; HOSTS[i]; i++)
        if (access_host(HOSTS[i], NAMES))
            fail_msg("'%s' is let in", HOSTS[i]);
    assert_false(access_host(NULL, NAMES));
    assert_false(access_host("greenhouse", NULL));
}

static void only_the_whole_token_opens(void **state)
{
    (void)state;
    assert_true(access_token("Bearer 0123456789abcdef", "0123456789abcdef"));
    assert_true(access_token("bearer 0123456789abcdef", "0123456789abcdef"));
    assert_false(access_token("Bearer 0123456789abcde", "0123456789abcdef"));
    assert_false(access_token("Bearer 0123456789abcdeg", "0123456789abcdef"));
    assert_false(access_token("Bearer 0123456789abcdef0", "0123456789abcdef"));
    assert_false(access_token("Bearer ", "0123456789abcdef"));
    assert_false(access_token("0123456789abcdef", "0123456789abcdef"));
    assert_false(access_token(NULL, "0123456789abcdef"));
}

static void without_a_token_nothing_opens(void **state)
{
    (void)state;
    assert_false(access_token("Bearer ", NULL));
    assert_false(access_token(NULL, NULL));
}

static void what_is_had_at_the_cable_is_had_there_alone_and_by_no_other_page(void **state)
{
    struct access_said said = {.host = "localhost", .marker = "1"};
    struct access_said with_token = {
        .host = "localhost", .marker = "1", .authorization = "Bearer 0123456789abcdef"};

    (void)state;
    assert_int_equal(access_decide(TTF_HTTP_CABLE, true, &said, "0123456789abcdef"), ACCESS_YES);
    assert_int_equal(access_decide(TTF_HTTP_CABLE, false, &said, "0123456789abcdef"),
                     ACCESS_ELSEWHERE);
    assert_int_equal(access_decide(TTF_HTTP_CABLE, false, &with_token, "0123456789abcdef"),
                     ACCESS_ELSEWHERE);
    said.site = "same-origin";
    assert_int_equal(access_decide(TTF_HTTP_CABLE, true, &said, "0123456789abcdef"), ACCESS_YES);
    said.site = "cross-site";
    assert_int_equal(access_decide(TTF_HTTP_CABLE, true, &said, "0123456789abcdef"),
                     ACCESS_OTHER_PAGE);
    said.site = NULL;
    said.marker = NULL;
    assert_int_equal(access_decide(TTF_HTTP_CABLE, true, &said, "0123456789abcdef"),
                     ACCESS_OTHER_PAGE);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(addresses_and_the_box_s_own_names_are_let_in),
        cmocka_unit_test(a_name_that_was_made_to_point_here_is_not),
        cmocka_unit_test(only_the_whole_token_opens),
        cmocka_unit_test(without_a_token_nothing_opens),
        cmocka_unit_test(what_is_had_at_the_cable_is_had_there_alone_and_by_no_other_page),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
