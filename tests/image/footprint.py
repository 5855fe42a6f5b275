# SPDX-License-Identifier: Apache-2.0
"""Memory of the whole box in a machine of 512 MiB, with a large camera and with a small one."""
import booted
import capture

SMALL = (320, 180)
LARGE = (3840, 2160)  # vivid's largest
HUGE = (4056, 3040)  # 12 megapixels: the simulated camera, and its world with it
BUFFERS = 2  # of the simulated camera; frames that may be held at once of a real one, which has so many spare ones more (hal/v4l2/device.h)
SPARE = 2
OWN_MIB, BOX_MIB = 24, 64
PLAN = "interval: %ds\ncount: 4\nlamps: {mode: capture-only, settle: 150ms}\nshots: [{lamps: {left: 100%%}}]\nkeep: %s\nreserve: 1MB\n"
PEAKS = ("for u in ttfboxd ttfbox-lampd; do p=$(systemctl show -P MainPID $u); grep VmHWM /proc/$p/status; "
         "grep ^Pss: /proc/$p/smaps_rollup; done; grep -E 'MemTotal|MemAvailable' /proc/meminfo")


VIVID = "qemu-virt-arm64", "{cameras.main.format: RG10, cameras.main.width: %d, cameras.main.height: %d}"
SIMULATED = "sim", ("{sim.clock: real, sim.sensor.width: %dpx, sim.sensor.height: %dpx, sim.optics.detail: 1024px, sim.timing.buffers: " + str(BUFFERS) + "}")


def run(m, name, box, size, keep, interval_s):
    """A plan under the services; kB at the peak: daemon, guardian."""
    width, height = size
    where = "/data/settings/current"
    board, sets = box[0], box[1] % size
    # As the settings' service would have left them: it is not what is looked at here.
    code, out = m.run("systemctl stop ttfboxd; printf '%s' >%s/plan.yaml; printf '%s' >%s/ttfboxd.yaml; systemctl start ttfboxd" % (
        (PLAN % (interval_s, keep)).replace("%", "%%").replace("\n", "\\n"), where,
        ("board: %s\nplan: plan.yaml\ndata: /var/lib/ttfbox\ndataset: %s\nset: %s\n" % (board, name, sets)).replace("\n", "\\n"), where), 300)
    assert code == 0, out
    m.wait("%s | grep -q done" % capture.STATUS, 900)
    out = m.run(PEAKS)[1]
    kb = [int(line.split()[1]) for line in out.splitlines()]
    code, verdict = m.run("grep -c '\"result\":\"captured\"' /var/lib/ttfbox/%s/records.jsonl" % name)
    frame = width * height * 2 / 2**20
    print("    %s, %dx%d (%.1f MiB a frame), keep %s, %s of 4 captured: ttfboxd %.1f MiB at most (%.1f afterwards, by share), guardian %.1f (%.1f)" %
          (name, width, height, frame, keep, verdict.strip(), kb[0] / 1024, kb[1] / 1024, kb[2] / 1024, kb[3] / 1024), flush=True)
    assert int(verdict) >= 3, m.journal()
    return (kb[0] + kb[2]) / 1024, frame


def the_whole_box_keeps_within_its_memory(board, image):
    capture.card(board, image, capture.PLAN % (2, "capture-only"))
    with booted.Booted(image) as m:
        m.wait("%s | grep -q done" % capture.STATUS, 300)
        print("    of %s" % ", ".join(m.run(PEAKS)[1].split("\n")[-3:-1]))
        small, _ = run(m, "small", VIVID, SMALL, "both", 3)
        raw, frame = run(m, "raw", VIVID, LARGE, "raw", 20)
        both, _ = run(m, "both", VIVID, LARGE, "both", 60)
        huge, huge_frame = run(m, "huge", SIMULATED, HUGE, "both", 120)
        m.off()
    bound, huge_bound = BOX_MIB + (BUFFERS + SPARE + 3) * frame, BOX_MIB + (BUFFERS + 3) * huge_frame
    print("    own share %.1f MiB (bound %d); with frames %.1f and %.1f (bound %.1f); of 12 megapixels, the simulator's world included, %.1f (bound %.1f)" %
          (small, OWN_MIB, raw, both, bound, huge, huge_bound))
    assert small < OWN_MIB and raw < bound and both < bound and huge < huge_bound


SCENARIOS = [the_whole_box_keeps_within_its_memory]
