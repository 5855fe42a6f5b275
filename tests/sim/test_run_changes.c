/* SPDX-License-Identifier: Apache-2.0 */
/* A change of plan: killed at every moment of it, on a storage that is away, and run again with this plan or that. */
#include "cmocka_includes.h"

#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "living.h"

/* ---- killed at every operation ---- */

static struct sim_run *child;
static unsigned operations, kill_at;

static int count_and_die(struct sim_run *run, const char *op, const char *path)
{
    (void)run;
    (void)op;
    (void)path;
    if (++operations == kill_at)
        _exit(77);
    return 0;
}

/* Where in the run's operations slot 1 was committed and the change told, which comes behind it. */
static unsigned begins, ends;

static void note_operations(struct sim_run *run, const struct ttf_progress *progress)
{
    (void)run;
    if (progress->kind == TTF_PROGRESS_SLOT && progress->index == 1)
        begins = operations;
    if (progress->kind == TTF_PROGRESS_EVENT && strstr(progress->text, "plan 1 is in force"))
        ends = operations + 2;
}

/* Killed at that operation: in a process of its own. False: it came to its end. */
static bool boot_and_die(struct sim_run *run, unsigned at)
{
    int status;
    pid_t pid = fork();

    assert_true(pid >= 0);
    if (pid == 0) {
        child = run;
        kill_at = at;
        operations = 0;
        run->fault = count_and_die;
        _exit(sim_run_boot(run) == 0 ? 0 : 1);
    }
    assert_int_equal(waitpid(pid, &status, 0), pid);
    assert_true(WIFEXITED(status));
    assert_true(WEXITSTATUS(status) == 77 || WEXITSTATUS(status) == 0);
    return WEXITSTATUS(status) == 77;
}

static void ask_for_change(struct sim_run *run)
{
    struct ttf_ask plan = {.kind = TTF_ASK_PLAN, .from_index = 2, .plan_yaml = "interval: 30s\n"};

    plan.plan = run->plan;
    plan.plan.interval_ns = 30 * TTF_NS_PER_S;
    plan.plan.count = 8;
    living_ask(run, &plan);
}

/* By the dataset alone: which plan it is left with. All of it, or nothing. */
static bool new_plan_in_force(const struct sim_run *run)
{
    struct ttf_segment last;
    struct ttf_reader *reader;

    assert_int_equal(ttf_reader_open(ttf_io_posix(), run->path, &reader, NULL), 0);
    assert_int_equal(ttf_reader_segment(reader, ttf_reader_summary(reader)->n_segments - 1, &last),
                     0);
    ttf_reader_close(reader);
    assert_true(last.plan == 0 || last.plan == 1);
    assert_int_equal(last.interval_ns, last.plan == 1 ? 30 * TTF_NS_PER_S : TTF_NS_PER_MIN);
    return last.plan == 1;
}

/* Gone on with by the plan it was begun with, as whoever starts the box again does. */
static void expect_gone_on_with(struct sim_run *run, bool changed)
{
    char results[32];

    /* As the program does: a new boot, an outage after the last slot. */
    run->config.power_on_ns = 200 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(run), 0);
    sim_run_results(run, results, sizeof(results));
    assert_int_equal(strlen(results), changed ? 8 : 6);
    assert_int_equal(sim_run_due_of(run, 5) - sim_run_due_of(run, 4),
                     changed ? 30 * TTF_NS_PER_S : TTF_NS_PER_MIN);
    assert_int_equal(run->result.total, changed ? 8 : 6);
    assert_int_equal(sim_run_events(run, "plan", "plan 1 has come since"), changed);
    run->plan.count = changed ? 8 : 6;
    sim_run_expect_whole(run, true);
}

static void killed_at_any_operation_of_a_change_the_old_or_the_new_plan_is_in_force(void **state)
{
    unsigned with_old = 0;
    unsigned with_new = 0;
    struct sim_run run;

    (void)state;
    living_init(&run);
    ask_for_change(&run);
    operations = kill_at = 0;
    run.fault = count_and_die;
    run.on_progress = note_operations;
    assert_int_equal(sim_run_boot(&run), 0);
    run.plan.count = 8;
    sim_run_expect_whole(&run, true);
    sim_run_expect_text(&run, "plans/1.yaml", "interval: 30s\n");
    living_finish(&run);
    assert_true(begins > 0 && ends > begins);
    for (unsigned at = begins + 1; at <= ends; at++) {
        bool changed;

        living_init(&run);
        ask_for_change(&run);
        assert_true(boot_and_die(&run, at));
        changed = new_plan_in_force(&run);
        with_old += !changed;
        with_new += changed;
        ttf_control_destroy(run.control); /* the next boot knows nothing of it */
        run.control = NULL;
        expect_gone_on_with(&run, changed);
        living_finish(&run);
    }
    print_message("killed %u times: %u with the old plan, %u with the new one\n", ends - begins,
                  with_old, with_new);
    assert_true(with_old > 5 && with_new > 2);
}

/* ---- run again with this plan or that ---- */

static void stopped_after_a_change(struct sim_run *run)
{
    living_init(run);
    run->plan.count = 10;
    living_ask(run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
                                      .from_index = 2,
                                      .interval_ns = 30 * TTF_NS_PER_S});
    living_ask(run, &(struct ttf_ask){.kind = TTF_ASK_STOP, .from_index = 4});
    assert_int_equal(sim_run_boot(run), 0);
    sim_run_expect(run, "cccc");
    run->config.power_on_ns = run->ended_ns + TTF_NS_PER_S;
}

static void the_first_plan_goes_on_with_what_it_has_become(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;

    (void)state;
    stopped_after_a_change(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_segment_of(&run, 9, &segment);
    assert_int_equal(segment.plan, 1);
    assert_int_equal(segment.interval_ns, 30 * TTF_NS_PER_S);
    assert_int_equal(sim_run_events(&run, "plan", "plan given is plan 0, but plan 1"), 1);
    sim_run_expect_whole(&run, true);
    /* Complete: nothing left to do by the first plan either. */
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.sealed);
    living_finish(&run);
}

static void a_plan_that_is_new_is_a_change(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;

    (void)state;
    stopped_after_a_change(&run);
    run.plan.interval_ns = 45 * TTF_NS_PER_S;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_segment_of(&run, 9, &segment);
    assert_int_equal(segment.plan, 2);
    assert_int_equal(segment.interval_ns, 45 * TTF_NS_PER_S);
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

static void the_first_plan_is_gone_back_to_when_that_is_meant(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;

    (void)state;
    stopped_after_a_change(&run);
    run.plan_as_given = true;
    assert_int_equal(sim_run_boot(&run), 0);
    sim_run_segment_of(&run, 9, &segment);
    assert_int_equal(segment.plan, 2);
    assert_int_equal(segment.interval_ns, TTF_NS_PER_MIN);
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

/* ---- asked on a storage that is away ---- */

static void away_for_a_while(struct sim_run *run, const struct ttf_progress *progress)
{
    if (progress->kind == TTF_PROGRESS_SLOT && progress->index == 1)
        run->failing = 5; /* the change, and the next slot's files */
}

static void a_change_waits_for_its_storage_in_its_turn(void **state)
{
    struct sim_run run;
    struct ttf_segment segment;
    int64_t n;

    (void)state;
    living_init(&run);
    run.plan.count = 8;
    run.on_progress = away_for_a_while;
    n = living_ask(&run, &(struct ttf_ask){.kind = TTF_ASK_INTERVAL,
                                           .from_index = 2,
                                           .interval_ns = 30 * TTF_NS_PER_S});
    if (sim_run_boot(&run) < 0)
        print_error("%s: %s\n", run.err.where, run.err.what);
    assert_int_equal(run.code, 0);
    living_expect_done(&run, n);
    assert_int_equal(run.result.slots, 8);
    assert_int_equal(sim_run_segment_of(&run, 2, &segment), 1);
    assert_int_equal(segment.interval_ns, 30 * TTF_NS_PER_S);
    sim_run_expect_whole(&run, true);
    living_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(killed_at_any_operation_of_a_change_the_old_or_the_new_plan_is_in_force),
        cmocka_unit_test(the_first_plan_goes_on_with_what_it_has_become),
        cmocka_unit_test(a_plan_that_is_new_is_a_change),
        cmocka_unit_test(the_first_plan_is_gone_back_to_when_that_is_meant),
        cmocka_unit_test(a_change_waits_for_its_storage_in_its_turn),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
