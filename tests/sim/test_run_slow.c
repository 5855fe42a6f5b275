/* SPDX-License-Identifier: Apache-2.0 */
/* A storage that is slower than the plan, for a while or always (capture/README.md, "The way of a slot"). */
#include "cmocka_includes.h"

#include <stdio.h>
#include <string.h>

#include "sim_run.h"

/* The storage stands still once, as slot 2 is written, for so long. */
static int64_t still_ns;

static void stand_still_once(struct sim_run *run)
{
    int64_t for_ns = still_ns;

    if (run->committed != 2 || for_ns == 0)
        return;
    still_ns = 0;
    ttf_clock_wait_until(run->box->clock, ttf_clock_now_ns(run->box->clock) + for_ns);
}

static void run_with_a_standstill(struct sim_run *run, int64_t count, int64_t for_ns)
{
    sim_run_init(run);
    run->plan.count = count;
    run->on_file = stand_still_once;
    still_ns = for_ns;
    assert_int_equal(sim_run_boot(run), 0);
    assert_int_equal(still_ns, 0);
    sim_run_expect_whole(run, true);
}

static void a_storage_that_stands_still_for_some_intervals_costs_no_slot(void **state)
{
    struct sim_run run;

    (void)state;
    run_with_a_standstill(&run, 16, 10 * TTF_NS_PER_MIN);
    sim_run_expect(&run, "cccccccccccccccc");
    sim_run_finish(&run);
}

/* So many are held, and no more: the memory of a run is bounded, whatever the storage does. */
static void a_storage_that_stands_still_for_long_costs_what_nothing_can_hold(void **state)
{
    struct sim_run run;
    char results[64];
    size_t missed = 0;

    (void)state;
    run_with_a_standstill(&run, 40, 30 * TTF_NS_PER_MIN);
    sim_run_results(&run, results, sizeof(results));
    for (const char *r = results; *r; r++)
        missed += *r == 'm';
    assert_int_equal(strlen(results), 40);
    assert_in_range(missed, 12, 16);
    assert_int_equal(run.result.captured, 40 - missed);
    sim_run_expect_reason(&run, strchr(results, 'm') - results, "storage too slow");
    sim_run_finish(&run);
}

static void storage_slower_than_the_plan_misses_slots_and_says_so(void **state)
{
    struct sim_run run;
    char results[64];

    (void)state;
    sim_run_init(&run);
    run.plan.count = 60;
    run.config.cost_commit_ns = 100 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_results(&run, results, sizeof(results));
    assert_int_equal(strlen(results), 60);
    assert_non_null(strchr(results, 'm'));
    assert_null(strchr(results, 'f'));
    sim_run_expect_reason(&run, strchr(results, 'm') - results, "storage too slow");
    assert_true(run.result.captured >= 30);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_storage_that_stands_still_for_some_intervals_costs_no_slot),
        cmocka_unit_test(a_storage_that_stands_still_for_long_costs_what_nothing_can_hold),
        cmocka_unit_test(storage_slower_than_the_plan_misses_slots_and_says_so),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
