/* SPDX-License-Identifier: Apache-2.0 */
#include "lampd_fixture.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "ttf/base/time.h"

static int heat_read(struct ttf_sensors *base, struct ttf_reading ret[TTF_SENSORS_MAX],
                     struct ttf_err *err)
{
    struct test_heat *heat = (struct test_heat *)base;

    (void)err;
    atomic_store(&heat->asked, true);
    while (atomic_load(&heat->hangs))
        (void)ttf_clock_wait_until(heat->clock, ttf_clock_now_ns(heat->clock) + TTF_NS_PER_MS);
    memset(&ret[0], 0, sizeof(ret[0]));
    snprintf(ret[0].name, sizeof(ret[0].name), "box-temp");
    ret[0].kind = TTF_SENSOR_TEMP_MDEGC;
    ret[0].ok = !atomic_load(&heat->silent);
    ret[0].value = atomic_load(&heat->temp_mdegc);
    ret[0].at_ns = ttf_clock_now_ns(heat->clock) - atomic_load(&heat->age_ns);
    atomic_fetch_add(&heat->n, 1);
    return 1;
}

static void heat_destroy(struct ttf_sensors *base)
{
    (void)base;
}

static const struct ttf_sensors_ops HEAT_OPS = {
    .name = "test", .read = heat_read, .destroy = heat_destroy};

static void make_lines(struct lampd_fixture *f)
{
    struct ttf_line_spec specs[3] = {{.label = "left", .line = "0"},
                                     {.label = "right", .line = "1", .active_low = true},
                                     {.label = "door", .line = "2", .input = true}};
    struct ttf_err err = {0};

    if (ttf_lines_file_create(f->wires, specs, 3, &f->lines, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
}

struct lampd_fixture *lampd_fixture_make(void)
{
    struct lampd_fixture *f = calloc(1, sizeof(*f));

    assert_non_null(f);
    snprintf(f->folder, sizeof(f->folder), "/tmp/ttf-lampd.XXXXXX");
    assert_non_null(mkdtemp(f->folder));
    snprintf(f->socket, sizeof(f->socket), "%s/socket", f->folder);
    snprintf(f->wires, sizeof(f->wires), "%s/wires", f->folder);
    f->clock = ttf_clock_real_create();
    assert_non_null(f->clock);
    f->heat.base.ops = &HEAT_OPS;
    f->heat.clock = f->clock;
    f->heat.temp_mdegc = 25000;
    for (unsigned i = 0; i < LAMPD_LAMPS; i++) {
        f->info[i] = (struct ttf_lamp_info){.kind = TTF_LAMP_SWITCH, .max_duty_permille = 1000};
        snprintf(f->info[i].name, sizeof(f->info[i].name), "%s", i ? "right" : "left");
    }
    make_lines(f);
    return f;
}

void lampd_fixture_take_lines(struct lampd_fixture *f, struct ttf_lines *lines)
{
    ttf_lines_destroy(f->lines);
    f->lines = lines;
}

static void *guard(void *arg)
{
    struct lampd_fixture *f = arg;

    (void)ttf_lampd_run(f->lampd, &f->stop);
    return NULL;
}

void lampd_fixture_start(struct lampd_fixture *f)
{
    const struct ttf_lampd_config config = {
        .socket = f->socket,
        .n = LAMPD_LAMPS,
        .info = f->info,
        .lines = f->lines,
        .door = 2,
        .clock = f->clock,
        .sensors = &f->heat.base,
    };
    struct ttf_err err = {0};

    if (ttf_lampd_create(&config, &f->lampd, &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    f->stop = 0;
    assert_int_equal(pthread_create(&f->thread, NULL, guard, f), 0);
    f->running = true;
}

void lampd_fixture_stop(struct lampd_fixture *f)
{
    if (!f->running)
        return;
    __atomic_store_n(&f->stop, 1, __ATOMIC_RELAXED);
    pthread_join(f->thread, NULL);
    f->running = false;
    atomic_store(&f->heat.hangs, false);
    while (ttf_lampd_destroy(f->lampd) < 0)
        ; /* nothing hangs: the machine is busy */
}

void lampd_fixture_free(struct lampd_fixture *f)
{
    for (unsigned i = 0; i < LAMPD_CLIENTS; i++)
        ttf_lamps_destroy(f->clients[i]); /* its thread waits by the clock */
    lampd_fixture_stop(f);
    ttf_lines_destroy(f->lines);
    ttf_clock_destroy(f->clock);
    (void)unlink(f->wires);
    (void)rmdir(f->folder);
    free(f);
}

int lampd_setup(void **state)
{
    struct lampd_fixture *f = lampd_fixture_make();

    lampd_fixture_start(f);
    *state = f;
    return 0;
}

int lampd_teardown(void **state)
{
    lampd_fixture_free(*state);
    return 0;
}

char wire(const struct lampd_fixture *f, unsigned i)
{
    int file = open(f->wires, O_RDONLY | O_CLOEXEC);
    char level = '?';

    if (file >= 0) {
        (void)!pread(file, &level, 1, i);
        (void)close(file);
    }
    return level;
}

void move_wire(const struct lampd_fixture *f, unsigned i, char level)
{
    int file = open(f->wires, O_WRONLY | O_CLOEXEC);

    assert_true(file >= 0);
    assert_int_equal(pwrite(file, &level, 1, i), 1);
    (void)close(file);
}

int64_t wait_for_wire(const struct lampd_fixture *f, unsigned i, char level, int64_t most_ns)
{
    int64_t from_ns = ttf_clock_now_ns(f->clock);
    int64_t now_ns = from_ns;

    while (wire(f, i) != level) {
        now_ns = ttf_clock_now_ns(f->clock);
        if (now_ns - from_ns > most_ns)
            fail_msg("wire %u is still '%c' after %lld ms", i, wire(f, i),
                     (long long)(most_ns / TTF_NS_PER_MS));
        (void)ttf_clock_wait_until(f->clock, now_ns + TTF_NS_PER_MS);
    }
    return now_ns - from_ns;
}

struct ttf_lamps *lampd_fixture_client(struct lampd_fixture *f)
{
    struct ttf_err err = {0};
    unsigned i = 0;

    while (i < LAMPD_CLIENTS && f->clients[i])
        i++;
    assert_true(i < LAMPD_CLIENTS);
    if (ttf_lamps_lampd_create(f->socket, f->clock, &f->clients[i], &err) < 0)
        fail_msg("%s: %s", err.where, err.what);
    return f->clients[i];
}

void lampd_fixture_part(struct lampd_fixture *f, struct ttf_lamps *client)
{
    unsigned i = 0;

    while (i < LAMPD_CLIENTS && f->clients[i] != client)
        i++;
    assert_true(i < LAMPD_CLIENTS);
    f->clients[i] = NULL;
    ttf_lamps_destroy(client);
}
