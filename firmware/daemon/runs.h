/* SPDX-License-Identifier: Apache-2.0 */
/* runs.h: one run after the other, and what comes between: the life of the thread that owns the devices. */
#ifndef DAEMON_RUNS_H
#define DAEMON_RUNS_H

#include "parts.h"

/* What all runs have in common, once. */
void runs_prepare(struct daemon *d);

/* Until the program is told to end. */
void runs_live(struct daemon *d);

#endif
