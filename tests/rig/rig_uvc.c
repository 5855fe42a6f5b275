/* SPDX-License-Identifier: Apache-2.0 */
/*
 * rig_uvc [silent]: the camera's end of a webcam at USB, by the kernel's usb_f_uvc (rig-uvc of modules.sh), whose settings are
 * seen in its pictures. It ends when its device does. Lines of standard input are faults (rig_uvc.h); each value that is
 * asked of it is a line of its output.
 */
#include "rig_uvc.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/usb/video.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <sys/timerfd.h>
#include <time.h>
#include <unistd.h>

#include "ttf/base/time.h"

#define WIDTH       320
#define HEIGHT      180
#define FRAME_BYTES (WIDTH * HEIGHT * 2)
#define PACKET      3072
#define BUFFERS     4
#define DELAY       2 /* frames until a setting shows, as sensors have it */

/* As they stand in the descriptors that uvc.py writes; units of 100 ns. */
static const uint32_t INTERVALS[] = {1000000, 2500000};

struct gadget {
    int fd, timer_fd;
    struct rig_uvc_controls controls;
    struct usb_ctrlrequest pending; /* whose data are to come */
    struct uvc_streaming_control probe, commit;
    bool streaming;
    uint8_t *at[BUFFERS];
    bool queued[BUFFERS];
    struct rig_uvc_light later[DELAY];
    unsigned dropped;
};

/* ---- the stream ---- */

static void fill(struct uvc_streaming_control *ctrl, uint32_t interval)
{
    bool slow = interval > (INTERVALS[0] + INTERVALS[1]) / 2;

    *ctrl = (struct uvc_streaming_control){.bmHint = 1,
                                           .bFormatIndex = 1,
                                           .bFrameIndex = 1,
                                           .dwFrameInterval = INTERVALS[slow ? 1 : 0],
                                           .dwMaxVideoFrameSize = FRAME_BYTES,
                                           .dwMaxPayloadTransferSize = PACKET,
                                           .bmFramingInfo = 3,
                                           .bPreferedVersion = 1,
                                           .bMaxVersion = 1};
}

static int map_buffers(struct gadget *g)
{
    struct v4l2_requestbuffers req = {
        .count = BUFFERS, .type = V4L2_BUF_TYPE_VIDEO_OUTPUT, .memory = V4L2_MEMORY_MMAP};

    if (ioctl(g->fd, VIDIOC_REQBUFS, &req) < 0 || req.count != BUFFERS)
        return -errno;
    for (unsigned i = 0; i < BUFFERS; i++) {
        struct v4l2_buffer b = {.index = i, .type = req.type, .memory = req.memory};

        if (ioctl(g->fd, VIDIOC_QUERYBUF, &b) < 0)
            return -errno;
        g->at[i] = mmap(NULL, b.length, PROT_READ | PROT_WRITE, MAP_SHARED, g->fd, b.m.offset);
        if (g->at[i] == MAP_FAILED || b.length < FRAME_BYTES)
            return -ENOMEM;
        g->queued[i] = false;
    }
    return 0;
}

static void unmap_buffers(struct gadget *g)
{
    struct v4l2_requestbuffers none = {.type = V4L2_BUF_TYPE_VIDEO_OUTPUT,
                                       .memory = V4L2_MEMORY_MMAP};

    for (unsigned i = 0; i < BUFFERS; i++) {
        if (g->at[i] && g->at[i] != MAP_FAILED)
            (void)munmap(g->at[i], FRAME_BYTES);
        g->at[i] = NULL;
    }
    (void)ioctl(g->fd, VIDIOC_REQBUFS, &none);
}

static void stream_off(struct gadget *g)
{
    int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    struct itimerspec never = {0};

    if (!g->streaming)
        return;
    g->streaming = false;
    (void)timerfd_settime(g->timer_fd, 0, &never, NULL);
    (void)ioctl(g->fd, VIDIOC_STREAMOFF, &type);
    unmap_buffers(g);
    printf("stream off, %u frames dropped\n", g->dropped);
}

static int stream_on(struct gadget *g)
{
    int type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    long ns = (long)g->commit.dwFrameInterval * 100;
    struct itimerspec each = {.it_interval.tv_nsec = ns, .it_value.tv_nsec = ns};
    int r;

    stream_off(g);
    r = map_buffers(g);
    if (r < 0)
        return r;
    if (ioctl(g->fd, VIDIOC_STREAMON, &type) < 0 ||
        timerfd_settime(g->timer_fd, 0, &each, NULL) < 0)
        return -errno;
    g->streaming = true;
    g->dropped = 0;
    for (unsigned i = 0; i < DELAY; i++)
        g->later[i] = rig_uvc_controls_light(&g->controls, (int)(ns / 100000));
    printf("stream on, a frame each %ld ms\n", ns / 1000000);
    return 0;
}

static void reclaim(struct gadget *g)
{
    struct v4l2_buffer b = {.type = V4L2_BUF_TYPE_VIDEO_OUTPUT, .memory = V4L2_MEMORY_MMAP};

    while (ioctl(g->fd, VIDIOC_DQBUF, &b) == 0)
        g->queued[b.index] = false;
}

/* A frame's exposure ends. */
static void frame(struct gadget *g)
{
    struct rig_uvc_light light = g->later[0];
    struct timespec now;
    unsigned i = 0;

    memmove(g->later, g->later + 1, sizeof(g->later) - sizeof(*g->later));
    g->later[DELAY - 1] =
        rig_uvc_controls_light(&g->controls, (int)(g->commit.dwFrameInterval / 1000));
    reclaim(g);
    while (i < BUFFERS && g->queued[i])
        i++;
    if (i == BUFFERS) {
        g->dropped++;
        return;
    }
    rig_uvc_picture(&light, WIDTH, HEIGHT, g->at[i]);
    (void)clock_gettime(CLOCK_MONOTONIC, &now);
    struct v4l2_buffer b = {.index = i,
                            .type = V4L2_BUF_TYPE_VIDEO_OUTPUT,
                            .memory = V4L2_MEMORY_MMAP,
                            .bytesused = FRAME_BYTES,
                            .timestamp = {.tv_sec = now.tv_sec, .tv_usec = now.tv_nsec / 1000}};
    g->queued[i] = ioctl(g->fd, VIDIOC_QBUF, &b) == 0;
}

/* ---- requests ---- */

static bool of_stream(const struct usb_ctrlrequest *asked)
{
    return (asked->wIndex & 0xff) != 0;
}

static void answer_stream(struct gadget *g, const struct usb_ctrlrequest *asked,
                          struct uvc_request_data *ret)
{
    struct uvc_streaming_control now = g->probe;
    uint8_t which = asked->wValue >> 8;

    memset(ret, 0, sizeof(*ret));
    ret->length = -1;
    if (which != UVC_VS_PROBE_CONTROL && which != UVC_VS_COMMIT_CONTROL)
        return;
    if (which == UVC_VS_COMMIT_CONTROL)
        now = g->commit;
    if (asked->bRequest == UVC_GET_DEF)
        fill(&now, INTERVALS[0]);
    if (asked->bRequest == UVC_GET_INFO) {
        ret->length = 1;
        ret->data[0] = UVC_CONTROL_CAP_GET | UVC_CONTROL_CAP_SET;
    } else if (asked->bRequest == UVC_GET_LEN) {
        ret->length = 2;
        ret->data[0] = sizeof(now);
    } else { /* CUR, MIN, MAX, DEF, and the length of data to come */
        ret->length = asked->wLength < sizeof(now) ? asked->wLength : (int)sizeof(now);
        if (asked->bRequest != UVC_SET_CUR)
            memcpy(ret->data, &now, sizeof(now));
    }
}

static void setup(struct gadget *g, const struct usb_ctrlrequest *asked)
{
    struct uvc_request_data answer;

    if (of_stream(asked))
        answer_stream(g, asked, &answer);
    else
        rig_uvc_controls_answer(&g->controls, asked, &answer);
    g->pending = *asked;
    if (ioctl(g->fd, UVCIOC_SEND_RESPONSE, &answer) < 0)
        printf("no answer to request %#x of %#x: %m\n", asked->bRequest, asked->wValue);
}

static void data(struct gadget *g, const struct uvc_request_data *came)
{
    struct uvc_streaming_control asked = {0};

    if (!of_stream(&g->pending)) {
        rig_uvc_controls_set(&g->controls, &g->pending, came);
        return;
    }
    if (came->length < 26) /* of the oldest version */
        return;
    memcpy(&asked, came->data,
           (size_t)came->length < sizeof(asked) ? (size_t)came->length : sizeof(asked));
    fill(g->pending.wValue >> 8 == UVC_VS_COMMIT_CONTROL ? &g->commit : &g->probe,
         asked.dwFrameInterval);
}

/* 0, or that the device is gone. */
static int events(struct gadget *g)
{
    struct v4l2_event event;
    const struct uvc_event *uvc = (const void *)event.u.data;
    int r = 0;

    while (r == 0 && ioctl(g->fd, VIDIOC_DQEVENT, &event) == 0) {
        if (event.type == UVC_EVENT_SETUP)
            setup(g, &uvc->req);
        else if (event.type == UVC_EVENT_DATA)
            data(g, &uvc->data);
        else if (event.type == UVC_EVENT_STREAMON)
            r = stream_on(g);
        else if (event.type == UVC_EVENT_STREAMOFF || event.type == UVC_EVENT_DISCONNECT)
            stream_off(g);
    }
    return r < 0 ? r : errno == ENODEV ? -ENODEV : 0;
}

/* ---- life ---- */

/* The node of the gadget's function. */
static int open_gadget(void)
{
    for (unsigned i = 0; i < 16; i++) {
        struct v4l2_capability cap;
        char path[32];
        int fd;

        (void)snprintf(path, sizeof(path), "/dev/video%u", i);
        fd = open(path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
        if (fd < 0)
            continue;
        if (ioctl(fd, VIDIOC_QUERYCAP, &cap) == 0 && strcmp((char *)cap.driver, "g_uvc") == 0)
            return fd;
        (void)close(fd);
    }
    return -ENODEV;
}

static int subscribe(int fd)
{
    for (uint32_t type = UVC_EVENT_CONNECT; type <= UVC_EVENT_DATA; type++) {
        struct v4l2_event_subscription s = {.type = type};

        /* With that of requests the camera appears at its cable; that is the last but one. */
        if (ioctl(fd, VIDIOC_SUBSCRIBE_EVENT, &s) < 0)
            return -errno;
    }
    return 0;
}

static int serve(struct gadget *g)
{
    struct pollfd fds[] = {{.fd = g->fd, .events = POLLPRI},
                           {.fd = g->timer_fd, .events = POLLIN},
                           {.fd = STDIN_FILENO, .events = POLLIN}};
    char line[64];
    uint64_t n;
    int r = 0;

    while (r == 0) {
        if (poll(fds, 3, -1) < 0)
            return -errno;
        if (fds[0].revents & (POLLERR | POLLHUP | POLLNVAL))
            return -ENODEV;
        if (fds[0].revents)
            r = events(g);
        if (fds[1].revents && read(g->timer_fd, &n, sizeof(n)) > 0 && g->streaming)
            frame(g);
        if (fds[2].revents && !fgets(line, sizeof(line), stdin))
            fds[2].fd = -1;
        else if (fds[2].revents)
            printf("%s: %s", rig_uvc_controls_fault(&g->controls, line) ? "fault" : "what?", line);
    }
    return r;
}

int main(int argc, char **argv)
{
    struct gadget g = {.fd = open_gadget(),
                       .timer_fd = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK)};
    int r;

    setvbuf(stdout, NULL, _IOLBF, 0);
    setvbuf(stdin, NULL, _IONBF, 0);
    if (g.fd < 0 || g.timer_fd < 0) {
        printf("there is no UVC gadget\n");
        return 1;
    }
    rig_uvc_controls_reset(&g.controls, argc > 1 && strcmp(argv[1], "silent") == 0);
    fill(&g.probe, INTERVALS[0]);
    fill(&g.commit, INTERVALS[0]);
    r = subscribe(g.fd);
    if (r == 0) {
        printf("ready\n");
        r = serve(&g);
    }
    stream_off(&g);
    printf("over: %s\n", strerrordesc_np(-r));
    (void)close(g.fd);
    (void)close(g.timer_fd);
    return 0;
}
