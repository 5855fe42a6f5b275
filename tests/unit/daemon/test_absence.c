/* SPDX-License-Identifier: Apache-2.0 */
/* test_absence.c: what a run is told of the time before it. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <string.h>

#include "absence.h"

static void a_stop_counts_from_the_last_record_on(void **state)
{
    struct absence a = {0};
    struct ttf_absence it;

    (void)state;
    absence_rested(&a, "grass", 100, 200); /* found stopped at 100, perhaps after a boot */
    it = absence_of(&a, "grass");
    assert_true(it.stops[0].from_ns == INT64_MIN);
    assert_int_equal(it.stops[0].until_ns, 200);
    assert_int_equal(it.trying_since_ns, 0);
}

static void what_was_tried_before_and_after_a_stop_is_no_stop(void **state)
{
    struct absence a = {0};
    struct ttf_absence it;

    (void)state;
    absence_tried(&a, "grass", 50);
    absence_rested(&a, "grass", 100, 200);
    absence_tried(&a, "grass", 210);
    it = absence_of(&a, "grass");
    assert_int_equal(it.trying_since_ns, 50);
    assert_int_equal(it.stops[0].from_ns, 100);
    assert_int_equal(it.stops[0].until_ns, 200);
}

/* Armed at 210, it failed at 300 and was tried until a person stopped it at 500. */
static void what_the_box_lost_between_two_stops_is_no_stop(void **state)
{
    struct absence a = {0};
    struct ttf_absence it;

    (void)state;
    absence_rested(&a, "grass", 100, 200);
    absence_over(&a);
    absence_tried(&a, "grass", 205);
    absence_rested(&a, "grass", 500, 600);
    it = absence_of(&a, "grass");
    assert_int_equal(it.trying_since_ns, 205);
    assert_int_equal(it.stops[0].from_ns, 500);
    assert_int_equal(it.stops[0].until_ns, 600);
}

/* The guardian is away all the time: a person stops it, goes on, and stops it once more. */
static void each_of_two_stops_in_one_absence_is_told(void **state)
{
    struct absence a = {0};
    struct ttf_absence it;

    (void)state;
    absence_tried(&a, "grass", 50);
    absence_rested(&a, "grass", 100, 200);
    absence_tried(&a, "grass", 210);
    absence_rested(&a, "grass", 500, 600);
    it = absence_of(&a, "grass");
    assert_int_equal(it.n_stops, 2);
    assert_int_equal(it.stops[0].from_ns, 100);
    assert_int_equal(it.stops[0].until_ns, 200);
    assert_int_equal(it.stops[1].from_ns, 500);
    assert_int_equal(it.stops[1].until_ns, 600);
    absence_over(&a);
    assert_int_equal(absence_of(&a, "grass").n_stops, 0);
}

static void a_stop_right_behind_another_is_one(void **state)
{
    struct absence a = {0};
    struct ttf_absence it;

    (void)state;
    absence_rested(&a, "grass", 100, 200);
    absence_rested(&a, "grass", 201, 300);
    it = absence_of(&a, "grass");
    assert_int_equal(it.n_stops, 1);
    assert_true(it.stops[0].from_ns == INT64_MIN);
    assert_int_equal(it.stops[0].until_ns, 300);
}

static void of_more_stops_than_there_is_room_for_the_last_are_told(void **state)
{
    struct absence a = {0};
    struct ttf_absence it;

    (void)state;
    for (int64_t i = 1; i <= TTF_ABSENCE_STOPS + 3; i++) {
        absence_tried(&a, "grass", 100 * i - 50);
        absence_rested(&a, "grass", 100 * i, 100 * i + 10);
    }
    it = absence_of(&a, "grass");
    assert_int_equal(it.n_stops, TTF_ABSENCE_STOPS);
    assert_int_equal(it.stops[0].from_ns, 400);
    assert_int_equal(it.stops[TTF_ABSENCE_STOPS - 1].from_ns, 100 * (TTF_ABSENCE_STOPS + 3));
}

static void nothing_is_said_of_one_dataset_by_another(void **state)
{
    struct absence a = {0};
    struct ttf_absence it;

    (void)state;
    absence_rested(&a, "grass", 100, 200);
    it = absence_of(&a, "moss");
    assert_int_equal(it.n_stops, 0);
    it = absence_of(&a, "grass");
    assert_int_equal(it.n_stops, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_stop_counts_from_the_last_record_on),
        cmocka_unit_test(what_was_tried_before_and_after_a_stop_is_no_stop),
        cmocka_unit_test(what_the_box_lost_between_two_stops_is_no_stop),
        cmocka_unit_test(each_of_two_stops_in_one_absence_is_told),
        cmocka_unit_test(a_stop_right_behind_another_is_one),
        cmocka_unit_test(of_more_stops_than_there_is_room_for_the_last_are_told),
        cmocka_unit_test(nothing_is_said_of_one_dataset_by_another),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
