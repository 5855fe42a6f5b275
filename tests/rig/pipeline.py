# SPDX-License-Identifier: Apache-2.0
"""Cameras behind a real libcamera, on the kernel's vimc: a whole pipeline of the media controller, without controls of exposure."""
import os

import camera
import drivers
import lamps

BOARD = lamps.BOARD.replace("{backend: sim}", "{backend: libcamera, width: 640px, height: 480px}")
# vimc is slow in an emulated machine, and slower beside other work: a slot takes some 15 of its frames.
PLAN = camera.PLAN.replace("interval: 1s", "interval: 2s")
INTERVAL_S = 2
SLOTS = 10
FRAMES = int(os.environ.get("TTFBOX_RIG_FRAMES", "600"))
AWAY_S = 2


def load(m):
    drivers.udev(m)
    code, out = m.run("modprobe vimc && udevadm settle -t 20 && ls /dev/media0")
    assert code == 0, out


def the_camera_suite_passes_on_vimc_through_libcamera(m):
    load(m)
    code, out = m.run("rig_camera libcamera info best", 120)
    print("    " + out.strip().splitlines()[-1])
    assert code == 0 and "'Sensor B'" in out and "BG24" in out, out
    code, out = m.run("rig_camera libcamera conformance best 2>&1", 400)
    assert code == 0, out[-2500:]


def many_frames_through_libcamera_leave_nothing_behind(m):
    load(m)
    code, out = m.run("rig_camera libcamera soak %d" % FRAMES, 500)
    print("    " + out.strip().splitlines()[-1])
    assert code == 0, out


def no_camera_behind_libcamera_is_said_with_its_reason(m):
    board = BOARD.replace("\n", "\\n")
    code, out = m.run("printf '%s' >/run/board.yaml; ttfbox board probe --board /run/board.yaml" % board)
    assert code == 1 and "finds no camera" in out and "there is no /dev/media*" in out, out
    code, out = m.run("modprobe vimc; ttfbox board probe --board /run/board.yaml")
    assert code == 1 and "by udev, which does not run" in out, out
    drivers.udev(m)
    code, out = m.run("mkdir /run/alone; cp /share/ttfbox /run/alone; /run/alone/ttfbox board probe --board /run/board.yaml")
    assert code == 1 and "module for libcamera cannot be loaded" in out, out


def prepare(m, slots):
    load(m)
    lamps.guard(m, BOARD)
    code, out = m.run("printf '%s' >/run/plan.yaml" % (PLAN % slots).replace("\n", "\\n").replace("%", "%%"))
    assert code == 0, out


def a_capture_through_libcamera_has_every_slot(m):
    prepare(m, SLOTS)
    code, out = m.run(camera.CAPTURE, SLOTS * INTERVAL_S + 120)
    assert code == 0, out
    records = camera.slots_of(m, SLOTS)
    late = sorted(abs(r["middle_ns"] - r["due_ns"]) / 1e6 for r in records if r["result"] == "captured")
    lost = camera.tell_lost(records)
    print("    %d of %d slots captured, %.0f ms off at most" % (len(late), SLOTS, late[-1] if late else -1))
    assert len(lost) <= 1, lost
    lamps.end(m)


def goes_and_comes(m, before=""):
    """The camera's driver unbound in the middle of a capture, and bound again."""
    slots = 14
    prepare(m, slots)
    m.begin(before + camera.CAPTURE + " & sleep 8; echo vimc.0 >/sys/bus/platform/drivers/vimc/unbind; sleep %d; "
            "echo vimc.0 >/sys/bus/platform/drivers/vimc/bind; cut -d' ' -f1 /proc/uptime >/run/back; wait $!" % AWAY_S)
    code, out = m.end(slots * INTERVAL_S + 160)
    assert code == 0, (code, out)
    records = camera.slots_of(m, slots)
    lost = camera.tell_lost(records)
    code, out = m.run("cat /run/back")
    again = [r["due_ns"] / 1e9 for r in records if r["result"] == "captured" and r["due_ns"] / 1e9 > float(out)]
    assert again, m.run("tail -n 30 /tmp/out/events.jsonl")[1]
    print("    away for %d s: %d of %d lost, the next one captured %.1f s after it was back" %
          (AWAY_S, len(lost), slots, again[0] - float(out)))
    # Those due while it was away, and in the ten seconds that it may take to be well again.
    assert len(lost) <= (AWAY_S + 10) // INTERVAL_S and all(r.get("reason") for r in lost) and again[0] - float(out) < 10, lost
    lamps.end(m)


def a_camera_behind_libcamera_that_goes_is_found_again(m):
    goes_and_comes(m)


def a_camera_behind_libcamera_that_goes_unheard_is_found_again(m):
    """As the service runs: in a network of its own, where no word of udev arrives."""
    goes_and_comes(m, "unshare -n ")


SCENARIOS = [the_camera_suite_passes_on_vimc_through_libcamera,
             a_capture_through_libcamera_has_every_slot,
             a_camera_behind_libcamera_that_goes_is_found_again,
             a_camera_behind_libcamera_that_goes_unheard_is_found_again,
             no_camera_behind_libcamera_is_said_with_its_reason,
             many_frames_through_libcamera_leave_nothing_behind]
