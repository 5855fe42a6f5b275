# SPDX-License-Identifier: Apache-2.0
"""The services under a real systemd, killed, stopped and hung while a lamp burns: dark by the outside observer, and going on by themselves."""
import os
import subprocess
import time

import booted
import camera
import capture
import lamps

TIMES = int(os.environ.get("TTFBOX_IMAGE_STROKES", "3"))
LASTS_S = 600 + TIMES * 300  # at most
PLAN_S = LASTS_S + 400  # a plan that outlives the strokes, on a card that it fits
CARD_MIB = 1024 * PLAN_S // 1900
MARGIN_NS = 2 * 10**9  # of a sign of life behind the end of a wait (capture/pulse.h)


def freezer(folder):
    """freeze, for the guest: alone, so it needs no system to be compiled against."""
    out = folder + "/freeze"
    subprocess.run(["aarch64-linux-gnu-gcc", "-O1", "-static", "-D_GNU_SOURCE", "-o", out, booted.ROOT + "/tests/rig/freeze.c"], check=True)
    return out


def lit_again(m, seconds):
    began = time.monotonic()
    assert m.level(lamps.LEFT, 1, seconds), m.journal()
    return time.monotonic() - began


def pid_of(m, unit):
    return int(m.run("systemctl show -P MainPID %s" % unit)[1])


def hit(m, command):
    """Strikes between two marks on a line of its own; when, by the host's clock."""
    before = time.time()
    code, out = m.run("gpioset 9030000.pl061 %d=1; %s; gpioset 9030000.pl061 %d=0" % (lamps.MARK, command, lamps.MARK))
    assert code == 0, out
    return [c[0] for c in m.changes(before) if c[1:] == (lamps.MARK, 1)][0]


def dark_after(m, since, seconds=20):
    assert m.level(lamps.LEFT, 0, seconds), m.lines()
    return [c[0] for c in m.changes(since) if c[1:] == (lamps.LEFT, 0)][0]


def tell(what, dark_ms, back_s):
    dark_ms, back_s = sorted(dark_ms), sorted(back_s)
    print("    %s: %.0f ms (median), %.0f ms (longest of %d); the lamp burns again %.0f s after that (median), %.0f s (longest)" %
          (what, dark_ms[len(dark_ms) // 2], dark_ms[-1], len(dark_ms), back_s[len(back_s) // 2], back_s[-1]), flush=True)
    return dark_ms


def kill_daemon(m, signal):
    dark_ms, back_s = [], []
    for _ in range(TIMES):
        lit_again(m, 120)
        struck = hit(m, "kill -%s %d" % (signal, pid_of(m, "ttfboxd")))
        dark_ms.append((dark_after(m, struck) - struck) * 1000)
        back_s.append(lit_again(m, 120))
    return tell("ttfboxd, SIG%s: dark after" % signal, dark_ms, back_s)


def hang_daemon(m):
    """Its loop stands still where it waits; its other threads live on. From the sign of life that it declared last."""
    late_ms, back_s, held_ms = [], [], []
    for _ in range(TIMES):
        lit_again(m, 120)
        zero = camera.boot_at(m)
        since = time.time()
        code, out = m.run("rm -f /run/frozen; /usr/local/bin/freeze %d >/run/frozen 2>&1 & i=0; while [ $i -lt 200 ] && ! [ -s /run/frozen ]; "
                          "do sleep 0.05; i=$((i+1)); done; cat /run/frozen" % pid_of(m, "ttfboxd"))
        assert out.startswith("frozen"), out
        now, until = [int(word) / 1e9 for word in out.split()[1:3]]
        dark = dark_after(m, since) - zero
        late_ms.append((dark - until - MARGIN_NS / 1e9) * 1000)
        held_ms.append((dark - now) * 1000)
        back_s.append(lit_again(m, 120))
    tell("ttfboxd, its loop hung: dark after", held_ms, back_s)
    return tell("ttfboxd, its loop hung: dark after the declared sign of life", late_ms, back_s)


def hit_guardian(m, signal, seconds):
    dark_ms, back_s = [], []
    for _ in range(TIMES):
        lit_again(m, 120)
        struck = hit(m, "kill -%s %d" % (signal, pid_of(m, "ttfbox-lampd")))
        dark_ms.append((dark_after(m, struck, seconds) - struck) * 1000)
        back_s.append(lit_again(m, 120))
    return tell("ttfbox-lampd, SIG%s: started again, dark after" % signal, dark_ms, back_s)


def services_killed_stopped_and_hung_leave_the_lamps_dark_and_go_on(board, image):
    capture.card(board, image, capture.PLAN % (PLAN_S, "continuous"), [freezer(os.path.dirname(image))], CARD_MIB)
    with booted.Booted(image, seconds=LASTS_S) as m:
        lit_again(m, 300)
        killed = kill_daemon(m, "KILL")
        stopped = kill_daemon(m, "STOP")
        hung = hang_daemon(m)
        guardian = hit_guardian(m, "KILL", 20)
        hit_guardian(m, "STOP", 30)
        out = m.run("systemctl show -P NRestarts ttfboxd ttfbox-lampd; systemctl --failed --no-legend --plain")[1]
        restarts = [int(word) for word in out.split()]
        assert restarts == [3 * TIMES, 2 * TIMES], out
        m.run("systemctl stop ttfboxd", 200)
        assert m.level(lamps.LEFT, 0), m.lines()
        code, whole = m.run("ttfbox verify -q /var/lib/ttfbox/plan", 200)
        assert code == 0, whole
        print("    " + whole.strip())
        code, segments = m.run("grep -c '\"type\":\"segment\"' %s" % capture.RECORDS)
        assert segments.split() == [str(3 * TIMES + 1)], segments
        m.off()
    assert killed[-1] < 500, killed
    # A loaded host stretches what the guest calls 400 ms; the bounds in its own time are tested elsewhere.
    assert stopped[len(stopped) // 2] < 700 and hung[len(hung) // 2] < 700 and guardian[len(guardian) // 2] < 3000, (stopped, hung, guardian)


SCENARIOS = [services_killed_stopped_and_hung_leave_the_lamps_dark_and_go_on]
