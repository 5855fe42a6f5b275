#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""rig.py [quick|smoke] [WORDS]: real kernel drivers in an emulated board; scenarios whose names hold one of WORDS. README.md."""
import fcntl
import os
import shutil
import subprocess
import sys
import time
import traceback

import boots
import camera
import chips
import drivers
import frozen
import gpiod2
import inputs
import instructions
import lamps
import pipeline
import powercuts
import soak
import strokes
import usb
import usb_speed
import uvc
from cable import Board
from cross import HERE, ROOT, Cross
from machine import Machine

RIG = ROOT + "/build-rig"
ARM64 = Cross(RIG + "/system/tree", RIG + "/arm64")
PROGRAMS = ["ttfbox", "ttfboxd", "ttfbox-lampd", "ttfbox-usbd", "lampd_child", "capture_child", "rig_camera", "rig_usb", "rig_uvc", "strike", "test_lines", "test_sysfs",
            "test_conformance_lampd", "ttfbox-libcamera", "ttfbox-libcamera-host"]
# What no machine here has; said, so that nobody takes silence for a pass.
NOT_HERE = ["exposure control of a camera behind libcamera", "a Raspberry Pi's own PWM and under-voltage alarm"]


# A machine that is thawed in place of booted; smoke: those that need neither many programs nor modules of our own.
SMOKE_PROGRAMS = ["ttfbox-lampd", "lampd_child", "rig_camera", "strike", "test_lines", "test_sysfs"]
SMOKE = [lamps.lamps_are_dark_from_the_first_and_without_a_glitch, lamps.a_client_that_hangs_is_dark_after_its_declared_sign_of_life,
         lamps.a_killed_guardian_leaves_them_and_its_restart_darkens_them, lamps.a_line_that_another_holds_is_named_with_its_holder,
         lamps.clients_killed_a_few_times_leave_the_lamps_dark, camera.a_raw_and_a_yuv_stream_pass_the_camera_suite,
         camera.compressed_pixels_and_a_missing_camera_are_refused_in_words]
QUICK = SMOKE + [lamps.programs_pass_their_tests_on_this_processor, drivers.simulated_lines_are_felt_and_seen] + inputs.SCENARIOS + chips.SCENARIOS


def build(programs, share):
    """The scenarios' programs, where the guest finds them."""
    ARM64.configure()
    ARM64.compile(programs)
    out = ARM64.folder
    shutil.rmtree(share, ignore_errors=True)
    os.makedirs(share)
    for name in programs:
        folder = "/bin/" if name.startswith("ttfbox") else "/tests/"
        if name.startswith("ttfbox-libcamera"):  # a module and what loads it, that programs find beside them
            folder, name = "/lib/ttfbox/", name if name.endswith("host") else name + ".so"
        shutil.copy(out + folder + name, share)
    shutil.copy(ROOT + "/firmware/gadget/ttfbox-gadget", share)
    shutil.copy(ROOT + "/boards/sim-small/board.yaml", share + "/sim-small.yaml")


def prepare_system():
    """75, as tree.sh has it: this machine's mirror has no such system."""
    done = subprocess.run(["bash", HERE + "/tree.sh", RIG + "/system"], check=False)
    if done.returncode != 0:
        sys.exit(done.returncode)


def of_tier(name, tier):
    """A folder that each tier has for itself, as one may run beside another."""
    return RIG + "/" + name + ("-" + tier if tier else "")


def prepare(tier):
    """The system and the programs; where the guest finds them. One at a time, in a tree."""
    os.makedirs(RIG, exist_ok=True)
    share = of_tier("share", tier)
    with open(RIG + "/lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        prepare_system()
        if tier != "smoke":
            subprocess.run(["bash", HERE + "/modules.sh", RIG], check=True)
        build(SMOKE_PROGRAMS if tier == "smoke" else PROGRAMS, share)
        if tier:
            frozen.prepare(RIG + "/system", share, of_tier("frozen", tier))
    return share


def machine_for(scenario, share, tier):
    if tier:
        return frozen.Frozen(RIG + "/system", of_tier("frozen", tier))
    if scenario in gpiod2.SCENARIOS:
        return gpiod2.Newer(RIG + "/system", of_tier("share", "newer"))
    return (Board if scenario in usb.SCENARIOS + usb_speed.SCENARIOS + uvc.SCENARIOS else Machine)(RIG + "/system", share)


def run(scenario, share, tier):
    """None, or what went wrong."""
    try:
        if scenario in powercuts.SCENARIOS + boots.SCENARIOS + soak.SCENARIOS + instructions.SCENARIOS:
            scenario(RIG + "/system", share)
            return None
        with machine_for(scenario, share, tier) as machine:
            scenario(machine)
        return None
    except AssertionError as e:
        return "%s\n%s" % (e, traceback.format_exc(limit=2))
    except (RuntimeError, OSError) as e:
        return "the machine: %s" % e
    except Exception as e:  # a scenario that does not understand what it is told; the others are run all the same
        return "%s: %s\n%s" % (type(e).__name__, e, traceback.format_exc(limit=3))


def main():
    words = sys.argv[1:]
    tier = words.pop(0) if words and words[0] in ("quick", "smoke") else None
    if words == ["setup"]:
        prepare(tier)
        return 0
    every = {"smoke": SMOKE, "quick": QUICK}.get(tier) or (
        lamps.SCENARIOS + camera.SCENARIOS + strokes.SCENARIOS + powercuts.SCENARIOS + boots.SCENARIOS + soak.SCENARIOS + instructions.SCENARIOS +
        drivers.SCENARIOS + inputs.SCENARIOS + gpiod2.SCENARIOS + chips.SCENARIOS + pipeline.SCENARIOS + usb.SCENARIOS + usb_speed.SCENARIOS + uvc.SCENARIOS)
    scenarios = [s for s in every if not words or any(w in s.__name__ for w in words)]
    if not scenarios:
        print("rig: no scenario has such a name; there are:", file=sys.stderr)
        print("\n".join("  " + s.__name__ for s in every), file=sys.stderr)
        return 2
    share = prepare(tier)
    if any(s in gpiod2.SCENARIOS for s in scenarios):
        gpiod2.prepare(of_tier("share", "newer"))
    failed = 0
    for scenario in scenarios:
        before = time.monotonic()
        print("  %s ..." % scenario.__name__.replace("_", " "), flush=True)
        wrong = run(scenario, share, tier)
        failed += wrong is not None
        print("    %s (%.0f s)%s" % ("FAILED" if wrong else "passed", time.monotonic() - before,
                                     ": " + wrong if wrong else ""), flush=True)
    for what in NOT_HERE:
        print("  skipped, as no machine here has it: %s" % what)
    print("%d passed, %d failed, %d skipped" % (len(scenarios) - failed, failed, len(NOT_HERE)))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
