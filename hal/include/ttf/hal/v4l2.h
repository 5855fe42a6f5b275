/* SPDX-License-Identifier: Apache-2.0 */
/*
 * v4l2.h: cameras behind the kernel's Video4Linux2: webcams (UVC), sensors with a plain capture driver.
 * What it promises and what it cannot: hal/v4l2/README.md.
 */
#ifndef TTF_HAL_V4L2_H
#define TTF_HAL_V4L2_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/camera.h"
#include "ttf/hal/clock.h"

#define TTF_V4L2_CONTROLS_MAX 16

/* A control by the driver's own name for it, as `v4l2-ctl -l` writes it ("sharpness"), and its value. */
struct ttf_v4l2_control {
    char name[32];
    int32_t value;
};

/* Which mains the camera's own anti-flicker reckons with. Off is right where exposures snap to the mains. */
enum ttf_v4l2_flicker {
    TTF_V4L2_FLICKER_OFF = 0,
    TTF_V4L2_FLICKER_50HZ,
    TTF_V4L2_FLICKER_60HZ
};

/*
 * All zero is a camera taken as it comes: the first one that gives pictures, at its largest. Empty texts match any.
 * A camera that was unplugged is found again by what `device`, `bus` and `name` say, and by nothing less than
 * the bus and name it had.
 */
struct ttf_v4l2_config {
    char device
        [64];      /* "/dev/video0", a link below /dev/v4l/by-id; empty: look through /dev/video* */
    char bus[64];  /* "usb-0000:01:00.0-1.2", as VIDIOC_QUERYCAP has it (or its beginning) */
    char name[64]; /* "HD Pro Webcam C920" (or its beginning) */
    char pixel_format
        [5]; /* "RG10", "YUYV": the kernel's four letters; empty: the best of what there is */
    uint32_t width, height;  /* pixels, what a mode of 0 means; 0: the largest the camera has */
    int64_t frame_period_ns; /* wanted of the free-running sensor; 0: as the driver has it */
    unsigned buffers;        /* frames that may be held at once, 2..8; 0: 2 */
    bool steer;              /* the stream may be moved to meet instants (README.md, "Steering") */
    unsigned settle_frames;  /* frames after a change of settings until it shows, 1..30; 0: 4 */
    int64_t readout_ns; /* from the first row's end of exposure to the last's; 0: a frame period */
    uint16_t black_level; /* code of no light, of raw and linear grey; < 2^bits - 1 */
    uint16_t white_level; /* code of saturation; 0: 2^bits - 1 */
    /*
     * V4L2 gives gain, white balance and focus no unit. With the driver's code that stands for 1 (or for a dioptre)
     * such a control becomes a capability; without, it is fixed for the run and no capability.
     */
    uint32_t gain_unity;        /* code of gain 1.0; gain is taken to be proportional to the code */
    uint32_t balance_unity;     /* code of a red or blue balance of 1.0; likewise */
    uint32_t focus_per_dioptre; /* codes to a dioptre, 0 at infinity */
    uint32_t white_balance_kelvin; /* fixed; 0: the driver's default */
    enum ttf_v4l2_flicker flicker;
    unsigned n_controls;
    struct ttf_v4l2_control controls[TTF_V4L2_CONTROLS_MAX]; /* fixed, after all others */
};

/* Which kinds of control the device has, and which of them are in use. Bits. */
enum {
    TTF_V4L2_EXPOSURE = 1u << 0,
    TTF_V4L2_GAIN = 1u << 1,
    TTF_V4L2_BALANCE = 1u << 2,     /* red and blue */
    TTF_V4L2_TEMPERATURE = 1u << 3, /* white balance by colour temperature */
    TTF_V4L2_FLICKER = 1u << 4,
    TTF_V4L2_FOCUS = 1u << 5
};

/* What there is, for `board probe` and a board's author. */
struct ttf_v4l2_info {
    char device[64], driver[16], name[32], bus[32];
    char pixel_format[5]; /* as granted */
    unsigned has;         /* TTF_V4L2_*: controls that the driver has */
    unsigned mapped;      /* those that a set's settings reach; the other ones of `has` are fixed */
    unsigned automatics_off; /* how many automatic controls were found and switched off */
    bool sensor_time;        /* the driver stamps frames; else their time is of arrival */
    int64_t
        time_uncertainty_ns; /* of turning the driver's clock into the boot clock, when last looked at */
};

/*
 * Opens the camera; nothing is changed in it before configure. The clock is borrowed and must be the machine's.
 * -ENODEV: no such camera (err says what there is instead), -EACCES, -EINVAL (config), -ENOTSUP (no device that
 * captures into memory), -ENOMEM. Free with ttf_camera_destroy.
 */
TTF_MUST_USE int ttf_v4l2_camera_create(const struct ttf_v4l2_config *config,
                                        struct ttf_clock *clock, struct ttf_camera **ret,
                                        struct ttf_err *err);

/* base: one made by ttf_v4l2_camera_create. Format and controls are known after configure. */
void ttf_v4l2_camera_info(const struct ttf_camera *base, struct ttf_v4l2_info *ret);

#endif
