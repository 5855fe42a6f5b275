/* SPDX-License-Identifier: Apache-2.0 */
/* lampd_fixture.h: a guardian on wires in a file, run by a thread, for tests to be its clients. */
#ifndef TTF_TESTS_LAMPD_FIXTURE_H
#define TTF_TESTS_LAMPD_FIXTURE_H

#include <pthread.h>
#include <stdatomic.h>

#include "ttf/hal/lampd.h"

#define LAMPD_LAMPS   2 /* "left" on wire 0, "right" on wire 1 (active low); the door is wire 2 */
#define LAMPD_CLIENTS 4

/* A thermometer that tests set. */
struct test_heat {
    struct ttf_sensors base;
    struct ttf_clock *clock;
    atomic_int temp_mdegc;
    atomic_bool silent, hangs, asked;
    atomic_llong age_ns; /* how long ago what it gives was measured */
    atomic_uint n;       /* readings given */
};

struct lampd_fixture {
    char folder[64], socket[96], wires[96];
    struct ttf_clock *clock;
    struct ttf_lines *lines;
    struct test_heat heat;
    struct ttf_lamp_info info[LAMPD_LAMPS];
    struct ttf_lampd *lampd;
    volatile int stop;
    pthread_t thread;
    bool running;
    struct ttf_lamps *clients[LAMPD_CLIENTS]; /* NULL: room for one */
};

/* cmocka setup and teardown: *state is the fixture. The lamps have no limits. */
int lampd_setup(void **state);
int lampd_teardown(void **state);

/* Makes it without starting the guardian, so that its lamps' limits can be set; then starts it. */
struct lampd_fixture *lampd_fixture_make(void);
void lampd_fixture_take_lines(struct lampd_fixture *f,
                              struct ttf_lines *lines); /* in place of its own */
void lampd_fixture_start(struct lampd_fixture *f);
void lampd_fixture_stop(struct lampd_fixture *f); /* the guardian alone */
void lampd_fixture_free(struct lampd_fixture *f);

/*
 * A client of it; the test fails if there is none. It ends with the fixture, before the clock that it waits by: a test
 * whose assertion failed frees nothing. Or earlier, by lampd_fixture_part.
 */
struct ttf_lamps *lampd_fixture_client(struct lampd_fixture *f);
void lampd_fixture_part(struct lampd_fixture *f, struct ttf_lamps *client);

/* What somebody who looks at wire i from outside sees: '0' or '1'; and moves it. */
char wire(const struct lampd_fixture *f, unsigned i);
void move_wire(const struct lampd_fixture *f, unsigned i, char level);

/* How long until wire i is at level, looking every ms; fails the test after most_ns. */
int64_t wait_for_wire(const struct lampd_fixture *f, unsigned i, char level, int64_t most_ns);

#endif
