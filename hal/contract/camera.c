/* SPDX-License-Identifier: Apache-2.0 */
/*
 * The camera's contract: argument and state checks, the count of buffers that a
 * set has yet to deliver, and the recovery ladder for back-ends without one.
 */
#include <errno.h>
#include <stddef.h>

#include "ttf/base/attr.h"
#include "ttf/base/time.h"
#include "ttf/hal/camera_backend.h"

const char *ttf_camera_recovery_name(enum ttf_camera_recovery step)
{
    static const char *const names[TTF_CAMERA_RECOVERY_COUNT] = {"requeue", "restart", "reopen"};

    return (unsigned)step < TTF_CAMERA_RECOVERY_COUNT ? names[step] : "unknown";
}

int ttf_camera_configure(struct ttf_camera *camera, const struct ttf_camera_mode *mode,
                         struct ttf_frame_format *ret_granted, struct ttf_err *err)
{
    int r;

    if (mode->packing < TTF_PACKING_NONE || mode->packing >= TTF_PACKING_COUNT)
        return ttf_err_set(err, -EINVAL, camera->ops->name, "no such packing: %d",
                           (int)mode->packing);
    if (camera->streaming)
        return ttf_err_set(err, -EBUSY, camera->ops->name,
                           "the camera is streaming and cannot be configured");
    r = camera->ops->configure(camera, mode, err);
    if (r < 0)
        return r;
    camera->configured = true;
    if (ret_granted)
        *ret_granted = camera->format;
    return 0;
}

const struct ttf_camera_caps *ttf_camera_caps(const struct ttf_camera *camera)
{
    return &camera->caps;
}

const struct ttf_frame_format *ttf_camera_format(const struct ttf_camera *camera)
{
    return camera->configured ? &camera->format : NULL;
}

int ttf_camera_start(struct ttf_camera *camera, struct ttf_err *err)
{
    int r;

    if (!camera->configured)
        return ttf_err_set(err, -EINVAL, camera->ops->name, "the camera is not configured");
    if (camera->streaming)
        return ttf_err_set(err, -EALREADY, camera->ops->name, "the camera is streaming already");
    r = camera->ops->start(camera, err);
    if (r < 0)
        return r;
    camera->streaming = true;
    camera->outstanding = 0;
    return 0;
}

void ttf_camera_stop(struct ttf_camera *camera)
{
    if (!camera->streaming)
        return;
    camera->ops->stop(camera);
    camera->streaming = false;
    camera->outstanding = 0;
}

int ttf_camera_submit(struct ttf_camera *camera, const struct ttf_camera_set *set,
                      struct ttf_err *err)
{
    int r;

    if (set->n < 1 || set->n > TTF_CAMERA_SET_MAX || !set->settings)
        return ttf_err_set(err, -EINVAL, camera->ops->name, "a set has 1 to %d settings, not %u",
                           TTF_CAMERA_SET_MAX, set->n);
    for (unsigned i = 0; i < set->n; i++)
        if (set->settings[i].exposure_ns < 0 ||
            (set->settings[i].exposure_ns == 0 && camera->caps.exposure_max_ns > 0))
            return ttf_err_set(err, -EINVAL, camera->ops->name,
                               "exposure %u of the set is not longer than nothing", i);
    if (set->middle_ns > TTF_NS_NEVER / 2)
        return ttf_err_set(err, -EINVAL, camera->ops->name,
                           "the middle asked for is centuries ahead");
    if (!camera->streaming)
        return ttf_err_set(err, -EPIPE, camera->ops->name, "the camera is not streaming");
    if (camera->outstanding > 0)
        return ttf_err_set(err, -EBUSY, camera->ops->name, "a set is under way");
    r = camera->ops->submit(camera, set, err);
    if (r < 0)
        return r;
    camera->set_n = set->n;
    camera->outstanding = set->n;
    return 0;
}

int ttf_camera_next(struct ttf_camera *camera, int64_t deadline_ns, struct ttf_frame **ret_frame,
                    struct ttf_err *err)
{
    struct ttf_frame *frame = NULL;
    int r;

    if (camera->outstanding == 0)
        return ttf_err_set(err, -ENODATA, camera->ops->name, "no set is under way");
    r = camera->ops->next(camera, deadline_ns, &frame, err);
    if (r == -ENODATA || r == -ENODEV)
        camera->outstanding = 0;
    if (r < 0)
        return r;
    /* Buffers that were lost before this one will not come any more. */
    camera->outstanding =
        frame->set_index + 1 < camera->set_n ? camera->set_n - frame->set_index - 1 : 0;
    *ret_frame = frame;
    return 0;
}

void ttf_camera_release(struct ttf_camera *camera, struct ttf_frame *frame)
{
    if (frame)
        camera->ops->release(camera, frame);
}

void ttf_camera_cancel(struct ttf_camera *camera)
{
    if (camera->outstanding > 0)
        camera->ops->cancel(camera);
    camera->outstanding = 0;
}

/* What any camera can do: drop the set; stop and start. */
static int recover_plainly(struct ttf_camera *camera, enum ttf_camera_recovery step,
                           struct ttf_err *err)
{
    switch (step) {
    case TTF_CAMERA_REQUEUE:
        camera->ops->cancel(camera);
        return 0;
    case TTF_CAMERA_RESTART:
        ttf_camera_stop(camera);
        return ttf_camera_start(camera, err);
    default:
        return ttf_err_set(err, -ENOTSUP, camera->ops->name, "the camera cannot be reopened");
    }
}

int ttf_camera_recover(struct ttf_camera *camera, enum ttf_camera_recovery step,
                       struct ttf_err *err)
{
    int r;

    if ((unsigned)step >= TTF_CAMERA_RECOVERY_COUNT)
        return ttf_err_set(err, -EINVAL, camera->ops->name, "no such step of recovery: %d",
                           (int)step);
    if (!camera->configured)
        return ttf_err_set(err, -EINVAL, camera->ops->name, "the camera is not configured");
    if (!camera->streaming && step == TTF_CAMERA_REQUEUE)
        return ttf_err_set(err, -EPIPE, camera->ops->name, "the camera is not streaming");
    if (!camera->ops->recover) {
        r = recover_plainly(camera, step, err);
    } else {
        r = camera->ops->recover(camera, step, err);
        if (r == 0)
            camera->streaming = true;
    }
    camera->outstanding = 0;
    return r;
}

void ttf_camera_destroy(struct ttf_camera *camera)
{
    if (!camera)
        return;
    ttf_camera_stop(camera);
    camera->ops->destroy(camera);
}
