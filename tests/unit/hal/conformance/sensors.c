/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <string.h>

#include "conformance.h"

static void readings_are_named_once_and_of_a_known_kind(void **state)
{
    struct ttf_box *box = *state;
    struct ttf_reading r[TTF_SENSORS_MAX];
    int64_t before = ttf_clock_now_ns(box->clock);
    int n = ttf_sensors_read(box->sensors, r, NULL);

    assert_in_range(n, 0, TTF_SENSORS_MAX);
    for (int i = 0; i < n; i++) {
        assert_true(r[i].name[0] != '\0');
        assert_int_equal(strspn(r[i].name, "abcdefghijklmnopqrstuvwxyz0123456789-"),
                         strlen(r[i].name));
        assert_true((unsigned)r[i].kind < TTF_SENSOR_KIND_COUNT);
        assert_true(r[i].at_ns >= before && r[i].at_ns <= ttf_clock_now_ns(box->clock));
        for (int k = 0; k < i; k++)
            assert_string_not_equal(r[i].name, r[k].name);
    }
}

static void values_are_possible_in_their_units(void **state)
{
    struct ttf_box *box = *state;
    struct ttf_reading r[TTF_SENSORS_MAX];
    int n = ttf_sensors_read(box->sensors, r, NULL);

    for (int i = 0; i < n; i++) {
        if (!r[i].ok)
            assert_int_equal(r[i].value, 0);
        else if (r[i].kind == TTF_SENSOR_TEMP_MDEGC)
            assert_true(r[i].value > -60000 && r[i].value < 150000);
        else if (r[i].kind == TTF_SENSOR_HUMIDITY_MPCT)
            assert_in_range(r[i].value, 0, 100000);
        else if (r[i].kind == TTF_SENSOR_PRESSURE_PA)
            assert_in_range(r[i].value, 30000, 120000);
    }
}

static void the_same_sensors_answer_in_the_same_order(void **state)
{
    struct ttf_box *box = *state;
    struct ttf_reading a[TTF_SENSORS_MAX], b[TTF_SENSORS_MAX];
    int n = ttf_sensors_read(box->sensors, a, NULL);

    assert_int_equal(ttf_sensors_read(box->sensors, b, NULL), n);
    for (int i = 0; i < n; i++)
        assert_string_equal(a[i].name, b[i].name);
}

int conformance_sensors(const struct conformance_factory *factory)
{
    const struct CMUnitTest tests[] = {
        CONFORMANCE_TEST(readings_are_named_once_and_of_a_known_kind, factory),
        CONFORMANCE_TEST(values_are_possible_in_their_units, factory),
        CONFORMANCE_TEST(the_same_sensors_answer_in_the_same_order, factory),
    };

    return _cmocka_run_group_tests(factory->name, tests, TTF_COUNT_OF(tests), NULL, NULL);
}
