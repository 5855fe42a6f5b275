#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""powercuts.py [ext4|f2fs] [CASES [SEED]]: power cuts of real file systems under a capture, from one log of its disk.

A capture of SLOTS slots runs in the rig's machine on a disk whose every write and flush is logged; for each slot that it
acknowledges it waits until the log's length is noted. Then the disk is made as of every flush (or every so many), as of
each acknowledgement without what was not flushed then, and as of CASES random moments with that dropped, torn or
reordered. Of each: what a boot does brings the file system to order (filesystems.py), `ttfbox verify` finds nothing
damaged, every acknowledged slot is there and whole. f2fs has to be mounted for that, in a guest, which takes seconds each
time: one of sixteen flushes, and a fifth of the cases.
"""
import bisect
import os
import random
import shutil
import subprocess
import sys
import tempfile
import time

import blocklog
from filesystems import BY_NAME, RUN, command
from machine import Machine

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path.append(ROOT + "/tests/datasets")
import read  # noqa: E402
SLOTS = 200
PARTS = {"ext4": (1, 1), "f2fs": (16, 5)}  # one of how many flushes, and of how many cases
TTFBOX = ROOT + "/build/bin/ttfbox"


class Recording:
    """A capture and what its disk was told meanwhile."""

    def __init__(self, filesystem, system, share, folder, slots=SLOTS):
        self.before, disk, log = folder + "/before", folder + "/disk", folder + "/log"
        command("truncate", "-s", "%dM" % filesystem.disk_mib, disk)
        filesystem.make(disk)
        shutil.copy(disk, self.before)
        open(log, "wb").close()
        self.acknowledged = []  # (index, letter of its result, log's length then)
        devices = ["-blockdev", "driver=file,filename=%s,node-name=f" % disk,
                   "-blockdev", "driver=raw,file=f,node-name=base",
                   "-blockdev", "driver=file,filename=%s,node-name=l" % log,
                   "-blockdev", "driver=blklogwrites,node-name=lw,file=base,log=l",
                   "-device", "virtio-blk-pci,drive=lw,write-cache=on"]
        with Machine(system, share, devices=devices) as m:
            code, out = m.run(filesystem.mount)
            assert code == 0, out
            port = m.begin_with_port("capture_child /disk/%s 0 %d waits" % (RUN, slots))
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

    def acknowledgements(self):
        """Of each slot: its index, and how many entries the log had when it was said to be safe."""
        ends = [e.end for e in self.entries]
        return [(index, bisect.bisect_right(ends, length)) for index, _, length in self.acknowledged]


LETTERS = {"captured": "c", "partial": "p", "missed": "m", "failed": "f", "paused": "z", "power": "w"}


def judge(filesystem, folder, disk, owed):
    """None, or what is wrong with what a cut left."""
    out = folder + "/out"
    shutil.rmtree(out, ignore_errors=True)
    os.mkdir(out)
    wrong = filesystem.fetch(disk, out)
    if wrong:
        return wrong
    dataset = out + "/" + RUN
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


def replay(filesystem, recording, folder, every, cases, seed):
    """Judges the disk at every so many flushes, at each acknowledgement, and at random moments. Count."""
    count = Count()

    def add(what, until, disk):
        owed = recording.owed(until)
        count.add(what, judge(filesystem, folder, disk, owed), owed)

    replaying = blocklog.Replay(recording.before, recording.entries)
    for until in recording.flushes[::every]:
        replaying.to(until)
        add("flush %d" % until, until, replaying.disk)
    # Whatever was not flushed at the moment when a slot was said to be safe is gone.
    replaying = blocklog.Replay(recording.before, recording.entries)
    for index, until in recording.acknowledgements():
        replaying.to(until)
        add("the acknowledgement of slot %d" % index, until, replaying.disk)
    replaying = blocklog.Replay(recording.before, recording.entries)
    chance = random.Random(seed)
    moments = sorted(chance.randrange(1, len(recording.entries) + 1) for _ in range(cases))
    for until in moments:
        replaying.to(until)
        disk, counts = replaying.cut(chance, filesystem.whole)
        add("entry %d of seed %d (%s)" % (until, seed, counts), until, disk)
    return count


def run(name, system, share, every, cases, seed, slots=SLOTS):
    """Records and replays on a file system; what was wrong, and a line of figures."""
    if not os.path.exists(TTFBOX):
        raise RuntimeError("build first: %s is not there" % TTFBOX)
    with tempfile.TemporaryDirectory(prefix="ttfbox-cuts.", dir="/dev/shm") as folder:
        shutil.copy(TTFBOX, folder)  # it may be built anew meanwhile
        before = time.monotonic()
        filesystem = BY_NAME[name](system, folder)
        recording = Recording(filesystem, system, share, folder, slots)
        took = time.monotonic() - before
        try:
            count = replay(filesystem, recording, folder, every, cases, seed)
        finally:
            filesystem.close()
    line = ("%s: %d writes and %d flushes of %d slots, logged in %.0f s; %d cuts at flushes, %d at acknowledgements and %d at random "
            "(seed %d), %d wrong" % (name, len(recording.entries) - len(recording.flushes), len(recording.flushes), slots, took,
                                     count.cases - cases - slots, slots, cases, seed, len(count.wrong)))
    return count.wrong, line


def no_power_cut_loses_what_was_acknowledged(system, share):
    """A part of what `./dev powercuts` does in full."""
    wrong, line = run("ext4", system, share, every=8, cases=60, seed=1, slots=40)
    print("    " + line)
    assert not wrong, wrong


def no_power_cut_loses_what_was_acknowledged_on_f2fs(system, share):
    wrong, line = run("f2fs", system, share, every=16, cases=30, seed=1, slots=20)
    print("    " + line)
    assert not wrong, wrong


SCENARIOS = [no_power_cut_loses_what_was_acknowledged, no_power_cut_loses_what_was_acknowledged_on_f2fs]


def main():
    import rig  # sets up the machine's files
    words = sys.argv[1:]
    names = [words.pop(0)] if words and words[0] in BY_NAME else list(BY_NAME)
    cases = int(words[0]) if words else 2000
    seed = int(words[1]) if len(words) > 1 else 1
    share = rig.prepare(None)
    failed = 0
    for name in names:
        every, part = PARTS[name]
        wrong, line = run(name, rig.RIG + "/system", share, every, -(-cases // part), seed)
        print(line, flush=True)
        failed += bool(wrong)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
