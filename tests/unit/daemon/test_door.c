/* SPDX-License-Identifier: Apache-2.0 */
/* test_door.c: what is asked of the box: nobody waits behind a start that waits for devices. */
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
};

static void begin(struct fixture *f)
{
    char path[128];

    memset(f, 0, sizeof *f);
    (void)snprintf(f->folder, sizeof f->folder, "/tmp/ttfbox-door.XXXXXX");
    f->d.io = ttf_io_posix();
    f->d.clock = ttf_clock_real_create();
    if (!f->d.clock || !mkdtemp(f->folder)) {
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
    f->d.workshop = workshop_create(f->d.clock, f->d.wake);
    assert_int_equal(orders_create(f->d.io, f->folder, "", "", &f->d.orders, NULL), 0);
    workshop_open(f->d.workshop, true); /* and nobody works there: the devices do not answer */
}

static void end(struct fixture *f)
{
    char path[128];

    orders_destroy(f->d.orders);
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

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_start_beside_one_that_waits_for_devices_is_told_so_at_once),
    };

    (void)alarm(100); /* what waits for ever fails */
    return cmocka_run_group_tests(tests, NULL, NULL);
}
