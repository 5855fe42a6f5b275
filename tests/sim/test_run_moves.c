/* SPDX-License-Identifier: Apache-2.0 */
/* Moves to the second storage that do not go as smoothly as those of test_run_storage: half-way, or with more to bring. */
#include "cmocka_includes.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>

#include "second_run.h"
#include "ttf/capture/guided_calibration.h"

static unsigned failed; /* operations */

static void with_second(struct sim_run *run)
{
    second_run_init(run);
    failed = 0;
}

/* Letters of the slots from `from` on, all of which the second dataset has. */
static void expect_second(const struct sim_run *run, int64_t from, const char *letters)
{
    struct sim_run second = second_run_of(run);
    struct ttf_slot_record record;

    for (int64_t i = 0; letters[i]; i++) {
        sim_run_record(&second, from + i, &record);
        assert_int_equal("cpmfzw"[record.result], letters[i]);
        ttf_slot_record_free(&record);
    }
}

/* ---- a second dataset that was made and never begun ---- */

/* The first one can only be read; the second can be made, but takes no line. */
static int neither_takes_a_line(struct sim_run *run, const char *op, const char *path)
{
    if (second_run_holds(path))
        return strcmp(op, "append") == 0 && sim_run_path_ends(path, "records.jsonl") ? EROFS : 0;
    return run->committed >= 2 ? EROFS : 0;
}

static int first_can_only_be_read(struct sim_run *run, const char *op, const char *path)
{
    (void)op;
    return !second_run_holds(path) && run->committed >= 4 ? EROFS : 0;
}

static void the_plan_in_force_is_that_of_a_second_dataset_made_under_an_older_one(void **state)
{
    struct sim_run run;

    (void)state;
    with_second(&run);
    run.fault = neither_takes_a_line;
    assert_int_equal(sim_run_boot(&run), -EROFS);
    sim_run_expect(&run, "cc");
    /* Mended, gone on with for longer; then it fails again, and the second one is well. */
    run.plan.count = 9;
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    run.fault = first_can_only_be_read;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.second_storage);
    assert_true(run.result.sealed);
    expect_second(&run, 4, "ccccc");
    /* The same plan finds nothing to do: it is the one in force there. */
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(run.result.total, 9);
    sim_run_finish(&run);
}

static void change_at_6(struct sim_run *run)
{
    run->control = ttf_control_create();
    assert_non_null(run->control);
    assert_true(
        ttf_control_ask(run->control,
                        &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 6, .count = 8}) > 0);
}

/* Another interval and eight slots; and it stops when it has moved. */
static void change_at_2(struct sim_run *run)
{
    run->control = ttf_control_create();
    assert_non_null(run->control);
    assert_true(ttf_control_ask(run->control, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
                                                                .from_index = 2,
                                                                .interval_ns = 30 * TTF_NS_PER_S}) >
                0);
    assert_true(
        ttf_control_ask(run->control,
                        &(struct ttf_ask){.kind = TTF_ASK_COUNT, .from_index = 2, .count = 8}) > 0);
    assert_true(ttf_control_ask(run->control,
                                &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 5}) > 0);
}

/* As above, and then the plan changes again: its number there is the next one there. */
static void plans_that_come_later_are_counted_as_they_stand_there(void **state)
{
    struct sim_run run;
    struct sim_run second;
    struct ttf_reader *reader = NULL;
    struct ttf_segment last;

    (void)state;
    with_second(&run);
    run.fault = neither_takes_a_line;
    assert_int_equal(sim_run_boot(&run), -EROFS);
    run.plan.count = 9;
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    run.fault = first_can_only_be_read;
    change_at_6(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    expect_second(&run, 4, "cccc");
    second = second_run_of(&run);
    assert_int_equal(ttf_reader_open(ttf_io_posix(), second.path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_summary(reader)->n_plans, 3);
    assert_int_equal(ttf_reader_summary(reader)->n_segments, 2);
    assert_int_equal(ttf_reader_segment(reader, 0, &last), 0);
    assert_int_equal(last.plan, 1);
    assert_int_equal(ttf_reader_segment(reader, 1, &last), 0);
    assert_int_equal(last.plan, 2);
    ttf_reader_close(reader);
    sim_run_expect_undamaged(&second, true);
    ttf_control_destroy(run.control);
    sim_run_finish(&run);
}

/*
 * Changed, moved, cut: who starts the box again has the plan it was begun with, and the first disk may be gone. It goes
 * on with what the plan has become.
 */
static void a_changed_plan_is_in_force_in_the_second_storage_whatever_plan_is_given(void **state)
{
    struct ttf_segment last;
    struct sim_run second;
    struct sim_run run;

    for (int gone = 0; gone < 2; gone++) {
        char away[PATH_MAX];

        (void)state;
        with_second(&run);
        run.plan.count = 7;
        run.fault = first_can_only_be_read;
        change_at_2(&run);
        assert_int_equal(sim_run_boot(&run), 0);
        expect_second(&run, 4, "c");
        if (gone) {
            snprintf(away, sizeof(away), "%s.gone", run.path);
            assert_int_equal(rename(run.path, away), 0);
        }
        run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
        ttf_control_destroy(run.control);
        run.control = NULL;
        assert_int_equal(sim_run_boot(&run), 0);
        assert_int_equal(run.result.total, 8);
        assert_int_equal(run.result.moved_on_from, 0);
        second = second_run_of(&run);
        assert_int_equal(sim_run_segment_of(&second, 7, &last), 1);
        assert_int_equal(last.plan, 1);
        assert_int_equal(last.interval_ns, 30 * TTF_NS_PER_S);
        sim_run_finish(&run);
    }
}

/* ---- errors that a file system found in itself ---- */

static void errors_of_the_second_storage_are_told_though_the_first_had_more(void **state)
{
    struct sim_run second;
    struct sim_run run;

    (void)state;
    with_second(&run);
    run.plan.count = 9;
    run.fs_errors = 5;
    run.second_fs_errors = 2;
    run.fault = first_can_only_be_read;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.second_storage);
    second = second_run_of(&run);
    assert_int_equal(sim_run_events(&run, "storage", "5 since it was last checked"), 1);
    assert_int_equal(sim_run_events(&second, "storage", "2 since it was last checked"), 1);
    assert_int_equal(sim_run_events(&second, "storage", "found errors in itself"), 1);
    sim_run_finish(&run);
}

/* ---- at the beginning of a boot ---- */

static int at_boot; /* errno of all that is written in the first; 0: none */

static int the_first_answers(struct sim_run *run, const char *op, const char *path)
{
    (void)run;
    (void)op;
    return second_run_holds(path) ? 0 : at_boot;
}

static void cut_at_slot_2(struct sim_run *run)
{
    with_second(run);
    run->plan.count = 5;
    run->fault = the_first_answers;
    at_boot = 0;
    sim_run_fault(run, TTF_FAULT_POWER_CUT, TTF_NS_PER_MIN + 40 * TTF_NS_PER_S);
    assert_int_equal(sim_run_boot(run), -ESHUTDOWN);
    run->config.power_on_ns = run->back_ns;
}

static void
whatever_keeps_the_first_from_being_written_it_is_gone_on_from_in_the_second(void **state)
{
    static const int errors[] = {EROFS, EIO, ENOSPC, EDQUOT, EACCES, EPERM};

    (void)state;
    for (unsigned i = 0; i < sizeof(errors) / sizeof(errors[0]); i++) {
        struct sim_run run;
        struct sim_run second;

        cut_at_slot_2(&run);
        at_boot = errors[i];
        assert_int_equal(sim_run_boot(&run), 0);
        assert_true(run.result.second_storage);
        sim_run_expect(&run, "cc");
        expect_second(&run, 2, "wcc");
        second = second_run_of(&run);
        assert_int_equal(sim_run_events(&second, "storage", "cannot be written at the start"), 1);
        sim_run_expect_undamaged(&second, true);
        sim_run_finish(&run);
    }
}

/* That passes, or is for a person: the first is not left for it. */
static void what_says_nothing_of_the_storage_is_no_reason_to_leave_it(void **state)
{
    struct sim_run run;

    (void)state;
    cut_at_slot_2(&run);
    at_boot = ENOMEM;
    assert_int_equal(sim_run_boot(&run), -ENOMEM);
    assert_false(run.result.second_storage);
    at_boot = 0;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_false(run.result.second_storage);
    sim_run_expect(&run, "ccwcc");
    sim_run_finish(&run);
}

static int fails_from_4(struct sim_run *run, const char *op, const char *path)
{
    (void)op;
    return !second_run_holds(path) && run->committed >= 4 ? EROFS : 0;
}

/* Gone on with without a clock, moved, and then somebody gives the time: the segment there is corrected. */
static void a_clock_that_comes_back_after_the_move_corrects_the_segment_there(void **state)
{
    struct ttf_reader *reader = NULL;
    struct ttf_segment segment;
    struct sim_run run;
    struct sim_run second;

    (void)state;
    with_second(&run);
    run.config.rtc = false;
    run.config.utc_back_ns = 5 * TTF_NS_PER_MIN;
    run.plan.count = 10;
    run.fault = fails_from_4;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, TTF_NS_PER_MIN + 40 * TTF_NS_PER_S)->amount = 130;
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    run.config.power_on_ns = run.back_ns;
    assert_int_equal(sim_run_boot(&run), 0);
    second = second_run_of(&run);
    sim_run_expect(&run, "cccc");
    expect_second(&run, 4, "cccccc");
    assert_int_equal(ttf_reader_open(ttf_io_posix(), second.path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_segment(reader, 0, &segment), 0);
    assert_int_equal(segment.first_index, 4);
    assert_string_not_equal(segment.trust, "none");
    /* Slot 4 is due when it was: its boot began at power_on. */
    assert_int_equal(segment.origin_utc_ns,
                     run.config.start_utc_ns + run.config.power_on_ns + segment.origin_ns);
    ttf_reader_close(reader);
    sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
}

/* ---- a move that fails ---- */

/* Dark and flat of this box. */
static void calibrate(struct sim_run *run, char *folder, size_t size)
{
    struct ttf_calibration calibration;
    struct ttf_scene white;
    struct ttf_box box;
    struct ttf_guided_config config = {
        .box = &box, .shot = &run->plan.shots[0], .mains_hz = 50, .frames = 4, .reflectance = 0.9};

    ttf_calibration_init(&calibration);
    assert_int_equal(ttf_scene_procedural("white", 1, TTF_NS_PER_DAY, &white, NULL), 0);
    assert_int_equal(ttf_sim_box_create(&run->config, &white, &box, NULL), 0);
    assert_int_equal(ttf_guided_dark(&config, &calibration, NULL), 0);
    ttf_box_destroy(&box);
    snprintf(folder, size, "%s/calibration", run->folder);
    assert_int_equal(ttf_calibration_save(&calibration, ttf_io_posix(), folder, NULL), 0);
    ttf_calibration_free(&calibration);
    run->calibration = folder;
}

/* Slot 2's files find no way into the first; the second takes neither the calibration nor a line. */
static int slot_2_and_the_whole_second(struct sim_run *run, const char *op, const char *path)
{
    if (second_run_holds(path))
        return strstr(path, "/calibration") ||
                       (strcmp(op, "append") == 0 && sim_run_path_ends(path, "/records.jsonl"))
                   ? EROFS
                   : 0;
    return run->committed == 2 && strstr(path, "/frames/") ? EIO : 0;
}

static void a_move_that_failed_leaves_the_first_its_calibration(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;
    char folder[96];
    char id[64];

    (void)state;
    with_second(&run);
    calibrate(&run, folder, sizeof(folder));
    run.fault = slot_2_and_the_whole_second;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_false(run.result.second_storage);
    sim_run_record(&run, 1, &record);
    snprintf(id, sizeof(id), "%.63s", record.images[0].calibration);
    assert_true(id[0] != '\0');
    ttf_slot_record_free(&record);
    for (int64_t k = 3; k < 6; k++) {
        sim_run_record(&run, k, &record);
        assert_int_equal(record.result, TTF_RESULT_CAPTURED);
        assert_string_equal(record.images[0].calibration, id);
        ttf_slot_record_free(&record);
    }
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* As above, but the second takes lines. */
static int no_calibration_there(struct sim_run *run, const char *op, const char *path)
{
    (void)op;
    if (second_run_holds(path))
        return strstr(path, "/calibration") ? EIO : 0;
    return run->committed >= 2 ? EROFS : 0;
}

static void images_name_no_calibration_that_did_not_come_along(void **state)
{
    struct sim_run run;
    struct sim_run second;
    struct ttf_slot_record record;
    char folder[96];

    (void)state;
    with_second(&run);
    calibrate(&run, folder, sizeof(folder));
    run.fault = no_calibration_there;
    assert_int_equal(sim_run_boot(&run), 0);
    second = second_run_of(&run);
    expect_second(&run, 2, "cccc");
    sim_run_record(&second, 2, &record);
    assert_string_equal(record.images[0].calibration, "");
    ttf_slot_record_free(&record);
    assert_int_equal(sim_run_events(&second, "storage", "the calibration did not come along"), 1);
    sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
}

/* Slot 2's files fail here once more; there the segment's line is written, and neither acknowledged nor taken back. */
static int a_segment_in_doubt(struct sim_run *run, const char *op, const char *path)
{
    bool lines = sim_run_path_ends(path, "records.jsonl");

    if (!second_run_holds(path))
        return run->committed == 2 && strstr(path, "/frames/") ? EIO : 0;
    if ((lines && strcmp(op, "sync") == 0 && failed == 0) ||
        (sim_run_path_ends(path, "records.jsonl.tmp") && strcmp(op, "open") == 0 && failed == 1) ||
        (lines && strcmp(op, "truncate") == 0 && failed == 2)) {
        failed++;
        return EIO;
    }
    return 0;
}

static void a_second_dataset_that_was_begun_after_all_is_gone_on_with(void **state)
{
    struct sim_run run;

    (void)state;
    with_second(&run);
    run.fault = a_segment_in_doubt;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(failed, 3);
    /* The next run would go on there: slots that came into the first meanwhile would be given up. */
    assert_true(run.result.second_storage);
    sim_run_expect(&run, "cc");
    expect_second(&run, 2, "cccc");
    sim_run_finish(&run);
}

/* Both fail in the end: the first at slot 2, the second at slot 4. */
static int one_after_the_other(struct sim_run *run, const char *op, const char *path)
{
    (void)op;
    return run->committed >= (second_run_holds(path) ? 4 : 2) ? EROFS : 0;
}

static void a_second_storage_that_fails_too_ends_the_run_with_what_both_hold(void **state)
{
    struct sim_run run;
    struct sim_run second;

    (void)state;
    with_second(&run);
    run.fault = one_after_the_other;
    assert_int_equal(sim_run_boot(&run), -EROFS);
    assert_int_equal(run.alarms, 2);
    assert_non_null(strstr(run.alarm_text, "in the second storage too"));
    second = second_run_of(&run);
    sim_run_expect(&run, "cc");
    expect_second(&run, 2, "cc");
    sim_run_expect_undamaged(&second, false);
    /* Mended, it is gone on with there. */
    run.fault = NULL;
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.sealed);
    sim_run_finish(&run);
}

/* ---- what comes along ---- */

/* From slot 2's record on the first takes nothing more; its files are there, one of them no more as it was. */
static int spoils_a_file(struct sim_run *run, const char *op, const char *path)
{
    char name[160];
    FILE *f;

    if (second_run_holds(path) || run->committed < 2 || strcmp(op, "append") != 0)
        return 0;
    if (failed++ == 0) {
        snprintf(name, sizeof(name), "%s/frames/main/000002.tif", run->path);
        f = fopen(name, "r+");
        assert_non_null(f);
        assert_int_equal(fputc('X', f), 'X');
        assert_int_equal(fclose(f), 0);
    }
    return EROFS;
}

static void a_file_that_changed_on_the_failing_disk_is_not_brought_as_if_it_were_good(void **state)
{
    struct sim_run run;
    struct sim_run second;
    struct ttf_slot_record record;

    (void)state;
    with_second(&run);
    run.fault = spoils_a_file;
    assert_int_equal(sim_run_boot(&run), 0);
    second = second_run_of(&run);
    expect_second(&run, 2, "cccc");
    sim_run_record(&second, 2, &record);
    assert_int_equal(record.images[0].n_files, 1);
    assert_string_equal(record.images[0].files[0].role, "raw");
    assert_non_null(strstr(record.images[0].flags, "developed-lost"));
    ttf_slot_record_free(&record);
    sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
}

/* The files of slot 2 cannot be read back either. */
static int takes_the_files_away(struct sim_run *run, const char *op, const char *path)
{
    char name[160];

    if (second_run_holds(path) || run->committed < 2 || strcmp(op, "append") != 0)
        return 0;
    if (failed++ == 0) {
        snprintf(name, sizeof(name), "%s/frames/main/000002.tif", run->path);
        assert_int_equal(remove(name), 0);
        snprintf(name, sizeof(name), "%s/raw/main/000002.dng", run->path);
        assert_int_equal(remove(name), 0);
    }
    return EROFS;
}

/*
 * The first takes no record from slot 2 on, and the second is not there before slot 3 is due: slot 2 waits, its files in
 * the first. As soon as the run goes on in the second the first is sound again, and is told: opening it clears away
 * files without a record, so what waits must have been fetched by then.
 */
static bool second_begun;

static int first_is_back_once_it_is_left(struct sim_run *run, const char *op, const char *path)
{
    int64_t now = ttf_sim_elapsed_ns(run->box, ttf_clock_now_ns(run->box->clock));

    if (run->committed < 2)
        return 0;
    if (second_run_holds(path)) {
        second_begun |= strcmp(op, "append") == 0 && sim_run_path_ends(path, "records.jsonl");
        return now < sim_run_due_ns(run, 3) - 5 * TTF_NS_PER_S ? EIO : 0;
    }
    return !second_begun && strstr(path, "/records.jsonl") ? EIO : 0;
}

static void files_of_a_slot_that_waited_are_fetched_before_the_first_is_opened(void **state)
{
    struct sim_run second;
    struct sim_run run;

    (void)state;
    with_second(&run);
    second_begun = false;
    run.fault = first_is_back_once_it_is_left;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.second_storage);
    expect_second(&run, 2, "cccc");
    second = second_run_of(&run);
    sim_run_expect_undamaged(&second, true);
    assert_true(sim_run_events(&run, "storage", "goes on in the second storage, from slot 2") == 1);
    sim_run_finish(&run);
}

static void a_slot_whose_files_are_lost_on_the_way_says_so(void **state)
{
    struct sim_run run;
    struct sim_run second;

    (void)state;
    with_second(&run);
    run.fault = takes_the_files_away;
    assert_int_equal(sim_run_boot(&run), 0);
    second = second_run_of(&run);
    expect_second(&run, 2, "fccc");
    sim_run_expect_reason(&second, 2, "storage error");
    sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
}

/* The first fails when the first of two images is in it: what is there is fetched, the other is written there. */
static int fails_at_the_second_image(struct sim_run *run, const char *op, const char *path)
{
    if (second_run_holds(path) || run->committed < 2)
        return 0;
    failed += strstr(path, "/frames/raking/000002") != NULL;
    return failed > 0 && strcmp(op, "rename") != 0 ? EIO : 0;
}

static void a_slot_of_two_images_is_moved_in_its_middle(void **state)
{
    struct sim_run run;
    struct sim_run second;
    struct ttf_slot_record record;

    (void)state;
    with_second(&run);
    run.plan.n_shots = 2;
    run.plan.shots[1] = run.plan.shots[0];
    strcpy(run.plan.shots[1].stream, "raking");
    strcpy(run.plan.shots[1].channel, "right");
    strcpy(run.plan.shots[1].levels[0].lamp, "right");
    run.fault = fails_at_the_second_image;
    assert_int_equal(sim_run_boot(&run), 0);
    second = second_run_of(&run);
    sim_run_expect(&run, "cc");
    expect_second(&run, 2, "cccc");
    sim_run_record(&second, 2, &record);
    assert_int_equal(record.n_images, 2);
    assert_int_equal(record.images[0].n_files, 2);
    assert_int_equal(record.images[1].n_files, 2);
    assert_string_equal(record.images[0].flags, "");
    ttf_slot_record_free(&record);
    sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_plan_in_force_is_that_of_a_second_dataset_made_under_an_older_one),
        cmocka_unit_test(plans_that_come_later_are_counted_as_they_stand_there),
        cmocka_unit_test(a_changed_plan_is_in_force_in_the_second_storage_whatever_plan_is_given),
        cmocka_unit_test(errors_of_the_second_storage_are_told_though_the_first_had_more),
        cmocka_unit_test(
            whatever_keeps_the_first_from_being_written_it_is_gone_on_from_in_the_second),
        cmocka_unit_test(what_says_nothing_of_the_storage_is_no_reason_to_leave_it),
        cmocka_unit_test(a_clock_that_comes_back_after_the_move_corrects_the_segment_there),
        cmocka_unit_test(a_move_that_failed_leaves_the_first_its_calibration),
        cmocka_unit_test(images_name_no_calibration_that_did_not_come_along),
        cmocka_unit_test(a_second_dataset_that_was_begun_after_all_is_gone_on_with),
        cmocka_unit_test(a_second_storage_that_fails_too_ends_the_run_with_what_both_hold),
        cmocka_unit_test(a_file_that_changed_on_the_failing_disk_is_not_brought_as_if_it_were_good),
        cmocka_unit_test(files_of_a_slot_that_waited_are_fetched_before_the_first_is_opened),
        cmocka_unit_test(a_slot_whose_files_are_lost_on_the_way_says_so),
        cmocka_unit_test(a_slot_of_two_images_is_moved_in_its_middle),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
