# SPDX-License-Identifier: Apache-2.0
"""How fast a box is pulled over USB, against what its cable carries. By the guest's own clock, which counts instructions (cable.Board)."""
import cable
from cable import FILES, FRAME, PC, WHOLE_FRAME, figure, must

MIB = 64
TRIES = 3


def best(m, command):
    return max(figure(must(m, command, 600)) for _ in range(TRIES))


def frame(m, bytes_):
    must(m, "echo %d >%s" % (bytes_, FRAME))


def raw(m):
    """What the cable carries without streams: 8 transfers of 64 KiB queued at each end. Whole; and throttled to 35 MB/s, with the frame for it."""
    cable.plug(m, "rig_usb source /run/ttfbox-usb >/run/source 2>&1 & " + cable.ready("/run/source", "ready"))
    drain = "rig_usb drain %d" % (MIB << 20)
    whole = best(m, drain)
    throttle = int(WHOLE_FRAME * 35 / whole) // 512 * 512
    frame(m, throttle)
    slow = best(m, drain)
    frame(m, WHOLE_FRAME)
    must(m, "pkill -x rig_usb; i=0; while pgrep -x rig_usb && [ $i -lt 50 ]; do sleep 0.1; i=$((i+1)); done; ttfbox-gadget remove")
    return whole, slow, throttle


def pulled(m, size):
    """MB/s of a whole pull through a program that has the box: opening the device is left out, as the guest's clock leaps there (cable.Board)."""
    rates = []
    for _ in range(TRIES):
        out = must(m, "rm -rf /tmp/here; a=$(cut -d' ' -f1 /proc/uptime); ttfbox pull /tmp/here --box %s >/run/pull 2>&1 && echo $a $(cut -d' ' -f1 /proc/uptime)" % PC, 900)
        a, b = (float(x) for x in out.split()[-2:])
        rates.append(size / 1e6 / (b - a))
    must(m, "busybox diff -r /tmp/data/grass /tmp/here/grass", 300)
    return max(rates)


def beside(m):
    """Milliseconds of a status, sorted, while a body takes the whole cable."""
    out = must(m, "rig_usb body %s %slarge >/dev/null 2>&1 & for i in $(seq 100); do rig_usb status %s || break; done; kill $!" % (PC, FILES, PC), 600)
    took = sorted(float(line.split()[0]) for line in out.splitlines() if line.endswith(" ms"))
    assert len(took) == 100, out
    return took


def a_pull_is_nearly_as_fast_as_its_cable(m):
    size = cable.dataset(m, 6, 1600, 1200)
    cable.serve(m)
    whole, slow, throttle = raw(m)
    cable.plug(m)
    cable.bridge(m)
    full = pulled(m, size)
    cable.beside(m, "large", cable.noise(MIB << 20))
    body = "rig_usb body %s %slarge once" % (PC, FILES)
    thrown = best(m, body)
    waited = beside(m)
    frame(m, throttle)
    throttled = best(m, body)
    frame(m, WHOLE_FRAME)
    sha256 = best(m, "rig_usb sha256 %d" % (MIB << 20))
    write = best(m, "rm -f /tmp/written; rig_usb write /tmp/written %d" % (MIB << 20))
    serial = 1 / (1 / whole + 1 / sha256 + 1 / write)
    print("    the cable alone %.1f MB/s; a body thrown away %.1f, %.3f of it; throttled: the cable alone %.1f, a body %.1f, %.3f of it and %.3f of 35" %
          (whole, thrown, thrown / whole, slow, throttled, throttled / slow, throttled / 35))
    print("    SHA-256 alone %.1f MB/s, writing alone %.1f; a pull of %.0f MB %.1f MB/s, %.3f of the three one after another (%.1f)" %
          (sha256, write, size / 1e6, full, full / serial, serial))
    print("    the status while a body takes the whole cable: %.1f ms (median), %.1f ms (99 of 100), %.1f ms (longest)" % (waited[50], waited[98], waited[99]))
    assert thrown >= 0.8 * whole, "a body"
    assert throttled >= 0.95 * 35, "a throttled body"
    assert full >= 0.8 * serial, "a pull"
    assert waited[98] <= 50, "the status"


SCENARIOS = [a_pull_is_nearly_as_fast_as_its_cable]
