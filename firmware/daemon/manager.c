/* SPDX-License-Identifier: Apache-2.0 */
#include "manager.h"

#include <inttypes.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/hal/systemd.h"

void manager_find(struct manager *manager)
{
    manager->socket = getenv("NOTIFY_SOCKET"); /* NOLINT(concurrency-mt-unsafe) */
    manager->watchdog_ns = ttf_systemd_watchdog_ns();
}

void manager_tell(struct manager *manager, const char *state)
{
    (void)ttf_systemd_notify(manager->socket, state);
}

void manager_status(struct manager *manager, const char *fmt, ...)
{
    char text[sizeof manager->said], state[sizeof text + 16];
    va_list args;

    va_start(args, fmt);
    /* NOLINTNEXTLINE(clang-analyzer-valist.Uninitialized): it is begun above */
    (void)vsnprintf(text, sizeof text, fmt, args);
    va_end(args);
    for (char *c = text; *c; c++)
        if (*c == '\n')
            *c = ' '; /* would begin another word of the protocol */
    if (strcmp(text, manager->said) == 0)
        return;
    memcpy(manager->said, text, sizeof text);
    (void)snprintf(state, sizeof state, "STATUS=%s", text);
    manager_tell(manager, state);
}

void manager_wait(struct manager *manager, int64_t ns)
{
    int64_t most_ns = ns > manager->watchdog_ns ? ns : manager->watchdog_ns;
    char state[80];

    if (manager->watchdog_ns <= 0)
        return;
    (void)snprintf(state, sizeof state, "WATCHDOG_USEC=%" PRId64 "\nWATCHDOG=1",
                   most_ns / TTF_NS_PER_US);
    manager_tell(manager, state);
}

struct ttf_watchdog *manager_watchdog(const struct manager *manager)
{
    struct ttf_watchdog *watchdog = NULL;

    if (!manager->socket || manager->watchdog_ns <= 0 ||
        ttf_watchdog_systemd_create(manager->socket, manager->watchdog_ns, &watchdog, NULL) < 0)
        return NULL;
    if (ttf_watchdog_arm(watchdog, manager->watchdog_ns) == 0)
        return watchdog;
    ttf_watchdog_destroy(watchdog);
    return NULL;
}
