# SPDX-License-Identifier: Apache-2.0
"""Sections speed, gmic and memory: whole processes, beside others' where there are such."""
import hashlib
import json
import os
import shutil
import statistics
import sys

from measured import costs, load, run, spread

SIDE = 1024
FRAMES = 500


def distinct_frames(path, side):
    """(frames, distinct ones): a program that writes one frame over and over would be fast."""
    frame, seen, n = side * side * 3, set(), 0
    with open(path, "rb") as f:
        while piece := f.read(frame):
            seen.add(hashlib.sha256(piece).digest())
            n += 1
    return n, len(seen)


def one_pair(bench, options):
    """Ours, then a plain copy of what it wrote: neighbours in time, so what else the machine does hits both."""
    bench.drop("out.raw")
    bench.warm(2 * SIDE * SIDE * 3 * FRAMES)
    ours = bench.quilt_raw(bench.grass(), *options, keep=True)
    bench.warm(2 * SIDE * SIDE * 3 * FRAMES)
    copy = run(["cp", "--reflink=never", "--sparse=never", bench.path("out.raw"), bench.path("copy.raw")])
    bench.drop("copy.raw")
    return ours, copy


def print_stages(times):
    """Rows are written while others are searched for, on the other thread: the parts are more than the whole."""
    print("stages of one more run: " + ", ".join(f"{name} {ns / 1e9:.2f} s" for name, ns in times.items()) +
          " (search, cut, render, sink are sums over threads, side by side; the sink's are within render's)")


def to_dataset(bench, options):
    """The full sink: 16-bit TIFFs with their hashes, figures, a sealed dataset."""
    bench.drop("out")
    full = bench.quilt(bench.grass(), "-o", bench.path("out"), *options)
    bench.drop("out")
    print(f"16-bit dataset with figures and hashes: {full['wall']:.2f} s wall, {full['cpu']:.2f} s CPU, "
          f"peak {full['peak_bytes'] / 1e6:.1f} MB")
    return {"costs": costs(full), "times_ns": full["report"]["times_ns"]}


def speed(bench):
    """500 frames of 256 x 256 to 1024 x 1024, all frames written, beside cp of the same bytes."""
    options = ["--size", f"{SIDE}x{SIDE}", "--threads", "2"]
    at_begin, pairs = load(), []
    one_pair(bench, options)  # warm: programs and input have been read before
    for _ in range(bench.runs):
        pairs.append(one_pair(bench, options))
        ours, copy = pairs[-1]
        print(f"ours {ours['wall']:.2f} s (user {ours['user']:.2f}, sys {ours['sys']:.2f}), cp {copy['wall']:.2f} s "
              f"(sys {copy['sys']:.2f}): {ours['wall'] / copy['wall']:.2f}")
    n, distinct = distinct_frames(bench.path("out.raw"), SIDE)
    bench.drop("out.raw")
    wall = spread([ours["wall"] / copy["wall"] for ours, copy in pairs])
    cpu = spread([ours["cpu"] / copy["cpu"] for ours, copy in pairs])
    peaks = [max(done["peak_bytes"] for done in dones) for dones in zip(*pairs)]
    print(f"wall, ours / cp: median {wall['median']:.2f} ({wall['least']:.2f}-{wall['largest']:.2f}); "
          f"CPU: median {cpu['median']:.2f}")
    print(f"{n} frames written, {distinct} distinct; peak {peaks[0] / 1e6:.1f} MB, of cp at most {peaks[1] / 1e6:.1f} MB")
    times = bench.quilt_raw(bench.grass(), *options)["report"]["times_ns"]
    print_stages(times)
    return {"frames": n, "distinct": distinct, "in_memory": bench.in_memory, "ratio_wall": wall, "ratio_cpu": cpu,
            "pairs": [{"ours": costs(ours), "cp": costs(copy)} for ours, copy in pairs], "times_ns": times,
            "dataset": to_dataset(bench, options), "load_at_begin": at_begin}


def stills(bench):
    """The single pictures of against_gmic.py, which prints its own table before its JSON."""
    script = os.path.join(os.path.dirname(os.path.abspath(__file__)), "against_gmic.py")
    done = run([sys.executable, script, bench.ttfbox, os.path.join(bench.tests, "bench_patches")],
               {"TTFBOX_TEST_DATA": bench.data})
    lines = done["text"].strip().splitlines()
    has_json = lines[-1].startswith("{")
    print("\n".join(lines[:-1] if has_json else lines))
    return json.loads(lines[-1]) if has_json else None


def gmic(bench):
    """100 frames to 512 x 512 beside one frame of another program, and stills beside stills."""
    if not shutil.which("gmic"):
        print("skipped: gmic is not installed (package gmic)")
        return None
    still, pairs = bench.pictures_of_grass()[50], []
    for _ in range(bench.runs):
        ours = bench.quilt_raw(bench.grass(), "--frames", "100", "--size", "512x512", "--threads", "2")
        theirs = run(["gmic", still, "syntexturize_matchpatch", "512,512", "-o", bench.path("gmic.png")],
                     {"OMP_NUM_THREADS": "2"})
        pairs.append((ours, theirs))
    ratio = spread([ours["wall"] / theirs["wall"] for ours, theirs in pairs])
    print(f"256 x 256 x 100 to 512 x 512 x 100: {statistics.median(o['wall'] for o, _ in pairs):.2f} s; "
          f"one frame by G'MIC: {statistics.median(t['wall'] for _, t in pairs):.2f} s; "
          f"ratio: median {ratio['median']:.2f} ({ratio['least']:.2f}-{ratio['largest']:.2f})")
    return {"ratio_wall": ratio, "pairs": [{"ours": costs(o), "gmic": costs(t)} for o, t in pairs],
            "stills": stills(bench)}


def ten_times(bench):
    """The capture's pictures, ten times over: 5,000 frames of as many different names."""
    os.makedirs(bench.path("links"))
    pictures = bench.pictures_of_grass()
    links = []
    for i in range(10 * len(pictures)):
        links.append(bench.path(f"links/{i:05}.png"))
        os.symlink(pictures[i % len(pictures)], links[-1])
    return bench.imported("long", links)


def memory_by(bench, datasets, side, sink):
    """Peaks of a short and of a long input, into one sink."""
    options = ["--size", f"{side}x{side}", "--threads", "2", "--sink", sink]
    if sink == "raw":
        options += ["-o", bench.path("out.raw")]
    peaks = []
    for dataset in datasets:
        done = bench.quilt(dataset, *options)
        bench.drop("out.raw")
        peaks.append({"frames": done["report"]["frames"], "costs": costs(done),
                      "memory_bytes": done["report"]["memory_bytes"]})
        print(f"{peaks[-1]['frames']} frames: peak {done['peak_bytes'] / 1e6:.1f} MB (matching "
              f"{done['report']['memory_bytes']['matching'] / 1e6:.1f} MB), {done['wall']:.1f} s wall, "
              f"{done['cpu']:.1f} s CPU")
    ratio = peaks[1]["costs"]["peak_bytes"] / peaks[0]["costs"]["peak_bytes"]
    print(f"ratio of peaks, sink {sink}: {ratio:.3f}")
    return {"sink": sink, "runs": peaks, "ratio": ratio}


def memory(bench):
    """Peak resident memory of a short and of a ten times longer input: it should not grow. (5,000 large frames are too many for a file in memory.)"""
    datasets = [bench.imported("short", bench.pictures_of_grass()), ten_times(bench)]
    results = [memory_by(bench, datasets, SIDE, "null"), memory_by(bench, datasets, 256, "raw")]
    for name in ("long", "short", "links"):
        bench.drop(name)
    return results
