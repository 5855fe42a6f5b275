#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Quilting of single pictures beside G'MIC's syntexturize_matchpatch (package gmic).

Crops 256 x 256 pixels of each picture, lets both programs make 512 x 512 of it
with two threads and their default arguments, five times in turn (ours with five
seeds; G'MIC never makes the same picture twice), and compares the patches of all
results to the crop's. Times are of whole processes. Where the picture is large
enough, another crop of it says what the real thing scores. Figures, not a verdict:
a table of medians with the least and largest, then JSON.

Without pictures: those of TTFBOX_TEST_DATA (unset: ../shared/data).

usage: against_gmic.py TTFBOX BENCH_PATCHES [PICTURE...]
"""
import argparse
import json
import os
import re
import shutil
import statistics
import struct
import subprocess
import sys
import tempfile
import time
import zlib

SIDE, OUT, THREADS, SAMPLES = 256, 512, 2, 1000
SIZES = ["sliced", "sliced_half", "sliced_quarter"]
DATA = ["textures/skimage/grass.png", "textures/skimage/gravel.png", "textures/skimage/brick.png",
        "textures/godot/rock_albedo.jpg", "timelapse/copper/050.png", "timelapse/clay/050.png"]


def skip(why):
    print(f"against_gmic: skipped: {why}")
    sys.exit(0)


def find_pictures(given):
    if given:
        return given
    data = os.environ.get("TTFBOX_TEST_DATA")
    if data is None:
        data = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../../shared/data")
    found = [path for path in (os.path.join(data, name) for name in DATA) if os.path.exists(path)]
    if not found:
        skip(f"no pictures given, and none in {data} (TTFBOX_TEST_DATA)")
    return found


def run(command):
    environment = dict(os.environ, OMP_NUM_THREADS=str(THREADS))
    done = subprocess.run(command, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"against_gmic: {' '.join(command)}: status {done.returncode}\n{done.stdout}")
    return done.stdout


def size_of(picture):
    """G'MIC reads all kinds, and says what it has read."""
    said = re.search(r"\(1 image (\d+)x(\d+)x1x\d+\)", run(["gmic", picture]))
    if not said:
        sys.exit(f"against_gmic: {picture}: gmic finds no single picture there")
    return int(said.group(1)), int(said.group(2))


def crop(picture, x, y, path):
    run(["gmic", picture, "crop", f"{x},{y},{x + SIDE - 1},{y + SIDE - 1}", "to_rgb", "-o", path])


def png_of_raw(raw, path):
    """One frame of 8-bit RGB as a PNG without compression."""
    with open(raw, "rb") as f:
        pixels = f.read()
    if len(pixels) != OUT * OUT * 3:
        sys.exit(f"against_gmic: {raw} has {len(pixels)} bytes")
    rows = b"".join(b"\0" + pixels[y * OUT * 3:(y + 1) * OUT * 3] for y in range(OUT))

    def chunk(name, body):
        return struct.pack(">I", len(body)) + name + body + struct.pack(">I", zlib.crc32(name + body))

    with open(path, "wb") as f:
        f.write(b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", struct.pack(">IIBBBBB", OUT, OUT, 8, 2, 0, 0, 0)) +
                chunk(b"IDAT", zlib.compress(rows, 0)) + chunk(b"IEND", b""))


def timed(command):
    begin = time.monotonic()
    run(command)
    return time.monotonic() - begin


# Default arguments, and repetition avoided over a block's side.
OURS = {"quilt": [], "avoid": ["--avoid", "64"]}


def run_both(args, still, tmp):
    """Times and pictures of each program's runs, in turn, so that what else the machine does hits both."""
    raw = os.path.join(tmp, "quilt.raw")
    times = {name: [] for name in [*OURS, "gmic", "gmic_start"]}
    pictures = {name: [] for name in [*OURS, "gmic"]}
    for i in range(args.runs):
        theirs = os.path.join(tmp, f"gmic-{i}.png")
        for name, options in OURS.items():
            ours = os.path.join(tmp, f"{name}-{i}.png")
            times[name].append(timed([args.ttfbox, "synth", "quilt", still, "--size", f"{OUT}x{OUT}",
                                      "--threads", str(THREADS), "--seed", str(i), "--sink", "raw", "-q",
                                      "-o", raw] + options))
            png_of_raw(raw, ours)
            os.remove(raw)
            pictures[name].append(ours)
        times["gmic"].append(timed(["gmic", still, "syntexturize_matchpatch", f"{OUT},{OUT}",
                                    "-o", theirs]))
        # its interpreter's start, reading and writing: what is not synthesis
        times["gmic_start"].append(timed(["gmic", still, "-o", os.path.join(tmp, "copy.png")]))
        pictures["gmic"].append(theirs)
    return times, pictures


def compare(args, still, paths):
    """Figures of each picture, and their medians."""
    rows = json.loads(run([args.bench_patches, "--threads", str(THREADS), "--samples", str(SAMPLES),
                           still] + paths))["outputs"]
    of_all = {"to_input": [row["to_input"] for row in rows], "from_input": [row["from_input"] for row in rows]}
    for i, size in enumerate(SIZES):
        of_all[size] = [row["sliced"][i] for row in rows]
    return {name: {"median": statistics.median(values), "runs": values} for name, values in of_all.items()}


def measure(args, picture, tmp):
    still, elsewhere = os.path.join(tmp, "still.png"), os.path.join(tmp, "elsewhere.png")
    width, height = size_of(picture)
    if width < SIDE or height < SIDE:
        print(f"against_gmic: {picture}: skipped: smaller than {SIDE} x {SIDE}")
        return None
    crop(picture, 0, 0, still)
    times, pictures = run_both(args, still, tmp)
    if width >= 2 * SIDE and height >= 2 * SIDE:
        crop(picture, width - SIDE, height - SIDE, elsewhere)
        pictures["elsewhere"] = [elsewhere]
    results = []
    for name, paths in pictures.items():
        result = {"by": name, "figures": compare(args, still, paths)}
        if name in times:
            result["seconds"] = {"median": statistics.median(times[name]), "runs": times[name]}
        results.append(result)
        for path in paths if args.keep else []:
            os.makedirs(args.keep, exist_ok=True)
            shutil.copy(path, os.path.join(args.keep, label(picture).replace("/", "-") + "-" +
                                           os.path.basename(path)))
    return {"picture": label(picture), "gmic_start_seconds": statistics.median(times["gmic_start"]),
            "results": results}


def label(picture):
    return "/".join(os.path.splitext(picture)[0].split(os.sep)[-2:])


def print_table(all_figures):
    names = SIZES + ["to_input", "from_input"]
    print(f"{'picture':22} {'by':10} {'seconds':>8} " + " ".join(f"{name:>14}" for name in names))
    for picture in all_figures:
        for result in picture["results"]:
            seconds = f"{result['seconds']['median']:.2f}" if "seconds" in result else ""
            columns = []
            for name in names:
                figure = result["figures"][name]
                spread = f" {min(figure['runs']):.1f}-{max(figure['runs']):.1f}" if "seconds" in result else ""
                columns.append(f"{figure['median']:.1f}{spread}")
            print(f"{picture['picture']:22} {result['by']:10} {seconds:>8} " +
                  " ".join(f"{column:>14}" for column in columns))


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("ttfbox")
    parser.add_argument("bench_patches")
    parser.add_argument("pictures", nargs="*")
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--keep", metavar="FOLDER", help="keep the pictures made there")
    args = parser.parse_intermixed_args()
    if not shutil.which("gmic"):
        skip("gmic is not installed (package gmic)")
    for program in (args.ttfbox, args.bench_patches):
        if not os.access(program, os.X_OK):
            skip(f"{program} is not there: build it first")
    load = os.getloadavg()[0]
    all_figures = []
    for picture in find_pictures(args.pictures):
        with tempfile.TemporaryDirectory(dir=os.environ.get("TMPDIR")) as tmp:
            figures = measure(args, picture, tmp)
            if figures:
                all_figures.append(figures)
    print_table(all_figures)
    if all_figures:
        start = statistics.median(picture["gmic_start_seconds"] for picture in all_figures)
        print(f"of gmic's seconds, {start:.2f} are its start, reading and writing")
    if load > 0.5:
        print(f"load average at the start {load:.1f}: others computed too, and the times are not to be relied on")
    print(json.dumps({"side": SIDE, "out": OUT, "threads": THREADS, "load_average": load, "pictures": all_figures}))


if __name__ == "__main__":
    main()
