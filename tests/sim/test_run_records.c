/* SPDX-License-Identifier: Apache-2.0 */
/* Records, events and the seal on a storage that fails for a moment: each once, in order, and none without power. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "sim_run.h"

static unsigned failed; /* operations */
static int fails_with;
static unsigned dark;        /* operations of a box without power */
static char last_event[300]; /* told */

static void with_fault(struct sim_run *run,
                       int (*fault)(struct sim_run *, const char *, const char *))
{
    sim_run_init(run);
    run->fault = fault;
    failed = 0;
    fails_with = EIO;
    dark = 0;
}

static int64_t now_ns(const struct sim_run *run)
{
    return ttf_sim_elapsed_ns(run->box, ttf_clock_now_ns(run->box->clock));
}

/* ---- once ---- */

/* The record of slot 2 is written, its sync fails, and so does all that would take it back. */
static int a_record_in_doubt(struct sim_run *run, const char *op, const char *path)
{
    bool lines = sim_run_path_ends(path, "/records.jsonl");

    if (run->committed != 2)
        return 0;
    if ((lines && strcmp(op, "sync") == 0 && failed == 0) ||
        (sim_run_path_ends(path, "records.jsonl.tmp") && strcmp(op, "open") == 0 && failed == 1) ||
        (lines && strcmp(op, "truncate") == 0 && failed == 2)) {
        failed++;
        return EIO;
    }
    return 0;
}

static void a_record_that_got_there_after_all_is_not_written_again(void **state)
{
    struct sim_run run;

    (void)state;
    with_fault(&run, a_record_in_doubt);
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(failed, 3);
    assert_int_equal(run.slots_told, 6);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_no_flag(&run, 2);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* ---- as it was written ---- */

/*
 * Slot 2's record cannot be written at first. Somebody has put a frame of a later slot beside its own, so opening
 * anew clears nothing away; and slot 2's developed frame is shorter by now.
 */
static int a_file_shrinks(struct sim_run *run, const char *op, const char *path)
{
    char name[160];

    if (run->committed != 2 || strcmp(op, "append") != 0 ||
        !sim_run_path_ends(path, "records.jsonl") || failed)
        return 0;
    failed++;
    snprintf(name, sizeof(name), "%s/frames/main/000002.tif", run->path);
    assert_int_equal(truncate(name, 100), 0);
    snprintf(name, sizeof(name), "%s/frames/main/000005.tif", run->path);
    fclose(fopen(name, "w"));
    return ENOSPC;
}

static void a_file_that_is_no_more_as_it_was_written_is_not_recorded(void **state)
{
    struct sim_run run;
    struct ttf_slot_record record;

    (void)state;
    with_fault(&run, a_file_shrinks);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_flag(&run, 2, "developed-lost");
    sim_run_record(&run, 2, &record);
    assert_int_equal(record.images[0].n_files, 1);
    ttf_slot_record_free(&record);
    sim_run_expect_undamaged(&run, true);
    sim_run_finish(&run);
}

/* Its record's first writing fails, and opening anew clears its files away: the record says so at once. */
static int a_record_fails_once(struct sim_run *run, const char *op, const char *path)
{
    if (run->committed != 5 || strcmp(op, "append") != 0 ||
        !sim_run_path_ends(path, "records.jsonl") || failed)
        return 0;
    failed++;
    return ENOSPC;
}

static void
a_slot_whose_files_were_cleared_away_is_recorded_as_failed_at_the_second_try(void **state)
{
    struct sim_run run;

    (void)state;
    with_fault(&run, a_record_fails_once);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cccccf");
    sim_run_expect_reason(&run, 5, "storage error");
    assert_int_equal(sim_run_events(&run, "retry", "record of slot 5 needed a second try"), 1);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* ---- in order ---- */

#define OPENED_NS (140 * TTF_NS_PER_S)

/* For a second there is no room, not even for an event. */
static int no_room_when_the_door_opens(struct sim_run *run, const char *op, const char *path)
{
    if (!(sim_run_path_ends(path, "events.jsonl") && strcmp(op, "append") == 0) &&
        !sim_run_path_ends(path, ".events-reserve"))
        return 0; /* what was begun of a line can be taken back */
    if (now_ns(run) < OPENED_NS || now_ns(run) > OPENED_NS + 3 * TTF_NS_PER_S)
        return 0;
    failed++;
    return ENOSPC;
}

static long where_is(const char *text, const char *what)
{
    const char *at = strstr(text, what);

    assert_non_null(at);
    return at ? at - text : -1;
}

static void events_are_written_in_the_order_they_came_in(void **state)
{
    struct sim_run run;
    char path[128];
    char *text = NULL;
    size_t bytes;

    (void)state;
    with_fault(&run, no_room_when_the_door_opens);
    sim_run_fault(&run, TTF_FAULT_DOOR_OPEN, OPENED_NS)->duration_ns = 10 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(failed > 0);
    snprintf(path, sizeof(path), "%s/events.jsonl", run.path);
    assert_int_equal(ttf_io_slurp(ttf_io_posix(), path, 1 << 20, &text, &bytes, NULL), 0);
    assert_true(where_is(text, "\"opened\"") < where_is(text, "\"closed\""));
    free(text);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* The door opens 40 times, for a second each, every other second, while there is no room; and once more when there is. */
#define DOORS      40
#define DOOR_NS    (2 * TTF_NS_PER_S)
#define NO_ROOM_NS (DOORS * DOOR_NS + 5 * TTF_NS_PER_S)

static int64_t room_again_ns;

static int no_room_for_events(struct sim_run *run, const char *op, const char *path)
{
    bool event = sim_run_path_ends(path, "events.jsonl") && strcmp(op, "append") == 0;

    if (!event && !sim_run_path_ends(path, ".events-reserve"))
        return 0;
    if (now_ns(run) < OPENED_NS || now_ns(run) > room_again_ns)
        return 0;
    failed++;
    return ENOSPC;
}

static void with_a_restless_door(struct sim_run *run)
{
    with_fault(run, no_room_for_events);
    room_again_ns = OPENED_NS + NO_ROOM_NS;
    run->config.lamps[0].info.interlock_door = false; /* no other events */
    for (int i = 0; i < DOORS; i++)
        sim_run_fault(run, TTF_FAULT_DOOR_OPEN, OPENED_NS + i * DOOR_NS)->duration_ns =
            TTF_NS_PER_S;
    sim_run_fault(run, TTF_FAULT_DOOR_OPEN, OPENED_NS + NO_ROOM_NS + 40 * TTF_NS_PER_S)
        ->duration_ns = TTF_NS_PER_S;
}

static void what_the_last_event_says(struct sim_run *run, const struct ttf_progress *progress)
{
    (void)run;
    if (progress->kind == TTF_PROGRESS_EVENT)
        snprintf(last_event, sizeof(last_event), "%.290s", progress->text);
}

static void events_that_find_no_place_to_wait_are_counted_where_they_would_stand(void **state)
{
    struct sim_run run;
    char *text;

    (void)state;
    with_a_restless_door(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    text = sim_run_text(&run, "events.jsonl");
    assert_non_null(text);
    assert_int_equal(sim_run_events(&run, "door", NULL), 64 + 2);
    assert_int_equal(sim_run_events(&run, "lost", "16 events are lost, within "), 1);
    assert_true(where_is(text, "\"lost\"") > where_is(text, "\"closed\""));
    assert_non_null(strstr(strstr(text, "\"lost\""), "\"opened\"")); /* the last one follows */
    free(text);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static void events_that_no_storage_took_to_the_end_are_told_by_their_number(void **state)
{
    struct sim_run run;

    (void)state;
    with_a_restless_door(&run);
    room_again_ns = INT64_MAX;
    run.on_progress = what_the_last_event_says;
    last_event[0] = '\0';
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(sim_run_events(&run, "door", NULL), 0);
    assert_non_null(strstr(last_event, "82 events are lost, within "));
    sim_run_expect(&run, "cccccc");
    sim_run_finish(&run);
}

/* The disk hangs for some minutes, and the door goes seven times in each four seconds of them. */
#define BEATS 80

static void a_disk_hangs_while_the_door_goes(struct sim_run *run)
{
    struct ttf_clock *clock = run->box->clock;

    if (run->committed != 2 || failed++ > 0)
        return;
    for (int i = 0; i < BEATS; i++) {
        for (int k = 0; k < 7; k++) {
            assert_int_equal(ttf_sim_panel_push(run->box, TTF_PANEL_DOOR_OPENED), 0);
            assert_int_equal(ttf_sim_panel_push(run->box, TTF_PANEL_DOOR_CLOSED), 0);
        }
        (void)ttf_clock_wait_until(clock, ttf_clock_now_ns(clock) + 4 * TTF_NS_PER_S);
    }
}

static void events_that_a_hanging_disk_leaves_no_place_for_are_counted(void **state)
{
    struct sim_run run;
    char *text, *said;
    long lost;

    (void)state;
    with_fault(&run, NULL);
    run.on_file = a_disk_hangs_while_the_door_goes;
    run.on_progress = what_the_last_event_says;
    run.config.lamps[0].info.interlock_door = false;
    run.plan.count = 12;
    /* Once more when all is well: lost ones are told with the next event. */
    sim_run_fault(&run, TTF_FAULT_DOOR_OPEN, OPENED_NS + 400 * TTF_NS_PER_S)->duration_ns =
        TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    text = sim_run_text(&run, "events.jsonl");
    assert_non_null(text);
    assert_int_equal(sim_run_events(&run, "lost", NULL), 1);
    said = strstr(strstr(text, "\"lost\""), "\"text\":\"");
    assert_non_null(said);
    lost = strtol(said + strlen("\"text\":\""), &said, 10);
    assert_non_null(strstr(said, " events are lost, within 28 s"));
    assert_int_equal((long)sim_run_events(&run, "door", NULL) + lost, BEATS * 14 + 2);
    free(text);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* Between two slots no line of the records finds room; UTC steps twice meanwhile. */
static int no_room_for_lines(struct sim_run *run, const char *op, const char *path)
{
    if (!sim_run_path_ends(path, "/records.jsonl") || strcmp(op, "append") != 0 ||
        now_ns(run) < OPENED_NS || now_ns(run) > OPENED_NS + 20 * TTF_NS_PER_S)
        return 0;
    failed++;
    return ENOSPC;
}

static void the_newest_correction_of_a_segment_is_the_one_that_is_written(void **state)
{
    struct ttf_reader *reader = NULL;
    struct ttf_segment segment;
    struct sim_run run;

    (void)state;
    with_fault(&run, no_room_for_lines);
    sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, OPENED_NS + 2 * TTF_NS_PER_S)->amount = 100;
    sim_run_fault(&run, TTF_FAULT_CLOCK_STEP, OPENED_NS + 12 * TTF_NS_PER_S)->amount = 7;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(failed >= 2);
    assert_int_equal(sim_run_events(&run, "clock-step", NULL), 2);
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run.path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_segment(reader, 0, &segment), 0);
    assert_int_equal(segment.origin_utc_ns,
                     run.config.start_utc_ns + segment.origin_ns + 107 * TTF_NS_PER_S);
    ttf_reader_close(reader);
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* ---- not without power ---- */

static void count_dark(struct sim_run *run)
{
    dark += run->box->power_lost(run->box->box_private) != 0;
}

/* A record takes ten seconds; the door opens meanwhile, and then the power goes. */
static void a_box_without_power_writes_nothing_that_waited(void **state)
{
    struct sim_run run;
    int64_t due;

    (void)state;
    with_fault(&run, NULL);
    assert_int_equal(sim_run_boot(&run), 0);
    due = sim_run_due_ns(&run, 2);
    sim_run_finish(&run);
    with_fault(&run, NULL);
    run.on_file = count_dark;
    run.config.cost_commit_ns = 10 * TTF_NS_PER_S;
    sim_run_fault(&run, TTF_FAULT_DOOR_OPEN, due + 3 * TTF_NS_PER_S)->duration_ns = TTF_NS_PER_MIN;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, due + 8 * TTF_NS_PER_S);
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    assert_int_equal(dark, 0);
    assert_int_equal(sim_run_events(&run, "door", NULL), 0);
    sim_run_expect(&run, "cc");
    sim_run_expect_undamaged(&run, false);
    sim_run_finish(&run);
}

/* ---- the end ---- */

/* From the last record's first try on, for twenty seconds. */
static int the_last_record_fails(struct sim_run *run, const char *op, const char *path)
{
    static int64_t since;

    (void)op;
    (void)path;
    if (run->committed != run->plan.count - 1 || now_ns(run) < sim_run_due_ns(run, run->committed))
        return 0;
    if (failed++ == 0)
        since = now_ns(run);
    return now_ns(run) < since + 20 * TTF_NS_PER_S ? fails_with : 0;
}

static int the_seal_fails(struct sim_run *run, const char *op, const char *path)
{
    static int64_t since;

    (void)op;
    (void)path;
    if (run->committed != run->plan.count)
        return 0;
    if (failed++ == 0)
        since = now_ns(run);
    return now_ns(run) < since + 20 * TTF_NS_PER_S ? fails_with : 0;
}

static const int passing[] = {EIO, ENOSPC, EDQUOT, ENOMEM};

static void a_last_record_waits_for_whatever_may_pass(void **state)
{
    (void)state;
    for (unsigned i = 0; i < sizeof(passing) / sizeof(passing[0]); i++) {
        struct sim_run run;

        with_fault(&run, the_last_record_fails);
        fails_with = passing[i];
        assert_int_equal(sim_run_boot(&run), 0);
        assert_true(failed > 0);
        assert_true(run.result.sealed);
        assert_int_equal(run.result.slots, 6);
        sim_run_expect_whole(&run, true);
        sim_run_finish(&run);
    }
}

static void a_seal_waits_for_whatever_may_pass(void **state)
{
    (void)state;
    for (unsigned i = 0; i < sizeof(passing) / sizeof(passing[0]); i++) {
        struct sim_run run;

        with_fault(&run, the_seal_fails);
        fails_with = passing[i];
        assert_int_equal(sim_run_boot(&run), 0);
        assert_true(failed > 0);
        assert_true(run.result.sealed);
        sim_run_expect(&run, "cccccc");
        sim_run_expect_whole(&run, true);
        sim_run_finish(&run);
    }
}

/* A disk quota that is used up is a full disk to whoever reads the records. */
static int no_quota_for_slot_2(struct sim_run *run, const char *op, const char *path)
{
    if (run->committed != 2 || strcmp(op, "pwrite") != 0 || !strstr(path, "/main/"))
        return 0;
    failed++;
    return EDQUOT;
}

static void a_quota_that_is_used_up_is_called_full(void **state)
{
    struct sim_run run;

    (void)state;
    with_fault(&run, no_quota_for_slot_2);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccfccc");
    sim_run_expect_reason(&run, 2, "disk full");
    assert_int_equal(failed, 2); /* each file once: another name would not help */
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_record_that_got_there_after_all_is_not_written_again),
        cmocka_unit_test(a_file_that_is_no_more_as_it_was_written_is_not_recorded),
        cmocka_unit_test(
            a_slot_whose_files_were_cleared_away_is_recorded_as_failed_at_the_second_try),
        cmocka_unit_test(events_are_written_in_the_order_they_came_in),
        cmocka_unit_test(events_that_find_no_place_to_wait_are_counted_where_they_would_stand),
        cmocka_unit_test(events_that_no_storage_took_to_the_end_are_told_by_their_number),
        cmocka_unit_test(events_that_a_hanging_disk_leaves_no_place_for_are_counted),
        cmocka_unit_test(the_newest_correction_of_a_segment_is_the_one_that_is_written),
        cmocka_unit_test(a_box_without_power_writes_nothing_that_waited),
        cmocka_unit_test(a_last_record_waits_for_whatever_may_pass),
        cmocka_unit_test(a_seal_waits_for_whatever_may_pass),
        cmocka_unit_test(a_quota_that_is_used_up_is_called_full),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
