/* SPDX-License-Identifier: Apache-2.0 */
/* test_pwm.c: PWM channels as lines, on files laid out like the kernel's. No real channel was at hand. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "alloc/alloc_hook.h"
#include "pwm_tree.h"
#include "ttf/hal/pwm.h"

static const struct ttf_line_spec LAMPS[] = {
    {.label = "left", .chip = "pwmchip0", .line = "0", .period_ns = 50000},
    {.label = "right", .chip = "fe20c000.pwm", .line = "1", .period_ns = 40000},
};

static struct pwm_tree tree; /* one test at a time */

static int setup(void **state)
{
    (void)state;
    pwm_tree_make(&tree);
    pwm_tree_export(&tree, 0);
    pwm_tree_export(&tree, 1);
    return 0;
}

static int teardown(void **state)
{
    (void)state;
    pwm_tree_free(&tree);
    return 0;
}

static struct ttf_lines *bank(void)
{
    struct ttf_lines *lines = NULL;
    struct ttf_err err = {0};

    if (ttf_lines_pwm_create(tree.root, LAMPS, 2, &lines, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    return lines;
}

static int refused(const struct ttf_line_spec *spec, struct ttf_err *ret)
{
    struct ttf_lines *lines = NULL;

    *ret = (struct ttf_err){0};
    return ttf_lines_pwm_create(tree.root, spec, 1, &lines, ret);
}

#define EXPECT(path, value) assert_int_equal(pwm_tree_number(&tree, path), value)

static void a_level_is_its_share_of_the_cycle_and_off_is_disabled(void **state)
{
    struct ttf_lines *lines = bank();

    (void)state;
    EXPECT("pwm0/period", 50000);
    EXPECT("pwm1/period", 40000);
    EXPECT("pwm0/enable", 0);
    assert_int_equal(ttf_lines_set(lines, 0, 123), 0);
    EXPECT("pwm0/duty_cycle", 6150);
    EXPECT("pwm0/enable", 1);
    assert_int_equal(ttf_lines_get(lines, 0), 1);
    assert_int_equal(ttf_lines_get(lines, 1), 0);
    assert_int_equal(ttf_lines_set(lines, 1, 1000), 0);
    EXPECT("pwm1/duty_cycle", 40000);
    assert_int_equal(ttf_lines_set(lines, 0, 1), 0); /* from long numbers to short ones */
    EXPECT("pwm0/duty_cycle", 50);
    assert_int_equal(ttf_lines_set(lines, 0, 0), 0);
    EXPECT("pwm0/duty_cycle", 0);
    EXPECT("pwm0/enable", 0);
    assert_int_equal(ttf_lines_get(lines, 0), 0);
    EXPECT("pwm1/enable", 1); /* the other one burns on */
    ttf_lines_destroy(lines);
    EXPECT("pwm1/duty_cycle", 0);
    EXPECT("pwm1/enable", 0);
}

static void what_a_killed_holder_left_lit_is_dark_from_the_first(void **state)
{
    struct ttf_lines *lines;

    (void)state;
    pwm_tree_put(&tree, "pwm0/period",
                 "100000\n"); /* another cycle than ours, longer and shorter */
    pwm_tree_put(&tree, "pwm0/duty_cycle", "90000\n");
    pwm_tree_put(&tree, "pwm0/enable", "1\n");
    pwm_tree_put(&tree, "pwm0/polarity", "inversed\n");
    lines = bank();
    EXPECT("pwm0/duty_cycle", 0);
    EXPECT("pwm0/enable", 0);
    EXPECT("pwm0/period", 50000);
    assert_int_equal(ttf_lines_set(lines, 0, 1000), 0);
    EXPECT("pwm0/duty_cycle", 50000);
    ttf_lines_destroy(lines);
}

static void a_channel_that_nobody_exported_is(void **state)
{
    struct ttf_err err = {0};

    (void)state;
    pwm_tree_remove(&tree, "pwm1");
    assert_int_equal(refused(&LAMPS[1], &err), -ENODEV); /* these files make none appear */
    assert_non_null(strstr(err.what, "did not appear"));
    EXPECT("export", 1);
}

static void a_chip_that_vanishes_says_so_until_it_is_back_and_dark(void **state)
{
    struct ttf_lines *lines = bank();

    (void)state;
    assert_int_equal(ttf_lines_set(lines, 0, 700), 0);
    pwm_tree_remove(&tree, "");
    assert_int_equal(ttf_lines_set(lines, 0, 0), -ENODEV);
    assert_int_equal(ttf_lines_set(lines, 0, 500), -ENODEV);
    assert_int_equal(ttf_lines_get(lines, 0), -ENODEV);
    assert_true(ttf_lines_reopen(lines, NULL) < 0);
    assert_int_equal(ttf_lines_set(lines, 1, 0), -ENODEV);
    (void)rmdir(tree.root);
    pwm_tree_make(&tree);
    pwm_tree_export(&tree, 0);
    pwm_tree_export(&tree, 1);
    assert_true(ttf_lines_reopen(lines, NULL) < 0); /* under another root */
    ttf_lines_destroy(lines);
}

static void a_chip_that_comes_back_is_held_again(void **state)
{
    struct ttf_lines *lines = bank();

    (void)state;
    pwm_tree_remove(&tree, "pwm0");
    pwm_tree_remove(&tree, "pwm1");
    assert_int_equal(ttf_lines_set(lines, 1, 500), -ENODEV);
    pwm_tree_export(&tree, 0);
    pwm_tree_export(&tree, 1);
    pwm_tree_put(&tree, "pwm0/period", "70000\n");
    pwm_tree_put(&tree, "pwm0/duty_cycle", "7000\n");
    pwm_tree_put(&tree, "pwm0/enable", "1\n");
    assert_int_equal(ttf_lines_set(lines, 1, 500), -ENODEV); /* not by itself: it may be lit */
    assert_int_equal(ttf_lines_reopen(lines, NULL), 0);
    EXPECT("pwm0/enable", 0);
    assert_int_equal(ttf_lines_set(lines, 1, 500), 0);
    EXPECT("pwm1/duty_cycle", 20000);
    ttf_lines_destroy(lines);
}

/* Writing there always fails, as a driver that does not take the value. */
static void refuse(const char *path)
{
    char at[256];

    pwm_tree_remove(&tree, path);
    (void)snprintf(at, sizeof at, "%s/class/pwm/pwmchip0/%s", tree.root, path);
    assert_int_equal(symlink("/dev/full", at), 0);
}

static void a_period_that_the_driver_refuses_is_told_at_the_beginning(void **state)
{
    struct ttf_err err;

    (void)state;
    refuse("pwm0/period");
    assert_true(refused(&LAMPS[0], &err) < 0);
    assert_string_equal(err.where, "left");
    assert_non_null(strstr(err.what, "period"));
    assert_non_null(strstr(err.hint, "period"));
}

static void a_level_that_the_driver_refuses_leaves_the_channel_dark(void **state)
{
    struct ttf_lines *lines = bank();

    (void)state;
    assert_int_equal(ttf_lines_set(lines, 0, 300), 0);
    refuse("pwm0/duty_cycle");
    assert_true(ttf_lines_set(lines, 0, 600) < 0);
    EXPECT("pwm0/enable", 0);
    ttf_lines_destroy(lines);
}

static void a_channel_that_cannot_be_enabled_keeps_no_duty(void **state)
{
    struct ttf_lines *lines = bank();

    (void)state;
    refuse("pwm0/enable");
    assert_true(ttf_lines_set(lines, 0, 600) < 0);
    EXPECT("pwm0/duty_cycle", 0);
    ttf_lines_destroy(lines);
}

static void without_permission_it_says_who_must_be_in_which_group(void **state)
{
    struct ttf_err err;
    char path[256];
    uid_t me = geteuid();
    int r;

    (void)state;
    (void)snprintf(path, sizeof path, "%s/class/pwm/pwmchip0/pwm0/period", tree.root);
    assert_int_equal(chmod(path, 0444), 0);
    if (me == 0 && seteuid(65534) < 0)
        skip();
    r = refused(&LAMPS[0], &err);
    if (me == 0)
        assert_int_equal(seteuid(me), 0);
    assert_int_equal(r, -EACCES);
    assert_non_null(strstr(err.hint, "group"));
}

static void a_channel_has_one_holder(void **state)
{
    struct ttf_lines *lines = bank();
    struct ttf_err err;

    (void)state;
    assert_int_equal(ttf_lines_set(lines, 0, 400), 0);
    assert_int_equal(refused(&LAMPS[0], &err), -EBUSY);
    assert_non_null(strstr(err.what, "held by another process"));
    EXPECT("pwm0/duty_cycle", 20000); /* and is not touched by who is refused */
    ttf_lines_destroy(lines);
    assert_int_equal(refused(
                         &(struct ttf_line_spec){
                             .label = "left", .chip = "pwmchip0", .line = "2", .period_ns = 50000},
                         &err),
                     -ENOENT);
    assert_non_null(strstr(err.what, "channel 2"));
}

static void descriptions_that_mean_nothing_are_refused(void **state)
{
    struct ttf_line_spec spec = LAMPS[0];
    struct ttf_err err;

    (void)state;
    (void)snprintf(spec.chip, sizeof spec.chip, "pwmchip7");
    assert_int_equal(refused(&spec, &err), -ENOENT);
    assert_non_null(strstr(err.what, "pwmchip7"));
    assert_non_null(strstr(err.hint, "/sys/class/pwm"));
    spec = LAMPS[0];
    spec.active_low = true;
    assert_int_equal(refused(&spec, &err), -EINVAL);
    spec = LAMPS[0];
    spec.period_ns = 999;
    assert_int_equal(refused(&spec, &err), -EINVAL);
    spec = LAMPS[0];
    spec.line[0] = 'x';
    assert_int_equal(refused(&spec, &err), -EINVAL);
    spec = LAMPS[0];
    spec.chip[0] = '\0';
    assert_int_equal(refused(&spec, &err), -EINVAL);
}

static void nothing_is_allocated_once_it_is_made(void **state)
{
    struct ttf_lines *lines = bank();
    struct alloc_counts before = alloc_hook_counts(ALLOC_ALL);
    struct ttf_line_event event;

    (void)state;
    assert_int_equal(ttf_lines_set(lines, 0, 400), 0);
    assert_int_equal(ttf_lines_set(lines, 0, 0), 0);
    assert_int_equal(ttf_lines_event(lines, &event), 0);
    assert_int_equal(alloc_hook_counts(ALLOC_ALL).calls, before.calls);
    ttf_lines_destroy(lines);
}

int main(void)
{
#define ON_TREE(test) cmocka_unit_test_setup_teardown(test, setup, teardown)
    const struct CMUnitTest tests[] = {
        ON_TREE(a_level_is_its_share_of_the_cycle_and_off_is_disabled),
        ON_TREE(what_a_killed_holder_left_lit_is_dark_from_the_first),
        ON_TREE(a_channel_that_nobody_exported_is),
        ON_TREE(a_chip_that_vanishes_says_so_until_it_is_back_and_dark),
        ON_TREE(a_chip_that_comes_back_is_held_again),
        ON_TREE(a_period_that_the_driver_refuses_is_told_at_the_beginning),
        ON_TREE(a_level_that_the_driver_refuses_leaves_the_channel_dark),
        ON_TREE(a_channel_that_cannot_be_enabled_keeps_no_duty),
        ON_TREE(without_permission_it_says_who_must_be_in_which_group),
        ON_TREE(a_channel_has_one_holder),
        ON_TREE(descriptions_that_mean_nothing_are_refused),
        ON_TREE(nothing_is_allocated_once_it_is_made),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
