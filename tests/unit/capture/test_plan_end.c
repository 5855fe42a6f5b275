/* SPDX-License-Identifier: Apache-2.0 */
/* How many slots a plan comes to that ends in time, by what is known of the run's clock. */
#include "cmocka_includes.h"

#include "plan_end.h"
#include "ttf/base/time.h"

#define S    TTF_NS_PER_S
#define UTC0 (INT64_C(1700000000) * S)

/* A slot a minute; slot 0 was due at boot clock 100 s = UTC0. Ends an hour later. */
static const struct ttf_grid GRID = {0, 100 * S, TTF_NS_PER_MIN};
static const struct ttf_run_clock KNOWN = {100 * S, 0, UTC0 - 100 * S, TTF_TRUST_NTP};
static const struct ttf_plan UNTIL = {.interval_ns = TTF_NS_PER_MIN,
                                      .count = 60,
                                      .end = TTF_END_UNTIL,
                                      .until_utc_ns = UTC0 + TTF_NS_PER_H};
static const struct ttf_plan LENGTH = {
    .interval_ns = TTF_NS_PER_MIN, .count = 60, .end = TTF_END_LENGTH, .length_ns = TTF_NS_PER_H};

static void the_slots_due_before_the_end_are_counted(void **state)
{
    struct ttf_plan plan = UNTIL;

    (void)state;
    plan.count = 7; /* of another grid */
    assert_int_equal(ttf_plan_slots(&plan, &GRID, &KNOWN), 60);
    plan.until_utc_ns += 2 * S;
    assert_int_equal(ttf_plan_slots(&plan, &GRID, &KNOWN), 61);
    plan = LENGTH;
    plan.count = 7;
    assert_int_equal(ttf_plan_slots(&plan, &GRID, &KNOWN), 60);
    plan.end = TTF_END_COUNT;
    assert_int_equal(ttf_plan_slots(&plan, &GRID, &KNOWN), 7);
    plan.end = TTF_END_UNTOLD;
    assert_int_equal(ttf_plan_slots(&plan, &GRID, &KNOWN), 7);
}

static void outages_that_no_slot_stands_for_count_in_a_length(void **state)
{
    struct ttf_run_clock clock = KNOWN;

    (void)state;
    clock.gaps_ns = 10 * TTF_NS_PER_MIN;
    assert_int_equal(ttf_plan_slots(&LENGTH, &GRID, &clock), 50);
    assert_int_equal(ttf_plan_slots(&UNTIL, &GRID, &clock), 60); /* UTC says all of it */
}

static void an_instant_that_nobody_can_tell_leaves_the_count(void **state)
{
    const struct ttf_run_clock unknown = {100 * S, 0, TTF_NS_UNKNOWN, TTF_TRUST_NONE};

    (void)state;
    assert_int_equal(ttf_plan_end_ns(&UNTIL, &unknown), TTF_NS_UNKNOWN);
    assert_int_equal(ttf_plan_slots(&UNTIL, &GRID, &unknown), 60);
    assert_false(ttf_plan_end_passed(&UNTIL, &GRID, 1000, &unknown));
}

/* Clocks are corrected by less than a second all the time: that adds and takes no slot. */
static void a_correction_of_less_than_a_second_leaves_the_count(void **state)
{
    static const struct {
        int64_t utc_behind_ns, slots;
    } cases[] = {
        {S - 1, 60}, {1 - S, 60}, {S + 1, 61}, {-S - 1, 60}, {-TTF_NS_PER_MIN - S - 1, 59}};

    (void)state;
    for (unsigned i = 0; i < 5; i++) {
        struct ttf_run_clock clock = KNOWN;

        clock.utc_offset_ns -= cases[i].utc_behind_ns;
        assert_int_equal(ttf_plan_slots(&UNTIL, &GRID, &clock), cases[i].slots);
    }
}

static void ten_slots_a_second_are_counted_to_the_half_of_one(void **state)
{
    const struct ttf_grid fast = {0, 100 * S, 100 * TTF_NS_PER_MS};
    struct ttf_run_clock clock = KNOWN;
    struct ttf_plan plan = UNTIL;

    (void)state;
    plan.count = 36000;
    clock.utc_offset_ns -= 40 * TTF_NS_PER_MS;
    assert_int_equal(ttf_plan_slots(&plan, &fast, &clock), 36000);
    clock.utc_offset_ns -= 20 * TTF_NS_PER_MS;
    assert_int_equal(ttf_plan_slots(&plan, &fast, &clock), 36001);
}

static void an_end_before_the_grid_leaves_what_came_before_it(void **state)
{
    const struct ttf_grid later = {20, 100 * S + 3 * TTF_NS_PER_H, TTF_NS_PER_MIN};

    (void)state;
    assert_int_equal(ttf_plan_slots(&UNTIL, &later, &KNOWN), 20);
    assert_true(ttf_plan_end_passed(&UNTIL, &later, 20, &KNOWN));
    assert_false(ttf_plan_end_passed(&UNTIL, &GRID, 60, &KNOWN));
    assert_true(ttf_plan_end_passed(&UNTIL, &GRID, 61, &KNOWN));
    assert_false(ttf_plan_end_passed(&UNTIL, &later, 0, &KNOWN));
}

static void a_clock_of_1970_asks_for_no_more_than_a_plan_may(void **state)
{
    const struct ttf_grid fast = {0, 100 * S, 100 * TTF_NS_PER_MS};
    const struct ttf_run_clock old = {100 * S, 0, 0, TTF_TRUST_NTP};
    struct ttf_plan plan = UNTIL;

    (void)state;
    assert_int_equal(ttf_plan_slots(&UNTIL, &fast, &old), 1000000000);
    plan = LENGTH;
    plan.length_ns = INT64_MAX;
    assert_int_equal(ttf_plan_end_ns(&plan, &KNOWN), TTF_NS_NEVER);
    assert_int_equal(ttf_plan_slots(&plan, &fast, &KNOWN), 1000000000);
}

static void a_pc_s_word_alone_ends_no_run(void **state)
{
    const struct ttf_grid late = {0, 100 * S + TTF_NS_PER_H, TTF_NS_PER_MIN};

    (void)state;
    assert_false(ttf_run_clock_believed(&UNTIL, &GRID, 61, &KNOWN, true));
    assert_true(ttf_run_clock_believed(&UNTIL, &GRID, 61, &KNOWN, false));
    assert_true(ttf_run_clock_believed(&UNTIL, &GRID, 60, &KNOWN, true)); /* it comes next */
    assert_true(ttf_run_clock_believed(&UNTIL, &GRID, 0, &KNOWN, true));
    assert_false(ttf_run_clock_believed(&UNTIL, &late, 0, &KNOWN, true)); /* and none was taken */
    assert_true(ttf_run_clock_believed(&UNTIL, &late, 0, &KNOWN, false));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_slots_due_before_the_end_are_counted),
        cmocka_unit_test(outages_that_no_slot_stands_for_count_in_a_length),
        cmocka_unit_test(an_instant_that_nobody_can_tell_leaves_the_count),
        cmocka_unit_test(a_correction_of_less_than_a_second_leaves_the_count),
        cmocka_unit_test(ten_slots_a_second_are_counted_to_the_half_of_one),
        cmocka_unit_test(an_end_before_the_grid_leaves_what_came_before_it),
        cmocka_unit_test(a_clock_of_1970_asks_for_no_more_than_a_plan_may),
        cmocka_unit_test(a_pc_s_word_alone_ends_no_run),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
