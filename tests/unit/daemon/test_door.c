/* SPDX-License-Identifier: Apache-2.0 */
/* test_door.c: what is asked of the box: nobody waits behind a start that waits for devices, and every stop is answered. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include <errno.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "door.h"
#include "parts.h"

#define PLAN "interval: 1h\ncount: 4\nshot: {exposure: 10ms}\n"

struct fixture {
    struct daemon d;
    char folder[64];
    struct ttf_err first; /* what came of the first start */
    int r;
    bool ends; /* what runs does, as soon as a decision is on the disk */
    bool full; /* the disk takes none */
};

/* Whoever runs what was decided is another thread: it may be done before the one that decided goes on. */
static int on_write(void *ctx, const char *op, const char *path)
{
    struct fixture *f = ctx;

    (void)path;
    if (f->full)
        return -ENOSPC;
    if (f->ends && strcmp(op, "sync_dir") == 0)
        asks_end(f->d.asks);
    return 0;
}

static void begin(struct fixture *f)
{
    char path[128];

    memset(f, 0, sizeof *f);
    (void)snprintf(f->folder, sizeof f->folder, "/tmp/ttfbox-door.XXXXXX");
    f->d.io = ttf_io_faulty_create(ttf_io_posix(), on_write, f);
    f->d.clock = ttf_clock_real_create();
    if (!f->d.io || !f->d.clock || !mkdtemp(f->folder)) {
        fail_msg("no clock, or no folder");
        return;
    }
    (void)snprintf(f->d.config.state, sizeof f->d.config.state, "%s", f->folder);
    (void)snprintf(f->d.config.data, sizeof f->d.config.data, "%s", f->folder);
    (void)snprintf(path, sizeof path, "%s/plans", f->folder);
    assert_int_equal(ttf_io_mkdirs(f->d.io, path, NULL), 0);
    (void)snprintf(path, sizeof path, "%s/plans/week.yaml", f->folder);
    assert_int_equal(ttf_io_write_file(f->d.io, path, PLAN, sizeof PLAN - 1, NULL), 0);
    (void)pthread_mutex_init(&f->d.plans, NULL);
    (void)pthread_mutex_init(&f->d.starting, NULL);
    f->d.door.ops = &DOOR_OPS;
    f->d.wake = ttf_gate_create(f->d.clock);
    f->d.shadow = shadow_create();
    f->d.asks = asks_create(1);
    f->d.situation = situation_create(f->d.clock);
    f->d.workshop = workshop_create(f->d.clock, f->d.wake);
    assert_int_equal(orders_create(f->d.io, f->folder, "", "", &f->d.orders, NULL), 0);
    workshop_open(f->d.workshop, true); /* and nobody works there: the devices do not answer */
}

static void end(struct fixture *f)
{
    char path[128];

    orders_destroy(f->d.orders);
    asks_destroy(f->d.asks);
    situation_destroy(f->d.situation);
    ttf_io_faulty_destroy(f->d.io);
    workshop_destroy(f->d.workshop);
    shadow_destroy(f->d.shadow);
    ttf_gate_destroy(f->d.wake);
    ttf_clock_destroy(f->d.clock);
    (void)pthread_mutex_destroy(&f->d.plans);
    (void)pthread_mutex_destroy(&f->d.starting);
    (void)snprintf(path, sizeof path, "%s/plans/week.yaml", f->folder);
    (void)unlink(path);
    (void)snprintf(path, sizeof path, "%s/plans", f->folder);
    (void)rmdir(path);
    (void)snprintf(path, sizeof path, "%s/run.json", f->folder);
    (void)unlink(path);
    (void)snprintf(path, sizeof path, "%s/run.json.reserve", f->folder);
    (void)unlink(path);
    assert_int_equal(rmdir(f->folder), 0);
}

static int start(struct fixture *f, struct ttf_err *err)
{
    char *json = NULL;
    int r = f->d.door.ops->start(&f->d.door, "week", "", &json, err);

    free(json);
    return r;
}

static void *start_first(void *ctx)
{
    struct fixture *f = ctx;

    f->r = start(f, &f->first);
    return NULL;
}

static void a_start_beside_one_that_waits_for_devices_is_told_so_at_once(void **state)
{
    struct ttf_err err = {0};
    struct fixture f;
    pthread_t first;

    (void)state;
    begin(&f);
    assert_int_equal(pthread_create(&first, NULL, start_first, &f), 0);
    assert_int_equal(ttf_gate_wait(f.d.wake, TTF_NS_NEVER), 0); /* it has asked for the devices */
    assert_int_equal(start(&f, &err), -EBUSY);
    assert_non_null(strstr(err.what, "being started"));
    workshop_open(f.d.workshop, false);
    (void)pthread_join(first, NULL);
    assert_int_equal(f.r, -EAGAIN);
    assert_int_equal(start(&f, &err), -EAGAIN); /* it keeps its place no longer than it takes */
    end(&f);
}

static int ask_stop(struct fixture *f, char **ret_json, struct ttf_err *err)
{
    const struct ttf_http_ask stop = {.kind = TTF_HTTP_ASK_STOP};

    return f->d.door.ops->ask(&f->d.door, &stop, ret_json, err);
}

static void a_stop_is_answered_however_soon_what_ran_has_ended(void **state)
{
    struct ttf_err err = {0};
    struct fixture f;
    char *json = NULL;

    (void)state;
    begin(&f);
    assert_int_equal(orders_start(f.d.orders, "week", PLAN, "week", &err), 0);
    f.ends = true;
    assert_int_equal(ask_stop(&f, &json, &err), 0);
    f.ends = false;
    if (!json || !strstr(json, "\"answered\":true") || !strstr(json, "\"done\":true"))
        fail_msg("%s", json ? json : "nothing");
    free(json);
    end(&f);
}

static void a_stop_that_the_disk_did_not_take_is_none(void **state)
{
    struct ttf_err err = {0};
    struct ttf_json said;
    struct fixture f;
    char *json = NULL;

    (void)state;
    begin(&f);
    assert_int_equal(orders_start(f.d.orders, "week", PLAN, "week", &err), 0);
    f.full = true;
    assert_int_equal(ask_stop(&f, &json, &err), -ENOSPC);
    asks_end(f.d.asks);
    ttf_json_init(&said, false);
    assert_false(asks_answered(f.d.asks, &said));
    ttf_json_free(&said);
    end(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_start_beside_one_that_waits_for_devices_is_told_so_at_once),
        cmocka_unit_test(a_stop_is_answered_however_soon_what_ran_has_ended),
        cmocka_unit_test(a_stop_that_the_disk_did_not_take_is_none),
    };

    (void)alarm(100); /* what waits for ever fails */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
