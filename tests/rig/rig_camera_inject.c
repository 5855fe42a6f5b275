/* SPDX-License-Identifier: Apache-2.0 */
/* rig_camera_inject.c: vivid's faults set in a program that captures with it, from outside of that. */
#include <linux/videodev2.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <sys/syscall.h>
#include <unistd.h>

#include "rig_camera.h"
#include "ttf/base/time.h"

#define DESCRIPTORS 256

/*
 * A fault that waits for a stream to be set going comes with one that makes the box do so. One that spoils a single
 * buffer is set in several slots, a second apart: a busy machine may be late by a frame, and what it hits is nobody's.
 */
static const struct injection {
    const char *name;
    uint32_t first, then;
    int times;
} INJECTIONS[] = {
    {"disconnect", VIVID_DISCONNECT, 0, 1},       {"error-flag", VIVID_ERROR_FLAG, 0, 4},
    {"reqbufs", VIVID_REQBUFS, VIVID_FATAL, 1},   {"qbuf", VIVID_QBUF, 0, 1},
    {"streamon", VIVID_STREAMON, VIVID_FATAL, 1}, {"fatal", VIVID_FATAL, 0, 1},
};

/*
 * The very descriptor that a process has of a video device, or -1: while the box has the driver's highest priority, a
 * control is set by nobody else.
 */
static int descriptor_of(pid_t pid)
{
    int pidfd = (int)syscall(SYS_pidfd_open, pid, 0);
    char path[64], device[64];
    int fd = -1;

    for (int i = 0; i < DESCRIPTORS && fd < 0; i++) {
        ssize_t n;

        (void)snprintf(path, sizeof(path), "/proc/%d/fd/%d", (int)pid, i);
        n = readlink(path, device, sizeof(device) - 1);
        device[n < 0 ? 0 : n] = '\0';
        if (strncmp(device, "/dev/video", 10) == 0)
            fd = (int)syscall(SYS_pidfd_getfd, pidfd, i, 0);
    }
    if (pidfd >= 0)
        (void)close(pidfd);
    return fd;
}

/* 0 is no control. */
static int press(int fd, uint32_t id)
{
    struct v4l2_control c = {.id = id, .value = 1};

    return id == 0 ? 0 : ioctl(fd, VIDIOC_S_CTRL, &c);
}

/* 0, or what is wrong. */
static const char *inject(const struct injection *fault, struct ttf_clock *clock, pid_t pid,
                          int64_t when_ns)
{
    const char *wrong = NULL;
    int fd;

    ttf_clock_wait_until(clock, when_ns - TTF_NS_PER_S / 5);
    fd = descriptor_of(pid);
    if (fd < 0)
        return "it has no video device open";
    ttf_clock_wait_until(clock, when_ns);
    if (press(fd, fault->first) < 0 || press(fd, fault->then) < 0)
        wrong = "the driver refuses it";
    /* At once: a vivid that was disconnected is back when its last user has let go. */
    (void)close(fd);
    return wrong;
}

int rig_inject(const char *name)
{
    struct ttf_clock *clock = ttf_clock_real_create();
    const struct injection *fault = NULL;
    const char *wrong = "no such fault";
    char text[64], *end = text;
    pid_t pid;

    for (unsigned i = 0; i < TTF_COUNT_OF(INJECTIONS); i++)
        if (strcmp(INJECTIONS[i].name, name) == 0)
            fault = &INJECTIONS[i];
    if (clock && fault && fgets(text, sizeof(text), stdin)) {
        pid = (pid_t)strtol(text, &end, 10);
        wrong = NULL;
        for (int i = 0; i < fault->times && !wrong; i++)
            wrong = inject(fault, clock, pid, strtoll(end, NULL, 10) + i * TTF_NS_PER_S);
    }
    ttf_clock_destroy(clock);
    printf("%s\n", wrong ? wrong : "set");
    return wrong != NULL;
}
