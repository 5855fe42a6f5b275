/* SPDX-License-Identifier: Apache-2.0 */
/*
 * workshop.h: what others ask to be done with the box's devices while no run has them. The thread that owns the devices does
 * it when it is idle; whoever asked waits, not for ever.
 */
#ifndef DAEMON_WORKSHOP_H
#define DAEMON_WORKSHOP_H

#include <stdbool.h>
#include <stddef.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/clock.h"
#include "ttf/http/box.h"

struct workshop;

struct workshop_job {
    const struct ttf_http_view *view; /* a picture is wanted; NULL: that the devices are known */
    struct ttf_http_shown shown;      /* made */
};

/* wake is opened when there is something to do; borrowed. NULL: no memory. */
struct workshop *workshop_create(struct ttf_clock *clock, struct ttf_gate *wake);
void workshop_destroy(struct workshop *workshop); /* NULL allowed; nobody asks any more */

/* Waits up to 30 s until somebody begins it, and then until it is done. -EAGAIN: nobody did; errors of doing it. */
TTF_MUST_USE int workshop_ask(struct workshop *workshop, struct workshop_job *job,
                              struct ttf_err *err);

/* The owner: does one that waits. false: none did. */
typedef int workshop_fn(void *ctx, struct workshop_job *job, struct ttf_err *err);
bool workshop_work(struct workshop *workshop, workshop_fn *fn, void *ctx);

/* Who waits is told -EBUSY (a run takes the devices) until it is opened again. */
void workshop_open(struct workshop *workshop, bool open);

#endif
