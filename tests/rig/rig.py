#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""rig.py [quick|smoke] [WORDS]: real kernel drivers in an emulated board; scenarios whose names hold one of WORDS. README.md."""
import contextlib
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
import newer
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
LOCK_S = {None: 1800, "smoke": 300}
ARM64 = Cross(RIG + "/system/tree", RIG + "/arm64")
PROGRAMS = ["ttfbox", "ttfbox-full", "ttfboxd", "ttfbox-lampd", "ttfbox-usbd", "lampd_child", "capture_child", "rig_camera", "rig_usb", "rig_uvc", "strike", "test_lines", "test_sysfs",
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
        if name.startswith(("ttfbox-full", "ttfbox-libcamera")):  # that programs find beside them; built into a folder of their own
            folder, name = "/lib/ttfbox/", name + ".so" if name == "ttfbox-libcamera" else name
        shutil.copy(out + folder + name, share)
    shutil.copy(ROOT + "/firmware/gadget/ttfbox-gadget", share)
    shutil.copy(ROOT + "/boards/sim-small/board.yaml", share + "/sim-small.yaml")


def prepare_system():
    """75, as tree.sh has it: this machine's mirror has no such system."""
    done = subprocess.run(["bash", HERE + "/tree.sh", RIG + "/system"], check=False)
    if done.returncode != 0:
        sys.exit(done.returncode)


@contextlib.contextmanager
def alone(tier):
    """One sets up a tree's rig at a time. 124, as `timeout` has it: another one took too long."""
    wait_s = LOCK_S.get(tier, LOCK_S[None])
    with open(RIG + "/lock", "w") as lock:
        end = time.monotonic() + wait_s
        while True:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
                break
            except BlockingIOError:
                if time.monotonic() > end:
                    print("rig: another run has been setting up this tree for %g s" % wait_s, file=sys.stderr)
                    sys.exit(124)
                time.sleep(min(0.2, wait_s))
        yield


def of_tier(name, tier):
    """A folder that each tier has for itself, as one may run beside another."""
    return RIG + "/" + name + ("-" + tier if tier else "")


def prepare(tier):
    """The system and the programs; where the guest finds them. One at a time, in a tree."""
    os.makedirs(RIG, exist_ok=True)
    share = of_tier("share", tier)
    with alone(tier):
        prepare_system()
        if tier != "smoke":
            subprocess.run(["bash", HERE + "/modules.sh", RIG], check=True)
        build(SMOKE_PROGRAMS if tier == "smoke" else PROGRAMS, share)
        if tier:
            frozen.prepare(RIG + "/system", share, of_tier("frozen", tier))
    return share


def prepare_newer():
    """Of gpiod2's scenarios: None, or what has become of them all, and why. The others are run all the same."""
    try:
        with alone(None):
            gpiod2.prepare(of_tier("share", "newer"))
    except newer.NotHere as e:
        return "skipped", str(e)
    except (SystemExit, RuntimeError, OSError, subprocess.SubprocessError) as e:
        return "FAILED", "the second tree: %s" % e
    return None


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
    except (Exception, SystemExit) as e:  # a scenario that does not understand what it is told; the others are run all the same
        return "%s: %s\n%s" % (type(e).__name__, e, traceback.format_exc(limit=3))


def chosen(every, words):
    """A scenario's whole name is that one; else a word is of all whose names hold it."""
    names = [s.__name__ for s in every]
    return [s for s in every if not words or any(w == s.__name__ or (w not in names and w in s.__name__) for w in words)]


def run_all(scenarios, share, tier):
    """How many passed, failed, were skipped."""
    missing = prepare_newer() if any(s in gpiod2.SCENARIOS for s in scenarios) else None
    count = {"passed": 0, "FAILED": 0, "skipped": 0}
    for scenario in scenarios:
        before = time.monotonic()
        print("  %s ..." % scenario.__name__.replace("_", " "), flush=True)
        if missing and scenario in gpiod2.SCENARIOS:
            outcome, why = missing
        else:
            why = run(scenario, share, tier)
            outcome = "passed" if why is None else "FAILED"
        count[outcome] += 1
        print("    %s (%.0f s)%s" % (outcome, time.monotonic() - before, "" if outcome == "passed" else ": " + why), flush=True)
    return count


def main():
    words = sys.argv[1:]
    tier = words.pop(0) if words and words[0] in ("quick", "smoke") else None
    if words == ["setup"]:
        prepare(tier)
        return 0
    every = {"smoke": SMOKE, "quick": QUICK}.get(tier) or (
        lamps.SCENARIOS + camera.SCENARIOS + strokes.SCENARIOS + powercuts.SCENARIOS + boots.SCENARIOS + soak.SCENARIOS + instructions.SCENARIOS +
        drivers.SCENARIOS + inputs.SCENARIOS + gpiod2.SCENARIOS + chips.SCENARIOS + pipeline.SCENARIOS + usb.SCENARIOS + usb_speed.SCENARIOS + uvc.SCENARIOS)
    scenarios = chosen(every, words)
    if not scenarios:
        print("rig: no scenario has such a name; there are:", file=sys.stderr)
        print("\n".join("  " + s.__name__ for s in every), file=sys.stderr)
        return 2
    count = run_all(scenarios, prepare(tier), tier)
    for what in NOT_HERE:
        print("  skipped, as no machine here has it: %s" % what)
    print("%d passed, %d failed, %d skipped" % (count["passed"], count["FAILED"], count["skipped"] + len(NOT_HERE)))
    return 1 if count["FAILED"] else 0


if __name__ == "__main__":
    sys.exit(main())
