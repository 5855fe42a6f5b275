/* SPDX-License-Identifier: Apache-2.0 */
/* A week, every ten minutes. Frames are small here; the bench does it in full size. */
#include "cmocka_includes.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "sim_run.h"

#define WEEK_SLOTS 1008

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SANITIZED 1
#else
#define SANITIZED 0
#endif

static long resident_early_kb;
static long resident_late_kb;

static long resident_kb(void)
{
    FILE *f = fopen("/proc/self/statm", "r");
    char line[128];
    char *end;
    long resident;

    assert_non_null(f);
    assert_non_null(fgets(line, sizeof(line), f));
    fclose(f);
    (void)strtol(line, &end, 10); /* the whole; then what is resident, in pages */
    resident = strtol(end, NULL, 10);
    return resident * 4;
}

static void watch_memory(struct sim_run *run, const struct ttf_progress *progress)
{
    (void)run;
    if (progress->kind != TTF_PROGRESS_SLOT)
        return;
    if (progress->index == 100)
        resident_early_kb = resident_kb();
    if (progress->index == WEEK_SLOTS - 1)
        resident_late_kb = resident_kb();
}

static void a_week(struct sim_run *run)
{
    sim_run_init(run);
    run->plan.interval_ns = 10 * TTF_NS_PER_MIN;
    run->plan.count = WEEK_SLOTS;
    run->on_progress = watch_memory;
}

static void every_slot_of_a_week_has_its_record_on_time(void **state)
{
    struct sim_run run;
    struct ttf_reader *reader;

    (void)state;
    a_week(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(run.result.slots, WEEK_SLOTS);
    assert_int_equal(run.result.captured, WEEK_SLOTS);
    assert_int_equal(run.slots_told, WEEK_SLOTS);
    assert_int_equal(run.bites, 0);
    print_message("steerable: middle error p99 %.3f ms, max %.3f ms\n",
                  (double)run.result.error_p99_ns / 1e6, (double)run.result.error_max_ns / 1e6);
    assert_true(run.result.error_p99_ns < TTF_NS_PER_MS);
    assert_int_equal(ttf_reader_open(ttf_io_posix(), run.path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_summary(reader)->slots, WEEK_SLOTS);
    ttf_reader_close(reader);
    sim_run_expect_whole(&run, true);
    if (!SANITIZED) {
        print_message("resident: %ld KiB at slot 100, %ld KiB at slot %d\n", resident_early_kb,
                      resident_late_kb, WEEK_SLOTS - 1);
        assert_true(resident_late_kb - resident_early_kb < 1024);
    }
    sim_run_finish(&run);
}

static void a_camera_that_cannot_be_steered_stays_within_its_bound(void **state)
{
    struct sim_run run;
    int64_t bound;

    (void)state;
    a_week(&run);
    run.config.steerable = false;
    assert_int_equal(sim_run_boot(&run), 0);
    /* Half a frame period and jitter, as the camera states. */
    bound = run.config.frame_period_ns / 2 + 2 * run.config.jitter_ns;
    print_message("free running: middle error p99 %.3f ms, max %.3f ms, bound %.3f ms\n",
                  (double)run.result.error_p99_ns / 1e6, (double)run.result.error_max_ns / 1e6,
                  (double)bound / 1e6);
    assert_int_equal(run.result.captured, WEEK_SLOTS);
    assert_true(run.result.error_max_ns <= bound);
    assert_true(run.result.error_p99_ns > TTF_NS_PER_MS); /* it is really not steered */
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_slot_of_a_week_has_its_record_on_time),
        cmocka_unit_test(a_camera_that_cannot_be_steered_stays_within_its_bound),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
