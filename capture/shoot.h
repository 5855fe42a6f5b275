/* SPDX-License-Identifier: Apache-2.0 */
/*
 * shoot.h: one image from the camera: a set of equal exposures, checked frame by
 * frame, added up; what to do when frames are wrong or do not come. Loop thread only.
 */
#ifndef TTF_CAPTURE_PRIVATE_SHOOT_H
#define TTF_CAPTURE_PRIVATE_SHOOT_H

#include "image_flags.h"
#include "pulse.h"
#include "ttf/dataset/calibration.h"

/* A camera with what must be remembered of it from slot to slot. */
struct ttf_shooter {
    struct ttf_camera *camera;
    char name[32];
    struct ttf_frame_format format;
    struct ttf_pulse *pulse;
    struct ttf_events *events;
    bool down;    /* the last slot was given up: it needs reviving */
    bool revived; /* it was since, and waits for a slot to show what it gives */
    enum ttf_camera_recovery next_step;
    uint64_t recoveries;
    struct ttf_err said; /* why it gave no frame, the last time that it gave none */
};

/* Settings after the lock procedure: `granted` is what every frame must carry. */
struct ttf_locked {
    struct ttf_exposure asked, granted;
};

/* Sets of up to `average` exposures that one image can come to: two, and one for each step of the ladder. */
#define TTF_SHOOT_TRIES (2 + TTF_CAMERA_RECOVERY_COUNT)

/* One image to take. */
struct ttf_take {
    const struct ttf_locked *locked;
    unsigned average;
    int64_t middle_ns;  /* of the first exposure; 0: as soon as can be */
    int64_t give_up_ns; /* no new try after this */
    int64_t settle_ns;  /* of lamps; lit for less: flagged */
    struct ttf_raw_sum *raw;
    struct ttf_image *image; /* its shots, n_averaged, lacking and flags are filled */
    unsigned shots_room;     /* places in image->shots, the caller's: TTF_SHOOT_TRIES x average */
    /* results */
    int64_t start_ns; /* of the first accepted frame; TTF_NS_UNKNOWN */
    int64_t middle_got_ns;
    bool trouble; /* something was retried, flagged or lacking */
};

/*
 * Takes it, with one new try for bad frames and the ladder for none. 0 also when
 * the image is lacking (image->lacking says why); negative only from the pulse
 * (power, storage). Allocates nothing.
 */
TTF_MUST_USE int ttf_shoot(struct ttf_shooter *shooter, struct ttf_take *take);

/* Brings a camera back that the last slot gave up. Takes its time: for idle moments. As ttf_shoot. */
TTF_MUST_USE int ttf_shooter_revive(struct ttf_shooter *shooter);

/*
 * The lock procedure: asks, reads back, asks for what was granted, until both
 * agree. -EIO: they never do; -ENODEV: no frame after the whole ladder; or as beat.
 */
TTF_MUST_USE int ttf_shooter_lock(struct ttf_shooter *shooter, const struct ttf_exposure *asked,
                                  struct ttf_locked *ret, struct ttf_err *err);

#endif
