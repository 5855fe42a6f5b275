/* SPDX-License-Identifier: Apache-2.0 */
/* wires.h: the wires of a board as one bank, whatever each is: a GPIO line, a PWM channel, a byte of a file. */
#ifndef FIRMWARE_LAMPD_WIRES_H
#define FIRMWARE_LAMPD_WIRES_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/config/board_file.h"
#include "ttf/hal/lines.h"

/* All lamps dark. sys: where /sys is. Errors as ttf_lines_gpiod_create, ttf_lines_pwm_create. */
TTF_MUST_USE int lampd_wires_open(const struct ttf_board *board, const char *sys,
                                  struct ttf_lines **ret, struct ttf_err *err);

#endif
