# SPDX-License-Identifier: Apache-2.0
"""A box at the USB of a PC (cable.py): ttfbox-gadget composes and binds, ttfbox-usbd serves by FunctionFS, ttfbox pulls by libusb, and a
network runs beside it. Pulled, unplugged, killed; how fast it is: usb_speed.py."""
import os
import random

import cable
from cable import FILES, FRAME, PC, UDC, bridge, must, wait

WORKER_KILLS = 3
UNPLUGS = 3
KILLS = int(os.environ.get("TTFBOX_RIG_KILLS", "50"))
REPLIES = b"HTTP/1.1 200 OK\r\nContent-Length: 2\r\n\r\nno"


def status(m, box):
    """Milliseconds; it is right, or the scenario fails."""
    return cable.figure(must(m, "rig_usb status " + box))


def a_box_at_usb_is_pulled_beside_its_network(m):
    cable.dataset(m)
    cable.serve(m)
    address, box, pc = cable.plug(m)
    must(m, "for i in /sys/bus/usb/devices/*:*; do echo $(cat $i/bInterfaceClass); done | grep -q ff")
    must(m, "ttfbox pull /tmp/here --usb", 300)
    must(m, "busybox diff -r /tmp/data/grass /tmp/here/grass && ttfbox verify /tmp/here/grass", 300)
    code, out = m.run("ttfbox pull /tmp/other --box usb:NOBODY")
    assert code != 0 and "no box of serial 'NOBODY'" in out, out
    cable.network(m, address, box, pc)
    net = "http://%s:8417" % address
    status(m, net)
    number = must(m, "cat /sys/bus/usb/devices/1-1/devnum")
    bridge(m)
    for _ in range(WORKER_KILLS):
        must(m, "kill -9 $(pgrep -P $(pgrep -o -x ttfbox-usbd))")
        status(m, net)
        wait(m, "timeout 2 rig_usb status %s" % PC, "no status over the streams", 10)
    assert must(m, "cat /sys/bus/usb/devices/1-1/devnum") == number, "the box was enumerated anew"
    cable.end_bridge(m)
    must(m, "ttfbox pull /tmp/again --usb && busybox diff -r /tmp/data/grass /tmp/again/grass", 300)


def a_box_is_unplugged_while_it_is_pulled(m):
    size = cable.dataset(m)
    cable.serve(m)
    cable.plug(m)
    # So slow that it takes two seconds, of which the cable is in.
    must(m, "echo $((%d / 2000 / 512 * 512)) >%s" % (size, FRAME))
    for i in range(UNPLUGS):
        must(m, "ttfbox pull /tmp/here%d --usb --follow >/run/pull 2>&1 & until ls /tmp/here%d/grass/frames/main/*.tmp; do kill -0 $! || exit 1; sleep 0.01; done; "
                "sleep 0.0%d; kill -0 $! || exit 1; echo '' >%s; sleep 0.3; ttfbox-gadget bind; wait $!; r=$?; cat /run/pull; [ $r = 0 ]" %
             (i, i, 2 + 3 * i, UDC), 600)
        must(m, "busybox diff -r /tmp/data/grass /tmp/here%d/grass" % i, 300)
    must(m, "kill $(pgrep -o -x ttfbox-usbd); i=0; while pgrep -x ttfbox-usbd && [ $i -lt 50 ]; do sleep 0.1; i=$((i+1)); done; ! pgrep -x ttfbox-usbd")
    must(m, "ttfbox-gadget remove; [ ! -e %s ]" % cable.GADGET)


def programs_at_the_pc_are_killed_at_any_moment(m):
    chance = random.Random(1)
    cable.dataset(m)
    cable.beside(m, "replies", REPLIES * ((8 << 20) // len(REPLIES)))
    cable.beside(m, "noise", cable.noise(8 << 20))
    cable.beside(m, "small", cable.noise(700))
    cable.serve(m)
    cable.plug(m)
    bridge(m)
    took, came = [], 0
    for _ in range(KILLS):
        out = must(m, "for f in replies noise small; do rig_usb body %s %s$f >/run/body.$f 2>&1 & done; sleep %.3f; kill -9 $(cat /run/bridge.pid); wait; "
                      "cat /run/body.*" % (PC, FILES, chance.uniform(0, 0.3)))
        came += sum(int(line.split()[0]) for line in out.splitlines() if line.endswith(" bytes"))
        took.append(bridge(m))
        assert took[-1] <= 1000, "the status took %.0f ms" % took[-1]
    took.sort()
    print("    %d kills, after %.0f MB of three streams: the next status was right after %.0f ms (median), %.0f ms (longest)" %
          (KILLS, came / 1e6, took[len(took) // 2], took[-1]))
    assert came > KILLS * 100000, "nothing was under way: %d bytes" % came


SCENARIOS = [a_box_at_usb_is_pulled_beside_its_network, a_box_is_unplugged_while_it_is_pulled, programs_at_the_pc_are_killed_at_any_moment]
