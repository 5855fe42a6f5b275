/* SPDX-License-Identifier: Apache-2.0 */
/* trouble.h: a disk that fails once, or a program that is killed, at one step of a run. */
#ifndef TTF_TESTS_CRASH_TROUBLE_H
#define TTF_TESTS_CRASH_TROUBLE_H

#include "run.h"

enum trouble_kind {
    TROUBLE_NONE,
    TROUBLE_KILLED,
    TROUBLE_SYNC, /* fails, and its dirty pages are lost */
    TROUBLE_STEP, /* anything but a file's sync fails: EIO */
    TROUBLE_FULL, /* ENOSPC */
    TROUBLE_KIND_COUNT
};

const char *trouble_name(enum trouble_kind kind);

struct trouble {
    enum trouble_kind kind; /* NONE again once it has come */
    unsigned at;            /* at the at-th step, or the next that it fits */
    unsigned step;          /* so far */
    bool over;              /* it has come, and the run has not begun anew since */
};

/* To be called at each step: 0, or the errno that the step fails with. */
int trouble_step(struct trouble *trouble, struct run *run, const char *op, const char *path);

/* The next program: opens what the kernel holds, on a disk that is sound again. */
bool trouble_begin_anew(struct trouble *trouble, struct run *run);

/* Is the program dead? Then it must begin anew. */
bool trouble_killed(const struct run *run);

#endif
