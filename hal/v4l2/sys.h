/* SPDX-License-Identifier: Apache-2.0 */
/*
 * sys.h: the boundary to the kernel, as a table, so that a device made up in a test stands behind the same code.
 * Private to hal/v4l2. All give a negative errno on failure.
 */
#ifndef TTF_HAL_V4L2_SYS_H
#define TTF_HAL_V4L2_SYS_H

#include <stddef.h>
#include <stdint.h>

#include "ttf/hal/clock.h"
#include "ttf/hal/v4l2.h"

struct v4l2_sys {
    /* The i-th device that might be a camera, in rising order: 1 and its path, or 0 when there are no more. */
    int (*list)(void *ctx, unsigned i, char ret_path[64]);
    int (*open)(void *ctx, const char *path); /* non-blocking; a descriptor */
    void (*close)(void *ctx, int fd);
    int (*ioctl)(void *ctx, int fd, unsigned long request, void *arg);
    int (*map)(void *ctx, int fd, size_t length, int64_t offset, void **ret);
    void (*unmap)(void *ctx, void *at, size_t length);
    /* The serial number of the device behind an open camera; empty: it has none. */
    void (*serial)(void *ctx, int fd, char ret[64]);
    /* Until a buffer can be taken (0), or the device has something else to say (1). -ETIMEDOUT. */
    int (*wait)(void *ctx, int fd, struct ttf_clock *clock, int64_t deadline_ns);
};

/* The kernel itself; ctx is not looked at. */
extern const struct v4l2_sys v4l2_sys_kernel;

/* ttf_v4l2_camera_create on a system of one's own, which must outlive the camera. */
TTF_MUST_USE int v4l2_camera_create_on(const struct v4l2_sys *sys, void *ctx,
                                       const struct ttf_v4l2_config *config,
                                       struct ttf_clock *clock, struct ttf_camera **ret,
                                       struct ttf_err *err);

#endif
