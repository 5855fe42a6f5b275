# SPDX-License-Identifier: Apache-2.0
"""A box at the USB of a PC: both are the guest, and the kernel's dummy_hcd is the cable. ttfbox-gadget composes and binds,
ttfbox-usbd serves by FunctionFS, ttfbox pulls by libusb, and a network runs beside it."""
import re
import time

KILLS = 3
UNPLUGS = 3
PLAN = ("interval: 1h\\ncount: 4\\nlamps: {mode: continuous}\\nshots:\\n  - {stream: main, channel: white, "
        "lamps: {left: 100%, right: 100%}, exposure: 20ms}\\nkeep: both\\nmains: 50Hz\\n")
UDEV = ("mkdir -p /run/udev; /lib/systemd/systemd-udevd --daemon; udevadm trigger --type=devices --action=add "
        "--subsystem-match=usb; udevadm settle -t 20")
# By a shell: a bare machine has no client that is up to it.
GET = ("timeout %d bash -c 'exec 3<>/dev/tcp/%s/%d && printf \"GET %s HTTP/1.1\\r\\nHost: localhost\\r\\nConnection: close\\r\\n\\r\\n\" >&3 && "
       "cat <&3'")
HEALTH = "/api/v1/health"
LARGE = "/api/v1/datasets/grass/files/large"
UDC = "/sys/kernel/config/usb_gadget/ttfbox/UDC"


def must(m, command, seconds=60):
    code, out = m.run(command, seconds)
    assert code == 0, "%s: %s" % (command, out)
    return out


def wait(m, command, what, seconds=20):
    """Until a command succeeds in the guest."""
    code, out = m.run("u=$(($(cut -d. -f1 /proc/uptime) + %d)); while ! { %s; }; do [ $(cut -d. -f1 /proc/uptime) -lt $u ] || exit 1; sleep 0.1; done" %
                      (seconds, command), 4 * seconds + 20)
    assert code == 0, "%s: %s %s" % (what, out, m.run("tail -n 5 /run/usbd /run/bridge /run/serve; dmesg | tail -n 20")[1])


def plug(m):
    """A box with a dataset, its server, and its gadget, bound. Its address on the cable's network."""
    must(m, "ip link set lo up && modprobe dummy_hcd && " + UDEV, 90)
    must(m, "mount -o remount,size=450m /tmp && mkdir -p /tmp/data && printf '%s' >/tmp/plan.yaml && ttfbox capture /tmp/plan.yaml --board /share/sim-small.yaml "
            "--set sim.sensor.width=480px --set sim.sensor.height=320px -o /tmp/data/grass >/run/capture 2>&1 || "
            "{ cat /run/capture; false; }" % PLAN.replace("%", "%%"), 180)
    must(m, "ttfbox serve /tmp/data --listen unix:/run/http.sock >/run/serve 2>&1 & "
            "i=0; while [ $i -lt 100 ] && [ ! -S /run/http.sock ]; do sleep 0.1; i=$((i+1)); done; [ -S /run/http.sock ]")
    out = must(m, "ttfbox-gadget --serial RIG7 --owner 0 compose")
    must(m, "ttfbox-usbd --server /run/http.sock >/run/usbd 2>&1 & "
            "i=0; while [ $i -lt 100 ] && ! grep -q ready /run/usbd; do sleep 0.1; i=$((i+1)); done; cat /run/usbd; grep -q ready /run/usbd")
    must(m, "ttfbox-gadget bind")
    wait(m, "ttfbox usb list | grep -q RIG7", "no box appears at USB")
    return re.search(r"network ([0-9.]+)/29, addresses ([0-9a-f:]+) \(box\) and ([0-9a-f:]+)", out).groups()


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
    must(m, "ip netns exec box ttfbox serve /tmp/data --listen %s:8417 >/run/tcp 2>&1 & "
            "i=0; while [ $i -lt 100 ] && ! grep -q serving /run/tcp; do sleep 0.1; i=$((i+1)); done; cat /run/tcp; grep -q serving /run/tcp" % address)


def bridge(m, port):
    """A program at the PC that has the box."""
    must(m, "ttfbox usb --listen 127.0.0.1:%d >/run/bridge 2>&1 & echo $! >/run/bridge.pid; "
            "i=0; while [ $i -lt 100 ] && ! grep -q 'is there' /run/bridge; do sleep 0.1; i=$((i+1)); done; "
            "cat /run/bridge; grep -q 'is there' /run/bridge" % port)


def get(m, address, port):
    """The status, of the server there."""
    out = must(m, GET % (10, address, port, HEALTH))
    assert '"ok":true' in out, out


def a_box_at_usb_is_pulled_beside_its_network(m):
    address, box, pc = plug(m)
    must(m, "for i in /sys/bus/usb/devices/*:*; do echo $(cat $i/bInterfaceClass); done | grep -q ff")
    must(m, "ttfbox pull /tmp/here --usb", 120)
    must(m, "busybox diff -r /tmp/data/grass /tmp/here/grass && ttfbox verify /tmp/here/grass")
    code, out = m.run("ttfbox pull /tmp/other --box usb:NOBODY")
    assert code != 0 and "no box of serial 'NOBODY'" in out, out
    network(m, address, box, pc)
    get(m, address, 8417)
    number = must(m, "cat /sys/bus/usb/devices/1-1/devnum")
    bridge(m, 8418)
    for _ in range(KILLS):
        must(m, "kill -9 $(pgrep -P $(pgrep -o -x ttfbox-usbd))")
        get(m, address, 8417)
        wait(m, GET % (2, "127.0.0.1", 8418, HEALTH) + " | grep -q true", "no status over the streams", 10)
    assert must(m, "cat /sys/bus/usb/devices/1-1/devnum") == number, "the box was enumerated anew"
    must(m, "kill $(cat /run/bridge.pid); wait $(cat /run/bridge.pid); ttfbox pull /tmp/again --usb && busybox diff -r /tmp/data/grass /tmp/again/grass", 120)


def a_box_is_unplugged_while_it_is_pulled(m):
    plug(m)
    for i in range(UNPLUGS):
        must(m, "ttfbox pull /tmp/here%d --usb --follow >/run/pull 2>&1 & sleep 0.%d; echo '' >%s; sleep 0.3; "
                "ttfbox-gadget bind; wait $!; r=$?; cat /run/pull; [ $r = 0 ]" % (i, 2 + 3 * i, UDC), 120)
        must(m, "busybox diff -r /tmp/data/grass /tmp/here%d/grass" % i)
    must(m, "kill $(pgrep -o -x ttfbox-usbd); i=0; while pgrep -x ttfbox-usbd && [ $i -lt 50 ]; do sleep 0.1; i=$((i+1)); done; ! pgrep -x ttfbox-usbd")
    must(m, "ttfbox-gadget remove; [ ! -e /sys/kernel/config/usb_gadget/ttfbox ]")


def programs_at_the_pc_are_killed_at_any_moment(m):
    plug(m)
    must(m, "head -c 8000000 /dev/zero | tr '\\0' 'x' >/tmp/data/grass/large")
    begun = time.monotonic()
    for i in range(10):
        bridge(m, 8500 + i)
        must(m, "for k in 1 2 3; do %s >/dev/null 2>&1 & done; sleep 0.%d; kill -9 $(cat /run/bridge.pid)" %
             (GET % (10, "127.0.0.1", 8500 + i, LARGE), i))
        bridge(m, 8600 + i)
        must(m, GET % (1, "127.0.0.1", 8600 + i, HEALTH) + " | grep -q true")
        must(m, "kill $(cat /run/bridge.pid)")
    print("      10 kills in %.0f s" % (time.monotonic() - begun))


SCENARIOS = [a_box_at_usb_is_pulled_beside_its_network, a_box_is_unplugged_while_it_is_pulled, programs_at_the_pc_are_killed_at_any_moment]
