/* SPDX-License-Identifier: Apache-2.0 */
/* controls_wire.h: one control of a device: looked at, set, read, found by name. Private to hal/v4l2. */
#ifndef TTF_HAL_V4L2_CONTROLS_WIRE_H
#define TTF_HAL_V4L2_CONTROLS_WIRE_H

#include <linux/videodev2.h>

#include "controls.h"

/* -EINVAL: the device has no such control, or it is out of use. */
int v4l2_control_query(const struct v4l2_controls *c, uint32_t id, struct v4l2_query_ext_ctrl *ret);
int v4l2_control_set(const struct v4l2_controls *c, uint32_t id, int64_t value);
int v4l2_control_get(const struct v4l2_controls *c, uint32_t id, int64_t *ret);

/* In words, what a driver says that does not take a value. */
const char *v4l2_control_reason(int r);

/* Sets, and looks whether it was taken as it is. */
int v4l2_control_fix(const struct v4l2_controls *c, const char *name, uint32_t id, int64_t value,
                     struct ttf_err *err);

/* The same for one that a board names. */
int v4l2_control_fix_named(const struct v4l2_controls *c, const struct ttf_v4l2_control *control,
                           struct ttf_err *err);

#endif
