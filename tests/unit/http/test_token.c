/* SPDX-License-Identifier: Apache-2.0 */
/* test_token.c: the box's secret and its file; sockets from texts. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "scratch.h"
#include "ttf/http/listen.h"
#include "ttf/http/token.h"

static void a_file_is_made_once_for_its_owner_alone(void **state)
{
    char first[TTF_HTTP_TOKEN_SIZE], again[TTF_HTTP_TOKEN_SIZE], other[TTF_HTTP_TOKEN_SIZE];
    struct stat st;

    (void)state;
    assert_int_equal(ttf_http_token_load("token", first, NULL), 0);
    assert_int_equal(strlen(first), 32);
    assert_int_equal(stat("token", &st), 0);
    assert_int_equal(st.st_mode & 0777, 0600);
    assert_int_equal(ttf_http_token_load("token", again, NULL), 0);
    assert_string_equal(first, again);
    assert_int_equal(ttf_http_token_make(other, NULL), 0);
    assert_string_not_equal(first, other);
}

static void a_token_that_others_can_read_or_that_is_none_is_refused(void **state)
{
    char token[TTF_HTTP_TOKEN_SIZE];

    (void)state;
    scratch_file("open", "0123456789abcdef\n", 17);
    assert_int_equal(chmod("open", 0644), 0);
    assert_int_equal(ttf_http_token_load("open", token, NULL), -EPERM);
    assert_int_equal(chmod("open", 0600), 0);
    assert_int_equal(ttf_http_token_load("open", token, NULL), 0);
    assert_string_equal(token, "0123456789abcdef");
    scratch_file("short", "012345\n", 7);
    assert_int_equal(chmod("short", 0600), 0);
    assert_int_equal(ttf_http_token_load("short", token, NULL), -EINVAL);
    assert_int_equal(ttf_http_token_load("no/such/folder", token, NULL), -ENOENT);
}

static void an_empty_file_as_a_power_cut_leaves_it_is_made_anew(void **state)
{
    char token[TTF_HTTP_TOKEN_SIZE], again[TTF_HTTP_TOKEN_SIZE];
    struct stat st;

    (void)state;
    scratch_file("token", "", 0);
    assert_int_equal(ttf_http_token_load("token", token, NULL), 0);
    assert_int_equal(stat("token", &st), 0);
    assert_int_equal(st.st_mode & 0777, 0600);
    assert_int_equal(ttf_http_token_read("token", again, NULL), 0);
    assert_string_equal(token, again);
}

static void one_that_was_made_here_is_shown_once(void **state)
{
    char token[TTF_HTTP_TOKEN_SIZE], again[TTF_HTTP_TOKEN_SIZE];

    (void)state;
    (void)unlink("token");
    assert_int_equal(ttf_http_token_load_to_show("token", token, NULL), 0);
    assert_true(ttf_http_token_waits("token", token));
    /* A restart shows nothing. */
    assert_int_equal(ttf_http_token_load_to_show("token", again, NULL), 0);
    assert_string_equal(token, again);
    assert_true(ttf_http_token_waits("token", token));
    assert_int_equal(ttf_http_token_show("token", token, NULL), 0);
    assert_false(ttf_http_token_waits("token", token));
    assert_int_equal(ttf_http_token_show("token", token, NULL), -EEXIST);
    assert_int_equal(ttf_http_token_load_to_show("token", again, NULL), 0);
    assert_string_equal(token, again);
    assert_int_equal(ttf_http_token_show("token", token, NULL), -EEXIST);
}

static void one_that_somebody_chose_is_never_shown(void **state)
{
    char token[TTF_HTTP_TOKEN_SIZE], made[TTF_HTTP_TOKEN_SIZE];

    (void)state;
    /* There before the box made any. */
    scratch_file("chosen", "0123456789abcdef\n", 17);
    assert_int_equal(chmod("chosen", 0600), 0);
    assert_int_equal(ttf_http_token_load_to_show("chosen", token, NULL), 0);
    assert_false(ttf_http_token_waits("chosen", token));
    assert_int_equal(ttf_http_token_show("chosen", token, NULL), -EEXIST);
    /* Written into the place of one that waits. */
    (void)unlink("token");
    assert_int_equal(ttf_http_token_load_to_show("token", made, NULL), 0);
    scratch_file("token", "fedcba9876543210\n", 17);
    assert_int_equal(ttf_http_token_load_to_show("token", token, NULL), 0);
    assert_string_equal(token, "fedcba9876543210");
    assert_int_equal(ttf_http_token_show("token", token, NULL), -EEXIST);
}

static void a_token_that_was_never_finished_is_not_shown_as_the_next_one(void **state)
{
    char first[TTF_HTTP_TOKEN_SIZE], token[TTF_HTTP_TOKEN_SIZE];

    (void)state;
    (void)unlink("token");
    assert_int_equal(ttf_http_token_load_to_show("token", first, NULL), 0);
    /* The power was cut before the token itself was there; or somebody took it away. */
    assert_int_equal(unlink("token"), 0);
    assert_int_equal(ttf_http_token_load_to_show("token", token, NULL), 0);
    assert_string_not_equal(first, token);
    assert_false(ttf_http_token_waits("token", first));
    assert_int_equal(ttf_http_token_show("token", token, NULL), 0);
}

static void what_is_no_address_is_refused(void **state)
{
    static const char *const TEXTS[] = {
        "",          "8417",       ":8417",           "local host:8417",
        "127.0.0.1", "127.0.0.1:", "127.0.0.1:65536", "127.0.0.1:8a",
        "[::1]",     "::1:80",     "256.1.1.1:80",    "unix:",
        NULL};
    struct ttf_http_socket s;

    (void)state;
    for (unsigned i = 0; TEXTS[i]; i++)
        if (ttf_http_listen(TEXTS[i], false, &s, NULL) != -EINVAL)
            fail_msg("'%s' is listened on", TEXTS[i]);
}

static void an_interface_stands_for_the_address_that_it_has(void **state)
{
    struct ttf_http_socket s;

    (void)state;
    assert_int_equal(ttf_http_listen("lo:0", false, &s, NULL), 0);
    assert_true(s.loopback);
    assert_memory_equal(s.name, "127.0.0.1:", 10);
    assert_int_equal(close(s.fd), 0);
    assert_int_equal(ttf_http_listen("nowhere0:8417", false, &s, NULL), -ENODEV);
    assert_int_equal(ttf_http_listen("localhost:8417", false, &s, NULL), -ENODEV);
}

static void a_socket_knows_its_port_and_whether_others_reach_it(void **state)
{
    struct ttf_http_socket local, all, second;

    (void)state;
    assert_int_equal(ttf_http_listen("127.0.0.1:0", false, &local, NULL), 0);
    assert_true(local.loopback);
    assert_null(strstr(local.name, ":0"));
    assert_int_equal(ttf_http_listen(local.name, false, &second, NULL), -EADDRINUSE);
    assert_int_equal(ttf_http_listen("0.0.0.0:0", false, &all, NULL), 0);
    assert_false(all.loopback);
    (void)close(local.fd);
    (void)close(all.fd);
}

static void a_socket_that_nobody_listens_on_is_replaced_and_no_other_file(void **state)
{
    struct ttf_http_socket s, second;
    struct stat st;

    (void)state;
    assert_int_equal(ttf_http_listen("unix:box", false, &s, NULL), 0);
    assert_int_equal(stat("box", &st), 0);
    assert_int_equal(st.st_mode & 0777, 0600);
    assert_int_equal(ttf_http_listen("unix:box", false, &second, NULL), -EADDRINUSE);
    (void)close(s.fd);
    assert_int_equal(ttf_http_listen("unix:box", false, &second, NULL), 0);
    (void)close(second.fd);
    scratch_file("file", "x", 1);
    assert_int_equal(ttf_http_listen("unix:file", false, &s, NULL), -EEXIST);
}

#define IN_A_FOLDER(test) cmocka_unit_test_setup_teardown(test, scratch_make, scratch_remove)

int main(void)
{
    const struct CMUnitTest tests[] = {
        IN_A_FOLDER(a_file_is_made_once_for_its_owner_alone),
        IN_A_FOLDER(a_token_that_others_can_read_or_that_is_none_is_refused),
        IN_A_FOLDER(an_empty_file_as_a_power_cut_leaves_it_is_made_anew),
        IN_A_FOLDER(one_that_was_made_here_is_shown_once),
        IN_A_FOLDER(one_that_somebody_chose_is_never_shown),
        IN_A_FOLDER(a_token_that_was_never_finished_is_not_shown_as_the_next_one),
        cmocka_unit_test(what_is_no_address_is_refused),
        cmocka_unit_test(an_interface_stands_for_the_address_that_it_has),
        cmocka_unit_test(a_socket_knows_its_port_and_whether_others_reach_it),
        IN_A_FOLDER(a_socket_that_nobody_listens_on_is_replaced_and_no_other_file),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
