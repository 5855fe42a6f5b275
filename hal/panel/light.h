/* SPDX-License-Identifier: Apache-2.0 */
/* light.h: what each state of the box looks like on one light that can be lit or dark. No I/O. */
#ifndef TTF_HAL_PANEL_LIGHT_H
#define TTF_HAL_PANEL_LIGHT_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/hal/panel.h"

/* Whether it is lit, and when that changes next (TTF_NS_NEVER), for a state that was told at since_ns. */
bool light_at(enum ttf_led led, int64_t since_ns, int64_t now_ns, int64_t *ret_next_ns);

#endif
