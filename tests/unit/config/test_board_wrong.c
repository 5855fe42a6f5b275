/* SPDX-License-Identifier: Apache-2.0 */
/* test_board_wrong.c: boards that are wrong: each is refused with its place, in words, with what was meant. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>
#include <errno.h>

#include "board_text.h"
#include "ttf/base/attr.h"

static const struct {
    const char *text, *where, *what, *hint;
} WRONG[] = {
    {"", "dir/b.yaml:1:1", "empty", "cameras"},
    {"board: t\nclock: {backend: sim}\n", "dir/b.yaml:1:1", "'cameras' is missing", "main"},
    {"board: t\ncameras: {main: {backend: simm}}\nclock: {backend: sim}\n", "dir/b.yaml:2:27",
     "no back-end 'simm'", "sim"},
    {"board: t\ncameras: {main: {}}\nclock: {backend: sim}\n", "dir/b.yaml:2:17",
     "'backend' is missing", "sim"},
    {HEAD "sim: {sed: 5}\n", "dir/b.yaml:4:7", "sim.sed: unknown key", "'seed'"},
    {HEAD "sim: {seed: -1}\n", "dir/b.yaml:4:13", "negative", ""},
    {HEAD "sim: {outage: 5}\n", "dir/b.yaml:4:15", "has no unit", "5s"},
    {HEAD "sim: {optics: {blur: nan}}\n", "dir/b.yaml:4:22", "sim.optics.blur: 'nan'", ""},
    {HEAD "sim: {sensor: {width: 4px}}\n", "dir/b.yaml:4:23", "out of its range", "from 16"},
    {HEAD "sim: {sensor: {prnu: 0.4}}\n", "dir/b.yaml:4:22", "out of its range", "0.3"},
    {HEAD "sim: {mains: 55Hz}\n", "dir/b.yaml:4:14", "no mains has 55Hz", ""},
    {HEAD "sim: {mains: none}\n", "dir/b.yaml:4:14", "none", "50Hz"},
    {HEAD "sim: {scene: gras}\n", "dir/b.yaml:4:14", "no scene 'gras'", "'grass'"},
    {HEAD "sim: {scene: {name: grass, images: x}}\n", "dir/b.yaml:4:14", "more than one", ""},
    {HEAD "sim: {faults: [{kind: lamp-ded, at: 1h}]}\n", "dir/b.yaml:4:23", "no fault 'lamp-ded'",
     "'lamp-dead'"},
    {HEAD "sim: {faults: [{kind: lamp-dead}]}\n", "dir/b.yaml:4:16", "says not when", ""},
    {HEAD "sim: {faults: [{kind: lamp-dead, at: 1h, rate: 5ppm}]}\n", "dir/b.yaml:4:16", "exclude",
     ""},
    {HEAD LAMPS "sim: {lamps: {lft: {x: 1}}}\n", "dir/b.yaml:5:15", "no such lamp", "'left'"},
    {HEAD "lamps: {a: {backend: sim, kind: steps}}\n", "dir/b.yaml:4:12", "'steps'", ""},
    {HEAD "lamps: {a: {backend: sim, max_duty: 50}}\n", "dir/b.yaml:4:37", "has no unit", "%"},
    {HEAD "sensors: {t: {backend: sim}}\n", "dir/b.yaml:4:14", "'kind' is missing", ""},
    /* lamps with wires */
    {HEAD "lamps: {a: {backend: gpiod}}\n", "dir/b.yaml:4:12", "'line' is missing", "GPIO17"},
    {HEAD "lamps: {a: {backend: gpiod, line: x, kind: pwm}}\n", "dir/b.yaml:4:44", "on or off",
     "pwm: {"},
    {HEAD "lamps: {a: {backend: gpiod, line: x, pwm: {chip: p, channel: 0, period: 1ms}}}\n",
     "dir/b.yaml:4:12", "one wire", ""},
    {HEAD "lamps: {a: {backend: gpiod, pwm: {chip: p, channel: 0}}}\n", "dir/b.yaml:4:34",
     "'period' is missing", ""},
    {HEAD "lamps: {a: {backend: gpiod, pwm: {chip: p, channel: 0, period: 2s}}}\n",
     "dir/b.yaml:4:64", "out of its range", ""},
    {HEAD "lamps: {a: {backend: sim, pwm: {chip: p, channel: 0, period: 1ms}}}\n",
     "dir/b.yaml:4:12", "has no wire", ""},
    {REAL "lamps: {a: {backend: gpiod, pwm: {chip: p, channel: 0, period: 1ms}},\n"
          "  b: {backend: gpiod, pwm: {chip: p, channel: 0, period: 2ms}}}\n",
     "dir/b.yaml:5:6", "PWM channel 0 is already that of 'a'", ""},
    {HEAD "lamps: {a: {backend: sim, line: 4}}\n", "dir/b.yaml:4:12", "has no wire", ""},
    {HEAD "lamps: {a: {backend: file, line: 4}}\n", "dir/b.yaml:4:8", "no 'file' is named", ""},
    {HEAD "lamps: {a: {backend: gpiod, line: x, max_temp: 60degC}}\n", "dir/b.yaml:4:12",
     "without a temperature", "guardian"},
    {HEAD "sensors: {t: {backend: sysfs, kind: humidity, device: d}}\n"
          "lamps: {a: {backend: gpiod, line: x, max_temp: 60degC}}\n",
     "dir/b.yaml:5:12", "without a temperature", "guardian"},
    {HEAD "lamps: {a: {backend: gpiod, line: x, interlock: door}}\n", "dir/b.yaml:4:12",
     "without a door switch", "door"},
    {HEAD "lamps: {a: {backend: gpiod, line: x}}\nguardian: {door: {chip: c}}\n", "dir/b.yaml:5:18",
     "'line' is missing", "gpiochip0"},
    {HEAD LAMPS "guardian: {socket: /x}\n", "dir/b.yaml:5:11", "without lamps", ""},
    {HEAD "sensors: {t: {backend: sysfs, kind: temperature}}\n", "dir/b.yaml:4:14",
     "'device' is missing", "bme280"},
    {HEAD "sensors: {t: {backend: sysfs, kind: light, device: d}}\n", "dir/b.yaml:4:14",
     "'full' is missing", "2000"},
    {HEAD "sensors: {t: {backend: sim, kind: light, device: d}}\n", "dir/b.yaml:4:14",
     "has no driver", ""},
    /* real devices */
    {HEAD "lamps: {a: {backend: gpiod, line: x}}\n", "dir/b.yaml:3:8", "lives in real time",
     "machine"},
    {HEAD "watchdog: {backend: systemd}\n", "dir/b.yaml:3:8", "'watchdog' lives in real time", ""},
    {"board: t\ncameras: {main: {backend: v4l2}}\nclock: {backend: sim}\n", "dir/b.yaml:3:8",
     "'cameras' lives in real time", ""},
    {REAL "sim: {clock: virtual}\n", "dir/b.yaml:4:14", "virtual clock beside the machine's",
     "real"},
    {HEAD "sensors: {t: {backend: sim, kind: temperature}}\n"
          "lamps: {a: {backend: gpiod, line: x, max_temp: 60degC}}\n",
     "dir/b.yaml:5:12", "without a temperature", ""},
    {"board: t\ncameras: {main: {backend: sim, device: /dev/video0}}\n", "dir/b.yaml:2:32",
     "unknown key", ""},
    {"board: t\ncameras: {main: {backend: v4l2, format: RGB}}\nclock: {backend: machine}\n"
     "panel: {backend: file}\n",
     "dir/b.yaml:4:8", "no 'file' is named", ""},
    {"board: t\ncameras: {main: {backend: v4l2, format: RGGB10}}\n", "dir/b.yaml:2:41",
     "no pixel format", "RG10"},
    {"board: t\ncameras: {main: {backend: v4l2, frame_period: 90s}}\n", "dir/b.yaml:2:47",
     "out of its range", "1min"},
    {"board: t\ncameras: {main: {backend: v4l2, black_level: 64, white_level: 64}}\n",
     "dir/b.yaml:2:63", "is not above", ""},
    {"board: t\ncameras: {main: {backend: libcamera, format: SRGGB12}}\n", "dir/b.yaml:2:46",
     "no pixel format", "RG12"},
    {"board: t\ncameras: {main: {backend: libcamera, gain_unity: 16}}\n", "dir/b.yaml:2:38",
     "unknown key", ""},
    {"board: t\ncameras: {main: {backend: v4l2, controls: {a: b}}}\n", "dir/b.yaml:2:47", "'b'",
     ""},
    {REAL "panel: {backend: gpiod, door_switch: true}\n", "dir/b.yaml:4:25", "unknown key", ""},
    {REAL "panel: {backend: gpiod, button: {chip: c}}\n", "dir/b.yaml:4:33", "'line' is missing",
     ""},
    {REAL "machine: {header: raspberry-pi}\nlamps: {a: {backend: gpiod, line: GPIO0}}\n",
     "dir/b.yaml:5:12", "ID EEPROM", "16 to 27"},
    {REAL "machine: {header: raspberry-pi}\nlamps: {a: {backend: gpiod, line: GPIO4}}\n"
          "guardian: {door: {chip: gpiochip0, line: 14}}\n",
     "dir/b.yaml:6:18", "serial console", ""},
    {REAL "lamps: {a: {backend: gpiod, line: x}}\npanel: {backend: gpiod, led: {line: x}}\n",
     "dir/b.yaml:5:30", "already that of 'a'", ""},
    {"board: t\ncameras: {main: {backend: v4l2, bus: usb-1}}\nclock: {backend: machine}\n"
     "machine: {usb_role: device, usb_single: true}\n",
     "dir/b.yaml:2:17", "one USB port is a device", "host"},
    /* what excludes what on USB and at the power input */
    {"board: t\ncameras: {main: {backend: v4l2}}\nclock: {backend: machine}\n"
     "machine: {usb_role: device, usb_single: true}\n",
     "dir/b.yaml:2:17", "may be a USB camera", "platform:"},
    {"board: t\ncameras: {main: {backend: v4l2, bus: usb-1}}\nclock: {backend: machine}\n"
     "machine: {usb_single: true}\n",
     "dir/b.yaml:2:17", "one USB port is not used", "host"},
    {REAL "machine: {usb_role: device, usb_single: true, usb_devices: [disk]}\n", "dir/b.yaml:4:61",
     "'disk', but the machine's one USB port is a device", "host"},
    {REAL "lamps: {a: {backend: gpiod, chip: cp2112_gpio, line: 0}}\n"
          "machine: {usb_role: device, usb_single: true, usb_devices: [cp2112_gpio]}\n",
     "dir/b.yaml:5:61", "'cp2112_gpio', but", "host"},
    {REAL "machine: {usb_role: host, usb_devices: [disk, side]}\n", "dir/b.yaml:4:47",
     "the board has no 'side'", "disk or network"},
    {REAL "machine: {usb_role: host, usb_devices: disk}\n", "dir/b.yaml:4:40", "a list", ""},
    {REAL "machine: {usb_role: device, usb_powers: true}\n", "dir/b.yaml:4:21",
     "cannot be a device as well", "VBUS"},
    {REAL "machine: {usb_role: device, usb_powers: true, power: usb}\n", "dir/b.yaml:4:21",
     "cannot be a device as well", "header, poe or socket"},
    {REAL "machine: {usb_role: host, usb_powers: true, power: usb}\n", "dir/b.yaml:4:21",
     "cannot be a host as well", ""},
    {REAL "machine: {power: usb}\n", "dir/b.yaml:4:18", "no power input", "usb_powers"},
    {REAL "machine: {power: header}\n", "dir/b.yaml:4:18", "no header", "raspberry-pi"},
    /* services, and what it is on the bus */
    {REAL "units: [ttfboxd, httpd]\n", "dir/b.yaml:4:18", "no 'httpd'", "ttfbox-alertd"},
    {REAL "units: [ttfboxd, ttfboxd]\n", "dir/b.yaml:4:18", "twice", ""},
    {REAL "units: []\n", "dir/b.yaml:4:8", "a list", ""},
    {REAL "units: ttfboxd\n", "dir/b.yaml:4:8", "a list", ""},
    {REAL "units: [ttfbox-alertd]\n", "dir/b.yaml:4:8", "nothing runs a plan", "add ttfboxd"},
    {REAL "lamps: {a: {backend: gpiod, line: x}}\nunits: [ttfboxd]\n", "dir/b.yaml:5:8",
     "no guardian", "ttfbox-lampd"},
    {REAL "machine: {usb_role: device}\ngadget: {functions: [streams]}\n"
          "units: [ttfboxd, ttfbox-usbd]\n",
     "dir/b.yaml:6:8", "nothing without the other", "both"},
    {REAL "machine: {usb_role: device}\nunits: [ttfboxd, ttfbox-gadget, ttfbox-usbd]\n",
     "dir/b.yaml:5:8", "no gadget", "functions"},
    {REAL "machine: {usb_role: device}\ngadget: {functions: [streams]}\nunits: [ttfboxd]\n",
     "dir/b.yaml:6:8", "no service composes", "ttfbox-usbd"},
    {REAL "machine: {usb_role: host}\ngadget: {functions: [streams]}\n", "dir/b.yaml:5:9",
     "no USB port of the machine is a device", "usb_role"},
    {REAL "machine: {usb_role: device}\ngadget: {functions: [network]}\n", "dir/b.yaml:5:9",
     "nobody binds it", "streams"},
    {REAL "machine: {usb_role: device}\ngadget: {functions: [streams, printer]}\n",
     "dir/b.yaml:5:31", "no 'printer'", "network"},
    {REAL "machine: {usb_role: device}\ngadget: {}\n", "dir/b.yaml:5:9", "functions", ""},
    {REAL "machine: {usb_role: gadget}\n", "dir/b.yaml:4:21", "gadget", "device"},
    {REAL "watchdog: {backend: systemd, device: /dev/watchdog}\n", "dir/b.yaml:4:30", "unknown key",
     ""},
    /* fields that only make sense together: ttf_sim_config_check's, placed all the same */
    {HEAD "sim: {timing: {exposure_min: 5s, exposure_max: 1s}}\n", "dir/b.yaml:4", "exposure", ""},
};

static void what_is_wrong_is_named_with_line_column_and_what_was_meant(void **state)
{
    (void)state;
    for (unsigned i = 0; i < TTF_COUNT_OF(WRONG); i++) {
        struct ttf_board b;
        struct ttf_err err;
        int r = board_text(WRONG[i].text, NULL, 0, &b, &err);

        if (r != -EINVAL)
            fail_msg("accepted or other error (%d):\n%s", r, WRONG[i].text);
        if (strncmp(err.where, WRONG[i].where, strlen(WRONG[i].where)) != 0 ||
            !strstr(err.what, WRONG[i].what) || !strstr(err.hint, WRONG[i].hint))
            fail_msg("%s\n-> %s: %s; %s", WRONG[i].text, err.where, err.what, err.hint);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(what_is_wrong_is_named_with_line_column_and_what_was_meant),
    };

    return cmocka_run_group_tests(tests, NULL, NULL);
}
