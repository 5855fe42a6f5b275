/* SPDX-License-Identifier: Apache-2.0 */
#include "plan_change.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "plan_end.h"
#include "ttf/base/time.h"

struct ttf_plan_change *ttf_plan_change_new(const struct ttf_plan *plan, const char *yaml)
{
    struct ttf_plan_change *change = calloc(1, sizeof(*change));

    if (!change)
        return NULL;
    change->count = plan->count;
    change->reserve_bytes = plan->reserve_bytes;
    change->yaml = yaml ? strdup(yaml) : NULL;
    if (ttf_plan_json(plan, &change->json, NULL) < 0 || (yaml && !change->yaml)) {
        ttf_plan_change_free(change);
        return NULL;
    }
    return change;
}

void ttf_plan_change_free(struct ttf_plan_change *change)
{
    if (!change)
        return;
    free(change->json);
    free(change->yaml);
    free(change);
}

static const struct ttf_plan_shot *shot_of(const struct ttf_plan *plan, const char *stream)
{
    for (unsigned i = 0; i < plan->n_shots; i++)
        if (strcmp(plan->shots[i].stream, stream) == 0)
            return &plan->shots[i];
    return NULL;
}

/* A whole plan may differ from the one in force in what can change while cameras stay as they are. */
static int check_whole(const struct ttf_plan *plan, const struct ttf_plan *wanted,
                       struct ttf_err *err)
{
    struct ttf_plan as = *wanted;
    int r;

    for (unsigned i = 0; i < wanted->n_shots; i++) {
        if (shot_of(plan, wanted->shots[i].stream))
            continue;
        ttf_err_set(err, -EINVAL, "shots",
                    "stream '%s' is new: it needs a new dataset of the group",
                    wanted->shots[i].stream);
        ttf_err_hint(err, "stop this run, and begin another dataset beside this one, with 'group: "
                          "NAME-OF-THIS-ONE' in the new plan");
        return -EINVAL;
    }
    memcpy(as.title, plan->title, sizeof(as.title));
    as.interval_ns = plan->interval_ns;
    as.count = plan->count;
    as.end = plan->end;
    as.until_utc_ns = plan->until_utc_ns;
    as.length_ns = plan->length_ns;
    as.day_ns = plan->day_ns;
    as.period_ns = plan->period_ns;
    as.phase_ns = plan->phase_ns;
    as.photoperiod_local = plan->photoperiod_local;
    as.day_start_s = plan->day_start_s;
    as.n_day_levels = plan->n_day_levels;
    memcpy(as.day_levels, plan->day_levels, sizeof(as.day_levels));
    as.start_utc_ns = plan->start_utc_ns;
    as.reserve_bytes = plan->reserve_bytes;
    r = ttf_plan_same(&as, plan);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "the plan cannot be compared: %s", strerrordesc_np(-r));
    if (r > 0)
        return 0;
    ttf_err_set(err, -EINVAL, "shots",
                "only title, interval, length, photoperiod and reserve change while a run lives");
    ttf_err_hint(err, "stop, and run with the new plan into the same dataset");
    return -EINVAL;
}

static int change_photoperiod(struct ttf_plan *plan, const struct ttf_ask *ask, struct ttf_err *err)
{
    if (plan->lamps != TTF_LAMPS_PHOTOPERIOD) {
        ttf_err_set(err, -EINVAL, "lamps.mode", "this plan has no photoperiod");
        ttf_err_hint(err, "stop, and run with a plan that has one");
        return -EINVAL;
    }
    plan->day_ns = ask->day_ns;
    plan->period_ns = ask->period_ns;
    plan->photoperiod_local = ask->local;
    plan->day_start_s = ask->local ? ask->day_start_s : 0;
    plan->phase_ns = ask->local ? 0 : ask->phase_ns;
    return 0;
}

int ttf_plan_changed(const struct ttf_plan *plan, const struct ttf_ask *ask, int64_t index,
                     struct ttf_plan *ret, struct ttf_err *err)
{
    struct ttf_plan changed = *plan;
    int r = 0;

    switch (ask->kind) {
    case TTF_ASK_COUNT:
        changed.count = ask->count;
        changed.end = TTF_END_COUNT;
        changed.until_utc_ns = changed.length_ns = 0;
        break;
    case TTF_ASK_UNTIL:
        changed.end = TTF_END_UNTIL;
        changed.until_utc_ns = ask->until_utc_ns;
        changed.length_ns = 0;
        break;
    case TTF_ASK_INTERVAL:
        changed.interval_ns = ask->interval_ns;
        break;
    case TTF_ASK_PHOTOPERIOD:
        r = change_photoperiod(&changed, ask, err);
        break;
    case TTF_ASK_PLAN:
        r = check_whole(plan, &ask->plan, err);
        changed = ask->plan;
        changed.start_utc_ns = plan->start_utc_ns;
        changed.zone_offset_s = plan->zone_offset_s;
        break;
    default:
        r = ttf_err_set(err, -EINVAL, NULL, "changes no plan");
        break;
    }
    if (r < 0)
        return r;
    if (changed.count < index && !ttf_plan_ends_in_time(&changed))
        return ttf_err_set(err, -EINVAL, "count", "%lld slots have their records already",
                           (long long)index);
    *ret = changed;
    return 0;
}

struct ttf_grid ttf_grid_changed(const struct ttf_grid *grid, int64_t index, int64_t interval_ns,
                                 int64_t ready_ns)
{
    struct ttf_grid changed = {index, ttf_grid_due_ns(grid, index), interval_ns};

    if (index == 0 || interval_ns == grid->interval_ns)
        return changed;
    changed.origin_ns = ttf_grid_due_ns(grid, index - 1) + interval_ns;
    if (changed.origin_ns < ready_ns)
        changed.origin_ns +=
            (ready_ns - changed.origin_ns + interval_ns - 1) / interval_ns * interval_ns;
    return changed;
}
