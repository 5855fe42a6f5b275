/* SPDX-License-Identifier: Apache-2.0 */
/* cuts.h: the disks that a power cut may leave, one after another, each judged. */
#ifndef TTF_TESTS_CRASH_CUTS_H
#define TTF_TESTS_CRASH_CUTS_H

#include <stdio.h>

#include "run.h"
#include "seen.h"

/* How much is enumerated at one moment; README.md, "What is enumerated". */
struct cuts_bounds {
    unsigned subset_bits; /* all subsets of up to so many effects */
    unsigned tear_step;   /* effects of bytes are torn after 1, and every so many bytes */
    bool pairs;           /* where there are more effects: pairs, and all but pairs */
};

struct cuts_counts {
    uint64_t cuts;   /* choices made */
    uint64_t states; /* different ones, or any at random: judged */
    uint64_t deeper; /* of them, cuts in what a judge does */
    uint64_t steps;  /* operations of runs at which was cut */
    uint64_t of[RUN_FAULT_COUNT];
};

struct cuts {
    struct cuts_counts counts;
    struct cuts_bounds bounds[2]; /* of the first cut; of one in the recovery from it */
    unsigned depth;               /* how many cuts on end: 1 or 2 */
    const enum run_step *steps;   /* the run that is cut everywhere, or troubled */
    unsigned n_steps;
    int fresh_kinds; /* what unwritten blocks read as: zeros; 2: noise, too; 3: old logs, too */
    unsigned part, parts; /* troubled, random: this process takes each parts-th of them */
    bool stop_at_first;
    unsigned between_of;   /* one in so many states is looked at between repair and going on */
    struct seen *seen;     /* borrowed: states that were judged, steps that another process has */
    unsigned trouble_each; /* trouble at one in so many steps */
    char trouble[80];      /* that a run met first, in words */
    /* random */
    uint64_t seed, state;
    uint64_t states_most;
};

/* Cuts at every step of the run. */
void cuts_exhaustive(struct cuts *cuts);

/* The same run, with one failure of the disk, or killed, at each step, and cut after each call since. */
void cuts_troubled(struct cuts *cuts);

/* Runs drawn from seeds `seed`, seed + parts, ..., cut at random steps, until so many states were judged. */
void cuts_random(struct cuts *cuts);

/* ---- between its files ---- */

/* Was this state judged already, as a first cut (level 0) or as a second one? Remembers it. */
bool cuts_seen(struct cuts *cuts, const struct disk *disk, const struct run_promise *promise,
               unsigned level);
bool cuts_stopped(const struct cuts *cuts);

/* A run that was broken by itself. */
void cuts_broken_uncut(struct cuts *cuts, const struct run *run);

/* The state after a cut: judged, `then` watching each of its steps (NULL: nobody). Tells what is wrong. */
struct cuts_moment {
    const struct disk *disk;
    const struct run_promise *promise;
    const struct disk_kept *kept;
    const char *op, *path;
    const struct cuts_moment *before; /* the cut before this one; NULL */
};
void cuts_judge(struct cuts *cuts, const struct cuts_moment *moment, struct disk *after,
                unsigned looks, disk_step_fn *then, void *then_ctx, struct run *judged);

#endif
