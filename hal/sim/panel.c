/* SPDX-License-Identifier: Apache-2.0 */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "box_private.h"

struct sim_panel {
    struct ttf_panel base;
    struct sim_box *box;
    enum ttf_led led;
};

static int panel_led(struct ttf_panel *base, enum ttf_led led)
{
    struct sim_panel *panel = (struct sim_panel *)base;

    if (sim_box_dead(panel->box))
        return -ENODEV;
    panel->led = led;
    return 0;
}

static int panel_door(struct ttf_panel *base)
{
    struct sim_box *box = ((struct sim_panel *)base)->box;
    int open;

    if (!box->config.door_switch)
        return -ENOTSUP;
    if (sim_world_enter(box) < 0)
        return -ENODEV;
    open = box->door_open;
    sim_world_leave(box);
    return open;
}

static int panel_poll(struct ttf_panel *base, struct ttf_panel_event *ret)
{
    struct sim_box *box = ((struct sim_panel *)base)->box;
    int any;

    if (sim_world_enter(box) < 0)
        return -ENODEV;
    any = box->n_events > 0;
    if (any) {
        *ret = box->events[0];
        box->n_events--;
        memmove(&box->events[0], &box->events[1], box->n_events * sizeof(box->events[0]));
    }
    sim_world_leave(box);
    return any;
}

static void panel_destroy(struct ttf_panel *base)
{
    free(base);
}

static const struct ttf_panel_ops sim_panel_ops = {.name = "sim",
                                                   .led = panel_led,
                                                   .door = panel_door,
                                                   .poll = panel_poll,
                                                   .destroy = panel_destroy};

struct ttf_panel *sim_panel_create(struct sim_box *box)
{
    struct sim_panel *panel = calloc(1, sizeof(*panel));

    if (!panel)
        return NULL;
    panel->base.ops = &sim_panel_ops;
    panel->box = box;
    return &panel->base;
}
