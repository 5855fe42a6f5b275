/* SPDX-License-Identifier: Apache-2.0 */
/* What clocks, and a PC's, tell of an outage: which grid it leaves, and what no waiting makes right. */
#include "cmocka_includes.h"

#include <stdio.h>
#include <string.h>

#include "until_run.h"

#define S   TTF_NS_PER_S
#define MIN TTF_NS_PER_MIN

#define POWER_FAILS (3 * MIN + 40 * S) /* behind slot 3 */
#define POWER_BACK  (POWER_FAILS + S)

/*
 * Off the grid, as nobody knew how late it was; the network tells; and the power fails before a slot of that segment was
 * due: its lamps settled. No clock was wrong.
 */
static void power_that_fails_again_before_a_slot_of_a_new_grid_leaves_that_grid(void **state)
{
    static const struct until_belief beliefs[] = {
        {0, TTF_TRUST_NTP, 0}, {24 * MIN, TTF_TRUST_NONE, 0}, {27 * MIN, TTF_TRUST_NTP, 0}};
    struct until_clock b;

    (void)state;
    /* Slots from 20:03 on, four until 23:40; the fifth is to be at 44:03, and lamps settle until 50:23. */
    until_clock_init(&b, TTF_END_COUNT, 14, beliefs, 3);
    b.run.plan.lamps = TTF_LAMPS_CONTINUOUS;
    b.run.plan.settle_ns = 20 * MIN;
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 23 * MIN + 40 * S)->amount = 20;
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, 30 * MIN)->amount = 20;
    assert_int_equal(sim_run_through_cuts(&b.run), 0);
    assert_int_equal(sim_run_events(&b.run, "resume", "lies before the last slot"), 0);
    assert_int_equal(sim_run_events(&b.run, "resume", "on the same grid"), 1);
    until_expect_end(&b.run, "ccccmmmmmmmccc", "count");
    living_finish(&b.run);
}

/* Half an hour slow it stood before the last slot, and is as slow when it has come past it. */
static void a_pc_that_contradicted_the_box_s_own_clock_is_no_better_later(void **state)
{
    static const struct until_belief beliefs[] = {{0, TTF_TRUST_NTP, 0},
                                                  {POWER_BACK, TTF_TRUST_HOST, -30 * MIN}};
    struct ttf_segment segment;
    struct until_clock b;

    (void)state;
    until_clock_init(&b, TTF_END_COUNT, 45, beliefs, 2);
    sim_run_fault(&b.run, TTF_FAULT_POWER_CUT, POWER_FAILS)->amount = 15;
    assert_int_equal(sim_run_through_cuts(&b.run), 0);
    (void)sim_run_segment_of(&b.run, 44, &segment);
    assert_string_equal(segment.trust, "none");
    assert_int_equal(sim_run_events(&b.run, "clock", "lies before the last slot"), 1);
    assert_int_equal(sim_run_events(&b.run, "clock", "contradicts the last slot of before no more"),
                     0);
    until_expect_end(&b.run, "ccccccccccccccccccccccccccccccccccccccccccccc", "count");
    living_finish(&b.run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(power_that_fails_again_before_a_slot_of_a_new_grid_leaves_that_grid),
        cmocka_unit_test(a_pc_that_contradicted_the_box_s_own_clock_is_no_better_later),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
