#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""arm64.py [REGEX]: the unit tests, built for arm64 and run on this machine's processor by qemu-user. README.md."""
import hashlib
import json
import os
import re
import subprocess
import sys
import tempfile

import rig
from cross import QEMU_USER, ROOT


def listed(regex):
    """The unit tests that are programs: (name, whether it starts programs of ours)."""
    out = subprocess.run(["ctest", "--test-dir", rig.RIG + "/arm64", "-L", "unit", "-R", regex, "-E", NOT_HERE, "--show-only=json-v1"],
                         stdout=subprocess.PIPE, check=True).stdout
    for test in json.loads(out)["tests"]:
        program = [w for w in test.get("command", []) if w.startswith(rig.RIG + "/arm64/tests/")]
        if program:
            yield test["name"], os.path.basename(program[0])


# Campaigns about logic, which no processor changes; by emulation they would take an hour.
NOT_HERE = r"^failures_"
# qemu-user makes of vfork a fork: who starts a program that is not there is not told so by posix_spawn, as a kernel tells.
NOT_BY_EMULATION = {"a_missing_or_failing_ffmpeg_is_told_and_leaves_nothing", "a_video_comes_in_through_ffmpeg",
                    "a_program_that_is_not_there_is_named"}
# It has no asynchronous I/O of the kernel (io_setup: ENOSYS), by which a box's endpoints are served: usb.py runs them on a kernel.
NOT_BY_EMULATION |= {"before_a_pc_has_configured_it_a_box_sleeps", "a_box_whose_endpoint_was_disabled_unseen_is_down_and_sleeps",
                     "a_hosts_reset_starts_a_box_that_stands", "a_write_that_loses_bytes_begins_everything_anew"}


def starts_programs(program):
    """Names of other programs of the build stand in it: the kernel must know how to run those."""
    with open(rig.RIG + "/arm64/tests/" + program, "rb") as f:
        text = f.read()
    return (rig.RIG + "/arm64/").encode() in text


# ---- the same bits ----

PLAN = """interval: 10min
count: 5
lamps: {mode: continuous}
shots: [{exposure: 20ms, lamps: {left: 80%, right: 60%}}]
keep: raw
reserve: 0B
"""
BOX = ["--board", ROOT + "/boards/sim-small", "--plan", "plan.yaml", "-q"]


def pictures(folder):
    """What each of a dataset's pictures is, by a hash of its bytes."""
    found = {}
    for path, _, names in os.walk(folder):
        for name in names:
            if name.endswith((".tif", ".tiff", ".dng", ".png")):
                with open(path + "/" + name, "rb") as f:
                    found[os.path.relpath(path + "/" + name, folder)] = hashlib.sha256(f.read()).hexdigest()
    return found


def same_bits(env):
    """One dataset's raw frames, developed and quilted by this machine's program and by arm64's."""
    here = ROOT + "/build/bin/ttfbox"
    there = [QEMU_USER, "-L", rig.ARM64.libraries(), rig.RIG + "/arm64/bin/ttfbox"]
    rig.ARM64.compile(["ttfbox"])
    with tempfile.TemporaryDirectory(prefix="ttfbox-bits.") as folder:
        def run(*command):
            done = subprocess.run(command, cwd=folder, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
            if done.returncode != 0:
                sys.exit("arm64: %s: %s" % (" ".join(command[-8:]), done.stdout.decode(errors="replace")[-2000:]))

        with open(folder + "/plan.yaml", "w") as f:
            f.write(PLAN)
        run(here, "calibrate", "dark", *BOX, "--frames", "8", "-o", "cal")
        run(here, "calibrate", "flat", *BOX, "--frames", "8", "--scene", "white", "-o", "cal")
        run(here, "capture", "plan.yaml", "--board", ROOT + "/boards/sim-small", "-q", "-o", "raw")
        for name, program in (("here", [here]), ("there", there)):
            run(*program, "develop", "raw", "-c", "cal", "-q", "-o", name)
            run(*program, "synth", "quilt", name, "--size", "150x120", "--block", "32x32", "--seed", "7", "-q", "-o", name + "-quilt")
        wrong = 0
        for what in ("", "-quilt"):
            a, b = pictures(folder + "/here" + what), pictures(folder + "/there" + what)
            differ = sorted(n for n in set(a) | set(b) if a.get(n) != b.get(n))
            print("  %s: %d pictures on two processors, %d differ%s" %
                  ("quilted" if what else "developed", len(a), len(differ), ": " + ", ".join(differ[:4]) if differ else ""))
            wrong += len(differ) + (not a)
        return wrong


def judged(ran):
    """What ctest said: programs that failed, and cases that are excused. A program is, whose every failed case is."""
    wrong, excused = [], set()
    parts = re.split(r"^ *\d+/\d+ +Test +#\d+: (\w+) \.*(.*)$", ran, flags=re.M)
    for name, verdict, text in zip(parts[1::3], parts[2::3], parts[3::3]):
        if "Passed" in verdict or "Skipped" in verdict:
            continue
        cases = set(re.findall(r"^\[  FAILED  \] ([a-z]\w+)$", text, re.M))
        if "***Failed" in verdict and cases and cases <= NOT_BY_EMULATION:
            excused |= cases
        else:
            wrong.append(name)
    return wrong, excused, len(parts) // 3


def main():
    regex = sys.argv[1] if len(sys.argv) > 1 else "."
    rig.prepare_system()
    rig.ARM64.configure()
    tests = dict(listed(regex))
    if not tests:
        print("arm64: no unit test has such a name", file=sys.stderr)
        return 2
    rig.ARM64.compile(sorted(set(tests.values())))
    # qemu is registered with the kernel where its package could do so: then children run, too.
    registered = os.path.exists("/proc/sys/fs/binfmt_misc/qemu-aarch64")
    left_out = [] if registered else sorted(n for n, p in tests.items() if starts_programs(p))
    for name in left_out:
        print("  skipped, as this kernel does not run arm64 programs by itself: %s" % name)
    chosen = "^(%s)$" % "|".join(sorted(set(tests) - set(left_out)))
    env = dict(os.environ, QEMU_LD_PREFIX=rig.ARM64.libraries())
    ran = subprocess.run(["ctest", "--test-dir", rig.RIG + "/arm64", "-R", chosen, "-j", str(os.cpu_count()),
                          "--output-on-failure"], env=env, stdout=subprocess.PIPE, check=False).stdout.decode(errors="replace")
    wrong, excused, told = judged(ran)
    if told != len(tests) - len(left_out):
        wrong.append("ctest told of %d programs" % told)
    if wrong:
        print(ran[-20000:])
    print("  %d unit tests for arm64 ran here, %d failed%s; excused, as qemu-user cannot: %s" %
          (len(tests) - len(left_out), len(wrong), " (%s)" % ", ".join(wrong) if wrong else "", ", ".join(sorted(excused)) or "none"))
    return 1 if wrong or same_bits(env) else 0


if __name__ == "__main__":
    sys.exit(main())
