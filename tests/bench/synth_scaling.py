# SPDX-License-Identifier: Apache-2.0
"""Section scaling: time against each of five sizes, as scaling.csv and scaling.svg."""
import csv
import os

import svg_plot
from measured import load

# What is not varied. 200 frames: long enough that start-up is not what is measured.
BASE = {"frames": 200, "side": 512, "block": 64, "rank": 15, "threads": 2}
SWEEPS = [("frames", "frames", [50, 100, 200, 300, 400, 500]),
          ("side", "side of the output (pixels)", [256, 512, 768, 1024, 1280]),
          ("block", "side of a block (pixels)", [24, 32, 48, 64, 96]),
          ("rank", "rank k", [4, 8, 15, 24, 32, 48, 64]), ("threads", "threads", [1, 2])]
COLUMNS = ["varied", *BASE, "wall_s", "cpu_s", "load_s", "search_s", "render_s", "peak_mb", "load_average"]


def options_of(point):
    return ["--frames", str(point["frames"]), "--size", f"{point['side']}x{point['side']}",
            "--block", f"{point['block']}x{point['block']}", "--rank", str(point["rank"]),
            "--threads", str(point["threads"])]


def row_of(varied, value, runs):
    """Of the least run: what else the machine does only ever adds."""
    best = min(runs, key=lambda done: done["wall"])
    row = dict(BASE, **{varied: value}, varied=varied, wall_s=round(best["wall"], 3), cpu_s=round(best["cpu"], 3),
               peak_mb=round(best["peak_bytes"] / 1e6, 1), load_average=load()[0])
    for stage in ("load", "search", "render"):
        row[stage + "_s"] = round(best["report"]["times_ns"][stage] / 1e9, 3)
    print(f"{varied:8} {value:6} {row['wall_s']:8.2f} {row['cpu_s']:8.2f} {row['load_s']:7.2f} {row['search_s']:9.2f} "
          f"{row['render_s']:9.2f} {row['peak_mb']:8.1f}")
    return row


def measure(bench):
    """Runs of one point are far from each other in time: a busy minute spoils one run of each, not all of one."""
    points = [(varied, value) for varied, _, values in SWEEPS for value in values]
    runs = {point: [] for point in points}
    for _ in range(bench.runs):
        for varied, value in points:
            runs[varied, value].append(bench.quilt_raw(bench.grass(), *options_of(dict(BASE, **{varied: value}))))
    return [row_of(varied, value, runs[varied, value]) for varied, value in points]


def panels(rows):
    for varied, label, _ in SWEEPS:
        own = [row for row in rows if row["varied"] == varied]
        fixed = ", ".join(f"{name} {value}" for name, value in BASE.items() if name != varied)
        yield {"title": f"{varied}: at {fixed}", "x": label, "y": "seconds",
               "series": [{"name": "wall", "points": [(row[varied], row["wall_s"]) for row in own]},
                          {"name": "CPU, user + system", "dashed": True,
                           "points": [(row[varied], row["cpu_s"]) for row in own]}]}


def scaling(bench):
    """Whole processes to the raw sink, from the simulated grass; the least of each point's runs."""
    print(f"{'varied':8} {'value':>6} {'wall s':>8} {'cpu s':>8} {'load s':>7} {'search s':>9} {'render s':>9} {'peak MB':>8}")
    rows = measure(bench)
    base = os.path.join(bench.plots, "scaling")
    with open(base + ".csv", "w", encoding="ascii", newline="") as f:
        writer = csv.DictWriter(f, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    svg_plot.write(base + ".svg", "Quilting: time against size (simulated grass of 256 x 256, whole processes)",
                   list(panels(rows)))
    print(f"written: {base}.csv, {base}.svg")
    return rows
