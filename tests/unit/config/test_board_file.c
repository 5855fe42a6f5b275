/* SPDX-License-Identifier: Apache-2.0 */
/* Boards from YAML: every key of the simulated box, back-ends by name, overrides. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "board_text.h"
#include "ttf/base/attr.h"
#include "ttf/base/time.h"

static void parse_ok(const char *text, struct ttf_board *ret)
{
    struct ttf_err err;

    if (board_text(text, NULL, 0, ret, &err) != 0)
        fail_msg("%s: %s; %s", err.where, err.what, err.hint);
}

static const char WHOLE[] =
    "board: t\n"
    "title: T\n"
    "serial: S-1\n"
    "cameras: {main: {backend: sim, width: 64px, height: 48px}}\n"
    "clock: {backend: sim}\n"
    "lamps:\n"
    "  a: {backend: sim, kind: steps, steps: 4, max_on: 12h, max_duty: 60%, duty_window: 24h,\n"
    "      max_temp: 60degC, hysteresis: 5degC, interlock: door, warm_up: 3min}\n"
    "sensors: {t: {backend: sim, kind: temperature}, l: {backend: sim, kind: light}}\n"
    "panel: {backend: sim, door_switch: true}\n"
    "watchdog: {backend: sim}\n"
    "sim:\n"
    "  seed: 9223372036854775807\n"
    "  clock: real\n"
    "  start: 2026-03-01T08:00:00Z\n"
    "  power_on: 3h\n"
    "  outage: 7min\n"
    "  rtc: false\n"
    "  utc_back: 2h\n"
    "  cost: {develop: 120ms, commit: 30ms}\n"
    "  scene: {images: pics, span: 3d}\n"
    "  mains: 60Hz\n"
    "  ambient: 0.01\n"
    "  daylight: 2\n"
    "  room: {temperature: 18.5degC, day_swing: 4degC, heat_tau: 30min}\n"
    "  lamps: {a: {x: 0.2, y: -0.5, height: 1.5, strength: 2, cold: 60%, warm_tau: 90s,\n"
    "              ageing: 0.02, ripple: 10%, colour: [1, 0.9, 0.7], heat: 6degC}}\n"
    "  optics: {vignetting: 30%, perspective: 0, blur: 0.7px, margin: 4%,\n"
    "           margin_reflectance: 0.25}\n"
    "  sensor: {width: 64px, height: 48, bits: 14, black_level: 512, full_well: 20000,\n"
    "           read_noise: 3.5, prnu: 1%, dark_current: 0.3, dark_doubling: 6degC,\n"
    "           hot_fraction: 100ppm, hot_current: 500, sensitivity: 200000,\n"
    "           channel_gain: [0.5, 1, 0.6], noise: false}\n"
    "  timing: {exposure_min: 30us, exposure_max: 5s, exposure_step: 15us, gain_min: 1,\n"
    "           gain_max: 8, gain_step: 0.125, frame_period: 40ms, frame_period_max: 6s,\n"
    "           readout: 20ms, control_delay: 3, steerable: false, jitter: 50us, buffers: 3}\n"
    "  faults:\n"
    "    - {kind: lamp-dead, at: 3h, for: 10min, target: a}\n"
    "    - {kind: frame-missing, rate: 100ppm}\n"
    "    - {kind: clock-step, at: 1d, amount: -3600}\n";

static void every_key_reaches_its_field(void **state)
{
    struct ttf_board b;
    const struct ttf_sim_config *s = &b.sim;
    const struct ttf_lamp_info *lamp;

    (void)state;
    parse_ok(WHOLE, &b);
    assert_string_equal(b.name, "t");
    assert_string_equal(b.serial, "S-1");
    assert_int_equal(b.n_cameras, 1);
    assert_int_equal(b.cameras[0].mode.width, 64);
    assert_true(b.simulated && b.device[TTF_DEVICE_WATCHDOG]);
    lamp = &s->lamps[0].info;
    assert_int_equal(s->n_lamps, 1);
    assert_string_equal(lamp->name, "a");
    assert_true(lamp->kind == TTF_LAMP_STEPS && lamp->steps == 4);
    assert_true(lamp->max_on_ns == 12 * TTF_NS_PER_H && lamp->max_duty_permille == 600);
    assert_true(lamp->duty_window_ns == TTF_NS_PER_DAY && lamp->max_temp_mdegc == 60000);
    assert_true(lamp->hysteresis_mdegc == 5000 && lamp->interlock_door);
    assert_true(lamp->warm_up_ns == 3 * TTF_NS_PER_MIN);
    assert_int_equal(s->n_sensors, 2);
    assert_true(s->sensors[1].kind == TTF_SENSOR_LIGHT_PERMILLE && s->door_switch);
    assert_true(s->seed == INT64_MAX && s->real_time && !s->rtc);
    assert_true(s->start_utc_ns == INT64_C(1772352000) * TTF_NS_PER_S);
    assert_true(s->power_on_ns == 3 * TTF_NS_PER_H && s->outage_ns == 7 * TTF_NS_PER_MIN);
    assert_true(s->utc_back_ns == 2 * TTF_NS_PER_H);
    assert_true(s->cost_develop_ns == 120 * TTF_NS_PER_MS && s->cost_commit_ns == 30000000);
    assert_string_equal(b.scene.images, "dir/pics");
    assert_true(b.scene.span_ns == 3 * TTF_NS_PER_DAY && !*b.scene.name);
    assert_true(s->mains_hz == 60 && s->ambient == 0.01 && s->daylight == 2);
    assert_true(s->ambient_degc == 18.5 && s->day_swing_degc == 4);
    assert_true(s->heat_tau_ns == 30 * TTF_NS_PER_MIN);
    assert_true(s->lamps[0].x == 0.2 && s->lamps[0].y == -0.5 && s->lamps[0].height == 1.5);
    assert_true(s->lamps[0].strength == 2 && s->lamps[0].cold_fraction == 0.6);
    assert_true(s->lamps[0].warm_tau_ns == 90 * TTF_NS_PER_S && s->lamps[0].ripple == 0.1);
    assert_true(s->lamps[0].colour[2] == 0.7 && s->lamps[0].heat_degc == 6);
    assert_true(s->vignetting == 0.3 && s->perspective == 0 && s->blur_px == 0.7);
    assert_true(s->margin == 0.04 && s->margin_reflectance == 0.25);
    assert_true(s->width == 64 && s->height == 48 && s->bits == 14 && s->black_level == 512);
    assert_true(s->full_well_e == 20000 && s->read_noise_e == 3.5 && s->prnu == 0.01);
    assert_true(s->dark_e_per_s == 0.3 && s->dark_doubling_degc == 6 && s->hot_fraction == 1e-4);
    assert_true(s->hot_e_per_s == 500 && s->sensitivity_e == 200000 && !s->noise);
    assert_true(s->channel_gain[0] == 0.5);
    assert_true(s->exposure_min_ns == 30000 && s->exposure_step_ns == 15000);
    assert_true(s->exposure_max_ns == 5 * TTF_NS_PER_S && s->gain_max_milli == 8000);
    assert_true(s->gain_step_milli == 125 && s->frame_period_ns == 40000000);
    assert_true(s->frame_period_max_ns == 6 * TTF_NS_PER_S && s->readout_ns == 20000000);
    assert_true(s->control_delay_frames == 3 && !s->steerable && s->jitter_ns == 50000);
    assert_int_equal(s->buffers, 3);
    assert_int_equal(s->n_faults, 3);
    assert_int_equal(s->faults[0].kind, TTF_FAULT_LAMP_DEAD);
    assert_true(s->faults[0].at_ns == 3 * TTF_NS_PER_H &&
                s->faults[0].duration_ns == 10 * TTF_NS_PER_MIN);
    assert_string_equal(s->faults[0].target, "a");
    assert_int_equal(s->faults[1].rate_per_million, 100);
    assert_int_equal(s->faults[2].amount, -3600);
}

static void an_empty_section_gives_the_documented_defaults(void **state)
{
    struct ttf_sim_config defaults;
    struct ttf_board b;

    (void)state;
    ttf_sim_config_defaults(&defaults);
    parse_ok(HEAD LAMPS "sim:\n", &b);
    assert_int_equal(b.sim.width, defaults.width);
    assert_true(b.sim.sensitivity_e == defaults.sensitivity_e);
    assert_int_equal(b.sim.n_lamps, 2);
    assert_true(b.sim.lamps[1].x == defaults.lamps[1].x);
    assert_string_equal(b.scene.name, "grass");
}

static void a_board_without_lamps_has_none(void **state)
{
    struct ttf_board b;

    (void)state;
    parse_ok(HEAD, &b);
    assert_int_equal(b.sim.n_lamps, 0);
    assert_int_equal(b.sim.n_sensors, 0);
    assert_null(b.device[TTF_DEVICE_PANEL]);
}

static void wires_of_a_real_box_come_in_the_lamps_order_with_the_door_behind(void **state)
{
    struct ttf_board b;

    (void)state;
    parse_ok(REAL "guardian: {temperature: t, door: {chip: c, line: 3, active_low: true,"
                  " pull_up: true}}\n"
                  "lamps:\n"
                  "  left: {backend: gpiod, line: GPIO17, max_on: 2h, interlock: door,\n"
                  "         max_temp: 60degC, hysteresis: 5degC}\n"
                  "  right: {backend: gpiod, chip: gpiochip0, line: 27, active_low: true}\n"
                  "sensors:\n"
                  "  t: {backend: sysfs, kind: temperature, bus: iio, device: bme280}\n"
                  "  l: {backend: sysfs, kind: light, bus: iio, device: x, full: 2000}\n",
             &b);
    assert_int_equal(b.sim.n_lamps, 2);
    assert_int_equal(b.sim.lamps[0].info.kind, TTF_LAMP_SWITCH);
    assert_true(b.sim.lamps[0].info.max_on_ns == 2 * TTF_NS_PER_H);
    assert_int_equal(b.guardian.n_wires, 3);
    assert_string_equal(b.guardian.wires[0].label, "left");
    assert_string_equal(b.guardian.wires[0].line, "GPIO17");
    assert_string_equal(b.guardian.wires[1].label, "right");
    assert_string_equal(b.guardian.wires[1].chip, "gpiochip0");
    assert_true(b.guardian.wires[1].active_low && !b.guardian.wires[1].input);
    assert_int_equal(b.guardian.door, 2);
    assert_string_equal(b.guardian.wires[2].line, "3");
    assert_true(b.guardian.wires[2].input && b.guardian.wires[2].active_low &&
                b.guardian.wires[2].pull_up);
    assert_string_equal(b.guardian.temp_sensor, "t");
    assert_string_equal(b.guardian.socket, "/run/ttfbox/lampd.sock");
    assert_int_equal(b.n_sysfs, 2);
    assert_int_equal(b.sysfs[0].bus, TTF_SYSFS_IIO);
    assert_string_equal(b.sysfs[0].device, "bme280");
    assert_true(b.sysfs[1].full == 2000);
}

static void a_lamp_on_a_pwm_channel_takes_any_level_unless_it_is_said_to_be_a_switch(void **state)
{
    struct ttf_board b;

    (void)state;
    parse_ok(REAL
             "lamps:\n"
             "  left: {backend: gpiod, pwm: {chip: pwmchip0, channel: 1, period: 50us}}\n"
             "  right: {backend: gpiod, chip: pwmchip0, line: 1}\n"
             "  back: {backend: gpiod, kind: switch, pwm: {chip: p, channel: 0, period: 1ms}}\n"
             "  top: {backend: gpiod, kind: steps, steps: 4,\n"
             "        pwm: {chip: p, channel: 2, period: 1ms}}\n",
             &b);
    assert_int_equal(b.guardian.n_wires, 4);
    assert_int_equal(b.sim.lamps[0].info.kind, TTF_LAMP_PWM);
    assert_true(b.sim.lamps[0].info.pwm_period_ns == 50000);
    assert_string_equal(b.guardian.wires[0].label, "left");
    assert_string_equal(b.guardian.wires[0].chip, "pwmchip0");
    assert_string_equal(b.guardian.wires[0].line, "1");
    assert_true(b.guardian.wires[0].period_ns == 50000 && b.guardian.wires[1].period_ns == 0);
    assert_int_equal(b.sim.lamps[1].info.kind, TTF_LAMP_SWITCH);
    assert_int_equal(b.sim.lamps[2].info.kind, TTF_LAMP_SWITCH);
    assert_true(b.sim.lamps[2].info.pwm_period_ns == 0); /* never between dark and full */
    assert_int_equal(b.sim.lamps[3].info.kind, TTF_LAMP_STEPS);
    assert_true(b.sim.lamps[3].info.pwm_period_ns == TTF_NS_PER_MS);
}

static void every_key_of_real_devices_reaches_its_field(void **state)
{
    struct ttf_board b;
    const struct ttf_v4l2_config *v = &b.cameras[0].v4l2;

    (void)state;
    parse_ok("board: t\n"
             "cameras:\n"
             "  main: {backend: v4l2, device: /dev/video2, bus: usb-1, name: C920, format: Y10,\n"
             "         width: 640px, height: 480px, frame_period: 40ms, buffers: 3,\n"
             "         settle_frames: 6, steer: true, readout: 19ms, black_level: 64, white_level: "
             "1000,\n"
             "         gain_unity: 16, balance_unity: 128, focus_per_dioptre: 5,\n"
             "         white_balance_kelvin: 5000, flicker: 60Hz,\n"
             "         controls: {sharpness: 0, backlight_compensation: -3}}\n"
             "clock: {backend: machine}\n"
             "panel: {backend: gpiod, button: {line: GPIO5, active_low: true, pull_up: true},\n"
             "        led: {chip: gpiochip0, line: 6}}\n"
             "watchdog: {backend: device, device: /dev/watchdog1}\n"
             "lock: here.lock\n",
             &b);
    assert_false(b.simulated);
    assert_true(b.real);
    assert_string_equal(b.cameras[0].backend->name, "v4l2");
    assert_int_equal(b.cameras[0].mode.width, 640);
    assert_true(v->width == 640 && v->height == 480); /* also what a run's native mode is */
    assert_string_equal(v->device, "/dev/video2");
    assert_string_equal(v->bus, "usb-1");
    assert_string_equal(v->name, "C920");
    assert_string_equal(v->pixel_format, "Y10 ");
    assert_true(v->frame_period_ns == 40 * TTF_NS_PER_MS && v->readout_ns == 19 * TTF_NS_PER_MS);
    assert_true(v->buffers == 3 && v->settle_frames == 6 && v->steer);
    assert_true(v->black_level == 64 && v->white_level == 1000);
    assert_true(v->gain_unity == 16 && v->balance_unity == 128 && v->focus_per_dioptre == 5);
    assert_true(v->white_balance_kelvin == 5000 && v->flicker == TTF_V4L2_FLICKER_60HZ);
    assert_int_equal(v->n_controls, 2);
    assert_string_equal(v->controls[1].name, "backlight_compensation");
    assert_int_equal(v->controls[1].value, -3);
    assert_int_equal(b.panel.n_wires, 2);
    assert_true(b.panel.button == 0 && b.panel.led == 1);
    assert_true(b.panel.wires[0].input && b.panel.wires[0].active_low && b.panel.wires[0].pull_up);
    assert_string_equal(b.panel.wires[0].line, "GPIO5");
    assert_true(!b.panel.wires[1].input && !b.panel.wires[1].active_low);
    assert_string_equal(b.panel.wires[1].label, "led");
    assert_string_equal(b.watchdog_path, "/dev/watchdog1");
    assert_string_equal(b.lock, "dir/here.lock");
}

static void every_key_of_a_camera_behind_libcamera_reaches_its_field(void **state)
{
    struct ttf_board b;
    const struct ttf_libcamera_config *c = &b.cameras[0].libcamera;

    (void)state;
    parse_ok(
        "board: t\n"
        "cameras:\n"
        "  main: {backend: libcamera, id: /base/soc/i2c0mux, name: imx477, format: RG12P,\n"
        "         stream: raw, width: 4056px, height: 3040px, frame_period: 100ms, buffers: 3,\n"
        "         settle_frames: 5, delay_frames: 3, readout: 70ms, stamp: readout,\n"
        "         black_level: 256, white_level: 4095, module: /opt/m.so}\n"
        "clock: {backend: machine}\n",
        &b);
    assert_true(b.real && !b.simulated);
    assert_string_equal(b.cameras[0].backend->name, "libcamera");
    assert_true(b.cameras[0].mode.width == 4056 && c->width == 4056 && c->height == 3040);
    assert_string_equal(c->id, "/base/soc/i2c0mux");
    assert_string_equal(c->name, "imx477");
    assert_string_equal(c->module, "/opt/m.so");
    assert_string_equal(c->pixel_format, "RG12P");
    assert_int_equal(c->stream, TTF_LIBCAMERA_RAW);
    assert_int_equal(c->stamp, TTF_LIBCAMERA_STAMP_READOUT);
    assert_true(c->frame_period_ns == 100 * TTF_NS_PER_MS && c->readout_ns == 70 * TTF_NS_PER_MS);
    assert_true(c->buffers == 3 && c->settle_frames == 5 && c->delay_frames == 3);
    assert_true(c->black_level == 256 && c->white_level == 4095);
}

static void a_panel_may_have_either_wire_or_none(void **state)
{
    struct ttf_board b;

    (void)state;
    parse_ok(REAL "panel: {backend: gpiod, led: {line: x}}\n", &b);
    assert_true(b.panel.n_wires == 1 && b.panel.button == -1 && b.panel.led == 0);
    parse_ok(REAL "panel: {backend: gpiod}\n", &b);
    assert_true(b.panel.n_wires == 0 && b.panel.button == -1 && b.panel.led == -1);
}

static void one_simulated_device_makes_the_whole_box_simulated(void **state)
{
    struct ttf_board b;

    (void)state;
    parse_ok(REAL "lamps: {a: {backend: gpiod, line: x}}\n", &b);
    assert_true(b.simulated && b.real && b.sim.real_time);
    parse_ok("board: t\ncameras: {main: {backend: v4l2}}\nclock: {backend: machine}\n"
             "watchdog: {backend: sim}\n",
             &b);
    assert_true(b.simulated && b.real);
    parse_ok("board: t\ncameras: {main: {backend: v4l2}, side: {backend: sim}}\n"
             "clock: {backend: machine}\n",
             &b);
    assert_true(b.simulated && b.real);
    parse_ok(HEAD "sim: {clock: real}\nlamps: {a: {backend: gpiod, line: x}}\n", &b);
    assert_true(b.simulated && b.real && b.sim.real_time);
}

static void what_gets_along_on_usb_is_taken(void **state)
{
    static const char CAMERA[] =
        "board: t\ncameras: {main: {backend: v4l2%s}}\nclock: {backend: machine}\n"
        "lamps: {a: {backend: gpiod, chip: cp2112_gpio, line: 0}}\nmachine: {%s}\n";
    static const char *const RIGHT[][2] = {
        {"", "usb_role: host, usb_single: true, usb_devices: [main, cp2112_gpio]"},
        {", bus: usb-1", "usb_role: device, usb_devices: [main, disk, network]"},
        {", bus: 'platform:csi'", "usb_role: device, usb_single: true"},
        {"", "usb_role: device, usb_powers: true, power: poe"},
        {"", "usb_role: device, usb_powers: true, power: header, header: raspberry-pi"},
        {"", "usb_role: none, usb_powers: true, power: usb"},
    };
    struct ttf_board b;
    char text[600];

    (void)state;
    for (unsigned i = 0; i < TTF_COUNT_OF(RIGHT); i++) {
        /* NOLINTNEXTLINE(clang-diagnostic-format-nonliteral): above */
        (void)snprintf(text, sizeof text, CAMERA, RIGHT[i][0], RIGHT[i][1]);
        parse_ok(text, &b);
    }
    assert_int_equal(b.machine.power, TTF_POWER_USB);
    (void)snprintf(text, sizeof text, CAMERA, RIGHT[0][0], RIGHT[0][1]);
    parse_ok(text, &b);
    assert_int_equal(b.machine.n_usb_devices, 2);
    assert_string_equal(b.machine.usb_devices[1], "cp2112_gpio");
    assert_int_equal(b.machine.power, TTF_POWER_UNSAID);
}

static void services_and_the_gadget_are_named_in_their_order(void **state)
{
    struct ttf_board b;

    (void)state;
    parse_ok(REAL "machine: {usb_role: device}\nlamps: {a: {backend: gpiod, line: x}}\n"
                  "units: [ttfbox-usbd, ttfbox-gadget, ttfboxd, ttfbox-lampd]\n"
                  "gadget: {functions: [network, streams]}\n",
             &b);
    assert_string_equal(ttf_board_unit(&b, 0), "ttfbox-lampd");
    assert_string_equal(ttf_board_unit(&b, 1), "ttfboxd");
    assert_string_equal(ttf_board_unit(&b, 2), "ttfbox-gadget");
    assert_string_equal(ttf_board_unit(&b, 3), "ttfbox-usbd");
    assert_null(ttf_board_unit(&b, 4));
    assert_string_equal(ttf_board_function(&b, 0), "streams");
    assert_string_equal(ttf_board_function(&b, 1), "network");
    assert_null(ttf_board_function(&b, 2));
    parse_ok(REAL "units: [ttfboxd]\n", &b);
    assert_string_equal(ttf_board_unit(&b, 0), "ttfboxd");
    assert_null(ttf_board_unit(&b, 1));
    assert_null(ttf_board_function(&b, 0));
}

#define AT_A_PC                                                          \
    REAL "machine: {usb_role: device}\ngadget: {functions: [streams]}\n" \
         "units: [ttfboxd, ttfbox-gadget, ttfbox-usbd]\n"

/* What is set cannot take a key away: a change of the role takes what the file says of a device with it. */
static void a_port_that_is_set_to_be_no_device_takes_gadget_and_services_with_it(void **state)
{
    const struct ttf_board_set host[] = {{"machine.usb_role", "host"},
                                         {"gadget.functions", "[streams]"}};
    const struct ttf_board_set other[] = {{"machine.usb_role", "none"},
                                          {"units", "[ttfboxd, ttfbox-gadget, ttfbox-usbd]"}};
    const struct ttf_board_set whole = {"machine", "{usb_role: host}"};
    const struct ttf_board_set same[] = {{"machine.usb_role", "device"},
                                         {"machine.usb_single", "true"}};
    const struct ttf_board_set *const way[] = {host, other, &whole};
    struct ttf_board b;
    struct ttf_err err;

    (void)state;
    for (unsigned i = 0; i < TTF_COUNT_OF(way); i++) {
        if (board_text(AT_A_PC, way[i], 1, &b, &err) != 0)
            fail_msg("%s: %s", err.where, err.what);
        assert_int_equal(b.gadget, 0);
        assert_int_equal(b.units, TTF_UNIT_DAEMON);
    }
    assert_int_equal(board_text(AT_A_PC, same, 2, &b, &err), 0);
    assert_int_equal(b.gadget, TTF_GADGET_STREAMS);
    assert_non_null(ttf_board_unit(&b, 2));
    /* What was set, too, is held to it. */
    assert_int_equal(board_text(AT_A_PC, host, 2, &b, &err), -EINVAL);
    assert_non_null(strstr(err.what, "no USB port of the machine is a device"));
    assert_int_equal(board_text(AT_A_PC, other, 2, &b, &err), -EINVAL);
    assert_non_null(strstr(err.what, "and no gadget"));
}

static void a_box_with_real_devices_has_an_owner_and_a_simulated_one_needs_none(void **state)
{
    struct ttf_board b;

    (void)state;
    parse_ok(HEAD, &b);
    assert_string_equal(b.lock, "");
    parse_ok(HEAD "lock: x\n", &b);
    assert_string_equal(b.lock, "dir/x");
    parse_ok(REAL "watchdog: {backend: systemd}\n", &b);
    assert_string_equal(b.lock, "/run/ttfbox/box.lock");
    parse_ok(REAL "watchdog: {backend: systemd}\nlock: none\n", &b);
    assert_string_equal(b.lock, "");
}

/* They have no driver, so a guardian must not look for one. */
static void simulated_sensors_are_not_looked_for_in_the_kernel(void **state)
{
    struct ttf_board b;

    (void)state;
    parse_ok(REAL "sensors: {t: {backend: sim, kind: temperature}}\n"
                  "lamps: {a: {backend: gpiod, line: x}}\n",
             &b);
    assert_int_equal(b.n_sysfs, 0);
    assert_int_equal(b.sim.n_sensors, 1);
}

static void overrides_change_any_key_and_name_themselves_when_wrong(void **state)
{
    const struct ttf_board_set good[] = {{"sim.optics.blur", "2px"},
                                         {"sim.faults", "[{kind: power-cut, at: 3h}]"},
                                         {"sim.scene.name", "copper"},
                                         {"lamps.left.max_on", "1h"}};
    const struct ttf_board_set unknown = {"sim.optics.blurr", "2px"};
    const struct ttf_board_set no_place = {"board.x", "1"};
    const struct ttf_board_set bad_value = {"sim.outage", "5"};
    const struct ttf_board_set malformed = {"sim.faults", "[{"};
    struct ttf_board b;
    struct ttf_err err;

    (void)state;
    if (board_text(HEAD LAMPS "sim: {optics: {blur: 1px, vignetting: 0}}\n", good, 4, &b, &err) !=
        0)
        fail_msg("%s: %s", err.where, err.what);
    assert_true(b.sim.blur_px == 2 && b.sim.vignetting == 0);
    assert_int_equal(b.sim.faults[0].kind, TTF_FAULT_POWER_CUT);
    assert_string_equal(b.scene.name, "copper");
    assert_true(b.sim.lamps[0].info.max_on_ns == TTF_NS_PER_H);
    /* below a key that has nothing yet, too */
    if (board_text(HEAD LAMPS "sim:\n", good, 4, &b, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_true(b.sim.blur_px == 2);
    if (board_text(HEAD "sim: {optics: {blur: 0.7 px}}\n", NULL, 0, &b, &err) != 0)
        fail_msg("%s: %s", err.where, err.what);
    assert_true(b.sim.blur_px == 0.7);
    assert_int_equal(board_text(HEAD, &unknown, 1, &b, &err), -EINVAL);
    assert_non_null(strstr(err.where, "--set sim.optics.blurr"));
    assert_non_null(strstr(err.hint, "'blur'"));
    assert_int_equal(board_text(HEAD, &no_place, 1, &b, &err), -EINVAL);
    assert_non_null(strstr(err.what, "no such place"));
    assert_int_equal(board_text(HEAD, &bad_value, 1, &b, &err), -EINVAL);
    assert_non_null(strstr(err.what, "has no unit"));
    assert_int_equal(board_text(HEAD, &malformed, 1, &b, &err), -EINVAL);
    assert_non_null(strstr(err.what, "not YAML"));
}

static void any_cut_of_a_board_is_read_or_refused_with_its_place(void **state)
{
    (void)state;
    for (size_t n = 0; n < sizeof WHOLE; n++) {
        struct ttf_board b;
        struct ttf_err err = {0};

        if (ttf_board_parse("cut", WHOLE, n, NULL, 0, &b, &err) != 0 &&
            strncmp(err.where, "cut:", 4) != 0)
            fail_msg("cut at %zu: '%s' %s", n, err.where, err.what);
    }
}

static void boards_are_found_by_name_in_the_first_folder_that_has_them(void **state)
{
    char base[] = "/tmp/boards-XXXXXX", one[64], two[64], path[128], found[256];
    const char *folders[] = {one, two, NULL}, *near[] = {"near", one, NULL};
    struct ttf_err err = {0};
    FILE *f;

    (void)state;
    assert_non_null(mkdtemp(base));
    snprintf(one, sizeof one, "%s/one", base);
    snprintf(two, sizeof two, "%s/two", base);
    assert_int_equal(mkdir(one, 0700) | mkdir(two, 0700), 0);
    snprintf(path, sizeof path, "%s/my", two);
    assert_int_equal(mkdir(path, 0700), 0);
    snprintf(path, sizeof path, "%s/my/board.yaml", two);
    f = fopen(path, "w");
    assert_non_null(f);
    fclose(f);
    assert_int_equal(ttf_board_locate("my", folders, found, sizeof found, &err), 0);
    assert_string_equal(found, path);
    assert_int_equal(ttf_board_locate(path, folders, found, sizeof found, &err), 0);
    assert_string_equal(found, path);
    assert_int_equal(ttf_board_locate("yours", folders, found, sizeof found, &err), -ENOENT);
    assert_null(strstr(err.hint, base)); /* of whoever built the program */
    assert_non_null(strstr(err.hint, "came with the program"));
    assert_int_equal(ttf_board_locate("yours", near, found, sizeof found, &err), -ENOENT);
    assert_non_null(strstr(err.hint, "in near/ or"));
    unlink(path);
    snprintf(path, sizeof path, "%s/my", two);
    rmdir(path);
    rmdir(one);
    rmdir(two);
    rmdir(base);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_key_reaches_its_field),
        cmocka_unit_test(an_empty_section_gives_the_documented_defaults),
        cmocka_unit_test(a_board_without_lamps_has_none),
        cmocka_unit_test(wires_of_a_real_box_come_in_the_lamps_order_with_the_door_behind),
        cmocka_unit_test(a_lamp_on_a_pwm_channel_takes_any_level_unless_it_is_said_to_be_a_switch),
        cmocka_unit_test(every_key_of_real_devices_reaches_its_field),
        cmocka_unit_test(every_key_of_a_camera_behind_libcamera_reaches_its_field),
        cmocka_unit_test(a_panel_may_have_either_wire_or_none),
        cmocka_unit_test(one_simulated_device_makes_the_whole_box_simulated),
        cmocka_unit_test(what_gets_along_on_usb_is_taken),
        cmocka_unit_test(services_and_the_gadget_are_named_in_their_order),
        cmocka_unit_test(a_port_that_is_set_to_be_no_device_takes_gadget_and_services_with_it),
        cmocka_unit_test(a_box_with_real_devices_has_an_owner_and_a_simulated_one_needs_none),
        cmocka_unit_test(simulated_sensors_are_not_looked_for_in_the_kernel),
        cmocka_unit_test(overrides_change_any_key_and_name_themselves_when_wrong),
        cmocka_unit_test(any_cut_of_a_board_is_read_or_refused_with_its_place),
        cmocka_unit_test(boards_are_found_by_name_in_the_first_folder_that_has_them),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
