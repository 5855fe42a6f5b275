/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "ttf/base/checked.h"
#include "ttf/base/err.h"

static void says_where_what_and_hint(void **state)
{
    struct ttf_err err = {0};
    char text[512];

    (void)state;
    assert_int_equal(ttf_err_set(&err, -EINVAL, "plan.yaml:3", "'%s' has no unit", "30"), -EINVAL);
    ttf_err_hint(&err, "write 30s or 30min");
    assert_string_equal(ttf_err_text(&err, text, sizeof(text)),
                        "plan.yaml:3: '30' has no unit; write 30s or 30min");
}

static void prefixes_on_the_way_up(void **state)
{
    struct ttf_err err = {0};

    (void)state;
    ttf_err_set(&err, -EIO, NULL, "no answer");
    ttf_err_prefix(&err, "camera %d", 2);
    assert_string_equal(err.what, "camera 2: no answer");
    assert_int_equal(err.code, -EIO);
}

static void cuts_long_texts_and_takes_null(void **state)
{
    struct ttf_err err = {0};
    char big[2000];

    (void)state;
    memset(big, 'x', sizeof(big) - 1);
    big[sizeof(big) - 1] = '\0';
    ttf_err_set(&err, -EIO, big, "%s", big);
    assert_int_equal(strlen(err.what), sizeof(err.what) - 1);
    assert_int_equal(strlen(err.where), sizeof(err.where) - 1);
    assert_int_equal(ttf_err_set(NULL, -EPERM, "a", "b"), -EPERM);
}

static void checked_arithmetic_refuses_overflow(void **state)
{
    size_t r = 7;
    int64_t i = 7;

    (void)state;
    assert_false(ttf_mul_size(SIZE_MAX, 2, &r));
    assert_int_equal(r, 7);
    assert_true(ttf_mul_size(6, 7, &r));
    assert_int_equal(r, 42);
    assert_false(ttf_add_i64(INT64_MAX, 1, &i));
    assert_int_equal(i, 7);
}

static void instants_that_do_not_fit_are_the_nearest_that_do(void **state)
{
    (void)state;
    assert_int_equal(ttf_near_sum_i64(40, 2), 42);
    assert_int_equal(ttf_near_sum_i64(INT64_MAX, 1), INT64_MAX);
    assert_int_equal(ttf_near_sum_i64(-INT64_MAX, -1), -INT64_MAX);
    assert_int_equal(ttf_near_sum_i64(-INT64_MAX, -2), -INT64_MAX);
    assert_int_equal(ttf_near_difference_i64(44, 2), 42);
    assert_int_equal(ttf_near_difference_i64(INT64_MAX, -1), INT64_MAX);
    assert_int_equal(ttf_near_difference_i64(0, INT64_MIN), INT64_MAX);
    assert_int_equal(ttf_near_difference_i64(-INT64_MAX, 1), -INT64_MAX);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(says_where_what_and_hint),
        cmocka_unit_test(prefixes_on_the_way_up),
        cmocka_unit_test(cuts_long_texts_and_takes_null),
        cmocka_unit_test(checked_arithmetic_refuses_overflow),
        cmocka_unit_test(instants_that_do_not_fit_are_the_nearest_that_do),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
