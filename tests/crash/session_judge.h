/* SPDX-License-Identifier: Apache-2.0 */
/* session_judge.h: is everything there that a session promised, and nothing else? What is wrong is in s->broken. */
#ifndef TTF_TESTS_CRASH_SESSION_JUDGE_H
#define TTF_TESTS_CRASH_SESSION_JUDGE_H

#include "session_box.h"

/*
 * As a cut leaves it. whole: what the same boot, not cut, has acknowledged in the end; its next slot may be there too,
 * and is then as good as acknowledged. NULL: no other slot may be.
 */
void session_look(struct session_box *s, const struct session_promise *whole);

/*
 * After the last boot: it ended well and sealed, each slot of the plan has one record that counts, nothing is left over
 * (but files of a disk that has failed).
 */
void session_look_whole(struct session_box *s);

#endif
