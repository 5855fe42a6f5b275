/* SPDX-License-Identifier: Apache-2.0 */
/* What people ask of a run of chaos while it lives, and what must have come of it. */
#include "chaos.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A step of UTC in a drawn fault is no longer. */
#define STEP_MOST_NS (4000 * TTF_NS_PER_S)

/* ---- drawing ---- */

static bool steps_may_come(const struct chaos *c)
{
    for (unsigned i = 0; i < c->run.config.n_faults; i++)
        if (c->run.config.faults[i].kind == TTF_FAULT_CLOCK_STEP)
            return true;
    return false;
}

static int64_t span_of(struct chaos *c)
{
    const struct ttf_plan *plan = &c->run.plan;

    return chaos_between(c, 1, 3 * plan->count) * plan->interval_ns / 2;
}

static void draw_end(struct chaos *c, struct ttf_ask *ask)
{
    const struct ttf_plan *plan = &c->run.plan;
    /* By a clock that is an hour off, an instant may be thousands of short slots away. */
    bool far = plan->interval_ns < 20 * TTF_NS_PER_S && steps_may_come(c);

    switch (chaos_below(c, far ? 2 : 3)) {
    case 0:
        ask->kind = TTF_ASK_COUNT;
        ask->count = chaos_between(c, 1, plan->count + 15);
        break;
    case 1:
        ask->kind = TTF_ASK_PLAN;
        ask->plan.length_ns = span_of(c);
        break;
    default:
        ask->kind = TTF_ASK_UNTIL;
        ask->until_utc_ns = c->run.config.start_utc_ns + span_of(c);
        if (plan->start_utc_ns > c->run.config.start_utc_ns)
            ask->until_utc_ns += plan->start_utc_ns - c->run.config.start_utc_ns;
        break;
    }
}

static void draw_ask(struct chaos *c, unsigned n)
{
    struct chaos_ask *a = &c->asks[n];
    struct ttf_ask *ask = &a->ask;
    uint64_t what = chaos_below(c, 10);

    a->at = chaos_between(c, -1, c->run.plan.count - 1);
    if (chaos_percent(c, 50))
        ask->from_index = a->at + 1 + (int64_t)chaos_below(c, 5);
    if (what < 4) {
        draw_end(c, ask);
    } else if (what < 7) {
        ask->kind = TTF_ASK_INTERVAL;
        ask->interval_ns = c->run.plan.interval_ns * chaos_between(c, 2, 12) / 4;
    } else if (what < 8) {
        ask->kind = TTF_ASK_PAUSE;
    } else if (what < 9) {
        ask->kind = TTF_ASK_CONTINUE;
    } else {
        ask->kind = TTF_ASK_NOTE;
        snprintf(ask->note.text, sizeof(ask->note.text), "note %u of seed %llu", n,
                 (unsigned long long)c->seed);
        ask->note.utc_ns = TTF_NS_UNKNOWN;
    }
}

void chaos_asks_draw(struct chaos *c)
{
    c->n_asks = chaos_percent(c, 60) ? 1 + (unsigned)chaos_below(c, CHAOS_ASKS_MAX) : 0;
    for (unsigned i = 0; i < c->n_asks; i++)
        draw_ask(c, i);
}

void chaos_asks_describe(const struct chaos *c)
{
    static const char *const states[] = {"not asked", "asked", "done", "refused", "unanswered"};
    static const char *const kinds[] = {"stop",     "pause",       "continue", "count", "until",
                                        "interval", "photoperiod", "length",   "note"};

    for (unsigned i = 0; i < c->n_asks; i++) {
        const struct chaos_ask *a = &c->asks[i];
        const struct ttf_ask *ask = &a->ask;

        printf(
            "  asked at %lld for %lld: %s, count %lld, until %.3f s, length %.3f s, interval "
            "%.3f s: %s%s\n",
            (long long)a->at, (long long)ask->from_index, kinds[ask->kind], (long long)ask->count,
            ask->until_utc_ns ? (double)(ask->until_utc_ns - c->run.config.start_utc_ns) / 1e9 : 0,
            (double)ask->plan.length_ns / 1e9, (double)ask->interval_ns / 1e9, states[a->state],
            a->said);
    }
}

struct chaos_bounds chaos_bounds_of(const struct chaos *c)
{
    struct chaos_bounds b = {c->run.plan.interval_ns, c->run.plan.count};
    int64_t least_ns = c->run.plan.interval_ns;

    for (unsigned i = 0; i < c->n_asks; i++) {
        int64_t interval = c->asks[i].ask.interval_ns;

        b.interval_ns = interval > b.interval_ns ? interval : b.interval_ns;
        least_ns = interval > 0 && interval < least_ns ? interval : least_ns;
    }
    for (unsigned i = 0; i < c->n_asks; i++) {
        const struct ttf_ask *ask = &c->asks[i].ask;
        int64_t slots = ask->count;

        if (ask->kind == TTF_ASK_PLAN)
            slots = ask->plan.length_ns / least_ns + 1;
        if (ask->kind == TTF_ASK_UNTIL)
            slots = (ask->until_utc_ns - c->run.config.start_utc_ns +
                     STEP_MOST_NS * c->run.config.n_faults) /
                        least_ns +
                    1;
        b.slots = slots > b.slots ? slots : b.slots;
    }
    return b;
}

/* ---- asking; in the process of a boot ---- */

void chaos_asks_poll(struct chaos *c)
{
    for (unsigned i = 0; i < c->n_asks; i++) {
        struct chaos_ask *a = &c->asks[i];
        struct ttf_err err = {0};
        int r;

        if (a->state != CHAOS_ASKED)
            continue;
        r = ttf_control_answer(c->run.control, a->number, &err);
        if (r == -EAGAIN)
            continue;
        /* Of what was on its way when the run ended nobody has said anything. */
        a->state = r == 0 ? CHAOS_DONE : r == -ECANCELED ? CHAOS_UNANSWERED : CHAOS_REFUSED;
        if (r < 0)
            snprintf(a->said, sizeof(a->said), ": %.100s", err.what);
        if (r < 0 && err.what[0] == '\0')
            chaos_fail(c, "ask %u was answered %d without a reason", i, r);
    }
}

void chaos_asks_told(struct chaos *c, int64_t index)
{
    chaos_asks_poll(c);
    for (unsigned i = 0; i < c->n_asks; i++) {
        struct chaos_ask *a = &c->asks[i];
        struct ttf_ask *ask = &a->ask;

        if (a->state != CHAOS_NOT_ASKED || index < a->at)
            continue;
        if (ask->kind == TTF_ASK_PLAN) {
            int64_t length_ns = ask->plan.length_ns;

            ask->plan = c->run.plan;
            ask->plan.end = TTF_END_LENGTH;
            ask->plan.length_ns = length_ns;
        }
        a->number = ttf_control_ask(c->run.control, ask);
        a->state = CHAOS_ASKED;
        if (a->number <= 0)
            chaos_fail(c, "ask %u was not taken: %lld", i, (long long)a->number);
    }
}

/* Whoever asked and heard nothing before the boot was over will hear no more. */
void chaos_asks_over(struct chaos *c)
{
    for (unsigned i = 0; i < c->n_asks; i++)
        if (c->asks[i].state == CHAOS_ASKED)
            c->asks[i].state = CHAOS_UNANSWERED;
}

/* ---- what came of it ---- */

static bool says(const struct ttf_plan *plan, const struct ttf_ask *ask)
{
    switch (ask->kind) {
    case TTF_ASK_COUNT:
        return plan->end == TTF_END_COUNT && plan->count == ask->count;
    case TTF_ASK_UNTIL:
        return plan->end == TTF_END_UNTIL && plan->until_utc_ns == ask->until_utc_ns;
    case TTF_ASK_PLAN:
        return plan->end == TTF_END_LENGTH && plan->length_ns == ask->plan.length_ns;
    default:
        return plan->interval_ns == ask->interval_ns;
    }
}

/* Whether some plan that is, or was, in force says it. */
static bool came_into_force(struct chaos *c, const struct chaos_part *part,
                            const struct ttf_ask *ask)
{
    struct ttf_segment segment;
    struct ttf_plan plan;
    int last = -1;

    for (int i = 0; i < ttf_reader_summary(part->reader)->n_segments; i++) {
        if (ttf_reader_segment(part->reader, i, &segment) < 0 || segment.plan == last)
            continue;
        last = segment.plan;
        if (!chaos_plan_load(part, last, &plan))
            chaos_fail(c, "plan %d of segment %d cannot be read", last, i);
        else if (says(&plan, ask))
            return true;
    }
    return false;
}

static bool noted(const struct chaos_part *part, const char *text)
{
    char path[160];
    char *all = NULL;
    size_t bytes;
    bool found;

    snprintf(path, sizeof(path), "%s/notes.jsonl", part->path);
    if (ttf_io_slurp(ttf_io_posix(), path, 1 << 20, &all, &bytes, NULL) < 0)
        return false;
    found = strstr(all, text) != NULL;
    free(all);
    return found;
}

void chaos_asks_check(struct chaos *c, const struct chaos_parts *parts)
{
    for (unsigned i = 0; i < c->n_asks; i++) {
        const struct chaos_ask *a = &c->asks[i];
        const struct ttf_ask *ask = &a->ask;
        bool found = false;

        if (a->state != CHAOS_DONE || ask->kind == TTF_ASK_PAUSE || ask->kind == TTF_ASK_CONTINUE)
            continue;
        for (unsigned p = 0; p < parts->n; p++)
            found |= ask->kind == TTF_ASK_NOTE ? noted(&parts->part[p], ask->note.text)
                                               : came_into_force(c, &parts->part[p], ask);
        if (!found)
            chaos_fail(c, "what ask %u was answered is not there", i);
    }
}

bool chaos_asks_may_change(const struct chaos *c)
{
    for (unsigned i = 0; i < c->n_asks; i++) {
        const struct chaos_ask *a = &c->asks[i];

        if (a->state != CHAOS_NOT_ASKED &&
            (a->ask.kind == TTF_ASK_INTERVAL || a->ask.kind == TTF_ASK_PLAN))
            return true;
    }
    return false;
}

bool chaos_asks_may_pause(const struct chaos *c, int64_t index)
{
    for (unsigned i = 0; i < c->n_asks; i++) {
        const struct chaos_ask *a = &c->asks[i];

        if (a->ask.kind == TTF_ASK_PAUSE && a->state != CHAOS_NOT_ASKED && index > a->at &&
            index >= a->ask.from_index)
            return true;
    }
    return false;
}
