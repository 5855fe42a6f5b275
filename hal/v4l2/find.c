/* SPDX-License-Identifier: Apache-2.0 */
#include "find.h"

#include <errno.h>
#include <linux/videodev2.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

/* What was looked at and is not the one, for the message. */
struct seen {
    char text[200];
    size_t n;
    int denied; /* -EACCES or the like of a device that could not be opened */
    char denied_path[64];
};

static void note(struct seen *seen, const struct v4l2_identity *id, const char *why)
{
    int n = snprintf(seen->text + seen->n, sizeof(seen->text) - seen->n, "%s%s '%s' (%s)%s",
                     seen->n ? ", " : "", id->device, id->name, id->bus, why);

    if (n > 0 && (size_t)n < sizeof(seen->text) - seen->n)
        seen->n += (size_t)n;
    else
        seen->text[seen->n] = '\0'; /* only whole ones */
}

static bool begins(const char *text, const char *wanted)
{
    return strncmp(text, wanted, strlen(wanted)) == 0;
}

static bool fits(const struct v4l2_identity *id, const struct ttf_v4l2_config *config,
                 const struct v4l2_identity *known)
{
    if (known)
        return strcmp(id->bus, known->bus) == 0 && strcmp(id->name, known->name) == 0 &&
               strcmp(id->serial, known->serial) == 0;
    return begins(id->bus, config->bus) && begins(id->name, config->name);
}

/* 1: it captures; 0: it does not. */
static int ask(const struct v4l2_sys *sys, void *ctx, int fd, struct v4l2_identity *id)
{
    struct v4l2_capability cap = {0};
    uint32_t caps;
    int r = sys->ioctl(ctx, fd, VIDIOC_QUERYCAP, &cap);

    if (r < 0)
        return r;
    (void)snprintf(id->driver, sizeof(id->driver), "%s", (const char *)cap.driver);
    (void)snprintf(id->name, sizeof(id->name), "%s", (const char *)cap.card);
    (void)snprintf(id->bus, sizeof(id->bus), "%s", (const char *)cap.bus_info);
    sys->serial(ctx, fd, id->serial);
    caps = cap.capabilities & V4L2_CAP_DEVICE_CAPS ? cap.device_caps : cap.capabilities;
    return (caps & V4L2_CAP_VIDEO_CAPTURE) && (caps & V4L2_CAP_STREAMING);
}

/* A descriptor if this is the one, -ENOENT if it is not, else why it cannot be told. */
static int try(const struct v4l2_sys *sys, void *ctx, const struct ttf_v4l2_config *config,
               const struct v4l2_identity *known, struct v4l2_identity *id, struct seen *seen)
{
    int fd = sys->open(ctx, id->device), r;

    if (fd < 0) {
        if (fd != -ENOENT && fd != -ENODEV && fd != -ENXIO) {
            seen->denied = fd;
            memcpy(seen->denied_path, id->device, sizeof(seen->denied_path));
        }
        return fd;
    }
    r = ask(sys, ctx, fd, id);
    if (r > 0 && fits(id, config, known))
        return fd;
    if (r >= 0)
        note(seen, id, r == 0 ? ", which does not capture into memory" : "");
    sys->close(ctx, fd);
    return r < 0 ? r : -ENOENT;
}

static int not_found(const struct ttf_v4l2_config *config, const struct v4l2_identity *known,
                     const struct seen *seen, struct ttf_err *err)
{
    if (known)
        ttf_err_set(err, -ENODEV, known->device, "the camera '%s' (%s) is gone", known->name,
                    known->bus);
    else if (seen->denied)
        return ttf_err_set(err, seen->denied, seen->denied_path, "the camera cannot be opened: %s",
                           strerrordesc_np(-seen->denied));
    else
        ttf_err_set(err, -ENODEV, config->device[0] ? config->device : NULL, "no such camera%s%s%s",
                    config->name[0] || config->bus[0] ? " as " : "", config->name, config->bus);
    if (seen->n > 0)
        ttf_err_hint(err, "there is %s", seen->text);
    else
        ttf_err_hint(err, "there is no video device at all: look at the cable, and at `dmesg`");
    return -ENODEV;
}

/* How many devices but this one capture and are called as it is; the last of them opened, if that is wanted. */
static unsigned count_namesakes(const struct v4l2_sys *sys, void *ctx,
                                const struct v4l2_identity *self, struct v4l2_identity *ret,
                                int *ret_fd)
{
    struct v4l2_identity id = {0};
    unsigned n = 0;

    for (unsigned i = 0; sys->list(ctx, i, id.device) > 0; i++) {
        int fd = strcmp(id.device, self->device) == 0 && !ret_fd ? -1 : sys->open(ctx, id.device);

        if (fd < 0)
            continue;
        if (ask(sys, ctx, fd, &id) <= 0 || strcmp(id.name, self->name) != 0 ||
            strcmp(id.bus, self->bus) == 0) {
            sys->close(ctx, fd);
            continue;
        }
        n++;
        if (ret_fd && *ret_fd >= 0)
            sys->close(ctx, *ret_fd);
        if (ret_fd) {
            *ret_fd = fd;
            *ret = id;
        } else {
            sys->close(ctx, fd);
        }
    }
    return n;
}

/* Of a serial number, wherever it is. */
static int find_serial(const struct v4l2_sys *sys, void *ctx, const struct v4l2_identity *known,
                       struct v4l2_identity *ret)
{
    struct v4l2_identity id = {0};

    for (unsigned i = 0; sys->list(ctx, i, id.device) > 0; i++) {
        int fd = sys->open(ctx, id.device);

        if (fd < 0)
            continue;
        if (ask(sys, ctx, fd, &id) > 0 && strcmp(id.name, known->name) == 0 &&
            strcmp(id.serial, known->serial) == 0) {
            *ret = id;
            return fd;
        }
        sys->close(ctx, fd);
    }
    return -ENODEV;
}

/* In another socket. A board that names a bus means that very socket. */
static int find_moved(const struct v4l2_sys *sys, void *ctx, const struct ttf_v4l2_config *config,
                      const struct v4l2_identity *known, struct v4l2_identity *ret)
{
    int fd = -ENODEV;

    if (config->bus[0])
        return -ENODEV;
    if (known->serial[0])
        return find_serial(sys, ctx, known, ret);
    if (known->namesakes == 0 && count_namesakes(sys, ctx, known, ret, &fd) == 1 &&
        ret->serial[0] == '\0')
        return fd;
    if (fd >= 0)
        sys->close(ctx, fd);
    return -ENODEV;
}

int v4l2_find(const struct v4l2_sys *sys, void *ctx, const struct ttf_v4l2_config *config,
              const struct v4l2_identity *known, struct v4l2_identity *ret, struct ttf_err *err)
{
    struct v4l2_identity id = {0};
    struct seen seen = {0};
    int fd = -ENODEV;

    if (config->device[0]) {
        memcpy(id.device, config->device, sizeof(id.device));
        fd = try(sys, ctx, config, known, &id, &seen);
    }
    /* A camera that was unplugged may come back under another number; one that was never there may not. */
    for (unsigned i = 0;
         fd < 0 && (!config->device[0] || known) && sys->list(ctx, i, id.device) > 0; i++)
        if (strcmp(id.device, config->device) != 0)
            fd = try(sys, ctx, config, known, &id, &seen);
    if (fd < 0 && known)
        fd = find_moved(sys, ctx, config, known, &id);
    if (fd < 0)
        return not_found(config, known, &seen, err);
    *ret = id;
    ret->namesakes = known ? known->namesakes : count_namesakes(sys, ctx, &id, NULL, NULL);
    return fd;
}
