/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lamp_driver.h: commands lamps through the guardian's client: keeps the lease
 * alive, notices trips, commands again what a trip took away as soon as the
 * guardian allows it. A lamp's trouble is never an error here: it is an event and
 * a flag on the images. Loop thread only.
 */
#ifndef TTF_CAPTURE_PRIVATE_LAMP_DRIVER_H
#define TTF_CAPTURE_PRIVATE_LAMP_DRIVER_H

#include "events.h"
#include "ttf/dataset/record.h"
#include "ttf/hal/lamps.h"

struct ttf_lamp_driver {
    struct ttf_lamps *lamps; /* NULL: nothing to drive */
    struct ttf_events *events;
    unsigned n;
    unsigned wanted[TTF_LAMPS_MAX];
    enum ttf_lamp_trip trip[TTF_LAMPS_MAX]; /* as last told */
    bool no_lease;                          /* none is to be had: told once */
    bool silent[TTF_LAMPS_MAX];             /* nobody says what it does: told once */
    bool refused[TTF_LAMPS_MAX];            /* a command was refused: told once */
    bool off_level[TTF_LAMPS_MAX];          /* measured far from commanded: told once */
};

/* Takes the lease. lamps NULL: a driver that does nothing. -EBUSY. */
TTF_MUST_USE int ttf_lamp_driver_begin(struct ttf_lamp_driver *driver, struct ttf_lamps *lamps,
                                       struct ttf_events *events, int64_t alive_until_ns,
                                       struct ttf_err *err);

/* All off, lease given back. */
void ttf_lamp_driver_end(struct ttf_lamp_driver *driver);

/* From now on these levels are wanted; commands those that differ. True if any did. */
bool ttf_lamp_driver_want(struct ttf_lamp_driver *driver, const unsigned levels[TTF_LAMPS_MAX]);

/* A sign of life, and what goes with it: a lost lease taken anew, trips noticed, lost lamps commanded again. */
void ttf_lamp_driver_alive(struct ttf_lamp_driver *driver, int64_t alive_until_ns);

/* Levels now, into a shot. Returns the words an image gets for them: 0 or TTF_LAMP_MARK_*. */
enum {
    TTF_LAMP_MARK_TRIPPED = 1u << 0,
    TTF_LAMP_MARK_LEVEL = 1u << 1,
    TTF_LAMP_MARK_UNSETTLED = 1u << 2, /* lit again after a trip, less than settle_ns before */
    TTF_LAMP_MARK_UNKNOWN = 1u << 3    /* nobody says what a lamp did; it is not in the shot */
};
unsigned ttf_lamp_driver_sample(struct ttf_lamp_driver *driver, int64_t settle_ns,
                                struct ttf_shot *shot);

#endif
