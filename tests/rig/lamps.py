# SPDX-License-Identifier: Apache-2.0
"""Lamps on a real GPIO driver: ttfbox-lampd on the PL061, whose outputs are seen from outside the guest."""
import signal
import time

from waited import Waited

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
PROMISED_MS = 500  # from a client's end to darkness
LIFE_MS = 2000
LEASE_MS = 400


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


def strike(m, what, pid_file, host):
    """A process is sent a signal between two edges of a line that marks it: dark_after_ms(); None if the lamp was dark before it, by the outside observer."""
    before = time.time()
    code, out = m.run("strike /dev/gpiochip0 %d %d $(cat %s)" % (MARK, what, pid_file))
    assert code == 0, out
    struck = [c[0] for c in m.changes(before) if c[1:] == (MARK, 1)][0]
    if level_at(m.changes(), LEFT, 0, struck) == 0:
        return None
    return dark_after_ms(m, struck, host)


def level_at(changes, line, first, when):
    level = first
    for at, which, to in changes:
        if which == line and at <= when:
            level = to
    return level


def dark_after_ms(m, since, host):
    """Milliseconds from an instant to darkness, by the outside observer, and how many of them the emulator waited for a processor."""
    assert m.level(LEFT, 0), m.lines()
    dark = [c[0] for c in m.changes(since) if c[1:] == (LEFT, 0)][0]
    return (dark - since) * 1000, host.between_ms(since, dark)


def median_ms(strokes):
    return sorted(s[0] for s in strokes)[len(strokes) // 2]


def tell(who, strokes):
    waits = sorted(s[1] for s in strokes)
    print("    %-18s dark after %.0f ms (median), %.0f ms (longest of %d); meanwhile the emulator waited for a processor %.0f ms (median), %.0f (longest)" %
          (who, median_ms(strokes), max(s[0] for s in strokes), len(strokes), waits[len(waits) // 2], waits[-1]), flush=True)


def expect_within(strokes, bound_ms):
    """Each one of them. Of a longer one the host's own account says that it kept the emulator from running for what is above that."""
    late = [s for s in strokes if s[0] > bound_ms + s[1]]
    assert not late, late


def how_long(m, who, times, once):
    """So many strokes of fate. One at a lamp that had gone dark already, as a busy host kept its client from renewing, says nothing: then it is another one's turn."""
    strokes, spoilt = [], 0
    with Waited(m) as host:
        while len(strokes) < times:
            stroke = once(host)
            if stroke:
                strokes.append(stroke)
            else:
                spoilt += 1
            assert spoilt <= times, "%s: the lamp was dark before %d strokes" % (who, spoilt)
    tell(who, strokes)
    return strokes


def clients_end(m, what, times):
    def once(host):
        light(m)
        stroke = strike(m, what, "/run/client", host)
        m.run("kill -9 $(cat /run/client); rm -f /run/lit")
        return stroke
    return how_long(m, what.name, times, once)


def killed_and_stopped_clients_leave_the_lamps_dark(m):
    guard(m)
    killed = clients_end(m, signal.SIGKILL, TIMES)
    stopped = clients_end(m, signal.SIGSTOP, TIMES)
    assert max(s[0] for s in killed) < PROMISED_MS, killed
    expect_within(stopped, PROMISED_MS)
    assert median_ms(stopped) < 700, stopped
    end(m)


def clients_killed_a_few_times_leave_the_lamps_dark(m):
    """Beside whatever else this machine does."""
    guard(m)
    killed = clients_end(m, signal.SIGKILL, 5)
    assert median_ms(killed) < 1000, killed
    end(m)
    return killed


def clients_killed_five_times_leave_the_lamps_dark_in_time(m):
    """The whole rig is stricter."""
    expect_within(clients_killed_a_few_times_leave_the_lamps_dark(m), PROMISED_MS)


def a_client_that_hangs_is_dark_after_its_declared_sign_of_life(m):
    guard(m)
    before = time.time()
    with Waited(m) as host:
        light(m, LIFE_MS)
        lit = [c[0] for c in m.changes(before) if c[1:] == (LEFT, 1)][0]
        took, waited = dark_after_ms(m, lit, host)
        declared = host.between_ms(before, lit)
    print("    a hang: dark %.0f ms after lighting, with a sign of life declared for %d ms; the emulator waited for a processor %.0f ms meanwhile" %
          (took, LIFE_MS, waited))
    expect_within([(took, waited)], LIFE_MS + PROMISED_MS)
    # Not sooner: what is renewed is the lease. It was declared before it was lit, by what lies between.
    assert took > LIFE_MS - PROMISED_MS - declared or waited > LEASE_MS, (took, declared, waited)
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
