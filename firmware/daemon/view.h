/* SPDX-License-Identifier: Apache-2.0 */
/* view.h: the devices between runs: known, and a picture of now. Of the thread that owns them. */
#ifndef DAEMON_VIEW_H
#define DAEMON_VIEW_H

#include "parts.h"

/* For workshop_work; ctx is the daemon. */
int view_work(void *ctx, struct workshop_job *job, struct ttf_err *err);

/* The devices as pictures need them, made where they are not there yet. */
TTF_MUST_USE int view_open(struct daemon *d, struct ttf_err *err);

/* Devices that nobody looked through for a while are given back; now: at once. */
void view_close(struct daemon *d, bool now);

#endif
