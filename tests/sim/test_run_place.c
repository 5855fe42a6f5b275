/* SPDX-License-Identifier: Apache-2.0 */
/* Another folder comes to lie where the dataset is: a disk that was mounted late, or went and came back. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "second_run.h"

static char disk[128],
    hidden[128];           /* paths: what is mounted over the dataset, and where that lies then */
static int64_t mounted_at; /* once so many slots have their records */

static void move(const char *from, const char *to)
{
    assert_int_equal(rename(from, to), 0);
}

static void mount_over(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind != TTF_PROGRESS_SLOT || run->committed != mounted_at)
        return;
    mounted_at = -1;
    move(run->path, hidden);
    move(disk, run->path);
}

/* The same files by other numbers, as those of a disk that is mounted anew. */
static void copy_over(struct sim_run *run, const struct ttf_progress *progress)
{
    char line[300];

    if (progress->kind != TTF_PROGRESS_SLOT || run->committed != mounted_at)
        return;
    snprintf(line, sizeof(line), "cp -a %s %s", run->path, disk);
    assert_int_equal(system(line), 0); /* NOLINT(cert-env33-c,concurrency-mt-unsafe): a test's */
    mount_over(run, progress);
}

/* A run of two slots whose disk is late at the next boot, which begins a run beneath the mount point. */
static void begin_beneath(struct sim_run *run, bool second)
{
    if (second)
        second_run_init(run);
    else
        sim_run_init(run);
    snprintf(disk, sizeof(disk), "%s.disk", run->path);
    snprintf(hidden, sizeof(hidden), "%s.hidden", run->path);
    sim_run_fault(run, TTF_FAULT_POWER_CUT, TTF_NS_PER_MIN + 40 * TTF_NS_PER_S);
    assert_int_equal(sim_run_boot(run), -ESHUTDOWN);
    sim_run_expect(run, "cc");
    move(run->path, disk);
    run->config.power_on_ns = run->back_ns;
    run->on_progress = mount_over;
}

/* Not between two looks, but while an image is being written. */
static int mount_over_at_image(struct sim_run *run, const char *op, const char *path)
{
    (void)op;
    if (run->committed == mounted_at && strstr(path, "frames/main/000002"))
        mount_over(run, &(struct ttf_progress){.kind = TTF_PROGRESS_SLOT});
    return 0;
}

static int count_file(void *ctx, const char *name, bool is_dir)
{
    (void)name;
    *(unsigned *)ctx += !is_dir;
    return 0;
}

static unsigned frames(const struct sim_run *run)
{
    char path[160];
    unsigned n = 0;

    snprintf(path, sizeof(path), "%s/frames/main", run->path);
    assert_int_equal(ttf_io_posix()->ops->list(ttf_io_posix(), path, count_file, &n), 0);
    return n;
}

static struct sim_run beneath(const struct sim_run *run)
{
    struct sim_run other = *run;

    snprintf(other.path, sizeof(other.path), "%.90s", hidden);
    return other;
}

static void expect_begun_again(struct sim_run *run)
{
    const struct sim_run other = beneath(run);

    assert_int_equal(run->code, -ESTALE);
    assert_non_null(strstr(run->alarm_text, "another folder lies where the run began"));
    assert_false(run->result.second_storage);
    /* Nothing of the one came into the other. */
    sim_run_expect(run, "cc");
    sim_run_expect_undamaged(run, false);
    sim_run_expect_undamaged(&other, false);
    run->config.power_on_ns = run->ended_ns;
    assert_int_equal(sim_run_boot(run), 0);
    assert_false(run->result.second_storage);
    sim_run_expect_whole(run, true);
    sim_run_expect_undamaged(&other, false);
}

static void a_disk_that_is_mounted_late_over_a_run_is_gone_on_with_instead(void **state)
{
    struct sim_run run, other;

    for (int second = 0; second < 2; second++) {
        begin_beneath(&run, second == 1);
        mounted_at = 2;
        (void)sim_run_boot(&run);
        other = beneath(&run);
        sim_run_expect(&other, "cc");
        assert_int_equal(frames(&run), 2);
        expect_begun_again(&run);
        sim_run_finish(&run);
    }
    (void)state;
}

/* What fails then is no storage that has failed: the second one has nothing to do with it. */
static void one_that_is_mounted_while_an_image_is_written_leaves_no_record_there(void **state)
{
    struct sim_run run, second;
    char results[32];

    (void)state;
    begin_beneath(&run, true);
    run.on_progress = NULL;
    run.fault = mount_over_at_image;
    mounted_at = 2;
    (void)sim_run_boot(&run);
    assert_int_equal(mounted_at, -1);
    second = second_run_of(&run);
    second_run_results(&second, results);
    assert_int_equal(results[0], '-');
    assert_int_equal(results[2], '-');
    expect_begun_again(&run);
    sim_run_finish(&run);
}

/* All slots have their records: it is no seal of the other one. */
static void one_that_is_mounted_before_the_seal_is_not_sealed_by_it(void **state)
{
    struct sim_run run, other;

    (void)state;
    begin_beneath(&run, false);
    mounted_at = 6;
    (void)sim_run_boot(&run);
    other = beneath(&run);
    sim_run_expect(&other, "cccccc");
    expect_begun_again(&run);
    sim_run_finish(&run);
}

static void take_away(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind != TTF_PROGRESS_SLOT || run->committed != mounted_at)
        return;
    mounted_at = -1;
    move(run->path, hidden);
}

/* A new disk, say: nothing of this run is made on it that the next one would stumble over. */
static void where_nothing_lies_any_more_the_run_is_begun_anew(void **state)
{
    struct sim_run run, other;

    (void)state;
    sim_run_init(&run);
    snprintf(hidden, sizeof(hidden), "%s.hidden", run.path);
    run.on_progress = take_away;
    mounted_at = 2;
    assert_true(sim_run_boot(&run) < 0);
    assert_true(access(run.path, F_OK) < 0);
    other = beneath(&run);
    sim_run_expect_undamaged(&other, false);
    run.config.power_on_ns = run.ended_ns;
    run.on_progress = NULL;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* A disk that was taken away is a storage that has failed. */
static void where_nothing_lies_any_more_the_second_storage_takes_over(void **state)
{
    struct sim_run run, second;
    char results[32];

    (void)state;
    second_run_init(&run);
    snprintf(hidden, sizeof(hidden), "%s.hidden", run.path);
    run.on_progress = take_away;
    mounted_at = 2;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.second_storage);
    assert_true(access(run.path, F_OK) < 0);
    second = second_run_of(&run);
    second_run_results(&second, results);
    assert_memory_equal(results, "--cccc-", 7);
    sim_run_finish(&run);
}

static void a_disk_that_went_and_came_back_costs_nothing(void **state)
{
    static const int64_t AT[] = {2, 6}; /* under way; before the seal */
    struct sim_run run;

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        sim_run_init(&run);
        snprintf(disk, sizeof(disk), "%s.disk", run.path);
        snprintf(hidden, sizeof(hidden), "%s.hidden", run.path);
        run.on_progress = copy_over;
        mounted_at = AT[i];
        assert_int_equal(sim_run_boot(&run), 0);
        assert_int_equal(mounted_at, -1);
        sim_run_expect(&run, "cccccc");
        sim_run_expect_whole(&run, true);
        assert_int_equal(frames(&run), 6);
        sim_run_finish(&run);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_disk_that_is_mounted_late_over_a_run_is_gone_on_with_instead),
        cmocka_unit_test(one_that_is_mounted_while_an_image_is_written_leaves_no_record_there),
        cmocka_unit_test(one_that_is_mounted_before_the_seal_is_not_sealed_by_it),
        cmocka_unit_test(where_nothing_lies_any_more_the_run_is_begun_anew),
        cmocka_unit_test(where_nothing_lies_any_more_the_second_storage_takes_over),
        cmocka_unit_test(a_disk_that_went_and_came_back_costs_nothing),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
