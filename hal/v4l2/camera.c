/* SPDX-License-Identifier: Apache-2.0 */
/* camera.c: the life of a V4L2 camera: found, configured, streaming, brought back. */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "device.h"
#include "ttf/base/time.h"

#define BUFFERS_DEFAULT       2
#define BUFFERS_MAX           8
#define SETTLE_FRAMES_DEFAULT 4
#define SETTLE_FRAMES_MAX     30

/* Between a frame's end and our taking it: how late a loaded machine may be. */
#define JITTER_NS (2 * TTF_NS_PER_MS)

static struct v4l2_camera *of(struct ttf_camera *base)
{
    return (struct v4l2_camera *)base;
}

static void fill_caps(struct v4l2_camera *camera)
{
    struct ttf_camera_caps *caps = &camera->base.caps;
    int64_t period = camera->period_ns;

    *caps = (struct ttf_camera_caps){
        .steerable = false,
        /* Half a period as it runs freely; the other half for a readout and stamps that nobody vouches for. */
        .timing_bound_ns = period + JITTER_NS + camera->stream.uncertainty_ns,
        .frame_period_ns = period,
        .lead_frames = camera->controls.mapped ? camera->config.settle_frames : 0,
        .buffers = camera->config.buffers,
    };
    caps->lead_ns = (caps->lead_frames + 2) * period + v4l2_steer_lead_ns(camera);
    (void)snprintf(caps->model, sizeof(caps->model), "%s", camera->id.name);
    v4l2_controls_caps(&camera->controls, caps);
}

/* The device as it is open now: all that a run needs of it, once. */
static int set_up(struct v4l2_camera *camera, struct ttf_err *err)
{
    enum v4l2_priority priority = V4L2_PRIORITY_RECORD;
    int r;

    /* Nobody else turns its controls from now on; drivers without priorities do not mind. */
    (void)v4l2_ioctl(camera, VIDIOC_S_PRIORITY, &priority);
    camera->asked_any = false;
    r = v4l2_negotiate(camera, &camera->mode, err);
    if (r < 0)
        return r;
    camera->controls.sys = camera->sys;
    camera->controls.ctx = camera->ctx;
    camera->controls.fd = camera->fd;
    r = v4l2_controls_set_up(&camera->controls, &camera->config, camera->base.format.width,
                             camera->period_ns, err);
    if (r == 0)
        v4l2_steer_set_up(camera);
    return r;
}

static void let_go(struct v4l2_camera *camera)
{
    v4l2_stream_stop(camera);
    if (camera->fd >= 0)
        camera->sys->close(camera->ctx, camera->fd);
    camera->fd = -1;
}

/* The very camera that it was, under whatever name it has now. */
static int find_again(struct v4l2_camera *camera, struct ttf_err *err)
{
    struct v4l2_identity now;
    int fd;

    let_go(camera);
    fd = v4l2_find(camera->sys, camera->ctx, &camera->config, &camera->id, &now, err);
    if (fd < 0)
        return fd;
    camera->fd = fd;
    camera->id = now;
    return 0;
}

static int camera_configure(struct ttf_camera *base, const struct ttf_camera_mode *mode,
                            struct ttf_err *err)
{
    struct v4l2_camera *camera = of(base);
    struct v4l2_capability cap = {0};
    int r = 0;

    camera->mode = *mode;
    camera->controls.keep_lens = false; /* where a person has it now */
    /* Unplugged since it was opened? */
    if (v4l2_ioctl(camera, VIDIOC_QUERYCAP, &cap) == -ENODEV)
        r = find_again(camera, err);
    if (r == 0)
        r = set_up(camera, err);
    if (r == 0)
        fill_caps(camera);
    return r;
}

static int start(struct v4l2_camera *camera, struct ttf_err *err)
{
    int r = v4l2_stream_start(camera, err);

    camera->set.n = camera->set.next = 0;
    camera->set.settling = true; /* the first frames of a stream are often none */
    camera->set.counting = false;
    camera->set.fresh_ns = ttf_clock_now_ns(camera->clock);
    return r;
}

static int camera_start(struct ttf_camera *base, struct ttf_err *err)
{
    return start(of(base), err);
}

static void camera_cancel(struct ttf_camera *base)
{
    v4l2_steer_rest(of(base));
    of(base)->set.n = of(base)->set.next = 0;
}

static void camera_stop(struct ttf_camera *base)
{
    camera_cancel(base);
    v4l2_stream_stop(of(base));
}

static int camera_submit(struct ttf_camera *base, const struct ttf_camera_set *set,
                         struct ttf_err *err)
{
    return v4l2_set_begin(of(base), set, err);
}

static int camera_next(struct ttf_camera *base, int64_t deadline_ns, struct ttf_frame **ret_frame,
                       struct ttf_err *err)
{
    return v4l2_set_next(of(base), deadline_ns, ret_frame, err);
}

static void camera_release(struct ttf_camera *base, struct ttf_frame *frame)
{
    v4l2_stream_release(of(base), frame);
}

/* Bytes lie as they did, too. */
static bool same_format(const struct ttf_frame_format *a, const struct ttf_frame_format *b)
{
    return ttf_frame_format_equal(a, b) && a->stride == b->stride;
}

/* One configuration a run: a camera that comes back different is not the one that the dataset is of. */
static int reopen(struct v4l2_camera *camera, struct ttf_err *err)
{
    struct ttf_frame_format before = camera->base.format;
    unsigned mapped = camera->controls.mapped;
    int r = find_again(camera, err);

    camera->controls.keep_lens = true;
    if (r == 0)
        r = set_up(camera, err);
    if (r == 0 &&
        (!same_format(&before, &camera->base.format) || mapped != camera->controls.mapped))
        r = ttf_err_set(err, -EIO, camera->id.device,
                        "the camera came back with another format or other controls");
    camera->base.format = before;
    if (r == 0)
        r = start(camera, err);
    if (r < 0)
        let_go(camera);
    return r;
}

static int camera_recover(struct ttf_camera *base, enum ttf_camera_recovery step,
                          struct ttf_err *err)
{
    struct v4l2_camera *camera = of(base);

    camera_cancel(base);
    if (step == TTF_CAMERA_REOPEN)
        return reopen(camera, err);
    if (camera->fd < 0)
        return ttf_err_set(err, -ENODEV, camera->id.device, "the camera '%s' is gone",
                           camera->id.name);
    if (step == TTF_CAMERA_REQUEUE && camera->stream.on)
        return v4l2_stream_requeue(camera, err);
    v4l2_stream_stop(camera);
    camera->asked_any = false; /* whatever hung may have forgotten them */
    return start(camera, err);
}

static void camera_destroy(struct ttf_camera *base)
{
    struct v4l2_camera *camera = of(base);

    let_go(camera);
    ttf_gate_destroy(camera->freed);
    pthread_mutex_destroy(&camera->stream.lock);
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
    .cancel = camera_cancel,
    .recover = camera_recover,
    .destroy = camera_destroy,
};

/* ---- making one ---- */

static int check_config(const struct ttf_v4l2_config *c, struct ttf_err *err)
{
    if (!memchr(c->device, 0, sizeof(c->device)) || !memchr(c->bus, 0, sizeof(c->bus)) ||
        !memchr(c->name, 0, sizeof(c->name)) ||
        !memchr(c->pixel_format, 0, sizeof(c->pixel_format)))
        return ttf_err_set(err, -EINVAL, NULL, "a text without an end");
    if (c->buffers != 0 && (c->buffers < BUFFERS_DEFAULT || c->buffers > BUFFERS_MAX))
        return ttf_err_set(err, -EINVAL, "buffers", "%u is not in 2 to %d", c->buffers,
                           BUFFERS_MAX);
    if (c->settle_frames > SETTLE_FRAMES_MAX)
        return ttf_err_set(err, -EINVAL, "settle_frames", "%u is not in 1 to %d", c->settle_frames,
                           SETTLE_FRAMES_MAX);
    if (c->frame_period_ns < 0 || c->frame_period_ns > TTF_NS_PER_MIN || c->readout_ns < 0 ||
        c->readout_ns > TTF_NS_PER_MIN)
        return ttf_err_set(err, -EINVAL, NULL, "a frame period or readout is not in 0 to 60 s");
    if (c->n_controls > TTF_V4L2_CONTROLS_MAX)
        return ttf_err_set(err, -EINVAL, "controls", "more than %d", TTF_V4L2_CONTROLS_MAX);
    if ((unsigned)c->flicker > TTF_V4L2_FLICKER_60HZ)
        return ttf_err_set(err, -EINVAL, "flicker", "no such word");
    return 0;
}

static int open_first(struct v4l2_camera *camera, struct ttf_err *err)
{
    camera->fd = v4l2_find(camera->sys, camera->ctx, &camera->config, NULL, &camera->id, err);
    return camera->fd < 0 ? camera->fd : 0;
}

int v4l2_camera_create_on(const struct v4l2_sys *sys, void *ctx,
                          const struct ttf_v4l2_config *config, struct ttf_clock *clock,
                          struct ttf_camera **ret, struct ttf_err *err)
{
    struct v4l2_camera *camera;
    int r = check_config(config, err);

    if (r < 0)
        return r;
    camera = calloc(1, sizeof(*camera));
    if (!camera)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    camera->base.ops = &OPS;
    camera->config = *config;
    camera->config.buffers = config->buffers ? config->buffers : BUFFERS_DEFAULT;
    camera->config.settle_frames =
        config->settle_frames ? config->settle_frames : SETTLE_FRAMES_DEFAULT;
    camera->clock = clock;
    camera->sys = sys;
    camera->ctx = ctx;
    camera->freed = ttf_gate_create(clock);
    if (!camera->freed || pthread_mutex_init(&camera->stream.lock, NULL) != 0) {
        r = ttf_err_set(err, -ENOMEM, NULL, "no memory");
        goto err_gate;
    }
    r = open_first(camera, err);
    if (r < 0)
        goto err_lock;
    *ret = &camera->base;
    return 0;

err_lock:
    pthread_mutex_destroy(&camera->stream.lock);
err_gate:
    ttf_gate_destroy(camera->freed);
    free(camera);
    return r;
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
    if (camera->pixels)
        (void)v4l2_fourcc_text(camera->pixels->fourcc, ret->pixel_format);
    ret->has = camera->controls.has;
    ret->mapped = camera->controls.mapped;
    ret->automatics_off = camera->controls.automatics_off;
    ret->sensor_time = camera->stream.stamped;
    ret->time_uncertainty_ns = camera->stream.uncertainty_ns;
}
