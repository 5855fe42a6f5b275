/* SPDX-License-Identifier: Apache-2.0 */
/* session_private.h: what a run holds. Loop thread, but for what commit.h says is the committer's. */
#ifndef TTF_CAPTURE_PRIVATE_SESSION_H
#define TTF_CAPTURE_PRIVATE_SESSION_H

#include "commit.h"
#include "lamp_programme.h"
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
    struct ttf_resume resume;
    int segment;              /* number of the current one */
    int64_t lead_ns;          /* of a slot: first lamp command to due */
    int64_t first_settle_ns;  /* before the first slot's lead: lamps that settle once */
    int64_t lamps_changed_ns; /* the last command that changed a level */
    bool sensor_silent[TTF_SENSORS_MAX];
    bool trouble; /* in the last slot: the warning light */
};

/* ---- session_dataset.c: the dataset to write to ---- */

/* Opens or makes the dataset, resolves the grid, and writes the new segment's line. */
TTF_MUST_USE int ttf_session_open_dataset(struct ttf_session *s, struct ttf_err *err);

/* Refuses a new run that its disk cannot hold. */
TTF_MUST_USE int ttf_session_check_disk(struct ttf_session *s, struct ttf_err *err);

/* ---- slot.c ---- */

/*
 * One slot, from the idle time before it on: exactly one record is handed over.
 * 0; -ECANCELED: a stop was wanted before it began (no record); or as beat.
 */
TTF_MUST_USE int ttf_session_slot(struct ttf_session *s, int64_t index);

/* Hands over a record without images. */
TTF_MUST_USE int ttf_session_no_slot(struct ttf_session *s, int64_t index, enum ttf_result result,
                                     const char *reason);

#endif
