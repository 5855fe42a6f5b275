/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The memory of a running capture: after arming our code allocates nothing, libraries give
 * back what they took with each slot, and nothing grows. memory_capture SLOTS runs the last
 * for so many slots (`./dev memory`: 4,000), else it is a test of some hundred.
 */
#include "cmocka_includes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "memory_watch.h"

#define SLOTS 200

/* What a page here and there may differ by without anything growing. */
#define RESIDENT_NOISE_KB 256

static int64_t slots = SLOTS;

static void expect_nothing_allocated(const struct memory_watch *w)
{
    assert_int_equal(w->last.ours.calls - w->armed.ours.calls, 0);
    if (!alloc_hook_sees_all())
        return;
    assert_int_equal(w->live_off, 0);
    assert_int_equal(w->live_off_bytes, 0);
}

static void expect_no_growth(const struct memory_watch *w)
{
    if (!alloc_hook_sees_all())
        return;
    assert_int_equal(w->last.ours.live, w->early.ours.live);
    assert_int_equal(w->last.ours.live_bytes, w->early.ours.live_bytes);
    assert_int_equal(w->last.all.live, w->early.all.live);
    assert_int_equal(w->last.all.live_bytes, w->early.all.live_bytes);
    assert_in_range(w->last.resident_kb + RESIDENT_NOISE_KB - w->early.resident_kb, 0,
                    2 * RESIDENT_NOISE_KB);
}

static void a_rich_capture_allocates_nothing_after_arming(void **state)
{
    struct memory_watch w;

    (void)state;
    memory_watch_init(&w);
    memory_watch_rich(&w, SLOTS);
    memory_watch_run(&w);
    assert_int_equal(w.run.result.captured, SLOTS);
    expect_nothing_allocated(&w);
    expect_no_growth(&w);
    memory_watch_finish(&w);
}

static void nor_does_one_whose_box_fails_now_and_then(void **state)
{
    struct memory_watch w;

    (void)state;
    memory_watch_init(&w);
    memory_watch_rich(&w, SLOTS);
    memory_watch_faults(&w);
    memory_watch_run(&w);
    assert_true(w.events > SLOTS / 4);
    assert_true(w.run.result.captured > SLOTS / 2);
    expect_nothing_allocated(&w);
    expect_no_growth(&w);
    memory_watch_finish(&w);
}

static void a_long_capture_does_not_grow(void **state)
{
    struct memory_watch w;

    (void)state;
    memory_watch_init(&w);
    w.run.plan.count = slots;
    w.run.plan.lamps = TTF_LAMPS_PHOTOPERIOD;
    w.run.plan.period_ns = TTF_NS_PER_DAY;
    w.run.plan.day_ns = TTF_NS_PER_DAY / 2;
    memory_watch_faults(&w);
    memory_watch_run(&w);
    expect_nothing_allocated(&w);
    expect_no_growth(&w);
    memory_watch_finish(&w);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_rich_capture_allocates_nothing_after_arming),
        cmocka_unit_test(nor_does_one_whose_box_fails_now_and_then),
        cmocka_unit_test(a_long_capture_does_not_grow),
    };

    if (argc > 1)
        slots = strtoll(argv[1], NULL, 10);
    return cmocka_run_group_tests(tests, NULL, NULL);
}
