/* SPDX-License-Identifier: Apache-2.0 */
/*
 * asks.h: what people asked of the run under way, with a number each and what came of it; the last 64 are remembered. The
 * run's letter box (ttf/capture/control.h) lives in here. Any thread.
 */
#ifndef DAEMON_ASKS_H
#define DAEMON_ASKS_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/attr.h"
#include "ttf/base/err.h"
#include "ttf/capture/control.h"
#include "ttf/dataset/json_writer.h"
#include "ttf/http/box.h"

struct asks;

/*
 * The numbers go on from one made of `random`: those of an earlier start of the box are not taken for these, so that
 * whoever still waits for an answer of then does not take another's. They stay below 2^53. NULL: no memory.
 */
struct asks *asks_create(uint64_t random);
void asks_destroy(struct asks *asks);

/* A letter box for a run that begins, which is none's before it; NULL: no memory. */
struct ttf_control *asks_begin(struct asks *asks);
/* The run has ended: what it did not answer is not done any more, but for a stop. */
void asks_end(struct asks *asks);

/* A number > 0. -ENOENT: no run takes it; errors of ttf_control_ask. */
TTF_MUST_USE int64_t asks_put(struct asks *asks, const struct ttf_http_ask *ask,
                              struct ttf_err *err);

/* A stop, which needs no run that hears: answered by asks_end. */
int64_t asks_stop(struct asks *asks);
/* It came to nothing: as if it had not been asked. */
void asks_take_back(struct asks *asks, int64_t number);

/* The next that was answered and not given by this yet, as an event's data. false: there is none. */
bool asks_answered(struct asks *asks, struct ttf_json *json);

/* As JSON. -ENOENT: no such number, or so long ago that it was forgotten. */
TTF_MUST_USE int asks_show(struct asks *asks, int64_t number, struct ttf_json *json);

#endif
