/* SPDX-License-Identifier: Apache-2.0 */
/*
 * clock.h: the simulated box's clocks: virtual time, or the machine's time with
 * simulated UTC beside it. Private to hal/sim.
 */
#ifndef TTF_HAL_SIM_CLOCK_H
#define TTF_HAL_SIM_CLOCK_H

#include "clock_utc.h"
#include "ttf/hal/clock_backend.h"

/* A virtual clock that stands at start_ns. utc is borrowed and may be NULL (then UTC is unknown). NULL: no memory. */
struct ttf_clock *sim_clock_virtual_create(int64_t start_ns, const char *boot_id,
                                           const int64_t cost_ns[TTF_WORK_COUNT],
                                           struct sim_utc *utc);

/* The machine's clock with utc's steps on top. NULL with errno set. */
struct ttf_clock *sim_clock_machine_create(struct sim_utc *utc);

#endif
