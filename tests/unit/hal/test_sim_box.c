/* SPDX-License-Identifier: Apache-2.0 */
/* The simulated box as a whole: the same bits again, after a resume too; power; lamps and their guardian in the picture. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "sim_fixture.h"

#define CODES (64 * 48)

/* A noisy, rippling, ageing box: everything that could differ is on. */
static struct ttf_sim_config lively(void)
{
    struct ttf_sim_config c, small = sim_small();

    ttf_sim_config_defaults(&c);
    c.width = small.width;
    c.height = small.height;
    c.readout_ns = small.readout_ns;
    c.ambient = 0.05;
    c.daylight = 0.3;
    return c;
}

static void capture(struct ttf_box *box, int64_t middle_ns, uint16_t codes[CODES])
{
    struct ttf_frame *frame = NULL;

    assert_int_equal(sim_shoot(box, 20 * MS, middle_ns, &frame), 0);
    assert_true(llabs((frame->start_ns + frame->end_ns) / 2 - middle_ns) < MS);
    memcpy(codes, frame->data, CODES * sizeof(*codes));
    ttf_camera_release(box->cameras[0].camera, frame);
}

static void two_boxes_of_one_seed_give_the_same_bits_whatever_was_asked_between(void **state)
{
    struct ttf_sim_config c = lively();
    struct ttf_box a = sim_box(&c), b = sim_box(&c);
    uint16_t x[CODES], y[CODES], z[CODES];
    struct ttf_reading r[TTF_SENSORS_MAX];

    (void)state;
    sim_light_up(&a, 1000 * S);
    sim_light_up(&b, 1000 * S);
    capture(&a, 100 * S, x);
    for (int i = 10; i < 100; i += 10) {
        sim_wait(&b, i * S);
        assert_true(ttf_sensors_read(b.sensors, r, NULL) > 0);
        (void)sim_lamp(&b, 0);
        assert_int_equal(ttf_lamps_alive(b.lamps, 1000 * S, NULL), 0);
    }
    capture(&b, 100 * S, y);
    assert_memory_equal(x, y, sizeof(x));
    capture(&a, 110 * S, z);
    assert_memory_not_equal(x, z, sizeof(x));
    ttf_box_destroy(&a);
    ttf_box_destroy(&b);
    c.seed++;
    a = sim_box(&c);
    sim_light_up(&a, 1000 * S);
    capture(&a, 100 * S, z);
    assert_memory_not_equal(x, z, sizeof(x));
    ttf_box_destroy(&a);
}

static void a_resumed_box_gives_the_bits_that_it_would_have_given(void **state)
{
    struct ttf_sim_config c = lively();
    const int64_t resumed_ns = 5000 * S + 12345, at = 40000 * S;
    struct ttf_box whole = sim_box(&c), later;
    uint16_t x[CODES], y[CODES];

    (void)state;
    c.power_on_ns = resumed_ns;
    later = sim_box(&c);
    assert_true(ttf_clock_now_ns(later.clock) < 10 * S);
    assert_true(ttf_sim_elapsed_ns(&later, at - resumed_ns) == at);
    assert_string_not_equal(ttf_clock_boot_id(whole.clock), ttf_clock_boot_id(later.clock));
    /* Both in natural light, and then lit from the same instant on. */
    capture(&whole, at, x);
    capture(&later, at - resumed_ns, y);
    assert_memory_equal(x, y, sizeof(x));
    sim_wait(&whole, at + 5 * S);
    sim_wait(&later, at + 5 * S - resumed_ns);
    sim_light_up(&whole, at + 1000 * S);
    sim_light_up(&later, at + 1000 * S - resumed_ns);
    capture(&whole, at + 30 * S, x);
    capture(&later, at + 30 * S - resumed_ns, y);
    assert_memory_equal(x, y, sizeof(x));
    ttf_box_destroy(&whole);
    ttf_box_destroy(&later);
}

static void after_a_power_cut_nothing_answers(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_reading r[TTF_SENSORS_MAX];
    struct ttf_panel_event event;
    struct ttf_lamp_state lamp;
    struct ttf_frame *frame;
    struct ttf_box box;

    (void)state;
    sim_add_fault(&c, TTF_FAULT_POWER_CUT, 50 * S, 0, 120, NULL);
    box = sim_box(&c);
    sim_light_up(&box, 1000 * S);
    sim_wait(&box, 50 * S - 1);
    assert_int_equal(box.power_lost(box.box_private), 0);
    assert_int_equal(sim_shoot(&box, 20 * MS, 51 * S, &frame), -ENODEV);
    assert_true(ttf_clock_now_ns(box.clock) == 50 * S); /* a wait for a frame ends with the power */
    assert_int_equal(box.power_lost(box.box_private), 1);
    assert_int_equal(sim_shoot(&box, 20 * MS, 0, &frame), -ENODEV);
    assert_int_equal(ttf_camera_recover(box.cameras[0].camera, TTF_CAMERA_REOPEN, NULL), -ENODEV);
    assert_int_equal(ttf_sensors_read(box.sensors, r, NULL), -ENODEV);
    assert_int_equal(ttf_lamps_state(box.lamps, 0, &lamp), -ENODEV);
    assert_int_equal(ttf_lamps_set(box.lamps, 0, 0, NULL), -ENODEV);
    assert_int_equal(ttf_lamps_acquire(box.lamps, 100 * S, NULL), -ENODEV);
    assert_int_equal(ttf_panel_poll(box.panel, &event), -ENODEV);
    assert_int_equal(ttf_panel_led(box.panel, TTF_LED_IDLE), -ENODEV);
    assert_int_equal(ttf_watchdog_arm(box.watchdog, S), -ENODEV);
    assert_true(ttf_sim_back_ns(&box) == 170 * S);
    ttf_box_destroy(&box);
}

static void a_cut_that_happened_does_not_happen_again_and_the_next_one_does(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_box box;

    (void)state;
    sim_add_fault(&c, TTF_FAULT_POWER_CUT, 50 * S, 0, 0, NULL);
    sim_add_fault(&c, TTF_FAULT_POWER_CUT, 500 * S, 0, 0, NULL);
    c.outage_ns = 30 * S;
    c.power_on_ns = 80 * S;
    box = sim_box(&c);
    sim_wait(&box, 300 * S);
    assert_int_equal(box.power_lost(box.box_private), 0);
    sim_wait(&box, 420 * S);
    assert_int_equal(box.power_lost(box.box_private), 1);
    assert_true(ttf_sim_back_ns(&box) == 530 * S);
    ttf_box_destroy(&box);
}

static void one_time_faults_before_a_resume_are_over_and_lasting_ones_go_on(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_box box;
    struct ttf_frame *frame;

    (void)state;
    sim_add_fault(&c, TTF_FAULT_FRAME_MISSING, 50 * S, 0, 0, NULL);
    sim_add_fault(&c, TTF_FAULT_CAMERA_HANG, 60 * S, 0, 2, NULL);
    sim_add_fault(&c, TTF_FAULT_LAMP_FADING, 0, 0, 100, "left");
    sim_add_fault(&c, TTF_FAULT_IO_ERROR, 70 * S, 0, 0, NULL);
    c.power_on_ns = 2 * TTF_NS_PER_H;
    box = sim_box(&c);
    sim_light_up(&box, 1000 * S);
    assert_int_equal(sim_shoot(&box, 20 * MS, 10 * S, &frame), 0);
    ttf_camera_release(box.cameras[0].camera, frame);
    assert_int_equal(sim_lamp(&box, 0).measured_permille, 800);
    assert_false(ttf_sim_storage_fault(&box, TTF_FAULT_IO_ERROR));
    ttf_box_destroy(&box);
}

static void utc_survives_a_cut_only_with_a_battery(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_utc utc;
    struct ttf_box box;

    (void)state;
    c.power_on_ns = 7200 * S;
    box = sim_box(&c);
    ttf_clock_utc(box.clock, &utc);
    assert_int_equal(utc.trust, TTF_TRUST_RTC);
    assert_true(utc.utc_ns == c.start_utc_ns + 7200 * S + utc.boot_ns);
    ttf_box_destroy(&box);
    c.rtc = false;
    c.utc_back_ns = 600 * S;
    box = sim_box(&c);
    ttf_clock_utc(box.clock, &utc);
    assert_int_equal(utc.trust, TTF_TRUST_NONE);
    assert_true(utc.uncertainty_ns == TTF_NS_UNKNOWN);
    assert_true(utc.utc_ns < c.start_utc_ns + 7200 * S);
    sim_wait(&box, 601 * S);
    ttf_clock_utc(box.clock, &utc);
    assert_int_equal(utc.trust, TTF_TRUST_NTP);
    assert_int_equal(utc.steps, 1);
    assert_true(utc.utc_ns == c.start_utc_ns + 7200 * S + utc.boot_ns);
    ttf_box_destroy(&box);
}

static void a_hung_clients_lamps_go_dark_in_the_picture(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_box box = sim_box(&c);
    double lit;

    (void)state;
    sim_light_up(&box, 20 * S);
    lit = sim_brightness(&box, 19 * S);
    assert_true(lit > 100);
    assert_true(fabs(sim_brightness(&box, 20 * S + 300 * MS) / lit - 1) < 0.01);
    assert_true(sim_brightness(&box, 20 * S + 500 * MS) < 0.01 * lit);
    assert_int_equal(sim_lamp(&box, 0).trip, TTF_TRIP_LEASE);
    ttf_box_destroy(&box);
}

static void an_exposure_across_a_switching_gets_its_share_of_light(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_box box;
    struct ttf_frame *frame;
    double full;

    (void)state;
    c.readout_ns = 0;
    box = sim_box(&c);
    sim_light_up(&box, 100 * S);
    full = sim_brightness(&box, 10 * S);
    /* The lease lapses in the very middle of this exposure. */
    assert_int_equal(ttf_lamps_alive(box.lamps, ttf_clock_now_ns(box.clock), NULL), 0);
    assert_int_equal(
        sim_shoot(&box, 20 * MS, ttf_clock_now_ns(box.clock) + TTF_LEASE_LAPSE_NS, &frame), 0);
    assert_true(fabs(sim_mean(&box, frame) / full - 0.5) < 0.02);
    ttf_box_destroy(&box);
}

static void the_default_box_burns_for_a_week_without_a_trip_and_cheaply(void **state)
{
    struct ttf_sim_config c;
    struct ttf_box box;
    struct ttf_reading r[TTF_SENSORS_MAX];

    (void)state;
    ttf_sim_config_defaults(&c);
    box = sim_box(&c);
    sim_light_up(&box, 8 * TTF_NS_PER_DAY);
    for (int h = 1; h <= 7 * 24; h++) {
        sim_wait(&box, h * TTF_NS_PER_H);
        assert_int_equal(sim_lamp(&box, 0).trip, TTF_TRIP_NONE);
        assert_int_equal(ttf_sensors_read(box.sensors, r, NULL), 2);
        assert_in_range(r[0].value, 20000, 50000);
    }
    assert_true(sim_lamp(&box, 0).on_total_ns > 167 * TTF_NS_PER_H);
    ttf_box_destroy(&box);
}

static void a_box_that_gets_too_hot_trips_its_lamps_at_the_limit(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_reading r[TTF_SENSORS_MAX];
    struct ttf_lamp_state lamp;
    struct ttf_box box;
    double tau = (double)c.heat_tau_ns / S, expected;

    (void)state;
    c.day_swing_degc = 0;
    c.lamps[0].heat_degc = 60;
    c.lamps[1].heat_degc = 0;
    box = sim_box(&c);
    sim_light_up(&box, TTF_NS_PER_DAY);
    sim_wait(&box, 6 * TTF_NS_PER_H);
    lamp = sim_lamp(&box, 0);
    assert_int_equal(lamp.trip, TTF_TRIP_TEMP);
    /* 22 + 60 (1 - exp(-t/tau)) = 60, and the guardian looks once a second. */
    expected = -tau * log(1 - 38.0 / 60.0);
    assert_true(fabs((double)lamp.on_total_ns / S - expected) < 3);
    assert_true(ttf_sensors_read(box.sensors, r, NULL) > 0);
    assert_in_range(r[0].value, 21900, 22500); /* cooled down since */
    assert_int_equal(ttf_lamps_set(box.lamps, 0, 1000, NULL), 0);
    ttf_box_destroy(&box);
}

static void lamps_warm_up_exponentially(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_box box;

    (void)state;
    c.lamps[0].cold_fraction = 0.6;
    c.lamps[0].warm_tau_ns = 60 * S;
    box = sim_box(&c);
    sim_wait(&box, 10 * S);
    sim_light_up(&box, 10000 * S);
    assert_int_equal(sim_lamp(&box, 0).measured_permille, 600);
    sim_wait(&box, 70 * S);
    assert_int_equal(sim_lamp(&box, 0).measured_permille, lround(1000 * (1 - 0.4 * exp(-1))));
    sim_wait(&box, 1010 * S);
    assert_int_equal(sim_lamp(&box, 0).measured_permille, 1000);
    ttf_box_destroy(&box);
}

/* Ratio of the brightest row to the darkest of a frame of an even scene. */
static double banding(struct ttf_box *box, int64_t exposure_ns, int64_t middle_ns)
{
    struct ttf_frame *frame;
    double low = 1e9, high = 0;

    assert_int_equal(sim_shoot(box, exposure_ns, middle_ns, &frame), 0);
    for (unsigned y = 8; y < 40; y += 2) {
        const uint16_t *row = (const uint16_t *)frame->data + (size_t)y * 64;
        double sum = 0;

        for (unsigned x = 0; x < 4; x += 2) /* the margin: even everywhere */
            sum += row[x] - frame->format.black_level;
        low = fmin(low, sum);
        high = fmax(high, sum);
    }
    ttf_camera_release(box->cameras[0].camera, frame);
    return high / low;
}

static void mains_ripple_bands_short_exposures_and_not_whole_half_periods(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_box box;
    double even;

    (void)state;
    c.lamps[0].ripple = c.lamps[1].ripple = 0.3;
    c.readout_ns = 19 * MS;
    c.vignetting = 0;
    c.perspective = 0;
    c.margin = 0.2;
    c.margin_reflectance = 1;
    c.blur_px = 0;
    box = sim_box(&c);
    sim_light_up(&box, 1000 * S);
    even = banding(&box, 20 * MS, 30 * S); /* the lamps' fall-off alone */
    assert_true(banding(&box, 3 * MS, 10 * S) > 1.15 * even);
    assert_true(fabs(banding(&box, 10 * MS, 20 * S) / even - 1) < 0.01);
    ttf_box_destroy(&box);
}

static int render_white(void *scene, int64_t t_ns, uint32_t w, uint32_t h, float *rgb,
                        struct ttf_err *err)
{
    (void)scene;
    (void)t_ns;
    (void)err;
    for (size_t i = 0; i < (size_t)w * h * 3; i++)
        rgb[i] = 1;
    return 0;
}

static void twenty_ms_of_a_perfect_diffuser_is_about_two_fifths_of_full_scale(void **state)
{
    static const struct ttf_scene_ops white_ops = {.name = "white", .render = render_white};
    const struct ttf_scene white = {.ops = &white_ops};
    struct ttf_sim_config c;
    struct ttf_box box;
    struct ttf_frame *frame;
    double sum = 0;

    (void)state;
    ttf_sim_config_defaults(&c);
    box = sim_box_of(&c, &white);
    sim_light_up(&box, 1000 * S);
    assert_int_equal(sim_shoot(&box, 20 * MS, 900 * S, &frame), 0);
    for (size_t y = 370; y < 390; y += 2) /* green pixels in the middle */
        for (size_t x = 501; x < 521; x += 2)
            sum += ((const uint16_t *)frame->data)[y * 1014 + x] - frame->format.black_level;
    sum /= 100.0 * (frame->format.white_level - frame->format.black_level);
    assert_true(sum > 0.40 && sum < 0.45);
    ttf_camera_release(box.cameras[0].camera, frame);
    ttf_box_destroy(&box);
}

static void the_watchdog_bites_whoever_is_late_once(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_box box = sim_box(&c);

    (void)state;
    assert_int_equal(ttf_watchdog_arm(box.watchdog, 10 * S), 0);
    sim_wait(&box, 9 * S);
    assert_int_equal(ttf_watchdog_feed(box.watchdog), 0);
    sim_wait(&box, 18 * S);
    assert_int_equal(ttf_sim_watchdog_bites(&box), 0);
    sim_wait(&box, 60 * S);
    assert_int_equal(ttf_sim_watchdog_bites(&box), 1);
    assert_int_equal(ttf_watchdog_feed(box.watchdog), 0);
    assert_int_equal(ttf_sim_watchdog_bites(&box), 1);
    ttf_watchdog_disarm(box.watchdog);
    sim_wait(&box, 600 * S);
    assert_int_equal(ttf_sim_watchdog_bites(&box), 1);
    ttf_box_destroy(&box);
}

static void a_person_presses_the_button_and_opens_the_door(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_box box = sim_box(&c);
    struct ttf_panel_event event;

    (void)state;
    sim_wait(&box, 5 * S);
    assert_int_equal(ttf_sim_panel_push(&box, TTF_PANEL_BUTTON_LONG), 0);
    sim_wait(&box, 6 * S);
    assert_int_equal(ttf_sim_panel_push(&box, TTF_PANEL_DOOR_OPENED), 0);
    assert_int_equal(ttf_panel_door(box.panel), 1);
    assert_int_equal(ttf_panel_poll(box.panel, &event), 1);
    assert_int_equal(event.kind, TTF_PANEL_BUTTON_LONG);
    assert_true(event.at_ns == 5 * S);
    assert_int_equal(ttf_panel_poll(box.panel, &event), 1);
    assert_int_equal(event.kind, TTF_PANEL_DOOR_OPENED);
    assert_int_equal(ttf_panel_poll(box.panel, &event), 0);
    ttf_box_destroy(&box);
}

static void truth_and_corners_are_for_simulated_boxes_only(void **state)
{
    struct ttf_sim_config c = sim_small();
    struct ttf_box box = sim_box(&c), other = {0};
    double xy[4][2];
    float rgb[4 * 4 * 3];

    (void)state;
    assert_int_equal(ttf_sim_truth(&box, 10 * S, 4, 4, rgb, NULL), 0);
    for (int i = 0; i < 4 * 4 * 3; i++)
        assert_true(rgb[i] >= 0 && rgb[i] <= 1);
    assert_int_equal(ttf_sim_corners(&box, xy), 0);
    assert_true(xy[0][0] < xy[1][0] && xy[0][1] < xy[3][1]);
    assert_int_equal(ttf_sim_truth(&other, 10 * S, 4, 4, rgb, NULL), -ENOTSUP);
    assert_int_equal(ttf_sim_corners(&other, xy), -ENOTSUP);
    assert_int_equal(ttf_sim_panel_push(&other, TTF_PANEL_BUTTON_SHORT), -ENOTSUP);
    assert_false(ttf_sim_storage_fault(&other, TTF_FAULT_IO_ERROR));
    ttf_box_destroy(&box);
}

static void wrong_configurations_name_their_field(void **state)
{
    struct ttf_sim_config good = sim_small(), c;
    struct ttf_err err = {0};

    (void)state;
    assert_int_equal(ttf_sim_config_check(&good, NULL), 0);
#define REFUSED(change, field)                                 \
    c = good;                                                  \
    change;                                                    \
    assert_int_equal(ttf_sim_config_check(&c, &err), -EINVAL); \
    assert_string_equal(err.where, field)
    REFUSED(c.width = 63, "width");
    REFUSED(c.bits = 17, "bits");
    REFUSED(c.perspective = 0.5, "perspective");
    REFUSED(c.blur_px = NAN, "blur_px");
    REFUSED(c.lamps[1].height = 0, "lamps[1].height");
    REFUSED(c.lamps[0].info.name[0] = 'X', "lamps[0].name");
    REFUSED(c.lamps[1].info = c.lamps[0].info, "lamps[1].name");
    REFUSED(c.n_sensors = 0, "lamps[0].max_temp_mdegc");
    REFUSED(c.n_lamps = 9, "n_lamps");
    REFUSED(c.buffers = 1, "buffers");
    REFUSED(c.frame_period_ns = 1, "frame_period_ns");
    REFUSED(sim_add_fault(&c, TTF_FAULT_FRAME_SHORT, 0, 0, 1001, NULL), "faults[0].amount");
    REFUSED(sim_add_fault(&c, TTF_FAULT_POWER_CUT, 0, 0, 0, NULL), "faults[0].at_ns");
#undef REFUSED
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(two_boxes_of_one_seed_give_the_same_bits_whatever_was_asked_between),
        cmocka_unit_test(a_resumed_box_gives_the_bits_that_it_would_have_given),
        cmocka_unit_test(after_a_power_cut_nothing_answers),
        cmocka_unit_test(a_cut_that_happened_does_not_happen_again_and_the_next_one_does),
        cmocka_unit_test(one_time_faults_before_a_resume_are_over_and_lasting_ones_go_on),
        cmocka_unit_test(utc_survives_a_cut_only_with_a_battery),
        cmocka_unit_test(a_hung_clients_lamps_go_dark_in_the_picture),
        cmocka_unit_test(an_exposure_across_a_switching_gets_its_share_of_light),
        cmocka_unit_test(the_default_box_burns_for_a_week_without_a_trip_and_cheaply),
        cmocka_unit_test(a_box_that_gets_too_hot_trips_its_lamps_at_the_limit),
        cmocka_unit_test(lamps_warm_up_exponentially),
        cmocka_unit_test(mains_ripple_bands_short_exposures_and_not_whole_half_periods),
        cmocka_unit_test(twenty_ms_of_a_perfect_diffuser_is_about_two_fifths_of_full_scale),
        cmocka_unit_test(the_watchdog_bites_whoever_is_late_once),
        cmocka_unit_test(a_person_presses_the_button_and_opens_the_door),
        cmocka_unit_test(truth_and_corners_are_for_simulated_boxes_only),
        cmocka_unit_test(wrong_configurations_name_their_field),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
