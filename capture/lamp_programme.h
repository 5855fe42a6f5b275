/* SPDX-License-Identifier: Apache-2.0 */
/*
 * lamp_programme.h: which lamp should be at which level when. Pure: levels and
 * instants out, no commands. Photoperiods run in time elapsed since slot 0; local
 * ones are turned into that once, so clock steps and daylight saving never reach the plants.
 */
#ifndef TTF_CAPTURE_PRIVATE_LAMP_PROGRAMME_H
#define TTF_CAPTURE_PRIVATE_LAMP_PROGRAMME_H

#include <stdbool.h>

#include "ttf/capture/plan.h"

struct ttf_lamp_programme {
    enum ttf_lamp_mode mode;
    unsigned n_lamps;
    unsigned shot[TTF_PLAN_SHOTS_MAX][TTF_LAMPS_MAX]; /* permille during each shot */
    unsigned day[TTF_LAMPS_MAX];                      /* between slots: continuous, or by day */
    int64_t begin_ns; /* boot clock: dark before it; the caller may set it after init */
    int64_t zero_ns;  /* boot clock: where slot 0 is, or would have been, due */
    int64_t day_ns, period_ns, phase_ns;
};

/*
 * From a plan. lamps may be NULL (no lamps). -ENOENT and the plan's field in
 * err->where for a lamp the box has not got.
 */
TTF_MUST_USE int ttf_lamp_programme_init(struct ttf_lamp_programme *ret,
                                         const struct ttf_plan *plan, const struct ttf_lamps *lamps,
                                         int64_t zero_ns, struct ttf_err *err);

/* Levels between slots at t_ns. ret: n_lamps entries. */
void ttf_lamp_programme_background(const struct ttf_lamp_programme *programme, int64_t t_ns,
                                   unsigned ret[TTF_LAMPS_MAX]);

/* The next instant after t_ns at which the background changes, or TTF_NS_NEVER. */
int64_t ttf_lamp_programme_next_change(const struct ttf_lamp_programme *programme, int64_t t_ns);

/*
 * The phase, in time since slot 0, at which local day begins: resolved once.
 * slot0_utc_ns: UTC of slot 0. Result in [0, 24 h).
 */
int64_t ttf_photoperiod_phase_ns(int64_t slot0_utc_ns, int zone_offset_s, int day_start_s);

/* Settle time of a shot: the plan's, or the longest warm-up of the lamps it lights (0 without lamps). */
int64_t ttf_lamp_settle_ns(const struct ttf_plan *plan, const struct ttf_plan_shot *shot,
                           const struct ttf_lamps *lamps);

#endif
