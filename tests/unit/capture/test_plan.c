/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "queue.h"
#include "ttf/base/time.h"
#include "ttf/capture/plan.h"
#include "ttf/hal/camera_backend.h"
#include "ttf/hal/sim.h"

static struct ttf_box box;
static struct ttf_sim_config config;

static int make_box_of(uint32_t width, uint32_t height)
{
    struct ttf_camera_mode native = {0};
    struct ttf_frame_format format;
    struct ttf_scene scene;

    ttf_sim_config_defaults(&config);
    config.width = width;
    config.height = height;
    config.lamps[0].info.max_on_ns = 2 * TTF_NS_PER_H;
    config.lamps[1].info.max_duty_permille = 250;
    config.lamps[1].info.duty_window_ns = TTF_NS_PER_H;
    if (ttf_scene_procedural("chart", 1, TTF_NS_PER_DAY, &scene, NULL) < 0 ||
        ttf_sim_box_create(&config, &scene, &box, NULL) < 0)
        return -1;
    return ttf_camera_configure(box.cameras[0].camera, &native, &format, NULL);
}

static int make_box(void **state)
{
    (void)state;
    return make_box_of(64, 48);
}

static int drop_box(void **state)
{
    (void)state;
    ttf_box_destroy(&box);
    return 0;
}

static void good_plan(struct ttf_plan *plan)
{
    ttf_plan_defaults(plan);
    strcpy(plan->title, "grass");
    plan->interval_ns = 10 * TTF_NS_PER_MIN;
    plan->count = 1008;
}

/* Refused, and the field that is named. */
static void refused(const struct ttf_plan *plan, const struct ttf_box *on, const char *where)
{
    struct ttf_err err = {0};

    assert_int_equal(ttf_plan_check(plan, on, NULL, &err), -EINVAL);
    assert_string_equal(err.where, where);
    assert_true(err.what[0] != '\0');
}

static void a_good_plan_has_figures(void **state)
{
    struct ttf_plan plan;
    struct ttf_plan_figures f;

    (void)state;
    good_plan(&plan);
    assert_int_equal(ttf_plan_check(&plan, &box, &f, NULL), 0);
    assert_int_equal(f.slots, 1008);
    assert_int_equal(f.duration_ns, 1007 * 10 * TTF_NS_PER_MIN);
    assert_int_equal(f.exposure_ns[0], 20 * TTF_NS_PER_MS);
    /* raw and developed of 64 x 48, and some */
    assert_in_range(f.slot_bytes, 64 * 48 * 8, 64 * 48 * 8 + 40000);
    assert_int_equal(f.bytes, f.slot_bytes * 1008);
    assert_true(f.memory_bytes > 0);
    assert_true(f.slot_busy_ns > 20 * TTF_NS_PER_MS);
    assert_in_range(f.ready_ns, 10 * TTF_NS_PER_MS, TTF_NS_PER_S); /* nothing to settle */
}

/* Bytes of all raw sums that a run of such frames makes. */
static int64_t raw_sums_bytes(const struct ttf_frame_format *format)
{
    struct ttf_stock_size size = {.n_images = 1, .n_shots = 1, .rooms = 1, .slots = 1};
    struct ttf_clock *clock = ttf_clock_real_create();
    struct ttf_queue queue;
    int64_t bytes = 0;

    assert_non_null(clock);
    assert_int_equal(ttf_queue_init(&queue, clock, &size), 0);
    assert_int_equal(ttf_queue_reserve_raw(&queue, format), 0);
    for (unsigned i = 0; i < queue.n_raw; i++)
        bytes += (int64_t)(queue.raw[i].room * sizeof(*queue.raw[i].sum));
    ttf_queue_finish(&queue);
    ttf_clock_destroy(clock);
    return bytes;
}

/* Beside larger frames: what differs is raw sums, and a camera's buffers, dark and flat, which are less. */
static void memory_counts_every_raw_sum_that_a_run_makes(void **state)
{
    static const uint32_t sizes[][2] = {{640, 480}, {1280, 960}, {1920, 1080}};
    struct ttf_frame_format least = *ttf_camera_format(box.cameras[0].camera);
    struct ttf_plan plan;
    struct ttf_plan_figures few, many;

    good_plan(&plan);
    assert_int_equal(ttf_plan_check(&plan, &box, &few, NULL), 0);
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++) {
        const struct ttf_frame_format *format;
        int64_t sums;

        drop_box(state);
        assert_int_equal(make_box_of(sizes[i][0], sizes[i][1]), 0);
        format = ttf_camera_format(box.cameras[0].camera);
        sums = raw_sums_bytes(format) - raw_sums_bytes(&least);
        assert_int_equal(ttf_plan_check(&plan, &box, &many, NULL), 0);
        assert_in_range(many.memory_bytes - few.memory_bytes, sums,
                        sums + (int64_t)format->width * format->height * 32);
    }
    drop_box(state);
    assert_int_equal(make_box(state), 0);
}

/* Lamps that stay on need no settling in each slot: paint every 5 s under warm lamps. */
static void lamps_that_burn_all_the_time_settle_once(void **state)
{
    struct ttf_plan plan;
    struct ttf_plan_figures f;

    (void)state;
    good_plan(&plan);
    plan.lamps = TTF_LAMPS_CONTINUOUS;
    plan.shots[0].n_levels = 1;
    strcpy(plan.shots[0].levels[0].lamp, "left");
    plan.shots[0].levels[0].permille = 1000;
    plan.settle_ns = 5 * TTF_NS_PER_MIN;
    plan.interval_ns = 5 * TTF_NS_PER_S;
    plan.count = 60;
    assert_int_equal(ttf_plan_check(&plan, &box, &f, NULL), 0);
    assert_true(f.slot_busy_ns < TTF_NS_PER_S);
    /* Begun now, the first slot waits for them, and so is the end later. */
    assert_in_range(f.ready_ns, plan.settle_ns, plan.settle_ns + TTF_NS_PER_S);
    /* Another shot in another light: now every slot waits. */
    plan.n_shots = 2;
    plan.shots[1] = plan.shots[0];
    plan.shots[1].stream[0] = 'x';
    plan.shots[1].levels[0].permille /= 2;
    refused(&plan, &box, "interval");
    plan.shots[1].levels[0].permille = plan.shots[0].levels[0].permille;
    assert_int_equal(ttf_plan_check(&plan, &box, &f, NULL), 0);
    plan.lamps = TTF_LAMPS_CAPTURE_ONLY;
    refused(&plan, &box, "interval");
}

static void times_beyond_sense_are_refused(void **state)
{
    struct ttf_plan plan;

    (void)state;
    good_plan(&plan);
    plan.interval_ns = 0;
    refused(&plan, NULL, "interval");
    plan.interval_ns = -5;
    refused(&plan, NULL, "interval");
    plan.interval_ns = INT64_MAX;
    refused(&plan, NULL, "interval");
    good_plan(&plan);
    plan.count = 0;
    refused(&plan, NULL, "count");
    plan.count = INT64_MAX;
    refused(&plan, NULL, "count");
    plan.count = 900000000;
    refused(&plan, NULL, "count"); /* seventeen thousand years */
}

/* Whatever a plan's file, or a program that fills the struct, may hold: refused by the field's name. */
static void every_field_has_its_bounds(void **state)
{
    struct ttf_plan good, plan;

    (void)state;
    good_plan(&good);
#define REFUSED(where, change)       \
    do {                             \
        plan = good;                 \
        change;                      \
        refused(&plan, NULL, where); \
    } while (0)
    REFUSED("start", plan.start_utc_ns = -1);
    REFUSED("zone", plan.zone_offset_s = 86401);
    REFUSED("zone", plan.zone_offset_s = -86401);
    REFUSED("mains", plan.mains_hz = NAN);
    REFUSED("mains", plan.mains_hz = -50);
    REFUSED("mains", plan.mains_hz = 1001);
    REFUSED("mm_per_px", plan.mm_per_px = -0.1);
    REFUSED("mm_per_px", plan.mm_per_px = INFINITY);
    REFUSED("reserve", plan.reserve_bytes = -1);
    REFUSED("keep", plan.keep = (enum ttf_keep)(TTF_KEEP_BOTH + 1));
    REFUSED("lamps.mode", plan.lamps = (enum ttf_lamp_mode)(TTF_LAMPS_PHOTOPERIOD + 1));
    REFUSED("lamps.settle", plan.settle_ns = -1);
    REFUSED("lamps.settle", plan.settle_ns = TTF_NS_PER_DAY + 1);
    REFUSED("shots", plan.n_shots = TTF_PLAN_SHOTS_MAX + 1);
    REFUSED("shots[0].stream", plan.shots[0].stream[0] = '\0');
    REFUSED("shots[0].stream", strcpy(plan.shots[0].stream, "Main"));
    REFUSED("shots[0].stream", strcpy(plan.shots[0].stream, "a/b"));
    REFUSED("shots[0].channel", strcpy(plan.shots[0].channel, "\xc3\xa4"));
    REFUSED("shots[0].exposure", plan.shots[0].exposure.exposure_ns = 0);
    REFUSED("shots[0].exposure", plan.shots[0].exposure.exposure_ns = TTF_NS_PER_H + 1);
    REFUSED("shots[0].average", plan.shots[0].average = 0);
    REFUSED("shots[0].average", plan.shots[0].average = TTF_PLAN_AVERAGE_MAX + 1);
    REFUSED("shots[0].brackets", plan.shots[0].n_brackets = TTF_PLAN_BRACKETS_MAX + 1);
    REFUSED("shots[0].brackets[1]", (plan.shots[0].n_brackets = 2, plan.shots[0].brackets[0] = 1,
                                     plan.shots[0].brackets[1] = 2000));
    REFUSED("shots[0].brackets[1]", (plan.shots[0].n_brackets = 2, plan.shots[0].brackets[0] = 1,
                                     plan.shots[0].brackets[1] = NAN));
#undef REFUSED
}

static void a_photoperiod_has_its_bounds(void **state)
{
    struct ttf_plan good, plan;

    (void)state;
    good_plan(&good);
    good.lamps = TTF_LAMPS_PHOTOPERIOD;
    good.period_ns = TTF_NS_PER_DAY;
    good.day_ns = 16 * TTF_NS_PER_H;
    good.n_day_levels = 1;
    strcpy(good.day_levels[0].lamp, "grow");
    good.day_levels[0].permille = 1000;
    assert_int_equal(ttf_plan_check(&good, NULL, NULL, NULL), 0);
#define REFUSED(where, change)       \
    do {                             \
        plan = good;                 \
        change;                      \
        refused(&plan, NULL, where); \
    } while (0)
    REFUSED("lamps.period", plan.period_ns = 0);
    REFUSED("lamps.period", plan.period_ns = INT64_MAX);
    REFUSED("lamps.day", plan.day_ns = -1);
    REFUSED("lamps.day", plan.day_ns = TTF_NS_PER_DAY + 1);
    REFUSED("lamps.phase", plan.phase_ns = TTF_NS_PER_DAY + 1);
    REFUSED("lamps.phase", plan.phase_ns = -TTF_NS_PER_DAY - 1);
    REFUSED("lamps.period", (plan.photoperiod_local = true, plan.period_ns = 25 * TTF_NS_PER_H));
    REFUSED("lamps.day_start", (plan.photoperiod_local = true, plan.day_start_s = -1));
    REFUSED("lamps.day_start", (plan.photoperiod_local = true, plan.day_start_s = 86400));
    REFUSED("lamps.day_levels", plan.n_day_levels = TTF_LAMPS_MAX + 1);
    REFUSED("lamps.day_levels.grow", plan.day_levels[0].permille = 1001);
    REFUSED("lamps.day_levels.grow",
            (plan.n_day_levels = 2, plan.day_levels[1] = plan.day_levels[0]));
#undef REFUSED
}

static void shots_beyond_sense_are_refused(void **state)
{
    struct ttf_plan plan;

    (void)state;
    good_plan(&plan);
    plan.n_shots = 0;
    refused(&plan, NULL, "shots");
    good_plan(&plan);
    plan.n_shots = 2;
    plan.shots[1] = plan.shots[0];
    refused(&plan, NULL, "shots[1].stream");
    strcpy(plan.shots[1].stream, "side");
    plan.shots[1].exposure.exposure_ns = 0;
    refused(&plan, NULL, "shots[1].exposure");
    plan.shots[1].exposure.exposure_ns = 1000;
    plan.shots[1].average = 65;
    refused(&plan, NULL, "shots[1].average");
    plan.shots[1].average = 1;
    plan.shots[1].n_brackets = 2;
    plan.shots[1].brackets[0] = 0.5;
    plan.shots[1].brackets[1] = 2;
    refused(&plan, NULL, "shots[1].brackets"); /* no reference */
    plan.shots[1].brackets[0] = NAN;
    refused(&plan, NULL, "shots[1].brackets[0]");
}

static void brackets_that_snap_to_one_exposure_are_refused(void **state)
{
    struct ttf_plan plan;

    (void)state;
    good_plan(&plan);
    plan.shots[0].n_brackets = 2;
    plan.shots[0].brackets[0] = 1;
    plan.shots[0].brackets[1] = 1.1;
    refused(&plan, &box, "shots[0].brackets[1]");
    plan.mains_hz = 0;
    assert_int_equal(ttf_plan_check(&plan, &box, NULL, NULL), 0);
}

static void what_the_box_lacks_is_named(void **state)
{
    struct ttf_plan plan;

    (void)state;
    good_plan(&plan);
    strcpy(plan.shots[0].camera, "side");
    refused(&plan, &box, "shots[0].camera");
    good_plan(&plan);
    plan.lamps = TTF_LAMPS_CAPTURE_ONLY;
    plan.shots[0].n_levels = 1;
    strcpy(plan.shots[0].levels[0].lamp, "sun");
    refused(&plan, &box, "shots[0].lamps.sun");
    good_plan(&plan);
    plan.shots[0].exposure.exposure_ns = 50 * TTF_NS_PER_MIN;
    refused(&plan, &box, "shots[0].exposure");
    good_plan(&plan);
    plan.shots[0].exposure.gain_milli = 1000000;
    refused(&plan, &box, "shots[0].gain");
    good_plan(&plan);
    plan.region = (struct ttf_region){60, 0, 8, 8};
    refused(&plan, &box, "region");
    plan.region = (struct ttf_region){0, 0, 32, 32};
    plan.reference = (struct ttf_region){30, 30, 4, 4};
    refused(&plan, &box, "reference");
}

/* As another camera would say of itself. */
static void what_this_camera_cannot_do_is_refused(void **state)
{
    struct ttf_camera *camera = box.cameras[0].camera;
    const struct ttf_frame_format format = camera->format;
    const struct ttf_camera_caps caps = camera->caps;
    struct ttf_plan_figures f;
    struct ttf_plan plan;

    (void)state;
    good_plan(&plan);
    plan.mains_hz = 0;
    plan.shots[0].exposure.exposure_ns = 1;
    refused(&plan, &box, "shots[0].exposure");
    camera->caps.gain_min_milli = 2000;
    good_plan(&plan);
    refused(&plan, &box, "shots[0].gain");
    camera->caps.gain_min_milli = camera->caps.gain_max_milli = 0; /* it has none to set */
    assert_int_equal(ttf_plan_check(&plan, &box, NULL, NULL), 0);
    camera->caps.exposure_min_ns = camera->caps.exposure_max_ns = 0; /* nor an exposure */
    assert_int_equal(ttf_plan_check(&plan, &box, NULL, NULL), 0);
    plan.shots[0].n_brackets = 2;
    plan.shots[0].brackets[0] = 1;
    plan.shots[0].brackets[1] = 2;
    refused(&plan, &box, "shots[0].brackets");
    plan.shots[0].n_brackets = 0;
    camera->format.cfa = TTF_CFA_NONE;
    assert_int_equal(ttf_plan_check(&plan, &box, &f, NULL), 0);
    assert_true(f.slot_bytes > 0);
    plan.keep = TTF_KEEP_RAW;
    refused(&plan, &box, "keep");
    plan.keep = TTF_KEEP_DEVELOPED;
    assert_int_equal(ttf_plan_check(&plan, &box, NULL, NULL), 0);
    camera->configured = false;
    refused(&plan, &box, "shots[0].camera");
    camera->configured = true;
    camera->format = format;
    camera->caps = caps;
}

static void regions_are_held_to_the_frame_in_both_directions(void **state)
{
    struct ttf_plan plan;

    (void)state;
    good_plan(&plan);
    plan.region = (struct ttf_region){0, 44, 8, 8};
    refused(&plan, &box, "region");
    plan.region = (struct ttf_region){0, 0, 8, 0};
    refused(&plan, &box, "region");
    plan.region = (struct ttf_region){UINT32_MAX, 0, UINT32_MAX, 8};
    refused(&plan, &box, "region");
    plan.region = (struct ttf_region){0, 0, 32, 32};
    plan.reference = (struct ttf_region){0, 30, 4, 4};
    refused(&plan, &box, "reference");
    plan.reference = (struct ttf_region){0, 0, 4, 0};
    refused(&plan, &box, "reference");
    plan.reference = (struct ttf_region){0, 0, 4, 4};
    assert_int_equal(ttf_plan_check(&plan, &box, NULL, NULL), 0);
}

static void names_and_paths_must_be_such_that_folders_can_be_made_of_them(void **state)
{
    static const char *const names[] = {"", "Main", "ma in", "main{", "ma/in", "m\xc3\xa4in", ":"};
    struct ttf_plan plan;

    (void)state;
    for (unsigned i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
        good_plan(&plan);
        snprintf(plan.shots[0].stream, sizeof(plan.shots[0].stream), "%s", names[i]);
        refused(&plan, NULL, "shots[0].stream");
    }
    good_plan(&plan);
    strcpy(plan.shots[0].stream, "0-z9");
    assert_int_equal(ttf_plan_check(&plan, NULL, NULL, NULL), 0);
    strcpy(plan.second_storage, "media/second"); /* below which folder, after a restart? */
    refused(&plan, NULL, "storage.second");
}

static void runs_and_brackets_beyond_all_bounds_are_refused(void **state)
{
    struct ttf_plan plan;

    (void)state;
    good_plan(&plan);
    plan.count = 1000000000;
    plan.interval_ns = 366 * TTF_NS_PER_DAY;
    refused(&plan, NULL, "count");
    good_plan(&plan);
    plan.shots[0].n_brackets = 2;
    plan.shots[0].brackets[0] = 1;
    plan.shots[0].brackets[1] = INFINITY;
    refused(&plan, NULL, "shots[0].brackets[1]");
    plan.shots[0].brackets[1] = 1e9;
    refused(&plan, NULL, "shots[0].brackets[1]");
    plan.shots[0].brackets[1] = 1e-9;
    refused(&plan, NULL, "shots[0].brackets[1]");
}

static void lamps_are_held_to_what_the_board_allows(void **state)
{
    struct ttf_plan plan;
    struct ttf_plan_figures f;

    (void)state;
    good_plan(&plan);
    plan.lamps = TTF_LAMPS_CONTINUOUS;
    plan.shots[0].n_levels = 1;
    strcpy(plan.shots[0].levels[0].lamp, "left");
    plan.shots[0].levels[0].permille = 1000;
    refused(&plan, &box, "lamps.mode"); /* a week, allowed are 2 h */
    plan.lamps = TTF_LAMPS_CAPTURE_ONLY;
    plan.settle_ns = TTF_NS_PER_MIN;
    assert_int_equal(ttf_plan_check(&plan, &box, &f, NULL), 0);
    assert_in_range(f.lamp_duty_permille[0], 100, 120);
    assert_int_equal(f.lamp_switchings[0], 1008);
    /* right may be on a quarter of an hour's time: 4 of 10 minutes is too much. */
    strcpy(plan.shots[0].levels[0].lamp, "right");
    plan.settle_ns = 4 * TTF_NS_PER_MIN;
    refused(&plan, &box, "lamps.mode");
    plan.settle_ns = 2 * TTF_NS_PER_MIN;
    assert_int_equal(ttf_plan_check(&plan, &box, &f, NULL), 0);
    plan.shots[0].levels[0].permille = 1001;
    refused(&plan, &box, "shots[0].lamps.right");
}

static void a_run_that_is_over_before_a_lamp_s_share_is_used_up_fits(void **state)
{
    struct ttf_plan plan;
    struct ttf_plan_figures f;

    (void)state;
    good_plan(&plan);
    plan.lamps = TTF_LAMPS_CONTINUOUS;
    plan.settle_ns = TTF_NS_PER_MIN;
    plan.shots[0].n_levels = 1;
    strcpy(plan.shots[0].levels[0].lamp, "right");
    plan.shots[0].levels[0].permille = 1000;
    plan.count = 2; /* 11 of the 15 minutes that it may be on in an hour */
    assert_int_equal(ttf_plan_check(&plan, &box, &f, NULL), 0);
    assert_in_range(f.lamp_duty_permille[1], 180, 190);
    plan.count = 3;
    refused(&plan, &box, "lamps.mode");
}

static void a_photoperiod_is_held_to_it_as_well(void **state)
{
    struct ttf_plan plan;

    (void)state;
    good_plan(&plan);
    plan.lamps = TTF_LAMPS_PHOTOPERIOD;
    plan.n_day_levels = 1;
    strcpy(plan.day_levels[0].lamp, "left");
    plan.day_levels[0].permille = 300;
    refused(&plan, &box, "lamps.period");
    plan.period_ns = 24 * TTF_NS_PER_H;
    plan.day_ns = 16 * TTF_NS_PER_H;
    refused(&plan, &box, "lamps.day");
    plan.day_ns = 90 * TTF_NS_PER_MIN;
    assert_int_equal(ttf_plan_check(&plan, &box, NULL, NULL), 0);
    plan.photoperiod_local = true;
    plan.day_start_s = 86400;
    refused(&plan, NULL, "lamps.day_start");
}

static void lit_shots_without_a_lamp_mode_are_a_mistake(void **state)
{
    struct ttf_plan plan;

    (void)state;
    good_plan(&plan);
    plan.shots[0].n_levels = 1;
    strcpy(plan.shots[0].levels[0].lamp, "left");
    refused(&plan, NULL, "shots[0].lamps");
}

static void a_slot_must_fit_its_interval(void **state)
{
    struct ttf_plan plan;
    struct ttf_err err;

    (void)state;
    good_plan(&plan);
    plan.lamps = TTF_LAMPS_CAPTURE_ONLY;
    plan.shots[0].n_levels = 1;
    strcpy(plan.shots[0].levels[0].lamp, "left");
    plan.shots[0].levels[0].permille = 1000;
    plan.settle_ns = 5 * TTF_NS_PER_S;
    plan.interval_ns = 5 * TTF_NS_PER_S;
    refused(&plan, &box, "interval");
    assert_int_equal(ttf_plan_check(&plan, &box, NULL, &err), -EINVAL);
    assert_non_null(strstr(err.hint, "interval of 5."));
}

static void the_stored_plan_has_units_in_its_names(void **state)
{
    struct ttf_plan plan;
    char *text;

    (void)state;
    good_plan(&plan);
    assert_int_equal(ttf_plan_json(&plan, &text, NULL), 0);
    assert_non_null(strstr(text, "\"interval_ns\": 600000000000"));
    assert_non_null(strstr(text, "\"exposure_ns\": 20000000"));
    assert_non_null(strstr(text, "\"mode\": \"none\""));
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_good_plan_has_figures),
        cmocka_unit_test(memory_counts_every_raw_sum_that_a_run_makes),
        cmocka_unit_test(lamps_that_burn_all_the_time_settle_once),
        cmocka_unit_test(times_beyond_sense_are_refused),
        cmocka_unit_test(shots_beyond_sense_are_refused),
        cmocka_unit_test(every_field_has_its_bounds),
        cmocka_unit_test(a_photoperiod_has_its_bounds),
        cmocka_unit_test(brackets_that_snap_to_one_exposure_are_refused),
        cmocka_unit_test(what_the_box_lacks_is_named),
        cmocka_unit_test(what_this_camera_cannot_do_is_refused),
        cmocka_unit_test(regions_are_held_to_the_frame_in_both_directions),
        cmocka_unit_test(names_and_paths_must_be_such_that_folders_can_be_made_of_them),
        cmocka_unit_test(runs_and_brackets_beyond_all_bounds_are_refused),
        cmocka_unit_test(lamps_are_held_to_what_the_board_allows),
        cmocka_unit_test(a_run_that_is_over_before_a_lamp_s_share_is_used_up_fits),
        cmocka_unit_test(a_photoperiod_is_held_to_it_as_well),
        cmocka_unit_test(lit_shots_without_a_lamp_mode_are_a_mistake),
        cmocka_unit_test(a_slot_must_fit_its_interval),
        cmocka_unit_test(the_stored_plan_has_units_in_its_names),
    };

    return cmocka_run_group_tests(tests, make_box, drop_box);
}
