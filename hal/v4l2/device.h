/* SPDX-License-Identifier: Apache-2.0 */
/* device.h: the camera's own state, shared by the files of hal/v4l2. */
#ifndef TTF_HAL_V4L2_DEVICE_H
#define TTF_HAL_V4L2_DEVICE_H

#include "find.h"
#include "sys.h"
#include "ttf/hal/camera_backend.h"

struct v4l2_camera {
    struct ttf_camera base; /* first: downcast by address */
    struct ttf_v4l2_config config;
    struct ttf_clock *clock;
    const struct v4l2_sys *sys;
    void *ctx;
    int fd; /* -1: gone */
    struct v4l2_identity id;
};

#endif
