# SPDX-License-Identifier: Apache-2.0
"""A webcam at USB that is a gadget of the same guest (rig_uvc answers for it), and the kernel's own uvcvideo as its driver: exposure, gain, white balance
asked for, granted, refused, and seen in the pictures."""
import json
import re

from cable import must, wait

GADGET = "/sys/kernel/config/usb_gadget/cam"
FUNCTION = GADGET + "/functions/uvc.cam"
STREAMING = FUNCTION + "/streaming"
NAME = "RIG webcam"
# 320 x 180, YUYV, 10 or 4 a second, a packet of 3 x 1024 bytes each millisecond.
COMPOSE = [
    "modprobe rig-cable && modprobe rig-uvc && modprobe uvcvideo && mkdir -p {g}/strings/0x409 {g}/configs/c.1 {f}",
    "cd {g} && echo 0x1d6b >idVendor && echo 0x0102 >idProduct && echo RIG >strings/0x409/manufacturer",
    "echo '{name}' >strings/0x409/product && echo CAM1 >strings/0x409/serialnumber",
    "mkdir -p {s}/uncompressed/u/180p {s}/header/h {f}/control/header/h",
    "cd {s}/uncompressed/u/180p && echo 320 >wWidth && echo 180 >wHeight && echo 115200 >dwMaxVideoFrameBufferSize",
    "echo 1000000 >dwDefaultFrameInterval && printf '1000000\\n2500000\\n' >dwFrameInterval",
    "ln -s {s}/uncompressed/u {s}/header/h/u && ln -s {s}/header/h {s}/class/fs/h && ln -s {s}/header/h {s}/class/hs/h",
    "ln -s {f}/control/header/h {f}/control/class/fs/h",
    "echo 3072 >{f}/streaming_maxpacket && echo 4 >{f}/streaming_interval && ln -s {f} {g}/configs/c.1/",
    "echo dummy_udc.0 >{g}/UDC && mkfifo /run/faults"]
IS_THERE = "grep -qs '%s' /sys/class/video4linux/*/name" % NAME
# As rig_camera_settings.c has it.
BOARD = """board: rig
cameras: {main: {backend: v4l2, name: %s, frame_period: 100ms, gain_unity: 64, focus_per_dioptre: 50, flicker: 50Hz, white_balance_kelvin: 5200}}
clock: {backend: machine}
""" % NAME
PLAN = """interval: 2s
count: %d
shots: [{exposure: 20ms, gain: 2}]
mains: 50Hz
reserve: 1MB
"""
CAPTURE = "ttfbox capture --board /run/board.yaml -q --no-speed-check -o /tmp/out /run/plan.yaml"
ASKED_MS, ASKED_GAIN = 20, 2
# Each is asked for whenever the camera is set up.
SET_UP = ["mode 1", "priority 0", "autowhite 0", "autofocus 0", "flicker 1", "kelvin 5200"]

# As v4l2-ctl names them, when a run is over.
LEFT = {"auto_exposure": "1", "exposure_dynamic_framerate": "0", "white_balance_automatic": "0", "white_balance_temperature": "5200",
        "power_line_frequency": "1", "focus_automatic_continuous": "0", "exposure_time_absolute": "1000", "gain": "32"}


def compose(m):
    """The gadget, bound; it appears at the cable with its responder."""
    must(m, " && ".join(COMPOSE).format(g=GADGET, f=FUNCTION, s=STREAMING, name=NAME))


def write(m, path, text):
    must(m, "printf '%s' >%s" % (text.replace("%", "%%").replace("\n", "\\n"), path))


UNPLUG = "kill $(pgrep -x rig_uvc); while %s; do sleep 0.05; done" % IS_THERE
PLUG = "(rig_uvc %s <>/run/faults >/run/said 2>&1 &); until %s; do sleep 0.05; done; sleep 0.2"


def plug(m, faults=(), mode=""):
    """Anew, with all as after power-on, and these faults."""
    must(m, "{ ! pgrep -x rig_uvc || { %s; }; } && %s" % (UNPLUG, PLUG % (mode, IS_THERE)))
    for line in faults:
        must(m, "echo %s >/run/faults; until grep -q 'fault: %s' /run/said; do sleep 0.05; done" % (line, line))


def said(m, word):
    """What the camera was asked or told, in order: 'exposure 200' ..."""
    return re.findall(r"^%s (.*)$" % word, must(m, "cat /run/said"), re.M)


def prepare(m, slots):
    write(m, "/run/board.yaml", BOARD)
    write(m, "/run/plan.yaml", PLAN % slots)
    must(m, "rm -rf /tmp/out")


def capture(m, slots, meanwhile=""):
    """(Exit code, what it said), with a stroke of fate in the middle."""
    prepare(m, slots)
    return m.run("cd /run; %s%s" % ("(%s) >/run/fate 2>&1 & " % meanwhile if meanwhile else "", CAPTURE), 600)


def records_of(m, slots):
    out = must(m, "ttfbox verify /tmp/out >/dev/null && cat /tmp/out/records.jsonl")
    records = [json.loads(text) for text in out.splitlines() if text.startswith('{"type":"slot"')]
    assert [r["index"] for r in records] == list(range(slots)), out[-1500:]
    return records


def events_of(m):
    return must(m, "cat /tmp/out/events.jsonl")


def shots(records):
    """Of each captured slot, the exposure that counts."""
    return [[s for s in i["shots"] if "refused" not in s][0]
            for r in records if r["result"] == "captured" for i in r["images"]]


def all_granted(records, exposure_ms=ASKED_MS, gain=ASKED_GAIN):
    for shot in shots(records):
        g = shot["granted"]
        assert (g["exposure_ns"], g["gain_milli"]) == (exposure_ms * 1000000, gain * 1000), shot


def level(records):
    """Of the pictures, by light: they are all of one exposure."""
    found = [i["mean_level"] for r in records for i in r.get("images", []) if "mean_level" in i]
    assert max(found) - min(found) < 0.003, found
    return found[0]


# ---- scenarios


def the_camera_suite_passes_on_a_webcam_with_exposure(m):
    compose(m)
    plug(m)
    code, out = m.run("rig_camera uvc info YUYV; rig_camera uvc conformance YUYV 2>&1", 300)
    print("    " + out.splitlines()[0])
    assert code == 0 and "has 0x3b mapped 0x23 automatics off 4 exposure up to 100000000 ns" in out, out[-2500:]


def settings(m, wanted):
    """[(asked ms, gain, granted ms, gain, level)] of a webcam that is plugged in."""
    out = must(m, "rig_camera uvc settings " + ",".join("%d:%d" % (ms * 1000, gain * 1000) for ms, gain in wanted), 300)
    found = re.findall(r"asked (\d+) (\d+) granted (\d+) (\d+) lens \d+ flags 0 mean ([0-9.]+)", out)
    assert len(found) == len(wanted), out
    return [(int(a) / 1e3, int(g) / 1e3, int(b) / 1e3, int(h) / 1e3, float(mean)) for a, g, b, h, mean in found]


def what_a_webcam_is_asked_for_is_granted_and_seen_in_its_pictures(m):
    compose(m)
    plug(m)
    wanted = [(10, 1), (20, 1), (40, 1), (20, 2), (80, 1), (12.345, 1.39), (10, 0.5), (0.5, 1), (0.01, 1), (300, 0.5)]
    for asked, gain, got, got_gain, mean in settings(m, wanted):
        # The unit's step is 0.5 ms, from 0.5 ms to a frame; a code of gain is 1/64.
        within = min(max(asked, 0.5), 100)
        assert abs(got - within) <= 0.25 and abs(got_gain - gain) <= 0.5 / 64 + 0.0005, (asked, gain, got, got_gain)
        assert abs(mean / (got / 100 * got_gain) - 1) < 0.02, (got, got_gain, mean)
    asked = said(m, "asked")
    # On configure, twice (a reader of capabilities, and the run), each thing before the first exposure.
    before = asked[:asked.index("exposure 100")]
    assert set(before) == set(SET_UP), before
    left = dict(re.findall(r"(\w+): (\d+)", must(m, "v4l2-ctl -d /dev/$(basename $(dirname $(grep -l '%s' /sys/class/video4linux/*/name | head -n 1))) -C %s" %
                                                 (NAME, ",".join(LEFT)))))
    assert left == LEFT, left


def a_webcam_that_grants_another_exposure_is_found_out(m):
    compose(m)
    plug(m, ["rounds 150"])  # of which its step says nothing
    code, out = capture(m, 4)
    records = records_of(m, 4)
    assert code == 0 and "20.000 ms were asked for, 15.000 ms granted and locked" in events_of(m), out
    all_granted(records, 15)
    rounded = level(records)
    plug(m, ["grants 900"])
    code, out = capture(m, 4)
    assert code == 1 and "grants other settings than it was asked for, each time anew" in out, out
    # A camera that does not say that its values may change by themselves is not asked by the kernel's driver, which tells what was asked of it: only the
    # picture shows it. (Were this ever to fail, the better for us.)
    plug(m, mode="silent")
    code, out = capture(m, 4)
    honest = records_of(m, 4)
    plug(m, ["grants 900"], "silent")
    code, out = capture(m, 4)
    assert code == 0, out
    lied = records_of(m, 4)
    all_granted(lied)
    print("    level %.3f at 20 ms, %.3f at 15 ms rounded, %.3f at 18 ms told as 20" % (level(honest), rounded, level(lied)))
    assert abs(level(lied) / level(honest) - 0.9) < 0.01 and abs(rounded / level(honest) - 0.75) < 0.01


def a_webcam_that_changes_by_itself_is_set_right_with_the_next_try(m):
    compose(m)
    for fault in ("wanders 1 333", "hiccups"):
        plug(m)
        code, out = capture(m, 12, "until [ -s /tmp/out/records.jsonl ]; do sleep 0.1; done; sleep 7; echo %s >/run/faults" % fault)
        records = records_of(m, 12)
        assert code == 0 and all(r["result"] == "captured" for r in records), out
        all_granted(records)
        assert level(records) > 0
        events = events_of(m)
        assert events.count("taken again: wrong settings") == 1 and events.count('"type":"event"') == 1, events
        wrong = [s for r in records for i in r["images"] for s in i["shots"] if "refused" in s]
        assert len(wrong) == 1 and wrong[0]["refused"] == "wrong settings", wrong
        text = must(m, "cat /run/said")
        after = re.findall(r"^asked (.*)$", text[text.index("fault: "):], re.M)
        print("    %s: a frame of %.1f ms taken again; asked then: %s" %
              (fault.split()[0], wrong[0]["granted"]["exposure_ns"] / 1e6, ", ".join(after)))
        assert after == SET_UP + ["exposure 200", "gain 128", "focus 0"], after


def a_webcam_that_refuses_a_control_is_climbed_over_or_refused_in_words(m):
    compose(m)
    plug(m, ["stalls gain 1 4"])
    code, out = capture(m, 4)
    records = records_of(m, 4)
    assert code == 0 and len(shots(records)) == 4 and "stalled gain" in must(m, "cat /run/said"), out
    all_granted(records)
    for fault, words in (("stalls gain 1000 4", "does not take the settings: Numerical result out of range"),
                         ("stalls flicker 1000 7", "the camera does not take 1 here"),
                         ("sticks 1", "does not take the settings: not in the state that the camera is in")):
        plug(m, [fault])
        code, out = capture(m, 4)
        assert code == 1 and words in out, (fault, out)


def a_webcam_unplugged_in_a_capture_is_found_and_set_up_again(m):
    slots = 16
    compose(m)
    plug(m)
    code, out = capture(m, slots, "until [ -s /tmp/out/records.jsonl ]; do sleep 0.1; done; sleep 9; cut -d' ' -f1 /proc/uptime; %s; sleep 3; %s; "
                                  "cut -d' ' -f1 /proc/uptime" % (UNPLUG, PLUG % ("", IS_THERE)))
    assert code == 0, out
    gone, back = map(float, must(m, "cat /run/fate").split())
    records = records_of(m, slots)
    lost = [r for r in records if r["result"] != "captured"]
    again = min(r["due_ns"] / 1e9 for r in records if r["result"] == "captured" and r["due_ns"] / 1e9 > gone)
    print("    away for %.1f s: %d of %d slots lost, the next one due %.1f s after it was back" % (back - gone, len(lost), slots, again - back))
    # Those due while it was away, and one more.
    assert 0 < len(lost) <= (back - gone) / 2 + 2 and all(r.get("reason") for r in lost) and again - back < 5, lost
    all_granted(records)
    assert level(records) > 0
    assert said(m, "asked") == SET_UP + ["exposure 200", "gain 128", "focus 0"], said(m, "asked")


def many_frames_from_a_webcam_leave_nothing_behind(m):
    compose(m)
    plug(m)
    code, out = m.run("rig_camera uvc soak 300", 600)
    print("    " + out.strip().splitlines()[-1])
    assert code == 0, out


SCENARIOS = [the_camera_suite_passes_on_a_webcam_with_exposure,
             what_a_webcam_is_asked_for_is_granted_and_seen_in_its_pictures,
             a_webcam_that_grants_another_exposure_is_found_out,
             a_webcam_that_changes_by_itself_is_set_right_with_the_next_try,
             a_webcam_that_refuses_a_control_is_climbed_over_or_refused_in_words,
             a_webcam_unplugged_in_a_capture_is_found_and_set_up_again,
             many_frames_from_a_webcam_leave_nothing_behind]
