/* SPDX-License-Identifier: Apache-2.0 */
/* memory_watch.h: what a running capture allocates, looked at after each slot. */
#ifndef TTF_TESTS_MEMORY_WATCH_H
#define TTF_TESTS_MEMORY_WATCH_H

#include "alloc_hook.h"
#include "sim_run.h"

#define MEMORY_EARLY_SLOT 10 /* from which on nothing is to grow */

/* All there is to know of the process's memory at one moment. */
struct memory_sample {
    struct alloc_counts ours, all;
    long resident_kb;
};

/* A capture that is watched. run is first: on_progress finds the rest. */
struct memory_watch {
    struct sim_run run;
    int64_t slots, events; /* told since arming */
    struct memory_sample armed, first, early, last;
    /* after some slot: the most that it differed from after the first one */
    long live_off, live_off_bytes;
};

/* Makes the run's folder, watches from arming on. Change the rest of watch->run before memory_watch_run. */
void memory_watch_init(struct memory_watch *watch);

/* A rich plan: brackets, averages, two streams, a reference patch, raw and developed files, a calibration. */
void memory_watch_rich(struct memory_watch *watch, int64_t slots);

/* Everything that a box can do wrong now and then, but for its storage and power. */
void memory_watch_faults(struct memory_watch *watch);

/* Runs it, asserts that it ended well, prints what was seen and who of us allocated after arming. */
void memory_watch_run(struct memory_watch *watch);
void memory_watch_finish(struct memory_watch *watch);

#endif
