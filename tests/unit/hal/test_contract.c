/* SPDX-License-Identifier: Apache-2.0 */
/* What the wrappers do for every back-end, seen on a camera that can do only what it must. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <string.h>

#include "ttf/hal/box.h"
#include "ttf/hal/camera_backend.h"
#include "ttf/hal/clock_backend.h"
#include "ttf/hal/lamps_backend.h"

struct plain_camera {
    struct ttf_camera base;
    struct ttf_frame frame;
    int starts, stops, cancels, releases, destroyed;
    int next_result;
    uint32_t next_index;
};

static struct plain_camera *of(struct ttf_camera *camera)
{
    return (struct plain_camera *)camera;
}

static int plain_configure(struct ttf_camera *camera, const struct ttf_camera_mode *mode,
                           struct ttf_err *err)
{
    camera->format.width = mode->width ? mode->width : 32;
    return mode->width == 13 ? ttf_err_set(err, -EINVAL, "plain", "13 is unlucky") : 0;
}

static int plain_start(struct ttf_camera *camera, struct ttf_err *err)
{
    (void)err;
    of(camera)->starts++;
    return 0;
}

static void plain_stop(struct ttf_camera *camera)
{
    of(camera)->stops++;
}

static int plain_submit(struct ttf_camera *camera, const struct ttf_camera_set *set,
                        struct ttf_err *err)
{
    (void)camera;
    (void)set;
    (void)err;
    return 0;
}

static int plain_next(struct ttf_camera *camera, int64_t deadline_ns, struct ttf_frame **ret_frame,
                      struct ttf_err *err)
{
    (void)deadline_ns;
    (void)err;
    if (of(camera)->next_result < 0)
        return of(camera)->next_result;
    of(camera)->frame.set_index = of(camera)->next_index++;
    *ret_frame = &of(camera)->frame;
    return 0;
}

static void plain_release(struct ttf_camera *camera, struct ttf_frame *frame)
{
    (void)frame;
    of(camera)->releases++;
}

static void plain_cancel(struct ttf_camera *camera)
{
    of(camera)->cancels++;
}

static void plain_destroy(struct ttf_camera *camera)
{
    of(camera)->destroyed++;
}

static const struct ttf_camera_ops plain_ops = {.name = "plain",
                                                .configure = plain_configure,
                                                .start = plain_start,
                                                .stop = plain_stop,
                                                .submit = plain_submit,
                                                .next = plain_next,
                                                .release = plain_release,
                                                .cancel = plain_cancel,
                                                .destroy = plain_destroy};

static struct plain_camera streaming(void)
{
    const struct ttf_camera_mode native = {0};
    struct plain_camera c = {.base = {.ops = &plain_ops}};

    assert_int_equal(ttf_camera_configure(&c.base, &native, NULL, NULL), 0);
    assert_int_equal(ttf_camera_start(&c.base, NULL), 0);
    return c;
}

static int submit(struct plain_camera *c, unsigned n)
{
    const struct ttf_exposure e[4] = {
        {.exposure_ns = 1}, {.exposure_ns = 1}, {.exposure_ns = 1}, {.exposure_ns = 1}};
    const struct ttf_camera_set set = {.settings = e, .n = n};

    return ttf_camera_submit(&c->base, &set, NULL);
}

static void requeue_and_restart_are_made_of_the_mandatory_operations(void **state)
{
    struct plain_camera c = streaming();

    (void)state;
    assert_int_equal(submit(&c, 2), 0);
    assert_int_equal(ttf_camera_recover(&c.base, TTF_CAMERA_REQUEUE, NULL), 0);
    assert_int_equal(c.cancels, 1);
    assert_int_equal(submit(&c, 2), 0);
    assert_int_equal(ttf_camera_recover(&c.base, TTF_CAMERA_RESTART, NULL), 0);
    assert_int_equal(c.stops, 1);
    assert_int_equal(c.starts, 2);
    assert_int_equal(submit(&c, 2), 0);
    assert_int_equal(ttf_camera_recover(&c.base, TTF_CAMERA_REOPEN, NULL), -ENOTSUP);
}

static void lost_buffers_shorten_the_set(void **state)
{
    struct plain_camera c = streaming();
    struct ttf_frame *frame;

    (void)state;
    assert_int_equal(submit(&c, 4), 0);
    c.next_index = 2; /* 0 and 1 were lost */
    assert_int_equal(ttf_camera_next(&c.base, 1, &frame, NULL), 0);
    assert_int_equal(submit(&c, 1), -EBUSY);
    assert_int_equal(ttf_camera_next(&c.base, 1, &frame, NULL), 0);
    assert_int_equal(ttf_camera_next(&c.base, 1, &frame, NULL), -ENODATA);
    assert_int_equal(submit(&c, 1), 0);
}

static void a_timeout_keeps_the_set_and_its_end_or_the_cameras_does_not(void **state)
{
    struct plain_camera c = streaming();
    struct ttf_frame *frame = NULL;

    (void)state;
    assert_int_equal(submit(&c, 1), 0);
    c.next_result = -ETIMEDOUT;
    assert_int_equal(ttf_camera_next(&c.base, 1, &frame, NULL), -ETIMEDOUT);
    assert_int_equal(submit(&c, 1), -EBUSY);
    c.next_result = -ENODATA;
    assert_int_equal(ttf_camera_next(&c.base, 1, &frame, NULL), -ENODATA);
    assert_int_equal(submit(&c, 1), 0);
    c.next_result = -ENODEV;
    assert_int_equal(ttf_camera_next(&c.base, 1, &frame, NULL), -ENODEV);
    assert_int_equal(submit(&c, 1), 0);
    assert_null(frame);
}

static void a_refused_mode_leaves_the_output_alone(void **state)
{
    const struct ttf_camera_mode odd = {.width = 13}, packed = {.packing = TTF_PACKING_COUNT};
    struct plain_camera c = {.base = {.ops = &plain_ops}};
    struct ttf_frame_format f = {.width = 7};
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(ttf_camera_configure(&c.base, &odd, &f, &err), -EINVAL);
    assert_int_equal(f.width, 7);
    assert_string_equal(err.what, "13 is unlucky");
    assert_null(ttf_camera_format(&c.base));
    assert_int_equal(ttf_camera_configure(&c.base, &packed, &f, &err), -EINVAL);
}

static void destroying_stops_what_streams(void **state)
{
    struct plain_camera c = streaming();

    (void)state;
    ttf_camera_release(&c.base, NULL);
    assert_int_equal(c.releases, 0);
    ttf_camera_destroy(&c.base);
    assert_int_equal(c.stops, 1);
    assert_int_equal(c.destroyed, 1);
}

static void nothing_at_all_may_be_destroyed(void **state)
{
    struct ttf_box box = {.serial = "x"};

    (void)state;
    ttf_camera_destroy(NULL);
    ttf_lamps_destroy(NULL);
    ttf_sensors_destroy(NULL);
    ttf_panel_destroy(NULL);
    ttf_watchdog_destroy(NULL);
    ttf_clock_destroy(NULL);
    ttf_gate_destroy(NULL);
    ttf_box_destroy(NULL);
    ttf_box_destroy(&box);
    assert_int_equal(box.serial[0], '\0');
}

static void a_panel_without_light_and_switch_says_so(void **state)
{
    const struct ttf_panel_ops ops = {.name = "bare"};
    struct ttf_panel panel = {.ops = &ops};

    (void)state;
    assert_int_equal(ttf_panel_led(&panel, TTF_LED_IDLE), -ENOTSUP);
    assert_int_equal(ttf_panel_door(&panel), -ENOTSUP);
    assert_int_equal(ttf_panel_held(&panel), -ENOTSUP);
}

static int64_t shown_ns;

static void sure_utc(struct ttf_clock *clock, struct ttf_utc *ret)
{
    (void)clock;
    *ret = (struct ttf_utc){
        .boot_ns = 5, .utc_ns = shown_ns, .uncertainty_ns = 7, .trust = TTF_TRUST_NTP};
}

static void a_clock_that_was_never_set_is_vouched_for_by_nobody(void **state)
{
    const struct ttf_clock_ops ops = {.name = "sure", .utc = sure_utc};
    struct ttf_clock clock = {.ops = &ops};
    struct ttf_utc utc;

    (void)state;
    shown_ns = TTF_UTC_EARLIEST_NS;
    ttf_clock_utc(&clock, &utc);
    assert_int_equal(utc.trust, TTF_TRUST_NTP);
    assert_int_equal(utc.uncertainty_ns, 7);
    shown_ns = TTF_UTC_EARLIEST_NS - 1;
    ttf_clock_utc(&clock, &utc);
    assert_int_equal(utc.trust, TTF_TRUST_NONE);
    assert_int_equal(utc.uncertainty_ns, TTF_NS_UNKNOWN);
    assert_int_equal(utc.utc_ns, shown_ns);
}

static void levels_are_rounded_to_the_nearest_a_lamp_can_do(void **state)
{
    const struct ttf_lamp_info steps3 = {.kind = TTF_LAMP_STEPS, .steps = 3};
    const struct ttf_lamp_info onoff = {.kind = TTF_LAMP_SWITCH};
    const struct ttf_lamp_info pwm = {.kind = TTF_LAMP_PWM};

    (void)state;
    assert_int_equal(ttf_lamp_round(&steps3, 0), 0);
    assert_int_equal(ttf_lamp_round(&steps3, 166), 0);
    assert_int_equal(ttf_lamp_round(&steps3, 167), 333);
    assert_int_equal(ttf_lamp_round(&steps3, 600), 667);
    assert_int_equal(ttf_lamp_round(&steps3, 1000), 1000);
    assert_int_equal(ttf_lamp_round(&onoff, 499), 0);
    assert_int_equal(ttf_lamp_round(&onoff, 500), 1000);
    assert_int_equal(ttf_lamp_round(&pwm, 1), 1);
    assert_int_equal(ttf_lamp_round(&pwm, 5000), 1000);
    for (unsigned level = 0; level <= 1000; level++)
        assert_int_equal(ttf_lamp_round(&steps3, ttf_lamp_round(&steps3, level)),
                         ttf_lamp_round(&steps3, level));
}

static void names_are_the_ones_that_datasets_store(void **state)
{
    (void)state;
    assert_string_equal(ttf_trust_name(TTF_TRUST_HOST), "host");
    assert_string_equal(ttf_lamp_trip_name(TTF_TRIP_TEMP_MISSING), "temperature-missing");
    assert_string_equal(ttf_sensor_kind_name(TTF_SENSOR_HUMIDITY_MPCT), "humidity_mpct");
    assert_string_equal(ttf_camera_recovery_name(TTF_CAMERA_REOPEN), "reopen");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(requeue_and_restart_are_made_of_the_mandatory_operations),
        cmocka_unit_test(lost_buffers_shorten_the_set),
        cmocka_unit_test(a_timeout_keeps_the_set_and_its_end_or_the_cameras_does_not),
        cmocka_unit_test(a_refused_mode_leaves_the_output_alone),
        cmocka_unit_test(destroying_stops_what_streams),
        cmocka_unit_test(nothing_at_all_may_be_destroyed),
        cmocka_unit_test(a_panel_without_light_and_switch_says_so),
        cmocka_unit_test(a_clock_that_was_never_set_is_vouched_for_by_nobody),
        cmocka_unit_test(levels_are_rounded_to_the_nearest_a_lamp_can_do),
        cmocka_unit_test(names_are_the_ones_that_datasets_store),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
