# SPDX-License-Identifier: Apache-2.0
"""Cameras on a real V4L2 driver: the kernel's vivid, with its own faults."""

FORMATS = ["RGGB", "RG10", "RG12", "YUYV", "NV12", "GREY", "Y10", "RGB3"]
FAULTS = ["disconnect", "error-flag", "reqbufs", "qbuf", "streamon", "fatal", "dropped-30", "unbind",
          "unbind-renumbered"]


def load(m):
    """A fault that nobody met would hit the next one: the module is loaded anew each time."""
    code, out = m.run("rmmod vivid 2>/dev/null; modprobe vivid n_devs=1 node_types=0x1 num_inputs=1 input_types=0x00; "
                      "i=0; while [ $i -lt 100 ] && ! [ -e /dev/video0 ]; do sleep 0.05; i=$((i+1)); done; "
                      "[ -e /dev/video0 ]")
    assert code == 0, out


def the_camera_suite_passes_on_vivid_in_each_format(m):
    load(m)
    for pixels in FORMATS:
        code, out = m.run("rig_camera info %s; rig_camera conformance %s" % (pixels, pixels), 300)
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
    code, out = m.run("rig_camera soak 1000", 400)
    print("    " + out.strip())
    assert code == 0, out


SCENARIOS = [the_camera_suite_passes_on_vivid_in_each_format,
             compressed_pixels_and_a_missing_camera_are_refused_in_words,
             a_camera_whose_driver_fails_loses_at_most_one_slot,
             many_frames_restarts_and_reopenings_leave_nothing_behind]
