#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""image.py BOARD [WORDS]: the board's image, booted; scenarios whose names hold one of WORDS. README.md."""
import os
import subprocess
import sys
import tempfile
import time
import traceback

import booted
import capture
import footprint
import life
import pc
import strokes

SCENARIOS = {"qemu-virt-arm64": capture.SCENARIOS + life.SCENARIOS + strokes.SCENARIOS + footprint.SCENARIOS,
             "pc-uvc": pc.SCENARIOS}


def run(scenario, board):
    """None, or what went wrong."""
    keep = os.environ.get("TTFBOX_IMAGE_KEEP")
    with tempfile.TemporaryDirectory(prefix="ttfbox-image.") as folder:
        image = folder + "/card"
        try:
            scenario(board, image)
            return None
        except AssertionError as e:
            return "%s\n%s" % (e, traceback.format_exc(limit=3))
        except (RuntimeError, OSError, subprocess.SubprocessError) as e:
            return "the machine: %s" % e
        finally:
            if keep and os.path.exists(image):
                os.replace(image, keep)


def main():
    board, words = sys.argv[1], sys.argv[2:]
    every = SCENARIOS.get(board)
    if not every:
        print("image: nothing here boots an image of '%s'; of %s there are machines" % (board, ", ".join(SCENARIOS)), file=sys.stderr)
        return 2
    if not os.path.exists(booted.ROOT + "/build-image/%s.img" % board):
        print("image: there is no image: ./dev image %s" % board, file=sys.stderr)
        return 2
    scenarios = [s for s in every if not words or any(w in s.__name__ for w in words)]
    if not scenarios:
        print("image: no scenario has such a name; there are:\n" + "\n".join("  " + s.__name__ for s in every), file=sys.stderr)
        return 2
    failed = 0
    for scenario in scenarios:
        before = time.monotonic()
        print("  %s ..." % scenario.__name__.replace("_", " "), flush=True)
        wrong = run(scenario, board)
        failed += wrong is not None
        print("    %s (%.0f s)%s" % ("FAILED" if wrong else "passed", time.monotonic() - before,
                                     ": " + wrong if wrong else ""), flush=True)
    print("%d passed, %d failed" % (len(scenarios) - failed, failed))
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
