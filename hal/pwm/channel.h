/* SPDX-License-Identifier: Apache-2.0 */
/* channel.h: one channel of a PWM chip as files: found, exported, held, made dark, lit. */
#ifndef TTF_HAL_PWM_CHANNEL_H
#define TTF_HAL_PWM_CHANNEL_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/lines.h"

struct pwm_channel {
    int folder; /* its own, open and locked; -1: not held */
    int64_t period_ns;
    unsigned permille; /* what it was last told */
};

/* Finds it, takes hold of it, dark. Errors as ttf_lines_pwm_create. */
TTF_MUST_USE int pwm_channel_hold(const char *root, const struct ttf_line_spec *spec,
                                  struct pwm_channel *ret, struct ttf_err *err);
/* -ENODEV: it is gone; what the driver says. After a failure it is as dark as could be done. */
TTF_MUST_USE int pwm_channel_set(struct pwm_channel *channel, unsigned permille);
/* 1 lit, 0 dark, as the driver says; -ENODEV. */
TTF_MUST_USE int pwm_channel_get(const struct pwm_channel *channel);
/* Lets go of it, as it is. */
void pwm_channel_drop(struct pwm_channel *channel);

#endif
