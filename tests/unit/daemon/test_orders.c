/* SPDX-License-Identifier: Apache-2.0 */
/* test_orders.c: what a person decided holds over boots, and for the configuration that it was decided under. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "orders.h"

/* The configuration that most tests have. */
#define PLAN    "plan.yaml"
#define DATASET "data/grass"

static int make_folder(void **state)
{
    static char path[] = "/tmp/ttfbox-orders.XXXXXX";

    memcpy(path + sizeof path - 7, "XXXXXX", 7);
    *state = mkdtemp(path);
    return *state ? 0 : -1;
}

static int remove_folder(void **state)
{
    char path[700]; /* a test's own folder[600] and a name */

    (void)snprintf(path, sizeof path, "%s/run.json", (const char *)*state);
    (void)unlink(path);
    (void)snprintf(path, sizeof path, "%s/run.json.reserve", (const char *)*state);
    (void)unlink(path);
    return rmdir(*state);
}

/* A boot: what holds then. */
static struct order boot(const char *folder, const char *plan, const char *dataset,
                         struct orders **ret)
{
    struct ttf_err err = {0};
    struct order order = {0};

    if (orders_create(ttf_io_posix(), folder, plan, dataset, ret, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_int_equal(orders_get(*ret, &order), 0);
    return order;
}

static void expect(const char *folder, const char *plan, const char *dataset,
                   enum order_state state, const char *wanted)
{
    struct orders *orders = NULL;
    struct order order = boot(folder, plan, dataset, &orders);

    assert_int_equal(order.state, state);
    assert_string_equal(order.dataset, wanted);
    order_free(&order);
    orders_destroy(orders);
}

static void the_configuration_s_run_begins_by_itself(void **state)
{
    expect(*state, PLAN, DATASET, ORDER_RUN, "grass");
    expect(*state, "", "", ORDER_NONE, "");
}

static void what_the_configuration_names_runs_once_a_boot(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    struct order order = boot(*state, PLAN, DATASET, &orders);
    int64_t generation = order.generation;

    order_free(&order);
    assert_int_equal(orders_take(orders, &order, &err), 0);
    assert_int_equal(order.state, ORDER_RUN);
    assert_int_equal(orders_ended(orders, generation, ORDER_DONE, &err), 0);
    for (int look = 0; look < 2; look++) { /* there is still no file: that says nothing new */
        assert_false(orders_read_again(orders));
        order_free(&order);
        assert_int_equal(orders_take(orders, &order, &err), 0);
        assert_int_equal(order.state, ORDER_DONE);
    }
    order_free(&order);
    orders_destroy(orders);
    expect(*state, PLAN, DATASET, ORDER_RUN,
           "grass"); /* the next boot looks whether the plan became longer */
}

static void a_power_cut_behind_putting_aside_begins_nothing(void **state)
{
    char path[600], aside[640];
    FILE *out;

    (void)snprintf(path, sizeof path, "%s/run.json", (const char *)*state);
    (void)snprintf(aside, sizeof aside, "%s.unreadable", path);
    out = fopen(aside, "w");
    if (!out)
        fail_msg("no file");
    else
        assert_int_equal(fclose(out), 0);
    expect(*state, PLAN, DATASET, ORDER_STOPPED, "grass");
    expect(*state, PLAN, DATASET, ORDER_STOPPED, "grass");
    assert_int_equal(unlink(aside), 0);
}

static void a_run_that_was_asked_for_is_gone_on_with_as_it_was(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    struct order order = boot(*state, "", "", &orders);

    order_free(&order);
    assert_int_equal(orders_start(orders, "week", "interval: 1h\n", "moss", &err), 0);
    assert_int_equal(orders_start(orders, "week", "interval: 1h\n", "fern", &err), -EBUSY);
    orders_destroy(orders);
    order = boot(*state, PLAN, DATASET, &orders); /* another configuration, too */
    assert_int_equal(order.state, ORDER_RUN);
    assert_true(order.by_request);
    assert_string_equal(order.dataset, "moss");
    assert_string_equal(order.plan, "week");
    assert_string_equal(order.yaml, "interval: 1h\n");
    order_free(&order);
    assert_int_equal(orders_ended(orders, orders_generation(orders), ORDER_DONE, &err), 0);
    orders_destroy(orders);
    expect(*state, PLAN, DATASET, ORDER_DONE, "moss");
}

static void a_stop_holds_over_boots_until_it_is_taken_back(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    struct order order = boot(*state, PLAN, DATASET, &orders);

    order_free(&order);
    assert_int_equal(orders_stop(orders, &err), 0);
    assert_int_equal(orders_stop(orders, &err), -ENOENT);
    orders_destroy(orders);
    order = boot(*state, PLAN, DATASET, &orders);
    assert_int_equal(order.state, ORDER_STOPPED);
    order_free(&order);
    assert_int_equal(orders_go_on(orders, &err), 0);
    assert_int_equal(orders_go_on(orders, &err), -ENOENT);
    orders_destroy(orders);
    expect(*state, PLAN, DATASET, ORDER_RUN, "grass");
}

static void a_stop_does_not_keep_back_another_configuration(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    struct order order = boot(*state, PLAN, DATASET, &orders);

    order_free(&order);
    assert_int_equal(orders_stop(orders, &err), 0);
    orders_destroy(orders);
    expect(*state, PLAN, "data/moss", ORDER_RUN, "moss");
}

static void a_decision_that_the_disk_does_not_take_changes_nothing(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    struct order order;

    (void)state;
    order = boot("/proc/nowhere", PLAN, DATASET, &orders);
    order_free(&order);
    assert_true(orders_stop(orders, &err) < 0);
    assert_int_equal(orders_get(orders, &order), 0);
    assert_int_equal(order.state, ORDER_RUN);
    order_free(&order);
    orders_destroy(orders);
}

static void the_end_of_a_run_does_not_stop_the_one_that_was_asked_for_meanwhile(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    struct order first = boot(*state, "", "", &orders);
    int64_t under_way;

    order_free(&first);
    assert_int_equal(orders_start(orders, "week", "interval: 1h\n", "moss", &err), 0);
    under_way = orders_generation(orders);
    assert_int_equal(orders_stop(orders, &err), 0);
    assert_int_equal(orders_start(orders, "week", "interval: 1h\n", "fern", &err), 0);
    assert_int_equal(orders_ended(orders, under_way, ORDER_STOPPED, &err), 0);
    assert_int_equal(orders_ended(orders, under_way, ORDER_DONE, &err), 0);
    orders_destroy(orders);
    expect(*state, "", "", ORDER_RUN, "fern");
}

static void a_stop_ends_what_ran_and_never_what_is_taken_up_after_it(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    struct order order = boot(*state, PLAN, DATASET, &orders);
    volatile int flag = 0;

    order_free(&order);
    orders_flag(orders, &flag, 2);
    assert_int_equal(orders_take(orders, &order, &err), 0);
    order_free(&order);
    assert_int_equal(orders_stop(orders, &err), 0);
    assert_int_equal(flag, 2);
    assert_int_equal(orders_go_on(orders, &err), 0);
    assert_int_equal(flag, 2); /* the run that was stopped has not ended yet */
    assert_int_equal(orders_take(orders, &order, &err), 0);
    assert_int_equal(order.state, ORDER_RUN);
    assert_int_equal(flag, 0);
    order_free(&order);
    flag = 1; /* the program is to end: that stays */
    assert_int_equal(orders_stop(orders, &err), 0);
    assert_int_equal(orders_take(orders, &order, &err), 0);
    assert_int_equal(flag, 1);
    order_free(&order);
    orders_destroy(orders);
}

static void the_button_holds_also_where_the_disk_does_not_take_it(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    char folder[600], path[700];
    struct order order;
    FILE *file;

    /* A file where the folder is to be: the disk takes nothing until it goes. */
    (void)snprintf(folder, sizeof folder, "%s/state", (const char *)*state);
    (void)snprintf(path, sizeof path, "%s/run.json", folder);
    order = boot(folder, PLAN, DATASET, &orders);
    file = fopen(folder, "we");
    if (!file) {
        fail();
        return;
    }
    assert_int_equal(fclose(file), 0);
    assert_true(orders_ended(orders, order.generation, ORDER_STOPPED, &err) < 0);
    order_free(&order);
    assert_int_equal(orders_get(orders, &order), 0);
    assert_int_equal(order.state, ORDER_STOPPED);
    order_free(&order);
    assert_true(orders_save(orders, &err) < 0);
    assert_int_equal(unlink(folder), 0);
    assert_int_equal(orders_save(orders, &err), 0);
    orders_destroy(orders);
    expect(folder, PLAN, DATASET, ORDER_STOPPED, "grass");
    assert_int_equal(remove_folder((void **)&(char *){folder}), 0);
}

static void put(const char *folder, const char *text)
{
    char path[700];
    FILE *file;

    (void)snprintf(path, sizeof path, "%s/run.json", folder);
    file = fopen(path, "we");
    if (!file) {
        fail_msg("no %s", path);
        return;
    }
    (void)fputs(text, file);
    assert_int_equal(fclose(file), 0);
}

static void
a_file_that_says_nothing_is_put_aside_and_nothing_runs_until_somebody_says_so(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    struct order order;
    char aside[700];

    (void)snprintf(aside, sizeof aside, "%s/run.json.unreadable", (const char *)*state);
    put(*state, "{\"state\":\"walking\"}");
    order = boot(*state, PLAN, DATASET, &orders);
    assert_int_equal(order.state, ORDER_STOPPED);
    assert_non_null(strstr(order.why, aside));
    order_free(&order);
    orders_destroy(orders);
    assert_int_equal(access(aside, R_OK), 0);
    /* So also at the next boot, which finds nothing unreadable. */
    order = boot(*state, PLAN, DATASET, &orders);
    assert_int_equal(order.state, ORDER_STOPPED);
    assert_non_null(strstr(order.why, aside));
    order_free(&order);
    assert_int_equal(orders_go_on(orders, &err), 0);
    orders_destroy(orders);
    expect(*state, PLAN, DATASET, ORDER_RUN, "grass");
    assert_int_equal(unlink(aside), 0);
}

static void a_box_that_has_nothing_configured_does_not_go_on_with_nothing(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    struct order order;
    char aside[700];

    (void)snprintf(aside, sizeof aside, "%s/run.json.unreadable", (const char *)*state);
    put(*state, "");
    order = boot(*state, "", "", &orders);
    assert_int_equal(order.state, ORDER_STOPPED);
    order_free(&order);
    assert_int_equal(orders_go_on(orders, &err), -ENOENT);
    assert_int_equal(orders_start(orders, "week", "interval: 1h\n", "moss", &err), 0);
    orders_destroy(orders);
    expect(*state, "", "", ORDER_RUN, "moss");
    assert_int_equal(unlink(aside), 0);
}

/* A disk that gives an error for what is read: files cannot be opened. */
struct bad_disk {
    struct ttf_io io; /* first */
    struct ttf_io_ops ops;
    bool bad;
};

static int bad_open(struct ttf_io *io, const char *path, enum ttf_io_mode mode)
{
    return ((struct bad_disk *)io)->bad ? -EIO : ttf_io_posix()->ops->open(io, path, mode);
}

static void a_disk_that_cannot_be_read_is_tried_again_and_nothing_is_decided_by_guess(void **state)
{
    struct bad_disk disk = {.ops = *ttf_io_posix()->ops};
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    struct order order;

    disk.ops.open = bad_open;
    disk.io.ops = &disk.ops;
    order = boot(*state, PLAN, DATASET, &orders);
    order_free(&order);
    assert_int_equal(orders_stop(orders, &err), 0);
    orders_destroy(orders);
    disk.bad = true;
    assert_int_equal(orders_create(&disk.io, *state, PLAN, DATASET, &orders, &err), 0);
    assert_int_equal(orders_take(orders, &order, &err), -EIO);
    assert_int_equal(order.generation, orders_generation(orders)); /* by which it waits */
    assert_int_equal(orders_stop(orders, &err), -EAGAIN);
    assert_false(orders_read_again(orders));
    disk.bad = false;
    assert_true(orders_read_again(orders));
    assert_int_equal(orders_take(orders, &order, &err), 0);
    assert_int_equal(order.state, ORDER_STOPPED);
    order_free(&order);
    orders_destroy(orders);
}

static void a_disk_that_comes_late_says_what_holds_and_ends_what_began_without_it(void **state)
{
    struct orders *orders = NULL;
    struct ttf_err err = {0};
    volatile int flag = 0;
    char folder[600], path[700];
    struct order order;

    (void)snprintf(folder, sizeof folder, "%s/late", (const char *)*state);
    (void)snprintf(path, sizeof path, "%s/run.json", folder);
    order = boot(folder, PLAN, DATASET, &orders);
    orders_flag(orders, &flag, 2);
    assert_int_equal(order.state, ORDER_RUN);
    order_free(&order);
    assert_false(orders_read_again(orders));
    assert_int_equal(mkdir(folder, 0755), 0);
    put(folder, "{\"state\":\"stopped\",\"dataset\":\"grass\",\"configuration\":\"" PLAN
                " into " DATASET "\"}");
    assert_true(orders_read_again(orders));
    assert_int_equal(flag, 2);
    assert_int_equal(orders_take(orders, &order, &err), 0);
    assert_int_equal(order.state, ORDER_STOPPED);
    order_free(&order);
    assert_false(orders_read_again(orders));
    orders_destroy(orders);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmdir(folder), 0);
}

/* A disk that is full: it has the room of the reserve, once that is given up, or none at all. */
struct full_disk {
    char reserve[640];
    bool full, quite; /* quite full: not even that helps */
    bool cut;         /* power goes before the new file is in the old one's place */
};

static int no_room(void *ctx, const char *op, const char *path)
{
    const struct full_disk *disk = ctx;

    (void)path;
    if (strcmp(op, "rename") == 0 && disk->cut)
        return EIO;
    if (strcmp(op, "open") != 0 && strcmp(op, "append") != 0)
        return 0;
    return disk->quite || (disk->full && access(disk->reserve, F_OK) == 0) ? ENOSPC : 0;
}

static void room_left(void *ctx, const char *path, struct ttf_io_space *space)
{
    const struct full_disk *disk = ctx;

    (void)path;
    if (disk->full)
        space->free_bytes = 0;
}

static struct ttf_io *fill_up(struct full_disk *disk, const char *folder, struct orders **ret)
{
    struct ttf_io *io = ttf_io_faulty_create(ttf_io_posix(), no_room, disk);
    struct ttf_err err = {0};

    *disk = (struct full_disk){0};
    (void)snprintf(disk->reserve, sizeof disk->reserve, "%s/run.json.reserve", folder);
    assert_non_null(io);
    ttf_io_faulty_space(io, room_left);
    assert_int_equal(orders_create(io, folder, PLAN, DATASET, ret, &err), 0);
    assert_int_equal(orders_save(*ret, &err), 0);
    assert_int_equal(access(disk->reserve, F_OK), 0); /* also where nobody has decided anything */
    disk->full = true;
    return io;
}

static void a_full_disk_takes_a_stop_and_keeps_room_for_the_next_one(void **state)
{
    struct orders *orders = NULL;
    struct full_disk disk;
    struct ttf_io *io = fill_up(&disk, *state, &orders);
    struct ttf_err err = {0};

    assert_int_equal(orders_stop(orders, &err), 0);
    expect(*state, PLAN, DATASET, ORDER_STOPPED, "grass");
    assert_int_equal(access(disk.reserve, F_OK), -1); /* nothing that is not there is kept */
    disk.quite = true;
    assert_int_equal(orders_go_on(orders, &err), -ENOSPC);
    expect(*state, PLAN, DATASET, ORDER_STOPPED, "grass");
    disk.full = disk.quite = false;
    assert_int_equal(orders_save(orders, &err), 0);
    disk.full = true;
    assert_int_equal(access(disk.reserve, F_OK), 0);
    assert_int_equal(orders_go_on(orders, &err), 0);
    expect(*state, PLAN, DATASET, ORDER_RUN, "grass");
    orders_destroy(orders);
    ttf_io_faulty_destroy(io);
}

static void a_power_cut_behind_the_reserve_leaves_what_was_decided_before(void **state)
{
    struct orders *orders = NULL;
    struct full_disk disk;
    struct ttf_io *io = fill_up(&disk, *state, &orders);
    struct ttf_err err = {0};

    assert_int_equal(orders_stop(orders, &err), 0);
    disk.full = false;
    assert_int_equal(orders_save(orders, &err), 0);
    disk.full = disk.cut = true;
    assert_true(orders_go_on(orders, &err) < 0);
    assert_int_equal(access(disk.reserve, F_OK), -1);
    expect(*state, PLAN, DATASET, ORDER_STOPPED, "grass");
    orders_destroy(orders);
    ttf_io_faulty_destroy(io);
}

#define WITH_FOLDER(test) cmocka_unit_test_setup_teardown(test, make_folder, remove_folder)

int main(void)
{
    const struct CMUnitTest tests[] = {
        WITH_FOLDER(the_configuration_s_run_begins_by_itself),
        WITH_FOLDER(what_the_configuration_names_runs_once_a_boot),
        WITH_FOLDER(a_power_cut_behind_putting_aside_begins_nothing),
        WITH_FOLDER(a_run_that_was_asked_for_is_gone_on_with_as_it_was),
        WITH_FOLDER(a_stop_holds_over_boots_until_it_is_taken_back),
        WITH_FOLDER(a_stop_does_not_keep_back_another_configuration),
        cmocka_unit_test(a_decision_that_the_disk_does_not_take_changes_nothing),
        WITH_FOLDER(the_end_of_a_run_does_not_stop_the_one_that_was_asked_for_meanwhile),
        WITH_FOLDER(a_stop_ends_what_ran_and_never_what_is_taken_up_after_it),
        WITH_FOLDER(the_button_holds_also_where_the_disk_does_not_take_it),
        WITH_FOLDER(a_file_that_says_nothing_is_put_aside_and_nothing_runs_until_somebody_says_so),
        WITH_FOLDER(a_box_that_has_nothing_configured_does_not_go_on_with_nothing),
        WITH_FOLDER(a_disk_that_cannot_be_read_is_tried_again_and_nothing_is_decided_by_guess),
        WITH_FOLDER(a_disk_that_comes_late_says_what_holds_and_ends_what_began_without_it),
        WITH_FOLDER(a_full_disk_takes_a_stop_and_keeps_room_for_the_next_one),
        WITH_FOLDER(a_power_cut_behind_the_reserve_leaves_what_was_decided_before),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
