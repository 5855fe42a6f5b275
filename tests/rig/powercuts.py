#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""powercuts.py [CASES [SEED]]: power cuts of a real file system under a capture, from one log of its disk.

A capture of SLOTS slots runs in the rig's machine on ext4 on a disk whose every write and flush is logged; for each slot
that it acknowledges it waits until the log's length is noted. Then, without booting again: the disk as of every flush
(or every so many), and as of CASES random moments with what was not flushed dropped, torn or reordered. Of each: e2fsck
repairs what a journal repairs, `ttfbox verify` finds nothing damaged, every acknowledged slot is there and whole.
"""
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time

import blocklog
from machine import Machine

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path.append(ROOT + "/tests/datasets")
import read  # noqa: E402
SLOTS = 200
DISK_MIB = 24
TTFBOX = ROOT + "/build/bin/ttfbox"


def command(*words, allowed=(0,)):
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    if done.returncode not in allowed:
        raise RuntimeError("%s: exit %d: %s" % (words[0], done.returncode, done.stdout.decode(errors="replace")[-600:]))
    return done.returncode, done.stdout.decode(errors="replace")


class Recording:
    """A capture and what its disk was told meanwhile."""

    def __init__(self, system, share, folder, slots=SLOTS):
        self.before, disk, log = folder + "/before", folder + "/disk", folder + "/log"
        command("truncate", "-s", "%dM" % DISK_MIB, disk)
        command("mkfs.ext4", "-q", "-e", "remount-ro", "-E", "lazy_itable_init=0,lazy_journal_init=0", disk)
        shutil.copy(disk, self.before)
        open(log, "wb").close()
        self.acknowledged = []  # (index, letter of its result, log's length then)
        devices = ["-blockdev", "driver=file,filename=%s,node-name=f" % disk,
                   "-blockdev", "driver=raw,file=f,node-name=base",
                   "-blockdev", "driver=file,filename=%s,node-name=l" % log,
                   "-blockdev", "driver=blklogwrites,node-name=lw,file=base,log=l",
                   "-device", "virtio-blk-pci,drive=lw,write-cache=on"]
        with Machine(system, share, devices=devices) as m:
            code, out = m.run("mkdir -p /disk && mount -o errors=remount-ro /dev/vda /disk")
            assert code == 0, out
            port = m.begin_with_port("capture_child /disk/run 0 %d waits" % slots)
            for line in port.makefile("r"):
                index, _, result = line.split()
                self.acknowledged.append((int(index), result, os.path.getsize(log)))
                port.sendall(b"\n")
                if len(self.acknowledged) == slots:
                    break
            code, out = m.end(120)
            assert code == 0, out
            code, out = m.run("umount /disk")
            assert code == 0, out
            m.ask("quit")
            m.process.wait(30)
        self.entries = blocklog.read(log)
        self.flushes = [i + 1 for i, e in enumerate(self.entries) if e.flags & blocklog.FLUSH]

    def owed(self, until):
        """The slots that were acknowledged before this entry of the log: {index: letter}."""
        end = self.entries[until - 1].end if until else 0
        return {index: result for index, result, length in self.acknowledged if length <= end}


LETTERS = {"captured": "c", "partial": "p", "missed": "m", "failed": "f", "paused": "z", "power": "w"}


def judge(folder, disk, owed):
    """None, or what is wrong with what a cut left."""
    image, out = folder + "/cut", folder + "/out"
    with open(image, "wb") as f:
        f.write(disk)
    code, said = command("e2fsck", "-fy", image, allowed=range(256))
    if code > 2:
        return "e2fsck: exit %d: %s" % (code, said[-400:])
    shutil.rmtree(out, ignore_errors=True)
    os.mkdir(out)
    command("debugfs", "-R", "rdump /run %s" % out, image)
    dataset = out + "/run"
    if not owed and not os.path.exists(dataset + "/dataset.json"):
        return None  # the capture had hardly begun
    done = subprocess.run([folder + "/ttfbox", "verify", dataset, "--json", "-q"], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          check=False)
    if done.returncode != 0:
        return "verify: exit %d: %s" % (done.returncode, done.stdout.decode(errors="replace")[-600:])
    # A second opinion: the reader that was written from FORMAT.md alone.
    summary = read.Reader(dataset).summary()
    if summary["exit"] != 0:
        return "read.py: %s" % [f for f in summary["findings"] if f["class"] == "damage"][:3]
    there = {slot["index"]: LETTERS[slot["result"]] for slot in summary["slots"]}
    lost = [k for k, letter in owed.items() if there.get(k) != letter]
    return "acknowledged slots %s are lost" % lost[:10] if lost else None


class Count:
    def __init__(self):
        self.cases, self.wrong, self.owed = 0, [], 0

    def add(self, what, wrong, owed):
        self.cases += 1
        if self.cases % 500 == 0:
            print("    %d cuts judged" % self.cases, flush=True)
        self.owed = max(self.owed, len(owed))
        if wrong:
            self.wrong.append("%s: %s" % (what, wrong))
            print("    FAILED at %s: %s" % (what, wrong), flush=True)


def replay(recording, folder, every, cases, seed):
    """Judges the disk at every so many flushes, and at random moments. Count."""
    count = Count()
    replaying = blocklog.Replay(recording.before, recording.entries)
    for until in recording.flushes[::every]:
        replaying.to(until)
        owed = recording.owed(until)
        count.add("flush %d" % until, judge(folder, replaying.disk, owed), owed)
    replaying = blocklog.Replay(recording.before, recording.entries)
    chance = random.Random(seed)
    moments = sorted(chance.randrange(1, len(recording.entries) + 1) for _ in range(cases))
    for until in moments:
        replaying.to(until)
        owed = recording.owed(until)
        disk, counts = replaying.cut(chance)
        count.add("entry %d of seed %d (%s)" % (until, seed, counts), judge(folder, disk, owed), owed)
    return count


def run(system, share, every, cases, seed, slots=SLOTS):
    """Records and replays; what was wrong, and a line of figures."""
    if not os.path.exists(TTFBOX):
        raise RuntimeError("build first: %s is not there" % TTFBOX)
    with tempfile.TemporaryDirectory(prefix="ttfbox-cuts.", dir="/dev/shm") as folder:
        shutil.copy(TTFBOX, folder)  # it may be built anew meanwhile
        before = time.monotonic()
        recording = Recording(system, share, folder, slots)
        took = time.monotonic() - before
        count = replay(recording, folder, every, cases, seed)
    line = ("%d writes and %d flushes of %d slots, logged in %.0f s; %d cuts at flushes and %d at random (seed %d), "
            "%d wrong" % (len(recording.entries) - len(recording.flushes), len(recording.flushes), slots, took,
                          count.cases - cases, cases, seed, len(count.wrong)))
    return count.wrong, line


def no_power_cut_loses_what_was_acknowledged(system, share):
    """A part of what `./dev powercuts` does in full."""
    wrong, line = run(system, share, every=8, cases=60, seed=1, slots=40)
    print("    " + line)
    assert not wrong, wrong


SCENARIOS = [no_power_cut_loses_what_was_acknowledged]


def main():
    import rig  # sets up the machine's files
    cases = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 1
    share = rig.prepare(None)
    wrong, line = run(rig.RIG + "/system", share, 1, cases, seed)
    print(line)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
