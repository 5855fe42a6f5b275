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
static int space_says;
static bool read_only;

static int say_space(struct ttf_io *io, const char *path, struct ttf_io_space *ret)
{
    (void)io;
    (void)path;
    *ret = (struct ttf_io_space){
        .free_bytes = free_bytes, .total_bytes = INT64_C(1) << 40, .read_only = read_only};
    return space_says;
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

static void what_has_no_room_hears_how_much_it_needs_and_there_is(void **state)
{
    struct ttf_err err = {0};
    char path[96];

    (void)state;
    snprintf(path, sizeof(path), "%s/new/calibration", folder);
    free_bytes = 2000000;
    assert_int_equal(ttf_disk_room_check(&small, path, "a calibration", 2000000, &err), 0);
    assert_int_equal(ttf_disk_room_check(&small, path, "a calibration", 2000001, &err), -ENOSPC);
    assert_string_equal(err.what, "a calibration needs 2.0 MB; 2.0 MB are free");
    read_only = true;
    assert_int_equal(ttf_disk_room_check(&small, path, "a calibration", 1, &err), -EROFS);
    read_only = false;
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

static void a_disk_that_cannot_be_asked_or_only_read_is_refused(void **state)
{
    struct ttf_plan plan;
    struct ttf_plan_figures figures;
    struct ttf_err err;

    (void)state;
    plan_of(&plan, &figures);
    free_bytes = INT64_C(1) << 40;
    space_says = -EIO;
    assert_int_equal(ttf_disk_budget_check(&small, folder, NULL, &plan, &figures, NULL, &err),
                     -EIO);
    assert_non_null(strstr(err.what, "cannot be found out"));
    space_says = 0;
    read_only = true;
    assert_int_equal(ttf_disk_budget_check(&small, folder, NULL, &plan, &figures, NULL, &err),
                     -EROFS);
    read_only = false;
}

static void a_plan_that_keeps_nothing_needs_no_room(void **state)
{
    struct ttf_plan plan;
    struct ttf_plan_figures figures;

    (void)state;
    plan_of(&plan, &figures);
    free_bytes = 0;
    figures.slot_bytes = figures.bytes = 0;
    assert_int_equal(ttf_disk_budget_check(&small, folder, NULL, &plan, &figures, NULL, NULL), 0);
    /* The reserve alone is more than there is. */
    figures.slot_bytes = 1;
    assert_int_equal(ttf_disk_budget_check(&small, folder, NULL, &plan, &figures, NULL, NULL),
                     -ENOSPC);
}

static void a_path_is_looked_up_as_far_as_it_is_there(void **state)
{
    static char path[5000];
    struct ttf_plan plan;
    struct ttf_plan_figures figures;

    (void)state;
    plan_of(&plan, &figures);
    free_bytes = INT64_C(1) << 40;
    assert_int_equal(
        ttf_disk_budget_check(&small, "/no-such/folder/d", NULL, &plan, &figures, NULL, NULL), 0);
    assert_int_equal(ttf_disk_budget_check(&small, "d", NULL, &plan, &figures, NULL, NULL), 0);
    memset(path, 'a', sizeof(path) - 1);
    assert_int_equal(ttf_disk_budget_check(&small, path, NULL, &plan, &figures, NULL, NULL),
                     -ENAMETOOLONG);
}

static const char *fails_op;

static int fail_one(void *ctx, const char *op, const char *path)
{
    (void)ctx;
    return strcmp(op, fails_op) == 0 && strstr(path, ".tmp") ? EIO : 0;
}

/* Found out at the beginning, not at the first slot. */
static void a_disk_that_takes_nothing_is_refused_and_nothing_stays_on_it(void **state)
{
    static const char *const ops[] = {"open", "pwrite", "sync", "unlink"};
    struct ttf_clock *clock = ttf_clock_real_create();
    struct ttf_io *bad = ttf_io_faulty_create(&small, fail_one, NULL);
    struct ttf_plan plan;
    struct ttf_plan_figures figures;
    struct ttf_err err;

    (void)state;
    assert_non_null(bad);
    plan_of(&plan, &figures);
    free_bytes = INT64_C(1) << 40;
    snprintf(plan.second_storage, sizeof(plan.second_storage), "%s", folder);
    for (unsigned i = 0; i < 4; i++) {
        fails_op = ops[i];
        assert_int_equal(ttf_disk_budget_check(bad, folder, clock, &plan, &figures, NULL, &err),
                         -EIO);
        assert_non_null(strstr(err.what, "nothing can be written"));
        assert_int_equal(ttf_second_storage_check(bad, "", &plan, NULL, &err), -EIO);
        assert_string_equal(err.where, "storage.second");
    }
    ttf_io_faulty_destroy(bad);
    ttf_clock_destroy(clock);
}

static void a_second_storage_must_be_another_folder_that_is_there(void **state)
{
    struct ttf_io *io = ttf_io_posix();
    struct ttf_plan plan;
    struct ttf_plan_figures figures;
    struct ttf_err err;
    char path[96];
    char file[96];
    bool same = true;
    FILE *f;

    (void)state;
    plan_of(&plan, &figures);
    assert_int_equal(ttf_second_storage_check(io, folder, &plan, &same, NULL), 0);
    assert_false(same); /* there is none */
    snprintf(plan.second_storage, sizeof(plan.second_storage), "%s/none", folder);
    assert_int_equal(ttf_second_storage_check(io, folder, &plan, NULL, &err), -ENOENT);
    assert_non_null(strstr(err.hint, "mount"));
    snprintf(file, sizeof(file), "%s/file", folder);
    f = fopen(file, "w");
    assert_non_null(f);
    if (f)
        assert_int_equal(fclose(f), 0);
    snprintf(plan.second_storage, sizeof(plan.second_storage), "%s", file);
    assert_int_equal(ttf_second_storage_check(io, folder, &plan, NULL, &err), -ENOTDIR);
    assert_non_null(strstr(err.what, "no folder"));
    assert_int_equal(remove(file), 0);
    /* A dataset in the folder itself; beside it on the same disk is worth a warning only. */
    snprintf(plan.second_storage, sizeof(plan.second_storage), "%s", folder);
    snprintf(path, sizeof(path), "%s/dataset", folder);
    assert_int_equal(ttf_second_storage_check(io, path, &plan, NULL, &err), -EINVAL);
    assert_non_null(strstr(err.hint, "another disk"));
    assert_int_equal(ttf_second_storage_check(io, "/tmp/no-dataset", &plan, &same, NULL), 0);
    assert_true(same);
    assert_int_equal(ttf_second_storage_check(io, "/tmp/no-dataset", &plan, NULL, NULL), 0);
    assert_int_equal(ttf_second_storage_check(io, "/proc/none", &plan, &same, NULL), 0);
    assert_false(same);
    assert_int_equal(ttf_second_storage_check(io, "", &plan, &same, NULL), 0);
    assert_false(same); /* not known yet where the dataset will be */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_disk_that_cannot_be_asked_or_only_read_is_refused),
        cmocka_unit_test(a_plan_that_keeps_nothing_needs_no_room),
        cmocka_unit_test(a_path_is_looked_up_as_far_as_it_is_there),
        cmocka_unit_test(a_disk_that_takes_nothing_is_refused_and_nothing_stays_on_it),
        cmocka_unit_test(a_second_storage_must_be_another_folder_that_is_there),
        cmocka_unit_test(a_plan_that_fits_is_let_through),
        cmocka_unit_test(what_has_no_room_hears_how_much_it_needs_and_there_is),
        cmocka_unit_test(a_plan_that_does_not_fit_hears_what_would),
        cmocka_unit_test(speed_is_measured_in_real_time_and_leaves_nothing_behind),
    };

    return cmocka_run_group_tests(tests, set_up, tear_down);
}
