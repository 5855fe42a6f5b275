/* SPDX-License-Identifier: Apache-2.0 */
/*
 * libcamera.h: cameras behind libcamera, which is reached through a module that is loaded when the first one is made.
 * What it promises and what it cannot: hal/libcamera/README.md.
 */
#ifndef TTF_HAL_LIBCAMERA_H
#define TTF_HAL_LIBCAMERA_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/camera.h"
#include "ttf/hal/clock.h"

enum ttf_libcamera_stream {
    TTF_LIBCAMERA_ANY = 0, /* raw if the camera has it */
    TTF_LIBCAMERA_RAW,
    TTF_LIBCAMERA_PROCESSED
};

/* What SensorTimestamp is of. */
enum ttf_libcamera_stamp {
    TTF_LIBCAMERA_STAMP_EXPOSURE = 0, /* the first row's exposure begins */
    TTF_LIBCAMERA_STAMP_READOUT       /* it ends, the row is read */
};

/*
 * All zero is a camera taken as it comes: the first that there is, raw if it can, at its largest, as fast as it goes. Empty texts
 * match any. A camera that was lost is found again by its id, and by nothing less.
 */
struct ttf_libcamera_config {
    char module[128]; /* the module's file; empty: looked for beside the program */
    char id[128];     /* libcamera's id (or its beginning): "/base/soc/i2c0mux/i2c@1/imx477@1a" */
    char name[64];    /* the sensor's model (or its beginning): "imx477" */
    char pixel_format[6]; /* "SRGGB12" is "RG12", RGB is "BG24": DRM's letters; a P behind them
                              means packed ("RG12P"); empty: the best there is */
    enum ttf_libcamera_stream stream;
    uint32_t width, height;  /* pixels, what a mode of 0 means; 0: the largest the camera has */
    int64_t frame_period_ns; /* of the free-running sensor; 0: the shortest it can */
    unsigned buffers;        /* frames that may be held at once, 2..8; 0: 2 */
    unsigned settle_frames;  /* frames for which what is told has to stand still, 1..30; 0: 3 */
    unsigned
        delay_frames; /* from a request's frame to the first that obeys its duration, 1..8; 0: 2 */
    int64_t
        readout_ns; /* from the first row's end of exposure to the last's; 0: the shortest frame */
    enum ttf_libcamera_stamp stamp;
    uint16_t black_level; /* code of no light; < 2^bits - 1 */
    uint16_t
        white_level; /* code of saturation; 0: 2^bits - 1, or the sensor's largest in wider words */
};

/* Which kinds of control there are. Bits. */
enum {
    TTF_LIBCAMERA_EXPOSURE = 1u << 0,
    TTF_LIBCAMERA_GAIN = 1u << 1,
    TTF_LIBCAMERA_BALANCE = 1u << 2,
    TTF_LIBCAMERA_LENS = 1u << 3,
    TTF_LIBCAMERA_PLACING = 1u << 4 /* frame durations, followed */
};

/* What there is, for `board probe` and a board's author. */
struct ttf_libcamera_info {
    char id[128], model[64];
    char version[16];     /* of libcamera */
    char pixel_format[6]; /* as granted */
    bool raw;
    unsigned has;                /* TTF_LIBCAMERA_*: controls that libcamera lists */
    unsigned mapped;             /* those that a set's settings reach */
    unsigned automatics_off;     /* how many automatic controls were found and switched off */
    bool sensor_time;            /* frames are stamped; else their time is of arrival */
    int64_t time_uncertainty_ns; /* of turning the driver's clock into the boot clock */
};

/*
 * Loads libcamera and takes the camera; nothing is changed in it before configure. The clock is borrowed and must be the
 * machine's. -ENOTSUP: no module, or one of another build (err says where it was looked for); -ENODEV: no such camera
 * (err says what there is instead); -EBUSY: another program has it; -EINVAL (config), -ENOMEM.
 * Free with ttf_camera_destroy.
 */
TTF_MUST_USE int ttf_libcamera_camera_create(const struct ttf_libcamera_config *config,
                                             struct ttf_clock *clock, struct ttf_camera **ret,
                                             struct ttf_err *err);

/* base: one made by ttf_libcamera_camera_create. Format and controls are known after configure. */
void ttf_libcamera_camera_info(const struct ttf_camera *base, struct ttf_libcamera_info *ret);

#endif
