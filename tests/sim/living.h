/* SPDX-License-Identifier: Apache-2.0 */
/* living.h: runs of which something is asked while they live, and what they answer; all assert. */
#ifndef TTF_TESTS_LIVING_H
#define TTF_TESTS_LIVING_H

#include "sim_run.h"

/* As sim_run_init, with somebody to ask. */
void living_init(struct sim_run *run);

/* As sim_run_finish. */
void living_finish(struct sim_run *run);

/* The ask's number. */
int64_t living_ask(struct sim_run *run, const struct ttf_ask *ask);

/* The ask of this number was done; was refused, naming `where` and saying `what`. */
void living_expect_done(struct sim_run *run, int64_t number);
void living_expect_refused(struct sim_run *run, int64_t number, const char *where,
                           const char *what);

#endif
