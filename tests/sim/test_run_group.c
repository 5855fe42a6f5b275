/* SPDX-License-Identifier: Apache-2.0 */
/* A run whose plan needs other streams begins a dataset of its own, in the group of the one that it goes on from. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "second_run.h"

static void manifest_of(const char *path, struct ttf_manifest *ret)
{
    assert_int_equal(ttf_manifest_load(ttf_io_posix(), path, ret, NULL), 0);
}

/* A dataset of this name beside the run's, by a plan with another stream, in the group of `of`. */
static struct sim_run beside(const struct sim_run *run, const char *name, const char *of)
{
    struct sim_run other = *run;

    snprintf(other.path, sizeof(other.path), "%s/%s", run->folder, name);
    snprintf(other.plan.group, sizeof(other.plan.group), "%s", of);
    (void)snprintf(other.plan.shots[0].stream, sizeof other.plan.shots[0].stream, "%s", name);
    other.config.power_on_ns = run->ended_ns + TTF_NS_PER_S;
    other.config.n_faults = 0;
    other.committed = 0;
    return other;
}

static void first_of_all(struct sim_run *run)
{
    sim_run_init(run);
    run->plan.count = 2;
    assert_int_equal(sim_run_boot(run), 0);
}

static void expect_member(const struct sim_run *run, const struct ttf_manifest *first,
                          const char *member)
{
    struct ttf_manifest m;

    manifest_of(run->path, &m);
    assert_string_equal(m.group_uuid, first->uuid);
    assert_string_equal(m.group_member, member);
    assert_string_not_equal(m.uuid, first->uuid);
}

static void expect_refused(struct sim_run *run, const char *what)
{
    assert_int_equal(sim_run_boot(run), -EINVAL);
    assert_string_equal(run->err.where, "group");
    if (!strstr(run->err.what, what))
        print_error("'%s' does not say '%s'\n", run->err.what, what);
    assert_non_null(strstr(run->err.what, what));
}

static void another_stream_begins_a_dataset_of_the_group(void **state)
{
    struct sim_run run, second, third;
    struct ttf_manifest first;

    (void)state;
    first_of_all(&run);
    manifest_of(run.path, &first);
    assert_string_equal(first.group_uuid, "");
    second = beside(&run, "infrared", "dataset");
    assert_int_equal(sim_run_boot(&second), 0);
    sim_run_expect(&second, "cc");
    sim_run_expect_whole(&second, true);
    expect_member(&second, &first, "2");
    third = beside(&second, "raking", "infrared");
    assert_int_equal(sim_run_boot(&third), 0);
    expect_member(&third, &first, "3");
    sim_run_expect_text(&third, "plans/0.json", "\"group\": \"infrared\"");
    sim_run_expect_whole(&run, true); /* untouched, its seal too */
    sim_run_finish(&run);
}

/* FORMAT.md: how far it is from the first, so two that name the same one have the same; uuid tells them apart. */
static void two_that_go_on_from_the_same_one_have_the_same_member(void **state)
{
    struct sim_run run, second, third;
    struct ttf_manifest first, a, b;

    (void)state;
    first_of_all(&run);
    manifest_of(run.path, &first);
    second = beside(&run, "infrared", "dataset");
    assert_int_equal(sim_run_boot(&second), 0);
    third = beside(&second, "raking", "dataset");
    assert_int_equal(sim_run_boot(&third), 0);
    expect_member(&second, &first, "2");
    expect_member(&third, &first, "2");
    manifest_of(second.path, &a);
    manifest_of(third.path, &b);
    assert_string_not_equal(a.uuid, b.uuid);
    sim_run_finish(&run);
}

/* Only its beginning needs the other one, which may be carried away meanwhile. */
static void gone_on_with_it_is_of_the_group_without_the_other(void **state)
{
    struct sim_run run, second;
    struct ttf_manifest first;
    char moved[128];

    (void)state;
    first_of_all(&run);
    manifest_of(run.path, &first);
    second = beside(&run, "infrared", "dataset");
    second.plan.count = 6;
    sim_run_fault(&second, TTF_FAULT_POWER_CUT, second.config.power_on_ns + 160 * TTF_NS_PER_S)
        ->amount = 5;
    assert_int_equal(sim_run_boot(&second), -ESHUTDOWN);
    snprintf(moved, sizeof(moved), "%s/elsewhere", run.folder);
    assert_int_equal(rename(run.path, moved), 0);
    second.config.power_on_ns = second.back_ns;
    assert_int_equal(sim_run_boot(&second), 0);
    sim_run_expect(&second, "cccccc");
    expect_member(&second, &first, "2");
    sim_run_finish(&run);
}

/* Stopped, and gone on with by a plan of another interval. */
static void another_interval(struct sim_run *run, int64_t interval_ns)
{
    run->plan.interval_ns = interval_ns;
    run->plan.count += 2;
    run->config.power_on_ns = run->ended_ns + TTF_NS_PER_S;
}

/* Nor does a plan that it does not know need the other one, if it names the group of one that it knows. */
static void another_plan_of_the_group_needs_the_other_no_more(void **state)
{
    struct sim_run run, second;
    struct ttf_manifest first;
    char moved[128];

    (void)state;
    first_of_all(&run);
    manifest_of(run.path, &first);
    second = beside(&run, "infrared", "dataset");
    assert_int_equal(sim_run_boot(&second), 0);
    snprintf(moved, sizeof(moved), "%s/elsewhere", run.folder);
    assert_int_equal(rename(run.path, moved), 0);
    another_interval(&second, 50 * TTF_NS_PER_S);
    assert_int_equal(sim_run_boot(&second), 0);
    sim_run_expect(&second, "cccc");
    another_interval(&second, 40 * TTF_NS_PER_S);
    second.plan.group[0] =
        '\0'; /* which needs no other one either, and leaves the group as it is */
    assert_int_equal(sim_run_boot(&second), 0);
    another_interval(&second, 50 * TTF_NS_PER_S);
    (void)snprintf(second.plan.group, sizeof second.plan.group, "%s", "dataset");
    assert_int_equal(sim_run_boot(&second), 0);
    sim_run_expect(&second, "cccccccc");
    expect_member(&second, &first, "2");
    (void)snprintf(second.plan.group, sizeof second.plan.group, "%s", "nowhere");
    another_interval(&second, 30 * TTF_NS_PER_S);
    expect_refused(&second, "no dataset 'nowhere' beside");
    sim_run_finish(&run);
}

static unsigned operations, fails_at;

static int fails_from(struct sim_run *run, const char *op, const char *path)
{
    (void)run;
    (void)op;
    (void)path;
    return ++operations >= fails_at ? EIO : 0;
}

/* Whichever operation of its beginning is the last that the disk takes: run again it is of the group, or begins so. */
static void cut_off_at_any_operation_of_its_beginning_it_is_of_the_group(void **state)
{
    struct ttf_manifest first;
    struct sim_run run;

    (void)state;
    first_of_all(&run);
    manifest_of(run.path, &first);
    for (fails_at = 1; fails_at < 60; fails_at++) {
        struct sim_run second;
        char name[24];

        snprintf(name, sizeof(name), "try-%u", fails_at);
        second = beside(&run, name, "dataset");
        second.plan.count = 1;
        second.no_waiting = true;
        second.fault = fails_from;
        operations = 0;
        assert_true(sim_run_boot(&second) < 0);
        second.fault = NULL;
        second.config.power_on_ns = second.ended_ns + TTF_NS_PER_S;
        assert_int_equal(sim_run_boot(&second), 0);
        expect_member(&second, &first, "2");
        sim_run_expect_whole(&second, true);
    }
    sim_run_finish(&run);
}

static void what_is_no_dataset_to_join_is_refused(void **state)
{
    struct sim_run run, other, rehearsal;

    (void)state;
    first_of_all(&run);
    other = beside(&run, "infrared", "nowhere");
    expect_refused(&other, "no dataset 'nowhere' beside");
    other = beside(&run, "infrared", "infrared");
    expect_refused(&other, "the run's own");
    rehearsal = beside(&run, "rehearsal", "");
    rehearsal.rehearse = 2;
    assert_int_equal(sim_run_boot(&rehearsal), 0);
    other = beside(&run, "infrared", "rehearsal");
    expect_refused(&other, "a rehearsal");
    other = beside(&run, "infrared", "../dataset");
    expect_refused(&other, "the name of a dataset");
    assert_null(sim_run_text(&other, "dataset.json"));
    sim_run_finish(&run);
}

/* dataset.json is written once. */
static void a_dataset_that_was_begun_joins_no_group(void **state)
{
    struct sim_run run, alone;

    (void)state;
    first_of_all(&run);
    alone = beside(&run, "alone", "");
    assert_int_equal(sim_run_boot(&alone), 0);
    snprintf(alone.plan.group, sizeof(alone.plan.group), "dataset");
    alone.plan.count = 4;
    alone.config.power_on_ns = alone.ended_ns + TTF_NS_PER_S;
    expect_refused(&alone, "was begun, and not in the group");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

/* The first storage can only be read from its second slot on. */
static int only_the_second_writes(struct sim_run *run, const char *op, const char *path)
{
    static const char *const writes[] = {"append", "pwrite", "sync", "rename", "sync_dir"};

    for (unsigned i = 0; i < sizeof(writes) / sizeof(writes[0]); i++)
        if (run->committed >= 2 && strcmp(op, writes[i]) == 0 && !second_run_holds(path))
            return EROFS;
    return 0;
}

/* A run of the group of `run` that its storage fails for: it has gone on in the second one. */
static struct sim_run moved_to_second(const struct sim_run *run)
{
    struct sim_run other = beside(run, "infrared", "dataset");

    other.plan.count = 5;
    other.fault = only_the_second_writes;
    sim_run_fault(&other, TTF_FAULT_POWER_CUT, other.config.power_on_ns + 220 * TTF_NS_PER_S)
        ->amount = 1;
    assert_int_equal(sim_run_boot(&other), -ESHUTDOWN);
    other.config.power_on_ns = other.back_ns;
    assert_int_equal(sim_run_boot(&other), 0);
    assert_true(other.result.second_storage);
    assert_int_equal(other.result.slots, 3);
    return other;
}

static struct sim_run second_of(const struct sim_run *run)
{
    struct sim_run there = *run;

    snprintf(there.path, sizeof(there.path), "%s/second/infrared", run->folder);
    return there;
}

/* What its storage fails for goes on in the second one, and is found there: by the group that both are of. */
static void one_of_a_group_goes_on_in_its_second_storage(void **state)
{
    struct ttf_manifest first, m;
    struct sim_run run, other, there;

    (void)state;
    second_run_init(&run);
    run.plan.count = 2;
    assert_int_equal(sim_run_boot(&run), 0);
    manifest_of(run.path, &first);
    other = moved_to_second(&run);
    there = second_of(&other);
    expect_member(&other, &first, "first");
    expect_member(&there, &first, "second");
    other = beside(&other, "raking", "infrared");
    other.fault = NULL;
    other.plan.count = 2;
    other.plan.second_storage[0] = '\0';
    assert_int_equal(sim_run_boot(&other), 0);
    expect_member(&other, &first, "2"); /* "first" is no number to go on from */
    manifest_of(run.path, &m);
    assert_string_equal(m.group_uuid, first.uuid);
    sim_run_finish(&run);
}

/* Others of the group lie where the run began, wherever it is now. */
static void gone_on_with_in_the_second_storage_its_group_is_looked_for_where_it_began(void **state)
{
    struct sim_run run, other, third, alone;

    (void)state;
    second_run_init(&run);
    run.plan.count = 2;
    assert_int_equal(sim_run_boot(&run), 0);
    third = beside(&run, "raking", "dataset");
    assert_int_equal(sim_run_boot(&third), 0);
    alone = beside(&run, "alone", "");
    assert_int_equal(sim_run_boot(&alone), 0);
    other = moved_to_second(&run);
    another_interval(&other, 50 * TTF_NS_PER_S);
    assert_int_equal(sim_run_boot(&other), 0);
    another_interval(&other, 40 * TTF_NS_PER_S);
    (void)snprintf(other.plan.group, sizeof other.plan.group, "%s", "raking");
    assert_int_equal(sim_run_boot(&other), 0);
    assert_true(other.result.second_storage);
    another_interval(&other, 30 * TTF_NS_PER_S);
    (void)snprintf(other.plan.group, sizeof other.plan.group, "%s", "alone");
    expect_refused(&other, "was begun, and not in the group");
    sim_run_finish(&run);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(another_stream_begins_a_dataset_of_the_group),
        cmocka_unit_test(two_that_go_on_from_the_same_one_have_the_same_member),
        cmocka_unit_test(gone_on_with_it_is_of_the_group_without_the_other),
        cmocka_unit_test(another_plan_of_the_group_needs_the_other_no_more),
        cmocka_unit_test(cut_off_at_any_operation_of_its_beginning_it_is_of_the_group),
        cmocka_unit_test(what_is_no_dataset_to_join_is_refused),
        cmocka_unit_test(a_dataset_that_was_begun_joins_no_group),
        cmocka_unit_test(one_of_a_group_goes_on_in_its_second_storage),
        cmocka_unit_test(gone_on_with_in_the_second_storage_its_group_is_looked_for_where_it_began),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
