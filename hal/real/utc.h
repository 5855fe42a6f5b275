/* SPDX-License-Identifier: Apache-2.0 */
/*
 * utc.h: what this machine believes of UTC, and how often that belief jumped.
 * Private to hal/real. The caller serialises.
 */
#ifndef TTF_HAL_REAL_UTC_H
#define TTF_HAL_REAL_UTC_H

#include <stdbool.h>

#include "ttf/hal/clock.h"

struct real_utc {
    bool rtc; /* a battery-backed clock set the system's time at boot */
    bool known;
    int64_t boot_ns, utc_ns; /* of the last look */
    uint32_t steps;
};

/* sys: "/sys", or a folder laid out like it. */
void real_utc_init(struct real_utc *u, const char *sys);

/* Reads the clocks now. */
void real_utc_look(struct real_utc *u, struct ttf_utc *ret);

/*
 * The pure part of a look: counts a step if UTC moved against the boot clock by
 * more than discipline (500 ppm) and reading can explain.
 */
void real_utc_note(struct real_utc *u, int64_t boot_ns, int64_t utc_ns, int64_t reading_ns);

/* What CLOCK_MONOTONIC lacks of the boot clock, and the half-width of this look. */
int64_t real_monotonic_offset_ns(int64_t *ret_uncertainty_ns);

/* The machine's boot clock. */
int64_t real_boot_ns(void);

#endif
