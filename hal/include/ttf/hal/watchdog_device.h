/* SPDX-License-Identifier: Apache-2.0 */
/* watchdog_device.h: the machine's own watchdog, /dev/watchdog, as the kernel's Documentation/watchdog/watchdog-api.rst has it. */
#ifndef TTF_HAL_WATCHDOG_DEVICE_H
#define TTF_HAL_WATCHDOG_DEVICE_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/watchdog.h"

#define TTF_WATCHDOG_DEVICE "/dev/watchdog"

/*
 * Opened when it is armed, not before, since opening starts it: what dies armed resets the machine. Arming it is -EBUSY if
 * another holds it (systemd does, with RuntimeWatchdogSec), -EINVAL if it cannot wait for as long as it should. Disarming
 * is the kernel's "magic close"; a driver that is set never to stop (nowayout) bites nevertheless. -ENOENT: there is
 * none; -EACCES; -ENOMEM.
 */
TTF_MUST_USE int ttf_watchdog_device_create(const char *path, struct ttf_watchdog **ret,
                                            struct ttf_err *err);

#endif
