# SPDX-License-Identifier: Apache-2.0
"""Lamps on a real GPIO driver: ttfbox-lampd on the PL061, whose outputs are seen from outside the guest."""
import time

BOARD = """board: rig
cameras: {main: {backend: sim}}
clock: {backend: machine}
lamps:
  left: {backend: gpiod, chip: 9030000.pl061, line: 0, max_on: 1h}
  right: {backend: gpiod, chip: 9030000.pl061, line: 1, active_low: true}
guardian: {socket: /run/lampd.sock}
"""
LEFT, RIGHT, MARK = 0, 1, 5
TIMES = 20


def guard(m, board=BOARD):
    code, out = m.run("printf '%s' >/run/board.yaml" % board.replace("\n", "\\n"))
    assert code == 0, out
    code, out = m.run("ttfbox-lampd --board /run/board.yaml >/run/said 2>&1 & "
                      "i=0; while [ $i -lt 200 ] && ! grep -q guarding /run/said; do sleep 0.05; i=$((i+1)); done; "
                      "cat /run/said; grep -q guarding /run/said")
    assert code == 0, out


def light(m, life_ms=3600000, what="waits"):
    """A client that lights the left lamp; its process's number is in /run/client."""
    code, out = m.run("lampd_child /run/lampd.sock %d %s >/run/lit & echo $! >/run/client; i=0; "
                      "while [ $i -lt 200 ] && ! grep -q lit /run/lit; do sleep 0.02; i=$((i+1)); done; "
                      "grep -q lit /run/lit" % (life_ms, what))
    assert code == 0, out
    assert m.level(LEFT, 1), m.lines()


def end(m):
    m.run("kill -9 $(cat /run/client) $(pgrep -x 'ttfbox-lampd|lampd_child'); wait; rm -f /run/lit /run/said")


def lamps_are_dark_from_the_first_and_without_a_glitch(m):
    """An active-low lamp would flash if its line were given a direction before its value."""
    since = time.time()
    guard(m)
    lines = m.lines()
    assert lines.get(LEFT) == 0 and lines.get(RIGHT) == 1, lines
    wrong = [c for c in m.changes(since) if (c[1], c[2]) in ((LEFT, 1), (RIGHT, 0))]
    assert not wrong, wrong
    light(m)
    m.run("kill $(pgrep -x ttfbox-lampd); wait")
    assert m.level(LEFT, 0), m.lines()
    assert m.lines().get(RIGHT, 1) == 1, m.lines()
    end(m)


def how_long(m, stroke, times):
    """Milliseconds from a stroke of fate to darkness, by the outside observer, each time: a line marks the stroke."""
    took = []
    for _ in range(times):
        light(m)
        before = time.time()
        code, out = m.run("gpioset 9030000.pl061 %d=1; %s; gpioset 9030000.pl061 %d=0" % (MARK, stroke, MARK))
        assert code == 0, out
        assert m.level(LEFT, 0), (stroke, m.lines())
        struck = [c[0] for c in m.changes(before) if c[1:] == (MARK, 1)]
        dark = [c[0] for c in m.changes(before) if c[1:] == (LEFT, 0)]
        took.append((dark[0] - struck[0]) * 1000)
        m.run("kill -9 $(cat /run/client); rm -f /run/lit")
    took.sort()
    print("    %-34s dark after %.0f ms (median), %.0f ms (longest of %d)" %
          (stroke.split(" $")[0], took[len(took) // 2], took[-1], times))
    return took


def killed_and_stopped_clients_leave_the_lamps_dark(m):
    guard(m)
    killed = how_long(m, "kill -9 $(cat /run/client)", TIMES)
    stopped = how_long(m, "kill -STOP $(cat /run/client)", TIMES)
    assert killed[-1] < 500, killed
    # A loaded host stretches what the guest calls 400 ms; the bound in its own time is tested elsewhere.
    assert stopped[len(stopped) // 2] < 700, stopped
    end(m)


def clients_killed_a_few_times_leave_the_lamps_dark(m):
    guard(m)
    killed = how_long(m, "kill -9 $(cat /run/client)", 5)
    assert killed[2] < 1000, killed  # beside whatever else this machine does; the whole rig is stricter
    end(m)


def a_client_that_hangs_is_dark_after_its_declared_sign_of_life(m):
    guard(m)
    before = time.time()
    light(m, 2000)
    assert m.level(LEFT, 0), m.lines()
    dark = [c[0] for c in m.changes(before) if c[1:] == (LEFT, 0)]
    print("    a hang: dark %.0f ms after lighting, with a sign of life declared for 2,000 ms" %
          ((dark[-1] - before) * 1000))
    end(m)


def a_killed_guardian_leaves_them_and_its_restart_darkens_them(m):
    """What the chip does is latch: that is why boards need pull-downs and a thermal cut-out behind the guardian."""
    guard(m)
    light(m)
    m.run("kill -9 $(pgrep -x ttfbox-lampd); wait; rm -f /run/said")
    time.sleep(0.3)
    latched = m.lines().get(LEFT) == 1
    print("    a killed guardian's lamp %s" % ("stays lit until it is back" if latched else "goes dark by itself"))
    since = time.time()
    guard(m)
    assert m.level(LEFT, 0), m.lines()
    assert not [c for c in m.changes(since) if c[1:] in ((LEFT, 1), (RIGHT, 0))], m.changes(since)
    end(m)


def a_line_that_another_holds_is_named_with_its_holder(m):
    m.run("gpioset --mode=signal 9030000.pl061 1=1 & sleep 0.5")
    m.run("printf '%s' >/run/board.yaml" % BOARD.replace("\n", "\\n"))
    code, out = m.run("ttfbox-lampd --board /run/board.yaml")
    assert code == 1 and "held by gpioset" in out, (code, out)
    m.run("kill $(pgrep -x gpioset)")
    code, out = m.run("sed 's/9030000.pl061/nochip/' /run/board.yaml >/run/wrong.yaml; "
                      "ttfbox-lampd --board /run/wrong.yaml")
    assert code == 2 and "'nochip' cannot be opened" in out, (code, out)


def programs_pass_their_tests_on_this_processor(m):
    for test in ("test_lines", "test_sysfs", "test_conformance_lampd"):
        code, out = m.run(test, 240)
        assert code == 0, out[-1500:]


SCENARIOS = [lamps_are_dark_from_the_first_and_without_a_glitch,
             killed_and_stopped_clients_leave_the_lamps_dark,
             a_client_that_hangs_is_dark_after_its_declared_sign_of_life,
             a_killed_guardian_leaves_them_and_its_restart_darkens_them,
             a_line_that_another_holds_is_named_with_its_holder,
             programs_pass_their_tests_on_this_processor]
