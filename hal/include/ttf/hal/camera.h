/* SPDX-License-Identifier: Apache-2.0 */
/*
 * camera.h: one camera, as capture sees it.
 *
 * Life:    (board makes it) -> configure -> start -> { submit -> next x n ->
 *          release x n }* -> stop -> destroy. configure again needs stop first.
 * Sets:    a set of 1..TTF_CAMERA_SET_MAX settings (a bracket, an average) is
 *          submitted at once; its buffers come one after another through next,
 *          in the set's order. One set is under way at a time.
 * Buffers: belong to the camera; caps.buffers of them may be held unreleased;
 *          with none free the camera does not deliver (next times out).
 * Threads: one thread submits and calls next; release may come from any thread.
 *          Nothing else is thread-safe.
 * Time:    waits go through the box's clock.
 */
#ifndef TTF_HAL_CAMERA_H
#define TTF_HAL_CAMERA_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/base/frame.h"

#define TTF_CAMERA_SET_MAX 64

struct ttf_camera;

/*
 * What a camera can do; constant after configure. 0 in a max means: no such control; where that is the exposure, it
 * is the camera's own and the time of each frame is not known.
 */
struct ttf_camera_caps {
    char model[64];
    int64_t exposure_min_ns, exposure_max_ns;
    uint32_t gain_min_milli, gain_max_milli;
    bool has_white_balance; /* the camera itself applies white balance */
    bool has_lens;
    /*
     * A lens that has a control, but no unit, so that no plan moves it: it is held where it stood on configure, after
     * recover, too. lens_code: where, the driver's own number.
     */
    bool lens_held;
    int64_t lens_code;
    bool steerable; /* the middle of the first exposure can be placed (frame duration or trigger) */
    /*
     * Bound on abs(middle of the first exposure - the middle asked for): of
     * jitter if steerable, else half a frame period and jitter.
     */
    int64_t timing_bound_ns;
    int64_t frame_period_ns; /* of the free-running sensor at the shortest exposures */
    unsigned lead_frames;    /* control delay, in frames: settings take effect so many later */
    /*
     * Submit at least this long before the middle wanted; for exposures longer
     * than a frame period, half the exposure more.
     */
    int64_t lead_ns;
    /* Of cameras whose frames become longer with the exposure: so many times what it is longer than a frame period. */
    unsigned long_frames;
    unsigned buffers; /* frames that may be held at once, >= 2 */
    bool simulated;
};

/* What configure asks for. 0 means: the camera's native value. */
struct ttf_camera_mode {
    uint32_t width, height; /* pixels of the whole frame */
    enum ttf_packing packing;
};

/* One set of exposures. */
struct ttf_camera_set {
    const struct ttf_exposure *settings; /* n of them, copied by submit */
    unsigned n;                          /* 1..TTF_CAMERA_SET_MAX */
    /*
     * Where the middle of the first exposure should fall on the boot clock;
     * 0: as soon as the camera can. A middle that is too near or past is taken
     * as soon as possible. The others follow as fast as the camera can.
     */
    int64_t middle_ns;
};

/* How hard to try to bring back a camera that does not deliver; each step includes the milder ones. */
enum ttf_camera_recovery {
    TTF_CAMERA_REQUEUE = 0, /* give all buffers back to the driver */
    TTF_CAMERA_RESTART,     /* stop and start the stream */
    TTF_CAMERA_REOPEN,      /* close the device, open and configure it anew */
    TTF_CAMERA_RECOVERY_COUNT
};

/* "requeue", "restart", "reopen". */
const char *ttf_camera_recovery_name(enum ttf_camera_recovery step);

/*
 * Negotiates. On success *ret_granted is the format frames will have, which may
 * differ from what was asked: check it. -EINVAL for a mode that cannot be had at
 * all, -EBUSY while streaming, -ENODEV if the camera is gone.
 */
TTF_MUST_USE int ttf_camera_configure(struct ttf_camera *camera, const struct ttf_camera_mode *mode,
                                      struct ttf_frame_format *ret_granted, struct ttf_err *err);

/* Valid after configure; belongs to the camera. */
const struct ttf_camera_caps *ttf_camera_caps(const struct ttf_camera *camera);

/* What frames will look like, as granted; NULL before configure. Belongs to the camera. */
const struct ttf_frame_format *ttf_camera_format(const struct ttf_camera *camera);

/* Starts streaming. -EINVAL before configure; -EALREADY when streaming. */
TTF_MUST_USE int ttf_camera_start(struct ttf_camera *camera, struct ttf_err *err);

/* Stops; a set under way is dropped, held frames become invalid. Harmless when stopped. */
void ttf_camera_stop(struct ttf_camera *camera);

/*
 * Submits a set. The driver may alter each setting to what it can do: what it
 * made of them is in the frames' `settings`. -EINVAL for n out of range or an
 * exposure <= 0 (0 is allowed of a camera without that control); -EBUSY while a set is under way; -EPIPE when not streaming;
 * -ENODEV when gone.
 */
TTF_MUST_USE int ttf_camera_submit(struct ttf_camera *camera, const struct ttf_camera_set *set,
                                   struct ttf_err *err);

/*
 * Waits for the next buffer of the set until deadline_ns. 0 and *ret_frame (to
 * be released), also for a bad buffer: look at its flags and bytes. A buffer the
 * driver lost is skipped, its set_index never comes. -ETIMEDOUT at the deadline;
 * -ENODATA if no set is under way or all its buffers came; -EIO for a stream
 * that failed; -ENODEV when gone.
 */
TTF_MUST_USE int ttf_camera_next(struct ttf_camera *camera, int64_t deadline_ns,
                                 struct ttf_frame **ret_frame, struct ttf_err *err);

/* Gives a buffer back. NULL allowed. */
void ttf_camera_release(struct ttf_camera *camera, struct ttf_frame *frame);

/* Drops the set under way (if any). Then submit may be called again. */
void ttf_camera_cancel(struct ttf_camera *camera);

/* Tries one step of the ladder; 0 if the camera streams again as configured. Held frames become invalid. */
TTF_MUST_USE int ttf_camera_recover(struct ttf_camera *camera, enum ttf_camera_recovery step,
                                    struct ttf_err *err);

/* Stops if need be and frees. NULL allowed. */
void ttf_camera_destroy(struct ttf_camera *camera);

#endif
