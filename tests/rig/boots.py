# SPDX-License-Identifier: Apache-2.0
"""A box that loses its power again and again: the whole machine is killed, boots, and its daemon goes on by itself."""
import os
import random
import subprocess
import sys
import tempfile

import camera
import lamps
from machine import Machine

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path.append(os.path.dirname(HERE) + "/datasets")
import read  # noqa: E402

BOOTS = int(os.environ.get("TTFBOX_RIG_BOOTS", "4"))
INTERVAL_S = 3
PLAN = "interval: %ds\ncount: 500\nlamps: {mode: capture-only, settle: 150ms}\nshots: [{lamps: {left: 100%%}}]\n" \
       "keep: raw\nreserve: 1MB\n" % INTERVAL_S
CONFIG = "board: /disk/board.yaml\nplan: /disk/plan.yaml\ndata: /disk/data\n"
READY = ("i=0; while [ $i -lt 300 ] && ! grep -q '%s' /run/daemon; do sleep 0.1; i=$((i+1)); done; grep '%s' /run/daemon")


def put(m, path, text):
    code, out = m.run("printf '%s' >%s" % (text.replace("%", "%%").replace("\n", "\\n"), path))
    assert code == 0, out


def start(m, plan=None):
    """What the box's units would do at boot; at the first one with the settings. The slot that is next."""
    code, out = m.run("mkdir -p /disk && mount -o errors=remount-ro /dev/vda /disk")
    assert code == 0, out
    camera.load(m)
    lamps.guard(m, camera.BOARD)
    if plan:
        put(m, "/disk/board.yaml", camera.BOARD)
        put(m, "/disk/plan.yaml", plan)
        put(m, "/disk/config.yaml", CONFIG)
        m.run("sync")
    m.run("ttfboxd --config /disk/config.yaml >/run/daemon 2>&1 & echo $! >/run/daemon.pid")
    code, out = m.run(READY % ("armed next", "armed next"), 200)
    assert code == 0, m.run("cat /run/daemon /run/said")[1]
    return int(out.split("next=")[1].split()[0])


def recorded(m):
    code, out = m.run("grep -c '\"type\":\"slot\"' /disk/data/plan/records.jsonl")
    return int(out.split()[-1]) if code == 0 else 0


def more(m, slots):
    """Waits for so many further records."""
    want = recorded(m) + slots
    code, out = m.run("i=0; while [ $i -lt 900 ] && [ $(grep -c '\"type\":\"slot\"' /disk/data/plan/records.jsonl) -lt %d ]; "
                      "do sleep 0.1; i=$((i+1)); done; cat /run/daemon" % want, 120)
    got = recorded(m)
    assert got >= want, out
    return got


def stop(m):
    """The daemon, as its unit would, and the disk."""
    code, out = m.run("kill $(cat /run/daemon.pid); while kill -0 $(cat /run/daemon.pid) 2>/dev/null; do sleep 0.1; done; cat /run/daemon; umount /disk", 60)
    assert code == 0 and "stopped" in out, out
    m.run("sync")


def expect_grid(summary, interval_ns):
    """Each slot's label lies on the grid of the first, and each that was not captured says why."""
    slots = summary["slots"]
    assert [s["index"] for s in slots] == list(range(len(slots))), [s["index"] for s in slots]
    zero = slots[0]["due_utc_ns"]
    for s in slots:
        assert s["due_utc_ns"] - zero == s["index"] * interval_ns, (s["index"], s["due_utc_ns"] - zero)
        assert s["result"] == "captured" or s.get("reason") or s["result"] == "power", s


def a_box_that_loses_its_power_goes_on_by_itself_on_the_grid(system, share):
    chance = random.Random(1)
    with tempfile.TemporaryDirectory(prefix="ttfbox-boots.", dir="/dev/shm") as folder:
        disk = folder + "/disk"
        subprocess.run(["truncate", "-s", "96M", disk], check=True)
        subprocess.run(["mkfs.ext4", "-q", disk], check=True)
        devices = ["-drive", "file=%s,format=raw,if=none,id=d" % disk, "-device", "virtio-blk-pci,drive=d"]
        had = 0
        for boot in range(BOOTS + 1):
            with Machine(system, share, devices=devices) as m:
                first = start(m, PLAN if boot == 0 else None)
                assert boot == 0 or first > had - 1, (first, had)
                had = more(m, 2)
                if boot < BOOTS:
                    m.run("sleep %.2f" % (chance.random() * INTERVAL_S))
                    had = max(had, recorded(m))
                    m.cut()
                    continue
                stop(m)
        subprocess.run(["e2fsck", "-fy", disk], stdout=subprocess.DEVNULL, check=False)
        subprocess.run(["debugfs", "-R", "rdump /data %s" % folder, disk], stderr=subprocess.DEVNULL, check=True)
        summary = read.Reader(folder + "/data/plan").summary()
    assert summary["exit"] == 0, [f for f in summary["findings"] if f["class"] == "damage"][:3]
    assert len(summary["slots"]) >= had
    expect_grid(summary, INTERVAL_S * 10**9)
    results = [s["result"] for s in summary["slots"]]
    trust = sorted({s["trust"] for s in summary["segments"]})
    print("    %d cuts; %d slots in %d segments (UTC by %s): %s; all on the grid" %
          (BOOTS, len(results), len(summary["segments"]), ", ".join(trust),
           ", ".join("%d %s" % (results.count(r), r) for r in sorted(set(results)))))


SCENARIOS = [a_box_that_loses_its_power_goes_on_by_itself_on_the_grid]
