/* SPDX-License-Identifier: Apache-2.0 */
/*
 * chaos.h: whole captures at random: a plan, a board and faults drawn from a seed,
 * run, cut, stopped and run again until done, and what must hold of every dataset.
 */
#ifndef TTF_TESTS_CHAOS_H
#define TTF_TESTS_CHAOS_H

#include <stdbool.h>
#include <stdint.h>

#include "sim_run.h"

#define CHAOS_RUNS_MAX 48
#define CHAOS_ASKS_MAX 5
#define CHAOS_TOLD_MAX \
    4096 /* slots of which is kept what was told of them; those beyond it are not compared */

/* One boot of the box. */
struct chaos_boot {
    char id[37];
    int64_t power_on_ns, ended_ns; /* since the first power-on */
    bool storage_away;             /* it ended with what was not written */
};

/* A dataset's files as they were after the last boot; NULL. Where a process of a boot finds them to be no leak. */
struct chaos_kept {
    char *records, *events;
};

/* What a storage does for good, until somebody mends it. */
enum chaos_failing {
    CHAOS_FAILS_NOT = 0,
    CHAOS_FAILS_SYNC,      /* its syncs give EIO */
    CHAOS_FAILS_FRAMES,    /* no file of an image can be written: bad blocks */
    CHAOS_FAILS_RECORDS,   /* no record can be written, though images can */
    CHAOS_FAILS_IO,        /* EIO */
    CHAOS_FAILS_FULL,      /* ENOSPC */
    CHAOS_FAILS_READ_ONLY, /* EROFS */
    CHAOS_FAILS_ROOM,      /* it has less than the reserve; of the first one */
    CHAOS_FAILING_COUNT
};

#define CHAOS_MOVE_KILLS 2

/* The plan's second storage, and what happens to both (chaos_second.c). */
struct chaos_second {
    bool named;
    enum chaos_failing how[2];   /* of each storage, ... */
    int64_t from[2];             /* ... once this slot is told */
    unsigned mended_after;       /* so many runs that ended with a storage's error */
    bool mended_when_left;       /* the first works again once the run has moved on */
    int kills[CHAOS_MOVE_KILLS]; /* the process is killed so many operations into a move; -1: not */
    unsigned n_kills;            /* that were */
    int fail_in_move;            /* one operation fails so many into a move; -1: none */
    unsigned gone_from,
        gone_for;     /* the first's disk is gone in so many of the runs that begin there */
    int unmounted_at; /* the second is not mounted in this run; -1: always is */
    /* what happened */
    bool begun;          /* the dataset there has a segment: the run is gone on with there */
    unsigned began;      /* so many runs began there */
    bool gone;           /* the first is */
    unsigned operations; /* of this boot in the second, until it was begun */
};

/* The datasets of a run, and which slots each of them holds: the member that has a slot's time prevails. */
struct chaos_parts {
    unsigned n;
    struct chaos_part {
        unsigned storage; /* 0: the first */
        char path[128];
        struct ttf_reader *reader;
        int64_t slots; /* the first so many of its slot lines */
    } part[2];
};

enum chaos_ask_state {
    CHAOS_NOT_ASKED = 0,
    CHAOS_ASKED,
    CHAOS_DONE,
    CHAOS_REFUSED,
    CHAOS_UNANSWERED /* the boot was over before; it may be done */
};

/* What people ask once. */
struct chaos_ask {
    struct ttf_ask ask; /* of a whole plan: its length; the rest is the plan's that runs */
    int64_t at;         /* once this slot is told; -1: once it is armed */
    int64_t number;
    enum chaos_ask_state state;
    char said[128];
};

/* No run has a longer interval, or more slots, than this. */
struct chaos_bounds {
    int64_t interval_ns, slots;
};

struct chaos {
    struct sim_run run; /* first: its callbacks are given this */
    uint64_t seed, state;
    bool verbose;
    unsigned failures;
    /* what else happens */
    int64_t stop_at[3];  /* a person stops the run once this slot is told; -1: not */
    int64_t fail_at;     /* once this slot is told, some file operations fail; -1: never */
    unsigned fail_count; /* so many */
    int64_t kill_at;     /* once this slot is told, the process is killed; -1: never */
    int kill_after;      /* so many file operations later */
    int64_t full_from, full_until; /* slots between which the disk has little room; -1: never */
    unsigned repaired_after;       /* so many runs that found that the storage can only be read */
    unsigned n_asks;
    struct chaos_ask asks[CHAOS_ASKS_MAX];
    struct chaos_second second;
    bool troubled[2]; /* each storage: something was drawn that is wrong with it */
    /* what happened */
    struct chaos_boot boots[CHAOS_RUNS_MAX];
    unsigned n_boots;
    bool killed;
    int64_t told;                     /* highest slot told to be committed; -1 */
    int64_t stopped_ns;               /* boot clock when the stop was asked for; TTF_NS_UNKNOWN */
    char told_result[CHAOS_TOLD_MAX]; /* enum ttf_result of each, and one; 0: not told */
    struct chaos_kept *kept;          /* of both storages */
};

/* The plan, the board and the faults of a seed. */
void chaos_draw(struct chaos *c);

/* One line on what was drawn, and one per fault. */
void chaos_describe(const struct chaos *c);

/* A number from 0 to n - 1; from low to high; true in so many of 100. */
uint64_t chaos_below(struct chaos *c, uint64_t n);
int64_t chaos_between(struct chaos *c, int64_t low, int64_t high);
bool chaos_percent(struct chaos *c, unsigned percent);

/* Says what does not hold, and counts it. */
void chaos_fail(struct chaos *c, const char *format, ...) __attribute__((format(printf, 2, 3)));

/* After each boot: nothing committed was lost or changed, nothing is damaged (chaos_boot.c). */
void chaos_check_boot(struct chaos *c);

/*
 * ttf_verify of the dataset in a storage; every byte (deep). clean: and nothing but what a cut leaves. On a storage that
 * fails to the end, a file that could not be removed may be left.
 */
void chaos_check_verify(struct chaos *c, unsigned storage, bool deep, bool clean);

/* ---- what is asked (chaos_asks.c): drawn, and told ---- */

void chaos_asks_draw(struct chaos *c);
void chaos_asks_describe(const struct chaos *c);
struct chaos_bounds chaos_bounds_of(const struct chaos *c);

/* Asks what is to be asked once this slot is told (-1: armed), and hears what was answered. */
void chaos_asks_told(struct chaos *c, int64_t index);
void chaos_asks_poll(struct chaos *c);

/* After each boot: nobody answers any more; what was answered is there. */
void chaos_asks_over(struct chaos *c);
void chaos_asks_check(struct chaos *c, const struct chaos_parts *parts);

/* Whether somebody may have asked for another interval. */
bool chaos_asks_may_change(const struct chaos *c);

/* Whether somebody may have paused this slot. */
bool chaos_asks_may_pause(const struct chaos *c, int64_t index);

/* ---- the second storage (chaos_second.c) ---- */

/* After all else is drawn. */
void chaos_second_draw(struct chaos *c);
void chaos_second_describe(const struct chaos *c);

/* What a file operation meets by this; as the `fault` of a run. May kill the process. */
int chaos_second_fault(struct sim_run *run, const char *op, const char *path);

/* Whether the first storage has less room than the reserve now. */
bool chaos_second_no_room(const struct chaos *c);

/* Before and after each boot: disks that go and come; who mends. */
void chaos_second_before(struct chaos *c);
void chaos_second_after(struct chaos *c);

/* After the last one: what was away is back. */
void chaos_second_over(struct chaos *c);

/* Whether the second was not mounted in the boot that is over: it must have been refused, and nothing written. */
bool chaos_second_was_unmounted(struct chaos *c);

/* Ends this process as a kill does: between two file operations. */
void chaos_kill(struct chaos *c) __attribute__((noreturn));

/* ---- the datasets of a run (chaos_parts.c) ---- */

/* Where the dataset of a storage is, or would be; whether it is there. */
void chaos_part_path(const struct chaos *c, unsigned storage, char ret[128]);
bool chaos_part_exists(const struct chaos *c, unsigned storage);

/* Opens what is there of them. False, and said, if one of them cannot be read; n is 0 then. */
bool chaos_parts_open(struct chaos *c, struct chaos_parts *ret);
void chaos_parts_close(struct chaos_parts *parts);

/* The last slot of the run that has a record; -1. */
int64_t chaos_parts_last(const struct chaos_parts *parts);

/* What the second one's beginning says of the run's time, numbers and group, beside the first one. */
void chaos_parts_check(struct chaos *c, const struct chaos_parts *parts);

/* When the boot of this id began, since the first power-on; TTF_NS_UNKNOWN: there was none. */
int64_t chaos_boot_ns(const struct chaos *c, const char *boot_id);

/* plans/N.json of one of them. */
bool chaos_plan_load(const struct chaos_part *part, int plan, struct ttf_plan *ret);

/* ---- at the end ---- */

/* Whether the clock was stepped; and whether while no run looked: nobody can tell that from an outage. */
bool chaos_any_step(const struct chaos *c);

/* Every slot has its one record, and each says what was. */
void chaos_check_end(struct chaos *c, bool done);

#endif
