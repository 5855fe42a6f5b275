/* SPDX-License-Identifier: Apache-2.0 */
/* Whether a plan makes sense, by itself and on a box. err->where names the plan's field. */
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "exposure.h"
#include "lamp_programme.h"
#include "plan_figures.h"
#include "ttf/base/checked.h"
#include "ttf/base/time.h"
#include "ttf/dataset/copy.h"

#define INTERVAL_MIN_NS (100 * TTF_NS_PER_MS)
#define INTERVAL_MAX_NS (366 * TTF_NS_PER_DAY)
#define SETTLE_MAX_NS   (24 * TTF_NS_PER_H)
#define RUN_MAX_NS      (100 * 366 * TTF_NS_PER_DAY)
#define COUNT_MAX       INT64_C(1000000000)
#define EXPOSURE_MAX_NS TTF_NS_PER_H
#define BRACKET_MAX     1024.0

static int bad(struct ttf_err *err, const char *field, const char *what)
{
    return ttf_err_set(err, -EINVAL, field, "%s", what);
}

/* "shots[2].exposure" */
static const char *shot_field(char *buf, size_t size, unsigned shot, const char *field)
{
    snprintf(buf, size, "shots[%u].%s", shot, field);
    return buf;
}

static bool good_name(const char *name)
{
    if (name[0] == '\0')
        return false;
    for (; *name; name++) {
        if (!((*name >= 'a' && *name <= 'z') || (*name >= '0' && *name <= '9') || *name == '-'))
            return false;
    }
    return true;
}

static int check_times(const struct ttf_plan *plan, struct ttf_err *err)
{
    int64_t run;

    if (plan->interval_ns < INTERVAL_MIN_NS)
        return bad(err, "interval", "the interval must be at least 100 ms");
    if (plan->interval_ns > INTERVAL_MAX_NS)
        return bad(err, "interval", "the interval must be at most 366 days");
    if (plan->count < 1 || plan->count > COUNT_MAX)
        return bad(err, "count", "the number of slots must be 1 to 1000000000");
    if (!ttf_mul_i64(plan->count, plan->interval_ns, &run) || run > RUN_MAX_NS)
        return bad(err, "count", "the run would take more than a hundred years");
    if (plan->end == TTF_END_UNTIL && plan->until_utc_ns <= 0)
        return bad(err, "until", "the end lies before 1970");
    if (plan->end == TTF_END_LENGTH && (plan->length_ns < 1 || plan->length_ns > RUN_MAX_NS))
        return bad(err, "until", "the run must take some time, and at most a hundred years");
    if (plan->start_utc_ns < 0)
        return bad(err, "start", "the start lies before 1970");
    if (plan->zone_offset_s < -24 * 3600 || plan->zone_offset_s > 24 * 3600)
        return bad(err, "zone", "the zone is more than a day from UTC");
    return 0;
}

static int check_levels(const struct ttf_lamp_level *levels, unsigned n, const char *field,
                        struct ttf_err *err)
{
    char where[96];

    if (n > TTF_LAMPS_MAX)
        return ttf_err_set(err, -EINVAL, field, "more than %d lamps", TTF_LAMPS_MAX);
    for (unsigned i = 0; i < n; i++) {
        snprintf(where, sizeof(where), "%s.%s", field, levels[i].lamp);
        if (levels[i].permille > TTF_LAMP_FULL)
            return bad(err, where, "a lamp's level must be 0 to 100 %");
        for (unsigned j = 0; j < i; j++) {
            if (strcmp(levels[i].lamp, levels[j].lamp) == 0)
                return bad(err, where, "the lamp is named twice");
        }
    }
    return 0;
}

static int check_photoperiod(const struct ttf_plan *plan, struct ttf_err *err)
{
    if (plan->period_ns <= 0 || plan->period_ns > RUN_MAX_NS)
        return bad(err, "lamps.period", "a photoperiod needs a period, as 24h");
    if (plan->day_ns < 0 || plan->day_ns > plan->period_ns)
        return bad(err, "lamps.day", "the day must be no longer than the period");
    if (plan->phase_ns < -plan->period_ns || plan->phase_ns > plan->period_ns)
        return bad(err, "lamps.phase", "the phase must lie within a period");
    if (plan->photoperiod_local && plan->period_ns != TTF_NS_PER_DAY)
        return bad(err, "lamps.period", "a day that starts at a local time has a period of 24h");
    if (plan->photoperiod_local &&
        (plan->day_start_s < 0 || plan->day_start_s >= (int)(TTF_NS_PER_DAY / TTF_NS_PER_S)))
        return bad(err, "lamps.day_start", "the day must start between 00:00 and 23:59:59");
    return check_levels(plan->day_levels, plan->n_day_levels, "lamps.day_levels", err);
}

static int check_lamps(const struct ttf_plan *plan, struct ttf_err *err)
{
    char where[64];
    int r;

    if (plan->lamps < TTF_LAMPS_NONE || plan->lamps > TTF_LAMPS_PHOTOPERIOD)
        return bad(err, "lamps.mode", "no such way of driving lamps");
    if (plan->settle_ns < 0 || plan->settle_ns > SETTLE_MAX_NS)
        return bad(err, "lamps.settle", "the settle time must be 0 to 24 h");
    for (unsigned i = 0; i < plan->n_shots; i++) {
        const struct ttf_plan_shot *shot = &plan->shots[i];

        r = check_levels(shot->levels, shot->n_levels, shot_field(where, sizeof(where), i, "lamps"),
                         err);
        if (r < 0)
            return r;
        if (plan->lamps == TTF_LAMPS_NONE && shot->n_levels > 0) {
            bad(err, where, "the shot lights lamps, but the plan's lamps.mode is none");
            ttf_err_hint(err, "say lamps.mode: capture-only, continuous or photoperiod");
            return -EINVAL;
        }
    }
    return plan->lamps == TTF_LAMPS_PHOTOPERIOD ? check_photoperiod(plan, err) : 0;
}

static int check_brackets(const struct ttf_plan_shot *shot, unsigned i, struct ttf_err *err)
{
    char where[64];
    char name[32];
    bool has_reference = shot->n_brackets <= 1;

    if (shot->n_brackets > TTF_PLAN_BRACKETS_MAX)
        return ttf_err_set(err, -EINVAL, shot_field(where, sizeof(where), i, "brackets"),
                           "more than %d brackets", TTF_PLAN_BRACKETS_MAX);
    for (unsigned b = 0; shot->n_brackets > 1 && b < shot->n_brackets; b++) {
        snprintf(name, sizeof(name), "brackets[%u]", b);
        if (!isfinite(shot->brackets[b]) || shot->brackets[b] < 1 / BRACKET_MAX ||
            shot->brackets[b] > BRACKET_MAX)
            return bad(err, shot_field(where, sizeof(where), i, name),
                       "a relative exposure must lie between 1/1024 and 1024");
        if (shot->brackets[b] == 1)
            has_reference = true;
    }
    if (!has_reference)
        return bad(err, shot_field(where, sizeof(where), i, "brackets"),
                   "one of the relative exposures must be 1, the reference");
    return 0;
}

static int check_shot(const struct ttf_plan *plan, unsigned i, struct ttf_err *err)
{
    const struct ttf_plan_shot *shot = &plan->shots[i];
    char where[64];

    if (!good_name(shot->stream))
        return bad(err, shot_field(where, sizeof(where), i, "stream"),
                   "a stream's name is of a-z, 0-9 and -");
    if (!good_name(shot->channel))
        return bad(err, shot_field(where, sizeof(where), i, "channel"),
                   "a channel's name is of a-z, 0-9 and -");
    for (unsigned j = 0; j < i; j++) {
        if (strcmp(shot->stream, plan->shots[j].stream) == 0)
            return bad(err, shot_field(where, sizeof(where), i, "stream"),
                       "another shot has this stream; each shot needs its own");
    }
    if (shot->exposure.exposure_ns <= 0 || shot->exposure.exposure_ns > EXPOSURE_MAX_NS)
        return bad(err, shot_field(where, sizeof(where), i, "exposure"),
                   "an exposure must be more than 0 and at most an hour");
    if (shot->average < 1 || shot->average > TTF_PLAN_AVERAGE_MAX)
        return ttf_err_set(err, -EINVAL, shot_field(where, sizeof(where), i, "average"),
                           "1 to %d frames can be averaged", TTF_PLAN_AVERAGE_MAX);
    return check_brackets(shot, i, err);
}

static int check_rest(const struct ttf_plan *plan, struct ttf_err *err)
{
    if (!isfinite(plan->mains_hz) || plan->mains_hz < 0 || plan->mains_hz > 1000)
        return bad(err, "mains", "the mains frequency is 50 Hz, 60 Hz or none");
    if (!isfinite(plan->mm_per_px) || plan->mm_per_px < 0)
        return bad(err, "mm_per_px", "the scale must be positive");
    if (plan->reserve_bytes < 0)
        return bad(err, "reserve", "the reserve cannot be negative");
    if (plan->second_storage[0] && plan->second_storage[0] != '/')
        return bad(err, "storage.second",
                   "the second storage must be an absolute path, as /mnt/usb");
    if (plan->group[0] && !ttf_name_ok(plan->group))
        return bad(err, "group", "the group is told by the name of a dataset beside this one");
    if (plan->keep < TTF_KEEP_DEFAULT || plan->keep > TTF_KEEP_BOTH)
        return bad(err, "keep", "keep is raw, developed or both");
    return 0;
}

/* ---- against the box ---- */

static int check_exposures(const struct ttf_plan *plan, unsigned i,
                           const struct ttf_camera_caps *caps, struct ttf_err *err)
{
    const struct ttf_plan_shot *shot = &plan->shots[i];
    struct ttf_exposure seen[TTF_PLAN_BRACKETS_MAX];
    char where[64];
    char name[32] = "exposure";

    if (caps->exposure_max_ns == 0 && shot->n_brackets > 1)
        return ttf_err_set(err, -EINVAL, shot_field(where, sizeof(where), i, "brackets"),
                           "the camera's exposure cannot be set, so there are no brackets");
    for (unsigned b = 0; b < ttf_shot_images(shot); b++) {
        struct ttf_exposure e = ttf_shot_exposure(shot, b, plan->mains_hz, 0);

        if (shot->n_brackets > 1)
            snprintf(name, sizeof(name), "brackets[%u]", b);
        shot_field(where, sizeof(where), i, name);
        if (e.exposure_ns < caps->exposure_min_ns ||
            (caps->exposure_max_ns > 0 && e.exposure_ns > caps->exposure_max_ns)) {
            ttf_err_set(err, -EINVAL, where, "%.3f ms is beyond the camera's %.3f to %.3f ms",
                        (double)e.exposure_ns / 1e6, (double)caps->exposure_min_ns / 1e6,
                        (double)caps->exposure_max_ns / 1e6);
            if (plan->mains_hz > 0)
                ttf_err_hint(err, "exposures snap to whole half-periods of the mains (%.3f ms)",
                             500 / plan->mains_hz);
            return -EINVAL;
        }
        for (unsigned j = 0; j < b; j++) {
            if (seen[j].exposure_ns == e.exposure_ns) {
                ttf_err_set(err, -EINVAL, where, "two brackets come to the same exposure, %.3f ms",
                            (double)e.exposure_ns / 1e6);
                ttf_err_hint(err, "exposures snap to whole half-periods of the mains");
                return -EINVAL;
            }
        }
        seen[b] = e;
    }
    return 0;
}

static int check_shot_on_box(const struct ttf_plan *plan, unsigned i, const struct ttf_box *box,
                             struct ttf_err *err)
{
    const struct ttf_plan_shot *shot = &plan->shots[i];
    const struct ttf_camera *camera = ttf_box_camera_find(box, shot->camera);
    const struct ttf_camera_caps *caps;
    const struct ttf_frame_format *format;
    struct ttf_region region;
    char where[64];

    if (!camera)
        return ttf_err_set(err, -EINVAL, shot_field(where, sizeof(where), i, "camera"),
                           "the box has no camera '%s'", shot->camera);
    format = ttf_camera_format(camera);
    if (!format)
        return ttf_err_set(err, -EINVAL, shot_field(where, sizeof(where), i, "camera"),
                           "the camera '%s' has not been configured", shot->camera);
    if (format->cfa == TTF_CFA_NONE && plan->keep == TTF_KEEP_RAW)
        return bad(err, "keep", "this camera has no raw frames to keep; say developed");
    caps = ttf_camera_caps(camera);
    if (caps->gain_max_milli > 0 && (shot->exposure.gain_milli < caps->gain_min_milli ||
                                     shot->exposure.gain_milli > caps->gain_max_milli))
        return ttf_err_set(err, -EINVAL, shot_field(where, sizeof(where), i, "gain"),
                           "%.3f is beyond the camera's gain of %.3f to %.3f",
                           shot->exposure.gain_milli / 1e3, caps->gain_min_milli / 1e3,
                           caps->gain_max_milli / 1e3);
    region = ttf_plan_region(plan, format);
    if ((int64_t)region.x + region.width > format->width ||
        (int64_t)region.y + region.height > format->height || region.height == 0)
        return ttf_err_set(err, -EINVAL, "region", "it does not lie in the camera's %u x %u frame",
                           format->width, format->height);
    if (plan->reference.width > 0 &&
        ((int64_t)plan->reference.x + plan->reference.width > region.width ||
         (int64_t)plan->reference.y + plan->reference.height > region.height ||
         plan->reference.height == 0))
        return bad(err, "reference", "it does not lie in the region");
    return check_exposures(plan, i, caps, err);
}

/* Longest time a lamp is on at a stretch; TTF_NS_NEVER: always. */
static int64_t longest_on_ns(const struct ttf_plan *plan, const struct ttf_box *box,
                             const struct ttf_lamp_programme *programme,
                             const struct ttf_plan_figures *f, unsigned i)
{
    if (f->lamp_on_ns[i] == 0)
        return 0;
    if (plan->lamps == TTF_LAMPS_CONTINUOUS && programme->day[i] > 0)
        return f->duration_ns + f->slot_busy_ns + ttf_first_settle_ns(plan, box);
    if (plan->lamps == TTF_LAMPS_PHOTOPERIOD && programme->day[i] > 0)
        return plan->day_ns < plan->period_ns ? plan->day_ns + f->slot_busy_ns : TTF_NS_NEVER;
    return f->slot_busy_ns;
}

/* As a person says it: lamps burn for hours. */
static const char *span(int64_t ns, char *ret, size_t size)
{
    if (ns == TTF_NS_NEVER)
        (void)snprintf(ret, size, "ever");
    else if (ns < TTF_NS_PER_H)
        (void)snprintf(ret, size, "%.4g s", (double)ns / 1e9);
    else
        (void)snprintf(ret, size, "%.4g h", (double)ns / TTF_NS_PER_H);
    return ret;
}

static int check_lamps_on_box(const struct ttf_plan *plan, const struct ttf_box *box,
                              const struct ttf_plan_figures *f, struct ttf_err *err)
{
    struct ttf_lamp_programme programme;
    int r = ttf_lamp_programme_init(&programme, plan, box->lamps, 0, err);

    if (r < 0)
        return err ? (err->code = -EINVAL) : -EINVAL;
    for (unsigned i = 0; box->lamps && i < ttf_lamps_count(box->lamps); i++) {
        const struct ttf_lamp_info *info = ttf_lamps_info(box->lamps, i);
        bool by_day = plan->lamps == TTF_LAMPS_PHOTOPERIOD && programme.day[i] > 0;
        int64_t on = longest_on_ns(plan, box, &programme, f, i);
        char a[32], b[32];

        if (info->max_on_ns > 0 && on > info->max_on_ns)
            return ttf_err_set(err, -EINVAL, by_day ? "lamps.day" : "lamps.mode",
                               "the lamp '%s' would be on for %s at a stretch; the board "
                               "allows %s",
                               info->name, span(on, a, sizeof a),
                               span(info->max_on_ns, b, sizeof b));
        if (info->max_duty_permille < 1000 && f->lamp_duty_permille[i] > info->max_duty_permille)
            return ttf_err_set(err, -EINVAL, by_day ? "lamps.day" : "lamps.mode",
                               "the lamp '%s' would be on for %.1f %% of %s; the board "
                               "allows %.1f %%",
                               info->name, f->lamp_duty_permille[i] / 10.0,
                               span(info->duty_window_ns, a, sizeof a),
                               info->max_duty_permille / 10.0);
    }
    return 0;
}

static int check_on_box(const struct ttf_plan *plan, const struct ttf_box *box,
                        struct ttf_plan_figures *ret, struct ttf_err *err)
{
    int r;

    for (unsigned i = 0; i < plan->n_shots; i++) {
        r = check_shot_on_box(plan, i, box, err);
        if (r < 0)
            return r;
    }
    ttf_plan_figures_fill(plan, box, ret);
    if (ret->slot_busy_ns > plan->interval_ns) {
        ttf_err_set(err, -EINVAL, "interval",
                    "a slot takes %.3f s from its first lamp command to its last exposure's end, "
                    "which is more than the interval",
                    (double)ret->slot_busy_ns / 1e9);
        ttf_err_hint(err, "shorten lamps.settle or take an interval of %.1f s or more",
                     (double)ret->slot_busy_ns / 1e9 + 0.05);
        return -EINVAL;
    }
    return check_lamps_on_box(plan, box, ret, err);
}

int ttf_plan_check(const struct ttf_plan *plan, const struct ttf_box *box,
                   struct ttf_plan_figures *ret, struct ttf_err *err)
{
    struct ttf_plan_figures figures;
    int r = check_times(plan, err);

    if (r < 0)
        return r;
    if (plan->n_shots < 1 || plan->n_shots > TTF_PLAN_SHOTS_MAX)
        return ttf_err_set(err, -EINVAL, "shots", "a slot has 1 to %d shots", TTF_PLAN_SHOTS_MAX);
    for (unsigned i = 0; i < plan->n_shots; i++) {
        r = check_shot(plan, i, err);
        if (r < 0)
            return r;
    }
    r = check_lamps(plan, err);
    if (r == 0)
        r = check_rest(plan, err);
    if (r < 0)
        return r;
    if (box) {
        r = check_on_box(plan, box, &figures, err);
        if (r < 0)
            return r;
    } else {
        ttf_plan_figures_fill(plan, NULL, &figures);
    }
    if (ret)
        *ret = figures;
    return 0;
}
