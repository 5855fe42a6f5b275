/* SPDX-License-Identifier: Apache-2.0 */
/* Plans from YAML: what is right is understood, what is wrong is named with its place. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/attr.h"
#include "ttf/base/time.h"
#include "ttf/config/board_file.h"
#include "ttf/config/plan_file.h"
#include "ttf/hal/sim.h"

static struct ttf_plan_file *parse(const char *text)
{
    struct ttf_plan_file *file = NULL;
    struct ttf_err err = {0};

    if (ttf_plan_file_parse("p.yaml", text, strlen(text), &file, &err) != 0)
        fail_msg("%s: %s; %s", err.where, err.what, err.hint);
    return file;
}

static const char WHOLE[] = "title: Grass\n"
                            "interval: 10min\n"
                            "count: 1008\n"
                            "start: 2026-03-01T08:00:00Z\n"
                            "zone: UTC\n"
                            "lamps: {mode: photoperiod, settle: 20s, day: 16h, period: 24h,\n"
                            "        day_start: \"06:30\", day_levels: {left: 50%}}\n"
                            "shots:\n"
                            "  - stream: raking-left\n"
                            "    channel: raking-left\n"
                            "    lamps: {left: 400permille}\n"
                            "    exposure: 40ms\n"
                            "    gain: 1.5\n"
                            "    white_balance: {red: 1.8, blue: 1.25}\n"
                            "    lens: 2.5dpt\n"
                            "  - exposure: 20ms\n"
                            "    lamps: {left: 100%, right: 100%}\n"
                            "    brackets: [0.25, 1, 4]\n"
                            "    average: 8\n"
                            "mains: 60Hz\n"
                            "region: {x: 8px, y: 16, width: 640px, height: 480}\n"
                            "reference: {x: 1, y: 2, width: 3, height: 4}\n"
                            "keep: both\n"
                            "mm_per_px: 0.05\n"
                            "reserve: 2GiB\n"
                            "storage: {second: /mnt/usb}\n"
                            "group: grass.1\n";

static void every_key_reaches_its_field(void **state)
{
    struct ttf_plan_file *file = parse(WHOLE);
    const struct ttf_plan *p = ttf_plan_file_plan(file);

    (void)state;
    assert_string_equal(p->title, "Grass");
    assert_true(p->interval_ns == 10 * TTF_NS_PER_MIN);
    assert_int_equal(p->count, 1008);
    assert_true(p->start_utc_ns == INT64_C(1772352000) * TTF_NS_PER_S);
    assert_int_equal(p->lamps, TTF_LAMPS_PHOTOPERIOD);
    assert_true(p->settle_ns == 20 * TTF_NS_PER_S);
    assert_true(p->day_ns == 16 * TTF_NS_PER_H && p->period_ns == TTF_NS_PER_DAY);
    assert_true(p->photoperiod_local);
    assert_int_equal(p->day_start_s, 6 * 3600 + 30 * 60);
    assert_int_equal(p->n_day_levels, 1);
    assert_int_equal(p->day_levels[0].permille, 500);
    assert_int_equal(p->n_shots, 2);
    assert_string_equal(p->shots[0].stream, "raking-left");
    assert_int_equal(p->shots[0].levels[0].permille, 400);
    assert_true(p->shots[0].exposure.exposure_ns == 40 * TTF_NS_PER_MS);
    assert_int_equal(p->shots[0].exposure.gain_milli, 1500);
    assert_int_equal(p->shots[0].exposure.wb_r_milli, 1800);
    assert_int_equal(p->shots[0].exposure.wb_b_milli, 1250);
    assert_int_equal(p->shots[0].exposure.lens_mdpt, 2500);
    assert_string_equal(p->shots[1].stream, "main");
    assert_string_equal(p->shots[1].camera, "main");
    assert_int_equal(p->shots[1].exposure.gain_milli, 1000);
    assert_int_equal(p->shots[1].n_levels, 2);
    assert_int_equal(p->shots[1].n_brackets, 3);
    assert_true(p->shots[1].brackets[2] == 4);
    assert_int_equal(p->shots[1].average, 8);
    assert_true(p->mains_hz == 60);
    assert_int_equal(p->region.width, 640);
    assert_int_equal(p->region.y, 16);
    assert_int_equal(p->reference.height, 4);
    assert_int_equal(p->keep, TTF_KEEP_BOTH);
    assert_true(p->mm_per_px == 0.05);
    assert_true(p->reserve_bytes == INT64_C(2147483648));
    assert_string_equal(p->second_storage, "/mnt/usb");
    assert_string_equal(p->group, "grass.1");
    assert_string_equal(ttf_plan_file_text(file), WHOLE);
    ttf_plan_file_free(file);
}

static void a_box_s_zone_is_that_of_a_plan_which_names_none(void **state)
{
    static const char NONE[] = "interval: 1min\ncount: 3\n",
                      NAMED[] = "interval: 1min\ncount: 3\nzone: UTC\n";
    struct ttf_plan_file *file = NULL;

    (void)state;
    assert_int_equal(ttf_plan_file_parse("p.yaml", NONE, sizeof NONE - 1, &file, NULL), 0);
    ttf_plan_file_default_zone(file, "");
    assert_string_equal(ttf_plan_file_plan(file)->zone, "UTC");
    ttf_plan_file_default_zone(file, "Europe/Berlin");
    assert_string_equal(ttf_plan_file_plan(file)->zone, "Europe/Berlin");
    ttf_plan_file_free(file);
    file = NULL;
    assert_int_equal(ttf_plan_file_parse("p.yaml", NAMED, sizeof NAMED - 1, &file, NULL), 0);
    ttf_plan_file_default_zone(file, "Europe/Berlin");
    assert_string_equal(ttf_plan_file_plan(file)->zone, "UTC");
    ttf_plan_file_free(file);
}

static void until_counts_the_slots_before_it(void **state)
{
    static const struct {
        const char *text;
        int64_t count;
    } CASES[] = {
        {"interval: 10min\nuntil: 7d\n", 1008},
        {"interval: 10min\nuntil: 15min\n", 2},
        {"interval: 10min\nuntil: 1min\n", 1},
        {"interval: 1h\nstart: 2026-03-01T08:00:00Z\nuntil: 2026-03-01T11:00:00Z\n", 3},
    };

    (void)state;
    for (unsigned i = 0; i < TTF_COUNT_OF(CASES); i++) {
        struct ttf_plan_file *file = parse(CASES[i].text);

        assert_int_equal(ttf_plan_file_plan(file)->count, CASES[i].count);
        ttf_plan_file_free(file);
    }
}

#define P "interval: 10min\ncount: 10\n"

static void a_start_that_has_passed_is_refused_with_its_line(void **state)
{
    struct ttf_plan_file *file = parse(P "start: 2026-03-01T08:00:00Z\n");
    struct ttf_utc now = {.trust = TTF_TRUST_RTC, .uncertainty_ns = TTF_NS_PER_S};
    struct ttf_err err = {0};

    (void)state;
    now.utc_ns = ttf_plan_file_plan(file)->start_utc_ns - TTF_NS_PER_S;
    assert_int_equal(ttf_plan_file_check_start(file, &now, &err), 0);
    now.utc_ns += 2 * TTF_NS_PER_S; /* may still be before it, for all the clock knows */
    assert_int_equal(ttf_plan_file_check_start(file, &now, &err), 0);
    now.utc_ns += 1;
    assert_int_equal(ttf_plan_file_check_start(file, &now, &err), -EINVAL);
    assert_string_equal(err.where, "p.yaml:3:8");
    assert_non_null(strstr(err.what, "2026-03-01"));
    now.trust = TTF_TRUST_NONE;
    assert_int_equal(ttf_plan_file_check_start(file, &now, &err), 0);
    ttf_plan_file_free(file);
    file = parse(P "start: 1970-01-01T00:00:00Z\n"); /* an instant as any other */
    now.trust = TTF_TRUST_RTC;
    assert_int_equal(ttf_plan_file_check_start(file, &now, &err), -EINVAL);
    ttf_plan_file_free(file);
    file = parse(P);
    assert_int_equal(ttf_plan_file_check_start(file, &now, &err), 0);
    ttf_plan_file_free(file);
}

/* Each wrong plan: where it is said to be wrong, and words of what and of the hint. */
static const struct {
    const char *text, *where, *what, *hint;
} WRONG[] = {
    /* the kinds that a person makes most */
    {"interval: 10\ncount: 5\n", "p.yaml:1:11", "interval: '10' has no unit", "10s"},
    {P "intervall: 5min\n", "p.yaml:3:1", "intervall: unknown key", "'interval'"},
    {"interval: -10min\ncount: 5\n", "p.yaml:1:11", "-10min", "from 100ms"},
    {"interval: nan\ncount: 5\n", "p.yaml:1:11", "'nan' is not a time", "10min"},
    {"interval: 99999999999999999999d\ncount: 5\n", "p.yaml:1:11", "far too large", ""},
    {"", "p.yaml:1:1", "the file is empty", "interval"},
    {"interval: 10min\n  count: [5\n", "p.yaml:2", "not YAML", "key: value"},
    {"# only a comment\n", "p.yaml:1:1", "the file is empty", "interval"},
    /* missing and doubled */
    {"count: 5\n", "p.yaml:1:1", "'interval' is missing", "10min"},
    {"interval: 10min\n", "p.yaml:1:1", "neither 'count' nor 'until'", "count: 1008"},
    {P "count: 11\n", "p.yaml:3:1", "doubled key count", "line 2"},
    {P "until: 7d\n", "p.yaml:3:1", "until: stands beside 'count'", "keep one"},
    {"interval:\ncount: 5\n", "p.yaml:1:1", "interval: has no value", "10min"},
    {P "shot: {exposure: 20ms}\nshots: [{exposure: 20ms}]\n", "p.yaml:4:1", "beside 'shot'", ""},
    /* ranges and kinds of value */
    {"interval: 10ms\ncount: 5\n", "p.yaml:1:11", "out of its range", "100ms"},
    {"interval: 10min\ncount: 0\n", "p.yaml:2:8", "out of its range", "from 1"},
    {"interval: 10min\ncount: 1.5\n", "p.yaml:2:8", "not a whole number", ""},
    {"interval: 10min\ncount: inf\n", "p.yaml:2:8", "not a whole number", ""},
    {"interval: [10min]\ncount: 5\n", "p.yaml:1:11", "not a list", ""},
    {"- interval: 10min\n", "p.yaml:1:1", "a plan holds keys", ""},
    {P "mains: 55Hz\n", "p.yaml:3:8", "no mains has 55Hz", "50Hz"},
    {P "keep: rwa\n", "p.yaml:3:7", "none of its words", "'raw'"},
    {P "start: tomorrow\n", "p.yaml:3:8", "not an instant", "2026-03-01T08:00:00Z"},
    {P "reserve: 2\n", "p.yaml:3:10", "has no unit", "GiB"},
    {P "mm_per_px: nan\n", "p.yaml:3:12", "not a number", ""},
    {P "lamps: {mode: capture_only}\n", "p.yaml:3:15", "none of its words", "'capture-only'"},
    {P "lamps: {day_start: \"24:00\"}\n", "p.yaml:3:20", "no time of day", "06:00"},
    {P "lamps: {phase: 1h, day_start: \"06:00\"}\n", "p.yaml:3:9", "beside 'day_start'", ""},
    /* within shots */
    {P "shots:\n  - exposure: 20\n", "p.yaml:4:15", "shots[0].exposure: '20' has no unit", "20s"},
    {P "shots:\n  - {}\n  - exposur: 20ms\n", "p.yaml:5:5", "shots[1].exposur: unknown key",
     "'exposure'"},
    {P "shots:\n  - lamps: {left: 120%}\n", "p.yaml:4:19", "shots[0].lamps.left: 120%",
     "from 0% to 100%"},
    {P "shots:\n  - lamps: {left: 5}\n", "p.yaml:4:19", "has no unit", "%"},
    {P "shots:\n  - lamps: {left: 0.05%}\n", "p.yaml:4:19", "finer than a permille", ""},
    {P "shots:\n  - average: 65\n", "p.yaml:4:14", "out of its range", "to 64"},
    {P "shots:\n  - brackets: [1, inf]\n", "p.yaml:4:19", "shots[0].brackets[1]", ""},
    {P "shots:\n  - brackets: 2\n", "p.yaml:4:15", "a list", ""},
    {P "shots:\n  - stream: Haupt Strom\n", "p.yaml:4:13", "not a name", ""},
    {P "shots: []\n", "p.yaml:3:8", "a list", ""},
    {P "region: {x: 1, width: 5}\n", "p.yaml:3:9", "'height' is missing", ""},
    {P "region: {x: -1, width: 5, height: 5}\n", "p.yaml:3:13", "out of its range", ""},
    /* what YAML allows and a plan does not */
    {P "title: &a x\nzone: *a\n", "p.yaml:4:7", "aliases are not read", "write the value out"},
    {P "title: !!str x\n", "p.yaml:3:8", "tags are not read", ""},
    {P "lamps: !!omap {mode: none}\n", "p.yaml:3:8", "tags are not read", ""},
    {P "shots: !own [{exposure: 20ms}]\n", "p.yaml:3:8", "tags are not read", ""},
    {"\xff\xfei", "p.yaml:1:1", "UTF-16", "UTF-8"},
    {P "---\n" P, "p.yaml:3:1", "a second document", ""},
    {P "? [a]\n: b\n", "p.yaml:3:3", "a key must be a word", ""},
    {P "title: \"a\\0b\"\n", "p.yaml:3:8", "zero byte", ""},
};

static void what_is_wrong_is_named_with_line_column_and_what_was_meant(void **state)
{
    (void)state;
    for (unsigned i = 0; i < TTF_COUNT_OF(WRONG); i++) {
        struct ttf_plan_file *file = NULL;
        struct ttf_err err = {0};
        int r = ttf_plan_file_parse("p.yaml", WRONG[i].text, strlen(WRONG[i].text), &file, &err);

        if (r != -EINVAL)
            fail_msg("accepted or other error (%d):\n%s", r, WRONG[i].text);
        if (strncmp(err.where, WRONG[i].where, strlen(WRONG[i].where)) != 0 ||
            !strstr(err.what, WRONG[i].what) || !strstr(err.hint, WRONG[i].hint) || !*err.hint)
            fail_msg("%s\n-> %s: %s; %s", WRONG[i].text, err.where, err.what, err.hint);
    }
}

/* Ten lines that would mean ten billion nodes. */
static void a_bomb_of_aliases_is_refused_at_once(void **state)
{
    char text[4096];
    size_t n = (size_t)snprintf(text, sizeof text, "a0: &a0 [x, x, x, x, x, x, x, x, x, x]\n");
    struct ttf_plan_file *file = NULL;
    struct ttf_err err = {0};

    (void)state;
    for (int i = 1; i < 10; i++) {
        n += (size_t)snprintf(text + n, sizeof text - n, "a%d: &a%d [", i, i);
        for (int k = 0; k < 10; k++)
            n += (size_t)snprintf(text + n, sizeof text - n, "*a%d, ", i - 1);
        n += (size_t)snprintf(text + n, sizeof text - n, "]\n");
    }
    assert_int_equal(ttf_plan_file_parse("bomb", text, n, &file, &err), -EINVAL);
    assert_string_equal(err.where, "bomb:2:10");
}

static void deep_and_long_texts_are_bounded(void **state)
{
    size_t n = 200000;
    char *text = malloc(n + 1);
    struct ttf_plan_file *file = NULL;
    struct ttf_err err = {0};

    (void)state;
    assert_non_null(text);
    memset(text, '[', n);
    assert_int_equal(ttf_plan_file_parse("deep", text, n, &file, &err), -EINVAL);
    assert_non_null(strstr(err.what, "too deeply"));
    for (size_t i = 0; i < n; i++)
        text[i] = i < 8 ? "title: ["[i] : i % 2 ? ',' : '1';
    assert_int_equal(ttf_plan_file_parse("long", text, n, &file, &err), -EINVAL);
    assert_non_null(strstr(err.what, "more values"));
    free(text);
}

/* Cutting a good plan anywhere gives a plan or an error with a place, never a crash. */
static void any_cut_of_a_plan_is_read_or_refused_with_its_place(void **state)
{
    (void)state;
    for (size_t n = 0; n < sizeof WHOLE; n++) {
        struct ttf_plan_file *file = NULL;
        struct ttf_err err = {0};

        if (ttf_plan_file_parse("cut", WHOLE, n, &file, &err) == 0)
            ttf_plan_file_free(file);
        else if (strncmp(err.where, "cut:", 4) != 0)
            fail_msg("cut at %zu: '%s' %s", n, err.where, err.what);
    }
}

static void a_byte_changed_anywhere_never_harms(void **state)
{
    static const char BYTES[] = {0, '\t', '"', '*', '&', '-', ':', '[', '}', (char)0xff, '9'};
    char text[sizeof WHOLE];

    (void)state;
    for (size_t i = 0; i < sizeof WHOLE - 1; i++) {
        for (unsigned k = 0; k < sizeof BYTES; k++) {
            struct ttf_plan_file *file = NULL;
            struct ttf_err err = {0};

            memmove(text, WHOLE, sizeof WHOLE);
            text[i] = BYTES[k];
            if (ttf_plan_file_parse("m", text, sizeof WHOLE - 1, &file, &err) == 0)
                ttf_plan_file_free(file);
            else
                assert_true(err.code < 0 && *err.where);
        }
    }
}

/* ---- against a box ---- */

static const char BOX[] = "board: t\n"
                          "cameras: {main: {backend: sim}}\n"
                          "clock: {backend: sim}\n"
                          "lamps:\n"
                          "  left: {backend: sim, max_duty: 100permille, duty_window: 24h}\n"
                          "sim: {scene: white, sensor: {width: 32px, height: 32px}}\n";

/* Checks the plan on the board above; *err as the command line would show it. */
static int check_on_box(const char *text, struct ttf_err *err)
{
    struct ttf_plan_file *file = parse(text);
    struct ttf_plan_figures figures;
    struct ttf_frame_format format;
    struct ttf_camera_mode mode = {0};
    struct ttf_scene scene;
    struct ttf_board board;
    struct ttf_box box = {0};
    int r;

    assert_int_equal(ttf_board_parse("b.yaml", BOX, strlen(BOX), NULL, 0, &board, err), 0);
    assert_int_equal(ttf_scene_procedural("white", 1, TTF_NS_PER_DAY, &scene, err), 0);
    assert_int_equal(ttf_sim_box_create(&board.sim, &scene, &box, err), 0);
    assert_int_equal(ttf_camera_configure(box.cameras[0].camera, &mode, &format, err), 0);
    r = ttf_plan_check(ttf_plan_file_plan(file), &box, &figures, err);
    if (r < 0)
        ttf_plan_file_place(file, err);
    ttf_box_destroy(&box);
    ttf_plan_file_free(file);
    return r;
}

static void a_lamp_beyond_its_duty_is_named_with_its_line(void **state)
{
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(check_on_box("interval: 10min\n"
                                  "count: 1008\n"
                                  "lamps:\n"
                                  "  mode: continuous\n"
                                  "shots:\n"
                                  "  - lamps: {left: 100%}\n"
                                  "    exposure: 20ms\n",
                                  &err),
                     -EINVAL);
    if (strncmp(err.where, "p.yaml:", 7) != 0 || !strstr(err.what, "left") ||
        !strstr(err.what, "the board allows 10"))
        fail_msg("%s: %s; %s", err.where, err.what, err.hint);
    assert_int_equal(check_on_box("interval: 10min\ncount: 1008\n"
                                  "lamps: {mode: capture-only, settle: 5s}\n"
                                  "shots: [{lamps: {left: 100%}, exposure: 20ms}]\n",
                                  &err),
                     0);
}

static void a_lamp_that_the_box_lacks_is_named_with_its_line(void **state)
{
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(check_on_box("interval: 10min\n"
                                  "count: 5\n"
                                  "lamps: {mode: capture-only, settle: 5s}\n"
                                  "shots:\n"
                                  "  - exposure: 20ms\n"
                                  "    lamps: {top: 100%}\n",
                                  &err),
                     -EINVAL);
    assert_true(strncmp(err.where, "p.yaml:6:", 9) == 0);
    assert_non_null(strstr(err.what, "top"));
}

static void an_exposure_beyond_the_interval_is_named_with_its_line(void **state)
{
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(check_on_box("interval: 1s\n"
                                  "count: 5\n"
                                  "shot:\n"
                                  "  exposure: 3s\n",
                                  &err),
                     -EINVAL);
    assert_true(strncmp(err.where, "p.yaml:", 7) == 0);
    assert_true(*err.what != '\0');
}

static void an_error_about_a_file_is_left_as_it_is(void **state)
{
    struct ttf_plan_file *file = parse("interval: 1s\ncount: 5\nshot:\n  exposure: 3ms\n");
    struct ttf_err err;

    (void)state;
    ttf_err_set(&err, -EINVAL, "grass", "is another plan's");
    ttf_plan_file_place(file, &err);
    assert_string_equal(err.where, "grass");
    ttf_err_set(&err, -EINVAL, "shots[0].exposure", "is too long");
    ttf_plan_file_place(file, &err);
    assert_string_equal(err.where, "p.yaml:4:13");
    assert_string_equal(err.what, "shots[0].exposure: is too long");
    ttf_err_set(&err, -EINVAL, "lamps.settle", "is too long");
    ttf_plan_file_place(file, &err);
    assert_string_equal(err.where, "p.yaml:1:1");
    ttf_plan_file_free(file);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_reaches_its_field),
        cmocka_unit_test(a_box_s_zone_is_that_of_a_plan_which_names_none),
        cmocka_unit_test(until_counts_the_slots_before_it),
        cmocka_unit_test(a_start_that_has_passed_is_refused_with_its_line),
        cmocka_unit_test(what_is_wrong_is_named_with_line_column_and_what_was_meant),
        cmocka_unit_test(a_bomb_of_aliases_is_refused_at_once),
        cmocka_unit_test(deep_and_long_texts_are_bounded),
        cmocka_unit_test(any_cut_of_a_plan_is_read_or_refused_with_its_place),
        cmocka_unit_test(a_byte_changed_anywhere_never_harms),
        cmocka_unit_test(a_lamp_beyond_its_duty_is_named_with_its_line),
        cmocka_unit_test(a_lamp_that_the_box_lacks_is_named_with_its_line),
        cmocka_unit_test(an_exposure_beyond_the_interval_is_named_with_its_line),
        cmocka_unit_test(an_error_about_a_file_is_left_as_it_is),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
