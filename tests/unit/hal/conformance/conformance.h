/* SPDX-License-Identifier: Apache-2.0 */
/*
 * conformance.h: what every back-end must do, one suite per interface. A test
 * program of a back-end hands its factory to the suites of the devices it has, and
 * adds up what they return (the number of tests that failed).
 */
#ifndef TTF_TESTS_HAL_CONFORMANCE_H
#define TTF_TESTS_HAL_CONFORMANCE_H

#include "ttf/hal/box.h"

/* Makes a box with the devices under test; the others may be missing (clock excepted). */
struct conformance_factory {
    const char *name; /* of the back-end */
    /* 0 or a negative errno. Each test gets a box of its own, destroyed by ttf_box_destroy. */
    int (*make)(struct ttf_box *ret);
};

int conformance_clock(const struct conformance_factory *factory);
int conformance_camera(const struct conformance_factory *factory);
int conformance_lamps(const struct conformance_factory *factory);
int conformance_sensors(const struct conformance_factory *factory);
int conformance_panel(const struct conformance_factory *factory);
int conformance_watchdog(const struct conformance_factory *factory);

/* For the suites: a test on a box of its own; *state is the box. */
int conformance_setup(void **state);
int conformance_teardown(void **state);

#define CONFORMANCE_TEST(f, factory)                                      \
    {                                                                     \
#f, f, conformance_setup, conformance_teardown, (void *)(factory) \
    }

#endif
