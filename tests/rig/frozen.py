# SPDX-License-Identifier: Apache-2.0
"""A machine that was booted once and frozen: each scenario thaws it, which takes a second where a boot takes ten."""
import hashlib
import os
import shutil
import subprocess
import time

from machine import Machine

# What is loaded before it is frozen; scenarios that load a module anew still can.
WARM = "modprobe vivid n_devs=1 node_types=0x1 num_inputs=1 input_types=0x00; modprobe gpio-sim 2>/dev/null; ls /dev/video0 /dev/gpiochip0"
NAME = "warm"


class Frozen(Machine):
    """On disks of its own, as a frozen machine may hold nothing of the host's; thawed unless make is set."""

    def __init__(self, rig, folder, make=False):
        super().__init__(rig, None)
        self.disks, self.make = folder, make

    def lent(self):
        # The last one holds the frozen machine's memory; no guest looks at it. One is thawed at a time.
        disks = ["root.img,format=raw,readonly=on", "share.img,format=raw,readonly=on", "state.qcow2,format=qcow2"]
        words = []
        for i, disk in enumerate(disks):
            words += ["-drive", "file=%s/%s,if=none,id=d%d" % (self.disks, disk, i), "-device", "virtio-blk-pci,drive=d%d" % i]
        return words + ([] if self.make else ["-loadvm", NAME])

    def __enter__(self):
        self.power_on(" rig.disk")
        return self

    def meet(self):
        if self.make:
            super().meet()
            return
        self.talk_to_monitor()
        self.agent = self.connect("agent")
        self.ask("cont")
        # Its clock stands where it was frozen.
        code, out = self.run("date -s @%d >/dev/null" % int(time.time()))
        assert code == 0, out

    def freeze(self):
        code, out = self.run(WARM)
        assert code == 0, out
        self.ask("stop")
        said = self.ask("human-monitor-command", **{"command-line": "savevm " + NAME})
        assert not said.strip(), said


def disk_of(folder, image):
    """A read-only file system of what lies in a folder."""
    kb = int(subprocess.run(["du", "-sk", folder], stdout=subprocess.PIPE, check=True).stdout.split()[0])
    subprocess.run(["mke2fs", "-q", "-F", "-t", "ext4", "-O", "^has_journal", "-m", "0", "-d", folder, image,
                    "%dk" % (kb * 5 // 4 + 16384)], check=True, stdout=subprocess.DEVNULL)


def stamp_of(system, share):
    whole = hashlib.sha256()
    with open(system + "/stamp", "rb") as f:
        whole.update(f.read())
    extra = os.path.dirname(system) + "/modules/stamp"
    for path in [extra, os.path.abspath(__file__)] + [share + "/" + n for n in sorted(os.listdir(share))]:
        if os.path.exists(path):
            with open(path, "rb") as f:
                whole.update(f.read())
    return whole.hexdigest()


def prepare(system, share, folder):
    """Boots and freezes one, unless that is done already for the same system and programs."""
    stamp = stamp_of(system, share)
    if os.path.exists(folder + "/stamp"):
        with open(folder + "/stamp") as f:
            if f.read() == stamp:
                return
    shutil.rmtree(folder, ignore_errors=True)
    os.makedirs(folder)
    disk_of(system + "/tree", folder + "/root.img")
    disk_of(share, folder + "/share.img")
    subprocess.run(["qemu-img", "create", "-q", "-f", "qcow2", folder + "/state.qcow2", "2G"], check=True)
    with Frozen(system, folder, make=True) as machine:
        machine.freeze()
    with open(folder + "/stamp", "w") as f:
        f.write(stamp)
