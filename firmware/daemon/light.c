/* SPDX-License-Identifier: Apache-2.0 */
#include "light.h"

#include <string.h>

#include "devices.h"

struct ttf_panel *light_show(const struct ttf_board *board, struct ttf_clock *clock,
                             enum ttf_led led)
{
    const struct ttf_backend_entry *backend = board->device[TTF_DEVICE_PANEL];
    struct ttf_panel *panel = NULL;

    if (!backend || strcmp(backend->name, "sim") == 0 ||
        box_make_panel(board, clock, NULL, &panel, NULL) < 0)
        return NULL;
    if (ttf_panel_led(panel, led) == 0)
        return panel;
    ttf_panel_destroy(panel);
    return NULL;
}
