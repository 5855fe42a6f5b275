/* SPDX-License-Identifier: Apache-2.0 */
/* idle.h: the owner of the devices while it waits. */
#ifndef DAEMON_IDLE_H
#define DAEMON_IDLE_H

#include "parts.h"
#include "ttf/hal/panel.h"

/*
 * So long, or until the program is told to end or something else than this order is to be run (also where that was decided
 * before the wait began). The service manager sees that it
 * lives, the light shows what is, the button is heard, and what others want of the devices is done.
 */
void idle(struct daemon *d, int64_t generation, int64_t for_ns, enum ttf_led led);

#endif
