/* SPDX-License-Identifier: Apache-2.0 */
/* manager.h: what the service manager hears (README.md). One thread at a time. */
#ifndef DAEMON_MANAGER_H
#define DAEMON_MANAGER_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/hal/watchdog.h"

struct manager {
    const char *socket;  /* NULL: nobody listens */
    int64_t watchdog_ns; /* WATCHDOG_USEC, if it is meant for this process; 0 */
    char said[256];      /* the last status */
};

/* From the environment; before there are threads. */
void manager_find(struct manager *manager);

/* "READY=1", "STOPPING=1". */
void manager_tell(struct manager *manager, const char *state);

/* In words; the same twice is said once. */
void manager_status(struct manager *manager, const char *fmt, ...) TTF_PRINTF(2, 3);

/* What comes now may take so long, and nobody feeds meanwhile: more than WATCHDOG_USEC too, which a watchdog is never armed for.
 * Whoever arms one again ends it. */
void manager_wait(struct manager *manager, int64_t ns);

/* A watchdog for while nothing runs, armed; NULL: nobody watches. */
struct ttf_watchdog *manager_watchdog(const struct manager *manager);

#endif
