/* SPDX-License-Identifier: Apache-2.0 */
/* stream.c: buffers between the driver, us and the caller, and when what they hold was exposed. */
#include <errno.h>
#include <string.h>

#include "device.h"
#include "ttf/base/time.h"

/* The offset of two clocks of one machine moves by this much only if the machine slept. */
#define SLEPT_NS TTF_NS_PER_MS

static int say(struct v4l2_camera *camera, struct ttf_err *err, int r, const char *what)
{
    return ttf_err_set(err, r == -ENODEV || r == -ENXIO ? -ENODEV : r, camera->id.device, "%s: %s",
                       what, strerrordesc_np(-r));
}

/* Locked, or before anybody else knows of the stream. */
static int queue(struct v4l2_camera *camera, unsigned index)
{
    struct v4l2_buffer buffer = {
        .index = index, .type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP};
    int r = v4l2_ioctl(camera, VIDIOC_QBUF, &buffer);

    camera->stream.slot[index].place = r < 0 ? V4L2_BUFFER_OURS : V4L2_BUFFER_QUEUED;
    return r;
}

/* ---- buffers ---- */

static int request(struct v4l2_camera *camera, unsigned n, unsigned *ret)
{
    struct v4l2_requestbuffers want = {
        .count = n, .type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP};
    int r = v4l2_ioctl(camera, VIDIOC_REQBUFS, &want);

    if (r == 0)
        *ret = want.count;
    return r;
}

static void give_up_buffers(struct v4l2_camera *camera)
{
    struct v4l2_stream *s = &camera->stream;
    unsigned none;

    for (unsigned i = 0; i < s->n; i++) {
        if (s->slot[i].at)
            camera->sys->unmap(camera->ctx, s->slot[i].at, s->slot[i].length);
        memset(&s->slot[i], 0, sizeof(s->slot[i]));
    }
    s->n = s->held = 0;
    (void)request(camera, 0, &none);
}

static int map_one(struct v4l2_camera *camera, unsigned index)
{
    struct v4l2_slot *slot = &camera->stream.slot[index];
    struct v4l2_buffer buffer = {
        .index = index, .type = V4L2_BUF_TYPE_VIDEO_CAPTURE, .memory = V4L2_MEMORY_MMAP};
    int r = v4l2_ioctl(camera, VIDIOC_QUERYBUF, &buffer);

    if (r < 0)
        return r;
    if (buffer.length < camera->frame_bytes)
        return -EIO;
    slot->length = buffer.length;
    return camera->sys->map(camera->ctx, camera->fd, slot->length, buffer.m.offset, &slot->at);
}

static int get_buffers(struct v4l2_camera *camera, struct ttf_err *err)
{
    struct v4l2_stream *s = &camera->stream;
    unsigned need = camera->base.caps.buffers + 1, granted = 0;
    int r = request(camera, camera->base.caps.buffers + V4L2_BUFFERS_SPARE, &granted);

    if (r == -EBUSY)
        return ttf_err_set(err, r, camera->id.device, "another program uses the camera");
    if (r < 0)
        return say(camera, err, r, "the driver gives no buffers");
    s->n = granted < V4L2_BUFFERS_MAX ? granted : V4L2_BUFFERS_MAX;
    if (s->n < need)
        return ttf_err_set(err, -ENOMEM, camera->id.device,
                           "the driver gives %u buffers, and %u are needed", s->n, need);
    for (unsigned i = 0; i < s->n; i++) {
        r = map_one(camera, i);
        if (r == 0)
            r = queue(camera, i);
        if (r < 0)
            return say(camera, err, r, "a buffer cannot be had");
    }
    return 0;
}

int v4l2_stream_start(struct v4l2_camera *camera, struct ttf_err *err)
{
    struct v4l2_stream *s = &camera->stream;
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE, r;

    pthread_mutex_lock(&s->lock);
    s->broken = 0;
    s->seen = s->slept = false;
    s->offset_ns = ttf_clock_monotonic_offset_ns(camera->clock, &s->uncertainty_ns);
    r = get_buffers(camera, err);
    if (r == 0) {
        r = v4l2_ioctl(camera, VIDIOC_STREAMON, &type);
        if (r == -EBUSY)
            ttf_err_set(err, r, camera->id.device, "another program uses the camera");
        else if (r < 0)
            say(camera, err, r, "the stream does not start");
    }
    if (r < 0)
        give_up_buffers(camera);
    s->on = r == 0;
    pthread_mutex_unlock(&s->lock);
    return r;
}

void v4l2_stream_stop(struct v4l2_camera *camera)
{
    struct v4l2_stream *s = &camera->stream;
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;

    pthread_mutex_lock(&s->lock);
    if (s->on) {
        (void)v4l2_ioctl(camera, VIDIOC_STREAMOFF, &type);
        give_up_buffers(camera);
    }
    s->on = false;
    pthread_mutex_unlock(&s->lock);
}

static int dequeue(struct v4l2_camera *camera, struct v4l2_buffer *ret)
{
    memset(ret, 0, sizeof(*ret));
    ret->type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    ret->memory = V4L2_MEMORY_MMAP;
    return v4l2_ioctl(camera, VIDIOC_DQBUF, ret);
}

int v4l2_stream_requeue(struct v4l2_camera *camera, struct ttf_err *err)
{
    struct v4l2_stream *s = &camera->stream;
    struct v4l2_buffer buffer;
    int r = 0;

    pthread_mutex_lock(&s->lock);
    for (unsigned i = 0; i < s->n; i++) { /* no more than there are, or a fast stream never ends */
        r = dequeue(camera, &buffer);
        if (r < 0 || buffer.index >= s->n)
            break;
        s->slot[buffer.index].place = V4L2_BUFFER_OURS;
    }
    s->held = 0;
    r = r == -EAGAIN ? 0 : r;
    for (unsigned i = 0; i < s->n && r == 0; i++)
        if (s->slot[i].place != V4L2_BUFFER_QUEUED)
            r = queue(camera, i);
    if (r == 0)
        s->broken = 0;
    pthread_mutex_unlock(&s->lock);
    return r < 0 ? say(camera, err, r, "the buffers cannot be given back") : 0;
}

int v4l2_stream_give(struct v4l2_camera *camera, unsigned index, struct ttf_err *err)
{
    int r;

    pthread_mutex_lock(&camera->stream.lock);
    r = queue(camera, index);
    pthread_mutex_unlock(&camera->stream.lock);
    if (r == -ENODEV || r == -ENXIO)
        return ttf_err_set(err, -ENODEV, camera->id.device, "the camera is gone");
    return r < 0 ? ttf_err_set(err, -EIO, camera->id.device,
                               "the driver does not take a buffer back: %s", strerrordesc_np(-r))
                 : 0;
}

struct ttf_frame *v4l2_stream_hold(struct v4l2_camera *camera, unsigned index)
{
    struct v4l2_slot *slot = &camera->stream.slot[index];

    pthread_mutex_lock(&camera->stream.lock);
    slot->place = V4L2_BUFFER_HELD;
    camera->stream.held++;
    pthread_mutex_unlock(&camera->stream.lock);
    return &slot->frame;
}

void v4l2_stream_release(struct v4l2_camera *camera, struct ttf_frame *frame)
{
    struct v4l2_stream *s = &camera->stream;
    struct v4l2_slot *slot = frame->backend;
    int r = 0;

    pthread_mutex_lock(&s->lock);
    if (s->on && slot->place == V4L2_BUFFER_HELD) {
        s->held--;
        r = queue(camera, (unsigned)(slot - s->slot));
        if (r < 0)
            s->broken = r; /* next says so */
    }
    pthread_mutex_unlock(&s->lock);
    ttf_gate_open(camera->freed);
}

int v4l2_stream_await_room(struct v4l2_camera *camera, int64_t deadline_ns)
{
    struct v4l2_stream *s = &camera->stream;
    int waited = 0;

    for (;;) {
        bool room;

        pthread_mutex_lock(&s->lock);
        room = s->held < camera->base.caps.buffers;
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
static void count(struct v4l2_stream *s, uint32_t driver, struct v4l2_arrival *ret)
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

/* A driver's stamp is of its own clock, which does not count the time that the machine sleeps. */
static void date(struct v4l2_camera *camera, const struct v4l2_buffer *buffer,
                 struct v4l2_arrival *ret)
{
    struct v4l2_stream *s = &camera->stream;
    int64_t offset = ttf_clock_monotonic_offset_ns(camera->clock, &s->uncertainty_ns);

    s->slept |= offset > s->offset_ns + SLEPT_NS || offset < s->offset_ns - SLEPT_NS;
    s->offset_ns = offset;
    ret->came_ns = ttf_clock_now_ns(camera->clock);
    ret->stamp_ns = (int64_t)buffer->timestamp.tv_sec * TTF_NS_PER_S +
                    (int64_t)buffer->timestamp.tv_usec * TTF_NS_PER_US + offset;
    ret->stamp = V4L2_STAMP_END;
    if ((buffer->flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC ||
        ret->stamp_ns == offset)
        ret->stamp = V4L2_STAMP_NONE;
    else if ((buffer->flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE)
        ret->stamp =
            strcmp(camera->id.driver, "uvcvideo") == 0 ? V4L2_STAMP_READOUT : V4L2_STAMP_EXPOSURE;
    s->stamped = ret->stamp != V4L2_STAMP_NONE;
}

void v4l2_arrival_span(const struct v4l2_camera *camera, const struct v4l2_arrival *arrival,
                       int64_t exposure_ns, int64_t *ret_start, int64_t *ret_end)
{
    int64_t readout = camera->config.readout_ns > 0 ? camera->config.readout_ns : camera->period_ns;
    int64_t end = arrival->stamp_ns;

    switch (arrival->stamp) {
    case V4L2_STAMP_NONE:
        end = arrival->came_ns;
        break;
    case V4L2_STAMP_END:
        break;
    case V4L2_STAMP_READOUT:
        end += readout;
        break;
    case V4L2_STAMP_EXPOSURE:
        end += exposure_ns + readout;
        break;
    }
    /* Nothing that has arrived was exposed later, whatever was assumed of its readout. */
    if (end > arrival->came_ns)
        end = arrival->came_ns;
    *ret_end = end;
    *ret_start = end - readout - exposure_ns;
}

static int failed(struct v4l2_camera *camera, struct ttf_err *err, int r)
{
    if (r == -ENODEV || r == -ENXIO)
        return ttf_err_set(err, -ENODEV, camera->id.device, "the camera is gone");
    return ttf_err_set(err, -EIO, camera->id.device, "the stream failed: %s", strerrordesc_np(-r));
}

int v4l2_stream_take(struct v4l2_camera *camera, int64_t deadline_ns, struct v4l2_arrival *ret,
                     struct ttf_err *err)
{
    struct v4l2_stream *s = &camera->stream;
    struct v4l2_buffer buffer;
    bool complained = false;
    int r, broken;

    for (;;) {
        pthread_mutex_lock(&s->lock);
        broken = s->broken;
        pthread_mutex_unlock(&s->lock);
        r = broken < 0 ? broken : dequeue(camera, &buffer);
        if (r == 0)
            break;
        if (r != -EAGAIN || complained)
            return failed(camera, err, r);
        r = camera->sys->wait(camera->ctx, camera->fd, camera->clock, deadline_ns);
        if (r == -ETIMEDOUT)
            return ttf_err_set(err, r, camera->id.device, "no frame came in time");
        if (r < 0)
            return failed(camera, err, r);
        complained = r > 0;
    }
    if (buffer.index >= s->n)
        return failed(camera, err, -EIO);
    pthread_mutex_lock(&s->lock);
    s->slot[buffer.index].place = V4L2_BUFFER_OURS;
    pthread_mutex_unlock(&s->lock);
    ret->index = buffer.index;
    ret->bytes = buffer.bytesused < s->slot[buffer.index].length ? buffer.bytesused
                                                                 : s->slot[buffer.index].length;
    ret->error = buffer.flags & V4L2_BUF_FLAG_ERROR;
    count(s, buffer.sequence, ret);
    date(camera, &buffer, ret);
    return 0;
}
