/* SPDX-License-Identifier: Apache-2.0 */
#include "session_living.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "ttf/hal/sim.h"

void living_init(struct living *living, const struct ttf_plan *plan)
{
    memset(living, 0, sizeof(*living));
    living->plans[living->n_plans++] = *plan;
}

/* Slot 0 is due some seconds after power-on, and before a minute is over. */
static int64_t instant_after(int64_t slots)
{
    struct ttf_sim_config config;

    ttf_sim_config_defaults(&config);
    return config.start_utc_ns + slots * TTF_NS_PER_MIN;
}

static void change(struct ttf_plan *plan, struct ttf_ask *ask, int64_t value)
{
    switch (ask->kind) {
    case TTF_ASK_COUNT:
        plan->count = ask->count = value;
        plan->end = TTF_END_COUNT;
        break;
    case TTF_ASK_UNTIL:
        plan->count = value;
        plan->end = TTF_END_UNTIL;
        plan->until_utc_ns = ask->until_utc_ns = instant_after(value);
        break;
    case TTF_ASK_INTERVAL:
        plan->interval_ns = ask->interval_ns = value;
        break;
    case TTF_ASK_PHOTOPERIOD:
        plan->day_ns = ask->day_ns = value;
        ask->period_ns = plan->period_ns;
        ask->phase_ns = plan->phase_ns;
        break;
    default:
        plan->interval_ns = value;
        plan->count++;
        snprintf(plan->title, sizeof(plan->title), "another title");
        ask->plan = *plan;
        ask->plan_yaml = LIVING_YAML;
    }
}

void living_ask(struct living *living, enum ttf_ask_kind kind, int64_t from, int64_t value)
{
    unsigned i = living->n_asks++;
    struct ttf_ask *ask = &living->asks[i];

    if (i >= LIVING_ASKS_MAX)
        abort();
    ask->kind = kind;
    ask->from_index = from;
    switch (kind) {
    case TTF_ASK_STOP:
    case TTF_ASK_CONTINUE:
        break;
    case TTF_ASK_PAUSE:
        snprintf(ask->reason, sizeof(ask->reason), "somebody looks, as asked by %u", i);
        break;
    case TTF_ASK_NOTE:
        ask->note.utc_ns = TTF_NS_UNKNOWN;
        snprintf(ask->note.text, sizeof(ask->note.text), "note %u is said of the sample", i);
        break;
    default:
        living->plan_of[i] = (int)living->n_plans++;
        living->plans[living->plan_of[i]] = living->plans[living->plan_of[i] - 1];
        change(&living->plans[living->plan_of[i]], ask, value);
    }
}

int living_longer(struct living *living, int64_t slots)
{
    int longer = (int)living->n_plans++;

    living->plans[longer] = living->plans[longer - 1];
    living->plans[longer].count += slots;
    living->plans[longer].end = TTF_END_COUNT;
    living->plans[longer].until_utc_ns = 0;
    return longer;
}

/* Another of that kind, so that no two plans are alike. */
static int64_t draw_value(const struct living *living, enum ttf_ask_kind kind, struct draw *draw)
{
    const struct ttf_plan *plan = &living->plans[living->n_plans - 1];

    switch (kind) {
    case TTF_ASK_COUNT:
    case TTF_ASK_UNTIL:
        return plan->count + 1 + (int64_t)draw_below(draw, 2);
    case TTF_ASK_PHOTOPERIOD:
        return plan->day_ns - 10 * TTF_NS_PER_S;
    default:
        return plan->interval_ns - (5 + (int64_t)draw_below(draw, 5)) * TTF_NS_PER_S;
    }
}

void living_draw(struct living *living, struct draw *draw)
{
    static const enum ttf_ask_kind kinds[] = {TTF_ASK_COUNT,    TTF_ASK_INTERVAL,    TTF_ASK_PLAN,
                                              TTF_ASK_NOTE,     TTF_ASK_NOTE,        TTF_ASK_PAUSE,
                                              TTF_ASK_CONTINUE, TTF_ASK_PHOTOPERIOD, TTF_ASK_STOP};
    int64_t slots = living->plans[0].count, from = 0;
    bool stops = false, moved_grid = false;

    while (living->n_asks < LIVING_ASKS_MAX - 1 && draw_below(draw, 6) > 0) {
        enum ttf_ask_kind kind = kinds[draw_below(draw, sizeof(kinds) / sizeof(kinds[0]))];

        from += (int64_t)draw_below(draw, 2);
        if (from >= slots || (kind == TTF_ASK_STOP && (stops || from == 0)) ||
            (kind == TTF_ASK_PHOTOPERIOD && living->plans[0].lamps != TTF_LAMPS_PHOTOPERIOD))
            continue;
        stops = stops || kind == TTF_ASK_STOP;
        moved_grid = moved_grid || kind == TTF_ASK_INTERVAL || kind == TTF_ASK_PLAN;
        living_ask(living, kind, from, draw_value(living, kind, draw));
    }
    if (from >= slots || draw_below(draw, 2))
        return;
    if (from + 1 < slots && draw_below(draw, 2))
        living_ask(living, TTF_ASK_COUNT, from, from + 1); /* fewer, and none asks for more then */
    else if (!moved_grid && !stops)
        living_ask(living, TTF_ASK_UNTIL, from, draw_value(living, TTF_ASK_UNTIL, draw));
}

const char *living_note(const struct living *living, unsigned ask)
{
    return living->asks[ask].note.text;
}

const char *living_paused(const struct living *living, uint32_t asked, int64_t index)
{
    const char *reason = NULL;

    for (unsigned i = 0; i < living->n_asks; i++) {
        const struct ttf_ask *ask = &living->asks[i];

        if (!(asked & UINT32_C(1) << i) || ask->from_index > index)
            continue;
        if (ask->kind == TTF_ASK_PAUSE)
            reason = ask->reason;
        else if (ask->kind == TTF_ASK_CONTINUE)
            reason = NULL;
    }
    return reason;
}
