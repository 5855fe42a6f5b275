/* SPDX-License-Identifier: Apache-2.0 */
/* test_lampd.c: the guardian as a process sees its clients, on wires that an outsider looks at. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include "alloc/alloc_hook.h"
#include "lampd_fixture.h"
#include "ttf/base/time.h"

#define MS TTF_NS_PER_MS

/*
 * How late a busy machine may look: the guardian's own bounds are in virtual time elsewhere
 * (test_guardian_exhaustive); here it must happen, and not before it may.
 */
#define MUCH_LATER_NS (20 * TTF_NS_PER_S)

/* What another guardian at the same socket is told. */
static int second_guardian(struct lampd_fixture *f)
{
    const struct ttf_lampd_config config = {.socket = f->socket,
                                            .n = LAMPD_LAMPS,
                                            .info = f->info,
                                            .lines = f->lines,
                                            .door = -1,
                                            .clock = f->clock};
    struct ttf_lampd *second;

    return ttf_lampd_create(&config, &second, NULL);
}

static int64_t in(struct lampd_fixture *f, int64_t ns)
{
    return ttf_clock_now_ns(f->clock) + ns;
}

static struct ttf_lamps *lit_client(struct lampd_fixture *f)
{
    struct ttf_lamps *lamps = lampd_fixture_client(f);

    assert_int_equal(ttf_lamps_acquire(lamps, in(f, TTF_NS_PER_H), NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), 0);
    assert_int_equal(wire(f, 0), '1');
    return lamps;
}

static struct ttf_lamp_state look(struct ttf_lamps *lamps, unsigned i)
{
    struct ttf_lamp_state s;

    assert_int_equal(ttf_lamps_state(lamps, i, &s), 0);
    return s;
}

static void wires_follow_commands_whatever_their_polarity(void **state)
{
    struct lampd_fixture *f = *state;
    struct ttf_lamps *lamps = lampd_fixture_client(f);

    assert_int_equal(wire(f, 0), '0');
    assert_int_equal(wire(f, 1), '1'); /* active low */
    assert_int_equal(ttf_lamps_acquire(lamps, in(f, TTF_NS_PER_H), NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 1, 700, NULL), 0); /* a switch: on */
    assert_int_equal(wire(f, 0), '1');
    assert_int_equal(wire(f, 1), '0');
    ttf_lamps_release(lamps);
    assert_int_equal(wire(f, 0), '0');
    assert_int_equal(wire(f, 1), '1');
    lampd_fixture_part(f, lamps);
}

static void only_the_holder_lights_but_anyone_darkens(void **state)
{
    struct lampd_fixture *f = *state;
    struct ttf_lamps *holder = lit_client(f), *other = lampd_fixture_client(f);

    assert_int_equal(ttf_lamps_acquire(other, in(f, TTF_NS_PER_S), NULL), -EBUSY);
    assert_int_equal(ttf_lamps_set(other, 1, 1000, NULL), -ESTALE);
    ttf_lamps_release(other); /* of what it does not hold */
    assert_int_equal(wire(f, 0), '1');
    assert_int_equal(ttf_lamps_set(other, 0, 0, NULL), 0);
    assert_int_equal(wire(f, 0), '0');
    lampd_fixture_part(f, holder);
    assert_int_equal(ttf_lamps_acquire(other, in(f, TTF_NS_PER_S), NULL), 0);
    lampd_fixture_part(f, other);
}

/* A process that has lit lamp 0. */
static pid_t child(struct lampd_fixture *f, int64_t life_ms, const char *what)
{
    char life[24], line[8];
    int out[2];
    pid_t pid;

    snprintf(life, sizeof(life), "%lld", (long long)life_ms);
    assert_int_equal(pipe(out), 0);
    pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        (void)dup2(out[1], STDOUT_FILENO);
        (void)prctl(PR_SET_PDEATHSIG, SIGKILL); /* also of a test that fails before its end() */
        execl(LAMPD_CHILD, LAMPD_CHILD, f->socket, life, what, (char *)NULL);
        _exit(127);
    }
    (void)close(out[1]);
    assert_int_equal(read(out[0], line, 4), 4);
    (void)close(out[0]);
    assert_int_equal(wire(f, 0), '1');
    return pid;
}

static void end(pid_t pid)
{
    (void)kill(pid, SIGKILL);
    (void)waitpid(pid, NULL, 0);
}

static void a_killed_client_leaves_the_lamps_dark(void **state)
{
    struct lampd_fixture *f = *state;
    pid_t pid = child(f, 3600000, "waits");
    struct ttf_lamps *next;

    end(pid);
    wait_for_wire(f, 0, '0', MUCH_LATER_NS);
    next = lit_client(f); /* its lease is free at once */
    lampd_fixture_part(f, next);
}

static void a_stopped_client_loses_its_lease_and_is_told(void **state)
{
    struct lampd_fixture *f = *state;
    pid_t pid = child(f, 3600000, "gives");
    int status;

    assert_int_equal(kill(pid, SIGSTOP), 0);
    wait_for_wire(f, 0, '0', MUCH_LATER_NS);
    assert_int_equal(kill(pid, SIGCONT), 0);
    assert_int_equal(waitpid(pid, &status, 0), pid); /* its next sign of life fails */
    assert_true(WIFEXITED(status) && WEXITSTATUS(status) == 1);
    assert_int_equal(wire(f, 0), '0');
}

static void a_client_that_hangs_keeps_them_until_its_declared_sign_of_life(void **state)
{
    struct lampd_fixture *f = *state;
    pid_t pid = child(f, 1500, "waits");
    int64_t took_ns = wait_for_wire(f, 0, '0', MUCH_LATER_NS);

    /* The renewer kept the lease while the client's long exposure was declared. */
    assert_true(took_ns > 1000 * MS);
    end(pid);
}

static void who_speaks_another_language_is_let_go(void **state)
{
    struct lampd_fixture *f = *state;
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    struct ttf_lamps *lamps = lit_client(f);
    char noise[64] = "GET / HTTP/1.1";

    snprintf(at.sun_path, sizeof(at.sun_path), "%s", f->socket);
    for (unsigned i = 0; i < 20; i++) {
        int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);

        assert_true(fd >= 0);
        assert_int_equal(connect(fd, (struct sockaddr *)&at, sizeof(at)), 0);
        (void)!send(fd, noise, sizeof(noise) - i, MSG_NOSIGNAL);
        assert_int_equal(recv(fd, noise, sizeof(noise), 0), 0);
        (void)close(fd);
    }
    assert_int_equal(wire(f, 0), '1');
    assert_int_equal(ttf_lamps_alive(lamps, in(f, TTF_NS_PER_H), NULL), 0);
    lampd_fixture_part(f, lamps);
}

static void an_open_door_darkens_what_is_interlocked(void **state)
{
    struct lampd_fixture *f = lampd_fixture_make();
    struct ttf_lamps *lamps;

    *state = f;
    f->info[0].interlock_door = true;
    lampd_fixture_start(f);
    lamps = lit_client(f);
    assert_int_equal(ttf_lamps_set(lamps, 1, 1000, NULL), 0);
    assert_int_equal(ttf_lamps_lampd_door(lamps, NULL), 0);
    move_wire(f, 2, '1');
    wait_for_wire(f, 0, '0', MUCH_LATER_NS);
    assert_int_equal(ttf_lamps_lampd_door(lamps, NULL), 1);
    assert_int_equal(wire(f, 1), '0'); /* active low: lit, as it has no interlock */
    assert_int_equal(look(lamps, 0).trip, TTF_TRIP_DOOR);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), -EPERM);
    move_wire(f, 2, '0');
    while (ttf_lamps_lampd_door(lamps, NULL) == 1)
        ;
    assert_int_equal(wire(f, 0), '0'); /* nothing lights by itself */
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), 0);
    lampd_fixture_part(f, lamps);
}

static void wait_for_trip(struct lampd_fixture *f, struct ttf_lamps *lamps, enum ttf_lamp_trip trip)
{
    int64_t deadline_ns = in(f, MUCH_LATER_NS);

    while (look(lamps, 0).trip != trip) {
        assert_true(ttf_clock_now_ns(f->clock) < deadline_ns);
        (void)ttf_clock_wait_until(f->clock, in(f, MS));
    }
}

static void watched_lamp(void **state)
{
    struct lampd_fixture *f = lampd_fixture_make();

    *state = f;
    f->info[0].max_temp_mdegc = 60000;
    f->info[0].hysteresis_mdegc = 5000;
    lampd_fixture_start(f);
}

static void heat_darkens_a_lamp_until_it_has_cooled(void **state)
{
    struct lampd_fixture *f;
    struct ttf_lamps *lamps;

    watched_lamp(state);
    f = *state;
    lamps = lampd_fixture_client(f);
    assert_int_equal(ttf_lamps_acquire(lamps, in(f, TTF_NS_PER_H), NULL), 0);
    while (ttf_lamps_set(lamps, 0, 1000, NULL) == -EPERM) /* until the first reading */
        (void)ttf_clock_wait_until(f->clock, in(f, MS));
    assert_int_equal(wire(f, 0), '1');
    f->heat.temp_mdegc = 60001;
    wait_for_wire(f, 0, '0', MUCH_LATER_NS);
    assert_int_equal(look(lamps, 0).trip, TTF_TRIP_TEMP);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), -EPERM);
    lampd_fixture_part(f, lamps);
}

static void a_sensor_that_hangs_does_not_hang_the_guardian(void **state)
{
    struct lampd_fixture *f;
    struct ttf_lamps *lamps;

    watched_lamp(state);
    f = *state;
    lamps = lampd_fixture_client(f);
    assert_int_equal(ttf_lamps_acquire(lamps, in(f, TTF_NS_PER_H), NULL), 0);
    while (ttf_lamps_set(lamps, 0, 1000, NULL) == -EPERM)
        (void)ttf_clock_wait_until(f->clock, in(f, MS));
    atomic_store(&f->heat.hangs, true);
    wait_for_trip(f, lamps, TTF_TRIP_TEMP_MISSING); /* after 10 s */
    assert_int_equal(wire(f, 0), '0');
    assert_int_equal(ttf_lamps_set(lamps, 1, 1000, NULL), 0); /* it has no limit */
    lampd_fixture_part(f, lamps);
}

/* As one whose thread hung in another sensor's driver between measuring and telling. */
static void a_temperature_that_was_measured_long_ago_lights_no_lamp(void **state)
{
    struct lampd_fixture *f = lampd_fixture_make();
    struct ttf_lamps *lamps;

    *state = f;
    f->info[0].max_temp_mdegc = 60000;
    f->heat.age_ns = TTF_TEMP_MISSING_NS + TTF_NS_PER_S;
    lampd_fixture_start(f);
    lamps = lampd_fixture_client(f);
    assert_int_equal(ttf_lamps_acquire(lamps, in(f, TTF_NS_PER_H), NULL), 0);
    while (atomic_load(&f->heat.n) < 2) /* the first was told before the second was asked for */
        (void)ttf_clock_wait_until(f->clock, in(f, MS));
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), -EPERM);
    assert_int_equal(look(lamps, 0).trip, TTF_TRIP_TEMP_MISSING);
    assert_int_equal(wire(f, 0), '0');
    lampd_fixture_part(f, lamps);
}

static void a_guardian_ends_although_its_sensor_hangs(void **state)
{
    struct lampd_fixture *f = lampd_fixture_make();
    const struct ttf_lampd_config config = {.socket = f->socket,
                                            .n = LAMPD_LAMPS,
                                            .info = f->info,
                                            .lines = f->lines,
                                            .door = -1,
                                            .clock = f->clock,
                                            .sensors = &f->heat.base};
    struct ttf_lampd *lampd = NULL;

    *state = f;
    f->heat.hangs = true;
    assert_int_equal(ttf_lampd_create(&config, &lampd, NULL), 0);
    while (!atomic_load(&f->heat.asked))
        (void)ttf_clock_wait_until(f->clock, in(f, MS));
    (void)alarm(60); /* one that waits for it for ever ends the test */
    assert_int_equal(ttf_lampd_destroy(lampd), -EBUSY);
    assert_int_equal(access(f->socket, F_OK), -1);
    f->heat.hangs = false;
    while (ttf_lampd_destroy(lampd) < 0)
        ;
    (void)alarm(0);
}

static void a_guardian_that_ends_darkens_and_another_is_found(void **state)
{
    struct lampd_fixture *f = *state;
    struct ttf_lamps *lamps = lit_client(f);
    struct ttf_err err = {0};

    lampd_fixture_stop(f);
    assert_int_equal(wire(f, 0), '0');
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), -ESTALE);
    assert_int_equal(ttf_lamps_alive(lamps, in(f, TTF_NS_PER_H), &err), -ESTALE);
    assert_int_equal(ttf_lamps_set(lamps, 0, 0, NULL), -ENODEV);
    assert_int_equal(ttf_lamps_acquire(lamps, in(f, TTF_NS_PER_H), &err), -ENODEV);
    assert_non_null(strstr(err.hint, "ttfbox-lampd"));
    lampd_fixture_start(f);
    assert_int_equal(ttf_lamps_acquire(lamps, in(f, TTF_NS_PER_H), NULL), 0);
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), 0);
    assert_int_equal(wire(f, 0), '1');
    lampd_fixture_part(f, lamps);
}

/* A guardian that hangs: it listens, and hears nobody. */
static int deaf_guardian(const struct lampd_fixture *f)
{
    struct sockaddr_un at = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0);

    snprintf(at.sun_path, sizeof(at.sun_path), "%s", f->socket);
    assert_true(fd >= 0);
    assert_int_equal(bind(fd, (struct sockaddr *)&at, sizeof(at)), 0);
    assert_int_equal(listen(fd, 1), 0);
    return fd;
}

static void a_guardian_that_hangs_does_not_hang_its_clients(void **state)
{
    struct lampd_fixture *f = *state;
    struct ttf_lamps *lamps = lit_client(f);
    struct ttf_lamp_state s;
    struct ttf_lamps *another;
    int deaf;

    lampd_fixture_stop(f);
    deaf = deaf_guardian(f);
    (void)alarm(30); /* a call that waits for ever ends the test */
    assert_int_equal(ttf_lamps_set(lamps, 0, 1000, NULL), -ESTALE);
    for (unsigned i = 0; i < 2; i++) { /* more calls than it has room for callers */
        assert_int_equal(ttf_lamps_acquire(lamps, in(f, TTF_NS_PER_H), NULL), -ENODEV);
        assert_int_equal(ttf_lamps_set(lamps, 0, 0, NULL), -ENODEV);
        assert_int_equal(ttf_lamps_state(lamps, 0, &s), -ENODEV);
    }
    assert_int_equal(ttf_lamps_lampd_create(f->socket, f->clock, &another, NULL), -ENODEV);
    assert_int_equal(second_guardian(f), -EADDRINUSE);
    (void)alarm(0);
    lampd_fixture_part(f, lamps);
    (void)close(deaf);
    (void)unlink(f->socket);
}

static void two_guardians_are_one_too_many(void **state)
{
    struct lampd_fixture *f = *state;
    struct ttf_lamps *lamps = lit_client(f);

    assert_int_equal(second_guardian(f), -EADDRINUSE);
    assert_int_equal(ttf_lamps_alive(lamps, in(f, TTF_NS_PER_H), NULL), 0);
    assert_int_equal(wire(f, 0), '1');
    lampd_fixture_part(f, lamps);
}

static void a_chip_that_vanishes_is_found_again_dark(void **state)
{
    struct lampd_fixture *f = *state;
    struct ttf_lamps *lamps = lit_client(f);
    char away[112];
    int64_t deadline_ns;

    snprintf(away, sizeof(away), "%s/away", f->folder);
    assert_int_equal(link(f->wires, away), 0);
    assert_int_equal(unlink(f->wires), 0);
    assert_int_equal(unlink(away), 0);
    deadline_ns = in(f, MUCH_LATER_NS);
    while (ttf_lamps_set(lamps, 1, 1000, NULL) != -ENODEV)
        assert_true(ttf_clock_now_ns(f->clock) < deadline_ns);
    fclose(fopen(f->wires, "w")); /* plugged in again */
    wait_for_wire(f, 1, '1', MUCH_LATER_NS);
    assert_int_equal(wire(f, 0), '0');
    while (ttf_lamps_acquire(lamps, in(f, TTF_NS_PER_H), NULL) == -ENODEV)
        (void)ttf_clock_wait_until(f->clock, in(f, 20 * MS));
    while (ttf_lamps_set(lamps, 0, 1000, NULL) == -ENODEV)
        (void)ttf_clock_wait_until(f->clock, in(f, 20 * MS));
    assert_int_equal(wire(f, 0), '1');
    lampd_fixture_part(f, lamps);
}

static void a_running_guardian_allocates_nothing(void **state)
{
    struct lampd_fixture *f = *state;
    struct ttf_lamps *lamps = lit_client(f);
    struct alloc_counts before = alloc_hook_counts(ALLOC_ALL), after;

    for (unsigned i = 0; i < 200; i++) {
        assert_int_equal(ttf_lamps_alive(lamps, in(f, TTF_NS_PER_H), NULL), 0);
        assert_int_equal(ttf_lamps_set(lamps, i & 1, i & 2 ? 1000 : 0, NULL), 0);
        (void)look(lamps, 0);
    }
    after = alloc_hook_counts(ALLOC_ALL);
    assert_int_equal(after.calls - before.calls, 0);
    lampd_fixture_part(f, lamps);
}

static unsigned threads(void)
{
    DIR *tasks = opendir("/proc/self/task");
    unsigned n = 0;

    assert_non_null(tasks);
    while (readdir(tasks)) /* NOLINT(concurrency-mt-unsafe): a stream of its own */
        n++;
    (void)closedir(tasks);
    return n;
}

/* What a test leaves whose assertion failed: nothing of it may live beside the tests after it. */
static void clients_end_before_the_clock_that_they_wait_by(void **state)
{
    unsigned before = threads(), guarded;
    struct lampd_fixture *f;

    (void)lampd_setup(state);
    f = *state;
    guarded = threads();
    (void)lit_client(f);
    (void)lampd_fixture_client(f);
    assert_int_equal(threads(), guarded + 2); /* a renewer of each */
    (void)lampd_teardown(state);
    for (unsigned n = 0; n < 2000 && threads() != before; n++)
        (void)usleep(1000); /* joined, and yet a moment in the list */
    assert_int_equal(threads(), before);
}

int main(void)
{
#define GUARDED(test) cmocka_unit_test_setup_teardown(test, lampd_setup, lampd_teardown)
#define OWN(test)     cmocka_unit_test_teardown(test, lampd_teardown)
    const struct CMUnitTest tests[] = {
        GUARDED(wires_follow_commands_whatever_their_polarity),
        GUARDED(only_the_holder_lights_but_anyone_darkens),
        GUARDED(a_killed_client_leaves_the_lamps_dark),
        GUARDED(a_stopped_client_loses_its_lease_and_is_told),
        GUARDED(a_client_that_hangs_keeps_them_until_its_declared_sign_of_life),
        GUARDED(who_speaks_another_language_is_let_go),
        OWN(an_open_door_darkens_what_is_interlocked),
        OWN(heat_darkens_a_lamp_until_it_has_cooled),
        OWN(a_sensor_that_hangs_does_not_hang_the_guardian),
        OWN(a_temperature_that_was_measured_long_ago_lights_no_lamp),
        OWN(a_guardian_ends_although_its_sensor_hangs),
        GUARDED(a_guardian_that_ends_darkens_and_another_is_found),
        GUARDED(a_guardian_that_hangs_does_not_hang_its_clients),
        GUARDED(two_guardians_are_one_too_many),
        GUARDED(a_chip_that_vanishes_is_found_again_dark),
        GUARDED(a_running_guardian_allocates_nothing),
        cmocka_unit_test(clients_end_before_the_clock_that_they_wait_by),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
