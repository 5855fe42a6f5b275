/* SPDX-License-Identifier: Apache-2.0 */
/* asks.h: the session's side of ttf/capture/control.h. A control of NULL is one nobody uses. */
#ifndef TTF_CAPTURE_PRIVATE_ASKS_H
#define TTF_CAPTURE_PRIVATE_ASKS_H

#include "ttf/capture/control.h"

/* True if something is to be heard when slot `index` is the next. Any thread. */
bool ttf_asks_due(struct ttf_control *control, int64_t index);

/*
 * Takes the oldest that is due; it stays where it is, the taker's, until it is answered. NULL: none.
 * *ret_number: for the answer. Loop.
 */
struct ttf_ask *ttf_asks_take(struct ttf_control *control, int64_t index, int64_t *ret_number);

/* Answers: code 0 or negative with why (NULL allowed). A number of 0, or answered before, is passed over. Any thread. */
void ttf_asks_answer(struct ttf_control *control, int64_t number, int code,
                     const struct ttf_err *err);

/* The session ends: what was taken and not answered never will be. */
void ttf_asks_end(struct ttf_control *control);

#endif
