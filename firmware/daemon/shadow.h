/* SPDX-License-Identifier: Apache-2.0 */
/*
 * shadow.h: what a box's devices can do, remembered from when they were last made: so that a plan is checked against the
 * box also while a run has it, and no device is touched for it. Any thread.
 */
#ifndef DAEMON_SHADOW_H
#define DAEMON_SHADOW_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/hal/box.h"

struct shadow;

struct shadow *shadow_create(void); /* NULL: no memory */
void shadow_destroy(struct shadow *shadow);

/* Remembers a box whose cameras are configured. */
void shadow_take(struct shadow *shadow, const struct ttf_box *box);

/* Does something with a box that can only be looked at, under a lock. -EAGAIN: none was made yet. */
typedef int shadow_fn(void *ctx, const struct ttf_box *box, struct ttf_err *err);
TTF_MUST_USE int shadow_with(struct shadow *shadow, shadow_fn *fn, void *ctx, struct ttf_err *err);

#endif
