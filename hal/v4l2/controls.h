/* SPDX-License-Identifier: Apache-2.0 */
/*
 * controls.h: a camera's controls: all that is automatic off, what has a meaning mapped to settings, the rest fixed.
 * Private to hal/v4l2.
 */
#ifndef TTF_HAL_V4L2_CONTROLS_H
#define TTF_HAL_V4L2_CONTROLS_H

#include <stdbool.h>

#include "sys.h"

/* One control that settings reach. */
struct v4l2_dial {
    uint32_t id; /* 0: the device has none, or none that can be set */
    int32_t min, max, step;
};

struct v4l2_controls {
    const struct v4l2_sys *sys;
    void *ctx;
    int fd;
    struct v4l2_dial exposure, gain, red, blue, focus;
    int64_t exposure_unit_ns; /* of a code of exposure */
    uint32_t gain_unity, balance_unity, focus_per_dioptre;
    unsigned has, mapped, automatics_off; /* as in struct ttf_v4l2_info */
    /* A lens without a unit: where it stands. keep_lens: on the next set-up it is put there, else looked at anew. */
    bool lens_held, keep_lens;
    int64_t lens_code;
};

/*
 * Looks what there is on an open device whose format is set, switches off what is automatic, fixes what the
 * configuration fixes. c->sys, ctx and fd are set. width: pixels of a line, for sensors that expose in lines; period_ns: of the stream.
 * -ENOTSUP for an exposure that stays automatic, -EINVAL for a control that there is not or a value it does not take,
 * -EIO, -ENODEV, -EBUSY.
 */
TTF_MUST_USE int v4l2_controls_set_up(struct v4l2_controls *c, const struct ttf_v4l2_config *config,
                                      uint32_t width, int64_t period_ns, struct ttf_err *err);

/* How long a line of the sensor takes, of a driver that tells its pixel rate and blanking; 0. */
int64_t v4l2_controls_line_ns(const struct v4l2_controls *c, uint32_t width);

/* Limits and what there is not, into the capabilities. */
void v4l2_controls_caps(const struct v4l2_controls *c, struct ttf_camera_caps *caps);

/* Asks for settings, as far as they can be had. 0 or what the driver said. */
TTF_MUST_USE int v4l2_controls_apply(const struct v4l2_controls *c,
                                     const struct ttf_exposure *asked);

/* What the driver says when it has taken the nearest that it can of these. */
void v4l2_controls_meant(const struct v4l2_controls *c, const struct ttf_exposure *asked,
                         struct ttf_exposure *ret);

/* What the driver says now; 0 in what cannot be set. */
TTF_MUST_USE int v4l2_controls_read(const struct v4l2_controls *c, struct ttf_exposure *ret);

#endif
