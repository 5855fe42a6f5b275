/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include "exposure.h"

static void exposures_snap_to_whole_half_periods(void **state)
{
    (void)state;
    assert_int_equal(ttf_exposure_snap(20 * TTF_NS_PER_MS, 50, 0), 20 * TTF_NS_PER_MS);
    assert_int_equal(ttf_exposure_snap(23 * TTF_NS_PER_MS, 50, 0), 20 * TTF_NS_PER_MS);
    assert_int_equal(ttf_exposure_snap(26 * TTF_NS_PER_MS, 50, 0), 30 * TTF_NS_PER_MS);
    assert_int_equal(ttf_exposure_snap(20 * TTF_NS_PER_MS, 60, 0), 16666667);
}

static void the_shortest_is_one_half_period(void **state)
{
    (void)state;
    assert_int_equal(ttf_exposure_snap(100 * TTF_NS_PER_US, 50, 0), 10 * TTF_NS_PER_MS);
}

static void the_camera_s_longest_is_not_passed(void **state)
{
    (void)state;
    assert_int_equal(ttf_exposure_snap(99 * TTF_NS_PER_MS, 50, 95 * TTF_NS_PER_MS),
                     90 * TTF_NS_PER_MS);
    assert_int_equal(ttf_exposure_snap(99 * TTF_NS_PER_MS, 50, 5 * TTF_NS_PER_MS), 0);
}

static void without_mains_nothing_snaps(void **state)
{
    (void)state;
    assert_int_equal(ttf_exposure_snap(12345678, 0, 0), 12345678);
}

static void brackets_snap_as_well(void **state)
{
    struct ttf_plan plan;
    struct ttf_exposure e;

    (void)state;
    ttf_plan_defaults(&plan);
    plan.shots[0].n_brackets = 3;
    plan.shots[0].brackets[0] = 0.5;
    plan.shots[0].brackets[1] = 1;
    plan.shots[0].brackets[2] = 2.2;
    e = ttf_shot_exposure(&plan.shots[0], 0, 50, 0);
    assert_int_equal(e.exposure_ns, 10 * TTF_NS_PER_MS);
    e = ttf_shot_exposure(&plan.shots[0], 2, 50, 0);
    assert_int_equal(e.exposure_ns, 40 * TTF_NS_PER_MS);
    assert_int_equal(ttf_shot_images(&plan.shots[0]), 3);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(exposures_snap_to_whole_half_periods),
        cmocka_unit_test(the_shortest_is_one_half_period),
        cmocka_unit_test(the_camera_s_longest_is_not_passed),
        cmocka_unit_test(without_mains_nothing_snaps),
        cmocka_unit_test(brackets_snap_as_well),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
