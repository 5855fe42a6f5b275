/* SPDX-License-Identifier: Apache-2.0 */
/* v4l2_fixture.h: a camera on a made-up device, on virtual time. Include after cmocka.h. */
#ifndef TTF_TESTS_HAL_V4L2_FIXTURE_H
#define TTF_TESTS_HAL_V4L2_FIXTURE_H

#include "fake_v4l2.h"
#include "ttf/base/time.h"
#include "ttf/hal/camera.h"

#define MS TTF_NS_PER_MS

struct bench {
    struct fake_v4l2 fake;
    struct ttf_clock *clock;
    struct ttf_v4l2_config config;
    struct ttf_camera *camera;
    struct ttf_err err;
    struct ttf_frame_format format;
    int64_t lag_ns; /* of the monotonic clock */
};

/* For cmocka: *state is a struct bench with a device and no camera yet. The end checks that nothing is left open or mapped. */
int bench_setup(void **state);
int bench_teardown(void **state);

#define ON_BENCH(f) cmocka_unit_test_setup_teardown(f, bench_setup, bench_teardown)

/* Makes and configures the camera; what the first to fail returned, its reason in bench->err. */
int bench_configure(struct bench *bench);

/* The same, must succeed, and starts it. */
void bench_start(struct bench *bench);

struct ttf_exposure of_ms(int64_t ms, uint32_t gain_milli);

/* Submits n exposures alike. */
int bench_submit(struct bench *bench, int64_t ms, unsigned n, int64_t middle_ns);

/* Waits 2 s at most. */
int bench_next(struct bench *bench, struct ttf_frame **ret);

/* One exposure, must come; released. */
struct ttf_frame bench_shoot(struct bench *bench, int64_t ms, uint32_t gain_milli);

/* Passes one exposure, so that settings have settled and the stream runs; the sequence of the next frame. */
uint64_t bench_warm(struct bench *bench, int64_t ms);

/* The reason given holds this. */
void assert_says(const struct bench *bench, const char *words);

#endif
