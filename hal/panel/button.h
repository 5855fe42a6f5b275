/* SPDX-License-Identifier: Apache-2.0 */
/* button.h: levels of a wire that bounces, and time, become presses. No I/O. */
#ifndef TTF_HAL_PANEL_BUTTON_H
#define TTF_HAL_PANEL_BUTTON_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/time.h"
#include "ttf/hal/panel.h"

#define BUTTON_STEADY_NS (30 * TTF_NS_PER_MS) /* contacts bounce for less */
#define BUTTON_LONG_NS   (3 * TTF_NS_PER_S)

struct button {
    bool level; /* of the wire, now */
    int64_t level_since_ns;
    bool pressed; /* as it is taken, once the level is steady */
    int64_t pressed_ns;
    bool told; /* of this press: it was long */
};

/* One that is held at the beginning is no press until it was let go. */
void button_init(struct button *button, bool level, int64_t now_ns);

/* The wire is at this level since now. */
void button_level(struct button *button, bool level, int64_t now_ns);

/* The wire is at this level, and no edge told when it came there: a press whose end was missed so is none. */
void button_missed(struct button *button, bool level, int64_t now_ns);

/* Time passes: true if that makes an event. A long press is one while it is still held; a short one when it ends. */
bool button_look(struct button *button, int64_t now_ns, struct ttf_panel_event *ret);

/* It is down, and not told of yet. */
bool button_held(const struct button *button);

/* When to look next at the latest, should no level change; TTF_NS_NEVER. */
int64_t button_next_ns(const struct button *button);

#endif
