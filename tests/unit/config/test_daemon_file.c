/* SPDX-License-Identifier: Apache-2.0 */
/* test_daemon_file.c: the configuration of ttfboxd. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "ttf/base/attr.h"
#include "ttf/base/time.h"
#include "ttf/config/daemon_file.h"

static int parse(const char *text, struct ttf_daemon_config *ret, struct ttf_err *err)
{
    memset(err, 0, sizeof *err);
    return ttf_daemon_file_parse("/etc/ttfbox/d.yaml", text, strlen(text), ret, err);
}

static void every_key_reaches_its_field(void **state)
{
    struct ttf_daemon_config c;
    struct ttf_err err;

    (void)state;
    if (parse("board: ../boards/mine.yaml\nplan: plans/grass.yaml\ndata: /var/lib/ttfbox\n"
              "dataset: meadow\ncalibration: cal\nzone: UTC\nthreads: 3\nretry: 2s\n"
              "state: s\ntoken_file: secret\nlisten: ['[::1]:80', 'unix:/x']\nnames: [greenhouse]\n"
              "set: {sim.clock: real, sim.faults: '[{kind: power-cut, at: 3h}]'}\n",
              &c, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_string_equal(c.board, "/etc/ttfbox/../boards/mine.yaml");
    assert_string_equal(c.plan, "/etc/ttfbox/plans/grass.yaml");
    assert_string_equal(c.data, "/var/lib/ttfbox");
    assert_string_equal(c.dataset, "/var/lib/ttfbox/meadow");
    assert_string_equal(c.calibration, "/etc/ttfbox/cal");
    assert_int_equal(c.threads, 3);
    assert_true(c.retry_ns == 2 * TTF_NS_PER_S);
    assert_string_equal(c.zone, "UTC");
    assert_string_equal(c.state, "/etc/ttfbox/s");
    assert_string_equal(c.token_file, "/etc/ttfbox/secret");
    assert_int_equal(c.n_listen, 2);
    assert_string_equal(c.listen[0], "[::1]:80");
    assert_string_equal(c.listen[1], "unix:/x");
    assert_int_equal(c.n_names, 1);
    assert_string_equal(c.names[0], "greenhouse");
    assert_int_equal(c.n_sets, 2);
    assert_string_equal(c.set[1].path, "sim.faults");
    assert_string_equal(c.set[1].value, "[{kind: power-cut, at: 3h}]");
}

static void a_dataset_without_a_name_has_the_plan_s(void **state)
{
    struct ttf_daemon_config c;
    struct ttf_err err;

    (void)state;
    assert_int_equal(parse("board: rpi4\nplan: grass.yaml\ndata: /d\n", &c, &err), 0);
    assert_string_equal(c.dataset, "/d/grass");
    assert_string_equal(c.board, "rpi4"); /* a name, not a path */
    assert_true(c.retry_ns == 5 * TTF_NS_PER_S);
    assert_int_equal(parse("board: rpi4\nplan: /x/week\ndata: /d\n", &c, &err), 0);
    assert_string_equal(c.dataset, "/d/week");
}

/* What is not said lies in the data folder, wherever the file and whoever reads it. */
static void a_file_named_from_here_puts_its_state_into_its_data(void **state)
{
    static const char text[] = "board: rpi4\ndata: captures\n";
    struct ttf_daemon_config c;
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(ttf_daemon_file_parse("conf/d.yaml", text, strlen(text), &c, &err), 0);
    assert_string_equal(c.data, "conf/captures");
    assert_string_equal(c.state, "conf/captures/.ttfbox");
    assert_string_equal(c.token_file, "conf/captures/.ttfbox/token");
}

static void without_a_plan_runs_are_asked_for(void **state)
{
    struct ttf_daemon_config c;
    struct ttf_err err;

    (void)state;
    assert_int_equal(parse("board: rpi4\ndata: /d\n", &c, &err), 0);
    assert_string_equal(c.plan, "");
    assert_string_equal(c.dataset, "");
    assert_string_equal(c.state, "/d/.ttfbox");
    assert_string_equal(c.token_file, "/d/.ttfbox/token");
    assert_int_equal(c.n_listen, 3); /* this machine, and the cable: its streams, its network */
    assert_true(c.listen_as_ever);
    assert_string_equal(c.listen[0], "127.0.0.1:8417");
    assert_string_equal(c.listen[1], "unix:/run/ttfbox/http.sock");
    assert_string_equal(c.listen[2], "usb0:8417");
    assert_int_equal(parse("board: rpi4\ndata: /d\nlisten: []\n", &c, &err), 0);
    assert_int_equal(c.n_listen, 0);
    assert_false(c.listen_as_ever);
}

static const struct {
    const char *text, *where, *what;
} WRONG[] = {
    {"", "/etc/ttfbox/d.yaml:1:1", "empty"},
    {"- 1\n", "/etc/ttfbox/d.yaml:1:1", "holds keys"},
    {"board: b\nplan: p\n", "/etc/ttfbox/d.yaml:1:1", "'data' is missing"},
    {"board: b\nplan: p\ndata: d\nlisen: 1\n", "/etc/ttfbox/d.yaml:4:1", "unknown key"},
    {"board: b\nplan: p\ndata: d\nlisten: 1\n", "/etc/ttfbox/d.yaml:4:9", "a list is meant"},
    {"board: b\ndata: d\nlisten: [a, b, c, d, e, f, g, h, i]\n", "/etc/ttfbox/d.yaml:3:34",
     "more than 8"},
    {"board: b\ndata: d\nnames: ['']\n", "/etc/ttfbox/d.yaml:3:9", "1 to 127 letters"},
    {"board: b\ndata: d\ndataset: grass\n", "/etc/ttfbox/d.yaml:3:10", "without a plan"},
    {"board: b\nplan: p\ndata: d\ndataset: ../x\n", "/etc/ttfbox/d.yaml:4:10", "no dataset's name"},
    {"board: b\nplan: p\ndata: d\ndataset: a/b\n", "/etc/ttfbox/d.yaml:4:10", "no dataset's name"},
    {"board: b\nplan: p\ndata: d\nset: real\n", "/etc/ttfbox/d.yaml:4:6", "a map of at most 16"},
    {"board: b\nplan: p\ndata: d\ndataset: .x\n", "/etc/ttfbox/d.yaml:4:10", "no dataset's name"},
    {"board: b\nplan: p\ndata: d\n"
     "dataset: 0123456789012345678901234567890123456789012345678901234567890123x\n",
     "/etc/ttfbox/d.yaml:4:10", "no dataset's name"},
    {"board: b\nplan: p/.yaml\ndata: d\n", "/etc/ttfbox/d.yaml:2:7", "no dataset's name"},
    {"board: b\nplan: p\ndata: d\nretry: 5\n", "/etc/ttfbox/d.yaml:4:8", "has no unit"},
    {"board: b\nplan: p\ndata: d\nzone: Moon/Tycho\n", "/etc/ttfbox/d.yaml:4:7",
     "no time zone 'Moon/Tycho'"},
    {"board: b\nplan: p\ndata: d\nretry: 1ms\n", "/etc/ttfbox/d.yaml:4:8", "out of its range"},
    {"board: b\nplan: p\ndata: d\nset: {sim: {seed: 1}}\n", "/etc/ttfbox/d.yaml:4:12", "one value"},
};

static void what_is_wrong_is_named_with_its_place(void **state)
{
    (void)state;
    for (unsigned i = 0; i < TTF_COUNT_OF(WRONG); i++) {
        struct ttf_daemon_config c;
        struct ttf_err err;

        if (parse(WRONG[i].text, &c, &err) != -EINVAL)
            fail_msg("accepted:\n%s", WRONG[i].text);
        if (strcmp(err.where, WRONG[i].where) != 0 || !strstr(err.what, WRONG[i].what))
            fail_msg("%s\n-> %s: %s; %s", WRONG[i].text, err.where, err.what, err.hint);
    }
}

static void expect_refused(const char *text, const char *what)
{
    struct ttf_daemon_config c;
    struct ttf_err err;

    assert_int_equal(parse(text, &c, &err), -EINVAL);
    if (!strstr(err.what, what))
        fail_msg("%s: %s", err.where, err.what);
}

/* Each by one more than there is room for. */
static void what_has_no_room_is_refused(void **state)
{
    static const char HEAD[] = "board: b\nplan: p\ndata: d\nset: {";
    char text[2048], letters[300] = "";
    struct ttf_daemon_config c;
    struct ttf_err err;
    int n;

    (void)state;
    memset(letters, 'x', sizeof c.set[0].value);
    (void)snprintf(text, sizeof text, "%sa: %s}\n", HEAD, letters);
    expect_refused(text, "too long");
    letters[sizeof c.set[0].value - 1] = '\0';
    (void)snprintf(text, sizeof text, "%sa: %s}\n", HEAD, letters);
    assert_int_equal(parse(text, &c, &err), 0);
    memset(letters, 'k', sizeof c.set[0].path);
    letters[sizeof c.set[0].path] = '\0';
    (void)snprintf(text, sizeof text, "%s%s: 1}\n", HEAD, letters);
    expect_refused(text, "no key of a board");
    n = snprintf(text, sizeof text, "%s", HEAD);
    for (int i = 0; i <= TTF_DAEMON_SETS_MAX; i++)
        n += snprintf(text + n, sizeof text - (size_t)n, "k%d: 1, ", i);
    (void)snprintf(text + n, sizeof text - (size_t)n, "}\n");
    expect_refused(text, "at most 16 keys");
}

static int parse_board(const char *text, struct ttf_daemon_config *ret, struct ttf_err *err)
{
    memset(err, 0, sizeof *err);
    return ttf_daemon_file_parse_board("/etc/ttfbox/d.yaml", text, strlen(text), ret, err);
}

/* Each keeps the daemon from starting, and must not keep the lamp guardian from it. */
static void the_board_is_read_whatever_mistakes_are_elsewhere(void **state)
{
    static const char *const MISTAKES[] = {
        "retry: soon\n",           "zone: Atlantis/Deep\n", "planned: x\n",    "threads: [1, 2]\n",
        "dataset: ../elsewhere\n", "plan: {a: b}\n",        "data:\nplan: p\n"};
    struct ttf_daemon_config c;
    struct ttf_err err;
    char text[256];

    (void)state;
    for (size_t i = 0; i < TTF_COUNT_OF(MISTAKES); i++) {
        (void)snprintf(text, sizeof text, "%sset: {sim.clock: real}\nboard: boards/mine.yaml\n",
                       MISTAKES[i]);
        assert_int_equal(parse(text, &c, &err), -EINVAL);
        if (parse_board(text, &c, &err) < 0)
            fail_msg("%s: %s: %s", MISTAKES[i], err.where, err.what);
        assert_string_equal(c.board, "/etc/ttfbox/boards/mine.yaml");
        assert_int_equal(c.n_sets, 1);
        assert_string_equal(c.set[0].path, "sim.clock");
        assert_string_equal(c.set[0].value, "real");
    }
}

static void a_mistake_in_the_board_itself_is_still_refused(void **state)
{
    static const char *const MISTAKES[] = {"plan: p\ndata: d\n", "board:\n", "board: [a]\n",
                                           "board: b\nset: real\n", "board: b\nplan: 'p\n"};
    struct ttf_daemon_config c;
    struct ttf_err err;

    (void)state;
    for (size_t i = 0; i < TTF_COUNT_OF(MISTAKES); i++)
        assert_int_equal(parse_board(MISTAKES[i], &c, &err), -EINVAL);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_reaches_its_field),
        cmocka_unit_test(a_dataset_without_a_name_has_the_plan_s),
        cmocka_unit_test(a_file_named_from_here_puts_its_state_into_its_data),
        cmocka_unit_test(without_a_plan_runs_are_asked_for),
        cmocka_unit_test(what_has_no_room_is_refused),
        cmocka_unit_test(what_is_wrong_is_named_with_its_place),
        cmocka_unit_test(the_board_is_read_whatever_mistakes_are_elsewhere),
        cmocka_unit_test(a_mistake_in_the_board_itself_is_still_refused),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
