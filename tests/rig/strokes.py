# SPDX-License-Identifier: Apache-2.0
"""A daemon that is killed or stopped while its lamps burn: dark, by the outside observer; started again, it goes on."""
import os
import signal

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
    code, out = m.run("echo >>/run/lives; ttfboxd --config /run/config.yaml >/run/daemon 2>&1 & echo $! >/run/daemon.pid")
    assert code == 0, out
    assert m.level(lamps.LEFT, 1, 60), m.run("cat /run/daemon /run/said")[1]


def ends(m, what, times):
    """Of each stroke: milliseconds to darkness, and those that the host took."""
    def once(host):
        live(m)
        stroke = lamps.strike(m, what, "/run/daemon.pid", host)
        m.run(STOPPED)
        return stroke
    return lamps.how_long(m, "ttfboxd, " + what.name, times, once)


def a_daemon_killed_or_stopped_leaves_the_lamps_dark_and_goes_on(m):
    camera.load(m)
    lamps.guard(m, camera.BOARD)
    boots.put(m, "/run/plan.yaml", PLAN)
    boots.put(m, "/run/config.yaml", CONFIG)
    killed = ends(m, signal.SIGKILL, TIMES)
    stopped = ends(m, signal.SIGSTOP, TIMES)
    live(m)
    code, out = m.run("sleep 2; kill $(cat /run/daemon.pid); while kill -0 $(cat /run/daemon.pid) 2>/dev/null; do sleep 0.1; done; "
                      "cat /run/daemon; ttfbox verify -q /run/data/plan", 60)
    assert code == 0 and "stopped" in out, out
    code, out = m.run("grep -c '\"type\":\"segment\"' /run/data/plan/records.jsonl")
    assert int(out) == int(m.run("wc -l </run/lives")[1]), out
    assert max(s[0] for s in killed) < lamps.PROMISED_MS, killed
    lamps.expect_within(stopped, lamps.PROMISED_MS)
    assert lamps.median_ms(stopped) < 700, stopped
    lamps.end(m)


SCENARIOS = [a_daemon_killed_or_stopped_leaves_the_lamps_dark_and_goes_on]
