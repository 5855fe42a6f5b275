/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "device.h"

static int not_yet(struct ttf_err *err)
{
    return ttf_err_set(err, -ENOTSUP, NULL, "cameras of V4L2 do not stream yet");
}

static int camera_configure(struct ttf_camera *base, const struct ttf_camera_mode *mode,
                            struct ttf_err *err)
{
    (void)base;
    (void)mode;
    return not_yet(err);
}

static int camera_start(struct ttf_camera *base, struct ttf_err *err)
{
    (void)base;
    return not_yet(err);
}

static void camera_stop(struct ttf_camera *base)
{
    (void)base;
}

static int camera_submit(struct ttf_camera *base, const struct ttf_camera_set *set,
                         struct ttf_err *err)
{
    (void)base;
    (void)set;
    return not_yet(err);
}

static int camera_next(struct ttf_camera *base, int64_t deadline_ns, struct ttf_frame **ret_frame,
                       struct ttf_err *err)
{
    (void)base;
    (void)deadline_ns;
    (void)ret_frame;
    return not_yet(err);
}

static void camera_release(struct ttf_camera *base, struct ttf_frame *frame)
{
    (void)base;
    (void)frame;
}

static void camera_destroy(struct ttf_camera *base)
{
    struct v4l2_camera *camera = (struct v4l2_camera *)base;

    if (camera->fd >= 0)
        camera->sys->close(camera->ctx, camera->fd);
    free(camera);
}

static const struct ttf_camera_ops OPS = {
    .name = "v4l2",
    .configure = camera_configure,
    .start = camera_start,
    .stop = camera_stop,
    .submit = camera_submit,
    .next = camera_next,
    .release = camera_release,
    .cancel = camera_stop,
    .destroy = camera_destroy,
};

int v4l2_camera_create_on(const struct v4l2_sys *sys, void *ctx,
                          const struct ttf_v4l2_config *config, struct ttf_clock *clock,
                          struct ttf_camera **ret, struct ttf_err *err)
{
    struct v4l2_camera *camera = calloc(1, sizeof(*camera));

    if (!camera)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    camera->base.ops = &OPS;
    camera->config = *config;
    camera->clock = clock;
    camera->sys = sys;
    camera->ctx = ctx;
    camera->fd = v4l2_find(sys, ctx, config, NULL, &camera->id, err);
    if (camera->fd < 0) {
        int r = camera->fd;

        free(camera);
        return r;
    }
    *ret = &camera->base;
    return 0;
}

int ttf_v4l2_camera_create(const struct ttf_v4l2_config *config, struct ttf_clock *clock,
                           struct ttf_camera **ret, struct ttf_err *err)
{
    return v4l2_camera_create_on(&v4l2_sys_kernel, NULL, config, clock, ret, err);
}

void ttf_v4l2_camera_info(const struct ttf_camera *base, struct ttf_v4l2_info *ret)
{
    const struct v4l2_camera *camera = (const struct v4l2_camera *)base;

    memset(ret, 0, sizeof(*ret));
    memcpy(ret->device, camera->id.device, sizeof(ret->device));
    memcpy(ret->driver, camera->id.driver, sizeof(ret->driver));
    memcpy(ret->name, camera->id.name, sizeof(ret->name));
    memcpy(ret->bus, camera->id.bus, sizeof(ret->bus));
}
