/* SPDX-License-Identifier: Apache-2.0 */
/* test_lampd_devices.c: a guardian whose own devices misbehave: a switch that bounces, a deaf service manager. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <unistd.h>

#include "lampd_fixture.h"
#include "pwm_tree.h"
#include "ttf/base/time.h"
#include "ttf/hal/pwm.h"

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
    lampd_fixture_take_lines(f, &bank->base);
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
    lampd_fixture_part(f, lamps);
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
    lampd_fixture_part(f, lamps);
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
    assert_int_equal(ttf_lampd_destroy(lampd), 0);
}

/* ---- more than one chip ---- */

static struct ttf_lines *one_wire(const char *path, const struct ttf_line_spec *spec)
{
    struct ttf_lines *lines = NULL;

    assert_int_equal(ttf_lines_file_create(path, spec, 1, &lines, NULL), 0);
    return lines;
}

/* Each wire on a chip, a file, of its own: NAME.0 to NAME.2. */
static struct lampd_fixture *guarded_chips(void **state, char paths[3][112])
{
    struct lampd_fixture *f = lampd_fixture_make();
    struct ttf_line_spec specs[3];
    struct ttf_lines *banks[3], *joined = NULL;

    *state = f;
    for (unsigned i = 0; i < 3; i++) {
        specs[i] = *ttf_lines_spec(f->lines, i);
        (void)snprintf(paths[i], 112, "%s.%u", f->wires, i);
        banks[i] = one_wire(paths[i], &specs[i]);
    }
    assert_int_equal(ttf_lines_joined_create(specs, 3, banks, 3, &joined, NULL), 0);
    lampd_fixture_take_lines(f, joined);
    lampd_fixture_start(f);
    return f;
}

static char level_in(const char *path)
{
    int file = open(path, O_RDONLY | O_CLOEXEC);
    char level = '?';

    if (file >= 0 && read(file, &level, 1) != 1)
        level = '?';
    if (file >= 0)
        (void)close(file);
    return level;
}

static void wait_for_level(const struct lampd_fixture *f, const char *path, char level)
{
    int64_t last_ns = ttf_clock_now_ns(f->clock) + 20 * TTF_NS_PER_S;

    while (level_in(path) != level) {
        if (ttf_clock_now_ns(f->clock) > last_ns)
            fail_msg("%s is '%c'", path, level_in(path));
        (void)ttf_clock_wait_until(f->clock, ttf_clock_now_ns(f->clock) + TTF_NS_PER_MS);
    }
}

/* Nobody commands anything meanwhile: the guardian finds out by itself. */
static void a_chip_that_vanishes_takes_the_light_of_all_others_with_it(void **state)
{
    char paths[3][112];
    struct lampd_fixture *f = guarded_chips(state, paths);
    struct ttf_lamps *lamps = lampd_fixture_client(f);
    unsigned tries = 0;
    int r;

    assert_int_equal(ttf_lamps_acquire(lamps, ttf_clock_now_ns(f->clock) + TTF_NS_PER_H, NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 1, 1000, NULL), 0);
    assert_int_equal(level_in(paths[1]), '0'); /* active low: lit */
    assert_int_equal(unlink(paths[0]), 0);
    wait_for_level(f, paths[1], '1');
    assert_int_equal(ttf_lamps_set(lamps, 1, 1000, NULL), -ENODEV);
    (void)close(open(paths[0], O_WRONLY | O_CREAT | O_CLOEXEC, 0644)); /* it is back */
    wait_for_level(f, paths[0], '0');
    assert_int_equal(level_in(paths[1]), '1'); /* nothing lights by itself */
    while ((r = ttf_lamps_set(lamps, 1, 1000, NULL)) == -ENODEV && tries++ < 2000)
        (void)ttf_clock_wait_until(f->clock, ttf_clock_now_ns(f->clock) + 10 * TTF_NS_PER_MS);
    assert_int_equal(r, 0);
    assert_int_equal(level_in(paths[1]), '0');
    lampd_fixture_part(f, lamps);
    for (unsigned i = 0; i < 3; i++)
        (void)unlink(paths[i]);
}

/* ---- levels ---- */

static void levels_reach_a_channel_and_its_light_ends_with_the_client(void **state)
{
    static const struct ttf_line_spec LAMPS[] = {
        {.label = "left", .chip = "pwmchip0", .line = "1", .period_ns = 50000},
        {.label = "right", .chip = "pwmchip0", .line = "0", .period_ns = 50000}};
    struct lampd_fixture *f = lampd_fixture_make();
    struct ttf_line_spec specs[3] = {LAMPS[0], LAMPS[1], *ttf_lines_spec(f->lines, DOOR)};
    struct ttf_lines *banks[2], *joined = NULL;
    struct pwm_tree tree;
    struct ttf_lamps *lamps;

    *state = f;
    pwm_tree_make(&tree);
    pwm_tree_export(&tree, 0);
    pwm_tree_export(&tree, 1);
    f->info[0].kind = f->info[1].kind = TTF_LAMP_PWM;
    f->info[1].pwm_period_ns = 50000;
    assert_int_equal(ttf_lines_pwm_create(tree.root, LAMPS, 2, &banks[0], NULL), 0);
    banks[1] = one_wire(f->wires, &specs[2]);
    assert_int_equal(ttf_lines_joined_create(specs, 3, banks, 2, &joined, NULL), 0);
    lampd_fixture_take_lines(f, joined);
    lampd_fixture_start(f);
    lamps = lampd_fixture_client(f);
    assert_int_equal(ttf_lamps_info(lamps, 1)->pwm_period_ns, 50000);
    assert_int_equal(ttf_lamps_acquire(lamps, ttf_clock_now_ns(f->clock) + TTF_NS_PER_H, NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 301, NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 1, 1000, NULL), 0);
    assert_int_equal(pwm_tree_number(&tree, "pwm1/duty_cycle"), 15050);
    assert_int_equal(pwm_tree_number(&tree, "pwm0/duty_cycle"), 50000);
    lampd_fixture_part(f, lamps);
    for (unsigned n = 0; n < 20000 && pwm_tree_number(&tree, "pwm1/enable") != 0; n++)
        (void)ttf_clock_wait_until(f->clock, ttf_clock_now_ns(f->clock) + TTF_NS_PER_MS);
    assert_int_equal(pwm_tree_number(&tree, "pwm1/enable"), 0);
    lampd_fixture_stop(f);
    pwm_tree_free(&tree);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(a_chip_that_vanishes_takes_the_light_of_all_others_with_it,
                                  lampd_teardown),
        cmocka_unit_test_teardown(levels_reach_a_channel_and_its_light_ends_with_the_client,
                                  lampd_teardown),
        cmocka_unit_test_teardown(a_door_whose_switch_bounced_is_where_it_came_to_rest,
                                  lampd_teardown),
        cmocka_unit_test_teardown(edges_without_end_do_not_keep_the_guardian_from_its_clients,
                                  lampd_teardown),
        cmocka_unit_test_teardown(a_sign_of_life_that_was_not_taken_is_not_the_last,
                                  lampd_teardown),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
