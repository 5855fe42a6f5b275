/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include "schedule.h"
#include "ttf/base/time.h"

static void slots_never_drift(void **state)
{
    struct ttf_grid grid = {0, 12345, TTF_NS_PER_S / 3};

    (void)state;
    /* A million slots on, it is the same multiplication as at the start. */
    assert_int_equal(ttf_grid_due_ns(&grid, 0), 12345);
    assert_int_equal(ttf_grid_due_ns(&grid, 1000000), 12345 + 1000000 * (TTF_NS_PER_S / 3));
}

static void a_slot_due_now_is_the_one_at_hand(void **state)
{
    struct ttf_grid grid = {7, 1000, 100};

    (void)state;
    assert_int_equal(ttf_grid_index_at(&grid, 0), 7);
    assert_int_equal(ttf_grid_index_at(&grid, 1000), 7);
    assert_int_equal(ttf_grid_index_at(&grid, 1001), 8);
    assert_int_equal(ttf_grid_index_at(&grid, 1100), 8);
    assert_int_equal(ttf_grid_index_at(&grid, 1101), 9);
}

static void instants_before_this_boot_are_negative(void **state)
{
    struct ttf_grid grid = {0, -TTF_NS_PER_H, TTF_NS_PER_MIN};

    (void)state;
    assert_int_equal(ttf_grid_due_ns(&grid, 60), 0);
    assert_int_equal(ttf_grid_index_at(&grid, 1), 61);
}

static void a_slot_beyond_all_time_never_comes(void **state)
{
    struct ttf_grid grid = {0, 0, TTF_NS_PER_DAY};

    (void)state;
    assert_int_equal(ttf_grid_due_ns(&grid, INT64_MAX / 2), TTF_NS_NEVER);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(slots_never_drift),
        cmocka_unit_test(a_slot_due_now_is_the_one_at_hand),
        cmocka_unit_test(instants_before_this_boot_are_negative),
        cmocka_unit_test(a_slot_beyond_all_time_never_comes),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
