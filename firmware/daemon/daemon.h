/* SPDX-License-Identifier: Apache-2.0 */
/* daemon.h: what comes when (README.md). */
#ifndef DAEMON_DAEMON_H
#define DAEMON_DAEMON_H

#include <stdbool.h>

#include "ttf/base/err.h"

struct daemon_options {
    const char *config;
    bool check;               /* reads configuration, board and plan, and ends */
    const volatile int *stop; /* becomes non-zero: end */
};

/* Until it is told to end: 0. Else a negative errno, and *err. */
TTF_MUST_USE int daemon_run(const struct daemon_options *options, struct ttf_err *err);

#endif
