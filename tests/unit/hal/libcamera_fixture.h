/* SPDX-License-Identifier: Apache-2.0 */
/* libcamera_fixture.h: a camera behind a made-up libcamera, on virtual time. Include after cmocka.h. */
#ifndef TTF_TESTS_HAL_LIBCAMERA_FIXTURE_H
#define TTF_TESTS_HAL_LIBCAMERA_FIXTURE_H

#include "fake_libcamera.h"
#include "ttf/base/time.h"
#include "ttf/hal/camera.h"

#define MS TTF_NS_PER_MS

struct rig {
    struct fake_libcamera fake;
    struct ttf_clock *clock;
    struct ttf_libcamera_config config;
    struct ttf_camera *camera;
    struct ttf_err err;
    struct ttf_frame_format format;
};

/* For cmocka: *state is a struct rig without a camera yet. The end checks that nothing is left held or begun. */
int rig_setup(void **state);
int rig_teardown(void **state);

#define ON_RIG(f) cmocka_unit_test_setup_teardown(f, rig_setup, rig_teardown)

/* Makes and configures the camera; what the first to fail returned, its reason in rig->err. */
int rig_configure(struct rig *rig);

/* The same, must succeed, and starts it. */
void rig_start(struct rig *rig);

struct ttf_exposure of_us(int64_t us, uint32_t gain_milli);

int rig_submit(struct rig *rig, const struct ttf_exposure *settings, unsigned n, int64_t middle_ns);

/* Waits 3 s at most. */
int rig_next(struct rig *rig, struct ttf_frame **ret);

/* One exposure, must come; released. */
struct ttf_frame rig_shoot(struct rig *rig, const struct ttf_exposure *asked, int64_t middle_ns);

/* The reason given holds this. */
void assert_says(const struct rig *rig, const char *words);

#endif
