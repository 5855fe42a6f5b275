/* SPDX-License-Identifier: Apache-2.0 */
/* A disk that fills up: previews go first, then the run goes on in the second storage, or slots are missed. */
#include "cmocka_includes.h"

#include <stdio.h>
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(previews_go_first_oldest_first),
        cmocka_unit_test(a_full_disk_is_left_for_the_second_storage),
        cmocka_unit_test(without_one_capture_stops_before_the_reserve),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
