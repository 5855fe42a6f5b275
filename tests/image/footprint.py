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
OWN = ("ttfboxd", "ttfbox-lampd")  # what a capture needs; the bound of the box is for all that run on it
BOX = OWN + ("ttfbox-usbd", "ttfbox-alertd")
PREVIEW = "ttfbox-preview"  # a budget of its own, which the kernel holds: MemoryMax= of its unit
# Of each process of a service, in kB: its peak, libraries that others have as well counted whole; and what of it is, by share, theirs.
PEAKS = ("for u in %s; do for p in $(cat /sys/fs/cgroup$(systemctl show -P ControlGroup $u)/cgroup.procs); do "
         "echo service $u $(awk '/^VmHWM:/ {print $2}' /proc/$p/status) "
         "$(awk '/^Rss:/ {rss = $2} /^Pss:/ {pss = $2} END {print rss - pss}' /proc/$p/smaps_rollup); done; done 2>/dev/null" % " ".join(BOX))
BUDGET = "echo preview $(systemctl show -P MemoryMax %s) $(cat /sys/fs/cgroup$(systemctl show -P ControlGroup %s)/memory.peak)" % (PREVIEW, PREVIEW)
MEMORY = "grep -E 'MemTotal|MemAvailable' /proc/meminfo"


VIVID = "qemu-virt-arm64", "{cameras.main.format: RG10, cameras.main.width: %d, cameras.main.height: %d}"
SIMULATED = "sim", ("{sim.clock: real, sim.sensor.width: %dpx, sim.sensor.height: %dpx, sim.optics.detail: 512px, sim.timing.buffers: " + str(BUFFERS) + "}")


def peaks(m):
    """MiB at the peak of each service's processes, and what of all that is counted more than once."""
    mib, twice = dict.fromkeys(BOX, 0.0), 0.0
    m.wait("systemctl is-active %s" % " ".join(BOX), 300)  # on a slow machine the cable comes late
    out = m.run(PEAKS)[1]
    for line in out.splitlines():
        words = line.split()
        if words[:1] == ["service"] and len(words) == 4:
            mib[words[1]] += int(words[2]) / 1024
            twice += int(words[3]) / 1024
    assert all(mib.values()), "a service of the box does not run: " + out + m.journal()
    return mib, twice


def preview_within_its_budget(m):
    """What previews may take, and took at most, the disk's cache in their name included."""
    m.wait("systemctl is-active %s" % PREVIEW, 600)
    words = m.run(BUDGET)[1].split()
    budget, peak = (int(word) / 2**20 for word in words[1:3])
    print("    previews, apart: %.1f MiB at most of a budget of %.0f (MemoryMax)" % (peak, budget), flush=True)
    assert 0 < peak <= budget < 512, words


def run(m, name, box, size, keep, interval_s):
    """A plan under the services; MiB at the peak: of daemon and guardian, of the whole box, of one frame."""
    width, height = size
    where = "/data/settings/current"
    board, sets = box[0], box[1] % size
    # As the settings' service would have left them: it is not what is looked at here.
    code, out = m.run("systemctl stop ttfboxd; printf '%s' >%s/plan.yaml; printf '%s' >%s/ttfboxd.yaml; systemctl start ttfboxd" % (
        (PLAN % (interval_s, keep)).replace("%", "%%").replace("\n", "\\n"), where,
        ("board: %s\nplan: plan.yaml\ndata: /var/lib/ttfbox\ndataset: %s\nset: %s\n" % (board, name, sets)).replace("\n", "\\n"), where), 300)
    assert code == 0, out
    m.wait("%s | grep -q done" % capture.STATUS, 900)
    mib, twice = peaks(m)
    code, verdict = m.run("grep -c '\"result\":\"captured\"' /var/lib/ttfbox/%s/records.jsonl" % name)
    frame, own, whole = width * height * 2 / 2**20, sum(mib[u] for u in OWN), sum(mib.values())
    print("    %s, %dx%d (%.1f MiB a frame), keep %s, %s of 4 captured: %s; the box %.1f MiB (%.1f of them more than once)" %
          (name, width, height, frame, keep, verdict.strip(), ", ".join("%s %.1f" % (u, mib[u]) for u in BOX), whole, twice), flush=True)
    assert int(verdict) >= 3, m.journal()
    return own, whole, frame


def the_whole_box_keeps_within_its_memory(board, image):
    capture.card(board, image, capture.PLAN % (2, "capture-only"))
    with booted.Booted(image) as m:
        m.wait("%s | grep -q done" % capture.STATUS, 300)
        print("    of %s" % ", ".join(m.run(MEMORY)[1].split("\n")[-3:-1]))
        own, small, small_frame = run(m, "small", VIVID, SMALL, "both", 3)
        _, raw, frame = run(m, "raw", VIVID, LARGE, "raw", 20)
        _, both, _ = run(m, "both", VIVID, LARGE, "both", 60)
        _, huge, huge_frame = run(m, "huge", SIMULATED, HUGE, "both", 120)
        preview_within_its_budget(m)
        m.off()
    small_bound, bound = (BOX_MIB + (BUFFERS + SPARE + 3) * size for size in (small_frame, frame))
    huge_bound = BOX_MIB + (BUFFERS + 3) * huge_frame
    print("    daemon's and guardian's own share %.1f MiB (bound %d); the box with small frames %.1f (bound %.1f), with large ones %.1f and %.1f "
          "(bound %.1f); of 12 megapixels, the simulator's world included, %.1f (bound %.1f)" %
          (own, OWN_MIB, small, small_bound, raw, both, bound, huge, huge_bound))
    assert own < OWN_MIB and small < small_bound and raw < bound and both < bound and huge < huge_bound


SCENARIOS = [the_whole_box_keeps_within_its_memory]
