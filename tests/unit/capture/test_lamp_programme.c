/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include <errno.h>
#include <string.h>

#include "lamp_programme.h"
#include "ttf/hal/sim.h"

static struct ttf_box box;

static int make_box(void **state)
{
    struct ttf_sim_config config;
    struct ttf_scene scene;

    (void)state;
    ttf_sim_config_defaults(&config);
    config.width = 32;
    config.height = 32;
    if (ttf_scene_procedural("chart", 1, TTF_NS_PER_DAY, &scene, NULL) < 0)
        return -1;
    return ttf_sim_box_create(&config, &scene, &box, NULL);
}

static int drop_box(void **state)
{
    (void)state;
    ttf_box_destroy(&box);
    return 0;
}

/* left at 100 % for the shot; by day, right at 60 %, 16 h of 24 h, 2 h after the start. */
static void growth_plan(struct ttf_plan *plan)
{
    ttf_plan_defaults(plan);
    plan->interval_ns = TTF_NS_PER_MIN;
    plan->count = 10;
    plan->lamps = TTF_LAMPS_PHOTOPERIOD;
    plan->day_ns = 16 * TTF_NS_PER_H;
    plan->period_ns = 24 * TTF_NS_PER_H;
    plan->phase_ns = 2 * TTF_NS_PER_H;
    plan->n_day_levels = 1;
    strcpy(plan->day_levels[0].lamp, "right");
    plan->day_levels[0].permille = 600;
    plan->shots[0].n_levels = 1;
    strcpy(plan->shots[0].levels[0].lamp, "left");
    plan->shots[0].levels[0].permille = 1000;
}

static void a_photoperiod_counts_from_slot_zero(void **state)
{
    struct ttf_plan plan;
    struct ttf_lamp_programme p;
    unsigned levels[TTF_LAMPS_MAX];
    unsigned right;
    int64_t zero = 500 * TTF_NS_PER_S;

    (void)state;
    growth_plan(&plan);
    right = (unsigned)ttf_lamps_find(box.lamps, "right");
    assert_int_equal(ttf_lamp_programme_init(&p, &plan, box.lamps, zero, NULL), 0);
    ttf_lamp_programme_background(&p, zero, levels);
    assert_int_equal(levels[right], 0);
    assert_int_equal(ttf_lamp_programme_next_change(&p, zero), zero + 2 * TTF_NS_PER_H);
    ttf_lamp_programme_background(&p, zero + 2 * TTF_NS_PER_H, levels);
    assert_int_equal(levels[right], 600);
    assert_int_equal(ttf_lamp_programme_next_change(&p, zero + 3 * TTF_NS_PER_H),
                     zero + 18 * TTF_NS_PER_H);
    ttf_lamp_programme_background(&p, zero + 18 * TTF_NS_PER_H, levels);
    assert_int_equal(levels[right], 0);
    /* The same a week later. */
    ttf_lamp_programme_background(&p, zero + (7 * 24 + 17) * TTF_NS_PER_H, levels);
    assert_int_equal(levels[right], 600);
}

static void a_resumed_photoperiod_has_its_zero_before_this_boot(void **state)
{
    struct ttf_plan plan;
    struct ttf_lamp_programme p;
    unsigned levels[TTF_LAMPS_MAX];

    (void)state;
    growth_plan(&plan);
    assert_int_equal(ttf_lamp_programme_init(&p, &plan, box.lamps, -20 * TTF_NS_PER_H, NULL), 0);
    ttf_lamp_programme_background(&p, 0, levels);
    assert_int_equal(levels[ttf_lamps_find(box.lamps, "right")], 0);
    assert_int_equal(ttf_lamp_programme_next_change(&p, 0), 6 * TTF_NS_PER_H);
}

static void local_days_are_resolved_once(void **state)
{
    /* Slot 0 at 05:30 local (UTC+2); the day begins at 07:00. */
    int64_t utc = (INT64_C(19000) * 86400 + 3 * 3600 + 1800) * TTF_NS_PER_S;

    (void)state;
    assert_int_equal(ttf_photoperiod_phase_ns(utc, 7200, 7 * 3600), 90 * TTF_NS_PER_MIN);
    /* At 08:00 local the day began an hour ago: 23 h to the next. */
    assert_int_equal(ttf_photoperiod_phase_ns(utc + 150 * TTF_NS_PER_MIN, 7200, 7 * 3600),
                     23 * TTF_NS_PER_H);
}

static void continuous_lamps_never_change(void **state)
{
    struct ttf_plan plan;
    struct ttf_lamp_programme p;
    unsigned levels[TTF_LAMPS_MAX];

    (void)state;
    growth_plan(&plan);
    plan.lamps = TTF_LAMPS_CONTINUOUS;
    assert_int_equal(ttf_lamp_programme_init(&p, &plan, box.lamps, 0, NULL), 0);
    ttf_lamp_programme_background(&p, 12345, levels);
    assert_int_equal(levels[ttf_lamps_find(box.lamps, "left")], 1000);
    assert_int_equal(ttf_lamp_programme_next_change(&p, 0), TTF_NS_NEVER);
}

static void capture_only_lamps_are_dark_between_slots(void **state)
{
    struct ttf_plan plan;
    struct ttf_lamp_programme p;
    unsigned levels[TTF_LAMPS_MAX];

    (void)state;
    growth_plan(&plan);
    plan.lamps = TTF_LAMPS_CAPTURE_ONLY;
    assert_int_equal(ttf_lamp_programme_init(&p, &plan, box.lamps, 0, NULL), 0);
    ttf_lamp_programme_background(&p, 3 * TTF_NS_PER_H, levels);
    for (unsigned i = 0; i < TTF_LAMPS_MAX; i++)
        assert_int_equal(levels[i], 0);
}

static void a_lamp_the_box_has_not_got_is_named(void **state)
{
    struct ttf_plan plan;
    struct ttf_lamp_programme p;
    struct ttf_err err;

    (void)state;
    growth_plan(&plan);
    strcpy(plan.shots[0].levels[0].lamp, "sun");
    assert_int_equal(ttf_lamp_programme_init(&p, &plan, box.lamps, 0, &err), -ENOENT);
    assert_string_equal(err.where, "shots[0].lamps.sun");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_photoperiod_counts_from_slot_zero),
        cmocka_unit_test(a_resumed_photoperiod_has_its_zero_before_this_boot),
        cmocka_unit_test(local_days_are_resolved_once),
        cmocka_unit_test(continuous_lamps_never_change),
        cmocka_unit_test(capture_only_lamps_are_dark_between_slots),
        cmocka_unit_test(a_lamp_the_box_has_not_got_is_named),
    };

    return cmocka_run_group_tests(tests, make_box, drop_box);
}
