/* SPDX-License-Identifier: Apache-2.0 */
/*
 * session_living.h: what people ask of a run while it lives (ttf/capture/control.h), and the plans that it then follows,
 * one after another. Whatever happens, the one in force is the last that was answered, or the one asked for next.
 */
#ifndef TTF_TESTS_CRASH_SESSION_LIVING_H
#define TTF_TESTS_CRASH_SESSION_LIVING_H

#include <stdbool.h>
#include <stdint.h>

#include "draw.h"
#include "ttf/capture/control.h"

#define LIVING_ASKS_MAX 6
#define LIVING_YAML     "# asked for\n" /* of a whole plan */

struct living {
    unsigned n_asks, n_plans;
    struct ttf_ask asks[LIVING_ASKS_MAX]; /* in the order in which they are asked and due */
    int plan_of[LIVING_ASKS_MAX];         /* the plan that the ask brings; 0: none */
    struct ttf_plan plans[LIVING_ASKS_MAX + 2];
};

/* Nothing is asked for yet. */
void living_init(struct living *living, const struct ttf_plan *plan);

/*
 * One more ask, due with slot `from` or later than those before it. value: COUNT and UNTIL: slots; INTERVAL: ns;
 * PHOTOPERIOD: the day, in ns; PLAN: the interval, in ns, and one slot more. UNTIL is the last change of plan, as an
 * instant means so many slots on the grid of the first boot alone.
 */
void living_ask(struct living *living, enum ttf_ask_kind kind, int64_t from, int64_t value);

/* A longer plan that nobody asks for: a boot is given it. Its number. */
int living_longer(struct living *living, int64_t slots);

/* Some of them, of a run of at least two slots. */
void living_draw(struct living *living, struct draw *draw);

/* The text of an ask for a note. */
const char *living_note(const struct living *living, unsigned ask);

/* Why slot `index` is recorded `paused` if these asks (bits) were asked in its boot; NULL: it is not. */
const char *living_paused(const struct living *living, uint32_t asked, int64_t index);

#endif
