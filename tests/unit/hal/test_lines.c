/* SPDX-License-Identifier: Apache-2.0 */
/* test_lines.c: banks of wires: what any refuses, and the one in a file. Real chips are for the rig. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/hal/gpiod.h"
#include "ttf/hal/lines.h"

static const struct ttf_line_spec SPECS[] = {
    {.label = "left", .line = "0"},
    {.label = "right", .line = "1", .active_low = true},
    {.label = "door", .line = "2", .input = true},
    {.label = "button", .line = "3", .input = true, .active_low = true},
};

static const char *path(void)
{
    static char text[64];

    snprintf(text, sizeof(text), "/tmp/ttf-wires.%d", (int)getpid());
    return text;
}

static void wires(const char *text)
{
    FILE *file = fopen(path(), "w");

    if (!file)
        fail();
    fputs(text, file);
    fclose(file);
}

static void expect_wires(const char *want)
{
    char text[16] = "";
    FILE *file = fopen(path(), "r");

    if (!file || !fgets(text, sizeof(text), file))
        fail();
    else
        fclose(file);
    assert_string_equal(text, want);
}

static int clean(void **state)
{
    (void)state;
    (void)unlink(path());
    return 0;
}

static struct ttf_lines *bank(void)
{
    struct ttf_lines *lines = NULL;

    assert_int_equal(ttf_lines_file_create(path(), SPECS, 4, &lines, NULL), 0);
    return lines;
}

static void outputs_are_dark_from_the_first_and_at_the_end(void **state)
{
    struct ttf_lines *lines;

    (void)state;
    wires("1000");
    lines = bank();
    expect_wires("0100"); /* inputs are left as they are */
    assert_int_equal(ttf_lines_set(lines, 0, 500), 0);
    assert_int_equal(ttf_lines_set(lines, 1, 1000), 0);
    expect_wires("1000");
    assert_int_equal(ttf_lines_get(lines, 1), 1);
    assert_int_equal(ttf_lines_set(lines, 0, 499), 0);
    assert_int_equal(ttf_lines_get(lines, 0), 0);
    ttf_lines_destroy(lines);
    expect_wires("0100");
}

static void edges_of_inputs_are_told_once_each(void **state)
{
    struct ttf_lines *lines;
    struct ttf_line_event event;

    (void)state;
    wires("0101");
    lines = bank();
    assert_int_equal(ttf_lines_event(lines, &event), 0);
    wires("0110"); /* the door opens, the button goes down */
    assert_int_equal(ttf_lines_event(lines, &event), 1);
    assert_int_equal(event.i, 2);
    assert_true(event.active);
    assert_int_equal(ttf_lines_event(lines, &event), 1);
    assert_int_equal(event.i, 3);
    assert_true(event.active);
    assert_int_equal(ttf_lines_event(lines, &event), 0);
    ttf_lines_destroy(lines);
}

static void what_cannot_be_driven_is_refused(void **state)
{
    struct ttf_lines *lines = bank();

    (void)state;
    assert_int_equal(ttf_lines_set(lines, 2, 1000), -EINVAL);
    assert_int_equal(ttf_lines_set(lines, 4, 1000), -EINVAL);
    assert_int_equal(ttf_lines_set(lines, 0, 1001), -EINVAL);
    assert_int_equal(ttf_lines_get(lines, 4), -EINVAL);
    assert_null(ttf_lines_spec(lines, 4));
    ttf_lines_destroy(lines);
}

static void a_bank_that_vanishes_says_so_until_it_is_back(void **state)
{
    struct ttf_lines *lines = bank();
    struct ttf_line_event event;

    (void)state;
    assert_int_equal(ttf_lines_set(lines, 0, 1000), 0);
    (void)unlink(path());
    assert_int_equal(ttf_lines_set(lines, 0, 0), -ENODEV);
    assert_int_equal(ttf_lines_get(lines, 0), -ENODEV);
    assert_int_equal(ttf_lines_event(lines, &event), -ENODEV);
    assert_int_equal(ttf_lines_reopen(lines, NULL), -ENODEV);
    wires("1011");
    assert_int_equal(ttf_lines_reopen(lines, NULL), 0);
    expect_wires("0111");
    ttf_lines_destroy(lines);
}

/* Of a whole that lost another bank, the lamps of this one were lit when it was lost. */
static void a_bank_that_did_not_vanish_is_dark_when_had_anew(void **state)
{
    struct ttf_lines *lines = bank();

    (void)state;
    assert_int_equal(ttf_lines_set(lines, 0, 1000), 0);
    assert_int_equal(ttf_lines_reopen(lines, NULL), 0);
    expect_wires("0101");
    ttf_lines_destroy(lines);
}

static void banks_joined_to_one_keep_the_order_of_the_whole(void **state)
{
    /* The whole's order is not that of the banks. */
    const struct ttf_line_spec whole[3] = {SPECS[3], SPECS[0], SPECS[2]};
    const struct ttf_line_spec inputs[2] = {SPECS[2], SPECS[3]};
    struct ttf_lines *banks[2], *lines = NULL;
    struct ttf_line_event event;
    struct ttf_err err = {0};
    char other[80];

    (void)state;
    (void)snprintf(other, sizeof other, "%s.other", path());
    wires("01");
    assert_int_equal(ttf_lines_file_create(path(), inputs, 2, &banks[0], NULL), 0);
    assert_int_equal(ttf_lines_file_create(other, &SPECS[0], 1, &banks[1], NULL), 0);
    assert_int_equal(ttf_lines_joined_create(SPECS, 4, banks, 2, &lines, &err), -EINVAL);
    assert_string_equal(err.where, "right"); /* nobody has it */
    assert_int_equal(ttf_lines_joined_create(whole, 3, banks, 2, &lines, NULL), 0);
    assert_int_equal(ttf_lines_set(lines, 1, 1000), 0);
    assert_int_equal(ttf_lines_get(lines, 1), 1);
    assert_int_equal(ttf_lines_set(lines, 0, 1000), -EINVAL);
    wires("00");
    assert_int_equal(ttf_lines_event(lines, &event), 1);
    assert_int_equal(event.i, 0); /* the button, second of its bank */
    assert_true(event.active);
    assert_int_equal(ttf_lines_event(lines, &event), 0);
    (void)unlink(other);
    assert_int_equal(ttf_lines_set(lines, 1, 0), -ENODEV);
    assert_int_equal(ttf_lines_get(lines, 2), 0);
    assert_int_equal(ttf_lines_reopen(lines, NULL), -ENODEV);
    ttf_lines_destroy(lines);
}

static void a_bank_that_cannot_be_had_whole_stays_lost(void **state)
{
    struct ttf_lines *lines = bank();

    (void)state;
    (void)unlink(path());
    assert_int_equal(ttf_lines_set(lines, 0, 1000), -ENODEV);
    assert_int_equal(symlink("/dev/full", path()), 0); /* opens, and takes nothing */
    assert_true(ttf_lines_reopen(lines, NULL) < 0);
    assert_int_equal(ttf_lines_set(lines, 0, 1000), -ENODEV);
    (void)unlink(path());
    wires("1011");
    assert_int_equal(ttf_lines_reopen(lines, NULL), 0); /* tried again, as it is not had */
    expect_wires("0111");
    ttf_lines_destroy(lines);
}

static void descriptions_that_mean_nothing_are_refused(void **state)
{
    struct ttf_line_spec twice[2] = {SPECS[0], SPECS[0]};
    struct ttf_line_spec nameless = {.line = "1"}, wireless = {.label = "left"};
    struct ttf_lines *lines;
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(ttf_lines_file_create(path(), twice, 2, &lines, &err), -EINVAL);
    assert_string_equal(err.where, "left");
    assert_int_equal(ttf_lines_file_create(path(), &nameless, 1, &lines, NULL), -EINVAL);
    assert_int_equal(ttf_lines_file_create(path(), &wireless, 1, &lines, NULL), -EINVAL);
    assert_int_equal(ttf_lines_file_create(path(), SPECS, 0, &lines, NULL), -EINVAL);
    assert_int_equal(ttf_lines_file_create("/nobody/here", SPECS, 1, &lines, &err), -ENOENT);
    assert_true(access(path(), F_OK) < 0); /* nothing was made */
}

#ifdef TTF_TEST_GPIOD
static void a_chip_that_is_not_there_is_named_with_what_to_do(void **state)
{
    struct ttf_line_spec spec = {.label = "left", .chip = "no-such-chip", .line = "17"};
    struct ttf_lines *lines;
    struct ttf_err err = {0};

    (void)state;
    assert_true(ttf_lines_gpiod_version()[0] != '\0');
    assert_true(ttf_lines_gpiod_create(&spec, 1, &lines, &err) < 0);
    assert_string_equal(err.where, "left");
    assert_non_null(strstr(err.what, "no-such-chip"));
    assert_true(err.hint[0] != '\0');
    spec.chip[0] = '\0'; /* a number is of a chip */
    assert_int_equal(ttf_lines_gpiod_create(&spec, 1, &lines, &err), -ENOENT);
    snprintf(spec.line, sizeof(spec.line), "no-such-line");
    assert_int_equal(ttf_lines_gpiod_create(&spec, 1, &lines, &err), -ENOENT);
    assert_non_null(strstr(err.what, "no-such-line"));
}
#endif

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(outputs_are_dark_from_the_first_and_at_the_end, clean),
        cmocka_unit_test_teardown(edges_of_inputs_are_told_once_each, clean),
        cmocka_unit_test_teardown(what_cannot_be_driven_is_refused, clean),
        cmocka_unit_test_teardown(a_bank_that_vanishes_says_so_until_it_is_back, clean),
        cmocka_unit_test_teardown(a_bank_that_did_not_vanish_is_dark_when_had_anew, clean),
        cmocka_unit_test_teardown(banks_joined_to_one_keep_the_order_of_the_whole, clean),
        cmocka_unit_test_teardown(a_bank_that_cannot_be_had_whole_stays_lost, clean),
        cmocka_unit_test_teardown(descriptions_that_mean_nothing_are_refused, clean),
#ifdef TTF_TEST_GPIOD
        cmocka_unit_test(a_chip_that_is_not_there_is_named_with_what_to_do),
#endif
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
