/* SPDX-License-Identifier: Apache-2.0 */
/*
 * camera_backend.h: what the author of a camera back-end implements.
 *
 * One file, one const table. `struct ttf_camera` is embedded first in the
 * back-end's own struct, made by the back-end's own constructor. The wrappers of
 * camera.h check arguments and state (configured, streaming, set under way)
 * before they call an op, so ops need not.
 *
 * Mandatory: configure, start, stop, submit, next, release, cancel, destroy.
 * Optional:  recover (NULL: the wrapper does requeue by cancel, restart by
 *            stop and start, and reopen gives -ENOTSUP). When recover returns 0
 *            the camera streams; when it fails, `streaming` stays as it was.
 * next returns -ENODATA when it knows that the rest of the set was lost; the
 * set is then over.
 */
#ifndef TTF_HAL_CAMERA_BACKEND_H
#define TTF_HAL_CAMERA_BACKEND_H

#include "ttf/hal/camera.h"

struct ttf_camera_ops {
    const char *name; /* "sim", "v4l2", "libcamera" */
    /* Fills camera->caps and camera->format. */
    int (*configure)(struct ttf_camera *camera, const struct ttf_camera_mode *mode,
                     struct ttf_err *err);
    int (*start)(struct ttf_camera *camera, struct ttf_err *err);
    void (*stop)(struct ttf_camera *camera);
    int (*submit)(struct ttf_camera *camera, const struct ttf_camera_set *set, struct ttf_err *err);
    int (*next)(struct ttf_camera *camera, int64_t deadline_ns, struct ttf_frame **ret_frame,
                struct ttf_err *err);
    void (*release)(struct ttf_camera *camera, struct ttf_frame *frame);
    void (*cancel)(struct ttf_camera *camera);
    int (*recover)(struct ttf_camera *camera, enum ttf_camera_recovery step, struct ttf_err *err);
    void (*destroy)(struct ttf_camera *camera);
};

struct ttf_camera {
    const struct ttf_camera_ops *ops;
    struct ttf_camera_caps caps;
    struct ttf_frame_format format;
    bool configured;
    bool streaming;
    unsigned set_n; /* settings in the set under way; kept by the wrappers */
    unsigned
        outstanding; /* buffers of the set that next has yet to deliver; kept by the wrappers */
};

#endif
