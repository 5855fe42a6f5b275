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

/* One boot of the box. */
struct chaos_boot {
    char id[37];
    int64_t power_on_ns, ended_ns; /* since the first power-on */
};

/* The files as they were after the last boot; NULL. Where a process of a boot finds them to be no leak. */
struct chaos_kept {
    char *records, *events;
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
    /* what happened */
    struct chaos_boot boots[CHAOS_RUNS_MAX];
    unsigned n_boots;
    bool killed;
    int64_t told;       /* highest slot told to be committed; -1 */
    int64_t stopped_ns; /* boot clock when the stop was asked for; TTF_NS_UNKNOWN */
    struct chaos_kept *kept;
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

/* After each boot: nothing committed was lost or changed, nothing is damaged. */
void chaos_check_boot(struct chaos *c);

/* What is asked (chaos_asks.c): drawn, and told. */
void chaos_asks_draw(struct chaos *c);
void chaos_asks_describe(const struct chaos *c);
struct chaos_bounds chaos_bounds_of(const struct chaos *c);

/* Asks what is to be asked once this slot is told (-1: armed), and hears what was answered. */
void chaos_asks_told(struct chaos *c, int64_t index);
void chaos_asks_poll(struct chaos *c);

/* After each boot: nobody answers any more; what was answered is there. */
void chaos_asks_over(struct chaos *c);
void chaos_asks_check(struct chaos *c, struct ttf_reader *reader);

/* Whether somebody may have paused this slot. */
bool chaos_asks_may_pause(const struct chaos *c, int64_t index);

/* plans/N.json of the dataset. */
bool chaos_plan_load(const struct chaos *c, int plan, struct ttf_plan *ret);

/* At the end: every slot has its one record, and each says what was. */
void chaos_check_end(struct chaos *c, bool done);

#endif
