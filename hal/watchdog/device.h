/* SPDX-License-Identifier: Apache-2.0 */
/* device.h: what is asked of the kernel, so that a test can be the kernel. */
#ifndef TTF_HAL_WATCHDOG_DEVICE_PRIVATE_H
#define TTF_HAL_WATCHDOG_DEVICE_PRIVATE_H

#include <stddef.h>

#include "ttf/hal/watchdog_device.h"

/* Each returns as the call it stands for, or a negative errno. */
struct watchdog_calls {
    int (*open)(const char *path);
    int (*set_timeout)(int fd, int *seconds); /* *seconds becomes what the driver made of it */
    int (*write)(int fd, char byte);
    int (*close)(int fd);
};

TTF_MUST_USE int watchdog_device_create_by(const struct watchdog_calls *calls, const char *path,
                                           struct ttf_watchdog **ret, struct ttf_err *err);

#endif
