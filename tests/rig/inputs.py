# SPDX-License-Identifier: Apache-2.0
"""Doors, buttons and chips that go: simulated lines (gpio-sim) with a hand on them from outside our programs."""
import time

import boots
import drivers
import lamps

DOOR, LIGHT = 2, 1

# Lamps on the PL061, where the outside observer sees them; the door on a bank with a hand on it.
BOARD = """board: rig
cameras: {main: {backend: sim}}
clock: {backend: machine}
lamps:
  left: {backend: gpiod, chip: 9030000.pl061, line: 0, max_on: 1h, interlock: door}
guardian: {socket: /run/lampd.sock, door: {chip: rig-sim, line: 2DOOR}}
panel: {backend: gpiod}
"""


def pull(m, folder, line, level):
    code, out = m.run("echo pull-%s >%s/sim_gpio%d/pull" % ("up" if level else "down", folder, line))
    assert code == 0, out


def door(m, want):
    """What a client of the guardian is told within two seconds."""
    for _ in range(10):
        _, out = m.run("ttfbox board probe --board /run/board.yaml 2>&1 | sed -n 's/^door *//p'")
        if out.strip() == want:
            return
        time.sleep(0.2)
    assert False, (want, out)


def dark_after_opening(m, folder, opened):
    """Milliseconds from the door's edge to darkness, by the outside observer."""
    before = time.time()
    code, out = m.run("gpioset 9030000.pl061 %d=1; echo pull-%s >%s/sim_gpio%d/pull; gpioset 9030000.pl061 %d=0" %
                      (lamps.MARK, "up" if opened else "down", folder, DOOR, lamps.MARK))
    assert code == 0, out
    assert m.level(lamps.LEFT, 0), m.lines()
    changes = m.changes(before)
    return ([c[0] for c in changes if c[1:] == (lamps.LEFT, 0)][0] -
            [c[0] for c in changes if c[1:] == (lamps.MARK, 1)][0])


def an_open_door_darkens_the_lamp_on_either_polarity(m):
    folder = drivers.gpio_sim(m, 4)
    for words, opened in (("", 1), (", active_low: true", 0)):
        pull(m, folder, DOOR, not opened)
        lamps.guard(m, BOARD.replace("DOOR", words))
        door(m, "closed")
        lamps.light(m)
        took = dark_after_opening(m, folder, opened)
        print("    a door%s: dark %.0f ms after it opened" % (words and " of an active-low line", took * 1000))
        assert took < 0.5, took
        door(m, "open")
        pull(m, folder, DOOR, not opened)
        time.sleep(0.3)
        assert m.lines()[lamps.LEFT] == 0, "a closed door lights nothing by itself"
        # A door that bounces forty times and stays open is open.
        code, out = m.run("for i in 1 2 3 4 5 6 7 8 9 10 11 12 13 14 15 16 17 18 19 20; do echo pull-%s >%s/sim_gpio%d/pull; "
                          "echo pull-%s >%s/sim_gpio%d/pull; done" %
                          (("down", folder, DOOR, "up", folder, DOOR) if opened else
                           ("up", folder, DOOR, "down", folder, DOOR)))
        assert code == 0, out
        door(m, "open")
        lamps.end(m)


def a_door_that_another_holds_is_refused_with_its_name(m):
    drivers.gpio_sim(m, 4)
    m.run("gpiomon rig-sim 2 >/dev/null 2>&1 & echo $! >/run/holder; sleep 0.5")
    code, out = m.run("printf '%s' >/run/board.yaml; ttfbox-lampd --board /run/board.yaml 2>&1" %
                      BOARD.replace("DOOR", "").replace("\n", "\\n"))
    assert code == 1 and "held by gpiomon" in out and "door" in out, (code, out)
    assert m.lines().get(lamps.LEFT, 0) == 0, m.lines()
    _, out = m.run("umount /sys/kernel/debug; ttfbox board probe --board /run/board.yaml 2>&1")
    assert "line door: line 2 of chip rig-sim is taken by 'gpiomon'" in out, out
    m.run("kill $(cat /run/holder)")
    _, out = m.run("ttfbox board probe --board /run/board.yaml 2>&1")
    assert "is taken by" not in out, out
    lamps.guard(m, BOARD.replace("DOOR", ""))
    lamps.end(m)


# ---- chips that go ----

TWO_CHIPS = """board: rig
cameras: {main: {backend: sim}}
clock: {backend: machine}
lamps:
  away: {backend: gpiod, chip: rig-sim, line: 1, max_on: 1h}
  left: {backend: gpiod, chip: 9030000.pl061, line: 0, max_on: 1h}
guardian: {socket: /run/lampd.sock}
"""
LIVE = "/sys/kernel/config/gpio-sim/rig-sim/live"


def away(m, seconds):
    """The bank is gone for a while; its folder when it is back, which has another number while somebody holds the old."""
    code, out = m.run("echo 0 >%s" % LIVE)
    assert code == 0, out
    time.sleep(seconds)
    code, out = m.run("b=/sys/kernel/config/gpio-sim/rig-sim; echo 1 >$b/live && "
                      "echo /sys/devices/platform/$(cat $b/dev_name)/$(cat $b/bank/chip_name)")
    assert code == 0, out
    return out.strip()


def a_chip_that_vanishes_darkens_all_and_its_lamps_come_back_dark(m):
    """The lamp that is asked for before the one that stays is on the chip that goes: a request that gave up at the
    first line would leave the other one as it was, lit."""
    folder = drivers.gpio_sim(m, 4)
    lamps.guard(m, TWO_CHIPS)
    code, out = m.run("lampd_child /run/lampd.sock 3600000 all >/run/lit 2>&1 & echo $! >/run/client; sleep 1; cat /run/lit; "
                      "cat %s/sim_gpio%d/value" % (folder, LIGHT))
    assert "lit" in out and out.strip().endswith("1"), out
    assert m.level(lamps.LEFT, 1), m.lines()
    since = time.time()
    folder = away(m, 3)  # looked for again and again meanwhile
    dark = [c for c in m.changes(since) if c[1:] == (lamps.LEFT, 0)]
    lit = [c for c in m.changes(since) if c[1:] == (lamps.LEFT, 1)]
    assert dark and not lit, (dark, lit)
    print("    the other chip's lamp: dark %.0f ms after its neighbour's chip went" % ((dark[0][0] - since) * 1000))
    code, out = m.run("sleep 2; cat %s/sim_gpio%d/value; kill -0 $(pgrep -x ttfbox-lampd)" % (folder, LIGHT))
    assert code == 0 and out.split()[0] == "0", out
    assert m.lines()[lamps.LEFT] == 0, m.lines()
    m.run("kill -9 $(cat /run/client); rm -f /run/lit; sleep 0.2")
    code, out = m.run("lampd_child /run/lampd.sock 3600000 all >/run/lit 2>&1 & echo $! >/run/client; sleep 1; cat /run/lit; "
                      "cat %s/sim_gpio%d/value" % (folder, LIGHT))
    assert "lit" in out and out.strip().endswith("1"), out
    assert m.level(lamps.LEFT, 1), m.lines()
    lamps.end(m)


# ---- the button ----

PANEL = """board: rig
cameras: {main: {backend: sim}}
clock: {backend: machine}
panel: {backend: gpiod, button: {chip: rig-sim, line: 3, active_low: true}, led: {chip: rig-sim, line: 0}}
sim: {daylight: 1, sensor: {width: 96px, height: 64px}, timing: {exposure_max: 100ms}}
"""
PLAN = "interval: 500ms\ncount: 2000\nshot: {exposure: 10ms}\nkeep: raw\nreserve: 0B\n"


def press(m, folder, ms):
    """Down and up again, with a spring's bounces at both ends."""
    bounce = "for i in 1 2 3; do echo pull-%s >P; echo pull-%s >P; done; "
    code, out = m.run((bounce % ("down", "up") + "echo pull-down >P; sleep %g; " % (ms / 1000) + bounce % ("up", "down") +
                       "echo pull-up >P").replace(">P", ">%s/sim_gpio3/pull" % folder))
    assert code == 0, out


def a_button_held_for_three_seconds_ends_a_run_and_a_short_press_does_not(m):
    folder = drivers.gpio_sim(m, 4)
    pull(m, folder, 3, 1)
    boots.put(m, "/run/board.yaml", PANEL)
    boots.put(m, "/run/plan.yaml", PLAN)
    m.run("ttfbox capture /run/plan.yaml --board /run/board.yaml -o /run/run >/run/said 2>&1 & echo $! >/run/capture; "
          "i=0; while [ $i -lt 400 ] && [ ! -e /run/run/records.jsonl ]; do sleep 0.05; i=$((i+1)); done; sleep 2")
    press(m, folder, 400)
    time.sleep(1.5)
    code, out = m.run("kill -0 $(cat /run/capture) && cat /run/said")
    assert code == 0, "a short press ended it: " + out
    # The chip goes and comes back under the panel; the button works again.
    folder = away(m, 2)
    pull(m, folder, 3, 1)
    code, out = m.run("sleep 2.5; kill -0 $(cat /run/capture)")
    assert code == 0, "a panel that vanished ended the run: " + out
    press(m, folder, 3600)
    code, out = m.run("i=0; while [ $i -lt 200 ] && kill -0 $(cat /run/capture) 2>/dev/null; do sleep 0.1; i=$((i+1)); done; "
                      "kill -0 $(cat /run/capture) 2>/dev/null; echo running=$?; cat /run/said; grep button /run/run/events.jsonl; "
                      "ttfbox verify -q /run/run")
    assert code == 0 and "running=1" in out and "held: the run is to end" in out, out


SCENARIOS = [an_open_door_darkens_the_lamp_on_either_polarity, a_door_that_another_holds_is_refused_with_its_name,
             a_chip_that_vanishes_darkens_all_and_its_lamps_come_back_dark,
             a_button_held_for_three_seconds_ends_a_run_and_a_short_press_does_not]
