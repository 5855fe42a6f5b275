# SPDX-License-Identifier: Apache-2.0
"""Chips on a bus that is registers in memory (i2c-stub), behind the drivers that real ones have: a BME280 by IIO, an LM75
by hwmon, a PCA9685's PWM channels. Scenarios turn registers; our programs see what the drivers make of them."""
import time

import boots
import lamps

BME280, LM75, PCA9685 = 0x77, 0x48, 0x40

# The calibration and the example of Bosch's data sheet: 25.08 degC and 1006.53 hPa.
CALIBRATION = [0x70, 0x6B, 0x43, 0x67, 0x18, 0xFC, 0x7D, 0x8E, 0x43, 0xD6, 0xD0, 0x0B, 0x27, 0x0B, 0x8C, 0x00, 0xF9, 0xFF,
               0x8C, 0x3C, 0xF8, 0xC6, 0x70, 0x17]
BME280_REGISTERS = {0xD0: 0x60, 0xA1: 75, 0xE1: 0x6A, 0xE2: 0x01, 0xE3: 0, 0xE4: 0x13, 0xE5: 0x2D, 0xE6: 0x03, 0xE7: 0x1E,
                    0xF7: 0x65, 0xF8: 0x5A, 0xF9: 0xC0, 0xFA: 0x7E, 0xFB: 0xED, 0xFC: 0x00, 0xFD: 0x6E, 0xFE: 0x00}
BME280_REGISTERS.update({0x88 + i: v for i, v in enumerate(CALIBRATION)})


def turn(m, chip, registers):
    for reg, value in registers.items():
        code, out = m.run("i2cset -f -y $(cat /run/bus) 0x%x 0x%x 0x%x" % (chip, reg, value))
        assert code == 0, out


def warm(m, celsius):
    """The LM75's register: its driver reads a word, high byte first."""
    code, out = m.run("i2cset -f -y $(cat /run/bus) 0x%x 0 0x%04x w" % (LM75, int(celsius) & 0xFF))
    assert code == 0, out


def plug(m, driver, chip):
    code, out = m.run("echo %s 0x%x >/sys/bus/i2c/devices/i2c-$(cat /run/bus)/new_device" % (driver, chip))
    assert code == 0, out


def bus(m):
    code, out = m.run("modprobe i2c-dev; modprobe i2c-stub chip_addr=0x%x,0x%x,0x%x && "
                      "i2cdetect -l | sed -n 's/^i2c-\\([0-9]*\\).*stub.*/\\1/p' >/run/bus; test -s /run/bus" %
                      (BME280, LM75, PCA9685))
    assert code == 0, out


def weather(m):
    bus(m)
    turn(m, BME280, BME280_REGISTERS)
    warm(m, 21)
    code, out = m.run("modprobe bmp280-i2c; modprobe lm75")
    assert code == 0, out
    plug(m, "bme280", BME280)
    plug(m, "lm75", LM75)


SENSORS = """sensors:
  box-temp: {backend: sysfs, kind: temperature, bus: iio, device: bme280}
  box-humidity: {backend: sysfs, kind: humidity, bus: iio, device: bme280}
  box-pressure: {backend: sysfs, kind: pressure, bus: iio, device: bme280}
  lens-temp: {backend: sysfs, kind: temperature, bus: hwmon, device: lm75}
"""
BOARD = """board: rig
cameras: {main: {backend: sim}}
clock: {backend: machine}
lamps:
  left: {backend: gpiod, chip: 9030000.pl061, line: 0, max_on: 1h, max_temp: 50degC, hysteresis: 5degC}
guardian: {socket: /run/lampd.sock, temperature: lens-temp}
sim: {daylight: 1, sensor: {width: 96px, height: 64px}, timing: {exposure_max: 100ms}}
""" + SENSORS
PLAN = "interval: 500ms\ncount: 2000\nshot: {exposure: 10ms}\nkeep: raw\nreserve: 0B\n"


def probed(m):
    """What each sensor gives, as it is said to people."""
    _, out = m.run("ttfbox board probe --board /run/board.yaml 2>&1")
    return {line.split()[1]: " ".join(line.split()[2:]) for line in out.splitlines() if line.startswith("sensor ")}


def sensors_of_real_drivers_are_read_lost_and_found_again(m):
    weather(m)
    boots.put(m, "/run/board.yaml", BOARD)
    lamps.guard(m, BOARD)
    seen = probed(m)
    assert seen["box-temp"] == "25.08 degC" and seen["lens-temp"] == "21.00 degC", seen
    assert abs(int(seen["box-pressure"].split()[-1]) - 100653) < 3, seen
    assert 20 < float(seen["box-humidity"].split()[0]) < 80, seen
    warm(m, -7)
    assert probed(m)["lens-temp"] == "-7.00 degC", probed(m)
    code, out = m.run("echo 0x%x >/sys/bus/i2c/devices/i2c-$(cat /run/bus)/delete_device" % LM75)
    assert code == 0, out
    seen = probed(m)
    assert seen["lens-temp"] == "DOES NOT ANSWER" and seen["box-temp"] == "25.08 degC", seen
    plug(m, "lm75", LM75)  # under another number of hwmon, may be
    assert probed(m)["lens-temp"] == "-7.00 degC", probed(m)
    lamps.end(m)


def a_lamp_too_hot_or_without_a_thermometer_goes_dark(m):
    weather(m)
    lamps.guard(m, BOARD)
    lamps.light(m)
    since = time.time()
    warm(m, 60)
    assert m.level(lamps.LEFT, 0, 15), m.lines()
    print("    too hot: dark %.1f s after the chip said so" % (time.time() - since))
    m.run("kill -9 $(cat /run/client); rm -f /run/lit")
    warm(m, 30)
    time.sleep(3)
    assert m.lines()[lamps.LEFT] == 0, "nothing lights by itself"
    lamps.light(m)
    since = time.time()
    code, out = m.run("echo 0x%x >/sys/bus/i2c/devices/i2c-$(cat /run/bus)/delete_device" % LM75)
    assert code == 0, out
    assert m.level(lamps.LEFT, 0, 30), m.lines()
    took = time.time() - since
    print("    no thermometer any more: dark %.1f s later" % took)
    assert took > 5, took
    lamps.end(m)


def a_lens_about_to_fog_is_an_event_of_the_run(m):
    weather(m)
    boots.put(m, "/run/board.yaml", BOARD.replace("lamps:\n", "").replace(BOARD.splitlines()[4] + "\n", "").replace(BOARD.splitlines()[5] + "\n", ""))
    boots.put(m, "/run/plan.yaml", PLAN)
    m.run("ttfbox capture /run/plan.yaml --board /run/board.yaml -o /run/run >/run/said 2>&1 & echo $! >/run/capture; "
          "i=0; while [ $i -lt 400 ] && ! grep -q '\"slot\"' /run/run/records.jsonl; do sleep 0.05; i=$((i+1)); done")
    code, out = m.run("grep dew /run/run/events.jsonl")
    assert code != 0, out
    warm(m, 2)  # colder than the dew point of the air around it
    code, out = m.run("i=0; while [ $i -lt 300 ] && ! grep -q dew /run/run/events.jsonl; do sleep 0.1; i=$((i+1)); done; "
                      "grep dew /run/run/events.jsonl; kill $(cat /run/capture); wait; cat /run/said; "
                      "grep -c 'lens-temp.*2000' /run/run/records.jsonl")
    assert "may fog" in out, out


# ---- a lamp that is dimmed ----

DIMMED = """board: rig
cameras: {main: {backend: sim}}
clock: {backend: machine}
lamps:
  left: {backend: gpiod, pwm: {chip: CHIP, channel: 3, period: 5ms}, max_on: 1h}
  right: {backend: gpiod, chip: 9030000.pl061, line: 0, max_on: 1h}
guardian: {socket: /run/lampd.sock}
"""


def channel(m, n):
    """What channel n of the chip was told: ticks of 4096 lit; its full-off bit is dark, its full-on bit is all."""
    code, out = m.run("for r in 0x%x 0x%x 0x%x 0x%x; do i2cget -f -y $(cat /run/bus) 0x%x $r; done" %
                      (6 + 4 * n, 7 + 4 * n, 8 + 4 * n, 9 + 4 * n, PCA9685))
    assert code == 0, out
    on_l, on_h, off_l, off_h = [int(x, 16) for x in out.split()]
    if off_h & 0x10:
        return 0
    if on_h & 0x10:
        return 4096
    return (off_l + 256 * (off_h & 15)) - (on_l + 256 * (on_h & 15))


def a_lamp_on_a_pwm_driver_has_its_levels_and_is_dark_with_its_client(m):
    bus(m)
    turn(m, PCA9685, {0xFE: 0x1E})  # its prescaler as after a reset
    code, out = m.run("modprobe pwm-pca9685")
    assert code == 0, out
    plug(m, "pca9685", PCA9685)
    code, out = m.run("basename $(readlink /sys/class/pwm/pwmchip0/device)")
    assert code == 0, out
    lamps.guard(m, DIMMED.replace("CHIP", out.strip()))
    assert channel(m, 3) == 0, channel(m, 3)
    for permille in (301, 1000, 5):
        code, out = m.run("lampd_child /run/lampd.sock 3600000 %d >/run/lit 2>&1 & echo $! >/run/client; sleep 0.7; cat /run/lit" % permille)
        assert "lit" in out, out
        ticks = channel(m, 3)
        assert abs(ticks - 4096 * permille / 1000) <= 1, (permille, ticks)
        m.run("kill -9 $(cat /run/client); sleep 0.5")
        assert channel(m, 3) == 0, channel(m, 3)
    # A killed guardian's channel stays; the next one darkens it before it does anything else.
    m.run("lampd_child /run/lampd.sock 3600000 500 >/run/lit 2>&1 & sleep 0.7; kill -9 $(pgrep -x ttfbox-lampd); rm -f /run/said; sleep 0.3")
    assert channel(m, 3) == 2048, channel(m, 3)
    lamps.guard(m, DIMMED.replace("CHIP", "pwmchip0"))
    assert channel(m, 3) == 0, channel(m, 3)
    # The chip goes, and comes back.
    m.run("lampd_child /run/lampd.sock 3600000 all >/run/lit 2>&1 & sleep 0.7")
    assert m.level(lamps.LEFT, 1), m.lines()
    code, out = m.run("echo 0x%x >/sys/bus/i2c/devices/i2c-$(cat /run/bus)/delete_device" % PCA9685)
    assert code == 0, out
    assert m.level(lamps.LEFT, 0, 5), "the other lamp's guardian did not notice"
    plug(m, "pca9685", PCA9685)
    m.run("kill -9 $(pgrep -x lampd_child)")
    time.sleep(2)
    assert channel(m, 3) == 0, "nothing lights by itself"
    code, out = m.run("lampd_child /run/lampd.sock 3600000 250 >/run/lit 2>&1 & sleep 0.7; cat /run/lit")
    assert "lit" in out and abs(channel(m, 3) - 1024) <= 1, (out, channel(m, 3))
    lamps.end(m)


def the_clock_is_vouched_for_by_a_battery_backed_one(m):
    boots.put(m, "/run/board.yaml", "board: rig\ncameras: {main: {backend: sim}}\nclock: {backend: machine}\n")
    code, out = m.run("cat /sys/class/rtc/rtc0/name /sys/class/rtc/rtc0/hctosys; ttfbox board probe --board /run/board.yaml 2>&1")
    assert "pl031" in out and "UTC vouched for by rtc" in out, out


SCENARIOS = [sensors_of_real_drivers_are_read_lost_and_found_again, a_lamp_too_hot_or_without_a_thermometer_goes_dark,
             a_lens_about_to_fog_is_an_event_of_the_run, a_lamp_on_a_pwm_driver_has_its_levels_and_is_dark_with_its_client,
             the_clock_is_vouched_for_by_a_battery_backed_one]
