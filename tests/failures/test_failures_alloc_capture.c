/* SPDX-License-Identifier: Apache-2.0 */
/*
 * Each allocation of a capture fails once: while it is set up, gone on with, changed and moved to the second
 * storage; and of plans and guided calibrations (README.md).
 */
#include "sim/cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "each_allocation.h"
#include "sim/sim_run.h"
#include "ttf/capture/guided_calibration.h"

static struct alloc_run run_of_all; /* set once, by main */

static struct sim_run run;
static bool moves;        /* the first storage fails at its third slot */
static int64_t committed; /* slots */

/* ---- a whole run ---- */

/* The box is made and unmade by the test; what is between may fail, in the box as well. */
static void may_fail(struct sim_run *r)
{
    alloc_hook_resume();
}

static void no_more(struct sim_run *r)
{
    alloc_hook_pause();
}

static void watch(struct sim_run *r, const struct ttf_progress *progress)
{
    committed += progress->kind == TTF_PROGRESS_SLOT;
}

static int first_fails(struct sim_run *r, const char *op, const char *path)
{
    return moves && committed >= 2 && !strstr(path, "/second") ? EROFS : 0;
}

static void begin_run(void)
{
    alloc_hook_pause();
    moves = false;
    committed = 0;
    sim_run_init(&run);
    run.no_waiting = true;
    run.plan.count = 4;
    run.plan_yaml = "# as given\n";
    run.on_box = may_fail;
    run.at_end = no_more;
    run.on_progress = watch;
    run.fault = first_fails;
    alloc_hook_resume();
}

/* One boot. */
static int work_run(struct ttf_err *err)
{
    int r;

    alloc_hook_pause();
    r = sim_run_boot(&run);
    alloc_hook_resume();
    *err = run.err;
    return r;
}

/* Without another failure, as often as it takes; then all is there, and the plan has not changed. */
static void boot_to_the_end(void)
{
    run.on_box = run.at_end = NULL;
    run.stop = 0;
    moves = false;
    if (!run.result.sealed)
        assert_int_equal(sim_run_boot(&run), 0);
    assert_true(run.result.sealed);
}

static unsigned plans_of(const struct sim_run *of)
{
    struct ttf_reader *reader;
    int n;

    assert_int_equal(ttf_reader_open(ttf_io_posix(), of->path, &reader, NULL), 0);
    n = ttf_reader_summary(reader)->n_plans;
    ttf_reader_close(reader);
    return (unsigned)n;
}

/* Every slot has its record; one that no memory was there for says so. */
static void expect_slots(const struct sim_run *of, int64_t n, int64_t unharmed)
{
    struct ttf_slot_record record;
    int64_t well = 0;

    for (int64_t i = 0; i < n; i++) {
        sim_run_record(of, i, &record);
        well += record.result == TTF_RESULT_CAPTURED;
        if (record.result != TTF_RESULT_CAPTURED)
            assert_true(record.reason[0] != '\0');
        ttf_slot_record_free(&record);
    }
    assert_true(well >= unharmed);
}

static void end_run(int r)
{
    alloc_hook_pause();
    boot_to_the_end();
    sim_run_expect_whole(&run, true);
    expect_slots(&run, 4, r == 0 ? 3 : 0);
    assert_int_equal(plans_of(&run), 1);
    sim_run_finish(&run);
    alloc_hook_resume();
}

/* Two slots are there, and the run was stopped. */
static void stop_after_two(struct sim_run *r, const struct ttf_progress *progress)
{
    watch(r, progress);
    if (committed == 2)
        r->stop = 1;
}

static void begin_stopped(void)
{
    begin_run();
    alloc_hook_pause();
    run.on_box = run.at_end = NULL;
    run.on_progress = stop_after_two;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_false(run.result.sealed);
    run.stop = 0;
    run.on_progress = watch;
    run.on_box = may_fail;
    run.at_end = no_more;
    alloc_hook_resume();
}

static void a_run_says_that_there_is_no_memory_and_goes_on_when_there_is(void **state)
{
    /* A failure behind a committed slot costs at most that slot's image, and is recorded. */
    static const struct alloc_piece pieces[] = {
        {.name = "a new run",
         .begin = begin_run,
         .work = work_run,
         .end = end_run,
         .may_do_without = true,
         .share = 7},
        {.name = "a run gone on with",
         .begin = begin_stopped,
         .work = work_run,
         .end = end_run,
         .may_do_without = true,
         .share = 7},
    };

    (void)state;
    for (unsigned i = 0; i < sizeof(pieces) / sizeof(pieces[0]); i++)
        each_allocation_fails(&pieces[i], run_of_all);
}

/* ---- the second storage ---- */

static void begin_moving(void)
{
    char path[96];

    begin_run();
    alloc_hook_pause();
    snprintf(path, sizeof(path), "%s/second", run.folder);
    assert_int_equal(mkdir(path, 0755), 0);
    snprintf(run.plan.second_storage, sizeof(run.plan.second_storage), "%s", path);
    moves = true;
    alloc_hook_resume();
}

static int64_t slots_of(const struct sim_run *of)
{
    struct ttf_reader *reader;
    int64_t n;

    if (ttf_reader_open(ttf_io_posix(), of->path, &reader, NULL) != 0)
        return 0;
    n = ttf_reader_summary(reader)->slots;
    ttf_reader_close(reader);
    return n;
}

/* Wherever it was when the failure came: each slot is in one of the two. */
static void end_moving(int r)
{
    struct sim_run second;

    alloc_hook_pause();
    boot_to_the_end();
    second = run;
    snprintf(second.path, sizeof(second.path), "%s/second/dataset", run.folder);
    sim_run_expect_undamaged(&run, !run.result.second_storage);
    assert_int_equal(slots_of(&run) + slots_of(&second), 4);
    if (run.result.second_storage)
        sim_run_expect_undamaged(&second, true);
    sim_run_finish(&run);
    alloc_hook_resume();
}

static void a_move_to_the_second_storage_loses_no_slot(void **state)
{
    static const struct alloc_piece piece = {.name = "moving to the second storage",
                                             .begin = begin_moving,
                                             .work = work_run,
                                             .end = end_moving,
                                             .may_do_without = true,
                                             .share = 7};

    (void)state;
    each_allocation_fails(&piece, run_of_all);
}

/* A run that was cut off, and its second storage is not mounted when it is looked for. */
static void begin_looking(void)
{
    char path[96];

    begin_moving();
    alloc_hook_pause();
    moves = false;
    run.on_box = run.at_end = NULL;
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, TTF_NS_PER_MIN + 40 * TTF_NS_PER_S);
    assert_int_equal(sim_run_boot(&run), -ESHUTDOWN);
    snprintf(path, sizeof(path), "%s/second", run.folder);
    assert_int_equal(rmdir(path), 0);
    alloc_hook_resume();
}

/* That nobody can know where it goes on is what must come of it. */
static int work_looking(struct ttf_err *err)
{
    char path[4096];
    int r = ttf_session_find(ttf_io_posix(), run.path, &run.plan, path, sizeof(path), err);

    if (r == 0)
        return ttf_err_set(err, -EEXIST, "storage.second", "the run would go on at %.60s", path);
    if (r != -EINVAL || strcmp(err->where, "storage.second") != 0)
        return r;
    *err = (struct ttf_err){0};
    return 0;
}

static void end_looking(int r)
{
    alloc_hook_pause();
    sim_run_finish(&run);
    alloc_hook_resume();
}

static void without_memory_nobody_says_that_a_run_has_not_moved_on(void **state)
{
    static const struct alloc_piece piece = {.name = "looking for a second storage that is away",
                                             .begin = begin_looking,
                                             .work = work_looking,
                                             .end = end_looking};

    (void)state;
    each_allocation_fails(&piece, run_of_all);
}

/* ---- asking ---- */

static int64_t numbers[3];

/* At the first slot: slower, fewer, and a note. */
static void ask_at_first(struct sim_run *r, const struct ttf_progress *progress)
{
    struct ttf_ask slower = {.kind = TTF_ASK_INTERVAL, .interval_ns = 2 * TTF_NS_PER_MIN};
    struct ttf_ask plan = {.kind = TTF_ASK_PLAN, .plan = r->plan, .plan_yaml = "# new\n"};
    struct ttf_ask note = {.kind = TTF_ASK_NOTE,
                           .note = {.utc_ns = TTF_NS_UNKNOWN, .text = "a fly"}};

    watch(r, progress);
    if (progress->kind != TTF_PROGRESS_SLOT || committed != 1)
        return;
    plan.from_index = 2;
    plan.plan.count = 3;
    plan.plan.interval_ns = 2 * TTF_NS_PER_MIN;
    numbers[0] = ttf_control_ask(r->control, &slower);
    numbers[1] = ttf_control_ask(r->control, &plan);
    numbers[2] = ttf_control_ask(r->control, &note);
}

static void begin_asking(void)
{
    begin_run();
    alloc_hook_pause();
    run.control = ttf_control_create();
    assert_non_null(run.control);
    run.on_progress = ask_at_first;
    memset(numbers, 0, sizeof(numbers));
    alloc_hook_resume();
}

/* What was asked is done, or it was said that there is no memory; the run itself is no worse for it. */
static void end_asking(int r)
{
    unsigned n = 0;

    alloc_hook_pause();
    for (unsigned i = 0; i < 3 && numbers[0] != 0; i++) {
        struct ttf_err err = {0};
        int answer =
            numbers[i] < 0 ? (int)numbers[i] : ttf_control_answer(run.control, numbers[i], &err);

        /* Stopped before it was heard: the run ended with the error itself. */
        assert_true(answer == 0 || answer == -ENOMEM || (r < 0 && answer == -ECANCELED));
        n += answer == 0;
    }
    if (r == 0)
        assert_true(n >= 2);
    run.plan.count = run.result.total ? run.result.total : run.plan.count;
    if (!run.result.sealed)
        run.plan_as_given = false;
    ttf_control_destroy(run.control);
    run.control = NULL;
    if (run.result.sealed)
        sim_run_expect_undamaged(&run, true);
    sim_run_finish(&run);
    alloc_hook_resume();
}

static void what_is_asked_is_done_or_refused(void **state)
{
    static const struct alloc_piece piece = {.name = "a run that is asked",
                                             .begin = begin_asking,
                                             .work = work_run,
                                             .end = end_asking,
                                             .may_do_without = true,
                                             .share = 7};

    (void)state;
    each_allocation_fails(&piece, run_of_all);
}

static int work_control(struct ttf_err *err)
{
    struct ttf_control *control = ttf_control_create();
    struct ttf_ask ask = {.kind = TTF_ASK_PLAN, .plan_yaml = "# new\n"};
    int64_t number = control ? ttf_control_ask(control, &ask) : -ENOMEM;

    ttf_control_destroy(control);
    return number < 0 ? (int)number : 0;
}

/* ---- plans and calibrations ---- */

static int work_plan(struct ttf_err *err)
{
    struct ttf_plan plan, back;
    char *text = NULL;
    int r;

    ttf_plan_defaults(&plan);
    plan.interval_ns = TTF_NS_PER_MIN;
    plan.count = 3;
    r = ttf_plan_json(&plan, &text, err);
    if (r == 0)
        r = ttf_plan_read(text, strlen(text), "plan", &back, err);
    free(text);
    if (r < 0)
        return r;
    r = ttf_plan_same(&plan, &back);
    if (r < 0)
        return ttf_err_set(err, r, "plan", "compared");
    assert_int_equal(r, 1);
    return 0;
}

static int work_guided(struct ttf_err *err)
{
    struct ttf_calibration calibration;
    struct ttf_scene white;
    struct ttf_box box;
    struct ttf_guided_config config = {
        .box = &box, .shot = &run.plan.shots[0], .mains_hz = 50, .frames = 2, .reflectance = 0.9};
    int r;

    ttf_calibration_init(&calibration);
    alloc_hook_pause();
    assert_int_equal(ttf_scene_procedural("white", 1, TTF_NS_PER_DAY, &white, NULL), 0);
    assert_int_equal(ttf_sim_box_create(&run.config, &white, &box, NULL), 0);
    alloc_hook_resume();
    r = ttf_guided_dark(&config, &calibration, err);
    if (r == 0)
        r = ttf_guided_flat(&config, &calibration, err);
    ttf_calibration_free(&calibration);
    alloc_hook_pause();
    ttf_box_destroy(&box);
    alloc_hook_resume();
    return r;
}

static void begin_guided(void)
{
    sim_run_plain(&run);
    run.config.margin_reflectance = 0.9;
}

static void plans_and_calibrations_say_that_there_is_no_memory(void **state)
{
    static const struct alloc_piece pieces[] = {
        {.name = "asking", .work = work_control, .speechless = true},
        {.name = "a plan as JSON", .work = work_plan},
        {.name = "a guided calibration", .begin = begin_guided, .work = work_guided},
    };

    (void)state;
    for (unsigned i = 0; i < sizeof(pieces) / sizeof(pieces[0]); i++)
        each_allocation_fails(&pieces[i], run_of_all);
}

int main(int argc, char **argv)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_run_says_that_there_is_no_memory_and_goes_on_when_there_is),
        cmocka_unit_test(a_move_to_the_second_storage_loses_no_slot),
        cmocka_unit_test(without_memory_nobody_says_that_a_run_has_not_moved_on),
        cmocka_unit_test(what_is_asked_is_done_or_refused),
        cmocka_unit_test(plans_and_calibrations_say_that_there_is_no_memory),
    };

    run_of_all = alloc_run_of(argc, argv);
    if (argc > 1 && strcmp(argv[1], "plans") == 0)
        cmocka_set_test_filter("plans_*");
    return cmocka_run_group_tests(tests, NULL, NULL);
}
