/* SPDX-License-Identifier: Apache-2.0 */
/* judge.h: is everything there that was promised, and does the dataset go on? */
#ifndef TTF_TESTS_CRASH_JUDGE_H
#define TTF_TESTS_CRASH_JUDGE_H

#include "run.h"

/*
 * Looks at the dataset on run->disk as readers and `verify` do, changing nothing.
 * clean: there must be no leftovers but those that only the same call removes. What
 * is wrong is in run->broken.
 */
void judge_look(struct run *run, bool clean);

/*
 * Looks (JUDGE_BEFORE), opens for writing, looks (JUDGE_BETWEEN), commits, seals, looks.
 * `run` has the promise and is gone on with.
 */
#define JUDGE_BEFORE  1u
#define JUDGE_BETWEEN 2u
void judge_go_on(struct run *run, unsigned looks);

#endif
