/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/hal/watchdog.h"

#include <errno.h>
#include <stddef.h>

int ttf_watchdog_arm(struct ttf_watchdog *watchdog, int64_t timeout_ns)
{
    return timeout_ns > 0 ? watchdog->ops->arm(watchdog, timeout_ns) : -EINVAL;
}

int ttf_watchdog_feed(struct ttf_watchdog *watchdog)
{
    return watchdog->ops->feed(watchdog);
}

void ttf_watchdog_disarm(struct ttf_watchdog *watchdog)
{
    watchdog->ops->disarm(watchdog);
}

void ttf_watchdog_destroy(struct ttf_watchdog *watchdog)
{
    if (!watchdog)
        return;
    watchdog->ops->disarm(watchdog);
    watchdog->ops->destroy(watchdog);
}
