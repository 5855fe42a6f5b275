# SPDX-License-Identifier: Apache-2.0
"""The box as it works for weeks: daemon, guardian, camera, lamps and a disk, slot after slot; what both programs hold at the end is what they held early on."""
import os
import subprocess
import sys
import tempfile
import time

import boots
import camera
import lamps
from machine import Machine

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.append(os.path.dirname(HERE) + "/datasets")
import read  # noqa: E402

SLOTS = int(os.environ.get("TTFBOX_RIG_SOAK", "800"))
FILLED = 600  # slots by when what is kept of the last so many events (TTF_HTTP_EVENTS_KEPT) is full: until then a daemon does grow
INTERVAL_MS = 400
EARLY = max(SLOTS * 2 // 5, min(FILLED, SLOTS * 3 // 4))
COUNT = 4 * SLOTS + 1000  # it is ended before
PLAN = "interval: %dms\ncount: %d\nlamps: {mode: capture-only, settle: 50ms}\nshots: [{lamps: {left: 100%%}}]\n" \
       "keep: developed\nregion: {x: 0, y: 0, width: 64, height: 48}\nreserve: 1MB\n"
PROGRAMS = ["ttfboxd", "ttfbox-lampd"]
LOOKS = 20
STALLED_S = 30  # without a slot that is captured
MORE_KB = 64  # of memory, that is no leak: a page here and there, first touched late


def held(m, name):
    """(descriptors, kB of its own memory that are resident): a quarter of some looks saw no more, as a slot that is under way has a file and a frame more, and a
    count that is taken while the map changes may be cut short. What is mapped from files the kernel gives up and fetches again as it likes; its counts in
    status are wrong by up to 64 pages a thread."""
    code, out = m.run("P=$(pgrep -x %s); i=0; while [ $i -lt %d ]; do set -- /proc/$P/fd/*; while read key kb unit; do [ $key = Anonymous: ] && echo $# $kb; done </proc/$P/smaps_rollup; "
                      "sleep 0.07; i=$((i+1)); done" % (name, LOOKS), 120)
    looks = [line.split() for line in out.splitlines()]
    assert len(looks) == LOOKS, (code, out)
    return tuple(sorted(int(look[i]) for look in looks)[LOOKS // 4] for i in (0, 1))


def captured(m):
    code, out = m.run("grep -c '\"result\":\"captured\"' /disk/data/plan/records.jsonl")
    return int(out.split()[-1]) if code == 0 else 0


def reach(m, slots):
    """Until so many slots are captured, however many a busy host makes it miss; asked seldom, as each time a program reads all records."""
    had, since = captured(m), time.monotonic()
    while had < slots:
        code, out = m.run("sleep %d; kill -0 $(cat /run/daemon.pid)" % min(30, 1 + (slots - had) * INTERVAL_MS // 1000), 120)
        assert code == 0, m.run("tail -n 20 /run/daemon")[1]
        now = captured(m)
        if now > had:
            had, since = now, time.monotonic()
        assert time.monotonic() - since < STALLED_S, (now, m.run("tail -n 20 /run/daemon")[1])


def what_both_hold(m):
    return {name: held(m, name) for name in PROGRAMS}


def a_daemon_that_captures_long_holds_no_more_than_early_on(system, share):
    with tempfile.TemporaryDirectory(prefix="ttfbox-soak.") as folder:
        disk = folder + "/disk"
        subprocess.run(["truncate", "-s", "%dM" % (128 + SLOTS // 8), disk], check=True)
        subprocess.run(["mkfs.ext4", "-q", disk], check=True)
        devices = ["-drive", "file=%s,format=raw,if=none,id=d,cache=unsafe" % disk, "-device", "virtio-blk-pci,drive=d"]
        with Machine(system, share, 600 + SLOTS, devices) as m:
            boots.start(m, PLAN % (INTERVAL_MS, COUNT))
            reach(m, EARLY)
            early = what_both_hold(m)
            reach(m, SLOTS)
            late = what_both_hold(m)
            assert boots.recorded(m) < COUNT, "it was looked at too late, after the run"
            boots.stop(m)
        subprocess.run(["e2fsck", "-fy", disk], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
        subprocess.run(["debugfs", "-R", "rdump /data %s" % folder, disk], stderr=subprocess.DEVNULL, check=True)
        summary = read.Reader(folder + "/data/plan").summary()
    assert summary["exit"] == 0, [f for f in summary["findings"] if f["class"] == "damage"][:3]
    boots.expect_grid(summary, INTERVAL_MS * 10**6)
    results = [s["result"] for s in summary["slots"]]
    print("    %d slots at %d ms: %s" % (len(results), INTERVAL_MS, ", ".join("%d %s" % (results.count(r), r) for r in sorted(set(results)))))
    for name in PROGRAMS:
        print("    %s, from its slot %d on to its end: descriptors %d -> %d, resident of its own %d -> %d kB" % (name, EARLY, early[name][0], late[name][0], early[name][1], late[name][1]))
    assert results.count("captured") >= SLOTS, results.count("captured")
    assert all(late[name][0] <= early[name][0] and late[name][1] <= early[name][1] + MORE_KB for name in PROGRAMS), (early, late)


SCENARIOS = [a_daemon_that_captures_long_holds_no_more_than_early_on]
