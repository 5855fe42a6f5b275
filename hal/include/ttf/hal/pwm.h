/* SPDX-License-Identifier: Apache-2.0 */
/* pwm.h: channels of the kernel's PWM chips as lines that take any level, through /sys/class/pwm. */
#ifndef TTF_HAL_PWM_H
#define TTF_HAL_PWM_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/lines.h"

/* The cycles that a channel may be asked for. */
#define TTF_PWM_PERIOD_MIN_NS INT64_C(1000)
#define TTF_PWM_PERIOD_MAX_NS INT64_C(1000000000)

/*
 * A bank of outputs: chip is "pwmchip0", or what its device is called ("fe20c000.pwm"), line the channel's number,
 * period_ns its cycle; neither active-low nor an input. root: where /sys is. Each channel is exported if it is not,
 * dark, its polarity normal, and held locked; it stays exported afterwards, dark, as its permissions are then there
 * at the next start. Level L is lit for L permille of each cycle; 0 is no time at all and the channel disabled.
 * -EINVAL (also a period that the driver refuses), -ENOENT (no such chip or channel), -EBUSY (the kernel's own, or
 * another process's), -EACCES, -ENOMEM.
 */
TTF_MUST_USE int ttf_lines_pwm_create(const char *root, const struct ttf_line_spec *specs,
                                      unsigned n, struct ttf_lines **ret, struct ttf_err *err);

#endif
