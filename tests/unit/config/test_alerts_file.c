/* SPDX-License-Identifier: Apache-2.0 */
/* test_alerts_file.c: `alerts:` of ttfboxd's configuration. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/config/alerts_file.h"

static int parse(const char *text, struct ttf_alerts_config *ret, struct ttf_err *err)
{
    memset(err, 0, sizeof *err);
    return ttf_alerts_file_parse("/etc/ttfbox/d.yaml", text, strlen(text), ret, err);
}

static void every_key_reaches_its_field(void **state)
{
    struct ttf_alerts_config c;
    struct ttf_err err;

    (void)state;
    if (parse("board: whatever\nplan: [it, is]\ndata: data\nalerts:\n  hooks:\n"
              "    tell: {command: /bin/tell, from: alarm, timeout: 2s}\n"
              "    web: {webhook: 'https://example.org/x?t=1'}\n"
              "    post: {mail: me@example.org, program: /bin/send}\n"
              "    bus: {mqtt: ttfbox/alerts, host: broker}\n"
              "  parts: {daemon: /run/ttfbox/http.sock, preview: lock}\n"
              "  grace: 2s\n  begin: 3s\n  heartbeat: http://example.org/beat\n  every: 30s\n",
              &c, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_string_equal(c.data, "/etc/ttfbox/data");
    assert_int_equal(c.n_hooks, 4);
    assert_string_equal(c.hooks[0].name, "tell");
    assert_int_equal(c.hooks[0].kind, TTF_ALERT_COMMAND);
    assert_string_equal(c.hooks[0].target, "/bin/tell");
    assert_int_equal(c.hooks[0].from, TTF_ALERT_ALARM);
    assert_true(c.hooks[0].timeout_ns == 2 * TTF_NS_PER_S);
    assert_int_equal(c.hooks[1].kind, TTF_ALERT_WEBHOOK);
    assert_true(c.hooks[1].timeout_ns == 10 * TTF_NS_PER_S);
    assert_int_equal(c.hooks[1].from, TTF_ALERT_NOTICE);
    assert_string_equal(c.hooks[2].program, "/bin/send");
    assert_int_equal(c.hooks[2].kind, TTF_ALERT_MAIL);
    assert_string_equal(c.hooks[3].target, "ttfbox/alerts");
    assert_string_equal(c.hooks[3].host, "broker");
    assert_int_equal(c.n_parts, 2);
    assert_string_equal(c.parts[0].socket, "/run/ttfbox/http.sock");
    assert_string_equal(c.parts[1].name, "preview");
    assert_string_equal(c.parts[1].socket, "");
    assert_true(c.grace_ns == 2 * TTF_NS_PER_S);
    assert_true(c.begin_ns == 3 * TTF_NS_PER_S);
    assert_string_equal(c.heartbeat, "http://example.org/beat");
    assert_true(c.heartbeat_every_ns == 30 * TTF_NS_PER_S);
}

/* As ttfboxd reads the same file (test_daemon_file.c). */
static void state_is_where_the_daemon_keeps_it(void **state)
{
    static const char text[] = "board: rpi4\ndata: captures\nplan: p.yaml\n";
    struct ttf_alerts_config c;
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(ttf_alerts_file_parse("conf/d.yaml", text, strlen(text), &c, &err), 0);
    assert_string_equal(c.data, "conf/captures");
    assert_string_equal(c.state, "conf/captures/.ttfbox");
    assert_string_equal(c.plan, "conf/p.yaml");
}

static void without_alerts_nobody_is_told(void **state)
{
    struct ttf_alerts_config c;
    struct ttf_err err;

    (void)state;
    assert_int_equal(parse("data: /d\n", &c, &err), 0);
    assert_int_equal(c.n_hooks, 0);
    assert_string_equal(c.heartbeat, "");
    assert_true(c.begin_ns == TTF_NS_PER_MIN);
    assert_true(c.grace_ns == 5 * TTF_NS_PER_S);
}

static void what_is_the_daemons_is_read_as_far_as_it_can_be(void **state)
{
    struct ttf_alerts_config c;
    struct ttf_err err;

    (void)state;
    assert_int_equal(
        parse("data: d\nplan: plans/grass.yaml\nlisten: [\"127.0.0.1:8417\", unix:/run/x]\n", &c,
              &err),
        0);
    assert_string_equal(c.plan, "/etc/ttfbox/plans/grass.yaml");
    assert_string_equal(c.dataset, "grass");
    assert_string_equal(c.state, "/etc/ttfbox/d/.ttfbox");
    assert_string_equal(c.http_at, "/run/x");
    assert_int_equal(parse("data: /d\nplan: p.yaml\ndataset: moss\nstate: s\n", &c, &err), 0);
    assert_string_equal(c.dataset, "moss");
    assert_string_equal(c.state, "/etc/ttfbox/s");
    assert_string_equal(c.http_at, "/run/ttfbox/http.sock");
    assert_int_equal(parse("data: /d\nplan: [p]\nlisten: yes\nstate: {}\n", &c, &err), 0);
    assert_string_equal(c.plan, "");
    assert_string_equal(c.dataset, "");
    assert_string_equal(c.http_at, "");
}

static void what_is_wrong_is_refused_with_its_place(void **state)
{
    static const struct {
        const char *text, *where;
    } WRONG[] = {
        {"data: d\nalerts: {hooks: {a: {}}}\n", ":2:"},
        {"data: d\nalerts: {hooks: {a: {mail: x@y, mqtt: z}}}\n", ":2:"},
        {"data: d\nalerts: {hooks: {a: {command: tell}}}\n", ":2:"},
        {"data: d\nalerts: {hooks: {a: {webhook: 'file:///etc/passwd'}}}\n", ":2:"},
        {"data: d\nalerts: {hooks: {a: {mail: \"x@y\\nBcc: z@y\"}}}\n", ":2:"},
        {"data: d\nalerts: {hooks: {a: {mail: '-oQ/tmp@x'}}}\n", ":2:"},
        {"data: d\nalerts: {hooks: {A b: {mail: x@y}}}\n", ":2:"},
        {"data: d\nalerts: {hooks: {a: {mail: x@y, from: panic}}}\n", ":2:"},
        {"data: d\nalerts:\n  parts: {daemon: somewhere}\n", ":3:"},
        {"data: d\nalerts:\n  heartbeat: example.org\n", ":3:"},
        {"data: d\nalerts:\n  hoooks: {}\n", ":3:"},
        {"alerts: {}\n", ""},
    };
    struct ttf_alerts_config c;
    struct ttf_err err;

    (void)state;
    for (unsigned i = 0; i < sizeof WRONG / sizeof *WRONG; i++) {
        if (parse(WRONG[i].text, &c, &err) != -EINVAL)
            fail_msg("taken: %s", WRONG[i].text);
        if (!strstr(err.where, WRONG[i].where))
            fail_msg("%s: at '%s'", WRONG[i].text, err.where);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_reaches_its_field),
        cmocka_unit_test(state_is_where_the_daemon_keeps_it),
        cmocka_unit_test(without_alerts_nobody_is_told),
        cmocka_unit_test(what_is_the_daemons_is_read_as_far_as_it_can_be),
        cmocka_unit_test(what_is_wrong_is_refused_with_its_place),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
