/* SPDX-License-Identifier: Apache-2.0 */
/* until_run.h: runs that end in time, by clocks that believe what a test wrote down. */
#ifndef TTF_TESTS_UNTIL_RUN_H
#define TTF_TESTS_UNTIL_RUN_H

#include "living.h"
#include "ttf/hal/clock_backend.h"

/* As living_init: a slot each minute from power-on + 12 s on, until so many have been due. living_finish ends it. */
void until_init(struct sim_run *run, enum ttf_plan_end end, int64_t slots);

/* Asserts that these are its slots, no more were to come, and that it is sealed and says this reason. */
void until_expect_end(struct sim_run *run, const char *letters, const char *reason);

/* From an instant since the first power-on on. */
struct until_belief {
    int64_t from_ns;
    enum ttf_trust trust;
    int64_t ahead_ns;
};

struct until_clock {
    struct sim_run run; /* first: its callbacks are given this */
    struct ttf_clock_ops ops;
    const struct until_belief *beliefs;
    unsigned n;
};

/* The same run in a box that believes these. */
void until_clock_init(struct until_clock *b, enum ttf_plan_end end, int64_t slots,
                      const struct until_belief *beliefs, unsigned n);

#endif
