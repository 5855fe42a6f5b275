# SPDX-License-Identifier: Apache-2.0
"""Sections agreement, coherence and exemplars: what comes out, in figures of its report."""
import csv
import json
import os

from measured import costs, load, run


def agreement(bench):
    """Rank 15 beside the search over all frames, on seeds that nothing was tuned with."""
    rows = []
    print(f"{'input':18} {'queries from':12} {'queries':>8} {'best block':>10} {'jaccard':>8} "
          f"{'jumps':>6} {'best of them':>12} {'extra cost':>10}")
    for name, dataset in bench.inputs():
        for where in ("map", "anywhere"):
            done = run([os.path.join(bench.tests, "bench_agreement"), dataset, "--queries", "2000",
                        "--queries-from", where])
            row = dict(json.loads(done["text"]), dataset=name)
            rows.append(row)
            print(f"{name:18} {where:12} {row['queries']:8} {row['best_block']:10.4f} "
                  f"{row['candidates_jaccard']:8.4f} {row['jumps']:6} {row['jumps_best_block']:12.4f} "
                  f"{row['jumps_extra_cost']:10.5f}")
    return rows


COHERENCE = [("plain", []), ("jitter 4", ["--jitter", "4"]),
             ("jitter 4 rounded", ["--jitter", "4", "--jitter-rounded"]), ("feather 6", ["--feather", "6"]),
             ("jitter 4, feather 6", ["--jitter", "4", "--feather", "6"]),
             ("jitter 4, every 4", ["--jitter", "4", "--jitter-every", "4"]),
             ("jitter 4, every 1", ["--jitter", "4", "--jitter-every", "1"]),
             ("feather 32", ["--overlap", "32x32", "--feather", "32"])]


def figure(value):
    return "-" if value is None else f"{value:.4f}"


def coherence_row(bench, name, what, dataset, options):
    report = bench.quilt(dataset, "--sink", "null", "--figures", *options)["report"]
    over_time = report["temporal_coherence"]
    row = {"input": name, "variant": what, "simulated": report["simulated"],
           "synchrony": report["synchrony"]["correlation"]}
    for key in ("difference_ratio", "difference_ratio_copied", "second_difference_ratio",
                "second_difference_ratio_copied", "difference_ratio_noise_subtracted"):
        row[key] = over_time[key]
    print(f"{name:18} {what:20} {figure(row['difference_ratio_copied']):>9} "
          f"{figure(row['second_difference_ratio_copied']):>9} {figure(row['difference_ratio']):>9} "
          f"{figure(row['second_difference_ratio']):>9} "
          f"{figure(row['difference_ratio_noise_subtracted']):>9} {figure(row['synchrony']):>9}")
    return row


def coherence(bench):
    """Ratios of changes over time: to the pixels copied (1: as they are), to the whole input."""
    rows = []
    print("d, dd: mean differences over time and second ones; copied: to the pixels copied, whole: to the whole input")
    print(f"{'input':18} {'variant':20} {'d copied':>9} {'dd copied':>9} {'d whole':>9} {'dd whole':>9} "
          f"{'d - noise':>9} {'synchrony':>9}")
    for name, dataset in bench.inputs():
        for what, options in COHERENCE:
            rows.append(coherence_row(bench, name, what, dataset, options))
        # the baseline that flickers; of the long capture, its beginning is enough to see it
        few = ["--frames", "12"] if name.startswith("grass") else []
        rows.append(coherence_row(bench, name, "per frame", dataset, ["--per-frame", *few]))
    return rows


def write_colours(bench, rows):
    """The distance at each time, for who wants to set another system's beside it."""
    path = os.path.join(bench.plots, "exemplars.csv")
    with open(path, "w", encoding="ascii", newline="") as f:
        writer = csv.writer(f, lineterminator="\n")
        writer.writerow(["input", "options", "frame", "colour_distance"])
        for row in rows:
            colour = row["colour_distance"]
            writer.writerows([row["input"], row["options"], frame, f"{distance:.3f}"]
                             for frame, distance in zip(colour["frames"], colour["distances"]))
    print(f"written: {path}")


def exemplar(bench, name, dataset, options):
    options = ["--size", "512x512", "--threads", "2", *options]
    report = bench.quilt(dataset, "--sink", "null", "--figures", *options)["report"]
    best = min((bench.quilt_raw(dataset, *options) for _ in range(bench.runs)), key=lambda done: done["cpu"])
    colour, over_time, words = report["colour_distance"], report["temporal_coherence"], " ".join(options[4:])
    largest_at = colour["frames"][colour["distances"].index(max(colour["distances"]))]
    print(f"{name:8} {words or '-':22} {report['frames']:6} {colour['mean']:11.2f} {colour['largest']:8.2f} {largest_at:8} "
          f"{figure(over_time['difference_ratio_copied']):>9} {figure(over_time['difference_ratio']):>9} "
          f"{figure(over_time['second_difference_ratio']):>9} {best['cpu']:7.2f} {best['wall']:7.2f}")
    return {"input": name, "options": words, "frames": report["frames"], "colour_distance": colour,
            "temporal_coherence": over_time, "costs_of_least_cpu": costs(best), "load": load()}


# As they come, and as an uneven light asks for.
EXEMPLAR_OPTIONS = [[], ["--flatten", "--avoid", "64"]]


def exemplars(bench):
    """The inputs that a learnt system is shown with: how near the colours stay, and at what cost."""
    rows = []
    print("256 x 256 to 512 x 512, all frames; costs are of the raw sink without figures")
    print(f"{'input':8} {'options':22} {'frames':>6} {'colour mean':>11} {'largest':>8} {'at frame':>8} {'d copied':>9} {'d whole':>9} "
          f"{'dd whole':>9} {'cpu s':>7} {'wall s':>7}")
    for name in ("copper", "clay"):
        dataset = bench.real(name)
        if not dataset:
            continue
        rows += [exemplar(bench, name, dataset, options) for options in EXEMPLAR_OPTIONS]
    if rows:
        write_colours(bench, rows)
    return rows
