/* SPDX-License-Identifier: Apache-2.0 */
/*
 * slow.h: threads for what takes more than a moment, those of one lane. The connection sleeps meanwhile, and others of its
 * thread are served. Calls wait in their order, at most 32 of them.
 */
#ifndef HTTP_SLOW_H
#define HTTP_SLOW_H

#include "ttf/base/attr.h"
#include "ttf/base/err.h"

#define SLOW_THREADS_MAX 4

struct call;
struct slow;

/* threads: 1 to SLOW_THREADS_MAX. */
TTF_MUST_USE int slow_create(unsigned threads, struct slow **ret, struct ttf_err *err);

/* -EAGAIN: too many wait. */
TTF_MUST_USE int slow_put(struct slow *slow, struct call *call);

/* No call is taken any more; those that wait are cancelled, the one under way is waited for. NULL allowed, twice too. */
void slow_stop(struct slow *slow);
void slow_destroy(struct slow *slow); /* NULL allowed */

#endif
