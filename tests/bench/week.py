#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""A simulated week, measured: wall time, memory over time, slot timing, bytes.

usage: week.py TTFBOX PLAN [--board B] [--keep-dataset FOLDER]
"""
import argparse
import json
import os
import subprocess
import sys
import tempfile
import time


def rss_kib(pid):
    try:
        with open(f"/proc/{pid}/status", encoding="ascii") as f:
            for line in f:
                if line.startswith("VmRSS:"):
                    return int(line.split()[1])
    except OSError:
        pass
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("ttfbox")
    parser.add_argument("plan")
    parser.add_argument("--board", default="sim")
    parser.add_argument("--calibration")
    parser.add_argument("--keep-dataset")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as tmp:
        dataset = args.keep_dataset or os.path.join(tmp, "week")
        command = [args.ttfbox, "capture", args.plan, "--board", args.board, "-o", dataset, "--json"]
        if args.calibration:
            command += ["--calibration", args.calibration]
        begun = time.monotonic()
        child = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        samples = []
        while child.poll() is None:
            kib = rss_kib(child.pid)
            if kib:
                samples.append(kib)
            time.sleep(0.25)
        out = child.stdout.read()
        wall = time.monotonic() - begun
        if child.returncode:
            sys.exit(f"week: the capture failed with {child.returncode}\n{out}")
        result = json.loads(out.strip().splitlines()[-1])
        size = sum(os.path.getsize(os.path.join(base, name)) for base, _, names in os.walk(dataset) for name in names)
        print(f"slots {result['slots']}, captured {result['captured']}")
        print(f"wall {wall:.1f} s ({wall / max(result['slots'], 1) * 1000:.0f} ms a slot), dataset {size / 1e9:.2f} GB")
        print(f"middle of exposure: p99 {result['error_p99_ns'] / 1e6:.4f} ms, max {result['error_max_ns'] / 1e6:.4f} ms (virtual time)")
        if len(samples) >= 8:
            tenth, last = samples[len(samples) // 10], samples[-2]
            print(f"memory: {tenth / 1024:.1f} MiB at a tenth of the run, {last / 1024:.1f} MiB at its end, "
                  f"peak {max(samples) / 1024:.1f} MiB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
