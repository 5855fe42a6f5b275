/* SPDX-License-Identifier: Apache-2.0 */
/*
 * duty.h: how long a lamp has been on within a sliding window. Private to the
 * guardian. Times are boot-clock nanoseconds.
 */
#ifndef TTF_HAL_GUARDIAN_DUTY_H
#define TTF_HAL_GUARDIAN_DUTY_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/hal/guardian.h"

/* True if the lamp's share of a window is limited at all. */
bool duty_limited(const struct ttf_lamp_info *info);

/* Longest time on within any window. */
int64_t duty_limit_ns(const struct ttf_lamp_info *info);

/* Time on within (at_ns - window, at_ns], the running stretch included; never less than it truly was. */
int64_t duty_used_ns(const struct ttf_lamp_info *info, const struct ttf_guardian_lamp *lamp,
                     int64_t at_ns);

/* The first instant >= now_ns at which a lamp that is on and stays on has used up its share. */
int64_t duty_exhausted_ns(const struct ttf_lamp_info *info, const struct ttf_guardian_lamp *lamp,
                          int64_t now_ns);

/* The lamp was on from from_ns to to_ns. */
void duty_record(const struct ttf_lamp_info *info, struct ttf_guardian_lamp *lamp, int64_t from_ns,
                 int64_t to_ns);

#endif
