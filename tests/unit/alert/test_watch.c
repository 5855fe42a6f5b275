/* SPDX-License-Identifier: Apache-2.0 */
/* test_watch.c: who is told what, and when: by a clock that is set by hand, of a dataset that is written by hand. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "alert.h"
#include "orders_file.h"
#include "store_test.h"
#include "ttf/hal/clock_backend.h"

#define BOOT   "0a0b0c0d-0000-4000-8000-000000000001" /* that of small_create's segment */
#define BEGIN  TTF_NS_PER_MIN
#define SECOND TTF_NS_PER_S

struct hand_clock {
    struct ttf_clock base; /* first */
    int64_t now_ns;
    const char *boot;
};

static int64_t hand_now_ns(struct ttf_clock *clock)
{
    return ((struct hand_clock *)clock)->now_ns;
}

static void hand_utc(struct ttf_clock *clock, struct ttf_utc *ret)
{
    *ret = (struct ttf_utc){.boot_ns = hand_now_ns(clock), .utc_ns = 5, .trust = TTF_TRUST_NTP};
}

static const char *hand_boot(struct ttf_clock *clock)
{
    return ((struct hand_clock *)clock)->boot;
}

static const struct ttf_clock_ops OPS = {
    .now_ns = hand_now_ns, .utc = hand_utc, .boot_id = hand_boot};

struct fixture {
    struct hand_clock clock;
    struct ttf_alerts_config config;
    struct watch watch;
    const char *says; /* what the daemon does; "": it is not there */
    unsigned n;
    struct alert told[16];
};

static void on_told(void *ctx, const struct alert *alert)
{
    struct fixture *f = ctx;

    assert_true(f->n < sizeof f->told / sizeof *f->told);
    f->told[f->n++] = *alert;
}

static void on_says(void *ctx, char *ret, size_t size)
{
    const struct fixture *f = ctx;

    (void)snprintf(ret, size, "%s", f->says);
}

static void start_watching(struct fixture *f)
{
    watch_init(&f->watch, &f->config, ttf_io_posix(), &f->clock.base);
    f->watch.tell = on_told;
    f->watch.says = on_says;
    f->watch.ctx = f;
    f->n = 0;
}

/* In a box whose configuration names the plan of `grass`; the clock stands at 5 s. */
static struct fixture *begin(const char *folder)
{
    struct fixture *f = calloc(1, sizeof *f);

    assert_non_null(f);
    f->clock = (struct hand_clock){{.ops = &OPS}, 5 * SECOND, BOOT};
    f->config.begin_ns = BEGIN;
    f->says = "retrying: the guardian is away";
    (void)snprintf(f->config.data, sizeof f->config.data, "%s/data", folder);
    (void)snprintf(f->config.state, sizeof f->config.state, "%s/state", folder);
    (void)snprintf(f->config.plan, sizeof f->config.plan, "%s/grass.yaml", folder);
    (void)snprintf(f->config.dataset, sizeof f->config.dataset, "grass");
    assert_int_equal(run("mkdir %s/data %s/state", folder, folder), 0);
    write_text(f->config.plan, "interval: 10s\ncount: 9\n", 23);
    start_watching(f);
    return f;
}

/* Looks as often as the program does, until so many seconds have passed. */
static void pass(struct fixture *f, double seconds)
{
    int64_t until_ns = f->clock.now_ns + (int64_t)(seconds * 1e9);

    for (;;) {
        int64_t next_ns = watch_next_ns(&f->watch, f->clock.now_ns);

        watch_look(&f->watch);
        if (f->clock.now_ns >= until_ns)
            return;
        f->clock.now_ns = next_ns < until_ns ? next_ns : until_ns;
    }
}

static void decided(struct fixture *f, enum order_state state, const char *why)
{
    struct order order = {.state = state};
    struct orders_file file;
    char dataset[600];

    (void)snprintf(order.dataset, sizeof order.dataset, "grass");
    (void)snprintf(order.why, sizeof order.why, "%s", why);
    (void)snprintf(dataset, sizeof dataset, "%s/grass", f->config.data);
    orders_file_name(&file, ttf_io_posix(), f->config.state, f->config.plan, dataset);
    assert_int_equal(orders_file_write(&file, &order, NULL), 0);
}

static bool told(const struct fixture *f, unsigned i, const char *kind, const char *words)
{
    return i < f->n && strcmp(f->told[i].kind, kind) == 0 && strstr(f->told[i].text, words);
}

static struct ttf_writer *create_as(const struct ttf_manifest *manifest, const char *path,
                                    int64_t origin_ns, int64_t interval_ns)
{
    struct ttf_writer *writer = NULL;
    struct ttf_segment segment = {.boot_id = BOOT,
                                  .trust = "rtc",
                                  .zone = "UTC",
                                  .origin_ns = origin_ns,
                                  .origin_utc_ns = INT64_C(1790000000000000000),
                                  .uncertainty_ns = SECOND,
                                  .interval_ns = interval_ns};

    assert_int_equal(
        ttf_writer_create(ttf_io_posix(), path, manifest, "interval: 1s\n", "{}\n", &writer, NULL),
        0);
    assert_int_equal(ttf_writer_segment(writer, &segment, NULL), 0);
    return writer;
}

/* A dataset whose first slot is due then. */
static struct ttf_writer *create(const char *path, int64_t origin_ns, int64_t interval_ns)
{
    struct ttf_manifest manifest;

    small_manifest(&manifest);
    return create_as(&manifest, path, origin_ns, interval_ns);
}

static struct ttf_writer *create_member(const char *group, const char *member, const char *path,
                                        int64_t origin_ns)
{
    struct ttf_manifest manifest;

    small_manifest(&manifest);
    (void)snprintf(manifest.group_uuid, sizeof manifest.group_uuid, "%s", group);
    (void)snprintf(manifest.group_member, sizeof manifest.group_member, "%s", member);
    return create_as(&manifest, path, origin_ns, 10 * SECOND);
}

/* What a run of that group goes on in. */
static struct ttf_writer *create_second(const char *group, const char *path, int64_t origin_ns)
{
    return create_member(group, "second", path, origin_ns);
}

static void a_run_that_does_not_begin_is_told_with_why(void **state)
{
    struct fixture *f = begin(*state);
    struct ttf_writer *writer;

    pass(f, 59);
    assert_int_equal(f->n, 0);
    pass(f, 2);
    assert_int_equal(f->n, 1);
    assert_true(told(f, 0, "not-begun", "the capture has not begun"));
    assert_true(told(f, 0, "not-begun", "the box says: retrying: the guardian is away"));
    assert_string_equal(f->told[0].dataset, "grass");
    assert_int_equal(f->told[0].severity, TTF_ALERT_ALARM);
    assert_true(f->watch.stopped);
    pass(f, 300);
    assert_int_equal(f->n, 1); /* once */
    writer = create(in(*state, "data/grass"), f->clock.now_ns, 10 * SECOND);
    pass(f, 1);
    assert_int_equal(f->n, 2);
    assert_true(told(f, 1, "going-on", "goes on"));
    assert_false(f->watch.stopped);
    ttf_writer_abandon(writer);
    free(f);
}

static void nothing_that_nobody_wants_is_an_alarm(void **state)
{
    struct fixture *f = begin(*state);
    struct ttf_writer *writer = small_create(ttf_io_posix(), in(*state, "data/old"));

    assert_int_equal(remove(f->config.plan), 0); /* the daemon waits for it */
    pass(f, 300);
    assert_int_equal(f->n, 0);
    decided(f, ORDER_NONE, "");
    pass(f, 300);
    assert_int_equal(f->n, 0);
    ttf_writer_abandon(writer);
    free(f);
}

static void while_lamps_settle_before_the_first_slot_nobody_is_told(void **state)
{
    struct fixture *f = begin(*state);
    struct ttf_writer *writer;

    pass(f, 2);
    writer = create(in(*state, "data/grass"), f->clock.now_ns + 22 * SECOND, SECOND);
    pass(f, 22.4);
    assert_int_equal(f->n, 0);
    pass(f, 0.5);
    assert_int_equal(f->n, 1);
    assert_true(told(f, 0, "stopped", "the capture has stopped"));
    ttf_writer_abandon(writer);
    free(f);
}

static void a_plan_that_waits_for_its_start_is_silent_and_late_behind_it(void **state)
{
    struct fixture *f = begin(*state);
    struct ttf_writer *writer = create(in(*state, "data/grass"), 5005 * SECOND, 60 * SECOND);

    pass(f, 2500);
    start_watching(f); /* the alerter begins anew in between */
    pass(f, 2500 + 29);
    assert_int_equal(f->n, 0);
    pass(f, 2);
    assert_int_equal(f->n, 1); /* within two slots */
    ttf_writer_abandon(writer);
    free(f);
}

static void a_box_that_was_without_power_has_its_time_to_go_on(void **state)
{
    struct fixture *f = begin(*state);
    struct ttf_writer *writer = small_create(ttf_io_posix(), in(*state, "data/grass"));

    assert_int_equal(small_slot(writer, 0), 0);
    f->clock.boot = "0a0b0c0d-0000-4000-8000-000000000002";
    pass(f, 59);
    assert_int_equal(f->n, 0);
    pass(f, 2);
    assert_true(told(f, 0, "not-begun", "has not gone on"));
    ttf_writer_abandon(writer);
    free(f);
}

static void a_stop_by_a_person_is_told_as_that_once_and_is_no_alarm(void **state)
{
    struct fixture *f = begin(*state);
    struct ttf_writer *writer = small_create(ttf_io_posix(), in(*state, "data/grass"));

    assert_int_equal(small_slot(writer, 0), 0);
    pass(f, 3);
    /* The button: its run ends, then it is written down. */
    assert_int_equal(
        ttf_writer_event(writer, "button", 0, 0, "held: the run is to end", NULL, NULL), 0);
    assert_int_equal(ttf_writer_event(writer, "stop", 0, 0, "ended as asked", NULL, NULL), 0);
    pass(f, 1);
    decided(f, ORDER_STOPPED, "");
    pass(f, 2000);
    assert_int_equal(f->n, 1);
    assert_true(told(f, 0, "stopped-by-person", "by a person, by the button"));
    assert_int_equal(f->told[0].severity, TTF_ALERT_WARNING);
    assert_false(f->watch.stopped); /* the heart goes on beating */
    start_watching(f);
    pass(f, 1000);
    assert_int_equal(f->n, 0); /* it was told */
    decided(f, ORDER_RUN, "");
    pass(f, 59);
    assert_int_equal(small_slot(writer, 1), 0);
    pass(f, 1);
    assert_int_equal(f->n, 1);
    assert_true(told(f, 0, "going-on", "goes on"));
    pass(f, 60);
    assert_true(told(f, 1, "stopped", "the capture has stopped"));
    ttf_writer_abandon(writer);
    free(f);
}

static void a_program_that_was_told_to_end_is_no_persons_stop(void **state)
{
    struct fixture *f = begin(*state);
    struct ttf_writer *writer = small_create(ttf_io_posix(), in(*state, "data/grass"));

    pass(f, 1);
    assert_int_equal(small_slot(writer, 0), 0);
    pass(f, 1);
    assert_int_equal(ttf_writer_event(writer, "stop", 0, 0, "ended as asked", NULL, NULL), 0);
    pass(f, 6);
    assert_int_equal(f->n, 1);
    assert_true(told(f, 0, "event", "told to end"));
    pass(f, 20);
    assert_int_equal(f->n, 2);
    assert_true(told(f, 1, "stopped", "the capture has stopped"));
    ttf_writer_abandon(writer);
    free(f);
}

static void orders_that_nobody_understands_are_an_alarm_until_something_runs(void **state)
{
    struct fixture *f = begin(*state);
    struct ttf_writer *writer;

    write_text(in(f->config.state, "run.json"), "{\"st", 4);
    pass(f, 100);
    decided(f, ORDER_STOPPED, "what was to run could not be understood"); /* as the daemon has it */
    pass(f, 100);
    assert_int_equal(f->n, 1);
    assert_true(told(f, 0, "stopped", "cannot be understood"));
    assert_true(f->watch.stopped);
    decided(f, ORDER_RUN, "");
    pass(f, 10);
    writer = create(in(*state, "data/grass"), f->clock.now_ns, 10 * SECOND);
    pass(f, 1);
    assert_true(told(f, 1, "going-on", "goes on"));
    ttf_writer_abandon(writer);
    free(f);
}

static void a_disk_that_goes_with_all_that_was_decided_is_an_alarm(void **state)
{
    struct fixture *f = begin(*state);
    struct ttf_writer *writer;

    assert_int_equal(remove(f->config.plan), 0);
    decided(f, ORDER_RUN, "");
    writer = small_create(ttf_io_posix(), in(*state, "data/grass"));
    pass(f, 3);
    assert_int_equal(small_slot(writer, 0), 0);
    pass(f, 3);
    ttf_writer_abandon(writer);
    assert_int_equal(run("rm -r %s/state %s/data", (char *)*state, (char *)*state), 0);
    pass(f, 20);
    assert_int_equal(f->n, 1);
    assert_true(told(f, 0, "stopped", "the capture has stopped"));
    free(f);
}

/* Another box, whose plan has a second storage: ret. */
static struct fixture *begin_with_second(const char *folder, const char **ret)
{
    struct fixture *f = begin(folder);
    char plan[300];

    *ret = in(folder, "second");
    (void)snprintf(plan, sizeof plan, "interval: 10s\ncount: 9\nstorage: {second: %s}\n", *ret);
    write_text(f->config.plan, plan, strlen(plan));
    assert_int_equal(run("mkdir %s", *ret), 0);
    return f;
}

static void a_run_that_goes_on_in_its_second_storage_has_not_stopped(void **state)
{
    const char *second;
    struct fixture *f = begin_with_second(*state, &second);
    struct ttf_writer *first, *writer;
    struct ttf_manifest of_first;

    first = small_create(ttf_io_posix(), in(*state, "data/grass"));
    assert_int_equal(ttf_manifest_load(ttf_io_posix(), in(*state, "data/grass"), &of_first, NULL),
                     0);
    pass(f, 5);
    assert_int_equal(small_slot(first, 0), 0);
    pass(f, 5);
    writer = create_second(of_first.uuid, in(second, "grass"), f->clock.now_ns + 5 * SECOND);
    for (int64_t i = 0; i < 6; i++) {
        pass(f, 10);
        assert_int_equal(small_slot(writer, i), 0);
    }
    assert_int_equal(f->n, 0);
    pass(f, 20);
    assert_true(told(f, 0, "stopped", "the capture has stopped"));
    ttf_writer_abandon(first);
    ttf_writer_abandon(writer);
    free(f);
}

/* Begun in the group of another dataset, it names that one's uuid in both storages, and its own in none. */
static void a_run_of_another_ones_group_is_followed_into_its_second_storage(void **state)
{
    static const char GROUP[] = "0a0b0c0d-0000-4000-8000-00000000000a";
    const char *second;
    struct fixture *f = begin_with_second(*state, &second);
    struct ttf_writer *first =
        create_member(GROUP, "first", in(*state, "data/grass"), f->clock.now_ns);
    struct ttf_writer *writer;

    pass(f, 5);
    writer = create_second(GROUP, in(second, "grass"), f->clock.now_ns + 5 * SECOND);
    for (int64_t i = 0; i < 6; i++) {
        pass(f, 10);
        assert_int_equal(small_slot(writer, i), 0);
    }
    assert_int_equal(f->n, 0);
    pass(f, 30);
    assert_true(told(f, 0, "stopped", "the capture has stopped"));
    ttf_writer_abandon(first);
    ttf_writer_abandon(writer);
    free(f);
}

/* What an ended run left in the second storage is not the one that is wanted. */
static void expect_no_beginning(struct fixture *f)
{
    pass(f, 70);
    assert_int_equal(f->n, 1);
    assert_true(told(f, 0, "not-begun", "the capture has not begun"));
    free(f);
}

static void an_older_dataset_of_this_name_in_the_second_storage_hides_no_alarm(void **state)
{
    const char *second;
    struct fixture *f = begin_with_second(*state, &second);
    char digest[65];
    struct ttf_writer *old = create(in(second, "grass"), 0, 10 * SECOND);

    assert_int_equal(ttf_writer_seal(old, "count", digest, NULL), 0);
    ttf_writer_abandon(old);
    expect_no_beginning(f);
}

static void the_second_part_of_a_run_that_ended_hides_no_alarm(void **state)
{
    const char *second;
    struct fixture *f = begin_with_second(*state, &second);
    char digest[65];
    struct ttf_writer *old =
        create_second("0a0b0c0d-0000-4000-8000-00000000000f", in(second, "grass"), 0);

    assert_int_equal(ttf_writer_seal(old, "count", digest, NULL), 0);
    ttf_writer_abandon(old);
    expect_no_beginning(f);
}

static void the_second_part_of_another_run_is_not_watched(void **state)
{
    const char *second;
    struct fixture *f = begin_with_second(*state, &second);
    struct ttf_writer *other =
        create_second("0a0b0c0d-0000-4000-8000-00000000000f", in(second, "grass"), 0);
    struct ttf_writer *first = small_create(ttf_io_posix(), in(*state, "data/grass"));

    for (int64_t i = 0; i < 9; i++) {
        pass(f, 10);
        assert_int_equal(small_slot(first, i), 0);
    }
    assert_int_equal(f->n, 0);
    ttf_writer_abandon(first);
    ttf_writer_abandon(other);
    free(f);
}

/* The first one's disk is gone: all that is known is that it went on. */
static void a_second_part_without_its_first_is_watched(void **state)
{
    const char *second;
    struct fixture *f = begin_with_second(*state, &second);
    struct ttf_writer *writer =
        create_second("0a0b0c0d-0000-4000-8000-00000000000f", in(second, "grass"), f->clock.now_ns);

    for (int64_t i = 0; i < 9; i++) {
        pass(f, 10);
        assert_int_equal(small_slot(writer, i), 0);
    }
    assert_int_equal(f->n, 0);
    ttf_writer_abandon(writer);
    free(f);
}

/* A dataset from elsewhere, or rot: its times are whatever they are, and none of them is in the past for being too large. */
static void times_beyond_all_time_are_no_alarm(void **state)
{
    static const struct {
        int64_t origin_ns, interval_ns;
    } ODD[] = {
        {INT64_MAX - 1, SECOND}, {5 * SECOND, INT64_MAX - 1}, {INT64_MAX - 1, INT64_MAX - 1}};

    for (size_t i = 0; i < sizeof ODD / sizeof *ODD; i++) {
        struct fixture *f = begin(*state);
        struct ttf_writer *writer =
            create(in(*state, "data/grass"), ODD[i].origin_ns, ODD[i].interval_ns);

        pass(f, 600);
        assert_int_equal(f->n, 0);
        ttf_writer_abandon(writer);
        assert_int_equal(run("rm -r %s/data %s/state", (const char *)*state, (const char *)*state),
                         0);
        free(f);
    }
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, folder_setup, folder_teardown)

/* The plan of `grass` has come to its end, and its file is what it was then. */
static struct fixture *begin_ended(const char *folder)
{
    struct fixture *f = begin(folder);
    struct ttf_writer *writer = small_create(ttf_io_posix(), in(folder, "data/grass"));
    char digest[65];

    f->says = "idle";
    assert_int_equal(small_slot(writer, 0), 0);
    pass(f, 3);
    assert_int_equal(ttf_writer_seal(writer, "count", digest, NULL), 0);
    ttf_writer_abandon(writer);
    pass(f, 300);
    assert_int_equal(f->n, 1);
    assert_true(told(f, 0, "ended", "has come to its end"));
    return f;
}

static void write_longer_plan(const struct fixture *f)
{
    write_text(f->config.plan, "interval: 10s\ncount: 90\n", 24);
    assert_int_equal(run("touch -d '+1 hour' %s", f->config.plan), 0);
}

/* In the folder of a capture that had ended. */
static struct ttf_writer *go_on(const char *folder)
{
    struct ttf_writer *writer = NULL;

    assert_int_equal(ttf_writer_open(ttf_io_posix(), in(folder, "data/grass"), &writer, NULL), 0);
    assert_int_equal(small_slot(writer, 1), 0);
    return writer;
}

static void a_plan_made_longer_behind_its_end_is_waited_for(void **state)
{
    struct fixture *f = begin_ended(*state);
    struct ttf_writer *writer;

    write_longer_plan(f);
    f->says = ""; /* its daemon does not come up */
    pass(f, 59);
    assert_int_equal(f->n, 1);
    pass(f, 3);
    assert_int_equal(f->n, 2);
    assert_true(told(f, 1, "not-begun", "has not gone on"));
    assert_true(f->watch.stopped);
    pass(f, 300);
    assert_int_equal(f->n, 2); /* once */
    start_watching(f);         /* the alerter begins anew */
    pass(f, 300);
    assert_int_equal(f->n, 1);
    assert_true(told(f, 0, "not-begun", "has not gone on"));
    writer = go_on(*state);
    pass(f, 1);
    assert_int_equal(f->n, 2);
    assert_true(told(f, 1, "going-on", "goes on"));
    assert_false(f->watch.stopped);
    ttf_writer_abandon(writer);
    free(f);
}

static void a_daemon_with_nothing_to_do_knows_that_the_end_was_one(void **state)
{
    struct fixture *f = begin_ended(*state);

    write_longer_plan(f); /* or with a word more of comment */
    pass(f, 300);
    assert_int_equal(f->n, 1);
    f->says = "";
    pass(f, 125);
    assert_int_equal(f->n, 2);
    assert_true(told(f, 1, "not-begun", "has not gone on"));
    f->says = "idle"; /* it came up, and there is nothing to do */
    pass(f, 62);
    assert_int_equal(f->n, 3);
    assert_true(told(f, 2, "ended", "has come to its end"));
    assert_false(f->watch.stopped);
    free(f);
}

static void a_daemon_that_tries_in_vain_has_something_to_do_behind_an_end(void **state)
{
    struct fixture *f = begin_ended(*state);

    f->says = ""; /* a dead one with a plan that is done misses nothing */
    pass(f, 300);
    assert_int_equal(f->n, 1);
    f->says = "retrying: the guardian is away";
    pass(f, 125);
    assert_int_equal(f->n, 2);
    assert_true(told(f, 1, "not-begun", "has not gone on"));
    assert_true(told(f, 1, "not-begun", "the box says: retrying: the guardian is away"));
    decided(f, ORDER_STOPPED, "");
    pass(f, 2);
    assert_false(f->watch.stopped); /* a person wants no more of it */
    free(f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(a_run_that_does_not_begin_is_told_with_why),
        TEST(nothing_that_nobody_wants_is_an_alarm),
        TEST(while_lamps_settle_before_the_first_slot_nobody_is_told),
        TEST(a_plan_that_waits_for_its_start_is_silent_and_late_behind_it),
        TEST(a_box_that_was_without_power_has_its_time_to_go_on),
        TEST(a_stop_by_a_person_is_told_as_that_once_and_is_no_alarm),
        TEST(a_program_that_was_told_to_end_is_no_persons_stop),
        TEST(orders_that_nobody_understands_are_an_alarm_until_something_runs),
        TEST(a_disk_that_goes_with_all_that_was_decided_is_an_alarm),
        TEST(a_run_that_goes_on_in_its_second_storage_has_not_stopped),
        TEST(a_run_of_another_ones_group_is_followed_into_its_second_storage),
        TEST(an_older_dataset_of_this_name_in_the_second_storage_hides_no_alarm),
        TEST(the_second_part_of_a_run_that_ended_hides_no_alarm),
        TEST(the_second_part_of_another_run_is_not_watched),
        TEST(a_second_part_without_its_first_is_watched),
        TEST(times_beyond_all_time_are_no_alarm),
        TEST(a_plan_made_longer_behind_its_end_is_waited_for),
        TEST(a_daemon_with_nothing_to_do_knows_that_the_end_was_one),
        TEST(a_daemon_that_tries_in_vain_has_something_to_do_behind_an_end),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
