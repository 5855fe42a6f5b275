/* SPDX-License-Identifier: Apache-2.0 */
/* calibrate.h: a step of a calibration, done while nothing runs. Of the thread that owns the devices. */
#ifndef DAEMON_CALIBRATE_H
#define DAEMON_CALIBRATE_H

#include "parts.h"

/* Does the step that waits, if one does; the watchdog (NULL: none) is given the time that it may take. true: one was done. */
bool calibrate_work(struct daemon *d, struct ttf_watchdog *watchdog);

#endif
