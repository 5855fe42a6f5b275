/* SPDX-License-Identifier: Apache-2.0 */
#include "chart_lamps.h"

#include <stdio.h>
#include <string.h>

#include "ttf/base/time.h"
#include "ttf/dataset/json_parse.h"

#define DAY_S       (TTF_NS_PER_DAY / TTF_NS_PER_S)
#define EARLIEST_NS (TTF_NS_UNKNOWN + 1)

/* ---- times of whoever wrote the dataset: what is beyond all times stays at the end of them ---- */

static int64_t plus(int64_t a, int64_t b)
{
    int64_t sum;

    if (__builtin_add_overflow(a, b, &sum))
        return b < 0 ? EARLIEST_NS : INT64_MAX;
    return sum;
}

static int64_t minus(int64_t a, int64_t b)
{
    int64_t difference;

    if (__builtin_sub_overflow(a, b, &difference))
        return b < 0 ? INT64_MAX : EARLIEST_NS;
    return difference;
}

/* ---- the plan ---- */

static int64_t whole(json_t *object, const char *key)
{
    return json_integer_value(json_object_get(object, key));
}

static int64_t within(int64_t value, int64_t least, int64_t most)
{
    return value < least ? least : value > most ? most : value;
}

/* Names of lamps that are given a level. */
static void take_background(struct chart_lamps *lamps, json_t *levels)
{
    const char *name;
    json_t *level;

    json_object_foreach(levels, name, level)
    {
        if (json_integer_value(level) > 0 && lamps->n_background < CHART_LAMPS)
            (void)snprintf(lamps->background[lamps->n_background++], 32, "%s", name);
    }
}

static void take_plan(struct chart_lamps *lamps, json_t *plan)
{
    json_t *programme = json_object_get(plan, "lamps");
    const char *mode = json_string_value(json_object_get(programme, "mode"));

    if (!mode)
        return;
    lamps->settle_ns = within(whole(programme, "settle_ns"), 0, INT64_MAX);
    lamps->mode = CHART_LAMPS_SHOTS;
    if (strcmp(mode, "continuous") == 0) {
        json_t *first = json_array_get(json_object_get(plan, "shots"), 0);

        lamps->mode = CHART_LAMPS_ALWAYS;
        take_background(lamps, json_object_get(first, "lamps_permille"));
    } else if (strcmp(mode, "photoperiod") == 0 && whole(programme, "period_ns") > 0) {
        lamps->mode = CHART_LAMPS_DAYS;
        lamps->period_ns = whole(programme, "period_ns");
        lamps->day_ns = within(whole(programme, "day_ns"), 0, lamps->period_ns);
        lamps->phase_ns = whole(programme, "phase_ns");
        lamps->local = json_is_true(json_object_get(programme, "local"));
        lamps->day_start_s = (int)within(whole(programme, "day_start_s"), 0, DAY_S);
        take_background(lamps, json_object_get(programme, "day_levels_permille"));
    }
}

void chart_lamps_plan(struct chart_lamps *lamps, const char *json, size_t bytes)
{
    json_t *plan = NULL;

    lamps->mode = CHART_LAMPS_UNKNOWN;
    lamps->n_background = 0;
    if (ttf_json_parse(json, bytes, &plan, NULL) == 0)
        take_plan(lamps, plan);
    json_decref(plan);
}

/* ---- the segment ---- */

void chart_lamps_segment(struct chart_lamps *lamps, const struct ttf_segment *segment)
{
    if (!lamps->has_segment || lamps->segment.segment != segment->segment)
        lamps->until_ns = TTF_NS_UNKNOWN;
    lamps->segment = *segment;
    lamps->has_segment = true;
}

/* Of the run, at which the boot clock would have shown 0. */
static int64_t run_of_zero_ns(const struct ttf_segment *s)
{
    int64_t run_ns = s->run_ns;

    if (run_ns == 0 && __builtin_mul_overflow(s->first_index, s->interval_ns, &run_ns))
        run_ns = 0;
    return minus(run_ns, s->origin_ns);
}

/* Where the first day begins, in the run's time: the plan's, or by a local time of day. */
static int64_t phase_ns(const struct chart_lamps *lamps)
{
    const struct ttf_segment *s = &lamps->segment;
    int64_t local_ns;

    if (!lamps->local || s->origin_utc_ns == TTF_NS_UNKNOWN)
        return lamps->phase_ns;
    local_ns = plus(minus(s->origin_utc_ns, plus(run_of_zero_ns(s), s->origin_ns)),
                    s->zone_offset_s * TTF_NS_PER_S); /* of the run's slot 0 */
    return lamps->day_start_s * TTF_NS_PER_S - local_ns % TTF_NS_PER_DAY;
}

/* Light up to t, since some time that lies whole periods back: a difference of two of these is what there was between. */
static int64_t light_before(const struct chart_lamps *lamps, int64_t t_ns)
{
    int64_t periods = t_ns / lamps->period_ns, rest = t_ns % lamps->period_ns;
    int64_t whole_days; /* a day is no longer than its period: never beyond t */

    if (rest < 0) {
        periods--;
        rest += lamps->period_ns;
    }
    if (__builtin_mul_overflow(periods, lamps->day_ns, &whole_days))
        whole_days =
            INT64_MIN; /* but for the period that t lies in, at the very beginning of time */
    return plus(whole_days, rest < lamps->day_ns ? rest : lamps->day_ns);
}

/* How long what burns between slots burned from one time of the boot clock to another. */
static int64_t background_ns(const struct chart_lamps *lamps, int64_t from_ns, int64_t to_ns)
{
    int64_t shift_ns;

    if (lamps->mode == CHART_LAMPS_ALWAYS)
        return minus(to_ns, from_ns);
    if (lamps->mode != CHART_LAMPS_DAYS)
        return 0;
    shift_ns = minus(run_of_zero_ns(&lamps->segment), phase_ns(lamps));
    return minus(light_before(lamps, plus(to_ns, shift_ns)),
                 light_before(lamps, plus(from_ns, shift_ns)));
}

/* ---- a record ---- */

static bool burns_between(const struct chart_lamps *lamps, const char *name)
{
    for (unsigned i = 0; i < lamps->n_background; i++)
        if (strcmp(lamps->background[i], name) == 0)
            return true;
    return false;
}

static struct chart_lit *lit_of(struct chart_lit *lit, unsigned *n, const char *name)
{
    for (unsigned i = 0; i < *n; i++)
        if (strcmp(lit[i].name, name) == 0)
            return &lit[i];
    if (*n == CHART_LAMPS)
        return NULL;
    (void)snprintf(lit[*n].name, sizeof lit[*n].name, "%s", name);
    lit[*n].ns = 0;
    return &lit[(*n)++];
}

struct lamp_work {
    char name[32];
    int64_t first_ns, last_ns; /* of the exposures that it was lit for */
    int64_t exposed_ns;
};

/* Which lamps the slot's own exposures were lit by, the refused ones too: the lamp was lit all the same. */
static unsigned work_of(const struct ttf_slot_record *record, struct lamp_work ret[CHART_LAMPS],
                        int64_t *ret_first_ns, int64_t *ret_last_ns)
{
    unsigned n = 0;

    for (unsigned i = 0; i < record->n_images; i++)
        for (unsigned s = 0; s < record->images[i].n_shots; s++) {
            const struct ttf_shot *shot = &record->images[i].shots[s];

            if (shot->start_ns == TTF_NS_UNKNOWN || shot->end_ns == TTF_NS_UNKNOWN)
                continue;
            if (*ret_first_ns == TTF_NS_UNKNOWN || shot->start_ns < *ret_first_ns)
                *ret_first_ns = shot->start_ns;
            if (*ret_last_ns == TTF_NS_UNKNOWN || shot->end_ns > *ret_last_ns)
                *ret_last_ns = shot->end_ns;
            for (unsigned l = 0; l < shot->n_lamps; l++) {
                const struct ttf_shot_lamp *lamp = &shot->lamps[l];
                unsigned k = 0;

                if (lamp->commanded_permille <= 0)
                    continue;
                while (k < n && strcmp(ret[k].name, lamp->name) != 0)
                    k++;
                if (k == CHART_LAMPS)
                    continue;
                if (k == n) {
                    ret[n] = (struct lamp_work){.first_ns = shot->start_ns};
                    memcpy(ret[n++].name, lamp->name, sizeof ret[k].name);
                }
                ret[k].last_ns = shot->end_ns;
                if (shot->end_ns > shot->start_ns)
                    ret[k].exposed_ns =
                        plus(ret[k].exposed_ns, minus(shot->end_ns, shot->start_ns));
            }
        }
    return n;
}

unsigned chart_lamps_add(struct chart_lamps *lamps, const struct ttf_slot_record *record,
                         struct chart_lit ret[CHART_LAMPS])
{
    struct lamp_work work[CHART_LAMPS];
    int64_t first_ns = TTF_NS_UNKNOWN, last_ns = TTF_NS_UNKNOWN, from_ns, to_ns;
    unsigned n = 0, n_work = work_of(record, work, &first_ns, &last_ns);
    bool mine = lamps->has_segment && record->segment == lamps->segment.segment;

    /* What burns between slots does so from some time before the first exposure of a boot on; what no exposure follows is not known of. */
    from_ns = lamps->until_ns;
    if (from_ns == TTF_NS_UNKNOWN && first_ns != TTF_NS_UNKNOWN)
        from_ns = minus(first_ns, lamps->settle_ns);
    to_ns = last_ns != TTF_NS_UNKNOWN ? last_ns : record->due_ns;
    if (mine && from_ns != TTF_NS_UNKNOWN && to_ns > from_ns) {
        for (unsigned i = 0; i < lamps->n_background; i++) {
            struct chart_lit *lit = lit_of(ret, &n, lamps->background[i]);

            if (lit)
                lit->ns = plus(lit->ns, background_ns(lamps, from_ns, to_ns));
        }
        lamps->until_ns = to_ns;
    }
    for (unsigned i = 0; i < n_work; i++) {
        int64_t begun_ns = minus(work[i].first_ns, lamps->settle_ns), burned_ns;
        struct chart_lit *lit = lit_of(ret, &n, work[i].name);

        if (!lit)
            continue;
        if (!mine || lamps->mode == CHART_LAMPS_UNKNOWN) {
            lit->ns = plus(lit->ns, work[i].exposed_ns);
            continue;
        }
        burned_ns = minus(work[i].last_ns, begun_ns);
        if (burns_between(lamps,
                          work[i].name)) /* what the programme had it burn is counted above */
            burned_ns = minus(burned_ns, background_ns(lamps, begun_ns, work[i].last_ns));
        lit->ns = plus(lit->ns, burned_ns > 0 ? burned_ns : 0);
    }
    return n;
}
