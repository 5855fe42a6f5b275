# SPDX-License-Identifier: Apache-2.0
"""How many instructions a slot costs the daemon and the guardian: on the machine of cable.py, whose processor takes a nanosecond for each."""
import os
import subprocess
import tempfile

import boots
import camera
import lamps
from cable import Board, must

DISK_MIB = 4096  # as far as it is written: 100 slots of 12 megapixels would have room
SECONDS = 5400  # of the host's, for all
ANSWER_S = 1200  # a slot of 12 megapixels, the simulator's drawing of it included, is 5,000 million instructions
PLAN = "interval: %ds\ncount: 100\nlamps: {mode: capture-only, settle: 150ms}\nshots: [{lamps: {left: 100%%}}]\nkeep: %s\nreserve: 1MB\n"
CONFIG = "board: %s\nplan: /disk/plan.yaml\ndata: /disk/data\ndataset: %s\nset: {%s}\n"
WIDTH = int(os.environ.get("TTFBOX_RIG_WIDTH", "1014"))  # of the simulated camera; 4056 is that of 12 megapixels, and takes so many times longer
HEIGHT = WIDTH * 760 // 1014
SIM = "sim.clock: real, sim.sensor.width: %dpx, sim.sensor.height: %dpx, sim.optics.detail: 1024px, sim.timing.buffers: 2" % (WIDTH, HEIGHT)
VIVID, SIMULATED = "/disk/board.yaml", "/share/sim-small.yaml"
# What it is; board, settings, what is kept; seconds between slots; slots before it is counted, as what is read or made once is no slot's; slots that are counted
RUNS = [("vivid 320x180", VIVID, "", "both", 1, 2, 10),
        ("simulated %dx%d, its world included" % (WIDTH, HEIGHT), SIMULATED, SIM, "raw", 60, 1, 2)]


def spent(m, name):
    """Instructions of all a program's threads so far, the kernel's in its name included; none of its threads ends while it captures."""
    out = must(m, "cat /proc/$(pgrep -x %s)/task/*/schedstat" % name)
    return sum(int(line.split()[0]) for line in out.splitlines()), len(out.splitlines())


def captured(m, name):
    must(m, "kill -0 $(cat /run/daemon.pid) || { cat /run/daemon; false; }", ANSWER_S)
    out = m.run("grep -c '\"result\":\"captured\"' /disk/data/%s/records.jsonl 2>/dev/null" % name, ANSWER_S)[1]
    return int(out or 0)


def until(m, name, slots, interval_s):
    """Asked again and again: many megapixels are many minutes of the host's, of which a single command is not to take all."""
    while (had := captured(m, name)) < slots:
        must(m, "sleep %d; ! grep retry /run/daemon" % interval_s, ANSWER_S)  # a start that is refused is tried again for ever


def count(m, i, run):
    """Millions of instructions a slot: the daemon's, the guardian's."""
    what, board, sets, keep, interval_s, early, slots = run
    name = "run%d" % i
    boots.put(m, "/disk/plan.yaml", PLAN % (interval_s, keep))
    boots.put(m, "/disk/config.yaml", CONFIG % (board, name, sets))
    must(m, "ttfboxd --config /disk/config.yaml >/run/daemon 2>&1 & echo $! >/run/daemon.pid")
    until(m, name, early, interval_s)
    before = [spent(m, program) for program in ("ttfboxd", "ttfbox-lampd")]
    until(m, name, early + slots, interval_s)
    after = [spent(m, program) for program in ("ttfboxd", "ttfbox-lampd")]
    assert [a[1] for a in after] == [b[1] for b in before], (before, after)
    must(m, "kill $(cat /run/daemon.pid); while kill -0 $(cat /run/daemon.pid) 2>/dev/null; do sleep 0.1; done; rm -r /disk/data/%s" % name)
    daemon, guardian = [(a[0] - b[0]) / 1e6 / slots for a, b in zip(after, before)]
    print("    %s, keep %s, a slot each %d s: ttfboxd %.1f, guardian %.2f million instructions a slot" % (what, keep, interval_s, daemon, guardian), flush=True)
    return daemon, guardian


def a_slot_costs_so_many_instructions(system, share):
    with tempfile.TemporaryDirectory(prefix="ttfbox-instructions.") as folder:
        disk = folder + "/disk"
        subprocess.run(["truncate", "-s", "%dM" % DISK_MIB, disk], check=True)
        subprocess.run(["mkfs.ext4", "-q", disk], check=True)
        devices = ["-drive", "file=%s,format=raw,if=none,id=d,cache=unsafe" % disk, "-device", "virtio-blk-pci,drive=d"]
        with Board(system, share, devices, SECONDS) as m:
            must(m, "cp /share/ttfboxd /share/ttfbox-lampd /run/bin/ && mkdir /disk && mount /dev/vda /disk")
            camera.load(m)
            lamps.guard(m, camera.BOARD)
            boots.put(m, VIVID, camera.BOARD)
            for i, run in enumerate(RUNS):
                count(m, i, run)


SCENARIOS = [a_slot_costs_so_many_instructions]
