/* SPDX-License-Identifier: Apache-2.0 */
/* A camera's driver that answers with errors, rounds, or wanders: what becomes of the run, and of guided calibration. */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "sim_run.h"
#include "ttf/capture/guided_calibration.h"
#include "ttf/hal/camera_backend.h"
#include "ttf/hal/lamps_backend.h"

static const struct ttf_camera_ops *good;
static struct ttf_camera_ops bad;
static struct sim_run *of_run;
static int64_t committed;
static unsigned times;       /* the bad ones so far */
static int error;            /* what it answers */
static unsigned error_times; /* so often; then it is well */
static int64_t grain_ns;     /* exposures are whole multiples of this */

static struct ttf_camera *camera_of(struct ttf_box *box)
{
    return box->cameras[0].camera;
}

static void put_camera(struct ttf_box *box)
{
    struct ttf_camera *camera = camera_of(box);

    good = camera->ops;
    bad.name = good->name;
    bad.configure = bad.configure ? bad.configure : good->configure;
    bad.start = bad.start ? bad.start : good->start;
    bad.stop = good->stop;
    bad.submit = bad.submit ? bad.submit : good->submit;
    bad.next = bad.next ? bad.next : good->next;
    bad.release = good->release;
    bad.cancel = good->cancel;
    bad.recover = bad.recover ? bad.recover : good->recover;
    bad.destroy = good->destroy;
    camera->ops = &bad;
    times = 0;
}

static void swap_camera(struct sim_run *run)
{
    of_run = run;
    put_camera(run->box);
}

static void watch(struct sim_run *run, const struct ttf_progress *progress)
{
    (void)run;
    if (progress->kind == TTF_PROGRESS_SLOT)
        committed = progress->index + 1;
}

static void with_camera(struct sim_run *run, struct ttf_camera_ops ops)
{
    sim_run_init(run);
    run->on_box = swap_camera;
    run->on_progress = watch;
    bad = ops;
    committed = -1; /* arming */
    error = -EIO;
    error_times = 1;
    grain_ns = 0;
}

static bool strikes(void)
{
    return committed == 2 && times < error_times && ++times;
}

/* ---- errors ---- */

static int bad_submit(struct ttf_camera *camera, const struct ttf_camera_set *set,
                      struct ttf_err *err)
{
    return strikes() ? ttf_err_set(err, error, "main", "its driver says no")
                     : good->submit(camera, set, err);
}

static int bad_next(struct ttf_camera *camera, int64_t deadline_ns, struct ttf_frame **ret,
                    struct ttf_err *err)
{
    return strikes() ? error : good->next(camera, deadline_ns, ret, err);
}

static int no_start(struct ttf_camera *camera, struct ttf_err *err)
{
    (void)camera;
    return ttf_err_set(err, -ENODEV, "main", "it is not plugged in");
}

static int no_configure(struct ttf_camera *camera, const struct ttf_camera_mode *mode,
                        struct ttf_err *err)
{
    (void)camera;
    (void)mode;
    return ttf_err_set(err, -ENODEV, "main", "it is not plugged in");
}

static void an_error_of_the_driver_is_climbed_over(void **state)
{
    static const int errors[] = {-EIO, -EPIPE, -ENODEV, -EBUSY};

    (void)state;
    for (unsigned i = 0; i < 2 * sizeof(errors) / sizeof(errors[0]); i++) {
        struct sim_run run;

        with_camera(&run, i % 2 ? (struct ttf_camera_ops){.submit = bad_submit}
                                : (struct ttf_camera_ops){.next = bad_next});
        error = errors[i / 2];
        assert_int_equal(sim_run_boot(&run), 0);
        assert_int_equal(times, 1);
        sim_run_expect(&run, "cccccc");
        /* One that is gone is not asked again as it is: it is recovered first. */
        assert_int_equal(sim_run_events(&run, "camera", "delivers nothing: requeue"),
                         error == -EBUSY ? 0 : 1);
        assert_int_equal(sim_run_events(&run, "retry", "taken again"), error == -EBUSY ? 1 : 0);
        sim_run_expect_whole(&run, true);
        sim_run_finish(&run);
    }
}

/* For as long as slot 2 lasts nothing helps. */
static void a_driver_that_refuses_every_set_costs_its_slots(void **state)
{
    struct sim_run run;

    (void)state;
    with_camera(&run, (struct ttf_camera_ops){.submit = bad_submit});
    error_times = 1000;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_true(times > 3); /* the ladder */
    sim_run_expect(&run, "ccfccc");
    sim_run_expect_reason(&run, 2, "camera does not deliver");
    assert_true(sim_run_events(&run, "camera", "delivers nothing") >= 1);
    sim_run_finish(&run);
}

static void a_camera_that_cannot_be_had_refuses_the_run(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        struct sim_run run;

        with_camera(&run, i ? (struct ttf_camera_ops){.start = no_start}
                            : (struct ttf_camera_ops){.configure = no_configure});
        assert_int_equal(sim_run_boot(&run), -ENODEV);
        assert_string_equal(run.err.what, "it is not plugged in");
        sim_run_finish(&run);
    }
}

/* ---- settings ---- */

static int64_t wander_ns;
static unsigned arming; /* frames taken before the first slot's record */

/* It says what it made of the exposure asked for. */
static int rounds(struct ttf_camera *camera, int64_t deadline_ns, struct ttf_frame **ret,
                  struct ttf_err *err)
{
    int r = good->next(camera, deadline_ns, ret, err);
    struct ttf_exposure *e = r == 0 ? &(*ret)->settings : NULL;

    arming += committed == -1;
    if (e && grain_ns > 0)
        e->exposure_ns = (e->exposure_ns + grain_ns / 2) / grain_ns * grain_ns;
    if (e && wander_ns != 0)
        e->exposure_ns += wander_ns * (int64_t)++times;
    if (e && camera->caps.gain_max_milli == 0)
        *e = (struct ttf_exposure){.exposure_ns = e->exposure_ns};
    return r;
}

static void an_exposure_granted_far_from_what_was_asked_is_told_and_locked(void **state)
{
    static const int64_t grains_ms[] = {21, 19};

    (void)state;
    for (unsigned i = 0; i < 2; i++) {
        struct sim_run run;
        struct ttf_slot_record record;

        with_camera(&run, (struct ttf_camera_ops){.next = rounds});
        grain_ns = grains_ms[i] * TTF_NS_PER_MS;
        wander_ns = 0;
        assert_int_equal(sim_run_boot(&run), 0);
        sim_run_expect(&run, "cccccc");
        assert_int_equal(sim_run_events(&run, "camera", "granted and locked"), 1);
        sim_run_record(&run, 4, &record);
        assert_int_equal(record.images[0].shots[0].granted.exposure_ns, grain_ns);
        assert_string_equal(record.images[0].flags, "");
        ttf_slot_record_free(&record);
        sim_run_finish(&run);
    }
}

static void a_camera_that_grants_other_settings_each_time_is_not_armed(void **state)
{
    static const int64_t wander[] = {1000, 2 * TTF_NS_PER_MS, -2 * TTF_NS_PER_MS};

    (void)state;
    for (unsigned i = 0; i < 3; i++) {
        struct sim_run run;

        with_camera(&run, (struct ttf_camera_ops){.next = rounds});
        wander_ns = wander[i];
        assert_int_equal(sim_run_boot(&run), -EIO);
        assert_non_null(strstr(run.err.what, "other settings than it was asked for"));
        wander_ns = 0;
        sim_run_finish(&run);
    }
}

static void without_controls(struct sim_run *run)
{
    struct ttf_camera_caps *caps;

    swap_camera(run);
    caps = &camera_of(run->box)->caps;
    caps->gain_min_milli = caps->gain_max_milli = 0;
    caps->has_white_balance = caps->has_lens = false;
}

static int configure_without_controls(struct ttf_camera *camera, const struct ttf_camera_mode *mode,
                                      struct ttf_err *err)
{
    int r = good->configure(camera, mode, err);

    camera->caps.gain_min_milli = camera->caps.gain_max_milli = 0;
    camera->caps.has_white_balance = camera->caps.has_lens = false;
    return r;
}

/* What it lacks is read back as 0, whatever was asked of it: that is as asked. */
static void controls_that_the_camera_lacks_are_no_difference(void **state)
{
    struct sim_run run;

    (void)state;
    with_camera(&run,
                (struct ttf_camera_ops){.next = rounds, .configure = configure_without_controls});
    run.on_box = without_controls;
    wander_ns = 0;
    grain_ns = 20 * TTF_NS_PER_MS;
    arming = 0;
    assert_int_equal(sim_run_boot(&run), 0);
    assert_in_range(arming, 1, 3); /* one to lock, and slot 0's */
    sim_run_expect(&run, "cccccc");
    sim_run_expect_whole(&run, true);
    sim_run_finish(&run);
}

static int configure_with_a_lens(struct ttf_camera *camera, const struct ttf_camera_mode *mode,
                                 struct ttf_err *err)
{
    int r = good->configure(camera, mode, err);

    camera->caps.lens_held = true;
    camera->caps.lens_code = 120;
    return r;
}

static void where_a_lens_stands_that_no_plan_moves_is_recorded_at_each_beginning(void **state)
{
    struct sim_run run;

    (void)state;
    with_camera(&run, (struct ttf_camera_ops){.configure = configure_with_a_lens});
    sim_run_fault(&run, TTF_FAULT_POWER_CUT, 2 * TTF_NS_PER_MIN + 30 * TTF_NS_PER_S);
    assert_int_equal(sim_run_through_cuts(&run), 0);
    assert_int_equal(
        sim_run_events(&run, "camera", "the lens is held at 120, the driver's own number"), 2);
    sim_run_finish(&run);
    /* A camera without such a lens says nothing of it. */
    sim_run_init(&run);
    assert_int_equal(sim_run_boot(&run), 0);
    assert_int_equal(sim_run_events(&run, "camera", "lens"), 0);
    sim_run_finish(&run);
}

/* ---- guided calibration ---- */

struct guided {
    struct ttf_sim_config config;
    struct ttf_plan plan;
    struct ttf_box box;
    struct ttf_calibration calibration;
    struct ttf_guided_config guided;
    struct ttf_err err;
};

static void guide_with(struct guided *g, const struct ttf_fault *fault)
{
    struct ttf_scene white;

    memset(g, 0, sizeof(*g));
    ttf_sim_config_defaults(&g->config);
    g->config.width = 48;
    g->config.height = 32;
    if (fault)
        g->config.faults[g->config.n_faults++] = *fault;
    ttf_plan_defaults(&g->plan);
    g->plan.shots[0].n_levels = 1;
    strcpy(g->plan.shots[0].levels[0].lamp, "left");
    g->plan.shots[0].levels[0].permille = 500;
    assert_int_equal(ttf_scene_procedural("white", 1, TTF_NS_PER_DAY, &white, NULL), 0);
    assert_int_equal(ttf_sim_box_create(&g->config, &white, &g->box, NULL), 0);
    ttf_calibration_init(&g->calibration);
    g->guided = (struct ttf_guided_config){
        .box = &g->box, .shot = &g->plan.shots[0], .mains_hz = 50, .frames = 4, .reflectance = 0.9};
    bad = (struct ttf_camera_ops){.name = NULL};
    committed = 2; /* strikes() at once */
    error = -EIO;
    error_times = 100000;
    wander_ns = grain_ns = 0;
}

static void guide(struct guided *g)
{
    guide_with(g, NULL);
}

static void end(struct guided *g)
{
    ttf_calibration_free(&g->calibration);
    ttf_box_destroy(&g->box);
}

static void refused(struct guided *g, int code, const char *what)
{
    assert_int_equal(ttf_guided_dark(&g->guided, &g->calibration, &g->err), code);
    if (!strstr(g->err.what, what))
        print_error("'%s', not '%s'\n", g->err.what, what);
    assert_non_null(strstr(g->err.what, what));
    assert_int_equal(g->calibration.dark_frames, 0);
    end(g);
}

static void a_calibration_of_no_frame_or_too_many_is_refused(void **state)
{
    struct guided g;

    (void)state;
    guide(&g);
    g.guided.frames = 0;
    refused(&g, -EINVAL, "1 to 1000 frames");
    guide(&g);
    g.guided.frames = 1001;
    refused(&g, -EINVAL, "1 to 1000 frames");
    guide(&g);
    g.plan.shots[0].exposure.exposure_ns = 0;
    refused(&g, -EINVAL, "more than 0");
}

static void a_calibration_names_the_camera_that_it_lacks(void **state)
{
    struct guided g;

    (void)state;
    guide(&g);
    strcpy(g.plan.shots[0].camera, "side");
    refused(&g, -EINVAL, "no camera 'side'");
    guide(&g);
    bad.configure = no_configure;
    put_camera(&g.box);
    refused(&g, -ENODEV, "not plugged in");
    guide(&g);
    bad.start = no_start;
    put_camera(&g.box);
    refused(&g, -ENODEV, "not plugged in");
}

static void a_calibration_names_the_lamp_that_it_lacks(void **state)
{
    struct guided g;

    (void)state;
    guide(&g);
    strcpy(g.plan.shots[0].levels[0].lamp, "candle");
    assert_true(ttf_guided_flat(&g.guided, &g.calibration, &g.err) < 0);
    assert_non_null(strstr(g.err.what, "candle"));
    end(&g);
}

static void a_camera_that_gives_nothing_is_not_calibrated(void **state)
{
    struct guided g;

    (void)state;
    guide(&g);
    bad.submit = bad_submit;
    put_camera(&g.box);
    refused(&g, -ENODEV, "no frame, also after it was opened anew: its driver says no");
}

/* Locked, then every frame is another one's. */
static unsigned frames_until_it_drifts;

static int drifts(struct ttf_camera *camera, int64_t deadline_ns, struct ttf_frame **ret,
                  struct ttf_err *err)
{
    int r = good->next(camera, deadline_ns, ret, err);

    if (r == 0 && ++times > frames_until_it_drifts)
        (*ret)->settings.exposure_ns = 7 * TTF_NS_PER_MS;
    return r;
}

static int spoils(struct ttf_camera *camera, int64_t deadline_ns, struct ttf_frame **ret,
                  struct ttf_err *err)
{
    int r = good->next(camera, deadline_ns, ret, err);

    if (r == 0 && ++times > frames_until_it_drifts)
        (*ret)->flags |= TTF_FRAME_ERROR;
    return r;
}

static void a_camera_that_does_not_keep_its_exposure_is_not_calibrated(void **state)
{
    struct guided g;

    (void)state;
    frames_until_it_drifts = 1000;
    guide(&g);
    bad.next = drifts;
    put_camera(&g.box);
    assert_int_equal(ttf_guided_dark(&g.guided, &g.calibration, &g.err), 0);
    end(&g);
    frames_until_it_drifts = times - 4; /* those that lock it */
    guide(&g);
    bad.next = drifts;
    put_camera(&g.box);
    refused(&g, -EIO, "does not keep its exposure");
    guide(&g);
    bad.next = spoils;
    put_camera(&g.box);
    refused(&g, -EIO, "no good frame: corrupt");
}

/* Under lamps; each part of a calibration takes its frames alike. */
static void refused_lit(struct guided *g, int code, const char *what)
{
    assert_int_equal(ttf_guided_flat(&g->guided, &g->calibration, &g->err), code);
    if (!strstr(g->err.what, what))
        print_error("'%s', not '%s'\n", g->err.what, what);
    assert_non_null(strstr(g->err.what, what));
    assert_false(g->calibration.has_flat);
    end(g);
}

static void a_calibration_with_an_open_door_is_refused_and_a_look_inside_is_not(void **state)
{
    const struct ttf_fault open = {.kind = TTF_FAULT_DOOR_OPEN, .duration_ns = TTF_NS_PER_H};
    struct ttf_raw_sum sum = {0};
    struct guided g;

    (void)state;
    guide_with(&g, &open);
    refused(&g, -EIO, "the door was open");
    guide_with(&g, &open);
    refused_lit(&g, -EIO, "the door was open");
    guide_with(&g, &open);
    assert_int_equal(ttf_guided_frames(&g.guided, true, &sum, &g.err), 0);
    assert_int_equal(sum.n, 4);
    ttf_raw_sum_free(&sum);
    end(&g);
}

static int not_lit(struct ttf_lamps *lamps, unsigned lamp, unsigned permille, struct ttf_err *err)
{
    (void)lamps;
    (void)lamp;
    (void)permille;
    (void)err;
    return -EIO;
}

static void a_calibration_by_lamps_that_are_off_is_refused(void **state)
{
    struct ttf_lamps_ops refusing;
    struct guided g;

    (void)state;
    guide(&g);
    refusing = *g.box.lamps->ops;
    refusing.set = not_lit;
    g.box.lamps->ops = &refusing;
    refused_lit(&g, -EIO, "a lamp was off");
}

static void a_calibration_by_a_lamp_that_a_door_put_out_before_is_refused(void **state)
{
    /* of the five minutes that it takes to warm up */
    const struct ttf_fault open = {
        .kind = TTF_FAULT_DOOR_OPEN, .at_ns = 3 * TTF_NS_PER_MIN, .duration_ns = TTF_NS_PER_S};
    struct guided g;

    (void)state;
    guide_with(&g, &open);
    refused_lit(&g, -EIO, "had not settled");
}

static int nobody_knows(struct ttf_lamps *lamps, unsigned lamp, struct ttf_lamp_state *ret)
{
    (void)lamps;
    (void)lamp;
    (void)ret;
    return -EIO;
}

static void a_calibration_by_lamps_that_nobody_knows_of_is_refused(void **state)
{
    struct ttf_lamps_ops mute;
    struct guided g;

    (void)state;
    guide(&g);
    mute = *g.box.lamps->ops;
    mute.state = nobody_knows;
    g.box.lamps->ops = &mute;
    refused_lit(&g, -EIO, "nobody says what a lamp did");
}

static void a_calibration_is_of_one_camera(void **state)
{
    struct ttf_chart_view view = {0};
    struct ttf_chart chart;
    struct guided g;

    (void)state;
    guide(&g);
    ttf_chart_classic(&chart);
    strcpy(g.calibration.camera, "side");
    assert_int_equal(ttf_guided_flat(&g.guided, &g.calibration, &g.err), -EINVAL);
    assert_int_equal(ttf_guided_chart(&g.guided, &view, &chart, &g.calibration, &g.err), -EINVAL);
    assert_non_null(strstr(g.err.what, "is of camera 'side'"));
    assert_int_equal(ttf_guided_geometry(&g.guided, 5, &g.calibration, &g.err), -EINVAL);
    assert_non_null(strstr(g.err.what, "is of camera 'side'"));
    assert_int_equal(ttf_guided_flicker(&g.guided, &g.calibration, &g.err), -EINVAL);
    assert_non_null(strstr(g.err.what, "is of camera 'side'"));
    refused(&g, -EINVAL, "is of camera 'side'");
}

static int no_temperature(struct ttf_sensors *sensors, struct ttf_reading ret[TTF_SENSORS_MAX],
                          struct ttf_err *err)
{
    (void)sensors;
    (void)err;
    memset(ret, 0, 2 * sizeof(ret[0]));
    ret[0].kind = TTF_SENSOR_TEMP_MDEGC; /* not ok */
    ret[1].kind = TTF_SENSOR_TEMP_MDEGC + 1;
    ret[1].ok = true;
    return 2;
}

static void dark_frames_without_a_thermometer_say_no_temperature(void **state)
{
    struct ttf_sensors_ops cold;
    struct ttf_calibration untouched;
    struct guided g;

    (void)state;
    ttf_calibration_init(&untouched);
    guide(&g);
    cold = *g.box.sensors->ops;
    cold.read = no_temperature;
    g.box.sensors->ops = &cold;
    assert_int_equal(ttf_guided_dark(&g.guided, &g.calibration, &g.err), 0);
    assert_int_equal(g.calibration.dark_temp_mdegc, untouched.dark_temp_mdegc);
    end(&g);
    ttf_calibration_free(&untouched);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(an_error_of_the_driver_is_climbed_over),
        cmocka_unit_test(a_driver_that_refuses_every_set_costs_its_slots),
        cmocka_unit_test(a_camera_that_cannot_be_had_refuses_the_run),
        cmocka_unit_test(an_exposure_granted_far_from_what_was_asked_is_told_and_locked),
        cmocka_unit_test(a_camera_that_grants_other_settings_each_time_is_not_armed),
        cmocka_unit_test(controls_that_the_camera_lacks_are_no_difference),
        cmocka_unit_test(where_a_lens_stands_that_no_plan_moves_is_recorded_at_each_beginning),
        cmocka_unit_test(a_calibration_of_no_frame_or_too_many_is_refused),
        cmocka_unit_test(a_calibration_names_the_camera_that_it_lacks),
        cmocka_unit_test(a_calibration_names_the_lamp_that_it_lacks),
        cmocka_unit_test(a_camera_that_gives_nothing_is_not_calibrated),
        cmocka_unit_test(a_camera_that_does_not_keep_its_exposure_is_not_calibrated),
        cmocka_unit_test(a_calibration_with_an_open_door_is_refused_and_a_look_inside_is_not),
        cmocka_unit_test(a_calibration_by_lamps_that_are_off_is_refused),
        cmocka_unit_test(a_calibration_by_a_lamp_that_a_door_put_out_before_is_refused),
        cmocka_unit_test(a_calibration_by_lamps_that_nobody_knows_of_is_refused),
        cmocka_unit_test(a_calibration_is_of_one_camera),
        cmocka_unit_test(dark_frames_without_a_thermometer_say_no_temperature),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
