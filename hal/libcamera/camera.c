/* SPDX-License-Identifier: Apache-2.0 */
/* camera.c: the life of a camera behind libcamera: found, configured, tried, streaming, brought back. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "device.h"
#include "ttf/base/time.h"

#define BUFFERS_DEFAULT       2
#define BUFFERS_MAX           8
#define SETTLE_FRAMES_DEFAULT 3
#define SETTLE_FRAMES_MAX     30
#define DELAY_FRAMES_DEFAULT  2
#define DELAY_FRAMES_MAX      8

/* Between a frame's end and our taking it: how late a loaded machine may be. */
#define JITTER_NS (2 * TTF_NS_PER_MS)

/* What of a frame period steering may miss, in parts of it. */
#define STEERING_PARTS 20

static struct lc_camera *of(struct ttf_camera *base)
{
    return (struct lc_camera *)base;
}

static void fill_caps(struct lc_camera *camera)
{
    struct ttf_camera_caps *caps = &camera->base.caps;
    int64_t period = camera->period_ns;
    bool steerable = camera->can.mapped & TTF_LIBCAMERA_PLACING;
    unsigned settled =
        camera->stream.n + camera->config.delay_frames + camera->config.settle_frames;
    /* Twice, as a digit more may have to be tried. */
    unsigned ahead = camera->can.mapped ? 2 * settled + 2 : camera->stream.n + 2;

    *caps = (struct ttf_camera_caps){
        .steerable = steerable,
        /* Half a period as it runs freely; the other half for a readout and stamps that nobody vouches for. */
        .timing_bound_ns = (steerable ? period / STEERING_PARTS : period + camera->uneven_ns) +
                           JITTER_NS + camera->stream.uncertainty_ns,
        .frame_period_ns = period,
        .lead_frames = camera->can.mapped ? settled : 0,
        .lead_ns = ahead * period,
        .long_frames = ahead,
        .buffers = camera->config.buffers,
    };
    (void)snprintf(caps->model, sizeof(caps->model), "%.63s",
                   camera->id.model[0] ? camera->id.model : camera->id.id);
    lc_controls_caps(&camera->can, caps);
}

static int64_t us_ns(double us)
{
    return us > 1e12 ? TTF_NS_NEVER / 4 : llround(us * 1e3);
}

/* Durations that may be asked, and the one that is. */
static void set_pace(struct lc_camera *camera)
{
    const struct lc_limits *l = &camera->can.limits;
    int64_t least = us_ns(l->min[LC_FRAME_DURATION]), most = us_ns(l->max[LC_FRAME_DURATION]);
    int64_t base = camera->config.frame_period_ns;

    if (least < TTF_NS_PER_US)
        least = TTF_NS_PER_US;
    if (base < least)
        base = least;
    if (base > most)
        base = most;
    lc_steer_init(&camera->stream.steer, least, most, base, camera->config.delay_frames);
    camera->readout_ns = camera->config.readout_ns;
    if (camera->readout_ns == 0 && l->has & 1u << LC_FRAME_DURATION)
        camera->readout_ns = least;
}

/* The camera as it is held now: format, buffers, controls. */
static int set_up(struct lc_camera *camera, struct ttf_err *err)
{
    int r;

    camera->settle.set = false;
    r = lc_negotiate(camera, err);
    if (r == 0)
        r = lc_controls_find(camera, err);
    if (r == 0)
        set_pace(camera);
    return r;
}

static int camera_configure(struct ttf_camera *base, const struct ttf_camera_mode *mode,
                            struct ttf_err *err)
{
    struct lc_camera *camera = of(base);
    int r = 0;

    camera->mode = *mode;
    camera->settle.n_pairs = camera->settle.next_pair = 0;
    if (!camera->handle)
        r = lc_find(camera, true, err);
    if (r == 0)
        r = set_up(camera, err);
    if (r == -ENODEV) { /* unplugged since it was taken? */
        r = lc_find(camera, true, err);
        if (r == 0)
            r = set_up(camera, err);
    }
    if (r == 0)
        r = lc_trial(camera, err);
    if (r < 0)
        return r;
    if (camera->readout_ns == 0)
        camera->readout_ns = camera->period_ns;
    fill_caps(camera);
    return 0;
}

static int start(struct lc_camera *camera, struct ttf_err *err)
{
    struct ttf_exposure none = {.exposure_ns = 10 * TTF_NS_PER_MS,
                                .gain_milli = 1000,
                                .wb_r_milli = 1000,
                                .wb_b_milli = 1000};

    camera->set.n = camera->set.next = 0;
    if (!camera->settle.set)
        lc_settle_want(camera, &none);
    else
        lc_settle_again(camera);
    return lc_stream_start(camera, err);
}

static int camera_start(struct ttf_camera *base, struct ttf_err *err)
{
    if (!of(base)->handle)
        return ttf_err_set(err, -ENODEV, of(base)->id.id, "the camera is gone");
    return start(of(base), err);
}

static void camera_cancel(struct ttf_camera *base)
{
    of(base)->set.n = of(base)->set.next = 0;
    lc_stream_aim(of(base), 0);
}

static void camera_stop(struct ttf_camera *base)
{
    camera_cancel(base);
    lc_stream_stop(of(base));
}

static int camera_submit(struct ttf_camera *base, const struct ttf_camera_set *set,
                         struct ttf_err *err)
{
    return lc_set_begin(of(base), set, err);
}

static int camera_next(struct ttf_camera *base, int64_t deadline_ns, struct ttf_frame **ret_frame,
                       struct ttf_err *err)
{
    return lc_set_next(of(base), deadline_ns, ret_frame, err);
}

static void camera_release(struct ttf_camera *base, struct ttf_frame *frame)
{
    lc_stream_release(of(base), frame);
}

/* Bytes lie as they did, too. */
static bool same_format(const struct ttf_frame_format *a, const struct ttf_frame_format *b)
{
    return ttf_frame_format_equal(a, b) && a->stride == b->stride;
}

/* What the trial found holds for the camera that came back; there is no time for another. */
static int as_before(struct lc_camera *camera, const struct ttf_frame_format *format,
                     const struct lc_abilities *can, struct ttf_err *err)
{
    if (!same_format(format, &camera->base.format) || can->has != camera->can.has)
        return ttf_err_set(err, -EIO, camera->id.id,
                           "the camera came back with another format or other controls");
    camera->can.lens_told = can->lens_told;
    lc_controls_unmap(&camera->can, can->has & ~can->mapped);
    return 0;
}

/* One configuration a run: a camera that comes back different is not the one that the dataset is of. */
static int reopen(struct lc_camera *camera, struct ttf_err *err)
{
    struct ttf_frame_format format = camera->base.format;
    struct lc_abilities can = camera->can;
    struct ttf_exposure wanted = camera->settle.wanted;
    int64_t readout = camera->readout_ns, base = camera->stream.steer.base_ns;
    bool any = camera->settle.set;
    int r = lc_find(camera, true, err);

    if (r == 0)
        r = set_up(camera, err);
    if (r == 0)
        r = as_before(camera, &format, &can, err);
    camera->base.format = format;
    if (r == 0) {
        camera->readout_ns = readout;
        camera->stream.steer.base_ns = base;
        if (any)
            lc_settle_want(camera, &wanted);
        r = start(camera, err);
    }
    if (r < 0) {
        camera->can = can;
        lc_let_go(camera);
    }
    return r;
}

static int camera_recover(struct ttf_camera *base, enum ttf_camera_recovery step,
                          struct ttf_err *err)
{
    struct lc_camera *camera = of(base);

    camera_cancel(base);
    if (step == TTF_CAMERA_REOPEN)
        return reopen(camera, err);
    if (!camera->handle)
        return ttf_err_set(err, -ENODEV, camera->id.id, "the camera is gone");
    lc_stream_stop(camera);
    return start(camera, err);
}

static void free_system(const struct lc_system *system)
{
    if (system->destroy)
        system->destroy(system->ctx);
}

static void free_camera(struct lc_camera *camera)
{
    lc_let_go(camera);
    ttf_gate_destroy(camera->freed);
    pthread_mutex_destroy(&camera->stream.lock);
    free_system(&camera->system);
    free(camera);
}

static void camera_destroy(struct ttf_camera *base)
{
    free_camera(of(base));
}

static const struct ttf_camera_ops OPS = {
    .name = "libcamera",
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

static int check_config(const struct ttf_libcamera_config *c, struct ttf_err *err)
{
    if (!memchr(c->module, 0, sizeof(c->module)) || !memchr(c->id, 0, sizeof(c->id)) ||
        !memchr(c->name, 0, sizeof(c->name)) ||
        !memchr(c->pixel_format, 0, sizeof(c->pixel_format)))
        return ttf_err_set(err, -EINVAL, NULL, "a text without an end");
    if (c->buffers != 0 && (c->buffers < BUFFERS_DEFAULT || c->buffers > BUFFERS_MAX))
        return ttf_err_set(err, -EINVAL, "buffers", "%u is not in 2 to %d", c->buffers,
                           BUFFERS_MAX);
    if (c->settle_frames > SETTLE_FRAMES_MAX)
        return ttf_err_set(err, -EINVAL, "settle_frames", "%u is not in 1 to %d", c->settle_frames,
                           SETTLE_FRAMES_MAX);
    if (c->delay_frames > DELAY_FRAMES_MAX)
        return ttf_err_set(err, -EINVAL, "delay_frames", "%u is not in 1 to %d", c->delay_frames,
                           DELAY_FRAMES_MAX);
    if (c->frame_period_ns < 0 || c->frame_period_ns > TTF_NS_PER_MIN || c->readout_ns < 0 ||
        c->readout_ns > TTF_NS_PER_MIN)
        return ttf_err_set(err, -EINVAL, NULL, "a frame period or readout is not in 0 to 60 s");
    if ((unsigned)c->stream > TTF_LIBCAMERA_PROCESSED ||
        (unsigned)c->stamp > TTF_LIBCAMERA_STAMP_READOUT)
        return ttf_err_set(err, -EINVAL, NULL, "no such stream or stamp");
    return 0;
}

int lc_camera_create_on(const struct lc_system *system, const struct ttf_libcamera_config *config,
                        struct ttf_clock *clock, struct ttf_camera **ret, struct ttf_err *err)
{
    struct lc_camera *camera;
    int r = check_config(config, err);

    camera = r == 0 ? calloc(1, sizeof(*camera)) : NULL;
    if (!camera) {
        free_system(system);
        return r < 0 ? r : ttf_err_set(err, -ENOMEM, NULL, "no memory");
    }
    camera->base.ops = &OPS;
    camera->config = *config;
    camera->config.buffers = config->buffers ? config->buffers : BUFFERS_DEFAULT;
    camera->config.settle_frames =
        config->settle_frames ? config->settle_frames : SETTLE_FRAMES_DEFAULT;
    camera->config.delay_frames =
        config->delay_frames ? config->delay_frames : DELAY_FRAMES_DEFAULT;
    camera->clock = clock;
    camera->system = *system;
    if (pthread_mutex_init(&camera->stream.lock, NULL) != 0) {
        free_system(system);
        free(camera);
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    }
    camera->freed = ttf_gate_create(clock);
    r = camera->freed ? lc_find(camera, false, err) : ttf_err_set(err, -ENOMEM, NULL, "no memory");
    if (r < 0) {
        free_camera(camera);
        return r;
    }
    *ret = &camera->base;
    return 0;
}

int ttf_libcamera_camera_create(const struct ttf_libcamera_config *config, struct ttf_clock *clock,
                                struct ttf_camera **ret, struct ttf_err *err)
{
    struct lc_system system = {0};
    int r = check_config(config, err);

    if (r == 0)
        r = lc_load(config->module, &system, err);
    return r < 0 ? r : lc_camera_create_on(&system, config, clock, ret, err);
}

void ttf_libcamera_camera_info(const struct ttf_camera *base, struct ttf_libcamera_info *ret)
{
    const struct lc_camera *camera = (const struct lc_camera *)base;

    memset(ret, 0, sizeof(*ret));
    memcpy(ret->id, camera->id.id, sizeof(ret->id));
    memcpy(ret->model, camera->id.model, sizeof(ret->model));
    (void)snprintf(ret->version, sizeof(ret->version), "%s",
                   lc_ops(camera)->version(camera->system.ctx));
    if (camera->pixels) {
        (void)lc_pixels_text(camera->pixels->fourcc, camera->pixels->modifier, ret->pixel_format);
        ret->raw = camera->pixels->role == LC_RAW;
    }
    ret->has = camera->can.has;
    ret->mapped = camera->can.mapped;
    ret->automatics_off = camera->can.automatics_off;
    ret->sensor_time = camera->stream.stamped;
    ret->time_uncertainty_ns = camera->stream.uncertainty_ns;
}
