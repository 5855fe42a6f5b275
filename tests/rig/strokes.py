# SPDX-License-Identifier: Apache-2.0
"""A daemon that is killed or stopped while its lamps burn: dark, by the outside observer; started again, it goes on."""
import os
import time

import boots
import camera
import lamps

TIMES = int(os.environ.get("TTFBOX_RIG_STROKES", "4"))
PLAN = "interval: 1s\ncount: 2000\nlamps: {mode: continuous, settle: 150ms}\nshots: [{lamps: {left: 100%}}]\n" \
       "keep: developed\nregion: {x: 0, y: 0, width: 64, height: 48}\nreserve: 1MB\n"
CONFIG = "board: /run/board.yaml\nplan: /run/plan.yaml\ndata: /run/data\n"
STOPPED = "kill -9 $(cat /run/daemon.pid) 2>/dev/null; while kill -0 $(cat /run/daemon.pid) 2>/dev/null; do sleep 0.05; done"


def live(m):
    """What the service's manager does: starts it, again and again."""
    code, out = m.run("ttfboxd --config /run/config.yaml >/run/daemon 2>&1 & echo $! >/run/daemon.pid")
    assert code == 0, out
    assert m.level(lamps.LEFT, 1, 60), m.run("cat /run/daemon /run/said")[1]


def strike(m, stroke, times):
    """Milliseconds from each stroke to darkness: a line marks the stroke."""
    took = []
    for _ in range(times):
        live(m)
        before = time.time()
        code, out = m.run("gpioset 9030000.pl061 %d=1; kill -%s $(cat /run/daemon.pid); gpioset 9030000.pl061 %d=0" %
                          (lamps.MARK, stroke, lamps.MARK))
        assert code == 0, out
        assert m.level(lamps.LEFT, 0), (stroke, m.lines())
        struck = [c[0] for c in m.changes(before) if c[1:] == (lamps.MARK, 1)]
        dark = [c[0] for c in m.changes(before) if c[1:] == (lamps.LEFT, 0)]
        took.append((dark[0] - struck[0]) * 1000)
        m.run(STOPPED)
    took.sort()
    print("    ttfboxd, %-8s dark after %.0f ms (median), %.0f ms (longest of %d)" %
          ("SIG" + stroke, took[len(took) // 2], took[-1], times))
    return took


def a_daemon_killed_or_stopped_leaves_the_lamps_dark_and_goes_on(m):
    camera.load(m)
    lamps.guard(m, camera.BOARD)
    boots.put(m, "/run/plan.yaml", PLAN)
    boots.put(m, "/run/config.yaml", CONFIG)
    killed = strike(m, "KILL", TIMES)
    stopped = strike(m, "STOP", TIMES)
    live(m)
    code, out = m.run("sleep 2; kill $(cat /run/daemon.pid); while kill -0 $(cat /run/daemon.pid) 2>/dev/null; do sleep 0.1; done; "
                      "cat /run/daemon; ttfbox verify -q /run/data/plan", 60)
    assert code == 0 and "stopped" in out, out
    code, out = m.run("grep -c '\"type\":\"segment\"' /run/data/plan/records.jsonl")
    assert int(out) == 2 * TIMES + 1, out
    assert killed[-1] < 500, killed
    # A loaded host stretches what the guest calls 400 ms.
    assert stopped[len(stopped) // 2] < 700, stopped
    lamps.end(m)


SCENARIOS = [a_daemon_killed_or_stopped_leaves_the_lamps_dark_and_goes_on]
