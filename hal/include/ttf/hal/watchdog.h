/* SPDX-License-Identifier: Apache-2.0 */
/*
 * watchdog.h: what restarts the box when its loop is dead.
 *
 * It is fed by "the loop is alive and its next deadline is armed", not by
 * commits: a disk that is slow is no reason to reboot. One thread at a time.
 */
#ifndef TTF_HAL_WATCHDOG_H
#define TTF_HAL_WATCHDOG_H

#include <stdint.h>

#include "ttf/base/attr.h"

struct ttf_watchdog;

/* Arms it: from now on it must be fed at least every timeout_ns (> 0). -EINVAL, -ENOTSUP. */
TTF_MUST_USE int ttf_watchdog_arm(struct ttf_watchdog *watchdog, int64_t timeout_ns);

/* -EPIPE when not armed. */
TTF_MUST_USE int ttf_watchdog_feed(struct ttf_watchdog *watchdog);

/* A clean end: it will not bite. Harmless when not armed. */
void ttf_watchdog_disarm(struct ttf_watchdog *watchdog);

/* Disarms and frees. NULL allowed. */
void ttf_watchdog_destroy(struct ttf_watchdog *watchdog);

/* --- for authors of back-ends: all ops mandatory --- */
struct ttf_watchdog_ops {
    const char *name;
    int (*arm)(struct ttf_watchdog *watchdog, int64_t timeout_ns);
    int (*feed)(struct ttf_watchdog *watchdog);
    void (*disarm)(struct ttf_watchdog *watchdog);
    void (*destroy)(struct ttf_watchdog *watchdog);
};

struct ttf_watchdog {
    const struct ttf_watchdog_ops *ops;
};

#endif
