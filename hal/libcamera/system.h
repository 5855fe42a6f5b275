/* SPDX-License-Identifier: Apache-2.0 */
/* system.h: libcamera as it was loaded, or a test's; how one waits for it. Private to hal/libcamera. */
#ifndef TTF_HAL_LIBCAMERA_SYSTEM_H
#define TTF_HAL_LIBCAMERA_SYSTEM_H

#include "boundary.h"
#include "ttf/hal/clock.h"
#include "ttf/hal/libcamera.h"

struct lc_system {
    const struct lc_ops *ops;
    void *ctx;
    /* Until take has something to say: 0. -ETIMEDOUT. */
    int (*wait)(const struct lc_system *system, struct lc_handle *handle, struct ttf_clock *clock,
                int64_t deadline_ns);
    void (*destroy)(void *ctx); /* NULL: ctx is whoever made it */
};

/* The module at `path` (empty: where it is looked for), in a process of its own. -ENOTSUP. ret->destroy frees it. */
TTF_MUST_USE int lc_load(const char *path, struct lc_system *ret, struct ttf_err *err);

/* ttf_libcamera_camera_create on a system of one's own, which is copied, and is the camera's from here on, also on failure. */
TTF_MUST_USE int lc_camera_create_on(const struct lc_system *system,
                                     const struct ttf_libcamera_config *config,
                                     struct ttf_clock *clock, struct ttf_camera **ret,
                                     struct ttf_err *err);

#endif
