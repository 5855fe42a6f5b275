/* SPDX-License-Identifier: Apache-2.0 */
/* device.h: the camera's own state, shared by the files of hal/v4l2. Private to it. */
#ifndef TTF_HAL_V4L2_DEVICE_H
#define TTF_HAL_V4L2_DEVICE_H

#include <linux/videodev2.h>
#include <pthread.h>

#include "controls.h"
#include "find.h"
#include "formats.h"
#include "sys.h"
#include "ttf/hal/camera_backend.h"

#define V4L2_BUFFERS_MAX 32

/* Frames the driver keeps to itself while the caller holds all it may, so that the stream goes on. */
#define V4L2_BUFFERS_SPARE 2

enum v4l2_buffer_place {
    V4L2_BUFFER_OURS = 0, /* neither in the driver nor in the caller's hands */
    V4L2_BUFFER_QUEUED,
    V4L2_BUFFER_HELD
};

struct v4l2_slot {
    void *at;
    size_t length;
    enum v4l2_buffer_place place;
    struct ttf_frame frame;
};

/* What of a frame a driver's time is of. */
enum v4l2_stamp {
    V4L2_STAMP_NONE = 0, /* none: when it came */
    V4L2_STAMP_END,      /* the last row was read */
    V4L2_STAMP_READOUT,  /* the first row was read: what UVC drivers stamp, whatever they call it */
    V4L2_STAMP_EXPOSURE  /* the first row's exposure began */
};

/* What came out of the driver, with its time on the boot clock. */
struct v4l2_arrival {
    unsigned index;
    size_t bytes;
    uint32_t sequence; /* never falls or stays between two of a stream */
    uint32_t lost;     /* frames between the one before and this */
    bool error;
    enum v4l2_stamp stamp;
    int64_t stamp_ns, came_ns; /* came: taken out of the driver, never later than its end */
};

struct v4l2_stream {
    pthread_mutex_t lock; /* of places and the number held: release comes from any thread */
    struct v4l2_slot slot[V4L2_BUFFERS_MAX];
    unsigned n, held;
    bool on;
    int broken; /* negative errno of a buffer that could not be given back */
    bool seen;  /* last_sequence means something */
    uint32_t last_sequence;
    int64_t offset_ns, uncertainty_ns; /* of the driver's clock */
    bool stamped;                      /* the last arrival had a driver's time */
    bool slept;                        /* the machine was suspended since the last arrival */
};

/* The set under way. */
struct v4l2_set {
    struct ttf_exposure asked[TTF_CAMERA_SET_MAX];
    unsigned n, next;
    int64_t middle_ns;
    int64_t fresh_ns;    /* exposures that began before this are none of the set */
    bool settling;       /* settings were changed: frames are passed over until settled */
    bool counting;       /* the frame from which they are counted has come */
    uint32_t settled_at; /* sequence */
    bool placed;         /* a frame of the set has come: the others follow it one by one */
    bool watched;        /* a frame before the one wanted was seen: what is lost now is the set's */
    bool starved;        /* the caller held all buffers: what was lost meanwhile is nobody's loss */
    uint32_t expected;   /* sequence of set.next, if placed */
    bool lost;           /* of the set, before the next one that comes */
};

/* What moves the stream's frames in time. */
enum v4l2_steer_by {
    V4L2_STEER_NONE = 0,
    V4L2_STEER_BLANK, /* lines of blanking below the picture: any duration in steps of a line */
    V4L2_STEER_RATE   /* another rate, where it is taken while the stream is on */
};

struct v4l2_steer {
    enum v4l2_steer_by by;
    int64_t line_ns, blank, blank_max; /* blank: as it is else */
    bool moving;                       /* frames have another duration ... */
    uint32_t moved_at;                 /* ... until this sequence */
    bool settling;                     /* the last move may not show yet ... */
    uint32_t settled_at;               /* ... before this sequence */
};

struct v4l2_camera {
    struct ttf_camera base; /* first: downcast by address */
    struct ttf_v4l2_config config;
    struct ttf_clock *clock;
    const struct v4l2_sys *sys;
    void *ctx;
    int fd; /* -1: gone */
    struct v4l2_identity id;
    struct ttf_camera_mode mode; /* as last asked for */
    const struct v4l2_pixels *pixels;
    size_t frame_bytes; /* of a whole frame */
    int64_t period_ns;
    bool rate_settable; /* the driver says that its rate can be set */
    struct v4l2_controls controls;
    struct v4l2_steer steer;
    struct ttf_exposure asked; /* of the driver, last */
    bool asked_any;
    bool asked_twice; /* the same settings were asked for anew */
    bool held;        /* it has told them as they were asked for */
    bool astray;      /* it tells other ones: set up anew with the next set */
    struct ttf_gate *freed;
    struct v4l2_stream stream;
    struct v4l2_set set;
};

static inline int v4l2_ioctl(struct v4l2_camera *camera, unsigned long request, void *arg)
{
    return camera->fd < 0 ? -ENODEV : camera->sys->ioctl(camera->ctx, camera->fd, request, arg);
}

/* ---- negotiate.c ---- */

/* Format, frame rate, base.format, period_ns, frame_bytes. As ttf_camera_configure. */
int v4l2_negotiate(struct v4l2_camera *camera, const struct ttf_camera_mode *mode,
                   struct ttf_err *err);

/* ---- stream.c ---- */

/* Buffers, all of them queued, and the stream on. The driver may have to give at least caps.buffers + 1. */
int v4l2_stream_start(struct v4l2_camera *camera, struct ttf_err *err);
/* Off, and all buffers given up; held ones too. */
void v4l2_stream_stop(struct v4l2_camera *camera);
/* Held frames and what the driver has filled go back to it. */
int v4l2_stream_requeue(struct v4l2_camera *camera, struct ttf_err *err);
/* The next arrival; its buffer is ours. -ETIMEDOUT, -EIO, -ENODEV. */
int v4l2_stream_take(struct v4l2_camera *camera, int64_t deadline_ns, struct v4l2_arrival *ret,
                     struct ttf_err *err);
/*
 * From the beginning of the first row's exposure to the end of the last's, on the boot clock; the readout is the
 * configuration's, or taken to be a frame period.
 */
void v4l2_arrival_span(const struct v4l2_camera *camera, const struct v4l2_arrival *arrival,
                       int64_t exposure_ns, int64_t *ret_start, int64_t *ret_end);
/* An arrival goes back to the driver. */
int v4l2_stream_give(struct v4l2_camera *camera, unsigned index, struct ttf_err *err);
/* Its slot is in the caller's hands from now on. */
struct ttf_frame *v4l2_stream_hold(struct v4l2_camera *camera, unsigned index);
void v4l2_stream_release(struct v4l2_camera *camera, struct ttf_frame *frame);
/* Until the caller holds fewer than it may. 1 if there was a wait, 0; -ETIMEDOUT. */
int v4l2_stream_await_room(struct v4l2_camera *camera, int64_t deadline_ns);

/* ---- steer.c ---- */

/* Of a configured camera. */
void v4l2_steer_set_up(struct v4l2_camera *camera);
/* How much earlier a set is to be submitted. */
int64_t v4l2_steer_lead_ns(const struct v4l2_camera *camera);
/* A frame of this sequence and middle went by while a set waits for its instant: what follows is moved towards it. */
void v4l2_steer_look(struct v4l2_camera *camera, uint32_t sequence, int64_t middle_ns);
/* The usual duration again. */
void v4l2_steer_rest(struct v4l2_camera *camera);

/* ---- set.c ---- */

int v4l2_set_begin(struct v4l2_camera *camera, const struct ttf_camera_set *begun,
                   struct ttf_err *err);
int v4l2_set_next(struct v4l2_camera *camera, int64_t deadline_ns, struct ttf_frame **ret_frame,
                  struct ttf_err *err);

#endif
