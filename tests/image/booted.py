# SPDX-License-Identifier: Apache-2.0
"""An image of firmware/image, booted as it is: a copy with an agent of the tests put into its root, and nothing else changed."""
import os
import subprocess
import sys

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
sys.path.append(ROOT + "/tests/rig")
import machine  # noqa: E402

BOOT_START, ROOT_START, DATA_START = 2048 * 512, (2048 + 256 * 2048) * 512, 4194304 * 512
AGENT_UNIT = """[Unit]
DefaultDependencies=no
IgnoreOnIsolate=yes
[Service]
ExecStartPre=/bin/sh -c 'modprobe virtio_console; while ! [ -e /dev/hvc0 ]; do sleep 0.2; done'
ExecStart=/usr/local/sbin/rig-agent
OOMScoreAdjust=-1000
"""
FIRMWARE = {"arm64": "/usr/share/qemu-efi-aarch64/QEMU_EFI.fd", "amd64": "/usr/share/ovmf/OVMF.fd"}


def copy(board, to, programs=()):
    """A copy of the board's image, in which the tests can run commands."""
    subprocess.run(["cp", "--sparse=always", ROOT + "/build-image/%s.img" % board, to], check=True)
    unit = to + ".unit"
    with open(unit, "w") as f:
        f.write(AGENT_UNIT)
    wants = "/etc/systemd/system/sysinit.target.wants"
    files = [(ROOT + "/tests/rig/guest/agent", "/usr/local/sbin/rig-agent")]
    files += [(p, "/usr/local/bin/" + os.path.basename(p)) for p in programs]
    script = "mkdir %s\nwrite %s /etc/systemd/system/rig-agent.service\n" % (wants, unit)
    script += "symlink %s/rig-agent.service /etc/systemd/system/rig-agent.service\n" % wants
    for source, target in files:
        script += "write %s %s\nsif %s mode 0100755\n" % (source, target, target)
    subprocess.run(["debugfs", "-w", "-f", "-", "%s?offset=%d" % (to, ROOT_START)], input=script.encode(), check=True,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    os.unlink(unit)


def boot_partition(image):
    return "%s@@%d" % (image, BOOT_START)


def put(image, name, text):
    """A file of the boot partition, as a person with a card reader writes it."""
    folders = name.split("/")[:-1]
    for depth in range(len(folders)):
        subprocess.run(["mmd", "-D", "s", "-i", boot_partition(image), "::" + "/".join(folders[:depth + 1])], check=False,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    subprocess.run(["mcopy", "-o", "-i", boot_partition(image), "-", "::" + name], input=text.encode(), check=True)


def get(image, name):
    """The same, read; None if it is not there."""
    done = subprocess.run(["mtype", "-i", boot_partition(image), "::" + name], stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, check=False)
    return done.stdout.decode() if done.returncode == 0 else None


def take_out(image, inside, to):
    """A folder of the data partition."""
    data = "%s?offset=%d" % (image, DATA_START)
    # What the last mount left in the journal is brought to the file system first, as the next boot would.
    subprocess.run(["e2fsck", "-fy", data], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, check=False)
    subprocess.run(["debugfs", "-R", "rdump %s %s" % (inside, to), data], stdout=subprocess.DEVNULL,
                   stderr=subprocess.DEVNULL, check=True)


class Booted(machine.Machine):
    """A machine with the image as its one disk."""

    ready_s = 400

    def __init__(self, image, arch="arm64", memory=512, seconds=3000):
        super().__init__(None, None, seconds)
        self.image, self.arch, self.memory = image, arch, memory

    def boots(self, words):
        kind = ["qemu-system-aarch64", "-accel", "tcg", "-M", "virt,acpi=off", "-cpu", "cortex-a53"]
        if self.arch == "amd64":
            kind = ["qemu-system-x86_64", "-accel", "tcg", "-M", "q35", "-cpu", "qemu64"]
        return kind + ["-m", str(self.memory), "-bios", FIRMWARE[self.arch], "-device", "virtio-rng-pci",
                       "-drive", "file=%s,format=raw,if=none,id=d" % self.image, "-device", "virtio-blk-pci,drive=d"]

    def off(self):
        """As a person turns it off in good order."""
        self.begin("systemctl poweroff")
        self.process.wait(200)

    def wait(self, condition, seconds=120):
        """Until a shell's condition holds; its output in the end."""
        code, out = self.run("end=$(($(date +%%s) + %d)); while [ $(date +%%s) -lt $end ] && ! { %s; } >/dev/null 2>&1; do "
                             "sleep 0.5; done; %s" % (seconds, condition, condition), seconds + 60)
        assert code == 0, (condition, out, self.journal())
        return out

    def journal(self):
        return self.run("journalctl -b --no-pager -o short-monotonic | grep -v kernel: | tail -n 60", 120)[1]
