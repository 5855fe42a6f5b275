# SPDX-License-Identifier: Apache-2.0
"""File systems whose power is cut (powercuts.py): how one is made, how it is brought to order after a cut as a boot does
it, and its files fetched."""
import os
import shutil
import subprocess

from machine import Machine

RUN = "run"  # the dataset's folder


def command(*words, allowed=(0,)):
    done = subprocess.run(words, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
    if done.returncode not in allowed:
        raise RuntimeError("%s: exit %d: %s" % (words[0], done.returncode, done.stdout.decode(errors="replace")[-600:]))
    return done.returncode, done.stdout.decode(errors="replace")


class Ext4:
    """Read on this machine, without mounting it."""

    disk_mib = 24
    whole = 512  # bytes that a cut leaves old or new and never half: any disk's least

    def __init__(self, system, folder):
        self.folder = folder

    @staticmethod
    def make(disk):
        command("mkfs.ext4", "-q", "-e", "remount-ro", "-E", "lazy_itable_init=0,lazy_journal_init=0", disk)

    mount = "mkdir -p /disk && mount -o errors=remount-ro /dev/vda /disk"

    def fetch(self, disk, out):
        """None, or what is wrong with the file system itself."""
        image = self.folder + "/cut"
        with open(image, "wb") as f:
            f.write(disk)
        code, said = command("e2fsck", "-fy", image, allowed=range(256))
        if code > 2:
            return "e2fsck: exit %d: %s" % (code, said[-400:])
        command("debugfs", "-R", "rdump /%s %s" % (RUN, out), image)
        return None

    def close(self):
        pass


class F2fs:
    """Nothing but a kernel reads it, which at mounting rolls forward what was synced after the last checkpoint: so a guest is
    lent one disk, on which one cut after the other is put."""

    disk_mib = 64
    whole = 4096  # its blocks, of which many have no checksum: it asks for disks that write those whole

    def __init__(self, system, folder):
        self.system, self.folder = system, folder
        self.image, self.files = folder + "/cut", folder + "/files"
        self.guest = None

    @staticmethod
    def make(disk):
        command("mkfs.f2fs", "-q", disk)

    mount = "mkdir -p /disk && mount -t f2fs /dev/vda /disk"

    def start(self):
        """The guest leaves what it fetched in the folder that it is lent."""
        os.makedirs(self.files, exist_ok=True)
        devices = ["-drive", "file=%s,format=raw,if=none,id=cut,cache=writeback" % self.image, "-device", "virtio-blk-pci,drive=cut"]
        self.guest = Machine(self.system, self.files, seconds=86400, devices=devices)
        self.guest.__enter__()
        code, out = self.guest.run("mkdir /cut && modprobe f2fs")
        assert code == 0, out

    def put(self, disk):
        with open(self.image, "r+b" if os.path.exists(self.image) else "wb") as f:
            f.write(disk)

    # As a boot does it.
    LOOK = ("blockdev --flushbufs /dev/vda; fsck.f2fs -a /dev/vda >/tmp/said 2>&1 || { tail -n 5 /tmp/said; exit 1; }; "
            "mount -t f2fs /dev/vda /cut || { dmesg | tail -n 5; exit 2; }; r=0; "
            "[ ! -e /cut/RUN ] || tar -c -f /share/tar -C /cut RUN || r=3; umount /cut || r=4; exit $r").replace("RUN", RUN)

    def fetch(self, disk, out):
        tar = self.files + "/tar"
        if os.path.exists(tar):
            os.unlink(tar)
        self.put(disk)
        if self.guest is None:
            self.start()
        try:
            code, said = self.guest.run(self.LOOK, 120)
        except (RuntimeError, OSError) as e:  # the next cut has a guest of its own
            self.close()
            return "the guest: %s" % e
        if code != 0:
            return "%s: %s" % ({1: "fsck -a", 2: "mount", 3: "reading", 4: "umount"}.get(code, code), said[-1200:])
        # Brought to order, the whole of it has to be in order.
        code, said = command("fsck.f2fs", "-f", "--dry-run", self.image, allowed=range(256))
        if code != 0 or "[Fail]" in said:
            return "fsck: exit %d: %s" % (code, [line for line in said.split("\n") if "ASSERT" in line or "Fail" in line][:10])
        if os.path.exists(tar):
            command("tar", "-x", "-f", tar, "-C", out)
        return None

    def close(self):
        if self.guest is not None:
            self.guest.__exit__()
            self.guest = None


BY_NAME = {"ext4": Ext4, "f2fs": F2fs}
