/* SPDX-License-Identifier: Apache-2.0 */
/* utc_watch.h: notices when UTC steps or becomes better vouched for. Pure. */
#ifndef TTF_CAPTURE_PRIVATE_UTC_WATCH_H
#define TTF_CAPTURE_PRIVATE_UTC_WATCH_H

#include <stdbool.h>

#include "ttf/hal/clock.h"

/* A jump of UTC against the boot clock beyond this is a step, not slewing. */
#define TTF_UTC_STEP_NS (100 * TTF_NS_PER_MS)

struct ttf_utc_watch {
    int64_t offset_ns; /* UTC - boot clock, as last seen */
    enum ttf_trust trust;
    uint32_t steps;
};

struct ttf_utc_news {
    bool stepped;
    int64_t step_ns;   /* by how much, positive: forward */
    bool more_trusted; /* trust has risen */
};

void ttf_utc_watch_init(struct ttf_utc_watch *watch, const struct ttf_utc *utc);

/* What changed since the last look. True if anything did. */
bool ttf_utc_watch_look(struct ttf_utc_watch *watch, const struct ttf_utc *utc,
                        struct ttf_utc_news *ret);

/* UTC of an instant of the boot clock; TTF_NS_UNKNOWN if nobody vouches. */
int64_t ttf_utc_watch_at(const struct ttf_utc_watch *watch, int64_t boot_ns);

#endif
