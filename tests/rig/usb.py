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
UDC = "/sys/kernel/config/usb_gadget/ttfbox/UDC"


def must(m, command, seconds=60):
    code, out = m.run(command, seconds)
    assert code == 0, "%s: %s" % (command, out)
    return out


def wait(m, command, what, seconds=20):
    """Until a command succeeds in the guest."""
    code, out = m.run("i=0; while [ $i -lt %d ] && ! { %s; }; do sleep 0.1; i=$((i+1)); done; [ $i -lt %d ]" %
                      (10 * seconds, command, 10 * seconds), 4 * seconds + 20)
    assert code == 0, "%s: %s %s" % (what, out, m.run("cat /run/usbd /run/serve; dmesg | tail -n 20")[1])


def plug(m):
    """A box with a dataset, its server, and its gadget, bound. Its address on the cable's network."""
    must(m, "modprobe dummy_hcd && " + UDEV, 90)
    must(m, "mkdir -p /tmp/data && printf '%s' >/tmp/plan.yaml && ttfbox capture /tmp/plan.yaml --board sim-small "
            "--set sim.sensor.width=480px --set sim.sensor.height=320px -o /tmp/data/grass >/run/capture 2>&1 || "
            "{ cat /run/capture; false; }" % PLAN.replace("%", "%%"), 180)
    must(m, "ttfbox serve /tmp/data --listen unix:/run/http.sock >/run/serve 2>&1 & "
            "i=0; while [ $i -lt 100 ] && [ ! -S /run/http.sock ]; do sleep 0.1; i=$((i+1)); done; [ -S /run/http.sock ]")
    out = must(m, "ttfbox-gadget --serial RIG7 --owner root compose")
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
    must(m, "ip netns exec box ttfbox serve /tmp/data --listen %s:8417 >/run/tcp 2>&1 & sleep 1" % address)


def get(m, url):
    return must(m, "busybox wget -T 10 -q -O - " + url)


def a_box_at_usb_is_pulled_beside_its_network(m):
    address, box, pc = plug(m)
    must(m, "for i in /sys/bus/usb/devices/*:*; do echo $(cat $i/bInterfaceClass); done | grep -q ff")
    must(m, "ttfbox pull /tmp/here --usb", 120)
    must(m, "diff -r /tmp/data/grass /tmp/here/grass && ttfbox verify /tmp/here/grass")
    code, out = m.run("ttfbox pull /tmp/other --box usb:NOBODY")
    assert code != 0 and "no box of serial 'NOBODY'" in out, out
    network(m, address, box, pc)
    assert '"ok":true' in get(m, "http://%s:8417/api/v1/health" % address)
    number = must(m, "cat /sys/bus/usb/devices/1-1/devnum")
    must(m, "ttfbox usb >/run/bridge 2>&1 & sleep 1")
    for _ in range(KILLS):
        must(m, "kill -9 $(pgrep -P $(pgrep -o -x ttfbox-usbd))")
        assert '"ok":true' in get(m, "http://%s:8417/api/v1/health" % address)
        wait(m, "busybox wget -T 2 -q -O - http://127.0.0.1:8418/api/v1/health | grep -q '\"ok\":true'", "no status over the streams")
    assert must(m, "cat /sys/bus/usb/devices/1-1/devnum") == number, "the box was enumerated anew"
    must(m, "kill $(pgrep -f 'ttfbox usb'); ttfbox pull /tmp/again --usb && diff -r /tmp/data/grass /tmp/again/grass", 120)


def a_box_is_unplugged_while_it_is_pulled(m):
    plug(m)
    for i in range(UNPLUGS):
        must(m, "ttfbox pull /tmp/here%d --usb --follow >/run/pull 2>&1 & sleep 0.%d; echo '' >%s; sleep 0.3; "
                "ttfbox-gadget bind; wait $!; r=$?; cat /run/pull; [ $r = 0 ]" % (i, 2 + 3 * i, UDC), 120)
        must(m, "diff -r /tmp/data/grass /tmp/here%d/grass" % i)
    must(m, "kill $(pgrep -o -x ttfbox-usbd); i=0; while pgrep -x ttfbox-usbd && [ $i -lt 50 ]; do sleep 0.1; i=$((i+1)); done; ! pgrep -x ttfbox-usbd")
    must(m, "ttfbox-gadget --owner root remove; [ ! -e /sys/kernel/config/usb_gadget/ttfbox ]")


def programs_at_the_pc_are_killed_at_any_moment(m):
    plug(m)
    must(m, "head -c 8000000 /dev/zero | tr '\\0' 'x' >/tmp/data/grass/large")
    begun = time.monotonic()
    for i in range(10):
        must(m, "ttfbox usb --listen 127.0.0.1:8%d >/run/bridge 2>&1 & B=$!; sleep 0.5; "
                "for k in 1 2 3; do busybox wget -q -O /dev/null http://127.0.0.1:8%d/api/v1/datasets/grass/files/large & done; "
                "sleep 0.%d; kill -9 $B; wait" % (500 + i, 500 + i, i))
        must(m, "ttfbox usb --listen 127.0.0.1:8%d >/run/bridge 2>&1 & B=$!; "
                "i=0; while [ $i -lt 50 ] && ! grep -q 'is there' /run/bridge; do sleep 0.1; i=$((i+1)); done; "
                "busybox wget -T 1 -q -O - http://127.0.0.1:8%d/api/v1/health | grep -q '\"ok\":true'; r=$?; kill $B; wait; "
                "[ $r = 0 ]" % (600 + i, 600 + i))
    print("      10 kills in %.0f s" % (time.monotonic() - begun))


SCENARIOS = [a_box_at_usb_is_pulled_beside_its_network, a_box_is_unplugged_while_it_is_pulled, programs_at_the_pc_are_killed_at_any_moment]
