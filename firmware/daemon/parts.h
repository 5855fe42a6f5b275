/* SPDX-License-Identifier: Apache-2.0 */
/* parts.h: what the parts of the daemon share. */
#ifndef DAEMON_PARTS_H
#define DAEMON_PARTS_H

#include <pthread.h>

#include "absence.h"
#include "asks.h"
#include "calibrations.h"
#include "daemon.h"
#include "lock.h"
#include "mailbox.h"
#include "manager.h"
#include "orders.h"
#include "run.h"
#include "shadow.h"
#include "situation.h"
#include "ttf/config/daemon_file.h"
#include "ttf/hal/host_time.h"
#include "ttf/http/box.h"
#include "ttf/http/events.h"
#include "workshop.h"

struct keeper;

struct daemon {
    struct ttf_http_box door; /* first: downcast by address */
    const struct daemon_options *options;
    struct ttf_daemon_config config;
    struct ttf_board board;
    struct ttf_board view_board; /* the same without what watches: for pictures between runs */
    struct ttf_board_set sets[TTF_DAEMON_SETS_MAX];
    char serial[64];
    struct ttf_io *io;
    struct ttf_clock *clock;
    struct ttf_host_time
        *host_time; /* what a PC says, for this clock and those of the box's devices */
    struct manager manager;
    struct box_host host;
    struct box_lock lock;

    /* of the thread that owns the devices */
    struct run run;
    int64_t captured, told_ns;          /* of this run */
    struct absence absence;             /* why there are no records */
    char calibration[CALIBRATION_PATH]; /* that it is developed with */
    int64_t wanted;      /* the generation of the order that is run, since run.wanted_ns */
    int64_t wait_ns;     /* before what failed is tried again */
    struct ttf_box view; /* kept open for a while between pictures; n_cameras 0: not */
    int64_t viewed_ns;
    volatile int
        view_stop; /* atomically: not 0: a run wants the devices, no picture does any more */

    pthread_mutex_t plans; /* over their files: one change at a time */
    pthread_mutex_t
        starting; /* held while a start is checked: one at a time, nobody waits for it */

    /* of all threads; each has its own lock, or needs none */
    struct ttf_gate *wake; /* the owner's */
    struct mailbox *mailbox;
    struct orders *orders;
    struct situation *situation;
    struct asks *asks;
    struct workshop *workshop;
    struct shadow *shadow;
    struct calibrations *calibrations;
    struct ttf_http_events *events;
    struct keeper *keeper;
    char token[65];
};

bool daemon_told_to_end(const struct daemon *d);

/* The writer's text as an event, to whoever listens; json is freed. */
void daemon_publish(struct daemon *d, const char *kind, struct ttf_json *json);

/* Tells whoever listens what the box does now. */
void daemon_tell_state(struct daemon *d);

/* The text of a writer that is done with, as whoever asks by HTTP gets it: by malloc. -ENOMEM; json is freed. */
TTF_MUST_USE int daemon_give(struct ttf_json *json, char **ret, struct ttf_err *err);

/* Of a decision that the disk did not take (r): it holds here, the keeper brings it there, and this says so. */
void daemon_decided(int r, const struct ttf_err *err);

/* What the box does, and, where it is something else than before, that it does. */
void daemon_does(struct daemon *d, enum doing doing, const char *why, int64_t retry_ns);

#endif
