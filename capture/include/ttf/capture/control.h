/* SPDX-License-Identifier: Apache-2.0 */
/*
 * control.h: what people ask of a run while it lives: to stop, pause, go on, take more slots, change its
 * interval or its day, note something. A letter box between any thread and the session's loop, which
 * looks into it at every tick (2 s) while it waits between slots; so nothing asked for ever disturbs an exposure.
 *
 * A change of plan is a new plan and a new segment of the dataset: the index goes on, nothing is
 * renumbered. Whatever happens at that moment, the old plan is in force or the new one: the segment's line, behind
 * the plan's, is what decides.
 *
 * A control outlives the session: make it, lend it to one session after another (boots of a box),
 * destroy it after the last. Functions below: any thread, at any time.
 */
#ifndef TTF_CAPTURE_CONTROL_H
#define TTF_CAPTURE_CONTROL_H

#include <stdbool.h>
#include <stdint.h>

#include "ttf/base/err.h"
#include "ttf/capture/plan.h"
#include "ttf/dataset/notes.h"

/* Asked and not answered yet, at most. */
#define TTF_ASKS_MAX 32

enum ttf_ask_kind {
    TTF_ASK_STOP = 0, /* end within a slot; the same run may be gone on with */
    TTF_ASK_PAUSE, /* slots are recorded `paused`; lamps follow their programme, no shot is taken */
    TTF_ASK_CONTINUE, /* takes the pause back */
    TTF_ASK_COUNT,    /* so many slots in all: more, or fewer than planned */
    TTF_ASK_UNTIL,    /* the slots due before an instant */
    TTF_ASK_INTERVAL, /* the next slot comes one new interval after the last, or as soon as it may */
    TTF_ASK_PHOTOPERIOD, /* of a plan with one: its day, period and phase */
    TTF_ASK_PLAN,        /* a whole plan that differs in no more than the above */
    TTF_ASK_NOTE,        /* a line in notes.jsonl */
    TTF_ASK_KIND_COUNT
};

struct ttf_ask {
    enum ttf_ask_kind kind;
    int64_t from_index;        /* not before this slot is the next; 0: as soon as may be */
    char reason[120];          /* PAUSE; empty: "paused by a person" */
    int64_t count;             /* COUNT */
    int64_t until_utc_ns;      /* UNTIL */
    int64_t interval_ns;       /* INTERVAL */
    int64_t day_ns, period_ns; /* PHOTOPERIOD */
    int64_t phase_ns;      /* PHOTOPERIOD, unless local: time since slot 0 at which a day begins */
    bool local;            /* PHOTOPERIOD: the day begins at a local time */
    int day_start_s;       /* PHOTOPERIOD, if local */
    struct ttf_plan plan;  /* PLAN */
    const char *plan_yaml; /* PLAN: as given, copied; NULL allowed */
    struct ttf_note note;  /* NOTE; utc_ns TTF_NS_UNKNOWN: now by the box's clock */
};

struct ttf_control;

struct ttf_control *ttf_control_create(void); /* NULL: no memory */
/* NULL allowed. No session uses it any more. */
void ttf_control_destroy(struct ttf_control *control);

/* Asks. Returns a number > 0 to ask the answer by; -EAGAIN: too many wait; -ENOMEM; -EINVAL: no such kind. */
TTF_MUST_USE int64_t ttf_control_ask(struct ttf_control *control, const struct ttf_ask *ask);

/*
 * What came of it: 0: done, and on the disk if it is anything that is written; -EAGAIN: not answered yet; -ENOENT: no
 * such number, or so long ago that it was forgotten; else it was refused, *err (may be NULL) says in a
 * sentence why, and nothing has changed. -ECANCELED: the run ended before it was done.
 */
TTF_MUST_USE int ttf_control_answer(struct ttf_control *control, int64_t number,
                                    struct ttf_err *err);

/* How many wait for their answer. */
unsigned ttf_control_waiting(struct ttf_control *control);

#endif
