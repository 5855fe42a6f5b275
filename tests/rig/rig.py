#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""rig.py [WORDS]: real kernel drivers in an emulated board; scenarios whose names hold one of WORDS. README.md."""
import os
import shutil
import subprocess
import sys
import time
import traceback

import boots
import camera
import drivers
import lamps
import pipeline
import powercuts
import strokes
from machine import Machine

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
RIG = ROOT + "/build-rig"
PROGRAMS = ["ttfbox", "ttfboxd", "ttfbox-lampd", "lampd_child", "capture_child", "rig_camera", "test_lines", "test_sysfs",
            "test_conformance_lampd", "ttfbox-libcamera"]
# What no machine here has; said, so that nobody takes silence for a pass.
NOT_HERE = ["exposure control through a real camera driver", "a GPIO chip that is unplugged",
            "an edge of a real button or door", "a temperature of a real sensor"]


def build():
    """The programs for arm64, against the tree."""
    tree = RIG + "/system/tree"
    lib = tree + "/usr/lib/aarch64-linux-gnu/pkgconfig:" + tree + "/usr/share/pkgconfig"
    env = dict(os.environ, TTFBOX_RIG_TREE=tree, PKG_CONFIG_SYSROOT_DIR=tree, PKG_CONFIG_LIBDIR=lib)
    out = RIG + "/arm64"
    steps = []
    if not os.path.exists(out + "/build.ninja"):
        steps.append(["cmake", "-G", "Ninja", "-S", ROOT, "-B", out, "-DCMAKE_BUILD_TYPE=RelWithDebInfo",
                      "-DCMAKE_TOOLCHAIN_FILE=" + HERE + "/cross.cmake"])
    steps.append(["ninja", "-C", out] + PROGRAMS)
    for step in steps:
        done = subprocess.run(step, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, check=False)
        if done.returncode != 0:
            sys.stderr.write(done.stdout.decode(errors="replace")[-4000:])
            sys.exit("rig: the programs do not build for arm64")
    share = RIG + "/share"
    shutil.rmtree(share, ignore_errors=True)
    os.makedirs(share)
    for name in PROGRAMS:
        folder = "/bin/" if name.startswith("ttfbox") else "/tests/"
        if name == "ttfbox-libcamera":  # a module that programs find beside them
            folder, name = "/lib/ttfbox/", name + ".so"
        shutil.copy(out + folder + name, share)
    return share


def prepare():
    """The system and the programs; where the guest finds them."""
    subprocess.run(["bash", HERE + "/tree.sh", RIG + "/system"], check=True)
    subprocess.run(["bash", HERE + "/modules.sh", RIG], check=True)
    return build()


def run(scenario, share):
    """None, or what went wrong."""
    try:
        if scenario in powercuts.SCENARIOS + boots.SCENARIOS:
            scenario(RIG + "/system", share)
            return None
        with Machine(RIG + "/system", share) as machine:
            scenario(machine)
        return None
    except AssertionError as e:
        return "%s\n%s" % (e, traceback.format_exc(limit=2))
    except (RuntimeError, OSError) as e:
        return "the machine: %s" % e


def main():
    words = sys.argv[1:]
    every = lamps.SCENARIOS + camera.SCENARIOS + strokes.SCENARIOS + powercuts.SCENARIOS + boots.SCENARIOS + drivers.SCENARIOS + pipeline.SCENARIOS
    scenarios = [s for s in every if not words or any(w in s.__name__ for w in words)]
    if not scenarios:
        print("rig: no scenario has such a name; there are:", file=sys.stderr)
        print("\n".join("  " + s.__name__ for s in every), file=sys.stderr)
        return 2
    share = prepare()
    failed = 0
    for scenario in scenarios:
        before = time.monotonic()
        print("  %s ..." % scenario.__name__.replace("_", " "), flush=True)
        wrong = run(scenario, share)
        failed += wrong is not None
        print("    %s (%.0f s)%s" % ("FAILED" if wrong else "passed", time.monotonic() - before,
                                     ": " + wrong if wrong else ""), flush=True)
    for what in NOT_HERE:
        print("  skipped, as no machine here has it: %s" % what)
    print("%d passed, %d failed, %d skipped" % (len(scenarios) - failed, failed, len(NOT_HERE)))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
