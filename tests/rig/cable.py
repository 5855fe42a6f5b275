# SPDX-License-Identifier: Apache-2.0
"""A box and a PC in one guest, and the kernel's dummy_hcd as the cable between them: what the scenarios of usb.py stand on."""
import os
import random
import re
import subprocess

from machine import Machine

HERE = os.path.dirname(os.path.abspath(__file__))
TTFBOX = os.path.dirname(os.path.dirname(HERE)) + "/build/bin/ttfbox"
PLAN = """interval: 1h
count: %d
lamps: {mode: continuous}
shots:
  - {stream: main, channel: white, lamps: {left: 100%%, right: 100%%}, exposure: 20ms}
keep: both
mains: 50Hz
"""
# Asked again: while udevd's files are read from the host, the guest's clock leaps over any time limit (Board).
UDEV = ("mkdir -p /run/udev; /lib/systemd/systemd-udevd --daemon; udevadm trigger --type=devices --action=add "
        "--subsystem-match=usb; i=0; until udevadm settle -t 20; do i=$((i+1)); [ $i -lt 20 ] || exit 1; done")
GADGET = "/sys/kernel/config/usb_gadget/ttfbox"
UDC = GADGET + "/UDC"
FRAME = "/sys/module/rig_cable/parameters/frame_bytes"
WHOLE_FRAME = 512 * 13 * 8  # bytes of a millisecond at high speed
BOX, PC = "/run/http.sock", "unix:/run/pc"
FILES = "/datasets/grass/files/"


PROGRAMS = ["ttfbox", "ttfbox-full", "ttfbox-usbd", "ttfbox-gadget", "rig_usb", "rig_uvc", "rig_camera"]


class Board(Machine):
    """Whose processor takes a nanosecond for each instruction by its own clock, and no time of the host's for waiting: a time in the guest says what
    the programs do there, and not what else this machine has to do. When the guest waits for the host, its clock leaps to the next timer; so
    programs and libraries are in its memory before anything is timed."""

    def __init__(self, system, share, devices=(), seconds=1800):
        super().__init__(system, share, seconds, ["-icount", "shift=0,sleep=off", "-m", "1024"] + list(devices))

    def meet(self):
        super().meet()
        must(self, "mkdir /run/bin && cd /share && cp %s /run/bin/ && cat $(ldd ttfbox-full rig_usb rig_camera | grep -o '/[^ :]*') >/dev/null" %
             " ".join(PROGRAMS))

    def begin(self, command):
        super().begin("PATH=/run/bin:$PATH; " + command)


def must(m, command, seconds=120):
    code, out = m.run(command, seconds)
    assert code == 0, "%s: %s" % (command, out)
    return out


def wait(m, command, what, seconds=20):
    """Until a command succeeds, for so many seconds of the guest."""
    code, out = m.run("u=$(($(cut -d. -f1 /proc/uptime) + %d)); while ! { %s; }; do [ $(cut -d. -f1 /proc/uptime) -lt $u ] || exit 1; sleep 0.1; done" %
                      (seconds, command), 20 * seconds + 60)
    assert code == 0, "%s: %s %s" % (what, out, m.run("tail -n 5 /run/usbd /run/bridge /run/serve; dmesg | tail -n 20")[1])


def figure(text):
    """The number of a line that rig_usb printed last."""
    return float(text.split()[-2])


# ---- what there is to be pulled, made here: the emulated processor would take minutes for it


def dataset(m, slots=4, width=480, height=320):
    """A captured and sealed one in the guest, /tmp/data/grass; its bytes."""
    made = m.share + "/data"
    with open(m.share + "/plan.yaml", "w", encoding="ascii") as f:
        f.write(PLAN % slots)
    subprocess.run(["rm", "-rf", made], check=True)
    subprocess.run([TTFBOX, "capture", "-q", m.share + "/plan.yaml", "--board", m.share + "/sim-small.yaml", "--set", "sim.sensor.width=%dpx" % width,
                    "--set", "sim.sensor.height=%dpx" % height, "-o", made + "/grass"], check=True, stdout=subprocess.DEVNULL)
    must(m, "mount -o remount,size=600m /tmp && cp -r /share/data /tmp/", 300)
    return sum(os.path.getsize(base + "/" + name) for base, _, names in os.walk(made) for name in names)


def beside(m, name, bytes_):
    """A file in the dataset's folder that is not of it."""
    with open(m.share + "/" + name, "wb") as f:
        f.write(bytes_)
    must(m, "cp /share/%s /tmp/data/grass/" % name, 300)


def noise(n, seed=1):
    return random.Random(seed).randbytes(n)


# ---- the parts


def ready(log, what):
    """Until a program that was started into the background has said so."""
    return ("i=0; while [ $i -lt 300 ] && ! grep -q '%s' %s; do sleep 0.1; i=$((i+1)); done; cat %s; grep -q '%s' %s" %
            (what, log, log, what, log))


def plug(m, box_end=None):
    """The gadget, bound, and what serves it. Its address on the cable's network, and both ends' in it."""
    must(m, "ip link set lo up && { lsmod | grep -q rig_cable || { modprobe rig-cable && %s; }; }" % UDEV)
    out = must(m, "ttfbox-gadget --serial RIG7 --owner 0 compose")
    must(m, box_end or "ttfbox-usbd --server %s >/run/usbd 2>&1 & %s" % (BOX, ready("/run/usbd", "ready")))
    must(m, "ttfbox-gadget bind")
    wait(m, "ttfbox usb list | grep -q RIG7", "no box appears at USB")
    return re.search(r"network ([0-9.]+)/29, addresses ([0-9a-f:]+) \(box\) and ([0-9a-f:]+)", out).groups()


def serve(m):
    must(m, "ttfbox serve /tmp/data --listen unix:%s >/run/serve 2>&1 & %s" % (BOX, ready("/run/serve", "serving")))


def bridge(m):
    """A program at the PC that has the box; milliseconds from when it could be asked to its first right status."""
    out = must(m, "rm -f /run/pc; ttfbox usb --listen %s >/run/bridge 2>&1 & echo $! >/run/bridge.pid; rig_usb status %s || { cat /run/bridge; false; }" % (PC, PC))
    return figure(out)


def end_bridge(m):
    must(m, "P=$(cat /run/bridge.pid); kill $P; while kill -0 $P 2>/dev/null; do sleep 0.05; done")


def network(m, address, box, pc):
    """The box's end in a network of its own, so that what passes really crosses the cable."""
    interface = "$(grep -l %s /sys/class/net/*/address | cut -d/ -f5)"
    must(m, "ip netns add box && ip link set %s netns box" % (interface % box))
    wait(m, "grep -q %s /sys/class/net/*/address" % pc, "the PC has no such network")
    other = address.rsplit(".", 1)[0] + "." + str(int(address.rsplit(".", 1)[1]) + 1)
    must(m, "D=$(ip netns exec box ls /sys/class/net | grep -v lo); H=%s; "
            "ip -n box addr add %s/29 dev $D && ip -n box link set lo up && ip -n box link set $D up && "
            "ip addr add %s/29 dev $H && ip link set $H up" % (interface % pc, address, other))
    # In some first binds the PC's end stays without carrier until the box's has been down.
    code, _ = m.run("sleep 2; [ $(cat /sys/class/net/%s/carrier) = 1 ]" % (interface % pc))
    if code != 0:
        must(m, "D=$(ip netns exec box ls /sys/class/net | grep -v lo); ip -n box link set $D down; ip -n box link set $D up")
    must(m, "ip netns exec box ttfbox serve /tmp/data --listen %s:8417 >/run/tcp 2>&1 & %s" % (address, ready("/run/tcp", "serving")))
