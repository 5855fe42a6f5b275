#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Measurements of synthesis: figures and ratios of one run, never pass or fail.

Sections: agreement, coherence, speed, gmic, memory, scaling, exemplars; without
one, all of them. Real sequences are those of TTFBOX_TEST_DATA (unset:
../shared/data); where they are absent, what needs them is skipped, and says so.
To be run from the project's root, as ./dev bench synth does.

usage: synth.py TTFBOX TESTS [SECTION...] [--json FILE] [--plots FOLDER]
"""
import argparse
import json
import os
import signal
import sys

from measured import Bench, load
from synth_quality import agreement, coherence, exemplars
from synth_scaling import scaling
from synth_speed import gmic, memory, speed

SECTIONS = {"agreement": agreement, "coherence": coherence, "speed": speed, "gmic": gmic, "memory": memory,
            "scaling": scaling, "exemplars": exemplars}


def write_json(path, results):
    """What was measured before and not now stays: sections may be run one by one."""
    known = {}
    if os.path.exists(path):
        with open(path, encoding="utf-8") as f:
            known = json.load(f)
    with open(path, "w", encoding="utf-8") as f:
        json.dump(dict(known, **results), f, indent=1)
        f.write("\n")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ttfbox")
    parser.add_argument("tests", help="the folder of bench_agreement and bench_patches")
    parser.add_argument("sections", nargs="*", metavar="SECTION")
    parser.add_argument("--json", metavar="FILE", default="build/bench-synth.json")
    parser.add_argument("--plots", metavar="FOLDER", default="build", help="where scaling.csv, scaling.svg and exemplars.csv go")
    parser.add_argument("--runs", type=int, default=5, help="of what is timed (default: 5)")
    parser.add_argument("--grass", metavar="DATASET", help="a capture of the plan made before (default: make it)")
    args = parser.parse_intermixed_args()
    unknown = [name for name in args.sections if name not in SECTIONS]
    if unknown:
        parser.error(f"there is no section '{unknown[0]}': {', '.join(SECTIONS)}")
    # what is in memory is gigabytes: it goes away also where the run is ended from outside
    signal.signal(signal.SIGTERM, lambda *_: sys.exit("bench synth: ended"))
    bench = Bench(args.ttfbox, args.tests, args.plots, args.runs, args.grass)
    try:
        for name in args.sections or SECTIONS:
            before = load()
            print(f"== {name} (load average {before[0]}, {os.cpu_count()} processors)", flush=True)
            figures = SECTIONS[name](bench)
            write_json(args.json, {name: {"load_before": before, "load_after": load(), "figures": figures}})
    finally:
        bench.close()
    print(f"written: {args.json}")


if __name__ == "__main__":
    main()
