/* SPDX-License-Identifier: Apache-2.0 */
/*
 * session_cuts.h: a boot of a box whose disk is cut on the way, and what comes of each disk that is left.
 *
 * The boot itself goes on to its end; each cut leaves a disk of its own, which is looked at, and on which the run is
 * resumed, as a box does that has power again.
 */
#ifndef TTF_TESTS_CRASH_SESSION_CUTS_H
#define TTF_TESTS_CRASH_SESSION_CUTS_H

#include "choose.h"
#include "disk.h"
#include "locked_io.h"
#include "seen.h"
#include "session_box.h"

struct session_counts {
    uint64_t boots;
    uint64_t cuts;   /* choices made */
    uint64_t states; /* different ones, or any at random: judged */
    uint64_t asked;  /* boots in which people asked something */
    uint64_t deeper; /* of them, cuts of a run that was resumed */
    uint64_t troubled, moved,
        ended_early; /* boots whose disk failed; that moved on; that gave up */
    uint64_t broken;
};

/* How the disk fails. */
enum session_trouble_kind {
    SESSION_SOUND,
    SESSION_EIO,
    SESSION_ENOSPC,
    SESSION_EROFS,
    SESSION_SYNC_FAILS, /* of files, EIO; what was dirty is never written */
    SESSION_TROUBLE_COUNT
};

struct session_trouble {
    enum session_trouble_kind kind;
    uint64_t from, until; /* steps of the boot, from 1 */
    bool first_only;      /* what lies in the first storage */
    bool came;
};

struct session_cuts {
    struct session_counts counts;
    unsigned part, parts; /* cut everywhere: this process takes each parts-th step */
    struct seen *seen;    /* borrowed; NULL: nothing is remembered */
    bool everywhere;      /* at each step: no effect, all, the first k, all but the first k */
    unsigned each;        /* everywhere: of the choices of k each so many-th */
    bool stop_at_first;
    struct draw draw; /* at random */
    uint64_t seed;    /* to be told */
    uint64_t states_left;
};

struct session_boot;

/* A disk with the folders of both storages and nothing else. */
struct disk *session_fresh_disk(void);

/* What a whole run is: so many slots, how its first boot's disk fails, what people ask meanwhile. */
struct session_plan {
    int64_t slots;
    bool second;
    bool days;   /* a photoperiod of 2 min in each 4 */
    bool longer; /* in the end it is gone on with by a plan of two slots more */
    unsigned n_asks;
    struct session_ask {
        enum ttf_ask_kind kind;
        int64_t from, value;
    } asks[LIVING_ASKS_MAX]; /* of living_ask */
    bool drawn;              /* asks are drawn instead */
    enum disk_fresh fresh;   /* what unwritten blocks read as */
    enum ttf_keep keep;
    struct session_trouble trouble;
    unsigned cut_permille; /* at random: of the steps */
};

/* Something was broken, and the first is to end it: states are counted no more. */
bool session_cuts_stopped(const struct session_cuts *cuts);

/* A run from an empty disk on, with all cuts on the way. */
void session_cut_run(struct session_cuts *cuts, const struct session_plan *plan);

#endif
