/* SPDX-License-Identifier: Apache-2.0 */
#include "cmocka_includes.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "manifest_of_plan.h"
#include "ttf/base/time.h"
#include "ttf/hal/sim.h"

static struct ttf_box box;
static const struct ttf_calibration with_flat = {.has_flat = true};

static int make_box(void **state)
{
    struct ttf_camera_mode native = {0};
    struct ttf_frame_format format;
    struct ttf_sim_config config;
    struct ttf_scene scene;

    (void)state;
    ttf_sim_config_defaults(&config);
    config.width = 64;
    config.height = 48;
    if (ttf_scene_procedural("chart", 1, TTF_NS_PER_DAY, &scene, NULL) < 0 ||
        ttf_sim_box_create(&config, &scene, &box, NULL) < 0)
        return -1;
    return ttf_camera_configure(box.cameras[0].camera, &native, &format, NULL);
}

static int drop_box(void **state)
{
    (void)state;
    ttf_box_destroy(&box);
    return 0;
}

/* Two lamp states of one camera in two streams. */
static void two_shots(struct ttf_plan *plan)
{
    ttf_plan_defaults(plan);
    strcpy(plan->title, "grass");
    plan->n_shots = 2;
    plan->shots[1] = plan->shots[0];
    strcpy(plan->shots[1].stream, "side-lit");
    strcpy(plan->shots[1].channel, "side");
    plan->shots[1].n_levels = 2;
    strcpy(plan->shots[1].levels[0].lamp, "left");
    plan->shots[1].levels[0].permille = 505;
    strcpy(plan->shots[1].levels[1].lamp, "right");
}

static void a_camera_of_two_shots_is_one_camera_with_two_channels_and_streams(void **state)
{
    struct ttf_manifest m;
    struct ttf_plan plan;

    (void)state;
    two_shots(&plan);
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, &with_flat, &m, NULL), 0);
    assert_string_equal(m.title, "SIMULATED grass");
    assert_int_equal(m.n_cameras, 1);
    assert_int_equal(m.n_channels, 2);
    assert_string_equal(m.channels[0].title, "no lamps");
    assert_string_equal(m.channels[1].title, "left 50.5 %, right 0 %");
    assert_int_equal(m.n_streams, 2);
    assert_true(m.streams[0].primary && !m.streams[1].primary);
    assert_string_equal(m.streams[1].quantity, "reflectance");
    /* The same lamps again: the same channel. */
    memcpy(plan.shots[1].channel, plan.shots[0].channel, sizeof(plan.shots[0].channel));
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, NULL, &m, NULL), 0);
    assert_int_equal(m.n_channels, 1);
    assert_string_equal(m.streams[1].quantity, "radiance");
}

static void
a_measured_scale_is_that_of_its_own_camera_and_mode_unless_the_plan_has_one(void **state)
{
    struct ttf_calibration measured = {
        .width = 64, .height = 48, .has_geometry = true, .geometry = {.mm_per_px = 0.125}};
    struct ttf_manifest m;
    struct ttf_plan plan;

    (void)state;
    two_shots(&plan);
    memcpy(measured.camera, plan.shots[0].camera, sizeof(measured.camera));
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, &measured, &m, NULL), 0);
    assert_true(m.streams[0].mm_per_px == 0.125 && m.streams[1].mm_per_px == 0.125);
    assert_string_equal(m.streams[0].quantity, "radiance");
    measured.width = 128; /* another mode of the camera */
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, &measured, &m, NULL), 0);
    assert_true(m.streams[0].mm_per_px == 0);
    measured.width = 64;
    memcpy(measured.camera, "other", 6);
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, &measured, &m, NULL), 0);
    assert_true(m.streams[0].mm_per_px == 0);
    memcpy(measured.camera, plan.shots[0].camera, sizeof(measured.camera));
    plan.mm_per_px = 0.5;
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, &measured, &m, NULL), 0);
    assert_true(m.streams[0].mm_per_px == 0.5);
}

static void without_the_calibration_of_its_camera_a_stream_claims_no_reflectance(void **state)
{
    struct ttf_calibration flat = with_flat;
    struct ttf_manifest m;
    struct ttf_plan plan;

    (void)state;
    two_shots(&plan);
    box.cameras[1] = box.cameras[0];
    strcpy(box.cameras[1].name, "second");
    box.n_cameras = 2;
    strcpy(plan.shots[1].camera, "second");
    strcpy(flat.camera, "second");
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, &flat, &m, NULL), 0);
    assert_string_equal(m.streams[0].quantity, "radiance");
    assert_string_equal(m.streams[0].colour_space, "camera");
    assert_string_equal(m.streams[1].quantity, "reflectance");
    flat.camera[0] = '\0'; /* of whichever */
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, &flat, &m, NULL), 0);
    assert_string_equal(m.streams[0].quantity, "reflectance");
    box.n_cameras = 1;
    plan.n_shots = 1; /* of one camera, whatever it was called then */
    strcpy(flat.camera, "second");
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, &flat, &m, NULL), 0);
    assert_string_equal(m.streams[0].quantity, "reflectance");
}

static void a_real_box_invents_nothing(void **state)
{
    struct ttf_manifest m;
    struct ttf_plan plan;

    (void)state;
    two_shots(&plan);
    box.simulated = false;
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, &with_flat, &m, NULL), 0);
    box.simulated = true;
    assert_string_equal(m.title, "grass");
    assert_false(m.simulated);
}

static void refused(const struct ttf_manifest *m, const struct ttf_manifest *wanted,
                    const char *what)
{
    struct ttf_err err = {0};

    assert_int_equal(ttf_manifest_takes_plan(m, wanted, &err), -EINVAL);
    assert_non_null(strstr(err.what, what));
}

static void a_dataset_takes_only_images_of_its_own_kind(void **state)
{
    struct ttf_manifest m;
    struct ttf_manifest wanted;
    struct ttf_plan plan;

    (void)state;
    two_shots(&plan);
    assert_int_equal(ttf_manifest_of_plan(&plan, &box, &with_flat, &m, NULL), 0);
    wanted = m;
    assert_int_equal(ttf_manifest_takes_plan(&m, &wanted, NULL), 0);
    wanted.n_streams = 1; /* fewer are no harm */
    assert_int_equal(ttf_manifest_takes_plan(&m, &wanted, NULL), 0);
    wanted = m;
    wanted.simulated = false;
    refused(&m, &wanted, "simulated");
    wanted = m;
    wanted.streams[1].width--;
    refused(&m, &wanted, "63 x 48");
    wanted = m;
    wanted.streams[1].height--;
    refused(&m, &wanted, "64 x 47");
    wanted = m;
    strcpy(wanted.streams[1].camera, "other");
    refused(&m, &wanted, "camera 'other'");
    wanted = m;
    strcpy(wanted.streams[1].quantity, "radiance");
    refused(&m, &wanted, "quantity radiance");
    wanted = m;
    strcpy(wanted.streams[1].id, "third");
    refused(&m, &wanted, "'third'");
    m.rehearsal = true;
    refused(&m, &m, "rehearsal");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_camera_of_two_shots_is_one_camera_with_two_channels_and_streams),
        cmocka_unit_test(
            a_measured_scale_is_that_of_its_own_camera_and_mode_unless_the_plan_has_one),
        cmocka_unit_test(without_the_calibration_of_its_camera_a_stream_claims_no_reflectance),
        cmocka_unit_test(a_real_box_invents_nothing),
        cmocka_unit_test(a_dataset_takes_only_images_of_its_own_kind),
    };

    return cmocka_run_group_tests(tests, make_box, drop_box);
}
