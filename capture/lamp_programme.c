/* SPDX-License-Identifier: Apache-2.0 */
#include "lamp_programme.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

static int fill_levels(const struct ttf_lamp_level *levels, unsigned n, const char *field,
                       const struct ttf_lamps *lamps, unsigned ret[TTF_LAMPS_MAX],
                       struct ttf_err *err)
{
    memset(ret, 0, TTF_LAMPS_MAX * sizeof(*ret));
    for (unsigned i = 0; i < n; i++) {
        char where[96];
        int lamp = lamps ? ttf_lamps_find(lamps, levels[i].lamp) : -ENOENT;

        if (lamp < 0) {
            snprintf(where, sizeof(where), "%s.%s", field, levels[i].lamp);
            return ttf_err_set(err, -ENOENT, where, "the box has no lamp '%s'", levels[i].lamp);
        }
        ret[lamp] = levels[i].permille;
    }
    return 0;
}

int ttf_lamp_programme_init(struct ttf_lamp_programme *ret, const struct ttf_plan *plan,
                            const struct ttf_lamps *lamps, int64_t zero_ns, struct ttf_err *err)
{
    struct ttf_lamp_programme p = {
        .mode = plan->lamps,
        .n_lamps = lamps ? ttf_lamps_count(lamps) : 0,
        .begin_ns = INT64_MIN,
        .zero_ns = zero_ns,
        .day_ns = plan->day_ns,
        .period_ns = plan->period_ns,
        .phase_ns = plan->phase_ns,
    };
    int r;

    for (unsigned i = 0; i < plan->n_shots; i++) {
        char field[32];

        snprintf(field, sizeof(field), "shots[%u].lamps", i);
        r = fill_levels(plan->shots[i].levels, plan->shots[i].n_levels, field, lamps, p.shot[i],
                        err);
        if (r < 0)
            return r;
    }
    if (plan->lamps == TTF_LAMPS_CONTINUOUS) {
        memcpy(p.day, p.shot[0], sizeof(p.day));
    } else if (plan->lamps == TTF_LAMPS_PHOTOPERIOD) {
        r = fill_levels(plan->day_levels, plan->n_day_levels, "lamps.day_levels", lamps, p.day,
                        err);
        if (r < 0)
            return r;
    }
    *ret = p;
    return 0;
}

/* Where t lies within its period, 0 = day begins. */
static int64_t in_period(const struct ttf_lamp_programme *p, int64_t t_ns)
{
    int64_t at = (t_ns - p->zero_ns - p->phase_ns) % p->period_ns;

    return at < 0 ? at + p->period_ns : at;
}

void ttf_lamp_programme_background(const struct ttf_lamp_programme *programme, int64_t t_ns,
                                   unsigned ret[TTF_LAMPS_MAX])
{
    bool lit = t_ns >= programme->begin_ns && (programme->mode == TTF_LAMPS_CONTINUOUS ||
                                               (programme->mode == TTF_LAMPS_PHOTOPERIOD &&
                                                in_period(programme, t_ns) < programme->day_ns));

    for (unsigned i = 0; i < TTF_LAMPS_MAX; i++)
        ret[i] = lit ? programme->day[i] : 0;
}

int64_t ttf_lamp_programme_next_change(const struct ttf_lamp_programme *programme, int64_t t_ns)
{
    int64_t at;

    if (t_ns < programme->begin_ns)
        return programme->begin_ns;
    if (programme->mode != TTF_LAMPS_PHOTOPERIOD || programme->day_ns >= programme->period_ns ||
        programme->day_ns <= 0)
        return TTF_NS_NEVER;
    at = in_period(programme, t_ns);
    return t_ns + (at < programme->day_ns ? programme->day_ns - at : programme->period_ns - at);
}

int64_t ttf_photoperiod_phase_ns(int64_t slot0_utc_ns, int zone_offset_s, int day_start_s)
{
    int64_t local = slot0_utc_ns + zone_offset_s * TTF_NS_PER_S;
    int64_t phase = (day_start_s * TTF_NS_PER_S - local) % TTF_NS_PER_DAY;

    return phase < 0 ? phase + TTF_NS_PER_DAY : phase;
}

int64_t ttf_lamp_settle_ns(const struct ttf_plan *plan, const struct ttf_plan_shot *shot,
                           const struct ttf_lamps *lamps)
{
    int64_t longest = 0;

    if (plan->settle_ns > 0)
        return shot->n_levels > 0 || plan->lamps != TTF_LAMPS_NONE ? plan->settle_ns : 0;
    for (unsigned i = 0; lamps && i < shot->n_levels; i++) {
        int lamp = ttf_lamps_find(lamps, shot->levels[i].lamp);

        if (lamp >= 0 && shot->levels[i].permille > 0 &&
            ttf_lamps_info(lamps, (unsigned)lamp)->warm_up_ns > longest)
            longest = ttf_lamps_info(lamps, (unsigned)lamp)->warm_up_ns;
    }
    return longest;
}
