/* SPDX-License-Identifier: Apache-2.0 */
/*
 * panel_lines.h: a panel on wires (hal/panel/): a button and a light on lines of its own, and the door as the lamp
 * guardian feels it, since a line has one holder and the door's is the guardian's.
 */
#ifndef TTF_HAL_PANEL_LINES_H
#define TTF_HAL_PANEL_LINES_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/clock.h"
#include "ttf/hal/lamps.h"
#include "ttf/hal/lines.h"
#include "ttf/hal/panel.h"

struct ttf_panel_lines_config {
    struct ttf_lines *lines; /* NULL: no button and no light */
    int button, led;         /* lines of it, an input and an output; -1: none */
    struct ttf_clock *clock; /* borrowed */
    struct ttf_lamps *
        lamps; /* whose guardian feels the door (lampd.h); borrowed. NULL, or others: no door switch */
};

/*
 * Starts the thread that feels the button and drives the light. The lines are taken over: they end with the panel, and
 * also if it cannot be made. A button that bounces for less than 30 ms is pressed once; a light whose chip vanishes is
 * looked for every second. -EINVAL, -ENOMEM.
 */
TTF_MUST_USE int ttf_panel_lines_create(const struct ttf_panel_lines_config *config,
                                        struct ttf_panel **ret, struct ttf_err *err);

#endif
