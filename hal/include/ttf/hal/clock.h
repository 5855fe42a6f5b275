/* SPDX-License-Identifier: Apache-2.0 */
/*
 * clock.h: the only source of time.
 *
 * A clock has a boot clock (never steps, int64_t ns) and, beside it, what it
 * believes of UTC with the trust that belief deserves. Nothing outside a clock's
 * back-end calls clock_gettime, time, nanosleep or a timed pthread wait.
 *
 * Threads. A clock may be virtual: it then advances only when every thread that
 * joined it waits on it. So a thread that does work in time calls
 * ttf_clock_join first and ttf_clock_leave last, and blocks nowhere except
 * in ttf_clock_wait_until and ttf_gate_wait (short mutex sections apart). All
 * functions may be called from any thread unless they say otherwise.
 */
#ifndef TTF_HAL_CLOCK_H
#define TTF_HAL_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/time.h"

struct ttf_clock;
struct ttf_gate;

/* Why the wall clock may be believed, the less believable first. Stored in a dataset's segments by these names. */
enum ttf_trust {
    TTF_TRUST_NONE = 0, /* nobody vouches for it: a board without RTC after a power cut */
    TTF_TRUST_HOST,     /* a PC's word */
    TTF_TRUST_RTC,      /* a battery-backed clock that passed its plausibility check */
    TTF_TRUST_NTP,      /* synchronised */
    TTF_TRUST_COUNT
};

/* "none", "host", "rtc", "ntp". */
const char *ttf_trust_name(enum ttf_trust trust);

/* UTC at one instant of the boot clock. */
struct ttf_utc {
    int64_t boot_ns;        /* the instant */
    int64_t utc_ns;         /* UTC then */
    int64_t uncertainty_ns; /* half-width; TTF_NS_UNKNOWN if nobody vouches */
    enum ttf_trust trust;
    uint32_t steps; /* how often UTC has been stepped since boot, as far as the clock noticed */
};

/* Kinds of work that cost time on a real box; a virtual clock charges what the board says. */
enum ttf_work {
    TTF_WORK_DEVELOP = 0, /* developing one frame */
    TTF_WORK_COMMIT,      /* writing and syncing one slot */
    TTF_WORK_COUNT
};

/* Now, on the boot clock. */
int64_t ttf_clock_now_ns(struct ttf_clock *clock);

/* 2024: a clock that shows less was never set, as no ttfbox is that old. */
#define TTF_UTC_EARLIEST_NS (INT64_C(1704067200) * TTF_NS_PER_S)

/* What the clock believes of UTC now. Nobody vouches for one before TTF_UTC_EARLIEST_NS, whatever the back-end says. */
void ttf_clock_utc(struct ttf_clock *clock, struct ttf_utc *ret);

/*
 * What is to be added to an instant of the kernel's CLOCK_MONOTONIC, with which drivers stamp, to have it on the boot
 * clock: all the time that the machine has slept, so it grows by each suspend. *ret_uncertainty_ns, which may be NULL,
 * is the half-width of this look. 0 and 0 where time is simulated.
 */
int64_t ttf_clock_monotonic_offset_ns(struct ttf_clock *clock, int64_t *ret_uncertainty_ns);

/* A random identifier of this boot, 36 characters and a zero; belongs to the clock. */
const char *ttf_clock_boot_id(struct ttf_clock *clock);

/* True if time is simulated. */
bool ttf_clock_is_virtual(const struct ttf_clock *clock);

/* Registers, and takes back, the calling thread (not an identity: a count). */
void ttf_clock_join(struct ttf_clock *clock);
void ttf_clock_leave(struct ttf_clock *clock);

/*
 * Registers a thread that is about to be created, from its parent: call this
 * before pthread_create, and ttf_clock_leave at the end of the new thread. So
 * virtual time cannot run away before the thread has started.
 */
void ttf_clock_join_for(struct ttf_clock *clock);

/* Waits until the boot clock is at or past deadline_ns. Returns 0. A past deadline returns at once. */
int ttf_clock_wait_until(struct ttf_clock *clock, int64_t deadline_ns);

/* Says that work of this kind was done `times` times; a virtual clock waits the cost, a real one does nothing. */
void ttf_clock_charge(struct ttf_clock *clock, enum ttf_work work, unsigned times);

/*
 * A gate: one thread waits, any thread opens it. Opening is remembered until one
 * wait has passed through (a binary semaphore). A thread that was let through
 * counts as running from the moment of the opening.
 */
struct ttf_gate *ttf_gate_create(struct ttf_clock *clock); /* NULL: no memory */
void ttf_gate_destroy(struct ttf_gate *gate);              /* NULL allowed; nobody may wait */
void ttf_gate_open(struct ttf_gate *gate);

/* 0 when opened, -ETIMEDOUT when deadline_ns (or TTF_NS_NEVER) came first. */
TTF_MUST_USE int ttf_gate_wait(struct ttf_gate *gate, int64_t deadline_ns);

/* Frees the clock; no gate may remain. NULL allowed. */
void ttf_clock_destroy(struct ttf_clock *clock);

/* The machine's own clocks: CLOCK_BOOTTIME, CLOCK_REALTIME, adjtimex for trust. NULL with errno set on failure. */
struct ttf_clock *ttf_clock_real_create(void);

#endif
