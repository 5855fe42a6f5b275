#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Wake-up error of a real capture loop beside cyclictest, in the same minutes.

Runs `ttfbox capture` on the simulated devices with the machine's own clock and,
at the same time and under the same scheduling policy (SCHED_OTHER), cyclictest
from rt-tests at the same interval. Prints p50, p99 and max of both and their
difference. Figures, not a verdict.

usage: schedule.py TTFBOX [--slots N] [--interval-ms MS]
"""
import argparse
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

PLAN = """title: wake-up error
interval: {interval}ms
count: {slots}
shots:
  - exposure: 10ms
keep: raw
"""


def percentile_of_histogram(text, share):
    """cyclictest -h prints `latency_us count` lines."""
    counts = {}
    for line in text.splitlines():
        m = re.match(r"^(\d+)\s+(\d+)\s*$", line)
        if m:
            counts[int(m.group(1))] = int(m.group(2))
    overflow = re.search(r"# Histogram Overflows: (\d+)", text)
    total = sum(counts.values()) + (int(overflow.group(1)) if overflow else 0)
    seen = 0
    for us in sorted(counts):
        seen += counts[us]
        if seen >= share * total:
            return us / 1000
    return float("inf")


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("ttfbox")
    parser.add_argument("--slots", type=int, default=1000)
    parser.add_argument("--interval-ms", type=int, default=300)
    parser.add_argument("--board", required=True, help="a simulated board on the machine's own clock")
    args = parser.parse_args()
    if not shutil.which("cyclictest"):
        sys.exit("schedule: cyclictest is not installed (package rt-tests)")
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as tmp:
        plan = os.path.join(tmp, "plan.yaml")
        with open(plan, "w", encoding="utf-8") as f:
            f.write(PLAN.format(interval=args.interval_ms, slots=args.slots))
        capture = subprocess.Popen([args.ttfbox, "capture", plan, "--board", args.board, "-o",
                                    os.path.join(tmp, "D"), "--json"], stdout=subprocess.PIPE, text=True)
        cyclic = subprocess.run(["cyclictest", "-q", "--policy=other", "-t1", "-i", str(args.interval_ms * 1000),
                                 "-l", str(args.slots), "-h", "100000"], capture_output=True, text=True, check=False)
        out, _ = capture.communicate()
        if capture.returncode:
            sys.exit(f"schedule: the capture failed with {capture.returncode}")
        ours = json.loads(out.strip().splitlines()[-1])
        print(f"slots {ours['slots']}, captured {ours['captured']}, interval {args.interval_ms} ms, SCHED_OTHER")
        p99, worst = ours["wakeup_p99_ns"] / 1e6, ours["wakeup_max_ns"] / 1e6
        c99 = percentile_of_histogram(cyclic.stdout, 0.99)
        cmax = re.search(r"# Max Latencies: 0*(\d+)", cyclic.stdout)
        print(f"capture loop: p99 {p99:.3f} ms, max {worst:.3f} ms")
        print(f"cyclictest:   p99 {c99:.3f} ms, max {int(cmax.group(1)) / 1000 if cmax else float('nan'):.3f} ms")
        print(f"difference of p99: {p99 - c99:+.3f} ms (wanted: at most +1 ms)")
        return 0


if __name__ == "__main__":
    sys.exit(main())
