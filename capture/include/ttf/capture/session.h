/* SPDX-License-Identifier: Apache-2.0 */
/*
 * session.h: the loop that turns due slots into committed frames.
 *
 * One session = one run of a plan on a box into a dataset: new, or gone on with.
 * It joins the box's clock for the calling thread (which must not have joined),
 * creates its own committing thread and returns when the plan is done, stopped, or cannot go on.
 * It configures and starts the cameras itself. Everything that is not lasting ends as a record or an
 * event, never as the end of the run.
 */
#ifndef TTF_CAPTURE_SESSION_H
#define TTF_CAPTURE_SESSION_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/capture/control.h"
#include "ttf/capture/plan.h"
#include "ttf/dataset/io.h"
#include "ttf/hal/box.h"

/* What a watcher is told, from the session's threads (serialised). */
enum ttf_progress_kind {
    TTF_PROGRESS_ARMED = 0, /* exposure locked, first slot waits */
    TTF_PROGRESS_SLOT,      /* a slot's record is committed */
    TTF_PROGRESS_EVENT,     /* a line for events.jsonl, written or waiting for the storage */
    TTF_PROGRESS_ALARM,     /* a person is needed: the storage has failed (the run goes on in the
                               second one, or ends), has less room than the reserve, takes no images,
                               or its file system has found errors in itself */
    TTF_PROGRESS_ALARM_OVER /* what an alarm of this text told is over; also where none was told */
};

/* Until when an alarm stands. */
enum ttf_alarm_until {
    TTF_ALARM_UNTIL_OVER = 0, /* it is told to be over, of whatever run */
    TTF_ALARM_UNTIL_ARMED,    /* the run ended with it: a run is armed again, or this one is done */
    TTF_ALARM_UNTIL_NEW       /* another run is armed */
};

struct ttf_progress {
    enum ttf_progress_kind kind;
    enum ttf_alarm_until until; /* of an alarm */
    int64_t index, total;       /* slots that the run comes to, as is known by now */
    bool waits;                 /* armed: for the plan's start, which is still to come */
    int64_t lit_ns, settled_ns; /* armed: from when until when lamps that burn all the time settle,
                                   boot clock; 0: none do */
    int result;                 /* enum ttf_result of a slot */
    const char *text;           /* reason or event; valid during the call */
    int64_t now_ns;             /* boot clock */
    int64_t error_ns;           /* achieved middle - due; TTF_NS_UNKNOWN */
    int64_t wakeup_ns;          /* how late the loop woke for this slot; TTF_NS_UNKNOWN */
};

typedef void ttf_progress_fn(void *ctx, const struct ttf_progress *progress);

#define TTF_ABSENCE_STOPS 16

/* Why slots have no records, on this boot's clock. What it does not say is a program that was not running. */
struct ttf_absence {
    unsigned n_stops;
    struct ttf_absence_stop {
        int64_t from_ns, until_ns;
    } stops[TTF_ABSENCE_STOPS]; /* a person had stopped it; the oldest first */
    int64_t trying_since_ns; /* the program was there, and the run could not go on; 0: it was not */
};

struct ttf_session_config {
    struct ttf_box *box;            /* borrowed */
    struct ttf_io *io;              /* borrowed */
    const char *path;               /* of the dataset */
    const struct ttf_plan *plan;    /* borrowed, checked */
    const char *plan_yaml;          /* as given, for plans/N.yaml; NULL allowed */
    const char *calibration_folder; /* NULL: none */
    unsigned threads;               /* of the tile pool; 0: all */
    ttf_progress_fn *progress;      /* NULL allowed */
    void *progress_ctx;
    /* becomes non-zero (signal handler, or atomically from a thread): end cleanly within a slot; NULL allowed */
    const volatile int *stop;
    struct ttf_control *control; /* what people ask meanwhile; borrowed, NULL allowed */
    /* A plan that the dataset has moved on from is gone back to, as a change, instead of left alone. */
    bool plan_as_given;
    /* Of a run that is gone on with: what its watcher knows of the time that has no records; zeroed: nothing. */
    struct ttf_absence absence;
    int64_t rehearse;      /* > 0: so many slots at once, nothing sealed, figures in the result */
    bool skip_speed_check; /* of the disk's write speed */
};

struct ttf_session_result {
    int64_t slots, captured, partial, missed, failed, paused, power; /* of the whole dataset */
    int64_t error_p99_ns, error_max_ns;   /* abs(middle - due) of this run's captured slots */
    int64_t wakeup_p99_ns, wakeup_max_ns; /* of the loop's waking */
    bool resumed, sealed;
    bool
        second_storage; /* it ended in the plan's second storage: counts and digest are of the dataset there */
    int64_t total; /* slots of the plan in force at the end */
    /* The plan given is plans/N of the dataset, which has moved on from it, so that it was left alone; -1: no. */
    int moved_on_from;
    char digest[65];
    /* rehearsal */
    int64_t busy_ns;       /* per slot, from the first lamp command to the commit */
    double headroom_stops; /* between the brightest and saturation */
    double sharpness;
    double
        settle_change; /* relative change of level between the first and the last slot's reference */
    int64_t slot_bytes;
    int64_t
        sustained_interval_ns; /* shortest interval that exposing and committing can keep up with */
};

/*
 * Where the dataset of a run into `path` is gone on with: there, or in the plan's second storage. -EEXIST: what lies in
 * the second storage is not of this run.
 */
TTF_MUST_USE int ttf_session_find(struct ttf_io *io, const char *path, const struct ttf_plan *plan,
                                  char *ret, size_t size, struct ttf_err *err);

/*
 * Runs. 0 when the plan is done (sealed) or a stop was asked for (not sealed).
 * -EINVAL: the plan does not fit the box or the dataset. -EBUSY: dataset in use.
 * -ENOSPC, -EROFS, -EIO: storage gave out (all committed slots are safe); -EIO also: at arming the
 * camera granted other settings each time it was asked.
 * -ESTALE: another folder lies where the dataset did (a disk was mounted over it): run again, and what lies there is gone on with.
 * -ENODEV: no camera after the whole ladder at arming. -ESHUTDOWN: the (simulated) box lost power; run
 * again to resume. -TTF_EDAMAGED: the dataset is damaged.
 */
TTF_MUST_USE int ttf_session_run(const struct ttf_session_config *config,
                                 struct ttf_session_result *ret, struct ttf_err *err);

#endif
