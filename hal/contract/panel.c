/* SPDX-License-Identifier: Apache-2.0 */
#include "ttf/hal/panel.h"

#include <errno.h>
#include <stddef.h>

int ttf_panel_led(struct ttf_panel *panel, enum ttf_led led)
{
    if ((unsigned)led >= TTF_LED_COUNT)
        return -EINVAL;
    return panel->ops->led ? panel->ops->led(panel, led) : -ENOTSUP;
}

int ttf_panel_door(struct ttf_panel *panel)
{
    return panel->ops->door ? panel->ops->door(panel) : -ENOTSUP;
}

int ttf_panel_poll(struct ttf_panel *panel, struct ttf_panel_event *ret)
{
    return panel->ops->poll(panel, ret);
}

int ttf_panel_held(struct ttf_panel *panel)
{
    return panel->ops->held ? panel->ops->held(panel) : -ENOTSUP;
}

void ttf_panel_destroy(struct ttf_panel *panel)
{
    if (panel)
        panel->ops->destroy(panel);
}
