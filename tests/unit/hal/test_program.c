/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "ttf/hal/program.h"

static void finds_what_lies_beside_the_running_program(void **state)
{
    char own[TTF_PROGRAM_PATH_MAX] = "", found[TTF_PROGRAM_PATH_MAX];
    struct stat a, b;

    (void)state;
    assert_true(readlink("/proc/self/exe", own, sizeof(own) - 1) > 0);
    assert_int_equal(ttf_program_find(strrchr(own, '/') + 1, found), 0);
    assert_int_equal(stat(own, &a), 0);
    assert_int_equal(stat(found, &b), 0);
    assert_true(a.st_ino == b.st_ino && a.st_dev == b.st_dev);
}

static void says_that_there_is_none(void **state)
{
    char found[TTF_PROGRAM_PATH_MAX];

    (void)state;
    assert_int_equal(ttf_program_find("ttfbox-there-is-no-such-program", found), -ENOENT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(finds_what_lies_beside_the_running_program),
        cmocka_unit_test(says_that_there_is_none),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
