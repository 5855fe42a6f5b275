/* SPDX-License-Identifier: Apache-2.0 */
/* A resolved plan read back (plan_json.c writes it), and whether two plans are the same. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "plan_names.h"
#include "ttf/base/time.h"
#include "ttf/capture/plan.h"
#include "ttf/dataset/json_parse.h"

/* The first field that is not as it must be sticks. */
struct reading {
    const char *wrong; /* NULL: none yet */
};

static int64_t get_int(struct reading *in, const json_t *o, const char *key, int64_t min,
                       int64_t max)
{
    const json_t *v = json_object_get(o, key);
    int64_t value = json_is_integer(v) ? (int64_t)json_integer_value(v) : 0;

    if (!json_is_integer(v) || value < min || value > max) {
        in->wrong = in->wrong ? in->wrong : key;
        return 0;
    }
    return value;
}

/* 0 where it is absent. */
static int64_t maybe_int(struct reading *in, const json_t *o, const char *key)
{
    return json_object_get(o, key) ? get_int(in, o, key, INT64_MIN, INT64_MAX) : 0;
}

static double get_double(struct reading *in, const json_t *v, const char *key)
{
    if (!json_is_number(v)) {
        in->wrong = in->wrong ? in->wrong : key;
        return 0;
    }
    return json_number_value(v);
}

static void get_text(struct reading *in, const json_t *o, const char *key, char *ret, size_t size)
{
    const char *text = json_string_value(json_object_get(o, key));

    if (!text || strlen(text) >= size) {
        in->wrong = in->wrong ? in->wrong : key;
        return;
    }
    memcpy(ret, text, strlen(text) + 1);
}

static int get_name(struct reading *in, const json_t *o, const char *key, const char *const *names,
                    unsigned n)
{
    const char *text = json_string_value(json_object_get(o, key));

    for (unsigned i = 0; text && i < n; i++)
        if (strcmp(text, names[i]) == 0)
            return (int)i;
    in->wrong = in->wrong ? in->wrong : key;
    return 0;
}

static void get_end(struct reading *in, const json_t *root, struct ttf_plan *plan)
{
    plan->count = get_int(in, root, "count", 1, INT64_MAX);
    plan->end = TTF_END_UNTOLD;
    if (json_object_get(root, "end"))
        plan->end = (enum ttf_plan_end)get_name(in, root, "end", ttf_plan_end_names, 3);
    if (plan->end == TTF_END_UNTIL)
        plan->until_utc_ns = get_int(in, root, "until_utc_ns", 1, INT64_MAX);
    if (plan->end == TTF_END_LENGTH)
        plan->length_ns = get_int(in, root, "length_ns", 1, INT64_MAX);
}

static unsigned get_levels(struct reading *in, const json_t *o, const char *key,
                           struct ttf_lamp_level ret[TTF_LAMPS_MAX])
{
    json_t *map = json_object_get(o, key);
    const char *lamp;
    json_t *level;
    unsigned n = 0;

    if (!json_is_object(map))
        in->wrong = in->wrong ? in->wrong : key;
    json_object_foreach(map, lamp, level)
    {
        if (n >= TTF_LAMPS_MAX || strlen(lamp) >= sizeof(ret[n].lamp) || !json_is_integer(level)) {
            in->wrong = in->wrong ? in->wrong : key;
            break;
        }
        memcpy(ret[n].lamp, lamp, strlen(lamp) + 1);
        ret[n++].permille = (unsigned)json_integer_value(level);
    }
    return n;
}

static void get_lamps(struct reading *in, const json_t *root, struct ttf_plan *plan)
{
    const json_t *o = json_object_get(root, "lamps");

    plan->lamps = (enum ttf_lamp_mode)get_name(in, o, "mode", ttf_lamp_mode_names, 4);
    plan->settle_ns = get_int(in, o, "settle_ns", INT64_MIN, INT64_MAX);
    if (plan->lamps != TTF_LAMPS_PHOTOPERIOD)
        return;
    plan->day_ns = get_int(in, o, "day_ns", INT64_MIN, INT64_MAX);
    plan->period_ns = get_int(in, o, "period_ns", INT64_MIN, INT64_MAX);
    plan->phase_ns = get_int(in, o, "phase_ns", INT64_MIN, INT64_MAX);
    plan->photoperiod_local = json_is_true(json_object_get(o, "local"));
    if (plan->photoperiod_local)
        plan->day_start_s = (int)get_int(in, o, "day_start_s", 0, 24L * 3600);
    plan->n_day_levels = get_levels(in, o, "day_levels_permille", plan->day_levels);
}

static void get_shot(struct reading *in, const json_t *o, struct ttf_plan_shot *shot)
{
    const json_t *brackets = json_object_get(o, "brackets");
    struct ttf_exposure *e = &shot->exposure;

    get_text(in, o, "stream", shot->stream, sizeof(shot->stream));
    get_text(in, o, "camera", shot->camera, sizeof(shot->camera));
    get_text(in, o, "channel", shot->channel, sizeof(shot->channel));
    shot->n_levels = get_levels(in, o, "lamps_permille", shot->levels);
    e->exposure_ns = get_int(in, o, "exposure_ns", 0, INT64_MAX);
    e->gain_milli = (uint32_t)get_int(in, o, "gain_milli", 0, UINT32_MAX);
    e->wb_r_milli = (uint32_t)get_int(in, o, "wb_r_milli", 0, UINT32_MAX);
    e->wb_b_milli = (uint32_t)get_int(in, o, "wb_b_milli", 0, UINT32_MAX);
    e->lens_mdpt = (int32_t)get_int(in, o, "lens_mdpt", INT32_MIN, INT32_MAX);
    if (json_array_size(brackets) > TTF_PLAN_BRACKETS_MAX)
        in->wrong = in->wrong ? in->wrong : "brackets";
    for (size_t i = 0; i < json_array_size(brackets) && i < TTF_PLAN_BRACKETS_MAX; i++)
        shot->brackets[shot->n_brackets++] =
            get_double(in, json_array_get(brackets, i), "brackets");
    shot->average = (unsigned)get_int(in, o, "average", 1, TTF_PLAN_AVERAGE_MAX);
}

static void get_shots(struct reading *in, const json_t *root, struct ttf_plan *plan)
{
    const json_t *shots = json_object_get(root, "shots");
    size_t n = json_array_size(shots);

    if (n < 1 || n > TTF_PLAN_SHOTS_MAX) {
        in->wrong = in->wrong ? in->wrong : "shots";
        return;
    }
    plan->n_shots = (unsigned)n;
    memset(plan->shots, 0, sizeof(plan->shots));
    for (size_t i = 0; i < n; i++)
        get_shot(in, json_array_get(shots, i), &plan->shots[i]);
}

static void get_region(struct reading *in, const json_t *root, const char *key,
                       struct ttf_region *ret)
{
    const json_t *o = json_object_get(root, key);

    memset(ret, 0, sizeof(*ret));
    if (!o)
        return;
    ret->x = (uint32_t)get_int(in, o, "x", 0, UINT32_MAX);
    ret->y = (uint32_t)get_int(in, o, "y", 0, UINT32_MAX);
    ret->width = (uint32_t)get_int(in, o, "width", 1, UINT32_MAX);
    ret->height = (uint32_t)get_int(in, o, "height", 1, UINT32_MAX);
}

static void get_storage(struct reading *in, const json_t *root, struct ttf_plan *plan)
{
    const json_t *o = json_object_get(root, "storage");

    plan->second_storage[0] = '\0';
    if (o)
        get_text(in, o, "second", plan->second_storage, sizeof(plan->second_storage));
}

int ttf_plan_read(const char *text, size_t bytes, const char *where, struct ttf_plan *ret,
                  struct ttf_err *err)
{
    json_t *root = NULL;
    struct reading in = {NULL};
    struct ttf_plan plan;
    int r;

    r = ttf_json_parse(text, bytes, &root, NULL);
    if (r == -ENOMEM)
        return ttf_err_set(err, r, where, "no memory for the plan");
    if (!json_is_object(root)) {
        json_decref(root);
        return ttf_err_set(err, -EINVAL, where, "is no plan as JSON");
    }
    ttf_plan_defaults(&plan);
    get_text(&in, root, "title", plan.title, sizeof(plan.title));
    plan.interval_ns = get_int(&in, root, "interval_ns", 1, INT64_MAX);
    get_end(&in, root, &plan);
    plan.start_utc_ns = maybe_int(&in, root, "start_utc_ns");
    get_text(&in, root, "zone", plan.zone, sizeof(plan.zone));
    plan.zone_offset_s = (int)get_int(&in, root, "zone_offset_s", -86400, 86400);
    get_lamps(&in, root, &plan);
    get_shots(&in, root, &plan);
    plan.mains_hz = get_double(&in, json_object_get(root, "mains_hz"), "mains_hz");
    get_region(&in, root, "region", &plan.region);
    get_region(&in, root, "reference", &plan.reference);
    plan.keep = (enum ttf_keep)get_name(&in, root, "keep", ttf_keep_names, 4);
    plan.mm_per_px = json_object_get(root, "mm_per_px")
                         ? get_double(&in, json_object_get(root, "mm_per_px"), "mm_per_px")
                         : 0;
    plan.reserve_bytes = get_int(&in, root, "reserve_bytes", 0, INT64_MAX);
    get_storage(&in, root, &plan);
    if (json_object_get(root, "group"))
        get_text(&in, root, "group", plan.group, sizeof(plan.group));
    json_decref(root);
    if (in.wrong)
        return ttf_err_set(err, -EINVAL, where, "field '%s' of the plan is not as it must be",
                           in.wrong);
    *ret = plan;
    return 0;
}

static void forget_end(struct ttf_plan *plan)
{
    plan->end = TTF_END_UNTOLD;
    plan->until_utc_ns = plan->length_ns = 0;
}

/* What the first run resolves, and may resolve otherwise another time, is no difference between plans. */
static void forget_resolved(struct ttf_plan *plan)
{
    if (plan->end == TTF_END_UNTIL || plan->end == TTF_END_LENGTH)
        plan->count = 0;
    plan->zone_offset_s = 0;
    if (plan->photoperiod_local)
        plan->phase_ns = 0;
}

int ttf_plan_same(const struct ttf_plan *a, const struct ttf_plan *b)
{
    struct ttf_plan x = *a;
    struct ttf_plan y = *b;
    char *of_x = NULL;
    char *of_y = NULL;
    int r;

    if (x.end == TTF_END_UNTOLD || y.end == TTF_END_UNTOLD) {
        forget_end(&x);
        forget_end(&y);
    }
    forget_resolved(&x);
    forget_resolved(&y);
    r = ttf_plan_json(&x, &of_x, NULL);
    if (r == 0)
        r = ttf_plan_json(&y, &of_y, NULL);
    if (r == 0)
        r = strcmp(of_x, of_y) == 0;
    free(of_x);
    free(of_y);
    return r;
}
