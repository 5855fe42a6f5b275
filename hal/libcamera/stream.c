/* SPDX-License-Identifier: Apache-2.0 */
/* stream.c: buffers and requests between libcamera, us and the caller, and when what they hold was exposed. */
#include <errno.h>
#include <string.h>

#include "device.h"
#include "ttf/base/time.h"

/* The offset of two clocks of one machine moves by this much only if the machine slept. */
#define SLEPT_NS TTF_NS_PER_MS

/* What a driver needs between an exposure's end and the next frame, beside a fiftieth: lines that are not exposed. */
#define GAP_NS TTF_NS_PER_MS

static int failed(struct lc_camera *camera, struct ttf_err *err, int r)
{
    if (r == -ENODEV || r == -ENXIO)
        return ttf_err_set(err, -ENODEV, camera->id.id, "the camera is gone");
    return ttf_err_set(err, -EIO, camera->id.id, "the stream failed: %s", strerrordesc_np(-r));
}

/* ---- requests ---- */

/* Locked. */
static int queue(struct lc_camera *camera, unsigned index)
{
    struct lc_stream *s = &camera->stream;
    struct lc_slot *slot = &s->slot[index];
    struct lc_settings settings = s->carry;
    int r;

    slot->number = s->steer.queued;
    slot->generation = s->generation;
    if (camera->can.limits.has & 1u << LC_FRAME_DURATION) {
        double us = (double)lc_steer_next(&s->steer, s->floor_ns) / 1e3;

        settings.set |= 1u << LC_FRAME_DURATION;
        settings.value[LC_FRAME_DURATION][0] = settings.value[LC_FRAME_DURATION][1] = us;
    } else {
        s->steer.queued++;
    }
    r = camera->handle ? lc_ops(camera)->queue(camera->handle, index, &settings) : -ENODEV;
    slot->place = r < 0 ? LC_OURS : LC_QUEUED;
    return r;
}

void lc_stream_carry(struct lc_camera *camera, const struct ttf_exposure *asked)
{
    struct lc_stream *s = &camera->stream;

    pthread_mutex_lock(&s->lock);
    s->carry = lc_controls_request(&camera->can, asked);
    s->generation++;
    s->floor_ns =
        asked->exposure_ns > 0 ? asked->exposure_ns + asked->exposure_ns / 50 + GAP_NS : 0;
    pthread_mutex_unlock(&s->lock);
}

void lc_stream_aim(struct lc_camera *camera, int64_t middle_ns)
{
    struct lc_stream *s = &camera->stream;

    pthread_mutex_lock(&s->lock);
    if (middle_ns > 0 && (camera->can.mapped & TTF_LIBCAMERA_PLACING))
        lc_steer_begin(&s->steer, middle_ns);
    else
        lc_steer_end(&s->steer);
    pthread_mutex_unlock(&s->lock);
}

void lc_stream_seen(struct lc_camera *camera, const struct lc_arrival *arrival, int64_t middle_ns)
{
    pthread_mutex_lock(&camera->stream.lock);
    lc_steer_arrived(&camera->stream.steer, arrival->number, middle_ns);
    pthread_mutex_unlock(&camera->stream.lock);
}

int lc_stream_start(struct lc_camera *camera, struct ttf_err *err)
{
    struct lc_stream *s = &camera->stream;
    struct lc_settings first;
    int r;

    s->broken = 0;
    s->seen = s->slept = false;
    s->held = 0;
    s->offset_ns = ttf_clock_monotonic_offset_ns(camera->clock, &s->uncertainty_ns);
    s->steer.queued = 0;
    lc_steer_end(&s->steer);
    for (unsigned i = 0; i < LC_STEER_REMEMBERED; i++)
        s->steer.asked_ns[i] = s->steer.base_ns;
    first = s->carry;
    r = lc_ops(camera)->start(camera->handle, &first);
    if (r < 0)
        return r == -ENODEV ? failed(camera, err, r)
                            : ttf_err_set(err, r, camera->id.id, "the stream does not start: %s",
                                          strerrordesc_np(-r));
    pthread_mutex_lock(&s->lock);
    s->on = true;
    for (unsigned i = 0; i < s->n && r == 0; i++)
        r = queue(camera, i);
    pthread_mutex_unlock(&s->lock);
    if (r < 0) {
        lc_stream_stop(camera);
        return failed(camera, err, r);
    }
    return 0;
}

void lc_stream_stop(struct lc_camera *camera)
{
    struct lc_stream *s = &camera->stream;
    bool was;

    pthread_mutex_lock(&s->lock);
    was = s->on;
    s->on = false;
    for (unsigned i = 0; i < s->n; i++)
        s->slot[i].place = LC_OURS;
    s->held = 0;
    pthread_mutex_unlock(&s->lock);
    if (was && camera->handle)
        (void)lc_ops(camera)->stop(camera->handle);
}

int lc_stream_give(struct lc_camera *camera, unsigned index, struct ttf_err *err)
{
    int r;

    pthread_mutex_lock(&camera->stream.lock);
    r = queue(camera, index);
    pthread_mutex_unlock(&camera->stream.lock);
    return r < 0 ? failed(camera, err, r) : 0;
}

struct ttf_frame *lc_stream_hold(struct lc_camera *camera, unsigned index)
{
    struct lc_slot *slot = &camera->stream.slot[index];

    pthread_mutex_lock(&camera->stream.lock);
    slot->place = LC_HELD;
    camera->stream.held++;
    pthread_mutex_unlock(&camera->stream.lock);
    return &slot->frame;
}

void lc_stream_release(struct lc_camera *camera, struct ttf_frame *frame)
{
    struct lc_stream *s = &camera->stream;
    struct lc_slot *slot = frame->backend;
    int r = 0;

    pthread_mutex_lock(&s->lock);
    if (s->on && slot->place == LC_HELD) {
        s->held--;
        r = queue(camera, (unsigned)(slot - s->slot));
        if (r < 0)
            s->broken = r; /* next says so */
    }
    pthread_mutex_unlock(&s->lock);
    ttf_gate_open(camera->freed);
}

int lc_stream_await_room(struct lc_camera *camera, int64_t deadline_ns)
{
    struct lc_stream *s = &camera->stream;
    int waited = 0;

    for (;;) {
        bool room;

        pthread_mutex_lock(&s->lock);
        room = s->held < camera->config.buffers;
        pthread_mutex_unlock(&s->lock);
        if (room)
            return waited;
        waited = 1;
        if (ttf_gate_wait(camera->freed, deadline_ns) < 0)
            return -ETIMEDOUT;
    }
}

/* ---- arrivals ---- */

/* A counter that stands still or falls back is no counter: then each arrival is one more. */
static void count(struct lc_stream *s, uint32_t driver, struct lc_arrival *ret)
{
    uint32_t step = driver - s->last_sequence;

    ret->sequence = driver;
    ret->lost = 0;
    if (s->seen && (step == 0 || step > UINT32_MAX / 2))
        ret->sequence = s->last_sequence + 1;
    else if (s->seen)
        ret->lost = step - 1;
    s->seen = true;
    s->last_sequence = ret->sequence;
}

/*
 * SensorTimestamp is on the boot clock, unless a pipeline hands on the kernel driver's stamp, which is on the monotonic
 * clock: then both are the same.
 */
static void date(struct lc_camera *camera, const struct lc_done *done, struct lc_arrival *ret)
{
    struct lc_stream *s = &camera->stream;
    int64_t offset = ttf_clock_monotonic_offset_ns(camera->clock, &s->uncertainty_ns);

    s->slept |= offset > s->offset_ns + SLEPT_NS || offset < s->offset_ns - SLEPT_NS;
    s->offset_ns = offset;
    ret->came_ns = ttf_clock_now_ns(camera->clock);
    ret->stamped = done->sensor_ns != 0 || done->driver_ns != 0;
    ret->of_end = done->sensor_ns == 0;
    if (done->sensor_ns != 0 && done->sensor_ns != done->driver_ns)
        ret->stamp_ns = done->sensor_ns;
    else
        ret->stamp_ns = done->driver_ns + offset;
    s->stamped = ret->stamped;
}

void lc_arrival_span(const struct lc_camera *camera, const struct lc_arrival *arrival,
                     int64_t exposure_ns, int64_t *ret_start, int64_t *ret_end)
{
    int64_t readout = camera->readout_ns;
    int64_t end = arrival->stamped ? arrival->stamp_ns : arrival->came_ns;

    if (arrival->stamped && !arrival->of_end) {
        end += readout;
        if (camera->config.stamp == TTF_LIBCAMERA_STAMP_EXPOSURE)
            end += exposure_ns;
    }
    /* Nothing that has arrived was exposed later, whatever was assumed of its readout. */
    if (end > arrival->came_ns)
        end = arrival->came_ns;
    *ret_end = end;
    *ret_start = end - readout - exposure_ns;
}

static int broken(struct lc_stream *s)
{
    int r;

    pthread_mutex_lock(&s->lock);
    r = s->broken;
    pthread_mutex_unlock(&s->lock);
    return r;
}

int lc_stream_take(struct lc_camera *camera, int64_t deadline_ns, struct lc_arrival *ret,
                   struct ttf_err *err)
{
    struct lc_stream *s = &camera->stream;
    struct lc_done done = {0};
    struct lc_slot *slot;
    int r;

    for (;;) {
        r = broken(s);
        if (r == 0)
            r = lc_ops(camera)->take(camera->handle, &done);
        if (r == 0)
            break;
        if (r != -EAGAIN)
            return failed(camera, err, r);
        r = camera->system.wait(&camera->system, camera->handle, camera->clock, deadline_ns);
        if (r == -ETIMEDOUT)
            return ttf_err_set(err, r, camera->id.id, "no frame came in time");
        if (r < 0)
            return failed(camera, err, r);
    }
    if (done.buffer >= s->n)
        return failed(camera, err, -EIO);
    slot = &s->slot[done.buffer];
    pthread_mutex_lock(&s->lock);
    slot->place = LC_OURS;
    ret->number = slot->number;
    ret->generation = slot->generation;
    pthread_mutex_unlock(&s->lock);
    if (done.status == LC_CANCELLED)
        return ttf_err_set(err, -EIO, camera->id.id, "libcamera gave a request up");
    ret->index = done.buffer;
    ret->bytes = done.bytes < slot->length ? done.bytes : slot->length;
    ret->error = done.status != LC_GOOD;
    ret->told = done.told;
    count(s, done.sequence, ret);
    date(camera, &done, ret);
    return 0;
}
