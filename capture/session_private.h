/* SPDX-License-Identifier: Apache-2.0 */
/* session_private.h: what a run holds. Loop thread, but for what commit.h says is the committer's. */
#ifndef TTF_CAPTURE_PRIVATE_SESSION_H
#define TTF_CAPTURE_PRIVATE_SESSION_H

#include "climate_watch.h"
#include "commit.h"
#include "group.h"
#include "lamp_programme.h"
#include "plan_end.h"
#include "resume.h"
#include "schedule.h"
#include "shoot.h"
#include "ttf/capture/session.h"
#include "ttf/dataset/pool.h"

struct ttf_session {
    const struct ttf_session_config *config;
    struct ttf_box *box;
    struct ttf_plan plan; /* phase resolved, shortened for a rehearsal */
    struct ttf_plan_figures figures;

    struct ttf_queue queue;
    struct ttf_events events;
    struct ttf_lamp_driver lamps;
    struct ttf_pulse pulse;
    struct ttf_committer committer;
    struct ttf_rehearsal rehearsal;

    unsigned n_cameras; /* those the plan uses */
    struct ttf_shooter cameras[TTF_BOX_CAMERAS_MAX];
    struct ttf_darkroom rooms[TTF_BOX_CAMERAS_MAX];
    unsigned camera_of[TTF_PLAN_SHOTS_MAX];
    struct ttf_locked locked[TTF_PLAN_SHOTS_MAX][TTF_PLAN_BRACKETS_MAX];

    struct ttf_calibration calibration;
    bool has_calibration;
    struct ttf_pool *pool;

    struct ttf_lamp_programme programme;
    struct ttf_grid grid;
    struct ttf_grid grid_before; /* that the slot before grid.first_index is of */
    struct ttf_resume resume;
    struct ttf_run_clock run; /* the run's own time */
    struct ttf_run_past past; /* what its segments before said */
    bool goes_on;             /* known_plan is the one of the last segment */
    int known_plan;    /* the dataset has this plan already, by this number; -1: it is new to it */
    int moved_on_from; /* the plan that was given is this one, but another has come since; -1: no */
    bool names_group;  /* it names the group (or none) as one of the dataset's plans does */
    int next_plan;     /* number of the next one that changes it */
    /* that the plan names, of a new dataset or for a plan that is new to one; empty: none, or nobody has to know */
    struct ttf_group group;
    char path[4096];  /* of the dataset: as configured, or in the second storage */
    int first_code;   /* why, if from_first */
    bool from_first;  /* the second dataset is begun by reading the first */
    char *given_yaml; /* of the plan in force, as given; owned; NULL: not known */
    bool paused;
    char pause_reason[120];
    int segment;              /* number of the current one */
    int64_t lead_ns;          /* of a slot: first lamp command to due */
    int64_t first_settle_ns;  /* before the first slot's lead: lamps that settle once */
    int64_t lamps_changed_ns; /* the last command that changed a level */
    bool sensor_silent[TTF_SENSORS_MAX];
    struct ttf_climate_watch climate;
    bool trouble; /* in the last slot: the warning light */
};

/* ---- session_dataset.c: the dataset to write to ---- */

/* Opens or makes the dataset, resolves the grid, and writes the new segment's line. */
TTF_MUST_USE int ttf_session_open_dataset(struct ttf_session *s, struct ttf_err *err);

/* Refuses a new run that its disk cannot hold, or whose group is not there. */
TTF_MUST_USE int ttf_session_check_disk(struct ttf_session *s, struct ttf_err *err);

/* ---- session_tell.c: what a run says of itself ---- */

/* An event if the exposure that was granted is far off the one asked for: lamp ripple may show. */
void ttf_session_tell_exposure(struct ttf_session *s, int64_t asked_ns, int64_t granted_ns);

/* With the committer running: which plan, where on the grid, in which box; and that all is armed. */
void ttf_session_tell_beginning(struct ttf_session *s);

/* Counts and figures; sealed and digest are not its. */
void ttf_session_fill_result(const struct ttf_session *s, struct ttf_session_result *ret);

/* Sees to it that err (NULL: not wanted) says why the run ended with r < 0: what the committer met, or at least that it did. */
void ttf_session_say_why(const struct ttf_session *s, int r, struct ttf_err *err);

/* ---- slot.c ---- */

/*
 * One slot, from the idle time before it on: exactly one record is handed over.
 * 0; -ECANCELED: a stop was wanted before it began (no record); or as beat.
 */
TTF_MUST_USE int ttf_session_slot(struct ttf_session *s, int64_t index);

/* Hands over a record without images. */
TTF_MUST_USE int ttf_session_no_slot(struct ttf_session *s, int64_t index, enum ttf_result result,
                                     const char *reason);

/* Hands over a change of plan, in its turn among the records; takes ownership. -ENOMEM: nothing has happened. */
TTF_MUST_USE int ttf_session_hand_over_change(struct ttf_session *s,
                                              struct ttf_plan_change *change);

/* ---- session_plan.c: which plan is in force ---- */

/*
 * Before anything is set up: of a dataset that is there, compares the plan given with those it has. s->plan
 * becomes the one in force (README.md, "Living runs"); known_plan, moved_on_from, names_group.
 */
TTF_MUST_USE int ttf_session_plan_in_force(struct ttf_session *s, struct ttf_err *err);

/*
 * A day that begins at a local time becomes a phase since slot 0, by the UTC of slot 0.
 * TTF_NS_UNKNOWN: -EINVAL.
 */
TTF_MUST_USE int ttf_session_resolve_phase(struct ttf_plan *plan, int64_t slot0_utc_ns,
                                           struct ttf_err *err);

/* ---- session_end.c: how many slots there are ---- */

/* Whether slot `index` is to be, by the clock as it is now: one that was corrected may move the plan's end. */
bool ttf_session_has_slot(struct ttf_session *s, int64_t index);

/* Why a run that is complete has ended: what the dataset's "end" line says. */
const char *ttf_session_end_reason(const struct ttf_session *s);

/* ---- session_asks.c: what people ask meanwhile ---- */

/*
 * Hears all that is due with slot `index` the next: the plan, the grid and the pause may be others
 * afterwards. 0; -ECANCELED: to stop; -ENOMEM never: what finds no memory is refused.
 */
TTF_MUST_USE int ttf_session_hear(struct ttf_session *s, int64_t index);

#endif
