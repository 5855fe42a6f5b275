# SPDX-License-Identifier: Apache-2.0
"""Cameras on a real V4L2 driver: the kernel's vivid, with its own faults; and a capture with it by real lamp lines."""
import json
import os
import time

import lamps

SLOTS = int(os.environ.get("TTFBOX_RIG_SLOTS", "40"))
SOAK = int(os.environ.get("TTFBOX_RIG_SOAK", "1000"))
BOARD = lamps.BOARD.replace("{backend: sim}", "{backend: v4l2, name: vivid, format: RG10, width: 320, height: 180, frame_period: 40ms}")
PLAN = """interval: 1s
count: %d
lamps: {mode: capture-only, settle: 150ms}
shots: [{lamps: {left: 100%%}}]
reserve: 1MB
"""
CAPTURE = "ttfbox capture --board /run/board.yaml -q --no-speed-check -o /tmp/out /run/plan.yaml"
# The guest's clock is read to 10 ms, and the emulator's trace is written a little later than the line moves.
SLACK_S = 0.03
FAULTY_SLOTS, WRONG_SLOT = 12, 4
# What is to be read of each in the dataset's events.
INJECTED = {"error-flag": "taken again", "qbuf": "delivers again", "fatal": "Input/output error", "reqbufs": "the driver gives no buffers: Invalid argument",
            "streamon": "the stream does not start: Invalid argument", "disconnect": "No such device"}

FORMATS = ["RGGB", "RG10", "RG12", "YUYV", "NV12", "GREY", "Y10", "RGB3"]
FAULTS = ["disconnect", "error-flag", "reqbufs", "qbuf", "streamon", "fatal", "dropped-30", "unbind",
          "unbind-renumbered"]


def load(m):
    """A fault that nobody met would hit the next one: the module is loaded anew each time."""
    code, out = m.run("rmmod vivid 2>/dev/null; modprobe vivid n_devs=1 node_types=0x1 num_inputs=1 input_types=0x00; "
                      "i=0; while [ $i -lt 100 ] && ! [ -e /dev/video0 ]; do sleep 0.05; i=$((i+1)); done; "
                      "[ -e /dev/video0 ]")
    assert code == 0, out


def a_raw_and_a_yuv_stream_pass_the_camera_suite(m):
    the_camera_suite_passes_on_vivid_in_each_format(m, ("RG10", "YUYV"))


def the_camera_suite_passes_on_vivid_in_each_format(m, formats=None):
    load(m)
    for pixels in formats or FORMATS:
        code, out = m.run("rig_camera info %s; rig_camera conformance %s 2>&1" % (pixels, pixels), 300)
        print("    " + out.splitlines()[0])
        assert code == 0, out[-2500:]


def compressed_pixels_and_a_missing_camera_are_refused_in_words(m):
    m.run("rmmod vivid")
    code, out = m.run("rig_camera info RG10")
    assert code != 0 and "no video device at all" in out, out
    load(m)
    code, out = m.run("rig_camera info MJPG")
    assert code != 0 and "compressed" in out, out
    code, out = m.run("rig_camera info RG10")
    assert code == 0 and "has 0x2 " in out and "exposure up to 0 ns" in out, out


def a_camera_whose_driver_fails_loses_at_most_one_slot(m):
    wrong = []
    for fault in FAULTS:
        load(m)
        code, out = m.run("rig_camera case %s" % fault, 200)
        print("    " + out.strip().splitlines()[-1])
        if code != 0:
            wrong.append(out)
    assert not wrong, "\n".join(wrong)


def many_frames_restarts_and_reopenings_leave_nothing_behind(m):
    load(m)
    code, out = m.run("rig_camera soak %d" % SOAK, 100 + SOAK * 3 // 10)
    print("    " + out.strip())
    assert code == 0, out


def boot_at(m):
    """When the guest's boot clock stood at 0, by the host's: the tightest of some looks."""
    best = None
    for _ in range(20):
        before = time.time()
        _, out = m.run("cut -d' ' -f1 /proc/uptime")
        after = time.time()
        if best is None or after - before < best[0]:
            best = (after - before, (before + after) / 2 - float(out) - 0.005)
    return best[1]


def slots_of(m, slots):
    """The records of a dataset that verifies, one for each slot."""
    code, out = m.run("ttfbox verify /tmp/out && cat /tmp/out/records.jsonl", 120)
    assert code == 0, out[-1500:]
    records = [json.loads(text) for text in out.splitlines() if text.startswith('{"type":"slot"')]
    assert [r["index"] for r in records] == list(range(slots)), out[-1500:]
    return records


def prepare(m, slots, more=""):
    load(m)
    lamps.guard(m, BOARD)
    code, out = m.run("printf '%s' >/run/plan.yaml" % (PLAN % slots + more).replace("\n", "\\n").replace("%", "%%"))
    assert code == 0, out


def tell_lost(records):
    lost = [r for r in records if r["result"] != "captured"]
    for r in lost:
        print("    slot %d: %s, %s" % (r["index"], r["result"], r.get("reason", "no reason given")))
    return lost


def a_capture_with_every_third_buffer_dropped_loses_at_most_one_slot(m):
    prepare(m, 40)
    code, out = m.run("v4l2-ctl -c percentage_of_dropped_buffers=30 && v4l2-ctl -C percentage_of_dropped_buffers")
    assert code == 0 and out.split()[-1:] == ["30"], out
    code, out = m.run(CAPTURE, 160)
    assert code == 0, out
    lost = tell_lost(slots_of(m, 40))
    code, out = m.run("grep -c 'taken again' /tmp/out/events.jsonl")
    print("    %d of 40 slots lost; %s taken again" % (len(lost), out.strip()))
    assert len(lost) <= 1 and all(r.get("reason") for r in lost)
    assert lost or int(out) > 0, "no buffer was dropped at all"
    lamps.end(m)


def struck_in_slot(m, fault, slot, slots):
    """A capture with a fault of the driver from the middle of a slot's exposure on, so that the frame that ends next is the slot's; when that was, on the boot clock."""
    code, out = m.run(
        "rm -rf /tmp/out /run/ended; (%s >/run/captured 2>&1; echo $? >/run/ended) & "
        "until grep -q due_ns /tmp/out/records.jsonl; do [ -e /run/ended ] && exit 1; sleep 0.05; done 2>/dev/null; "
        "when=$(($(grep -o 'due_ns\":[0-9]*' /tmp/out/records.jsonl | head -n 1 | cut -d: -f2) + %d)); "
        "echo $(pgrep -x ttfbox) $when | rig_camera inject %s && until [ -e /run/ended ]; do sleep 0.2; done; cat /run/captured /run/ended; echo $when" %
        (CAPTURE, slot * 10**9, fault), slots + 160)
    assert code == 0 and out.split()[:1] == ["set"] and out.split()[-2] == "0", (out, m.run("cat /run/captured")[1])
    return int(out.split()[-1])


def a_capture_whose_driver_fails_loses_at_most_one_slot(m):
    """Each fault that vivid can be told to make, while the box exposes."""
    prepare(m, FAULTY_SLOTS, "keep: raw\n")  # what the emulated processor does easily in a second, beside other work
    wrong = []
    for fault, told in INJECTED.items():
        load(m)
        struck_ns = struck_in_slot(m, fault, WRONG_SLOT, FAULTY_SLOTS)
        records = slots_of(m, FAULTY_SLOTS)
        lost = [r for r in tell_lost(records) if r["due_ns"] >= struck_ns]
        events = [json.loads(text) for text in m.run("cat /tmp/out/events.jsonl")[1].splitlines()]
        said = [e["text"] for e in events if e["kind"] in ("camera", "retry") and e["at_ns"] > struck_ns]
        again_ns = min([r["due_ns"] for r in records if r["result"] == "captured" and r["due_ns"] >= struck_ns], default=float("inf"))
        print("    %s: %d of %d slots lost since, captured again %.1f s after it; recorded: %s" %
              (fault, len(lost), FAULTY_SLOTS, (again_ns - struck_ns) / 1e9, "; ".join(said) or "nothing"), flush=True)
        if len(lost) > 1 or not all(r.get("reason") for r in lost) or again_ns - struck_ns > 10**10 or not any(told in text for text in said):
            wrong.append((fault, lost, said))
    assert not wrong, wrong
    lamps.end(m)


def a_camera_unplugged_in_a_capture_is_found_again(m):
    prepare(m, 40)
    # Held open from before it goes, or it would come back under its old number.
    code, out = m.run("(%s >/run/captured 2>&1; echo $? >/run/ended) & sleep 15; "
                      "exec 4</dev/video0; echo vivid.0 >/sys/bus/platform/drivers/vivid/unbind; sleep 2; "
                      "cut -d' ' -f1 /proc/uptime; echo vivid.0 >/sys/bus/platform/drivers/vivid/bind; ls /dev/video*" % CAPTURE)
    assert code == 0 and out.split()[-1:] == ["/dev/video1"], out
    back = float(out.split()[0])
    code, out = m.run("i=0; while [ $i -lt 120 ] && ! [ -e /run/ended ]; do sleep 1; i=$((i+1)); done; "
                      "cat /run/captured /run/ended", 160)
    assert code == 0 and out.strip().endswith("\n0"), out
    records = slots_of(m, 40)
    lost = tell_lost(records)
    again = min(r["due_ns"] / 1e9 for r in records if r["result"] == "captured" and r["due_ns"] / 1e9 > back - 0.5)
    print("    away for 2 s, back under another number; %d of 40 slots lost, the first again due %.1f s after it was back" %
          (len(lost), again - back))
    # Those due while it was away, and one more.
    assert len(lost) <= 4 and all(r.get("reason") for r in lost) and again - back < 10, lost
    lamps.end(m)


def lateness_ms(records):
    return sorted(abs(r["middle_ns"] - r["due_ns"]) / 1e6 for r in records if r["result"] == "captured")


def lamps_as_recorded(records, changes, zero):
    """Each lamp's level from outside is the recorded one while each exposure lasts; how many had the left one lit."""
    lit = 0
    for r in records:
        for shot in [s for i in r.get("images", []) for s in i["shots"] if "start_ns" in s]:
            said = {lamp["name"]: lamp["commanded_permille"] for lamp in shot["lamps"]}
            for edge in (shot["start_ns"] / 1e9 + SLACK_S, shot["end_ns"] / 1e9 - SLACK_S):
                left = lamps.level_at(changes, lamps.LEFT, 0, zero + edge)
                right = lamps.level_at(changes, lamps.RIGHT, 1, zero + edge)
                around = [(at - zero, line, to) for at, line, to in changes if abs(at - zero - edge) < 1.5]
                assert (said["left"] > 0) == (left == 1) and (said["right"] > 0) == (right == 0), (r, left, right, around)
            lit += left
        # In the middle between two slots it is dark, if the exposure came on time: the lamps burn for the capture only.
        late_one = any("late" in i.get("flags", []) for i in r.get("images", []))
        assert late_one or lamps.level_at(changes, lamps.LEFT, 0, zero + r["due_ns"] / 1e9 + 0.5) == 0, r
    return lit


def a_capture_from_vivid_has_its_lamps_as_seen_from_outside(m):
    since = time.time()
    prepare(m, SLOTS)
    code, out = m.run(CAPTURE, SLOTS + 120)
    print("    " + "\n    ".join(out.strip().splitlines()[-8:]))
    assert code == 0, out
    zero = boot_at(m)
    records = slots_of(m, SLOTS)
    changes = m.changes(since)
    lit = lamps_as_recorded(records, changes, zero)
    late = lateness_ms(records)
    print("    %d of %d slots captured, lamps as recorded in each; slot error p99 %.1f ms, %.1f at most" %
          (len(late), SLOTS, late[len(late) * 99 // 100] if late else -1, late[-1] if late else -1))
    assert len(late) >= SLOTS - 1 and lit >= SLOTS - 1, (late, lit)
    lamps.end(m)


SCENARIOS = [the_camera_suite_passes_on_vivid_in_each_format,
             a_capture_from_vivid_has_its_lamps_as_seen_from_outside,
             a_capture_with_every_third_buffer_dropped_loses_at_most_one_slot,
             a_camera_unplugged_in_a_capture_is_found_again,
             a_capture_whose_driver_fails_loses_at_most_one_slot,
             compressed_pixels_and_a_missing_camera_are_refused_in_words,
             a_camera_whose_driver_fails_loses_at_most_one_slot,
             many_frames_restarts_and_reopenings_leave_nothing_behind]
