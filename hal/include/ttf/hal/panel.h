/* SPDX-License-Identifier: Apache-2.0 */
/*
 * panel.h: what a person sees and touches on the box: status light, button, door.
 * One thread at a time.
 */
#ifndef TTF_HAL_PANEL_H
#define TTF_HAL_PANEL_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"

struct ttf_panel;

enum ttf_led {
    TTF_LED_OFF = 0,
    TTF_LED_IDLE,      /* slow pulse */
    TTF_LED_CAPTURING, /* told anew at each slot, which is a wink */
    TTF_LED_WARNING,
    TTF_LED_STOPPED, /* fast blink: something needs a person */
    TTF_LED_COUNT
};

enum ttf_panel_event_kind {
    TTF_PANEL_BUTTON_SHORT = 0,
    TTF_PANEL_BUTTON_LONG, /* held for 3 s or more */
    TTF_PANEL_DOOR_OPENED,
    TTF_PANEL_DOOR_CLOSED
};

struct ttf_panel_event {
    enum ttf_panel_event_kind kind;
    int64_t at_ns;
};

/* -ENOTSUP without such a light. */
TTF_MUST_USE int ttf_panel_led(struct ttf_panel *panel, enum ttf_led led);

/* 1 open, 0 closed, -ENOTSUP without a door switch. */
TTF_MUST_USE int ttf_panel_door(struct ttf_panel *panel);

/* The oldest event not yet taken: 1 and *ret, or 0 if there is none. Never blocks. */
TTF_MUST_USE int ttf_panel_poll(struct ttf_panel *panel, struct ttf_panel_event *ret);

/* 1: the button is down, and it is not known yet how its press will be told of; 0: it is not; -ENOTSUP: nobody knows. */
TTF_MUST_USE int ttf_panel_held(struct ttf_panel *panel);

/* NULL allowed. */
void ttf_panel_destroy(struct ttf_panel *panel);

/* --- for authors of back-ends: led, door and held may be NULL (-ENOTSUP) --- */
struct ttf_panel_ops {
    const char *name;
    int (*led)(struct ttf_panel *panel, enum ttf_led led);
    int (*door)(struct ttf_panel *panel);
    int (*poll)(struct ttf_panel *panel, struct ttf_panel_event *ret);
    int (*held)(struct ttf_panel *panel);
    void (*destroy)(struct ttf_panel *panel);
};

struct ttf_panel {
    const struct ttf_panel_ops *ops;
};

#endif
