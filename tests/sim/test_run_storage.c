/* SPDX-License-Identifier: Apache-2.0 */
/* Storage that fails for good: the run goes on in the plan's second one, or stops with an alarm. */
#include "cmocka_includes.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "second_run.h"

/* What the first storage does from slot `fails_from` on. */
static int fails_with;
static int64_t fails_from, fails_until;
static const char *fails_op; /* NULL: any */
static bool fails_both;      /* the second one too */

static int fail_first(struct sim_run *run, const char *op, const char *path)
{
    if ((!fails_both && second_run_holds(path)) || run->committed < fails_from ||
        run->committed >= fails_until)
        return 0;
    return !fails_op || strcmp(op, fails_op) == 0 ? fails_with : 0;
}

static void with_second(struct sim_run *run)
{
    second_run_init(run);
    run->fault = fail_first;
    fails_with = 0;
    fails_from = 2;
    fails_until = INT64_MAX;
    fails_op = NULL;
    fails_both = false;
}

static void expect_group(const struct sim_run *run)
{
    struct sim_run second = second_run_of(run);
    struct ttf_manifest a, b;

    assert_int_equal(ttf_manifest_load(ttf_io_posix(), run->path, &a, NULL), 0);
    assert_int_equal(ttf_manifest_load(ttf_io_posix(), second.path, &b, NULL), 0);
    assert_string_equal(a.group_uuid, a.uuid);
    assert_string_equal(a.group_member, "first");
    assert_string_equal(b.group_uuid, a.uuid);
    assert_string_equal(b.group_member, "second");
    assert_string_not_equal(b.uuid, a.uuid);
}

static int64_t utc_of(const struct sim_run *run, int64_t index)
{
    struct ttf_slot_record record;
    struct ttf_reader *reader;
    int64_t utc;

    sim_run_record(run, index, &record);
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run->path, &reader, NULL), 0);
    utc = ttf_reader_due_utc_ns(reader, &record);
    ttf_reader_close(reader);
    ttf_slot_record_free(&record);
    return utc;
}

static void expect_second_took_over(struct sim_run *run, const char *why)
{
    struct sim_run second = second_run_of(run);

    assert_int_equal(sim_run_boot(run), 0);
    assert_true(run->result.sealed);
    assert_true(run->result.second_storage);
    assert_int_equal(run->alarms, 1);
    assert_non_null(strstr(run->alarm_text, why));
    second_run_expect_both(run, "cccccc");
    expect_group(run);
    sim_run_expect_undamaged(run, false);
    sim_run_expect_undamaged(&second, true);
    /* The same grid. */
    assert_int_equal(utc_of(&second, 5) - utc_of(run, 0), 5 * TTF_NS_PER_MIN);
    assert_int_equal(sim_run_events(&second, "storage", why), 1);
    assert_true(run->result.error_max_ns < TTF_NS_PER_MS);
}

static void the_second_storage_takes_over_from_one_that_can_only_be_read(void **state)
{
    struct sim_run run;
    struct sim_run second;

    (void)state;
    with_second(&run);
    fails_with = EROFS;
    expect_second_took_over(&run, "can only be read");
    second = second_run_of(&run);
    sim_run_expect(&run, "cc");
    sim_run_expect_no_flag(&second, 2);
    sim_run_finish(&run);
}

static void the_second_storage_takes_over_from_one_that_gives_errors(void **state)
{
    struct sim_run run;

    (void)state;
    with_second(&run);
    fails_with = EIO;
    expect_second_took_over(&run, "storage error");
    sim_run_finish(&run);
}

/* Failed syncs only: the first dataset can still be told. */
static void after_two_failed_syncs_both_say_why(void **state)
{
    struct sim_run run;

    (void)state;
    with_second(&run);
    fails_with = EIO;
    fails_op = "sync_dir";
    expect_second_took_over(&run, "storage error");
    assert_int_equal(sim_run_events(&run, "storage", "goes on in the second storage, from slot 2"),
                     1);
    sim_run_finish(&run);
}

static void one_failure_is_no_reason_to_move(void **state)
{
    struct sim_run run;

    (void)state;
    with_second(&run);
    run.fault = NULL;
    sim_run_fault(&run, TTF_FAULT_IO_ERROR, 2 * TTF_NS_PER_MIN);
    assert_int_equal(sim_run_boot(&run), 0);
    assert_false(run.result.second_storage);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* A record that cannot be written: the images before it lie in the first dataset, and are fetched. */
static void images_of_a_slot_without_a_record_come_along(void **state)
{
    struct sim_run run;
    struct sim_run second;
    struct ttf_slot_record record;

    (void)state;
    with_second(&run);
    fails_with = EROFS;
    fails_op = "append"; /* of lines; image files are written otherwise */
    expect_second_took_over(&run, "can only be read");
    second = second_run_of(&run);
    sim_run_record(&second, 2, &record);
    assert_int_equal(record.images[0].n_files, 2);
    ttf_slot_record_free(&record);
    sim_run_finish(&run);
}

static void without_a_second_storage_the_run_stops_with_an_alarm(void **state)
{
    struct sim_run run;

    (void)state;
    with_second(&run);
    run.plan.second_storage[0] = '\0';
    fails_with = EROFS;
    assert_int_equal(sim_run_boot(&run), -EROFS);
    assert_int_equal(run.err.code, -EROFS);
    assert_true(run.err.what[0] != '\0');
    assert_int_equal(run.alarms, 1);
    assert_non_null(strstr(run.alarm_text, "names no second storage"));
    sim_run_expect(&run, "cc");
    sim_run_expect_undamaged(&run, false);
    /* Mended, it is gone on with. */
    fails_with = 0;
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect_undamaged(&run, true);
    sim_run_finish(&run);
}

static void both_storages_may_fail(void **state)
{
    struct sim_run run;

    (void)state;
    with_second(&run);
    fails_with = EROFS;
    fails_both = true;
    assert_int_equal(sim_run_boot(&run), -EROFS);
    assert_non_null(strstr(run.alarm_text, "second storage cannot be used"));
    sim_run_expect(&run, "cc");
    sim_run_expect_undamaged(&run, false);
    sim_run_finish(&run);
}

/* ---- gone on with ---- */

static void a_run_that_has_moved_on_resumes_there(void **state)
{
    struct sim_run run;
    struct sim_run second;

    (void)state;
    with_second(&run);
    run.plan.count = 8;
    fails_with = EIO;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount = 130;
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    fails_with = 0; /* as good as new: it is not gone back to */
    run.config.power_on_ns = run.back_ns;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.second_storage);
    second = second_run_of(&run);
    sim_run_expect(&run, "cc");
    second_run_expect_both(&run, "ccccwwcc");
    sim_run_expect_reason(&second, 4, "the box was without power");
    sim_run_expect_undamaged(&run, false);
    sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
}

static void a_storage_that_came_back_read_only_is_gone_on_from_in_the_second(void **state)
{
    struct sim_run run;
    struct sim_run second;

    (void)state;
    with_second(&run);
    run.plan.count = 8;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount = 130;
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    fails_with = EROFS;
    run.config.power_on_ns = run.back_ns;
    if (sim_run_boot(&run) < 0)
        print_error("%s: %s\n", run.err.where, run.err.what);
    assert_int_equal(run.code, 0);
    second = second_run_of(&run);
    sim_run_expect(&run, "cccc");
    second_run_expect_both(&run, "ccccwwcc");
    expect_group(&run);
    assert_int_equal(run.alarms, 1);
    assert_non_null(strstr(run.alarm_text, "goes on in the second storage, from slot 4 on"));
    assert_non_null(strstr(run.alarm_text, run.path));
    assert_int_equal(utc_of(&second, 7) - utc_of(&run, 0), 7 * TTF_NS_PER_MIN);
    sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
}

/* Moved, and cut off there; then its disk is gone, and its mount point a folder like any other. Power is back. */
static void move_and_unplug(struct sim_run *run, char ret_disk[128])
{
    with_second(run);
    run->plan.count = 10;
    fails_with = EIO;
    fails_op = "sync_dir"; /* the first can still be told */
    sim_run_fault(run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount = 130;
    assert_int_equal(sim_run_boot(run), -ESHUTDOWN);
    run->fault = NULL; /* room again, say */
    snprintf(ret_disk, 128, "%s/disk", run->folder);
    assert_int_equal(rename(run->plan.second_storage, ret_disk), 0);
    assert_int_equal(mkdir(run->plan.second_storage, 0755), 0);
    run->config.power_on_ns = run->back_ns;
}

static void plug_in(struct sim_run *run, const char *disk)
{
    assert_int_equal(rmdir(run->plan.second_storage), 0); /* nothing was begun beneath it */
    assert_int_equal(rename(disk, run->plan.second_storage), 0);
    run->config.power_on_ns += 2 * TTF_NS_PER_MIN;
}

static void a_second_storage_that_is_an_empty_mount_point_is_waited_for(void **state)
{
    struct sim_run run, second;
    char disk[128];

    (void)state;
    move_and_unplug(&run, disk);
    for (int i = 0; i < 2; i++) {
        assert_int_equal(sim_run_boot(&run), -ENODEV);
        assert_non_null(strstr(run.err.what, "went on in"));
        assert_non_null(strstr(run.err.what, "from slot 2 on"));
        sim_run_expect(&run, "cc"); /* not gone on with: its slots lie elsewhere */
    }
    /* Nor where it can only be read, which would be begun anew in the second one. */
    run.fault = fail_first;
    fails_with = EROFS;
    fails_op = NULL;
    fails_from = 0;
    assert_int_equal(sim_run_boot(&run), -ENODEV);
    plug_in(&run, disk);
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.second_storage);
    second = second_run_of(&run);
    sim_run_expect(&run, "cc");
    second_run_expect_both(&run, "ccccwwwwcc");
    sim_run_expect_undamaged(&run, false);
    sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
}

static void without_its_lost_second_disk_a_run_goes_on_by_a_plan_that_names_none(void **state)
{
    struct ttf_plan with;
    struct sim_run run;
    char disk[128];

    (void)state;
    move_and_unplug(&run, disk);
    with = run.plan;
    run.plan.second_storage[0] = '\0';
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 7 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount = 20;
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    sim_run_expect(&run, "ccwwwwcc");
    /* Then another disk in the lost one's place is as good as any. */
    run.plan = with;
    run.config.power_on_ns = run.back_ns;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_false(run.result.second_storage);
    sim_run_expect(&run, "ccwwwwcccc");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* The first disk is not there at all any more. */
static void the_second_dataset_is_enough_to_go_on_with(void **state)
{
    struct sim_run run;
    struct sim_run second;
    char away[128];

    (void)state;
    with_second(&run);
    run.plan.count = 8;
    fails_with = EIO;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 3 * TTF_NS_PER_MIN + 40 * TTF_NS_PER_S);
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    snprintf(away, sizeof(away), "%s.away", run.path);
    assert_int_equal(rename(run.path, away), 0);
    run.config.power_on_ns = run.back_ns;
    assert_int_equal(sim_run_boot(&run), 0);
    second = second_run_of(&run);
    assert_int_equal(rename(away, run.path), 0);
    second_run_expect_both(&run, "ccccwccc");
    sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
}

static void a_dataset_of_another_run_in_the_second_storage_is_left_alone(void **state)
{
    struct sim_run run;
    struct sim_run other;

    (void)state;
    with_second(&run);
    other = second_run_of(&run);
    other.plan.second_storage[0] = '\0';
    assert_int_equal(sim_run_boot(&other), 0);
    assert_int_equal(sim_run_boot(&run), -EEXIST);
    assert_non_null(strstr(run.err.what, "not of this run"));
    sim_run_expect_whole(&other, true);
    sim_run_finish(&run);
}

/* A change of plan, then the move: numbers of segments and plans begin anew, the grid does not. */
static void a_changed_plan_moves_too(void **state)
{
    struct sim_run run;
    struct sim_run second;
    struct ttf_slot_record record;

    (void)state;
    with_second(&run);
    run.plan.count = 10;
    run.control = ttf_control_create();
    for (int64_t at = 1; at <= 5; at += 4)
        assert_true(ttf_control_ask(run.control, &(struct ttf_ask){
                                                     .kind = TTF_ASK_INTERVAL,
                                                     .from_index = at,
                                                     .interval_ns = (at + 29) * TTF_NS_PER_S}) > 0);
    fails_from = 3;
    fails_with = EROFS;
    assert_int_equal(sim_run_boot(&run), 0);
    second = second_run_of(&run);
    second_run_expect_both(&run, "cccccccccc");
    sim_run_expect_undamaged(&second, true);
    sim_run_record(&second, 3, &record);
    assert_int_equal(record.segment, 0);
    ttf_slot_record_free(&record);
    sim_run_record(&second, 9, &record);
    assert_int_equal(record.segment, 1);
    ttf_slot_record_free(&record);
    assert_int_equal(utc_of(&second, 4) - utc_of(&run, 0), 4 * 30 * TTF_NS_PER_S);
    assert_int_equal(utc_of(&second, 9) - utc_of(&second, 4), 5 * 34 * TTF_NS_PER_S);
    ttf_control_destroy(run.control);
    sim_run_finish(&run);
}

/* ---- killed at every operation of the move; every fifth, unless TTF_THOROUGH is set ---- */

static unsigned operations, kill_at;

static int fail_and_die(struct sim_run *run, const char *op, const char *path)
{
    int error = fail_first(run, op, path);

    if (run->committed >= fails_from && ++operations == kill_at)
        _exit(77);
    return error;
}

static bool lost(const struct sim_run *run, int slot)
{
    char results[32];

    second_run_results(run, results);
    return results[slot] == 'w';
}

/* Gone on with after a kill, whatever it hit. */
static void expect_moved_all_the_same(struct sim_run *run)
{
    struct sim_run second = second_run_of(run);
    char results[32];

    run->committed = 2; /* the first disk still fails */
    run->config.power_on_ns = 150 * TTF_NS_PER_S;
    run->plan.count = 4;
    assert_int_equal(sim_run_boot(run), 0);
    if (!fails_op) { /* it takes nothing */
        sim_run_expect(run, "cc");
        second_run_results(&second, results);
        assert_memory_equal(results, "--", 2);
        assert_true(results[2] == 'c' || results[2] == 'w');
        assert_true(results[3] == 'c' && results[4] == '-');
    } else { /* it takes records, and may be gone on with until its next image */
        second_run_expect_both(run, lost(run, 2) || lost(&second, 2) ? "ccwc" : "cccc");
    }
    expect_group(run);
    sim_run_expect_undamaged(run, false);
    sim_run_expect_undamaged(&second, true);
}

static void kill_at_each_operation_of_the_move(const char *op, unsigned expected_kills)
{
    /* NOLINTNEXTLINE(concurrency-mt-unsafe): before any thread */
    unsigned step = getenv("TTF_THOROUGH") ? 1 : 5;
    unsigned kills = 0;

    for (unsigned at = 1;; at += step) {
        struct sim_run run;
        int status;
        pid_t pid;

        with_second(&run);
        fails_with = op ? EIO : EROFS;
        fails_op = op;
        pid = fork();
        assert_true(pid >= 0);
        if (pid == 0) {
            kill_at = at;
            run.fault = fail_and_die;
            run.plan.count = 3;
            _exit(sim_run_boot(&run) == 0 ? 0 : 1);
        }
        assert_int_equal(waitpid(pid, &status, 0), pid);
        assert_true(WIFEXITED(status));
        if (WEXITSTATUS(status) == 77) {
            kills++;
            expect_moved_all_the_same(&run);
        }
        sim_run_finish(&run);
        if (WEXITSTATUS(status) != 77) {
            assert_int_equal(WEXITSTATUS(status), 0);
            break;
        }
    }
    print_message("killed %u times\n", kills);
    assert_true(kills > expected_kills / step);
}

static void killed_at_any_operation_of_the_move_each_slot_is_in_exactly_one(void **state)
{
    (void)state;
    kill_at_each_operation_of_the_move(NULL, 90);
}

/* What says that the first was left comes once the second is begun for good: no kill leaves a run that waits for nothing. */
static void killed_while_the_first_is_told_the_run_goes_on(void **state)
{
    (void)state;
    kill_at_each_operation_of_the_move("sync_dir", 90);
}

/* ---- the seal ---- */

static unsigned seal_fails; /* so many more operations on it do */

static int no_seal(struct sim_run *run, const char *op, const char *path)
{
    (void)op;
    if (run->committed < 6 || !strstr(path, "SHA256SUMS") || seal_fails == 0)
        return 0;
    seal_fails--;
    return fails_with;
}

static void a_seal_that_cannot_be_written_is_an_alarm_and_comes_with_the_next_run(void **state)
{
    struct sim_run run;

    (void)state;
    with_second(&run);
    run.plan.second_storage[0] = '\0';
    run.fault = no_seal;
    fails_with = EIO;
    seal_fails = UINT_MAX;
    assert_int_equal(sim_run_boot(&run), -EIO);
    assert_false(run.result.sealed);
    assert_int_equal(run.alarms, 1);
    assert_non_null(strstr(run.alarm_text, "cannot be sealed"));
    sim_run_expect(&run, "cccccc");
    sim_run_expect_undamaged(&run, false);
    fails_with = 0;
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(run.alarms, 1);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* A signal that came at the wrong moment must not leave a week unsealed. */
static void a_seal_that_was_interrupted_is_tried_again(void **state)
{
    struct sim_run run;

    (void)state;
    with_second(&run);
    run.plan.second_storage[0] = '\0';
    run.fault = no_seal;
    fails_with = EINTR;
    seal_fails = 12;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(seal_fails, 0);
    assert_int_equal(run.alarms, 0);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_second_storage_takes_over_from_one_that_can_only_be_read),
        cmocka_unit_test(the_second_storage_takes_over_from_one_that_gives_errors),
        cmocka_unit_test(after_two_failed_syncs_both_say_why),
        cmocka_unit_test(one_failure_is_no_reason_to_move),
        cmocka_unit_test(images_of_a_slot_without_a_record_come_along),
        cmocka_unit_test(without_a_second_storage_the_run_stops_with_an_alarm),
        cmocka_unit_test(both_storages_may_fail),
        cmocka_unit_test(a_run_that_has_moved_on_resumes_there),
        cmocka_unit_test(a_second_storage_that_is_an_empty_mount_point_is_waited_for),
        cmocka_unit_test(without_its_lost_second_disk_a_run_goes_on_by_a_plan_that_names_none),
        cmocka_unit_test(a_storage_that_came_back_read_only_is_gone_on_from_in_the_second),
        cmocka_unit_test(the_second_dataset_is_enough_to_go_on_with),
        cmocka_unit_test(a_dataset_of_another_run_in_the_second_storage_is_left_alone),
        cmocka_unit_test(a_changed_plan_moves_too),
        cmocka_unit_test(killed_at_any_operation_of_the_move_each_slot_is_in_exactly_one),
        cmocka_unit_test(killed_while_the_first_is_told_the_run_goes_on),
        cmocka_unit_test(a_seal_that_cannot_be_written_is_an_alarm_and_comes_with_the_next_run),
        cmocka_unit_test(a_seal_that_was_interrupted_is_tried_again),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
