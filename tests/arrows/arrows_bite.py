#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Shows that arrows.py bites: plants one wrong line at a time in a copy of the
tree and expects it to be found, by name; and that CMake refuses a wrong link.

usage: arrows_bite.py ROOT
"""
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

WRONG = [
    ("base/err.c", '#include "ttf/hal/clock.h"', "base includes ttf/hal/clock.h"),
    ("hal/sim/planted.c", '#include "ttf/dataset/pixbuf.h"', "hal_sim includes ttf/dataset/pixbuf.h"),
    ("hal/planted.c", '#include "ttf/dataset/pixbuf.h"', "hal includes ttf/dataset/pixbuf.h"),
    ("hal/planted.c", '#include "ttf/hal/sim.h"', "hal includes ttf/hal/sim.h"),
    ("dataset/planted.c", '#include "ttf/hal/camera.h"', "dataset includes ttf/hal/camera.h"),
    ("capture/planted.c", '#include "ttf/synth/quilt.h"', "capture includes ttf/synth/quilt.h"),
    ("synth/planted.c", '#include "ttf/capture/plan.h"', "synth includes ttf/capture/plan.h"),
    ("synth/planted.c", '#include "../dataset/planted_private.h"', "includes the private file dataset/planted_private.h"),
    ("capture/planted.c", "void f(void) { clock_gettime(0, 0); }", "reads or waits for time by clock_gettime"),
    ("hal/libcamera/adapter.cpp", "void f() { (void)std::chrono::steady_clock::now(); }", "reads or waits for time by steady_clock::now"),
]


def main():
    root = Path(sys.argv[1])
    bad = 0
    with tempfile.TemporaryDirectory() as tmp:
        copy = Path(tmp) / "tree"
        for folder in ("base", "hal", "dataset", "capture", "synth", "firmware", "cmake"):
            shutil.copytree(root / folder, copy / folder)
        (copy / "dataset/planted_private.h").write_text("\n")
        checker = root / "tests/arrows/arrows.py"
        for path, line, expected in WRONG:
            file = copy / path
            before = file.read_text() if file.exists() else None
            file.write_text((before or "") + "\n" + line + "\n")
            run = subprocess.run([sys.executable, checker, copy], capture_output=True, text=True)
            if run.returncode == 0 or expected not in run.stdout:
                print(f"not found: {path}: {line}\n{run.stdout}")
                bad += 1
            if before is None:
                file.unlink()
            else:
                file.write_text(before)
        script = Path(tmp) / "CMakeLists.txt"
        script.write_text("cmake_minimum_required(VERSION 3.25)\nproject(x LANGUAGES NONE)\n"
                          f"include({root}/cmake/Rooms.cmake)\nttf_check_arrows(synth base capture)\n")
        run = subprocess.run(["cmake", "-G", "Ninja", "-S", tmp, "-B", tmp + "/b"], capture_output=True, text=True)
        if run.returncode == 0 or "may not use room 'capture'" not in run.stderr.replace("\n", " "):
            print("CMake let synth use capture\n" + run.stderr)
            bad += 1
    print(f"{len(WRONG) + 1} wrong arrows planted, {bad} not found")
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
