/* SPDX-License-Identifier: Apache-2.0 */
/*
 * pulse.h: how the loop waits. Every wait, whatever for, is cut into ticks; at
 * each the loop feeds the watchdog, declares its next sign of life to the lamps,
 * and looks at power, storage, panel, UTC and the stop flag. Loop thread only.
 */
#ifndef TTF_CAPTURE_PRIVATE_PULSE_H
#define TTF_CAPTURE_PRIVATE_PULSE_H

#include "lamp_driver.h"
#include "timeline.h"
#include "ttf/capture/control.h"
#include "ttf/hal/box.h"
#include "utc_watch.h"

#define TTF_TICK_NS         (2 * TTF_NS_PER_S)
#define TTF_ALIVE_MARGIN_NS (2 * TTF_NS_PER_S) /* scheduling noise of a loaded board */
#define TTF_WATCHDOG_NS     (15 * TTF_NS_PER_S)
#define TTF_BLOCKING_MAX_NS (10 * TTF_NS_PER_S) /* a device call that cannot be cut into ticks */

/* Changes of plan in one boot whose UTC is corrected too; of more, the latest. */
#define TTF_PULSE_EARLIER 8

struct ttf_pulse {
    struct ttf_box *box;
    struct ttf_queue *queue;
    struct ttf_events *events;
    struct ttf_lamp_driver *lamps;
    const volatile int *stop;    /* NULL allowed */
    struct ttf_control *control; /* NULL allowed */
    int64_t next_index;          /* what is asked for up to here is heard */
    struct ttf_utc_watch utc;
    struct ttf_segment segment; /* the current one; corrected when UTC becomes better known */
    bool has_segment;
    bool
        corrected; /* it was, and nobody has looked since: what is reckoned in UTC may be other now */
    int gap_segment; /* of this boot's segments the one with an outage of unknown length before it; -1: none */
    /* those of this boot before it, of plans that were changed: corrected as well */
    struct ttf_segment earlier[TTF_PULSE_EARLIER];
    unsigned n_earlier;
    struct ttf_segment before; /* the last one of the boot before, if has_before */
    bool has_before;
    const struct ttf_run_past *past; /* of the run, if has_segment */
    bool
        behind; /* the clock stood before the last slot of a boot before at the last look: looked at again */
    bool button_stop; /* the button was held */
    bool door_open;
    int64_t door_opened_ns; /* the last time */
    /* the last time before that it was open and closed again; TTF_NS_UNKNOWN */
    int64_t door_was_opened_ns, door_was_closed_ns;
    bool watchdog; /* armed */
    enum ttf_led led;
};

/* Begins: looks at door and UTC. queue, events and lamps are borrowed. */
void ttf_pulse_begin(struct ttf_pulse *pulse, struct ttf_box *box, struct ttf_queue *queue,
                     struct ttf_events *events, struct ttf_lamp_driver *lamps,
                     const volatile int *stop);

/* Arms the watchdog: from now on the loop beats. */
void ttf_pulse_guard(struct ttf_pulse *pulse);

/* Disarms it: what follows may take its time. */
void ttf_pulse_end(struct ttf_pulse *pulse);

/* True once somebody asked for the end. */
bool ttf_pulse_stop_wanted(const struct ttf_pulse *pulse);

/*
 * One sign of life; the next comes before next_ns. 0; -ESHUTDOWN: power is gone;
 * else the errno that the committer says ends the run.
 */
TTF_MUST_USE int ttf_pulse_beat(struct ttf_pulse *pulse, int64_t next_ns);

/* Before a device call that may block for up to TTF_BLOCKING_MAX_NS. */
TTF_MUST_USE int ttf_pulse_beat_blocking(struct ttf_pulse *pulse);

/*
 * Waits until deadline_ns. 0, or as beat. stoppable: -ECANCELED as soon as a stop is wanted, 1 as soon as
 * something that was asked for is due to be heard, or the segment was corrected.
 */
TTF_MUST_USE int ttf_pulse_wait(struct ttf_pulse *pulse, int64_t deadline_ns, bool stoppable);

/* Waits for a gate: 0 opened, -ETIMEDOUT, or as beat. */
TTF_MUST_USE int ttf_pulse_gate(struct ttf_pulse *pulse, struct ttf_gate *gate,
                                int64_t deadline_ns);

/* Waits until the gate opens, beating all the while, whatever ended the run. */
void ttf_pulse_last_gate(struct ttf_pulse *pulse, struct ttf_gate *gate);

/* ttf_camera_next, cut into ticks; its results, or as beat. */
TTF_MUST_USE int ttf_pulse_next(struct ttf_pulse *pulse, struct ttf_camera *camera,
                                int64_t deadline_ns, struct ttf_frame **ret_frame,
                                struct ttf_err *err);

/* Looks at the door: was it open at any time from..until (the recent past)? */
bool ttf_pulse_door_was_open(struct ttf_pulse *pulse, int64_t from_ns, int64_t until_ns);

/* Another segment begins, of a changed plan: from now on it is the one that is corrected. */
void ttf_pulse_next_segment(struct ttf_pulse *pulse, const struct ttf_segment *segment);

/* UTC of an instant of this boot as its slots are labelled; TTF_NS_UNKNOWN: nobody is believed. */
int64_t ttf_pulse_utc_at(const struct ttf_pulse *pulse, int64_t boot_ns);

/* This clock stands before the last slot of a boot before, and is not believed until it has come past it: an event. */
void ttf_pulse_behind(struct ttf_pulse *pulse, const struct ttf_utc *utc);

/* Status light; a box without one is fine. */
void ttf_pulse_led(struct ttf_pulse *pulse, enum ttf_led led);

#endif
