/* SPDX-License-Identifier: Apache-2.0 */
/*
 * host_time.h: UTC as a PC says it, for a box whose own clock nobody vouches for: it stands in for that, and for nothing better.
 * Of one boot; clocks of one process share it. Any thread.
 */
#ifndef TTF_HAL_HOST_TIME_H
#define TTF_HAL_HOST_TIME_H

#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/clock.h"

#define TTF_HOST_TIME_LASTS_NS (24 * TTF_NS_PER_H) /* until another PC's word is heard */

struct ttf_host_time;

struct ttf_host_time *ttf_host_time_create(void); /* NULL: no memory */
void ttf_host_time_destroy(
    struct ttf_host_time *host_time); /* NULL allowed; no clock uses it any more */

/*
 * From now on clocks that trust it take it for their UTC where they have none better. clock: one of those. 0: it is taken; -EALREADY: the
 * clock has a better one, or a PC's of less than a day ago; -EINVAL: before 2024 or after 2100.
 */
TTF_MUST_USE int ttf_host_time_offer(struct ttf_host_time *host_time, struct ttf_clock *clock,
                                     int64_t utc_ns, struct ttf_err *err);

/* What it makes of a clock's own belief: nothing, where that is vouched for or no PC said anything. For authors of clocks. */
void ttf_host_time_apply(struct ttf_host_time *host_time, struct ttf_utc *utc);

/* The clock trusts it from now on; before any other thread uses the clock. Clocks that are simulated know their time: nothing happens. */
void ttf_clock_trust_host(struct ttf_clock *clock, struct ttf_host_time *host_time);

#endif
