/* SPDX-License-Identifier: Apache-2.0 */
/* second_run.h: runs whose plan names a second storage. */
#ifndef TTF_TESTS_SECOND_RUN_H
#define TTF_TESTS_SECOND_RUN_H

#include "sim_run.h"

/* Gives a run that was begun with a folder such a storage: a folder in it. */
void second_run_make(struct sim_run *run);

/* As sim_run_init; the second storage is a folder in its folder, and is there. */
void second_run_init(struct sim_run *run);

/* The run as it stands in the second storage, for what sim_run.h asserts. */
struct sim_run second_run_of(const struct sim_run *run);

/* Whether a path, as a fault is given it, lies in the second storage. */
bool second_run_holds(const char *path);

/* Letters of the slots' results by index, '-' where the dataset has none; no dataset: '-' alone. */
void second_run_results(const struct sim_run *run, char ret[32]);

/* Asserts that each slot is in one of the two, and only one, and that these are their results. */
void second_run_expect_both(const struct sim_run *run, const char *letters);

#endif
