/* SPDX-License-Identifier: Apache-2.0 */
/*
 * systemd.h: what a service tells its manager: the protocol of sd_notify(3), a datagram to the socket that
 * NOTIFY_SOCKET names. Small enough to be kept free of libsystemd, which the lamp guardian would else link.
 */
#ifndef TTF_HAL_SYSTEMD_H
#define TTF_HAL_SYSTEMD_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/watchdog.h"

/*
 * Sends "READY=1", "STATUS=...", "STOPPING=1", or several with newlines between. socket: what NOTIFY_SOCKET says; NULL or
 * empty: nobody listens. 1 sent; 0 nobody listens; a negative errno. Any thread.
 */
int ttf_systemd_notify(const char *socket, const char *state);

/*
 * What the manager's environment says of a watchdog: WATCHDOG_USEC in nanoseconds, if WATCHDOG_PID names this process
 * or is missing (a child of a service inherits both, and is not meant); else 0. Before there are threads.
 */
int64_t ttf_systemd_watchdog_ns(void);

/*
 * A watchdog that tells the manager "WATCHDOG=1". limit_ns: ttf_systemd_watchdog_ns(), by the unit file; arming it
 * for longer than that is refused (-EINVAL), since the unit's limit is what bites. While it is not armed the manager is
 * told to count no time ("WATCHDOG_USEC=0"), from here on. -ENOTSUP: nobody listens; -ENOMEM.
 */
TTF_MUST_USE int ttf_watchdog_systemd_create(const char *socket, int64_t limit_ns,
                                             struct ttf_watchdog **ret, struct ttf_err *err);

#endif
