/* SPDX-License-Identifier: Apache-2.0 */
/* cuts.h: the disks that a power cut may leave, one after another, each judged. */
#ifndef TTF_TESTS_CRASH_CUTS_H
#define TTF_TESTS_CRASH_CUTS_H

#include <stdio.h>

#include "run.h"

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
    unsigned part, parts;         /* exhaustive: this process takes each parts-th step */
    bool stop_at_first;
    uint64_t *seen; /* hashes of states that were judged; NULL: not remembered */
    size_t seen_n, seen_room;
    /* random */
    uint64_t seed, state;
    uint64_t states_most;
};

/* Cuts at every step of a fixed run. */
void cuts_exhaustive(struct cuts *cuts);

/* Runs drawn from seeds `seed`, seed + parts, ..., cut at random steps, until so many states were judged. */
void cuts_random(struct cuts *cuts);

void cuts_free(struct cuts *cuts);

/* ---- between its files ---- */

/* Was this state judged already? Remembers it. */
bool cuts_seen(struct cuts *cuts, uint64_t hash);

/* The state after a cut: judged, `then` watching each of its steps (NULL: nobody). Tells what is wrong. */
struct cuts_moment {
    const struct disk *disk;
    const struct run_promise *promise;
    const struct disk_kept *kept;
    const char *op, *path;
    const struct cuts_moment *before; /* the cut before this one; NULL */
};
void cuts_judge(struct cuts *cuts, const struct cuts_moment *moment, struct disk *after,
                disk_step_fn *then, void *then_ctx, struct run *judged);

#endif
