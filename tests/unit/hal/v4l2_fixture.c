/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "v4l2_fixture.h"

int bench_setup(void **state)
{
    struct bench *bench = calloc(1, sizeof(*bench));

    if (!bench)
        return -1;
    bench->clock = fake_clock_create(sim_clock_virtual_create(TTF_NS_PER_S, "boot", NULL, NULL),
                                     &bench->lag_ns);
    if (!bench->clock)
        abort();
    fake_v4l2_init(&bench->fake, bench->clock);
    bench->config.gain_unity = 64;
    *state = bench;
    return 0;
}

int bench_teardown(void **state)
{
    struct bench *bench = *state;
    bool clean;

    ttf_camera_destroy(bench->camera);
    clean = bench->fake.opened == bench->fake.closed && bench->fake.mapped == bench->fake.unmapped;
    fake_v4l2_free(&bench->fake);
    ttf_clock_destroy(bench->clock);
    free(bench);
    return clean ? 0 : -1;
}

int bench_configure(struct bench *bench)
{
    static const struct ttf_camera_mode native = {0};
    int r = 0;

    if (!bench->camera)
        r = v4l2_camera_create_on(&fake_v4l2_sys, &bench->fake, &bench->config, bench->clock,
                                  &bench->camera, &bench->err);
    return r < 0 ? r : ttf_camera_configure(bench->camera, &native, &bench->format, &bench->err);
}

void bench_start(struct bench *bench)
{
    assert_int_equal(bench_configure(bench), 0);
    assert_int_equal(ttf_camera_start(bench->camera, &bench->err), 0);
}

struct ttf_exposure of_ms(int64_t ms, uint32_t gain_milli)
{
    return (struct ttf_exposure){.exposure_ns = ms * MS, .gain_milli = gain_milli};
}

int bench_submit(struct bench *bench, int64_t ms, unsigned n, int64_t middle_ns)
{
    struct ttf_exposure settings[TTF_CAMERA_SET_MAX];
    struct ttf_camera_set set = {.settings = settings, .n = n, .middle_ns = middle_ns};

    for (unsigned i = 0; i < n && i < TTF_CAMERA_SET_MAX; i++)
        settings[i] = of_ms(ms, 1000);
    return ttf_camera_submit(bench->camera, &set, &bench->err);
}

int bench_next(struct bench *bench, struct ttf_frame **ret)
{
    return ttf_camera_next(bench->camera, ttf_clock_now_ns(bench->clock) + 2 * TTF_NS_PER_S, ret,
                           &bench->err);
}

struct ttf_frame bench_shoot(struct bench *bench, int64_t ms, uint32_t gain_milli)
{
    struct ttf_exposure asked = of_ms(ms, gain_milli);
    struct ttf_camera_set set = {.settings = &asked, .n = 1};
    struct ttf_frame *frame = NULL, seen;

    assert_int_equal(ttf_camera_submit(bench->camera, &set, &bench->err), 0);
    assert_int_equal(bench_next(bench, &frame), 0);
    if (!frame)
        abort();
    seen = *frame;
    ttf_camera_release(bench->camera, frame);
    return seen;
}

uint64_t bench_warm(struct bench *bench, int64_t ms)
{
    (void)bench_shoot(bench, ms, 1000);
    return fake_next_sequence(&bench->fake);
}

void assert_says(const struct bench *bench, const char *words)
{
    char text[900];

    ttf_err_text(&bench->err, text, sizeof(text));
    if (!strstr(text, words))
        print_message("said: %s\n", text);
    assert_non_null(strstr(text, words));
}
