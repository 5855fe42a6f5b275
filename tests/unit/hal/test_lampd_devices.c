/* SPDX-License-Identifier: Apache-2.0 */
/* test_lampd_devices.c: a guardian whose own devices misbehave: a switch that bounces, a deaf service manager. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <unistd.h>

#include "lampd_fixture.h"
#include "ttf/base/time.h"

#define DOOR 2 /* the fixture's */

/* Wires of the test's own: what the guardian is told of the door need not be what it finds there. */
struct bank {
    struct ttf_lines base;
    atomic_int edges; /* closing ones still to be told; -1: without end */
    atomic_int rest;  /* where the door is */
};

static int bank_set(struct ttf_lines *base, unsigned i, unsigned permille)
{
    (void)base, (void)i, (void)permille;
    return 0;
}

static int bank_get(struct ttf_lines *base, unsigned i)
{
    return i == DOOR ? atomic_load(&((struct bank *)base)->rest) : 0;
}

static int bank_fd(const struct ttf_lines *base)
{
    (void)base;
    return -1;
}

static int bank_event(struct ttf_lines *base, struct ttf_line_event *ret)
{
    struct bank *bank = (struct bank *)base;
    int left = atomic_load(&bank->edges);

    if (left == 0)
        return 0;
    if (left > 0)
        atomic_store(&bank->edges, left - 1);
    *ret = (struct ttf_line_event){.i = DOOR};
    return 1;
}

static int bank_reopen(struct ttf_lines *base, struct ttf_err *err)
{
    (void)base, (void)err;
    return 0;
}

static void bank_destroy(struct ttf_lines *base)
{
    (void)base;
}

static const struct ttf_lines_ops BANK_OPS = {.name = "test",
                                              .set = bank_set,
                                              .get = bank_get,
                                              .fd = bank_fd,
                                              .event = bank_event,
                                              .reopen = bank_reopen,
                                              .destroy = bank_destroy};

/* Started with the door closed. */
static struct lampd_fixture *guarded_bank(struct bank *bank, void **state)
{
    struct lampd_fixture *f = lampd_fixture_make();

    *state = f;
    bank->base = *f->lines;
    bank->base.ops = &BANK_OPS;
    ttf_lines_destroy(f->lines);
    f->lines = &bank->base;
    lampd_fixture_start(f);
    return f;
}

static void a_door_whose_switch_bounced_is_where_it_came_to_rest(void **state)
{
    static struct bank bank;
    struct lampd_fixture *f = guarded_bank(&bank, state);
    struct ttf_lamps *lamps = lampd_fixture_client(f);

    assert_int_equal(ttf_lamps_lampd_door(lamps, NULL), 0);
    /* Of opening, the kernel had room for the first edges alone, and the last of them closed it. */
    atomic_store(&bank.rest, 1);
    atomic_store(&bank.edges, 3);
    while (atomic_load(&bank.edges) > 0)
        (void)ttf_clock_wait_until(f->clock, ttf_clock_now_ns(f->clock) + TTF_NS_PER_MS);
    assert_int_equal(ttf_lamps_lampd_door(lamps, NULL), 1);
    ttf_lamps_destroy(lamps);
}

static void edges_without_end_do_not_keep_the_guardian_from_its_clients(void **state)
{
    static struct bank bank;
    struct lampd_fixture *f = guarded_bank(&bank, state);
    struct ttf_lamps *lamps = lampd_fixture_client(f);

    (void)alarm(30); /* a guardian that never comes round again would not end either */
    atomic_store(&bank.edges, -1);
    for (unsigned i = 0; i < 3; i++)
        assert_int_equal(ttf_lamps_lampd_door(lamps, NULL), 0);
    ttf_lamps_destroy(lamps);
    lampd_fixture_stop(f);
    (void)alarm(0);
}

/* A service manager that does not take the third sign of life. */
struct manager {
    struct ttf_watchdog base;
    unsigned fed;
    volatile int stop;
};

static int manager_arm(struct ttf_watchdog *base, int64_t timeout_ns)
{
    (void)base, (void)timeout_ns;
    return 0;
}

static int manager_feed(struct ttf_watchdog *base)
{
    struct manager *manager = (struct manager *)base;

    manager->fed++;
    if (manager->fed == 6)
        manager->stop = 1;
    return manager->fed == 3 ? -ECONNREFUSED : 0;
}

static void manager_nothing(struct ttf_watchdog *base)
{
    (void)base;
}

static void a_sign_of_life_that_was_not_taken_is_not_the_last(void **state)
{
    static const struct ttf_watchdog_ops OPS = {.name = "test",
                                                .arm = manager_arm,
                                                .feed = manager_feed,
                                                .disarm = manager_nothing,
                                                .destroy = manager_nothing};
    struct lampd_fixture *f = lampd_fixture_make();
    struct manager manager = {.base.ops = &OPS};
    const struct ttf_lampd_config config = {.socket = f->socket,
                                            .n = LAMPD_LAMPS,
                                            .info = f->info,
                                            .lines = f->lines,
                                            .door = DOOR,
                                            .clock = f->clock,
                                            .watchdog = &manager.base,
                                            .watchdog_ns = TTF_NS_PER_S};
    struct ttf_lampd *lampd = NULL;

    *state = f;
    assert_int_equal(ttf_lampd_create(&config, &lampd, NULL), 0);
    (void)alarm(30); /* who is fed no more does not end this */
    assert_int_equal(ttf_lampd_run(lampd, &manager.stop), 0);
    (void)alarm(0);
    assert_int_equal(manager.fed, 6);
    ttf_lampd_destroy(lampd);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_door_whose_switch_bounced_is_where_it_came_to_rest,
                                  lampd_teardown),
        cmocka_unit_test_teardown(edges_without_end_do_not_keep_the_guardian_from_its_clients,
                                  lampd_teardown),
        cmocka_unit_test_teardown(a_sign_of_life_that_was_not_taken_is_not_the_last,
                                  lampd_teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
