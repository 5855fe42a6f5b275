/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lampd.h: both ends of the lamp guardian as a process of its own (hal/lampd/README.md): the guardian, which
 * alone holds the lamps' lines, and its clients, which are lamps as lamps.h knows them.
 */
#ifndef TTF_HAL_LAMPD_H
#define TTF_HAL_LAMPD_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/clock.h"
#include "ttf/hal/lamps.h"
#include "ttf/hal/lines.h"
#include "ttf/hal/sensors.h"
#include "ttf/hal/watchdog.h"

#define TTF_LAMPD_SOCKET "/run/ttfbox/lampd.sock" /* where it is on a box */

struct ttf_lampd;

/* All borrowed: they must outlive the guardian. */
struct ttf_lampd_config {
    const char *socket;               /* path; what lies there is replaced */
    unsigned n;                       /* lamps */
    const struct ttf_lamp_info *info; /* n of them */
    struct ttf_lines *lines;          /* output i drives lamp i */
    int door;                         /* the line that is active while the door is open; -1: none */
    struct ttf_clock *clock;
    struct ttf_sensors *sensors;   /* NULL: a lamp with a max_temp stays dark */
    const char *temp_sensor;       /* its name; NULL: the first that gives a temperature */
    struct ttf_watchdog *watchdog; /* NULL: none; armed by run with watchdog_ns, fed once a round */
    int64_t watchdog_ns;
};

/*
 * Opens the socket, starts the thread that reads temperatures. All lamps are dark, and count as burnt
 * (ttf_guardian_assume_used): nothing is known of what was before. -EADDRINUSE: another guardian answers there;
 * -EINVAL, -ENOMEM, errors of the socket. After this nothing is allocated.
 */
TTF_MUST_USE int ttf_lampd_create(const struct ttf_lampd_config *config, struct ttf_lampd **ret,
                                  struct ttf_err *err);

/* Guards until *stop becomes non-zero (looked at every 50 ms, and when a signal interrupts); then all lamps are dark. 0. */
int ttf_lampd_run(struct ttf_lampd *lampd, const volatile int *stop);

/*
 * Frees; the socket's path is removed. 0. NULL allowed. -EBUSY: the thread that reads temperatures hangs in a sensor's driver, and was
 * waited for as long as one does that hears it; clock and sensors must not be freed, the lines may. To be called again, or left to the end of the process.
 */
int ttf_lampd_destroy(struct ttf_lampd *lampd);

/*
 * A client. What the lamps are is asked of the guardian. A thread of its own renews the lease. If the guardian
 * ends, commands fail with -ESTALE (off: -ENODEV, its lines are dark or beyond anyone's reach) until acquire finds it
 * again. One that hangs is waited for 300 ms a call, and is then as one that has ended.
 * -ENOENT, -ECONNREFUSED: no guardian there; -ENODEV: it does not answer; -EPROTO: another version; -ENOMEM.
 */
TTF_MUST_USE int ttf_lamps_lampd_create(const char *socket, struct ttf_clock *clock,
                                        struct ttf_lamps **ret, struct ttf_err *err);

/* When the guardian last felt the door move, on the boot clock; TTF_NS_UNKNOWN: not since it began. */
struct ttf_door_past {
    int64_t opened_ns, closed_ns;
};

/*
 * Of such lamps: 1 door open, 0 closed, -ENOTSUP without a door switch, -ENODEV without a guardian. ret_past: NULL
 * allowed; written unless it fails. Any thread.
 */
TTF_MUST_USE int ttf_lamps_lampd_door(struct ttf_lamps *lamps, struct ttf_door_past *ret_past);

#endif
