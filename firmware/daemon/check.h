/* SPDX-License-Identifier: Apache-2.0 */
/* check.h: would a plan do on this box? As `ttfbox plan check`, against what is remembered of the devices. Any thread. */
#ifndef DAEMON_CHECK_H
#define DAEMON_CHECK_H

#include "parts.h"

/*
 * Findings and figures as JSON, by malloc; *ret_ok: it would do. *err is what is wrong with it, where it would not.
 * Fails only where that cannot be said.
 */
TTF_MUST_USE int check_plan(struct daemon *d, const char *name, const char *yaml, size_t bytes,
                            char **ret_json, bool *ret_ok, struct ttf_err *err);

/* -EBUSY: the plan has a start, and nobody vouches for the box's clock. */
TTF_MUST_USE int check_clock(struct daemon *d, const char *name, const char *yaml,
                             struct ttf_err *err);

/* An object of "findings": level is "error" or "warning". */
void check_put_finding(struct ttf_json *j, const char *level, const struct ttf_err *err);

/* What the box is made of, as JSON. */
TTF_MUST_USE int check_devices(struct daemon *d, char **ret_json, struct ttf_err *err);

#endif
