/* SPDX-License-Identifier: Apache-2.0 */
/* light.h: the panel's light while no run has the box's devices. */
#ifndef DAEMON_LIGHT_H
#define DAEMON_LIGHT_H

#include "ttf/config/board_file.h"
#include "ttf/hal/clock.h"
#include "ttf/hal/panel.h"

/* A panel that shows this; NULL where there is none, or none that answers: a light is no reason to fail. */
struct ttf_panel *light_show(const struct ttf_board *board, struct ttf_clock *clock,
                             enum ttf_led led);

#endif
