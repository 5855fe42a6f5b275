/* SPDX-License-Identifier: Apache-2.0 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "clock.h"
#include "fake_v4l2.h"
#include "libcamera_fixture.h"

int rig_setup(void **state)
{
    struct rig *rig = calloc(1, sizeof(*rig));

    if (!rig)
        return -1;
    rig->clock = fake_clock_create(sim_clock_virtual_create(TTF_NS_PER_S, "boot", NULL, NULL),
                                   &rig->fake.monotonic_lag_ns);
    if (!rig->clock)
        abort();
    fake_libcamera_init(&rig->fake, rig->clock);
    *state = rig;
    return 0;
}

int rig_teardown(void **state)
{
    struct rig *rig = *state;
    bool clean;

    ttf_camera_destroy(rig->camera);
    clean = rig->fake.begun == rig->fake.ended && rig->fake.held == rig->fake.let_go;
    fake_libcamera_free(&rig->fake);
    ttf_clock_destroy(rig->clock);
    free(rig);
    return clean ? 0 : -1;
}

int rig_configure(struct rig *rig)
{
    static const struct ttf_camera_mode native = {0};
    struct lc_system system = fake_libcamera_system(&rig->fake);
    int r = 0;

    if (!rig->camera)
        r = lc_camera_create_on(&system, &rig->config, rig->clock, &rig->camera, &rig->err);
    return r < 0 ? r : ttf_camera_configure(rig->camera, &native, &rig->format, &rig->err);
}

void rig_start(struct rig *rig)
{
    int r = rig_configure(rig);

    if (r < 0)
        print_message("%s\n", rig->err.what);
    assert_int_equal(r, 0);
    assert_int_equal(ttf_camera_start(rig->camera, &rig->err), 0);
}

struct ttf_exposure of_us(int64_t us, uint32_t gain_milli)
{
    return (struct ttf_exposure){.exposure_ns = us * TTF_NS_PER_US, .gain_milli = gain_milli};
}

int rig_submit(struct rig *rig, const struct ttf_exposure *settings, unsigned n, int64_t middle_ns)
{
    struct ttf_camera_set set = {.settings = settings, .n = n, .middle_ns = middle_ns};

    return ttf_camera_submit(rig->camera, &set, &rig->err);
}

int rig_next(struct rig *rig, struct ttf_frame **ret)
{
    return ttf_camera_next(rig->camera, ttf_clock_now_ns(rig->clock) + 3 * TTF_NS_PER_S, ret,
                           &rig->err);
}

struct ttf_frame rig_shoot(struct rig *rig, const struct ttf_exposure *asked, int64_t middle_ns)
{
    struct ttf_frame *frame = NULL, seen;
    int r;

    assert_int_equal(rig_submit(rig, asked, 1, middle_ns), 0);
    r = ttf_camera_next(rig->camera, ttf_clock_now_ns(rig->clock) + TTF_NS_PER_MIN, &frame,
                        &rig->err);
    if (r < 0 || !frame) {
        print_message("%s\n", rig->err.what);
        fail();
        abort();
    }
    seen = *frame;
    ttf_camera_release(rig->camera, frame);
    return seen;
}

void assert_says(const struct rig *rig, const char *words)
{
    char text[900];

    ttf_err_text(&rig->err, text, sizeof(text));
    if (!strstr(text, words))
        print_message("said: %s\n", text);
    assert_non_null(strstr(text, words));
}
