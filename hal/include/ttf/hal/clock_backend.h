/* SPDX-License-Identifier: Apache-2.0 */
/*
 * clock_backend.h: what the author of a clock implements.
 *
 * All ops are mandatory but monotonic_offset_ns (NULL: the clocks are one) and trust_host. `struct ttf_clock` is embedded first in the back-end's
 * own struct. Ops are called from any thread; the back-end does its own locking.
 */
#ifndef TTF_HAL_CLOCK_BACKEND_H
#define TTF_HAL_CLOCK_BACKEND_H

#include "ttf/hal/clock.h"
#include "ttf/hal/host_time.h"

struct ttf_clock_ops {
    const char *name; /* "real", "virtual" */
    bool is_virtual;
    int64_t (*now_ns)(struct ttf_clock *clock);
    void (*utc)(struct ttf_clock *clock, struct ttf_utc *ret);
    int64_t (*monotonic_offset_ns)(struct ttf_clock *clock, int64_t *ret_uncertainty_ns);
    /* NULL: a PC's word is of no use to it */
    void (*trust_host)(struct ttf_clock *clock, struct ttf_host_time *host_time);
    const char *(*boot_id)(struct ttf_clock *clock);
    void (*join)(struct ttf_clock *clock);
    void (*leave)(struct ttf_clock *clock);
    int (*wait_until)(struct ttf_clock *clock, int64_t deadline_ns);
    void (*charge)(struct ttf_clock *clock, enum ttf_work work, unsigned times);
    struct ttf_gate *(*gate_create)(struct ttf_clock *clock);
    void (*gate_destroy)(struct ttf_gate *gate);
    void (*gate_open)(struct ttf_gate *gate);
    int (*gate_wait)(struct ttf_gate *gate, int64_t deadline_ns);
    void (*destroy)(struct ttf_clock *clock);
};

struct ttf_clock {
    const struct ttf_clock_ops *ops;
};

/* Embedded first in a back-end's gate. */
struct ttf_gate {
    struct ttf_clock *clock;
};

#endif
