/* SPDX-License-Identifier: Apache-2.0 */
#include "device.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/watchdog.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include "ttf/base/time.h"

struct device_watchdog {
    struct ttf_watchdog base;
    const struct watchdog_calls *calls;
    int fd; /* -1: not armed */
    char path[64];
};

static void disarm(struct ttf_watchdog *base)
{
    struct device_watchdog *w = (struct device_watchdog *)base;

    if (w->fd < 0)
        return;
    (void)w->calls->write(w->fd, 'V'); /* the magic character: closed on purpose */
    (void)w->calls->close(w->fd);
    w->fd = -1;
}

static int arm(struct ttf_watchdog *base, int64_t timeout_ns)
{
    struct device_watchdog *w = (struct device_watchdog *)base;
    int64_t seconds = timeout_ns / TTF_NS_PER_S + (timeout_ns % TTF_NS_PER_S != 0);
    int granted, r = 0;

    if (seconds > INT_MAX)
        return -EINVAL;
    if (w->fd < 0)
        r = w->fd = w->calls->open(w->path);
    if (r < 0)
        return r;
    granted = (int)seconds;
    r = w->calls->set_timeout(w->fd, &granted);
    if (r == 0 && granted >= seconds)
        return 0;
    disarm(base); /* one that bites sooner than it is fed would be worse than none */
    return r < 0 && r != -ENOTTY ? r : -EINVAL;
}

static int feed(struct ttf_watchdog *base)
{
    struct device_watchdog *w = (struct device_watchdog *)base;

    return w->fd < 0 ? -EPIPE : w->calls->write(w->fd, '\0');
}

static void destroy(struct ttf_watchdog *base)
{
    free(base);
}

static const struct ttf_watchdog_ops OPS = {
    .name = "device", .arm = arm, .feed = feed, .disarm = disarm, .destroy = destroy};

static int call_open(const char *path)
{
    int fd = open(path, O_WRONLY | O_CLOEXEC);

    return fd < 0 ? -errno : fd;
}

static int call_set_timeout(int fd, int *seconds)
{
    return ioctl(fd, WDIOC_SETTIMEOUT, seconds) < 0 ? -errno : 0;
}

static int call_write(int fd, char byte)
{
    return write(fd, &byte, 1) == 1 ? 0 : -errno;
}

static int call_close(int fd)
{
    return close(fd) < 0 ? -errno : 0;
}

static const struct watchdog_calls KERNEL = {call_open, call_set_timeout, call_write, call_close};

int watchdog_device_create_by(const struct watchdog_calls *calls, const char *path,
                              struct ttf_watchdog **ret, struct ttf_err *err)
{
    struct device_watchdog *w;

    if (strlen(path) >= sizeof(w->path))
        return ttf_err_set(err, -ENAMETOOLONG, path, "is too long a path");
    w = calloc(1, sizeof(*w));
    if (!w)
        return ttf_err_set(err, -ENOMEM, NULL, "no memory");
    w->base.ops = &OPS;
    w->calls = calls;
    w->fd = -1;
    memcpy(w->path, path, strlen(path) + 1);
    *ret = &w->base;
    return 0;
}

int ttf_watchdog_device_create(const char *path, struct ttf_watchdog **ret, struct ttf_err *err)
{
    if (access(path, W_OK) < 0) {
        int r = -errno;

        ttf_err_set(err, r, path,
                    r == -ENOENT ? "this machine has no watchdog" : "the watchdog cannot be used");
        ttf_err_hint(err, r == -ENOENT ? "is its driver loaded? softdog is one of software"
                                       : "who runs this must be allowed to write to it");
        return r;
    }
    return watchdog_device_create_by(&KERNEL, path, ret, err);
}
