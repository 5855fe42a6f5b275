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
 * The same with a descriptor that the manager keeps (FDSTORE=1, FDNAME=...): its copy outlives this process, and the next one gets it.
 * The unit needs FileDescriptorStoreMax=.
 */
int ttf_systemd_notify_fd(const char *socket, const char *state, int with);

/*
 * The descriptor of this name (FDNAME) that the manager has kept and now handed over (LISTEN_FDS), closed by exec; if there are
 * several, the first. -ENOENT: none, or they were meant for another process. Before there are threads; it takes the
 * variables from the environment, so that it says so once, and to no child.
 */
TTF_MUST_USE int ttf_systemd_kept_fd(const char *name);

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
