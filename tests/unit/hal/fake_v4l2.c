/* SPDX-License-Identifier: Apache-2.0 */
#include "fake_v4l2.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "formats.h"
#include "ttf/base/frame.h"
#include "ttf/base/time.h"

#define FD 77

static struct fake_v4l2 *of(void *ctx)
{
    return ctx;
}

struct fake_control *fake_control(struct fake_v4l2 *fake, uint32_t id)
{
    for (unsigned i = 0; i < FAKE_CONTROLS; i++)
        if (fake->controls[i].id == id)
            return &fake->controls[i];
    return NULL;
}

void fake_control_remove(struct fake_v4l2 *fake, uint32_t id)
{
    struct fake_control *c = fake_control(fake, id);

    if (c)
        memset(c, 0, sizeof(*c));
}

void fake_v4l2_init(struct fake_v4l2 *fake, struct ttf_clock *clock)
{
    static const struct fake_control CONTROLS[] = {
        {V4L2_CID_EXPOSURE_AUTO, V4L2_CTRL_TYPE_MENU, "Auto Exposure", 0, 3, 1, 3, 3, false},
        {V4L2_CID_EXPOSURE_ABSOLUTE, V4L2_CTRL_TYPE_INTEGER, "Exposure Time, Absolute", 1, 5000, 1,
         100, 100, false},
        {V4L2_CID_AUTOGAIN, V4L2_CTRL_TYPE_BOOLEAN, "Gain, Automatic", 0, 1, 1, 1, 1, false},
        {V4L2_CID_GAIN, V4L2_CTRL_TYPE_INTEGER, "Gain", 0, 255, 1, 64, 64, false},
        {V4L2_CID_SHARPNESS, V4L2_CTRL_TYPE_INTEGER, "Sharpness", 0, 7, 1, 3, 3, false},
    };

    memset(fake, 0, sizeof(*fake));
    fake->clock = clock;
    (void)snprintf(fake->path, sizeof(fake->path), "/dev/video0");
    fake->driver = "fake";
    fake->card = "Fake camera";
    fake->bus = "test-1.2";
    fake->serial = "";
    fake->device_caps = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    fake->formats[0].fourcc = V4L2_PIX_FMT_SRGGB10;
    fake->width = 64;
    fake->height = 48;
    fake->field = V4L2_FIELD_NONE;
    fake->colorspace = V4L2_COLORSPACE_SRGB;
    memcpy(fake->controls, CONTROLS, sizeof(CONTROLS));
    fake->period_ns = 20 * TTF_NS_PER_MS;
    fake->readout_ns = 15 * TTF_NS_PER_MS;
    fake->delay = 2;
    fake->buffers_max = FAKE_BUFFERS;
    fake->stamp_flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    fake->priority = -1;
}

static void drop_buffers(struct fake_v4l2 *fake)
{
    for (unsigned i = 0; i < FAKE_BUFFERS; i++) {
        free(fake->buffer[i].at);
        memset(&fake->buffer[i], 0, sizeof(fake->buffer[i]));
    }
    fake->n = fake->n_fifo = 0;
}

void fake_v4l2_free(struct fake_v4l2 *fake)
{
    drop_buffers(fake);
}

void fake_unplug(struct fake_v4l2 *fake)
{
    fake->path[0] = '\0';
    fake->streaming = false;
}

void fake_plug(struct fake_v4l2 *fake, const char *path)
{
    (void)snprintf(fake->path, sizeof(fake->path), "%s", path);
    fake->fd = -1; /* what was open stays dead */
    for (unsigned i = 0; i < FAKE_CONTROLS; i++)
        fake->controls[i].value = fake->controls[i].def;
}

/* ---- time and frames ---- */

static bool fated(const struct fake_v4l2 *fake, uint64_t mask, uint64_t n)
{
    return n >= fake->fate_from && n - fake->fate_from < 64 && mask >> (n - fake->fate_from) & 1;
}

static size_t frame_bytes(const struct fake_v4l2 *fake)
{
    const struct v4l2_pixels *p = v4l2_pixels_of(fake->fourcc);
    struct ttf_frame_format f = {.height = fake->height,
                                 .packing = p ? p->packing : TTF_PACKING_NONE};

    return (ttf_row_bytes(f.packing, fake->width) + fake->row_padding) * ttf_frame_rows(&f);
}

static int32_t value_of(struct fake_v4l2 *fake, uint32_t id)
{
    struct fake_control *c = fake_control(fake, id);

    return c ? (int32_t)c->value : -1;
}

/* When frame n has been read out; it comes at once. */
static int64_t read_ns(const struct fake_v4l2 *fake, uint64_t n)
{
    return fake->began_ns + (int64_t)(n + 1) * fake->period_ns;
}

static void fill(struct fake_v4l2 *fake, uint64_t n)
{
    unsigned index = fake->fifo[0];
    struct fake_buffer *b = &fake->buffer[index];
    uint64_t then = n >= fake->delay ? n - fake->delay : 0;
    int32_t *data;
    int64_t stamp = read_ns(fake, n);

    for (unsigned i = 0; i < fake->n_fifo; i++) { /* the first that is not filled */
        index = fake->fifo[i];
        b = &fake->buffer[index];
        if (!b->filled)
            break;
    }
    if (b->filled || !b->queued)
        return; /* dropped for want of a buffer */
    data = b->at;
    data[0] = fake->exposure_then[then % 64];
    data[1] = fake->gain_then[then % 64];
    if ((fake->stamp_flags & V4L2_BUF_FLAG_TSTAMP_SRC_MASK) == V4L2_BUF_FLAG_TSTAMP_SRC_SOE)
        stamp -= fake->readout_ns + data[0] * 100 * TTF_NS_PER_US;
    stamp -= fake->monotonic_lag_ns;
    b->filled = true;
    b->out = (struct v4l2_buffer){
        .index = index,
        .type = V4L2_BUF_TYPE_VIDEO_CAPTURE,
        .memory = V4L2_MEMORY_MMAP,
        .bytesused =
            (uint32_t)(fated(fake, fake->cut, n) ? frame_bytes(fake) / 3 : frame_bytes(fake)),
        .flags = fake->stamp_flags | (fated(fake, fake->in_error, n) ? V4L2_BUF_FLAG_ERROR : 0),
        .sequence = fake->frozen_sequence ? 0 : (uint32_t)n,
        .timestamp = {.tv_sec = stamp / TTF_NS_PER_S,
                      .tv_usec = stamp % TTF_NS_PER_S / TTF_NS_PER_US},
    };
}

/* Makes what has become due, with the controls as they are. */
static void run(struct fake_v4l2 *fake)
{
    int64_t now = ttf_clock_now_ns(fake->clock);

    while (fake->streaming && read_ns(fake, fake->made) <= now) {
        uint64_t n = fake->made++;

        fake->exposure_then[n % 64] = value_of(fake, V4L2_CID_EXPOSURE_ABSOLUTE);
        fake->gain_then[n % 64] = value_of(fake, V4L2_CID_GAIN);
        if (!fated(fake, fake->dropped, n) && !fake->silent && !fake->dead && fake->n_fifo > 0)
            fill(fake, n);
    }
}

uint64_t fake_next_sequence(struct fake_v4l2 *fake)
{
    run(fake);
    return fake->made;
}

void fake_exposed_with(const void *data, int *ret_exposure, int *ret_gain)
{
    *ret_exposure = ((const int32_t *)data)[0];
    *ret_gain = ((const int32_t *)data)[1];
}

/* ---- requests ---- */

static int query_cap(struct fake_v4l2 *fake, struct v4l2_capability *cap)
{
    memset(cap, 0, sizeof(*cap));
    (void)snprintf((char *)cap->driver, sizeof(cap->driver), "%s", fake->driver);
    (void)snprintf((char *)cap->card, sizeof(cap->card), "%s", fake->card);
    (void)snprintf((char *)cap->bus_info, sizeof(cap->bus_info), "%s", fake->bus);
    cap->device_caps = fake->device_caps;
    cap->capabilities = fake->device_caps | V4L2_CAP_DEVICE_CAPS;
    return 0;
}

static int enum_fmt(struct fake_v4l2 *fake, struct v4l2_fmtdesc *desc)
{
    if (desc->index >= 16 || fake->formats[desc->index].fourcc == 0)
        return -EINVAL;
    desc->pixelformat = fake->formats[desc->index].fourcc;
    desc->flags = fake->formats[desc->index].flags;
    return 0;
}

static int enum_sizes(struct fake_v4l2 *fake, struct v4l2_frmsizeenum *size)
{
    static const uint32_t SMALLER[] = {2, 1, 4};

    if (fake->no_sizes || size->index >= 3)
        return -EINVAL;
    size->type = V4L2_FRMSIZE_TYPE_DISCRETE;
    size->discrete.width = fake->width / SMALLER[size->index];
    size->discrete.height = fake->height / SMALLER[size->index];
    return 0;
}

static void tell_format(struct fake_v4l2 *fake, struct v4l2_pix_format *pix)
{
    const struct v4l2_pixels *p = v4l2_pixels_of(fake->fourcc);

    pix->width = fake->width;
    pix->height = fake->height;
    pix->pixelformat = fake->fourcc;
    pix->field = fake->field;
    pix->colorspace = fake->colorspace;
    pix->xfer_func = fake->xfer_func;
    pix->ycbcr_enc = fake->ycbcr_enc;
    pix->quantization = fake->quantization;
    pix->bytesperline =
        (uint32_t)ttf_row_bytes(p ? p->packing : TTF_PACKING_NONE, fake->width) + fake->row_padding;
    pix->sizeimage = (uint32_t)frame_bytes(fake);
}

static int set_format(struct fake_v4l2 *fake, struct v4l2_format *format)
{
    if (fake->n > 0)
        return -EBUSY;
    fake->s_fmt++;
    if (fake->keeps_range && (format->fmt.pix.flags & V4L2_PIX_FMT_FLAG_SET_CSC) &&
        format->fmt.pix.quantization != V4L2_QUANTIZATION_DEFAULT)
        fake->quantization = format->fmt.pix.quantization;
    fake->asked_width = format->fmt.pix.width;
    fake->asked_height = format->fmt.pix.height;
    fake->fourcc = fake->granted_fourcc ? fake->granted_fourcc : format->fmt.pix.pixelformat;
    tell_format(fake, &format->fmt.pix);
    return 0;
}

/* From the frame that is under way on: what was made before keeps its times. */
static void set_period(struct fake_v4l2 *fake, int64_t period_ns)
{
    int64_t last_ns;

    run(fake);
    last_ns = fake->began_ns + (int64_t)fake->made * fake->period_ns;
    if (fake->period_step_ns > 0)
        period_ns =
            (period_ns + fake->period_step_ns / 2) / fake->period_step_ns * fake->period_step_ns;
    fake->period_ns = period_ns;
    fake->began_ns = last_ns - (int64_t)fake->made * period_ns;
    fake->rates++;
}

static int rate(struct fake_v4l2 *fake, struct v4l2_streamparm *parm, bool set)
{
    struct v4l2_fract *per = &parm->parm.capture.timeperframe;

    if (fake->no_rate)
        return -ENOTTY;
    if (set && fake->streaming && !fake->steers)
        return -EBUSY;
    if (set)
        set_period(fake, (int64_t)per->numerator * TTF_NS_PER_S / per->denominator);
    parm->parm.capture.capability = fake->steers ? V4L2_CAP_TIMEPERFRAME : 0;
    per->numerator = (uint32_t)(fake->period_ns / TTF_NS_PER_US);
    per->denominator = 1000000;
    return 0;
}

static int query_control(struct fake_v4l2 *fake, struct v4l2_query_ext_ctrl *q)
{
    bool next = q->id & V4L2_CTRL_FLAG_NEXT_CTRL;
    uint32_t id = q->id & ~(uint32_t)V4L2_CTRL_FLAG_NEXT_CTRL;
    const struct fake_control *found = NULL;

    for (unsigned i = 0; i < FAKE_CONTROLS; i++) {
        const struct fake_control *c = &fake->controls[i];

        if (c->id && (next ? c->id > id && (!found || c->id < found->id) : c->id == id))
            found = c;
    }
    if (!found)
        return -EINVAL;
    memset(q, 0, sizeof(*q));
    q->id = found->id;
    q->type = found->type;
    (void)snprintf(q->name, sizeof(q->name), "%s", found->name);
    q->minimum = found->min;
    q->maximum = found->max;
    q->step = (uint64_t)found->step;
    q->default_value = found->def;
    q->elems = 1;
    return 0;
}

static int one_control(struct fake_v4l2 *fake, struct v4l2_ext_controls *all, bool set)
{
    struct v4l2_ext_control *e = all->controls;
    struct fake_control *c = fake_control(fake, e->id);

    if (!c || all->count != 1)
        return -EINVAL;
    if (!set) {
        if (c->type == V4L2_CTRL_TYPE_INTEGER64)
            e->value64 = c->value;
        else
            e->value = (int32_t)c->value;
        return 0;
    }
    run(fake); /* what came before has the old value */
    if (c->type == V4L2_CTRL_TYPE_MENU && (e->value < c->min || e->value > c->max))
        return -ERANGE;
    if (c->id == V4L2_CID_VBLANK && fake->line_ns > 0)
        set_period(fake, fake->period_ns + (e->value - c->value) * fake->line_ns);
    if (!c->stuck)
        c->value = e->value < c->min ? c->min : e->value > c->max ? c->max : e->value;
    return 0;
}

static int request_buffers(struct fake_v4l2 *fake, struct v4l2_requestbuffers *want)
{
    fake->reqbufs++;
    if (fake->streaming)
        return -EBUSY;
    drop_buffers(fake);
    fake->n = want->count < fake->buffers_max ? want->count : fake->buffers_max;
    want->count = fake->n;
    for (unsigned i = 0; i < fake->n; i++)
        fake->buffer[i].at = calloc(1, frame_bytes(fake) + 8);
    return 0;
}

static int queue_buffer(struct fake_v4l2 *fake, const struct v4l2_buffer *b)
{
    if (b->index >= fake->n || fake->buffer[b->index].queued)
        return -EINVAL;
    if (fake->dead)
        return -EIO;
    run(fake);
    fake->buffer[b->index].queued = true;
    fake->buffer[b->index].filled = false;
    fake->fifo[fake->n_fifo++] = b->index;
    return 0;
}

static int take_buffer(struct fake_v4l2 *fake, struct v4l2_buffer *b)
{
    struct fake_buffer *first;

    if (!fake->streaming)
        return -EINVAL;
    run(fake);
    if (fake->dead)
        return -EIO;
    if (fake->n_fifo == 0 || !fake->buffer[fake->fifo[0]].filled)
        return -EAGAIN;
    first = &fake->buffer[fake->fifo[0]];
    *b = first->out;
    first->queued = first->filled = false;
    memmove(fake->fifo, fake->fifo + 1, (size_t)--fake->n_fifo * sizeof(fake->fifo[0]));
    return 0;
}

static int stream(struct fake_v4l2 *fake, bool on)
{
    if (!on)
        fake->dead = false;
    for (unsigned i = 0; !on && i < fake->n; i++)
        fake->buffer[i].queued = fake->buffer[i].filled = false;
    if (!on)
        fake->n_fifo = 0;
    fake->streaming = on;
    fake->began_ns = ttf_clock_now_ns(fake->clock);
    fake->made = 0;
    return 0;
}

static int answer(struct fake_v4l2 *fake, unsigned long request, void *arg)
{
    switch (request) {
    case VIDIOC_QUERYCAP:
        return query_cap(fake, arg);
    case VIDIOC_ENUM_FMT:
        return enum_fmt(fake, arg);
    case VIDIOC_ENUM_FRAMESIZES:
        return enum_sizes(fake, arg);
    case VIDIOC_G_FMT:
        tell_format(fake, &((struct v4l2_format *)arg)->fmt.pix);
        return 0;
    case VIDIOC_S_FMT:
        return set_format(fake, arg);
    case VIDIOC_G_PARM:
        return rate(fake, arg, false);
    case VIDIOC_S_PARM:
        return rate(fake, arg, true);
    case VIDIOC_S_PRIORITY:
        fake->priority = *(const int *)arg;
        return 0;
    case VIDIOC_QUERY_EXT_CTRL:
        return query_control(fake, arg);
    case VIDIOC_G_EXT_CTRLS:
        return one_control(fake, arg, false);
    case VIDIOC_S_EXT_CTRLS:
        return one_control(fake, arg, true);
    case VIDIOC_REQBUFS:
        return request_buffers(fake, arg);
    case VIDIOC_QUERYBUF:
        ((struct v4l2_buffer *)arg)->length = (uint32_t)frame_bytes(fake) + 8;
        ((struct v4l2_buffer *)arg)->m.offset = ((struct v4l2_buffer *)arg)->index;
        return 0;
    case VIDIOC_QBUF:
        return queue_buffer(fake, arg);
    case VIDIOC_DQBUF:
        return take_buffer(fake, arg);
    case VIDIOC_STREAMON:
        return stream(fake, true);
    case VIDIOC_STREAMOFF:
        return stream(fake, false);
    default:
        return -ENOTTY;
    }
}

/* ---- the table ---- */

static int sys_list(void *ctx, unsigned i, char ret_path[64])
{
    if (i > 0 || of(ctx)->path[0] == '\0')
        return 0;
    memcpy(ret_path, of(ctx)->path, 64);
    return 1;
}

static int sys_open(void *ctx, const char *path)
{
    struct fake_v4l2 *fake = of(ctx);

    if (strcmp(path, fake->path) != 0 || !*path)
        return -ENOENT;
    if (fake->open_failure)
        return fake->open_failure;
    fake->fd = FD + (int)fake->opened++;
    fake->streaming = false;
    drop_buffers(fake);
    return fake->fd;
}

static void sys_close(void *ctx, int fd)
{
    struct fake_v4l2 *fake = of(ctx);

    fake->closed++;
    if (fd == fake->fd) {
        fake->streaming = false;
        drop_buffers(fake);
    }
}

static int sys_ioctl(void *ctx, int fd, unsigned long request, void *arg)
{
    struct fake_v4l2 *fake = of(ctx);

    if (fd != fake->fd || fake->path[0] == '\0')
        return -ENODEV;
    if (request == fake->failing && fake->failures != 0 && fake->served > 0) {
        fake->served--;
    } else if (request == fake->failing && fake->failures != 0) {
        fake->failures -= fake->failures > 0;
        return fake->failure;
    }
    return answer(fake, request, arg);
}

static int sys_map(void *ctx, int fd, size_t length, int64_t offset, void **ret)
{
    struct fake_v4l2 *fake = of(ctx);

    if (offset < 0 || offset >= fake->n || fd != fake->fd)
        return -EINVAL;
    fake->mapped++;
    *ret = fake->buffer[offset].at;
    return 0;
}

static void sys_unmap(void *ctx, void *at, size_t length)
{
    of(ctx)->unmapped++;
}

static void sys_serial(void *ctx, int fd, char ret[64])
{
    (void)fd;
    (void)snprintf(ret, 64, "%s", of(ctx)->serial);
}

/* To the next frame that is to come, or to the deadline. */
static int sys_wait(void *ctx, int fd, struct ttf_clock *clock, int64_t deadline_ns)
{
    struct fake_v4l2 *fake = of(ctx);

    for (;;) {
        int64_t next;

        if (fd != fake->fd || fake->path[0] == '\0' || fake->dead)
            return 1;
        run(fake);
        if (fake->n_fifo > 0 && fake->buffer[fake->fifo[0]].filled)
            return 0;
        if (ttf_clock_now_ns(fake->clock) >= deadline_ns)
            return -ETIMEDOUT;
        next = fake->streaming ? read_ns(fake, fake->made) : deadline_ns;
        ttf_clock_wait_until(fake->clock, next < deadline_ns ? next : deadline_ns);
    }
}

const struct v4l2_sys fake_v4l2_sys = {
    .list = sys_list,
    .open = sys_open,
    .close = sys_close,
    .ioctl = sys_ioctl,
    .map = sys_map,
    .unmap = sys_unmap,
    .serial = sys_serial,
    .wait = sys_wait,
};
