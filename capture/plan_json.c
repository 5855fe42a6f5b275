/* SPDX-License-Identifier: Apache-2.0 */
/* The resolved plan as JSON: every field, units in the names. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "plan_names.h"
#include "ttf/capture/plan.h"
#include "ttf/dataset/json_writer.h"

const char *const ttf_lamp_mode_names[4] = {"none", "continuous", "capture-only", "photoperiod"};
const char *const ttf_keep_names[4] = {"default", "raw", "developed", "both"};

const char *const ttf_plan_end_names[3] = {"count", "until", "length"};

static void write_end(struct ttf_json *j, const struct ttf_plan *plan)
{
    ttf_json_kint(j, "count", plan->count);
    if (plan->end == TTF_END_UNTOLD)
        return;
    ttf_json_kstring(j, "end", ttf_plan_end_names[plan->end]);
    if (plan->end == TTF_END_UNTIL)
        ttf_json_kint(j, "until_utc_ns", plan->until_utc_ns);
    if (plan->end == TTF_END_LENGTH)
        ttf_json_kint(j, "length_ns", plan->length_ns);
}

static void write_levels(struct ttf_json *j, const struct ttf_lamp_level *levels, unsigned n)
{
    ttf_json_object(j);
    for (unsigned i = 0; i < n; i++)
        ttf_json_kint(j, levels[i].lamp, levels[i].permille);
    ttf_json_object_end(j);
}

static void write_lamps(struct ttf_json *j, const struct ttf_plan *plan)
{
    ttf_json_key(j, "lamps");
    ttf_json_object(j);
    ttf_json_kstring(j, "mode", ttf_lamp_mode_names[plan->lamps]);
    ttf_json_kint(j, "settle_ns", plan->settle_ns);
    if (plan->lamps == TTF_LAMPS_PHOTOPERIOD) {
        ttf_json_kint(j, "day_ns", plan->day_ns);
        ttf_json_kint(j, "period_ns", plan->period_ns);
        ttf_json_kint(j, "phase_ns", plan->phase_ns);
        ttf_json_kbool(j, "local", plan->photoperiod_local);
        if (plan->photoperiod_local)
            ttf_json_kint(j, "day_start_s", plan->day_start_s);
        ttf_json_key(j, "day_levels_permille");
        write_levels(j, plan->day_levels, plan->n_day_levels);
    }
    ttf_json_object_end(j);
}

static void write_shot(struct ttf_json *j, const struct ttf_plan_shot *shot)
{
    ttf_json_object(j);
    ttf_json_kstring(j, "stream", shot->stream);
    ttf_json_kstring(j, "camera", shot->camera);
    ttf_json_kstring(j, "channel", shot->channel);
    ttf_json_key(j, "lamps_permille");
    write_levels(j, shot->levels, shot->n_levels);
    ttf_json_kint(j, "exposure_ns", shot->exposure.exposure_ns);
    ttf_json_kint(j, "gain_milli", shot->exposure.gain_milli);
    ttf_json_kint(j, "wb_r_milli", shot->exposure.wb_r_milli);
    ttf_json_kint(j, "wb_b_milli", shot->exposure.wb_b_milli);
    ttf_json_kint(j, "lens_mdpt", shot->exposure.lens_mdpt);
    if (shot->n_brackets > 1) {
        ttf_json_key(j, "brackets");
        ttf_json_array(j);
        for (unsigned i = 0; i < shot->n_brackets; i++)
            ttf_json_double(j, shot->brackets[i]);
        ttf_json_array_end(j);
    }
    ttf_json_kint(j, "average", shot->average);
    ttf_json_object_end(j);
}

static void write_region(struct ttf_json *j, const char *key, const struct ttf_region *region)
{
    if (region->width == 0)
        return;
    ttf_json_key(j, key);
    ttf_json_object(j);
    ttf_json_kint(j, "x", region->x);
    ttf_json_kint(j, "y", region->y);
    ttf_json_kint(j, "width", region->width);
    ttf_json_kint(j, "height", region->height);
    ttf_json_object_end(j);
}

int ttf_plan_json(const struct ttf_plan *plan, char **ret_text, struct ttf_err *err)
{
    struct ttf_json j;
    const char *text;
    char *copy = NULL;
    size_t bytes;
    int r;

    ttf_json_init(&j, true);
    ttf_json_object(&j);
    ttf_json_kstring(&j, "title", plan->title);
    ttf_json_kint(&j, "interval_ns", plan->interval_ns);
    write_end(&j, plan);
    if (plan->start_utc_ns != 0)
        ttf_json_kint(&j, "start_utc_ns", plan->start_utc_ns);
    ttf_json_kstring(&j, "zone", plan->zone);
    ttf_json_kint(&j, "zone_offset_s", plan->zone_offset_s);
    write_lamps(&j, plan);
    ttf_json_key(&j, "shots");
    ttf_json_array(&j);
    for (unsigned i = 0; i < plan->n_shots; i++)
        write_shot(&j, &plan->shots[i]);
    ttf_json_array_end(&j);
    ttf_json_kdouble(&j, "mains_hz", plan->mains_hz);
    write_region(&j, "region", &plan->region);
    write_region(&j, "reference", &plan->reference);
    ttf_json_kstring(&j, "keep", ttf_keep_names[plan->keep]);
    if (plan->mm_per_px > 0)
        ttf_json_kdouble(&j, "mm_per_px", plan->mm_per_px);
    ttf_json_kint(&j, "reserve_bytes", plan->reserve_bytes);
    if (plan->second_storage[0]) {
        ttf_json_key(&j, "storage");
        ttf_json_object(&j);
        ttf_json_kstring(&j, "second", plan->second_storage);
        ttf_json_object_end(&j);
    }
    if (plan->group[0])
        ttf_json_kstring(&j, "group", plan->group);
    ttf_json_object_end(&j);
    r = ttf_json_finish(&j, &text, &bytes);
    if (r == 0) {
        copy = strdup(text);
        r = copy ? 0 : -ENOMEM;
    }
    ttf_json_free(&j);
    if (r < 0)
        return ttf_err_set(err, r, NULL, "the plan could not be written as JSON");
    *ret_text = copy;
    return 0;
}
