/* SPDX-License-Identifier: Apache-2.0 */
/* device.h: the camera's own state, shared by the files of hal/libcamera. Private to it. */
#ifndef TTF_HAL_LIBCAMERA_DEVICE_H
#define TTF_HAL_LIBCAMERA_DEVICE_H

#include <pthread.h>

#include "boundary.h"
#include "pixels.h"
#include "steer.h"
#include "system.h"
#include "ttf/hal/camera_backend.h"

#define LC_BUFFERS_MAX 16

/* Requests that stay with libcamera while the caller holds all it may, so that the stream goes on. */
#define LC_BUFFERS_SPARE 2

enum lc_place {
    LC_OURS = 0, /* neither with libcamera nor in the caller's hands */
    LC_QUEUED,
    LC_HELD
};

struct lc_slot {
    const void *at;
    size_t length;
    enum lc_place place;
    uint64_t number;     /* of its request, as steering counts */
    uint64_t generation; /* of the settings that it carried */
    struct ttf_frame frame;
};

/* A request that came back, with its time on the boot clock. */
struct lc_arrival {
    unsigned index;
    size_t bytes;
    uint32_t sequence; /* never falls or stays between two of a stream */
    uint32_t lost;     /* frames between the one before and this */
    bool error;
    bool stamped;
    bool of_end; /* the stamp is of the frame's end */
    int64_t stamp_ns, came_ns;
    uint64_t number, generation;
    struct lc_settings told;
};

struct lc_stream {
    pthread_mutex_t
        lock; /* of places, the number held, and what requests carry: release comes from any thread */
    struct lc_slot slot[LC_BUFFERS_MAX];
    unsigned n, held;
    bool on;
    int broken;               /* negative errno of a request that could not be queued */
    struct lc_settings carry; /* what the next request asks for, but for its duration */
    uint64_t generation;      /* grows with each change of carry */
    int64_t floor_ns;         /* no frame of these settings is shorter */
    struct lc_steer steer;
    bool seen; /* last_sequence means something */
    uint32_t last_sequence;
    int64_t offset_ns, uncertainty_ns; /* of the monotonic clock */
    bool stamped;                      /* the last arrival was */
    bool slept;                        /* the machine was suspended since the last arrival */
};

/* What was asked, and what was told of it. */
struct lc_pair {
    struct ttf_exposure told, asked;
};

#define LC_PAIRS 64

/* Whether frames show the settings wanted. */
struct lc_settle {
    struct ttf_exposure wanted; /* by the caller, what cannot be set 0 */
    struct ttf_exposure
        asked; /* of the driver: wanted, or what led to it before, or a digit more */
    bool set;  /* something is wanted */
    bool settling, nudged;
    bool told_any;
    unsigned frames, alike;   /* since they count; of these, told the same one after another */
    struct ttf_exposure told; /* of the last frame that counts */
    struct lc_pair pair[LC_PAIRS];
    unsigned n_pairs, next_pair;
};

/* The set under way. */
struct lc_set {
    struct ttf_exposure asked[TTF_CAMERA_SET_MAX];
    unsigned n, next;
    int64_t middle_ns;
    int64_t fresh_ns;  /* exposures that began before this are none of the set */
    bool placed;       /* a frame of the set has come: the others follow it one by one */
    bool watched;      /* a frame before the one wanted was seen: what is lost now is the set's */
    bool starved;      /* the caller held all buffers: what was lost meanwhile is nobody's loss */
    uint32_t expected; /* sequence of set.next, if placed */
    bool lost;         /* of the set, before the next one that comes */
};

/* What was found of controls; trial.c takes from it what does not hold. */
struct lc_abilities {
    struct lc_limits limits;
    struct lc_settings fixed; /* carried by each request */
    unsigned has, mapped;     /* as in struct ttf_libcamera_info */
    unsigned automatics_off;
    bool lens_told;
};

struct lc_camera {
    struct ttf_camera base; /* first: downcast by address */
    struct ttf_libcamera_config config;
    struct ttf_clock *clock;
    struct lc_system system;
    struct lc_handle *handle; /* NULL: gone */
    bool begun;
    struct lc_identity id;
    struct ttf_camera_mode mode; /* as last asked for */
    const struct lc_pixels *pixels;
    size_t frame_bytes; /* of a whole frame */
    int64_t period_ns, readout_ns;
    int64_t
        uneven_ns; /* by how much the longest interval of the trial was longer than a period; one at most */
    struct lc_abilities can;
    struct ttf_gate *freed;
    struct lc_stream stream;
    struct lc_settle settle;
    struct lc_set set;
};

static inline const struct lc_ops *lc_ops(const struct lc_camera *camera)
{
    return camera->system.ops;
}

/* ---- find.c ---- */

/* Looks for the camera and holds it; again: the very one that it was. */
int lc_find(struct lc_camera *camera, bool again, struct ttf_err *err);
/* Gives it up; its buffers are gone. Harmless if it is not held. */
void lc_let_go(struct lc_camera *camera);

/* ---- choose.c ---- */

/* What to ask for: camera->pixels; *ret: the offer whose size is taken where none is asked. */
int lc_choose(struct lc_camera *camera, struct lc_offer *ret, struct ttf_err *err);
/* How many bits of a granted word of 16 are the sensor's, its upper ones. */
unsigned lc_sensor_bits(struct lc_camera *camera, const struct lc_granted *granted);

/* ---- negotiate.c ---- */

/* Format, buffers, base.format, frame_bytes. As ttf_camera_configure. */
int lc_negotiate(struct lc_camera *camera, struct ttf_err *err);

/* ---- controls.c ---- */

/* What there is of a configured camera; switches off what is automatic, in what requests carry. */
int lc_controls_find(struct lc_camera *camera, struct ttf_err *err);
/* One that turned out not to hold: fixed at its least, or at 1, from now on. */
void lc_controls_unmap(struct lc_abilities *can, unsigned which);
void lc_controls_caps(const struct lc_abilities *can, struct ttf_camera_caps *caps);
/* Settings with 0 for what cannot be set. */
struct ttf_exposure lc_controls_settable(const struct lc_abilities *can,
                                         const struct ttf_exposure *asked);
/* What a request carries for them. */
struct lc_settings lc_controls_request(const struct lc_abilities *can,
                                       const struct ttf_exposure *asked);
/* What a frame tells; false: it does not tell one that it should. asked: for a lens that does not tell. */
bool lc_controls_told(const struct lc_abilities *can, const struct lc_settings *told,
                      const struct ttf_exposure *asked, struct ttf_exposure *ret);
/* Pixels that were multiplied after they were taken are not what exposure and gain say. */
bool lc_controls_multiplied(const struct lc_camera *camera, const struct lc_settings *told);

/* ---- stream.c ---- */

/* All buffers queued, the stream on. */
int lc_stream_start(struct lc_camera *camera, struct ttf_err *err);
void lc_stream_stop(struct lc_camera *camera);
/* From the next request on. */
void lc_stream_carry(struct lc_camera *camera, const struct ttf_exposure *asked);
void lc_stream_aim(struct lc_camera *camera, int64_t middle_ns); /* 0: at nothing */
/* The next arrival; its buffer is ours. -ETIMEDOUT, -EIO, -ENODEV. */
int lc_stream_take(struct lc_camera *camera, int64_t deadline_ns, struct lc_arrival *ret,
                   struct ttf_err *err);
/* From the beginning of the first row's exposure to the end of the last's, on the boot clock. */
void lc_arrival_span(const struct lc_camera *camera, const struct lc_arrival *arrival,
                     int64_t exposure_ns, int64_t *ret_start, int64_t *ret_end);
/* Tells steering where it was. */
void lc_stream_seen(struct lc_camera *camera, const struct lc_arrival *arrival, int64_t middle_ns);
/* An arrival goes back with what requests carry now. */
int lc_stream_give(struct lc_camera *camera, unsigned index, struct ttf_err *err);
/* Its slot is in the caller's hands from now on. */
struct ttf_frame *lc_stream_hold(struct lc_camera *camera, unsigned index);
void lc_stream_release(struct lc_camera *camera, struct ttf_frame *frame);
/* Until the caller holds fewer than it may. 1 if there was a wait, 0; -ETIMEDOUT. */
int lc_stream_await_room(struct lc_camera *camera, int64_t deadline_ns);

/* ---- settle.c ---- */

enum lc_shown {
    LC_SHOWN_NO = 0, /* a frame of before, or under way to it */
    LC_SHOWN_YES,
    LC_SHOWN_NEVER /* it does not come to rest */
};

/* Settings that the coming frames are to show. */
void lc_settle_want(struct lc_camera *camera, const struct ttf_exposure *wanted);
/* Whatever was wanted has to be shown anew: after a start. */
void lc_settle_again(struct lc_camera *camera);
/* told: of this arrival, by lc_controls_told. May ask for a digit more. */
enum lc_shown lc_settle_shown(struct lc_camera *camera, const struct lc_arrival *arrival,
                              const struct ttf_exposure *told);

/* ---- trial.c ---- */

/* Streams for a moment and looks what holds: period_ns, can. The stream is off afterwards. */
int lc_trial(struct lc_camera *camera, struct ttf_err *err);

/* ---- set.c ---- */

int lc_set_begin(struct lc_camera *camera, const struct ttf_camera_set *begun, struct ttf_err *err);
int lc_set_next(struct lc_camera *camera, int64_t deadline_ns, struct ttf_frame **ret_frame,
                struct ttf_err *err);

#endif
