/* SPDX-License-Identifier: Apache-2.0 */
/*
 * guardian.h: the lamp guardian's pure state machine: events and time in,
 * levels out. No I/O, no allocation, no clock: whoever runs it (the simulated
 * box here, `ttfbox-lampd` on a real one) brings events with their boot-clock
 * instants, in order, and drives the lines to the levels it finds.
 *
 * Rules (ARCHITECTURE.md, Lamps): a lease lapses 400 ms after its last renewal;
 * a lamp beyond max_on or max_duty, hotter than its limit or with its
 * temperature missing for 10 s, or behind an open door, goes off with a reason.
 * Off needs nobody's consent. On after a trip needs a person (clear) or, for
 * temperature, cooling below the hysteresis; for a lease, a new lease; for the
 * door, closing it; for duty, the window to have room again.
 *
 * Nothing lights up by itself: when its cause is gone, a lamp that tripped stays
 * dark until the client commands it again.
 *
 * Threads: none of its own; the caller serialises.
 */
#ifndef TTF_HAL_GUARDIAN_H
#define TTF_HAL_GUARDIAN_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/hal/lamps.h"

/* Intervals kept per lamp to account max_duty; older ones are merged, on the safe side. */
#define TTF_GUARDIAN_SPANS 64

struct ttf_guardian_lamp {
    unsigned commanded_permille;
    unsigned actual_permille;
    enum ttf_lamp_trip trip;
    enum ttf_lamp_trip
        heat;            /* temperature or temperature-missing: has to cool below the hysteresis */
    int64_t on_since_ns; /* TTF_NS_UNKNOWN when off */
    int64_t on_total_ns;
    unsigned n_spans; /* completed on-spans within the duty window, oldest first */
    struct {
        int64_t from_ns, to_ns;
    } spans[TTF_GUARDIAN_SPANS];
};

/* The whole state: plain, copyable. Read freely; change only through the functions. */
struct ttf_guardian {
    unsigned n;
    struct ttf_lamp_info info[TTF_LAMPS_MAX];
    struct ttf_guardian_lamp lamp[TTF_LAMPS_MAX];
    int64_t now_ns; /* of the last event */
    bool leased;
    int64_t lease_until_ns; /* lapses then */
    bool door_open;
    bool temp_known;
    int32_t temp_mdegc;
    int64_t temp_at_ns; /* when the last reading that counts was made; of init */
};

/*
 * All lamps off, no lease, door closed, temperature unknown since now_ns: a watched lamp waits for its
 * first reading below the hysteresis. Nothing is remembered of a run before. n <= TTF_LAMPS_MAX; infos are copied.
 */
void ttf_guardian_init(struct ttf_guardian *g, const struct ttf_lamp_info *info, unsigned n,
                       int64_t now_ns);

/*
 * After init, where lamps may have burnt just before (power came back, the process was started again): every
 * lamp with a max_duty counts as on, until now, for all that its window allows.
 */
void ttf_guardian_assume_used(struct ttf_guardian *g);

/* Lets time pass to now_ns (>= the last event's; earlier is taken as the last): applies every limit at its own instant. */
void ttf_guardian_advance(struct ttf_guardian *g, int64_t now_ns);

/* The next instant at which a limit may turn a lamp off, or TTF_NS_NEVER. Advance then, at the latest. */
int64_t ttf_guardian_next_ns(const struct ttf_guardian *g);

/* The client took or renewed its lease: valid until now_ns + TTF_LEASE_LAPSE_NS. acquire: -EBUSY if leased; renew: -ESTALE if not. */
int ttf_guardian_acquire(struct ttf_guardian *g, int64_t now_ns);
int ttf_guardian_renew(struct ttf_guardian *g, int64_t now_ns);

/*
 * The same as renewing now and every TTF_LEASE_RENEW_NS from then up to
 * until_ns, told at once: for a box whose renewer is simulated. -ESTALE.
 */
int ttf_guardian_renew_through(struct ttf_guardian *g, int64_t now_ns, int64_t until_ns);

/* Lease given back: all off, no trip. */
void ttf_guardian_release(struct ttf_guardian *g, int64_t now_ns);

/* As ttf_lamps_set: 0, -ESTALE, -EPERM. i < n. */
int ttf_guardian_set(struct ttf_guardian *g, int64_t now_ns, unsigned i, unsigned permille);

/* A temperature reading; a missing one is simply not reported. */
void ttf_guardian_temp(struct ttf_guardian *g, int64_t now_ns, int32_t temp_mdegc);

/* The same as readings of this temperature from now_ns on, the last at until_ns, told at once. */
void ttf_guardian_temp_through(struct ttf_guardian *g, int64_t now_ns, int64_t until_ns,
                               int32_t temp_mdegc);

/*
 * A reading that was made at at_ns and comes only now: the 10 s until the temperature is missing count from at_ns. One that is
 * as old as that already, or older than the last that counts, is as if it had not come: it says nothing of now, and nobody has cooled by it.
 */
void ttf_guardian_temp_late(struct ttf_guardian *g, int64_t now_ns, int64_t at_ns,
                            int32_t temp_mdegc);

void ttf_guardian_door(struct ttf_guardian *g, int64_t now_ns, bool open);

/* A person clears a trip. 0, or -EPERM while its cause persists. */
int ttf_guardian_clear(struct ttf_guardian *g, int64_t now_ns, unsigned i);

#endif
