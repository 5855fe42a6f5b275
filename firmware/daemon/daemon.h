/* SPDX-License-Identifier: Apache-2.0 */
/* daemon.h: what comes when (README.md). */
#ifndef DAEMON_DAEMON_H
#define DAEMON_DAEMON_H

#include <stdbool.h>

#include "ttf/base/err.h"

/* Values of stop. */
#define DAEMON_STOP     1 /* the program is to end */
#define DAEMON_STOP_RUN 2 /* the run is; set by the daemon itself */

struct daemon_options {
    const char *config;
    bool check;         /* reads configuration, board and plan, and ends */
    volatile int *stop; /* DAEMON_STOP, by a signal handler: end */
};

/* Until it is told to end: 0. Else a negative errno, and *err. */
TTF_MUST_USE int daemon_run(const struct daemon_options *options, struct ttf_err *err);

#endif
