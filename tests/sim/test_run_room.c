/* SPDX-License-Identifier: Apache-2.0 */
/* A disk that fills up: previews go first, then the run goes on in the second storage, or slots are missed. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "second_run.h"

static void make_previews(const struct sim_run *run)
{
    char path[160];

    snprintf(path, sizeof(path), "%s/preview", run->path);
    assert_int_equal(mkdir(path, 0755), 0);
    snprintf(path, sizeof(path), "%s/preview/main", run->path);
    assert_int_equal(mkdir(path, 0755), 0);
    for (int i = 0; i < 40; i++) {
        FILE *f;

        snprintf(path, sizeof(path), "%s/preview/main/%06d.jpg", run->path, i);
        f = fopen(path, "w");
        assert_non_null(f);
        fclose(f);
    }
}

static unsigned previews_left(const struct sim_run *run, int from)
{
    unsigned n = 0;
    char path[160];

    for (int i = from; i < 40; i++) {
        snprintf(path, sizeof(path), "%s/preview/main/%06d.jpg", run->path, i);
        n += access(path, F_OK) == 0;
    }
    return n;
}

#define RESERVE_BYTES (INT64_C(1) << 20)

/* Each preview that goes makes 10 kB of room. */
static void previews_hold_room(struct sim_run *run)
{
    if (run->committed >= 2)
        run->free_bytes = RESERVE_BYTES + (40 - (int64_t)previews_left(run, 0)) * 10000;
}

static void previews_go_first_oldest_first(void **state)
{
    struct sim_run run;
    unsigned left;

    (void)state;
    second_run_init(&run);
    run.plan.reserve_bytes = RESERVE_BYTES;
    assert_int_equal(ttf_control_waiting(run.control = ttf_control_create()), 0);
    assert_true(
        ttf_control_ask(run.control, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 1}) > 0);
    assert_int_equal(sim_run_boot(&run), 0);
    make_previews(&run);
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    run.on_file = previews_hold_room;
    if (sim_run_boot(&run) < 0)
        print_error("%s: %s\n", run.err.where, run.err.what);
    sim_run_expect(&run, "cccccc");
    assert_false(run.result.second_storage);
    left = previews_left(&run, 0);
    assert_in_range(left, 1, 39);
    assert_int_equal(previews_left(&run, 40 - (int)left), left); /* the newest ones */
    assert_true(sim_run_events(&run, "disk", "preview/ were removed") >= 1);
    sim_run_expect_whole(&run, true);
    ttf_control_destroy(run.control);
    sim_run_finish(&run);
}

static void full_from_slot_2_on(struct sim_run *run, const struct ttf_progress *progress)
{
    (void)progress;
    if (run->committed >= 2)
        run->free_bytes = 1000;
}

static void a_full_disk_is_left_for_the_second_storage(void **state)
{
    struct sim_run run;
    struct sim_run second;

    (void)state;
    second_run_init(&run);
    run.plan.reserve_bytes = RESERVE_BYTES;
    run.on_progress = full_from_slot_2_on;
    assert_int_equal(sim_run_boot(&run), 0);
    second = second_run_of(&run);
    sim_run_expect(&run, "cc");
    second_run_expect_both(&run, "cccccc");
    assert_int_equal(sim_run_events(&run, "storage", "less room than the reserve"), 1);
    assert_int_equal(sim_run_events(&second, "storage", "less room than the reserve"), 1);
    sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
}

static void without_one_capture_stops_before_the_reserve(void **state)
{
    struct sim_run run;

    (void)state;
    second_run_init(&run);
    run.plan.second_storage[0] = '\0';
    run.plan.reserve_bytes = RESERVE_BYTES;
    run.on_progress = full_from_slot_2_on;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccmmmm");
    sim_run_expect_reason(&run, 5, "disk full");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* ---- no room for another file, and plenty of bytes ---- */

static int64_t no_inodes_from, no_inodes_until; /* slots */

static int no_inodes(struct sim_run *run, const char *op, const char *path)
{
    if (run->committed < no_inodes_from || run->committed >= no_inodes_until)
        return 0;
    return strcmp(op, "open") == 0 && strstr(path, "/main/") ? ENOSPC : 0;
}

/* How many alarms had been told when each slot was. */
static unsigned alarms_at[16];

static void note_alarms(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind == TTF_PROGRESS_SLOT)
        alarms_at[progress->index] = run->alarms;
}

static void without_inodes(struct sim_run *run, int64_t from, int64_t until)
{
    second_run_init(run);
    run->plan.second_storage[0] = '\0';
    run->plan.count = 9;
    no_inodes_from = from;
    no_inodes_until = until;
    run->fault = no_inodes;
    run->on_progress = note_alarms;
}

static void images_that_cannot_be_stored_are_an_alarm_until_they_can(void **state)
{
    struct sim_run run;

    (void)state;
    without_inodes(&run, 2, 6);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccffffccc");
    sim_run_expect_reason(&run, 3, "disk full");
    /* Told when the third of them was recorded; and over once. */
    assert_int_equal(alarms_at[4], 0);
    assert_int_equal(alarms_at[5], 1);
    assert_int_equal(run.alarms, 1);
    assert_non_null(strstr(run.alarm_text, "no images can be stored"));
    assert_int_equal(run.alarms_over, 1);
    assert_int_equal(sim_run_events(&run, "disk", "no images can be stored, 3 slots"), 1);
    assert_int_equal(sim_run_events(&run, "disk", "images are stored again"), 1);
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* The next run tells that it is over: whoever has heard the alarm knows that text. */
static void an_alarm_of_a_run_before_is_over_with_the_first_image_that_is_stored(void **state)
{
    struct sim_run run;

    (void)state;
    without_inodes(&run, 1, 5);
    run.control = ttf_control_create();
    assert_true(
        ttf_control_ask(run.control, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 5}) > 0);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "cffff");
    assert_int_equal(run.alarms, 1);
    assert_int_equal(run.alarms_over, 0);
    run.config.power_on_ns = run.ended_ns + TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(run.alarms, 1);
    assert_int_equal(run.alarms_over, 1);
    ttf_control_destroy(run.control);
    sim_run_finish(&run);
}

static void a_slot_or_two_without_images_are_no_alarm(void **state)
{
    struct sim_run run;

    (void)state;
    without_inodes(&run, 2, 4);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccffccccc");
    assert_int_equal(run.alarms, 0);
    sim_run_finish(&run);
    /* Nor are three within a minute. */
    without_inodes(&run, 2, 5);
    run.plan.interval_ns = 25 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_expect(&run, "ccfffcccc");
    assert_int_equal(run.alarms, 0);
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(previews_go_first_oldest_first),
        cmocka_unit_test(a_full_disk_is_left_for_the_second_storage),
        cmocka_unit_test(without_one_capture_stops_before_the_reserve),
        cmocka_unit_test(images_that_cannot_be_stored_are_an_alarm_until_they_can),
        cmocka_unit_test(an_alarm_of_a_run_before_is_over_with_the_first_image_that_is_stored),
        cmocka_unit_test(a_slot_or_two_without_images_are_no_alarm),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
