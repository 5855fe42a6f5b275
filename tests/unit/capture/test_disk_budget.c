/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/capture/disk_budget.h"

/* The machine's files on a disk of any size. */
static struct ttf_io_ops small_ops;
static struct ttf_io small = {&small_ops};
static int64_t free_bytes;

static int say_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    (void)io;
    (void)path;
    *ret = (struct ttf_io_space){.free_bytes = free_bytes, .total_bytes = INT64_C(1) << 40};
    return 0;
}

static char folder[64];

static int set_up(void **state)
{
    (void)state;
    small_ops = *ttf_io_posix()->ops;
    small_ops.space = say_space;
    strcpy(folder, "/tmp/ttf-budget-XXXXXX");
    return mkdtemp(folder) ? 0 : -1;
}

static int tear_down(void **state)
{
    (void)state;
    return rmdir(folder); /* fails if the probe was left behind */
}

static void plan_of(struct ttf_plan *plan, struct ttf_plan_figures *figures)
{
    ttf_plan_defaults(plan);
    plan->interval_ns = TTF_NS_PER_MIN;
    plan->count = 100;
    plan->reserve_bytes = 1000000;
    *figures = (struct ttf_plan_figures){.slots = 100, .slot_bytes = 1000000, .bytes = 100000000};
}

static void a_plan_that_fits_is_let_through(void **state)
{
    struct ttf_plan plan;
    struct ttf_plan_figures figures;
    struct ttf_disk_figures disk;

    (void)state;
    plan_of(&plan, &figures);
    free_bytes = 101000000;
    assert_int_equal(ttf_disk_budget_check(&small, folder, NULL, &plan, &figures, &disk, NULL), 0);
    assert_int_equal(disk.slots_that_fit, 100);
}

static void a_plan_that_does_not_fit_hears_what_would(void **state)
{
    struct ttf_plan plan;
    struct ttf_plan_figures figures;
    struct ttf_disk_figures disk;
    struct ttf_err err;
    char path[96];

    (void)state;
    plan_of(&plan, &figures);
    free_bytes = 100999999;
    /* The dataset itself need not be there yet. */
    snprintf(path, sizeof(path), "%s/new/dataset", folder);
    assert_int_equal(ttf_disk_budget_check(&small, path, NULL, &plan, &figures, &disk, &err),
                     -ENOSPC);
    assert_int_equal(disk.slots_that_fit, 99);
    assert_non_null(strstr(err.hint, "99"));
}

static void speed_is_measured_in_real_time_and_leaves_nothing_behind(void **state)
{
    struct ttf_clock *clock = ttf_clock_real_create();
    struct ttf_plan plan;
    struct ttf_plan_figures figures;
    struct ttf_disk_figures disk;
    struct ttf_err err;

    (void)state;
    plan_of(&plan, &figures);
    free_bytes = INT64_C(1) << 40;
    assert_int_equal(ttf_disk_budget_check(&small, folder, clock, &plan, &figures, &disk, NULL), 0);
    assert_true(disk.bytes_per_s > 0);
    assert_true(disk.shortest_interval_ns > 0);
    /* A slot of a petabyte is more than any disk takes in a minute. */
    figures.slot_bytes = INT64_C(1) << 50;
    plan.count = 0;
    assert_int_equal(ttf_disk_budget_check(&small, folder, clock, &plan, &figures, &disk, &err),
                     -EINVAL);
    assert_string_equal(err.where, "interval");
    ttf_clock_destroy(clock);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_plan_that_fits_is_let_through),
        cmocka_unit_test(a_plan_that_does_not_fit_hears_what_would),
        cmocka_unit_test(speed_is_measured_in_real_time_and_leaves_nothing_behind),
    };

    return cmocka_run_group_tests(tests, set_up, tear_down);
}
