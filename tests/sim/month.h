/* SPDX-License-Identifier: Apache-2.0 */
/* month.h: one of every fault each day, at drawn times, each with some slots to itself. README.md has the rule. */
#ifndef TTF_TESTS_MONTH_H
#define TTF_TESTS_MONTH_H

#include "sim_run.h"

#define MONTH_INTERVAL_NS (10 * TTF_NS_PER_MIN)
#define MONTH_DAY_SLOTS   144
#define MONTH_DAYS_MAX    60

/* All kinds but a storage that can only be read: it stays so, so it is one of a month, not of a day. */
#define MONTH_PLAIN_KINDS TTF_FAULT_READ_ONLY

/* Hangs of the four kinds count as kinds of their own. */
#define MONTH_KINDS (MONTH_PLAIN_KINDS + 3)

/* Each fault has so many slots to itself: 18 kinds make a day. */
#define MONTH_BLOCK (MONTH_DAY_SLOTS / MONTH_KINDS)

struct month_fault {
    unsigned kind; /* 0..MONTH_KINDS-1 */
    struct ttf_fault fault;
    int64_t lasts_ns;    /* as it is, defaults resolved; 0: it strikes once */
    int64_t first, last; /* slots of its block */
    /* found in the records */
    unsigned seen; /* slots that it left a mark on */
    unsigned lost; /* of these, not captured */
};

/*
 * In the block of a step of the clock, which leaves no mark in a record, people ask for things: a pause of two slots,
 * and when that is over another day, a note, and another interval for a slot: half of it, then one and a half, so that
 * the slots are where they were, and the first one again.
 */
#define MONTH_PAUSE_FIRST 2
#define MONTH_PAUSE_SLOTS 2
#define MONTH_ASK_AFTER   4
#define MONTH_ASKS        7

struct month {
    struct ttf_fault
        read_only; /* of the first storage, in the first block, behind all that is asked there */
    uint64_t seed, state;
    int64_t days;
    int64_t due0_ns; /* of slot 0, since the first power-on */
    unsigned n;
    struct month_fault faults[MONTH_DAYS_MAX * MONTH_KINDS];
};

/* Its name in a table. */
const char *month_kind_name(unsigned kind);

/* Draws all faults of so many days. */
void month_draw(struct month *m, uint64_t seed, int64_t days, int64_t due0_ns);

/* The fault of the block that a slot is of. */
const struct month_fault *month_fault_of(const struct month *m, int64_t index);

/* Whether people paused it. */
bool month_paused(const struct month *m, int64_t index);

/* From the slot before to this one; when it is due without any trouble, since the first power-on. */
int64_t month_interval_ns(const struct month *m, int64_t index);
int64_t month_due_ns(const struct month *m, int64_t index);

/* Hands the box those that a boot beginning then can meet, as many as it takes. */
void month_fill(const struct month *m, struct ttf_sim_config *config, int64_t power_on_ns);

#endif
